//! The gallery of the documentation: a list of pictures with the commands that draw them.
//!
//! The list is `docs/gallery.toml`. `cargo xtask gallery` draws it with the built program; a test draws it again, and compares.

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
    /// What a user types: `tercio` with its arguments, in single quotes where a shell needs them.
    pub command: String,
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
        let (mut words, mut word, mut is_quoted) = (Vec::new(), None::<String>, false);
        for c in self.command.chars() {
            match c {
                '\'' => {
                    is_quoted = !is_quoted;
                    word.get_or_insert_default();
                }
                ' ' if !is_quoted => words.extend(word.take()),
                c => word.get_or_insert_default().push(c),
            }
        }
        assert!(!is_quoted, "{}: a quote that is not closed", self.command);
        words.extend(word);
        assert_eq!(words.first().map(String::as_str), Some("tercio"), "{}", self.command);
        words.remove(0);
        words
    }

    /// The name of the file that it draws.
    ///
    /// # Panics
    /// If there is no `-o`.
    pub fn file(&self) -> String {
        let arguments = self.arguments();
        let at = arguments.iter().position(|argument| argument == "-o");
        let file = at.and_then(|at| arguments.get(at + 1));
        file.unwrap_or_else(|| panic!("{}: where is -o?", self.command)).clone()
    }
}

/// The list, in the order of the page.
///
/// # Panics
/// If it cannot be read, or two entries draw the same file.
pub fn entries() -> Vec<Entry> {
    let path = workspace_root().join("docs/gallery.toml");
    let text = fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let list: List = toml::from_str(&text).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let mut files: Vec<String> = list.picture.iter().map(Entry::file).collect();
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
    let draw = |entry: &Entry| -> io::Result<()> {
        let mut command = Command::new(program);
        command.args(entry.arguments()).arg("--quiet").current_dir(folder).stdin(Stdio::null());
        // Defaults of this machine change no picture.
        command.env("TERCIO_CONFIG", "none");
        let output = command.output()?;
        if output.status.success() && output.stderr.is_empty() {
            return Ok(());
        }
        let words = String::from_utf8_lossy(&output.stderr).into_owned();
        Err(io::Error::other(format!("{}: {}: {words}", entry.command, output.status)))
    };
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

/// The page.
pub fn page(entries: &[Entry]) -> String {
    let mut page = String::from(
        "# Gallery\n\n\
         What tercio draws, with the commands that drew it. The models are built in, so that every command works as it is\n\
         written. `cargo xtask gallery` makes this page from [gallery.toml](gallery.toml); every machine draws the same bytes.\n",
    );
    for entry in entries {
        if let Some(section) = &entry.section {
            let _ = write!(page, "\n## {section}\n");
        }
        let Entry { title, caption, command, .. } = entry;
        let file = entry.file();
        let _ = write!(
            page,
            "\n### {title}\n\n{caption}\n\n![{title}](images/gallery/{file})\n\n```sh\n{command}\n```\n"
        );
    }
    page
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_are_split_as_a_shell_does() {
        let entry = Entry {
            section: None,
            title: "a".into(),
            caption: "b".into(),
            command: "tercio render x --title 'two words' --clip-cap='#f00'  -o a.png ''".into(),
        };
        let expected = ["render", "x", "--title", "two words", "--clip-cap=#f00", "-o", "a.png", ""];
        assert_eq!(entry.arguments(), expected);
        assert_eq!(entry.file(), "a.png");
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
