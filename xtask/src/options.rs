//! `cargo xtask options`: docs/options.md, made from the definition of the options.

use anyhow::{Context as _, Result};

use crate::process;

/// Writes the page.
///
/// # Errors
/// The program does not build, or the page cannot be written.
pub fn run() -> Result<()> {
    let root = tercio_testkit::workspace_root();
    let mut print = process::cargo();
    print.args(["run", "--quiet", "--package", "tercio-cli", "--bin", "tercio", "--manifest-path"]);
    print.arg(root.join("Cargo.toml")).args(["--", "man", "--markdown"]);
    let path = root.join("docs/options.md");
    std::fs::write(&path, process::output(&mut print)?)
        .with_context(|| format!("writing {}", path.display()))?;
    println!("{}", path.display());
    Ok(())
}
