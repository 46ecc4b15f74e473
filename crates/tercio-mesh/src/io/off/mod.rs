//! OFF, the object file format of Geomview, and its dialects: `[ST][C][N][4][n]OFF`.
//!
//! A vertex is its position, then what the header's letters announce: normal, colour, texture coordinates.
//! A face is its number of corners, their vertices, and a colour or nothing up to the end of the line.
//!
//! Source: Geomview manual, "OFF Files"; four-dimensional and binary files are recognised, not read.

mod body;
mod header;

use super::{ReadModel, ReadOptions, input::Input, obj::transcode};
use crate::ReadError;

/// How much of a file is looked at to find out what it is.
const FRONT: usize = 1 << 16;

/// Does the content look like OFF? Decided by the first word that is no comment; without the keyword, by two
/// lines of numbers that fit each other.
pub fn looks_like(bytes: &[u8]) -> bool {
    let front = transcode::front(bytes, FRONT);
    header::looks_like(&front, bytes.len())
}

/// Reads OFF.
///
/// # Errors
/// Any [`ReadError`].
pub fn read(input: &Input, options: &ReadOptions) -> Result<ReadModel, ReadError> {
    let text = transcode::text(input, options)?;
    let (header, cursor) = header::parse(&input.name, &text)?;
    body::read(input, options, &header, cursor)
}

#[cfg(test)]
mod tests;
