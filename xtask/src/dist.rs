//! `cargo xtask dist`: one static file that runs without any other file.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use anyhow::{Context as _, Result, ensure};
use tercio_testkit::data::on_ci;
use tercio_testkit::workspace_root;

use crate::elf::Needs;
use crate::process::{
    cargo, find_program, host_triple, is_root, run as run_command, rustflags, target_folder,
};

/// The binary has to stay small enough to send by mail; a jump over this limit needs a known reason. It was 10 MiB before
/// there were kernels for several samples per pixel, 0.7 MB at four SIMD levels, 12 MiB before there were layers,
/// materials, and decoders for seven kinds of pictures, and 16 MiB before there were VTK's files with their compressors, colours by
/// data at four SIMD levels, type, films, completions and manual pages. It was 20 MiB before edges and data had kernels of their own at
/// two SIMD levels, and the laboratory its reasons, worked runs, figures and site, and 21 MiB before PNG in one pass and
/// an adaptive division.
const MOST_BYTES: u64 = 22 << 20;

const PNG_SIGNATURE: &[u8] = b"\x89PNG\r\n\x1a\n";

/// Arguments of `cargo xtask dist`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Run the binary in an empty root directory, too (as root, or where user namespaces are allowed)
    #[arg(long)]
    check: bool,
}

/// Outcome of the run in the empty root.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// It ran, and its output was right.
    Checked,
    /// This user may not change the root, and this is not CI.
    Skipped,
}

/// Builds the binary and, if requested, runs it.
///
/// # Errors
/// It does not build, is not static, is too large, or does not run.
pub fn run(arguments: &Arguments) -> Result<()> {
    let binary = build()?;
    if arguments.check {
        check(&binary)?;
    }
    Ok(())
}

/// Builds `dist/tercio` and returns its path.
///
/// # Errors
/// It does not build, is not static, or is too large.
pub fn build() -> Result<PathBuf> {
    let triple = host_triple()?;
    ensure!(triple.contains("-linux-"), "a static binary is made on Linux only, this is {triple}");
    ensure!(
        !triple.contains("-gnu") || crate::packages::has_static_libc(),
        "the static C library is missing (libc.a; Debian: libc6-dev, Fedora: glibc-static)"
    );
    run_command(
        cargo()
            .env("RUSTFLAGS", rustflags(&["-Ctarget-feature=+crt-static"]))
            .args(["build", "--package", "tercio-cli", "--bin", "tercio", "--profile", "dist", "--target"])
            .arg(&triple),
    )?;
    let built = target_folder()?.join(&triple).join("dist/tercio");
    let content = fs::read(&built).with_context(|| format!("reading {}", built.display()))?;
    Needs::of(&content)?.check_static()?;
    let size = content.len() as u64;
    ensure!(size <= MOST_BYTES, "the binary has {size} bytes, more than the {MOST_BYTES} it may have");

    let binary = workspace_root().join("dist/tercio");
    fs::create_dir_all(workspace_root().join("dist"))?;
    // Written under another name first: a running binary cannot be overwritten.
    let unfinished = binary.with_extension("new");
    fs::copy(&built, &unfinished)?;
    fs::rename(&unfinished, &binary)?;
    println!("{}: static, {size} bytes ({:.1} MB), {triple}", binary.display(), size as f64 / 1e6);
    Ok(binary)
}

/// Runs the binary in a root directory that contains nothing else.
///
/// # Errors
/// It fails there, or, on CI, it cannot be run there.
pub fn check(binary: &Path) -> Result<Outcome> {
    let folder = tempfile::tempdir()?;
    fs::copy(binary, folder.path().join("tercio"))?;
    let Some(room) = EmptyRoot::find(folder.path()) else {
        let reason = "running in an empty root needs root, or unshare (util-linux) and user namespaces";
        ensure!(!on_ci(), "{reason}; on CI this may not be skipped");
        println!("skipped: {reason}");
        return Ok(Outcome::Skipped);
    };

    room.tercio(&["render", "builtin:teapot@1k", "-o", "/t.png", "--size", "64x64"])?;
    let picture =
        fs::read(folder.path().join("t.png")).context("the picture that render should have made")?;
    ensure!(picture.starts_with(PNG_SIGNATURE), "render wrote {} bytes that are no PNG", picture.len());

    let info = room.tercio(&["info", "builtin:sphere@1k", "--json"])?;
    serde_json::from_slice::<serde_json::Value>(&info.stdout).context("info --json wrote no JSON")?;

    println!("{}: runs in an empty root ({} bytes of PNG)", binary.display(), picture.len());
    Ok(Outcome::Checked)
}

/// A way to run programs with a folder as their root directory.
struct EmptyRoot<'a> {
    folder: &'a Path,
    /// The program and arguments before `FOLDER PROGRAM`.
    command: Vec<PathBuf>,
}

impl<'a> EmptyRoot<'a> {
    fn find(folder: &'a Path) -> Option<Self> {
        let chroot = find_program("chroot")?;
        let mut ways = Vec::new();
        if is_root() {
            ways.push(vec![chroot.clone()]);
        }
        // Containers often withhold the right to chroot from their root user, and allow user namespaces.
        if let Some(unshare) = find_program("unshare") {
            ways.push(vec![unshare, "--map-root-user".into(), chroot]);
        }
        let works = |way: &Vec<PathBuf>| {
            let mut probe = Command::new(&way[0]);
            probe.args(&way[1..]).args(["/", "true"]).output().is_ok_and(|output| output.status.success())
        };
        ways.into_iter().find(works).map(|command| Self { folder, command })
    }

    fn tercio(&self, arguments: &[&str]) -> Result<Output> {
        let mut command = Command::new(&self.command[0]);
        // Without the environment, too: the binary may need nothing of this machine.
        command.args(&self.command[1..]).arg(self.folder).arg("/tercio").args(arguments).env_clear();
        crate::process::show(&command);
        let output = command.output().context("starting chroot")?;
        ensure!(
            output.status.success(),
            "tercio {} failed in an empty root ({}): {}",
            arguments.join(" "),
            output.status,
            String::from_utf8_lossy(&output.stderr).trim()
        );
        Ok(output)
    }
}
