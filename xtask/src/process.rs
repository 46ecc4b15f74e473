//! Running other programs: cargo, rustc, and those that cargo built.

use std::env;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

use anyhow::{Context as _, Result, bail, ensure};
use tercio_testkit::workspace_root;

/// The cargo that runs this program, with the workspace root as its directory.
pub fn cargo() -> Command {
    let mut command = Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.current_dir(workspace_root());
    command
}

/// Prints a command, runs it, and fails unless it succeeds.
pub fn run(command: &mut Command) -> Result<()> {
    show(command);
    let status = command.status().with_context(|| format!("starting {}", name(command)))?;
    ensure!(status.success(), "{} failed ({status})", name(command));
    Ok(())
}

/// Runs a command without printing it and returns its standard output.
pub fn output(command: &mut Command) -> Result<String> {
    let output = command.output().with_context(|| format!("starting {}", name(command)))?;
    if !output.status.success() {
        bail!("{} failed: {}", name(command), String::from_utf8_lossy(&output.stderr).trim());
    }
    String::from_utf8(output.stdout).with_context(|| format!("{} wrote no text", name(command)))
}

/// Prints the command line the way a shell shows it with `set -x`.
pub fn show(command: &Command) {
    let mut line = format!("+ {}", name(command));
    for argument in command.get_args() {
        line.push(' ');
        line += &argument.to_string_lossy();
    }
    eprintln!("{line}");
}

/// The command's file name without its folder.
pub fn name(command: &Command) -> String {
    let program = Path::new(command.get_program());
    program.file_name().unwrap_or(OsStr::new("?")).to_string_lossy().into_owned()
}

/// tercio: the release build, except that it may use shared libraries.
pub fn tercio() -> Result<PathBuf> {
    run(cargo().args(["build", "--release", "--package", "tercio-cli"]))?;
    Ok(target_folder()?.join("release/tercio"))
}

/// Cargo's target folder.
pub fn target_folder() -> Result<PathBuf> {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    if let Some(folder) = FOLDER.get() {
        return Ok(folder.clone());
    }
    let json = output(cargo().args(["metadata", "--format-version=1", "--no-deps"]))?;
    let metadata: serde_json::Value = serde_json::from_str(&json).context("reading cargo metadata")?;
    let folder = metadata["target_directory"].as_str().context("cargo metadata names no target folder")?;
    Ok(FOLDER.get_or_init(|| folder.into()).clone())
}

/// The triple of the machine that the compiler runs on, such as `x86_64-unknown-linux-gnu`.
pub fn host_triple() -> Result<String> {
    let rustc = env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let version = output(Command::new(rustc).arg("-vV").current_dir(workspace_root()))?;
    let host = version.lines().find_map(|line| line.strip_prefix("host: "));
    Ok(host.context("rustc -vV names no host")?.to_owned())
}

/// `RUSTFLAGS` of the environment plus `added`. They apply only to what is built for `--target`, so a command that uses
/// them names a target: build scripts and macros have to stay as they are.
pub fn rustflags(added: &[&str]) -> String {
    let mut flags = env::var("RUSTFLAGS").unwrap_or_default();
    for flag in added {
        if !flags.is_empty() {
            flags.push(' ');
        }
        flags += flag;
    }
    flags
}

/// Finds a program in `PATH`.
pub fn find_program(program: &str) -> Option<PathBuf> {
    let path = env::var_os("PATH")?;
    // chroot is in sbin, which the PATH of root may lack.
    let folders = env::split_paths(&path).chain(["/usr/sbin".into(), "/sbin".into()]);
    folders.map(|folder| folder.join(program)).find(|candidate| candidate.is_file())
}

/// True for the superuser.
pub fn is_root() -> bool {
    output(Command::new("id").arg("-u")).is_ok_and(|id| id.trim() == "0")
}
