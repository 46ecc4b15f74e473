//! Errors of reading a model.

use std::fmt;

/// Where in a file an error is.
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
#[non_exhaustive]
pub enum ReadError {
    /// The file could not be opened or read.
    #[error("{file}: {source}")]
    Io {
        /// File name as the user gave it.
        file: String,
        /// The system's reason.
        source: std::io::Error,
    },
    /// Something other than what the format requires was found.
    #[error("{file}: {place}expected {expected}, found {found}")]
    Malformed {
        /// File name as the user gave it.
        file: String,
        /// Where.
        place: Place,
        /// What the format requires.
        expected: String,
        /// What was found.
        found: String,
    },
    /// The content is of no supported format.
    #[error(
        "{file}: not a model that tercio reads (PLY, OBJ, STL, OFF, VTK, PCD, LAS, LAZ, point clouds as text, each also gzip-compressed); it begins with {begins}"
    )]
    UnknownFormat {
        /// File name as the user gave it.
        file: String,
        /// The first bytes, made printable.
        begins: String,
    },
    /// The content is of a known but unsupported format.
    #[error(
        "{file}: this is {what}, which tercio does not read (it reads PLY, OBJ, STL, OFF, VTK, PCD, LAS, LAZ, point clouds as text, each also gzip-compressed)"
    )]
    Unread {
        /// File name as the user gave it.
        file: String,
        /// The format.
        what: String,
    },
    /// The file has no content.
    #[error("{file}: the file is empty{what}")]
    Empty {
        /// File name as the user gave it.
        file: String,
        /// More about it, or nothing.
        what: &'static str,
    },
    /// There is content, but no geometry.
    #[error("{file}: holds nothing but {but}")]
    HoldsNothing {
        /// File name as the user gave it.
        file: String,
        /// What it does hold.
        but: &'static str,
    },
    /// Compressed data that cannot be decompressed completely.
    #[error("{file}: {what}")]
    Compressed {
        /// File name as the user gave it.
        file: String,
        /// What is wrong with the data.
        what: String,
    },
    /// The file is valid but holds something that is not supported.
    #[error("{file}: {place}{what} is not supported")]
    Unsupported {
        /// File name as the user gave it.
        file: String,
        /// Where.
        place: Place,
        /// What it is.
        what: String,
    },
    /// Reading would take more memory than is allowed.
    #[error("{file}: needs {needed} bytes for {what}, the limit is {limit} bytes (--memory-limit)")]
    MemoryLimit {
        /// File name as the user gave it.
        file: String,
        /// What the memory is for.
        what: String,
        /// Bytes in total, including what is already held.
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

impl ReadError {
    /// The error of a reader that began this many lines and bytes after the start of the file.
    #[must_use]
    pub(crate) fn shifted(self, lines: u64, bytes: u64) -> Self {
        match self {
            Self::Malformed { file, place, expected, found } => {
                Self::Malformed { file, place: place.shifted(lines, bytes), expected, found }
            }
            Self::Unsupported { file, place, what } => {
                Self::Unsupported { file, place: place.shifted(lines, bytes), what }
            }
            other => other,
        }
    }
}

impl Place {
    fn shifted(self, lines: u64, bytes: u64) -> Self {
        match self {
            Self::Line(n) => Self::Line(n + lines),
            Self::Byte(n) => Self::Byte(n + bytes),
            Self::File => Self::File,
        }
    }
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

/// Names the valid indices, for errors; `range` describes them if there are any.
pub(crate) fn expected_index(what: &str, plural: &str, count: u64, range: impl FnOnce() -> String) -> String {
    match count {
        0 => format!("no {what} indices (the file has no {plural})"),
        _ => range(),
    }
}

/// The same for vertices that are numbered from 0.
pub(crate) fn expected_vertex(vertices: u64) -> String {
    expected_index("vertex", "vertices", vertices, || format!("a vertex number from 0 to {}", vertices - 1))
}

/// The warning about faces without corners.
pub(crate) fn ignored_empty_faces(n: u64) -> String {
    format!("ignored {} that {} no corners", counted(n, "face"), if n == 1 { "has" } else { "have" })
}

/// "1 face", "2 faces".
pub(crate) fn counted(n: u64, what: &str) -> String {
    format!("{n} {what}{}", if n == 1 { "" } else { "s" })
}
