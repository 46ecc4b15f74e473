//! Every real and every broken file draws, or is refused with a clear error: no panic, no hang, no more than
//! 2 GB of memory.

mod common;

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use tercio_testkit::require_shared;

/// Time limit of one file. Debug builds on busy machines are slow; a hang never ends.
const PATIENCE: Duration = Duration::from_secs(10);
/// Address space of a run in KiB: 2 GB, plus the reservations of the program and its threads' stacks.
const ADDRESS_SPACE: u64 = (2 << 20) + (512 << 10);

/// All files below a folder whose name ends in one of `endings`, whatever its case.
fn files(folder: &Path, endings: &[&str]) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).expect("a folder of the shared data") {
            let path = entry.expect("an entry").path();
            let name = path.to_string_lossy().to_lowercase();
            if path.is_dir() {
                folders.push(path);
            } else if endings.iter().any(|e| name.ends_with(e)) {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

/// Renders one file in a bounded address space; returns exit code and standard error.
fn render(file: &Path, picture: &Path) -> (i32, String) {
    let mut child = Command::new("sh")
        .arg("-c")
        .arg(format!(
            "ulimit -v {ADDRESS_SPACE} && exec \"$0\" render \"$1\" -o \"$2\" --size 64x48 --threads 2 --allow-empty"
        ))
        .args([Path::new(env!("CARGO_BIN_EXE_tercio")), file, picture])
        .env("TERCIO_CONFIG", "none")
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("a shell");
    let begin = Instant::now();
    while child.try_wait().expect("a child").is_none() {
        if begin.elapsed() > PATIENCE {
            child.kill().expect("to end it");
            panic!("{}: still running after {PATIENCE:?}", file.display());
        }
        std::thread::sleep(Duration::from_millis(2));
    }
    let output = child.wait_with_output().expect("its output");
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    (output.status.code().unwrap_or(-1), stderr)
}

/// A run may end with a picture, or with one line that names the file and the reason.
fn check(file: &Path, picture: &Path) -> bool {
    let _ = std::fs::remove_file(picture);
    let (code, stderr) = render(file, picture);
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    assert!(!stderr.contains("panicked"), "{}: {stderr}", file.display());
    match code {
        0 => assert!(picture.exists(), "{}: no picture", file.display()),
        1 => {
            assert!(!picture.exists(), "{}: failed and left a picture", file.display());
            let error = stderr.lines().find(|l| l.starts_with("error: "));
            let error = error.unwrap_or_else(|| panic!("{}: no error line in {stderr:?}", file.display()));
            assert!(error.contains(&*name) && error.len() > name.len() + 20, "{error}");
        }
        _ => panic!("{}: exit code {code}: {stderr}", file.display()),
    }
    code == 0
}

#[test]
fn every_model_of_a_format_that_is_read_draws() {
    let Some(shared) = require_shared("every_model_of_a_format_that_is_read_draws") else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let picture = folder.path().join("picture.png");
    let models = files(&shared.join("meshes"), &[".ply", ".ply.gz", ".obj", ".stl", ".off"]);
    assert!(models.len() > 120, "{}", models.len());
    let refused: Vec<_> = models.iter().filter(|m| !check(m, &picture)).collect();
    assert!(refused.len() * 10 < models.len(), "refused {refused:#?}");
}

#[test]
fn every_broken_file_ends_in_an_error_or_a_repaired_picture() {
    let Some(shared) = require_shared("every_broken_file_ends_in_an_error_or_a_repaired_picture") else {
        return;
    };
    let folder = tempfile::tempdir().expect("a folder");
    let picture = folder.path().join("picture.png");
    let broken = files(&shared.join("malformed"), &[""]);
    assert!(broken.len() > 200, "{}", broken.len());
    let drawn = broken.iter().filter(|m| check(m, &picture)).count();
    assert!(drawn < broken.len() / 2, "{drawn} of {} broken files were drawn", broken.len());
}
