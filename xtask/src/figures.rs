//! `cargo xtask figures`: the pictures of the README, drawn by the program itself.

use anyhow::Result;

use crate::process;

/// Model, file name below `docs/images`, and further arguments of `tercio render`.
const FIGURES: [(&str, &str, &[&str]); 1] = [("builtin:teapot@1M", "teapot.png", &["--size", "1280x720"])];

/// Draws all of them.
///
/// # Errors
/// The program does not build, or it does not draw.
pub fn run() -> Result<()> {
    let images = tercio_testkit::workspace_root().join("docs/images");
    std::fs::create_dir_all(&images)?;
    for (model, file, arguments) in FIGURES {
        let path = images.join(file);
        process::run(
            process::cargo()
                .args(["run", "--release", "--package", "tercio-cli", "--bin", "tercio", "--"])
                .args(["render", model, "-o"])
                .arg(&path)
                .args(arguments),
        )?;
        println!("{}: {} bytes", path.display(), std::fs::metadata(&path)?.len());
    }
    Ok(())
}
