//! `cargo xtask gallery`: the pictures of `docs/gallery.md`, and the page.

use std::fs;

use anyhow::{Context as _, Result, bail};
use tercio_testkit::gallery::{changed, draw, entries, folder, page, replace};
use tercio_testkit::workspace_root;

use crate::process;

/// Arguments of `cargo xtask gallery`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Change nothing; name the pictures that would change, and fail if there are any
    #[arg(long)]
    check: bool,
    /// Build the program as for a release; the pictures are the same
    #[arg(long)]
    release: bool,
}

/// Draws all pictures with the program as it is, and writes them and their page; or compares them with those that are kept.
///
/// # Errors
/// The program does not build, a command fails, or a picture that was there has changed, which is written nevertheless.
pub fn run(arguments: &Arguments) -> Result<()> {
    let mut build = process::cargo();
    build.args(["build", "--package", "tercio-cli"]);
    if arguments.release {
        build.arg("--release");
    }
    process::run(&mut build)?;
    let profile = if arguments.release { "release" } else { "debug" };
    let program = process::target_folder()?.join(profile).join("tercio");
    let entries = entries();
    let drawn = tempfile::tempdir()?;
    draw(&entries, &program, drawn.path())?;
    let (kept, page_file) = (folder(), workspace_root().join("docs/gallery.md"));
    fs::create_dir_all(&kept)?;
    let mut names = changed(drawn.path(), &kept)?;
    let page = page(&entries);
    if fs::read_to_string(&page_file).unwrap_or_default() != page {
        names.push("docs/gallery.md".into());
    }
    if arguments.check {
        return if names.is_empty() { Ok(()) } else { bail!("changed: {}", names.join(", ")) };
    }
    names.iter().for_each(|name| println!("changed: {name}"));
    let otherwise = replace(&names, drawn.path(), &kept).with_context(|| kept.display().to_string())?;
    fs::write(&page_file, page)?;
    println!("{} entries, {} changes", entries.len(), names.len());
    if otherwise.is_empty() {
        return Ok(());
    }
    // They are written: whoever wants them so keeps them.
    bail!("pictures that were there are drawn otherwise now: {}", otherwise.join(", "))
}
