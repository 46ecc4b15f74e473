//! `cargo xtask figures`: draws the pictures of the README with the README's own commands.

use anyhow::{Context as _, Result};

use crate::process;

/// Prefix of the commands of the README that draw its pictures.
const COMMAND: &str = "cargo run --release -- ";

/// Draws all of them.
///
/// # Errors
/// The program does not build, or it does not draw.
pub fn run() -> Result<()> {
    let root = tercio_testkit::workspace_root();
    let images = root.join("docs/images");
    std::fs::create_dir_all(&images)?;
    let readme = std::fs::read_to_string(root.join("README.md"))?;
    for command in readme.lines().filter_map(|line| line.strip_prefix(COMMAND)) {
        let arguments: Vec<_> = command.split_whitespace().collect();
        let file = images.join(arguments.last().context("a command of the README draws nothing")?);
        let manifest = root.join("Cargo.toml");
        process::run(
            process::cargo()
                .args(["run", "--release", "--package", "tercio-cli", "--bin", "tercio", "--manifest-path"])
                .arg(manifest)
                .arg("--")
                .args(&arguments)
                .current_dir(&images),
        )?;
        println!("{}: {} bytes", file.display(), std::fs::metadata(&file)?.len());
    }
    Ok(())
}
