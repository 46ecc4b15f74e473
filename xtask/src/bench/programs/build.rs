//! Builds the programs that are measured.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context as _, Result, ensure};
use tercio_testkit::workspace_root;

use crate::process;

/// The floor, from `shared/floor` beside the checkout.
pub fn floor(folder: &Path) -> Result<PathBuf> {
    let shared = tercio_testkit::shared_data().context("../shared is absent")?;
    let source = shared.with_file_name("floor");
    ensure!(source.is_dir(), "../shared/floor is absent");
    #[cfg(target_arch = "x86_64")]
    ensure!(is_x86_feature_detected!("avx512vbmi"), "it needs AVX-512");
    ensure!(cfg!(target_arch = "x86_64"), "it needs an x86-64 processor");
    // Its own folder may be read-only, and a lock file is written beside the manifest: build a copy.
    let copy = folder.join("floor");
    process::run(Command::new("cp").arg("-r").arg(&source).arg(&copy))?;
    process::run(Command::new("chmod").args(["-R", "u+w"]).arg(&copy))?;
    process::run(
        process::cargo()
            .current_dir(&copy)
            .env("RUSTFLAGS", "-Ctarget-cpu=native")
            .args(["build", "--release", "--target-dir"])
            .arg(floor_target()?),
    )?;
    Ok(floor_target()?.join("release/floor"))
}

/// Kept from bench to bench: its mesh library takes minutes to compile.
fn floor_target() -> Result<PathBuf> {
    Ok(process::target_folder()?.join("floor"))
}

/// A program of `xtask/rivals` with the libraries of Debian that it needs.
pub fn rival(folder: &Path, name: &str, libraries: &[&str]) -> Result<PathBuf> {
    let (source, program) = (workspace_root().join("xtask/rivals"), folder.join(name));
    let mut command = Command::new("cc");
    command.args(["-std=c11", "-Wall", "-Wextra", "-O3", "-march=native"]);
    command.arg(source.join(format!("{name}.c"))).arg(source.join("common.c")).arg("-o").arg(&program);
    process::run(command.args(libraries.iter().map(|l| format!("-l{l}"))).arg("-lm"))?;
    Ok(program)
}

/// The Python that `PYTHON` names, or `python3`, if it has VTK's module.
pub fn vtk() -> Result<PathBuf> {
    let python = std::env::var_os("PYTHON").unwrap_or_else(|| "python3".into());
    let has_module = process::output(Command::new(&python).args(["-c", "import vtk"])).is_ok();
    ensure!(has_module, "the Python of $PYTHON, or python3, has no module vtk");
    Ok(python.into())
}

/// The program that draws with VTK.
pub fn vtk_script() -> PathBuf {
    workspace_root().join("xtask/rivals/vtk_turn.py")
}
