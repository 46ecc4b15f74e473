//! The gallery of the documentation: a list of pictures with the commands that draw them.
//!
//! The list is `docs/gallery.toml`. `cargo xtask gallery` draws it with the built program; a test draws it again, and compares.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::thread;
use std::{fs, io};

use serde::Deserialize;

use crate::workspace_root;

/// One picture.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Entry {
    /// The heading of this and the next ones; `None` for that of the one before.
    pub section: Option<String>,
    /// Its title.
    pub title: String,
    /// One sentence or two.
    pub caption: String,
    /// Small files that the commands read, by their names.
    #[serde(default)]
    pub files: BTreeMap<String, String>,
    /// Commands before that of the picture, such as those that draw what is compared.
    #[serde(default)]
    pub prepare: Vec<String>,
    /// What a user types: `tercio` with its arguments, in single quotes where a shell needs them.
    pub command: String,
    /// Its exit code, if that says more than success.
    #[serde(default)]
    pub exit: i32,
    /// The pictures that are shown, if not the one after `-o`.
    #[serde(default)]
    pub shows: Vec<String>,
}

#[derive(Deserialize)]
struct List {
    picture: Vec<Entry>,
}

impl Entry {
    /// The arguments, without `tercio`.
    ///
    /// # Panics
    /// If the command begins with another word, or a quote is not closed.
    pub fn arguments(&self) -> Vec<String> {
        words_of(&self.command)
    }

    /// The names of the pictures that it draws.
    ///
    /// # Panics
    /// If it does not say which, and there is no `-o`.
    pub fn pictures(&self) -> Vec<String> {
        if !self.shows.is_empty() {
            return self.shows.clone();
        }
        let arguments = self.arguments();
        let at = arguments.iter().position(|argument| argument == "-o");
        let file = at.and_then(|at| arguments.get(at + 1));
        vec![file.unwrap_or_else(|| panic!("{}: where is -o?", self.command)).clone()]
    }

    /// Draws the pictures into a folder with the program, in a folder of their own beside other files.
    fn draw(&self, program: &Path, folder: &Path) -> io::Result<()> {
        let own = tempfile::tempdir()?;
        for (name, text) in &self.files {
            fs::write(own.path().join(name), text)?;
        }
        let commands = self.prepare.iter().map(|line| (line, 0)).chain([(&self.command, self.exit)]);
        for (line, exit) in commands {
            let mut command = Command::new(program);
            command.args(words_of(line)).arg("--quiet").current_dir(own.path()).stdin(Stdio::null());
            // Defaults of this machine change no picture.
            command.env("TERCIO_CONFIG", "none");
            let output = command.output()?;
            if output.status.code() != Some(exit) || !output.stderr.is_empty() {
                let words = String::from_utf8_lossy(&output.stderr).into_owned();
                return Err(io::Error::other(format!("{line}: {}: {words}", output.status)));
            }
        }
        for name in self.pictures() {
            let copy = fs::copy(own.path().join(&name), folder.join(&name));
            copy.map_err(|error| io::Error::other(format!("{}: {name}: {error}", self.command)))?;
        }
        Ok(())
    }
}

/// The arguments of a command, without `tercio`.
///
/// # Panics
/// If it begins with another word, or a quote is not closed.
fn words_of(line: &str) -> Vec<String> {
    let (mut words, mut word, mut is_quoted) = (Vec::new(), None::<String>, false);
    for c in line.chars() {
        match c {
            '\'' => {
                is_quoted = !is_quoted;
                word.get_or_insert_default();
            }
            ' ' if !is_quoted => words.extend(word.take()),
            c => word.get_or_insert_default().push(c),
        }
    }
    assert!(!is_quoted, "{line}: a quote that is not closed");
    words.extend(word);
    assert_eq!(words.first().map(String::as_str), Some("tercio"), "{line}");
    words.remove(0);
    words
}

/// The list, in the order of the page.
///
/// # Panics
/// If it cannot be read, or two entries draw the same file.
pub fn entries() -> Vec<Entry> {
    let path = workspace_root().join("docs/gallery.toml");
    let text = fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let list: List = toml::from_str(&text).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let mut files: Vec<String> = list.picture.iter().flat_map(Entry::pictures).collect();
    files.sort();
    files.windows(2).for_each(|pair| assert_ne!(pair[0], pair[1], "two entries draw the same file"));
    list.picture
}

/// Where the pictures are.
pub fn folder() -> PathBuf {
    workspace_root().join("docs/images/gallery")
}

/// Draws all pictures into a folder with the program, two at a time.
///
/// # Errors
/// The first command that fails, with what it prints.
pub fn draw(entries: &[Entry], program: &Path, folder: &Path) -> io::Result<()> {
    let draw = |entry: &Entry| entry.draw(program, folder);
    thread::scope(|scope| {
        let half = |first: usize| move || entries.iter().skip(first).step_by(2).try_for_each(draw);
        let other = scope.spawn(half(1));
        half(0)()?;
        other.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    })
}

/// Names of the files in which two folders differ, or that only one of them has.
///
/// # Errors
/// A folder that cannot be read.
pub fn changed(drawn: &Path, kept: &Path) -> io::Result<Vec<String>> {
    let mut names = Vec::new();
    for folder in [drawn, kept] {
        for entry in fs::read_dir(folder)? {
            names.push(entry?.file_name().to_string_lossy().into_owned());
        }
    }
    names.sort();
    names.dedup();
    names.retain(|name| match (fs::read(drawn.join(name)), fs::read(kept.join(name))) {
        (Ok(a), Ok(b)) => a != b,
        _ => true,
    });
    Ok(names)
}

/// Puts the pictures that were drawn in place of those that are kept: `names` are those in which the folders differ. Returns the ones
/// that were there, and are drawn otherwise now.
///
/// # Errors
/// A file that cannot be replaced.
pub fn replace(names: &[String], drawn: &Path, kept: &Path) -> io::Result<Vec<String>> {
    let mut otherwise = Vec::new();
    for name in names {
        let (new, old) = (drawn.join(name), kept.join(name));
        match (new.is_file(), old.is_file()) {
            (true, was_there) => {
                fs::copy(&new, &old)?;
                otherwise.extend(was_there.then(|| name.clone()));
            }
            (false, true) => fs::remove_file(&old)?,
            (false, false) => {}
        }
    }
    Ok(otherwise)
}

/// The page.
pub fn page(entries: &[Entry]) -> String {
    let mut page = String::from(
        "# Gallery\n\n\
         What tercio draws, with the commands that drew it. The models are built in or written here, so that every command works\n\
         as it is written. `cargo xtask gallery` makes this page from [gallery.toml](gallery.toml); every machine draws the same bytes.\n",
    );
    for entry in entries {
        if let Some(section) = &entry.section {
            let _ = write!(page, "\n## {section}\n");
        }
        let Entry { title, caption, files, prepare, command, .. } = entry;
        let _ = write!(page, "\n### {title}\n\n{caption}\n");
        for file in entry.pictures() {
            let _ = write!(page, "\n![{title}](images/gallery/{file})\n");
        }
        for (name, text) in files {
            let _ = write!(page, "\n`{name}`:\n\n```\n{}\n```\n", text.trim_end());
        }
        let commands: Vec<&str> = prepare.iter().chain([command]).map(String::as_str).collect();
        let _ = write!(page, "\n```sh\n{}\n```\n", commands.join("\n"));
    }
    page
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_are_split_as_a_shell_does() {
        let entry = entry("tercio render x --title 'two words' --clip-cap='#f00'  -o a.png ''");
        let expected = ["render", "x", "--title", "two words", "--clip-cap=#f00", "-o", "a.png", ""];
        assert_eq!(entry.arguments(), expected);
        assert_eq!(entry.pictures(), ["a.png"]);
    }

    fn entry(command: &str) -> Entry {
        let text = format!("title = 'a'\ncaption = 'b'\ncommand = \"{command}\"\n");
        toml::from_str(&text).unwrap()
    }

    #[test]
    fn a_page_has_the_files_and_all_commands_of_a_picture() {
        let mut entry = entry("tercio compare a.png b.png --diff d.png");
        entry.files = [("a.csv".to_owned(), "1,2\n".to_owned())].into();
        entry.prepare = vec!["tercio render c -o a.png".into()];
        entry.shows = vec!["d.png".into()];
        let page = page(&[entry]);
        let end = "### a\n\nb\n\n![a](images/gallery/d.png)\n\n`a.csv`:\n\n```\n1,2\n```\n\n\
                   ```sh\ntercio render c -o a.png\ntercio compare a.png b.png --diff d.png\n```\n";
        assert!(page.ends_with(end), "{page}");
    }

    #[test]
    fn pictures_that_were_there_and_differ_are_named() {
        let (drawn, kept) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let write = |folder: &Path, name: &str, text: &str| fs::write(folder.join(name), text).unwrap();
        for (name, old, new) in [("same", "1", "1"), ("other", "1", "2"), ("gone", "1", ""), ("new", "", "1")]
        {
            [(kept.path(), old), (drawn.path(), new)]
                .into_iter()
                .filter(|(_, text)| !text.is_empty())
                .for_each(|(folder, text)| write(folder, name, text));
        }
        let names = changed(drawn.path(), kept.path()).unwrap();
        assert_eq!(names, ["gone", "new", "other"]);
        assert_eq!(replace(&names, drawn.path(), kept.path()).unwrap(), ["other"]);
        assert!(changed(drawn.path(), kept.path()).unwrap().is_empty());
    }

    #[test]
    fn the_page_is_that_of_the_list() {
        let path = workspace_root().join("docs/gallery.md");
        let page_of_list = page(&entries());
        let kept = fs::read_to_string(&path).unwrap();
        assert!(
            kept == page_of_list,
            "docs/gallery.md is not that of docs/gallery.toml: cargo xtask gallery"
        );
    }
}
