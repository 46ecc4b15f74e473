//! Errors of workload files.

use std::path::PathBuf;

/// A mistake in the text of a workload.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("line {line}: expected {expected}, found {found}")]
pub struct SyntaxError {
    /// Number of the line, from 1.
    pub line: usize,
    /// What was expected.
    pub expected: String,
    /// What was found.
    pub found: String,
}

/// Why a workload file was not read.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// The file could not be read.
    #[error("{}: {error}", file.display())]
    Io {
        /// Name of the file.
        file: PathBuf,
        /// The system's error.
        error: std::io::Error,
    },
    /// It was read and is not a valid workload.
    #[error("{}: {error}", file.display())]
    Syntax {
        /// Name of the file.
        file: PathBuf,
        /// The position, and what was expected.
        error: SyntaxError,
    },
}

/// Reads a text file and passes it to a parser.
pub(crate) fn read<T>(
    file: &std::path::Path,
    parse: impl FnOnce(&str) -> Result<T, SyntaxError>,
) -> Result<T, ReadError> {
    let bytes = std::fs::read(file).map_err(|error| ReadError::Io { file: file.into(), error })?;
    let text = std::str::from_utf8(&bytes).map_err(|e| {
        let line = 1 + bytes[..e.valid_up_to()].iter().filter(|&&b| b == b'\n').count();
        let expected = "text".to_owned();
        ReadError::Syntax {
            file: file.into(),
            error: SyntaxError { line, expected, found: "bytes that are not UTF-8".into() },
        }
    })?;
    parse(text).map_err(|error| ReadError::Syntax { file: file.into(), error })
}
