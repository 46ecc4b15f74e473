//! `cargo xtask bless`: golden pictures, shown before they are accepted.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, bail};
use tercio_testkit::golden::{BLESS_VARIABLE, describe, golden_folder};
use tercio_testkit::picture::Picture;

use crate::process;

/// Arguments of `cargo xtask bless`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Accept the new pictures: those named TOPIC or TOPIC/NAME, or all if no name is given
    #[arg(long, value_name = "NAME", num_args = 0..)]
    accept: Option<Vec<String>>,
}

/// Draws the golden pictures again, reports every change, and replaces those that are accepted.
///
/// # Errors
/// A test fails, a picture cannot be read or written, or an accepted name did not change.
pub fn run(arguments: &Arguments) -> Result<()> {
    let drawn = process::target_folder()?.join("golden-drawn");
    if drawn.exists() {
        fs::remove_dir_all(&drawn)?;
    }
    fs::create_dir_all(&drawn)?;
    process::run(process::cargo().env(BLESS_VARIABLE, &drawn).args([
        "test",
        "--quiet",
        "--workspace",
        "--tests",
        "--no-fail-fast",
        "golden",
    ]))?;

    let folders = Folders {
        golden: golden_folder(),
        differences: process::target_folder()?.join("golden-diff"),
        drawn,
    };
    let changed = folders.report()?;
    if let Some(names) = &arguments.accept {
        for name in accepted(&changed, names)? {
            folders.take(name)?;
            println!("taken: {name}");
        }
    } else if !changed.is_empty() {
        println!("look at them, then: cargo xtask bless --accept [NAME..]");
    }
    Ok(())
}

struct Folders {
    golden: PathBuf,
    drawn: PathBuf,
    differences: PathBuf,
}

impl Folders {
    /// Prints what is new, changed or no longer drawn; returns what is new or changed.
    fn report(&self) -> Result<BTreeSet<String>> {
        let golden = names_in(&self.golden)?;
        let drawn = names_in(&self.drawn)?;
        let mut changed = BTreeSet::new();
        for name in &drawn {
            let actual_path = file(&self.drawn, name);
            let actual = read(&actual_path)?;
            if !golden.contains(name) {
                println!("new: {name}: {}x{}: {}", actual.width, actual.height, actual_path.display());
            } else {
                let expected = read(&file(&self.golden, name))?;
                if expected == actual {
                    continue;
                }
                let shown = file(&self.differences, &format!("{name}.diff"));
                expected.side_by_side(&actual).write(&shown)?;
                println!("changed: {name}: {}: {}", describe(&expected, &actual), shown.display());
            }
            changed.insert(name.clone());
        }
        for name in golden.difference(&drawn) {
            println!("no test draws it any more: {name}: {}", file(&self.golden, name).display());
        }
        println!("{} golden pictures, {} new or changed", drawn.len(), changed.len());
        Ok(changed)
    }

    fn take(&self, name: &str) -> Result<()> {
        let to = file(&self.golden, name);
        fs::create_dir_all(to.parent().context("a golden picture has a folder")?)?;
        fs::copy(file(&self.drawn, name), &to).with_context(|| format!("writing {}", to.display()))?;
        Ok(())
    }
}

/// The changed pictures selected by the names on the command line.
fn accepted<'a>(changed: &'a BTreeSet<String>, names: &[String]) -> Result<BTreeSet<&'a str>> {
    if names.is_empty() {
        return Ok(changed.iter().map(String::as_str).collect());
    }
    let mut taken = BTreeSet::new();
    for name in names {
        let means = |picture: &&str| *picture == name || picture.split('/').next() == Some(name);
        let matching: Vec<_> = changed.iter().map(String::as_str).filter(means).collect();
        if matching.is_empty() {
            bail!("no new or changed picture is named {name}; nothing was taken");
        }
        taken.extend(matching);
    }
    Ok(taken)
}

/// `TOPIC/NAME` of every picture in a folder of topics.
fn names_in(folder: &Path) -> Result<BTreeSet<String>> {
    let mut names = BTreeSet::new();
    if !folder.is_dir() {
        return Ok(names);
    }
    for topic in fs::read_dir(folder)? {
        let topic = topic?;
        if !topic.file_type()?.is_dir() {
            continue;
        }
        for picture in fs::read_dir(topic.path())? {
            let picture = PathBuf::from(picture?.file_name());
            if let (Some("png"), Some(stem)) =
                (picture.extension().and_then(|e| e.to_str()), picture.file_stem())
            {
                names.insert(format!("{}/{}", topic.file_name().display(), stem.display()));
            }
        }
    }
    Ok(names)
}

fn file(folder: &Path, name: &str) -> PathBuf {
    folder.join(format!("{name}.png"))
}

fn read(path: &Path) -> Result<Picture> {
    Picture::read(path).with_context(|| format!("reading {}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folders(top: &Path) -> Folders {
        Folders { golden: top.join("golden"), drawn: top.join("drawn"), differences: top.join("differences") }
    }

    fn write(folder: &Path, name: &str, value: u8) {
        Picture::new(2, 2, vec![value; 16]).write(file(folder, name)).unwrap();
    }

    #[test]
    fn only_what_changed_is_reported_shown_and_taken() {
        let top = tempfile::tempdir().unwrap();
        let folders = folders(top.path());
        for name in ["a/same", "a/changed", "b/gone"] {
            write(&folders.golden, name, 1);
        }
        for (name, value) in [("a/same", 1), ("a/changed", 2), ("b/new.v2", 3)] {
            write(&folders.drawn, name, value);
        }
        let changed = folders.report().unwrap();
        assert_eq!(changed, BTreeSet::from(["a/changed".into(), "b/new.v2".into()]));
        assert!(folders.differences.join("a/changed.diff.png").is_file());
        assert_eq!(read(&file(&folders.golden, "a/changed")).unwrap().rgba[0], 1, "the report takes nothing");

        for name in accepted(&changed, &[]).unwrap() {
            folders.take(name).unwrap();
        }
        assert_eq!(read(&file(&folders.golden, "a/changed")).unwrap().rgba[0], 2);
        assert_eq!(read(&file(&folders.golden, "b/new.v2")).unwrap().rgba[0], 3);
        assert!(folders.report().unwrap().is_empty());
    }

    #[test]
    fn names_and_topics_choose() {
        let changed: BTreeSet<String> = ["a/x", "a/y", "b/x"].map(String::from).into();
        let accepted = |names: &[&str]| {
            let names: Vec<_> = names.iter().map(ToString::to_string).collect();
            accepted(&changed, &names).map(|taken| taken.into_iter().collect::<Vec<_>>())
        };
        assert_eq!(accepted(&["a/y", "b"]).unwrap(), ["a/y", "b/x"]);
        assert_eq!(accepted(&["a", "a/x"]).unwrap(), ["a/x", "a/y"]);
        assert!(accepted(&["a", "x"]).is_err());
    }
}
