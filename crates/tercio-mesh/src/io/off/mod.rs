//! OFF, the object file format of Geomview, and its dialects: `[ST][C][N][4][n]OFF`.
//!
//! A vertex is its position, then what the header's letters announce: normal, colour, texture coordinates.
//! A face is its number of corners, their vertices, and a colour or nothing up to the end of the line.
//!
//! Decisions where the format leaves it open, or files do not follow it:
//! - `4OFF` holds homogeneous coordinates, which are divided by the last; of `nOFF` the first three coordinates are
//!   drawn, and missing ones are 0. `4nOFF`, of which no program could be found that writes it, is not read.
//! - Binary numbers are big-endian, colours of vertices have four of them, and each face ends with the number of
//!   its colour's components. Files of programs that write little-endian numbers, or no colours at the faces, are
//!   read too, with a warning, if that fits the file to its end.
//!
//! Source: Geomview manual, "OFF Files" and "Generic Geom format"; how Geomview reads binary files.

mod binary;
mod body;
mod header;

use super::{ReadModel, ReadOptions, input::Input, obj::transcode, text};
use crate::ReadError;
use header::Encoding;

/// How much of a file is examined for detecting the format.
const FRONT: usize = 1 << 16;

/// Does the content look like OFF? Decided by the first word that is not a comment; without the keyword, by two lines
/// of numbers that are consistent.
pub fn looks_like(bytes: &[u8]) -> bool {
    let front = transcode::front(bytes, FRONT);
    header::looks_like(&front, bytes.len())
}

/// Reads OFF.
///
/// # Errors
/// Any [`ReadError`].
pub fn read(input: &Input, options: &ReadOptions) -> Result<ReadModel, ReadError> {
    let mut odd = Vec::new();
    let bytes = input.bytes();
    let unmarked = transcode::without_mark(bytes).unwrap_or(bytes);
    let mut model = match header::parse_keyword(&input.name, unmarked) {
        Ok((header, Encoding::Binary(at))) => {
            let mark = bytes.len() - unmarked.len();
            if mark > 0 {
                odd.push(transcode::MARK_WARNING.into());
            }
            binary::read(input, options, header, at + mark)?
        }
        _ => {
            let text = transcode::text(input, options, &mut odd)?;
            let pieces = text.len() / input.stretch(text.len().max(1));
            let lines = text::split_lines(&text, pieces, |bytes| input.consumed(bytes));
            let (mut header, encoding) = header::parse_keyword(&input.name, &text)?;
            let mut cursor = match encoding {
                Encoding::Ascii(cursor) => cursor,
                // Only in UTF-16, where the rest is not binary data.
                Encoding::Binary(_) => text::Cursor::new(b"", 1),
            };
            // One line is read at a time.
            input.check_chunk_lengths(&lines, options)?;
            body::skip_to_word(input, &mut cursor);
            header::parse_counts(&input.name, &mut header, &mut cursor)?;
            body::read(input, options, header, cursor)?
        }
    };
    model.report.warnings.splice(0..0, odd);
    Ok(model)
}

#[cfg(test)]
mod tests;
#[cfg(test)]
mod tests_binary;
