//! Lines on standard error in one piece.
//!
//! The macro `eprintln!` writes each part of a line by itself. In a job all processes, and `mpirun`, share standard error, so that
//! their words would come between.

use std::fmt::Display;
use std::io::{self, Write as _};

/// Writes a line to standard error in one piece, with the line break that ends it. A pipe, as a process of a job has to `mpirun`,
/// keeps up to 4,096 bytes together on Linux.
///
/// A standard error that is closed or cannot be written to is ignored: messages are no reason to fail.
pub fn write_line(line: &str) {
    let _ = io::stderr().lock().write_all(format!("{line}\n").as_bytes());
}

/// Writes `error: rank 3: ...` to standard error, as [`write_line`] does: what a program passes to `run` if its errors need nothing
/// else.
pub fn write_error(rank: usize, error: impl Display) {
    write_line(&format!("error: rank {rank}: {error}"));
}
