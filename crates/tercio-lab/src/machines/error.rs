//! What can be wrong with a description.

use std::io;
use std::path::PathBuf;

use thiserror::Error;

/// Why a machine could not be had.
#[derive(Debug, Error)]
pub enum MachineError {
    /// Neither a file nor one of ours.
    #[error("no machine \"{name}\": neither a file nor one of {known}")]
    Unknown {
        /// What was asked for.
        name: String,
        /// The machines that come with the program.
        known: String,
    },
    /// The file could not be read.
    #[error("{}: {source}", path.display())]
    Io {
        /// Which file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The text is no description.
    #[error("{file}:{line}:{column}: {what}")]
    Text {
        /// Which file.
        file: String,
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// What was expected and what stood there.
        what: String,
    },
    /// The description lacks what is asked of it.
    #[error("machine \"{machine}\": {what} is needed here, and its description has none")]
    Missing {
        /// Which machine.
        machine: String,
        /// The section or number.
        what: String,
    },
}

impl MachineError {
    /// An error of the TOML reader, its place counted in lines.
    pub(super) fn of_toml(file: &str, text: &str, error: &toml::de::Error) -> Self {
        let start = error.span().map_or(0, |s| s.start.min(text.len()));
        Self::behind(file, &text[..start], error.message())
    }

    /// The error that behind `before` a file holds no text.
    pub(super) fn of_bytes(file: &str, before: &[u8]) -> Self {
        let before = String::from_utf8_lossy(before);
        Self::behind(file, &before, "expected text, found bytes that are not UTF-8")
    }

    /// An error at the place behind `before`.
    fn behind(file: &str, before: &str, what: &str) -> Self {
        let line = before.matches('\n').count() + 1;
        let column = before.rsplit('\n').next().unwrap_or("").chars().count() + 1;
        Self::Text { file: file.into(), line, column, what: what.into() }
    }
}
