//! Runs the program as a user does.

#![allow(dead_code, reason = "each test file uses its own part")]

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use tempfile::TempDir;

/// An octahedron with eight triangles.
pub const OCTAHEDRON: &str = "OFF\n6 8 12\n1 0 0\n-1 0 0\n0 1 0\n0 -1 0\n0 0 1\n0 0 -1\n\
    3 0 2 4\n3 2 1 4\n3 1 3 4\n3 3 0 4\n3 2 0 5\n3 1 2 5\n3 3 1 5\n3 0 3 5\n";

/// A folder of its own for each test, with a model in it.
pub struct Place {
    folder: TempDir,
}

/// The result of a run.
pub struct Outcome {
    pub code: Option<i32>,
    pub stdout: Vec<u8>,
    pub stderr: String,
}

impl Outcome {
    pub fn text(&self) -> &str {
        std::str::from_utf8(&self.stdout).expect("standard output is text")
    }

    /// The run succeeded and printed nothing on standard error.
    #[track_caller]
    pub fn ok_silently(self) -> Self {
        assert_eq!((self.code, self.stderr.as_str()), (Some(0), ""));
        self
    }

    /// The run failed with this code and one line that contains all of `parts`.
    #[track_caller]
    pub fn failed(&self, code: i32, parts: &[&str]) {
        assert_eq!(self.code, Some(code), "{}", self.stderr);
        let line = self.stderr.lines().next().unwrap_or_default();
        assert!(line.starts_with("error: "), "{line}");
        parts.iter().for_each(|p| assert!(self.stderr.contains(p), "{p:?} is not in {}", self.stderr));
    }
}

impl From<Output> for Outcome {
    fn from(output: Output) -> Self {
        let stderr = String::from_utf8(output.stderr).expect("standard error is text");
        Self { code: output.status.code(), stdout: output.stdout, stderr }
    }
}

impl Place {
    pub fn new() -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        std::fs::write(folder.path().join("model.off"), OCTAHEDRON).expect("a model");
        Self { folder }
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    pub fn names(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.folder.path()).expect("the folder");
        let mut names: Vec<_> =
            entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    /// The program, to be run in the folder; arguments are split at white space.
    pub fn command(&self, arguments: &str) -> Command {
        command(self.folder.path(), arguments)
    }

    pub fn run(&self, arguments: &str) -> Outcome {
        self.command(arguments).output().expect("the program starts").into()
    }

    pub fn run_with_input(&self, arguments: &str, input: &[u8]) -> Outcome {
        let mut command = self.command(arguments);
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().expect("the program starts");
        // A program that ends early closes its input, which is no failure of the test.
        let _ = child.stdin.take().expect("its input").write_all(input);
        child.wait_with_output().expect("the program ends").into()
    }
}

fn command(folder: &Path, arguments: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_tercio"));
    command.current_dir(folder).args(arguments.split_whitespace()).stdin(Stdio::null());
    // That of the machine must not change what is tested.
    command.env("TERCIO_CONFIG", "none");
    command
}

/// A small random number generator, the same on every machine.
pub struct Random(pub u64);

impl Random {
    /// From 0 to 1.
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    /// With coordinates from `-reach` to `reach`.
    pub fn point(&mut self, reach: f64) -> tercio::glam::DVec3 {
        tercio::glam::DVec3::new(self.next(), self.next(), self.next()) * (2.0 * reach) - reach
    }
}
