//! What can go wrong while a model is read.

use std::fmt;

/// Where in a file something stood.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// Line number, the first line is 1.
    Line(u64),
    /// Byte offset, the first byte is 0; after decompression where the file is compressed.
    Byte(u64),
    /// The file as a whole.
    File,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Place::Line(n) => write!(f, "line {n}: "),
            Place::Byte(n) => write!(f, "byte {n}: "),
            Place::File => Ok(()),
        }
    }
}

/// Why a model could not be read.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// The file could not be opened or read.
    #[error("{file}: {source}")]
    Io {
        /// File name as the user gave it.
        file: String,
        /// The system's reason.
        source: std::io::Error,
    },
    /// Something else stood where the format asks for `expected`.
    #[error("{file}: {place}expected {expected}, found {found}")]
    Malformed {
        /// File name as the user gave it.
        file: String,
        /// Where.
        place: Place,
        /// What the format asks for.
        expected: String,
        /// What stood there.
        found: String,
    },
    /// The content is of no format that is read.
    #[error(
        "{file}: not a model that tercio reads (PLY, OBJ, STL, OFF, each also gzip-compressed); it begins with {begins}"
    )]
    UnknownFormat {
        /// File name as the user gave it.
        file: String,
        /// The first bytes, made printable.
        begins: String,
    },
    /// The file is right but holds something that is not drawn.
    #[error("{file}: {place}{what} is not supported")]
    Unsupported {
        /// File name as the user gave it.
        file: String,
        /// Where.
        place: Place,
        /// What it is.
        what: String,
    },
    /// Reading would take more memory than allowed.
    #[error("{file}: needs {needed} bytes for {what}, the limit is {limit} bytes (--memory-limit)")]
    MemoryLimit {
        /// File name as the user gave it.
        file: String,
        /// What the memory is for.
        what: String,
        /// Bytes in all, with what is already held.
        needed: u64,
        /// Bytes allowed.
        limit: u64,
    },
    /// More vertices or triangles than can be numbered.
    #[error("{file}: {count} {what}, at most {} are supported", crate::mesh::MAX_ELEMENTS)]
    TooMany {
        /// File name as the user gave it.
        file: String,
        /// Vertices or triangles.
        what: &'static str,
        /// How many the file holds.
        count: u64,
    },
}

/// Makes bytes of a broken file printable for an error message: at most 40 of them, quoted.
pub fn printable(bytes: &[u8]) -> String {
    if bytes.is_empty() {
        return "the end of the file".into();
    }
    let shown = &bytes[..bytes.len().min(40)];
    let dots = if shown.len() < bytes.len() { "…" } else { "" };
    format!("\"{}{dots}\"", shown.escape_ascii())
}
