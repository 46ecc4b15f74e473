//! Converts texts into the form that the parsers expect: ASCII-compatible bytes, lines ending with a line feed.
//!
//! UTF-16 becomes UTF-8, a byte order mark is removed, and a file whose lines end with carriage returns alone gets
//! line feeds. All other files are used in place, without a copy.

use std::borrow::Cow;

use crate::ReadError;
use crate::error::counted;
use crate::io::{ReadOptions, input::Input};

/// How far line ends are searched for before a file is assumed to have carriage returns alone.
const LINE_END_WINDOW: usize = 1 << 16;

#[derive(Clone, Copy, PartialEq, Eq)]
enum Encoding {
    /// UTF-8 or any 8-bit encoding compatible with ASCII, after a byte order mark of this length.
    Bytes(usize),
    Utf16 {
        big_endian: bool,
        mark: usize,
    },
}

fn encoding(bytes: &[u8]) -> Encoding {
    match bytes {
        [0xef, 0xbb, 0xbf, ..] => Encoding::Bytes(3),
        [0xfe, 0xff, ..] => Encoding::Utf16 { big_endian: true, mark: 2 },
        [0xff, 0xfe, ..] => Encoding::Utf16 { big_endian: false, mark: 2 },
        // Model files begin with ASCII, so zeros between four bytes indicate UTF-16 even without a mark.
        [0, 1..=0x7f, 0, 1..=0x7f, ..] => Encoding::Utf16 { big_endian: true, mark: 0 },
        [1..=0x7f, 0, 1..=0x7f, 0, ..] => Encoding::Utf16 { big_endian: false, mark: 0 },
        _ => Encoding::Bytes(0),
    }
}

/// The mark in front of UTF-8 that Windows programs write.
const MARK: &[u8] = b"\xef\xbb\xbf";

/// The text of a whole file. Padding around it is ignored with a warning.
///
/// # Errors
/// [`ReadError::MemoryLimit`] where a copy is needed that would be too large.
pub fn text<'a>(
    input: &'a Input,
    options: &ReadOptions,
    warnings: &mut Vec<String>,
) -> Result<Cow<'a, [u8]>, ReadError> {
    let bytes = input.bytes();
    if needs_copy(bytes) {
        input.count_all();
        let copy = bytes.len() as u64 / 2 * 3;
        options.check_memory(&input.name, "the decoded text", input.held_bytes() + copy)?;
    }
    if without_mark(bytes).is_some() {
        warnings.push(MARK_WARNING.into());
    }
    let mut text = convert(bytes);
    let length = input.unpadded(&text).len();
    if length < text.len() {
        let padding = counted((text.len() - length) as u64, "zero byte");
        warnings.push(format!("ignored {padding} at the end"));
        match &mut text {
            Cow::Borrowed(bytes) => *bytes = bytes.get(..length).unwrap_or_default(),
            Cow::Owned(bytes) => bytes.truncate(length),
        }
    }
    Ok(text)
}

/// The warning about a byte order mark before UTF-8.
pub const MARK_WARNING: &str = "ignored the byte order mark at the front";

/// The bytes after a byte order mark of UTF-8, if there is one.
pub fn without_mark(bytes: &[u8]) -> Option<&[u8]> {
    bytes.strip_prefix(MARK)
}

/// The text of the first `limit` bytes, for detecting the format.
pub fn front(bytes: &[u8], limit: usize) -> Cow<'_, [u8]> {
    convert(bytes.get(..limit).unwrap_or(bytes))
}

/// The same for bytes of any origin, such as a material library.
pub fn convert(bytes: &[u8]) -> Cow<'_, [u8]> {
    let text = match encoding(bytes) {
        Encoding::Bytes(mark) => Cow::Borrowed(bytes.get(mark..).unwrap_or_default()),
        Encoding::Utf16 { big_endian, mark } => {
            Cow::Owned(from_utf16(bytes.get(mark..).unwrap_or_default(), big_endian))
        }
    };
    if has_lone_carriage_returns(&text) {
        let mut text = text.into_owned();
        text.iter_mut().filter(|b| **b == b'\r').for_each(|b| *b = b'\n');
        return Cow::Owned(text);
    }
    text
}

fn needs_copy(bytes: &[u8]) -> bool {
    matches!(encoding(bytes), Encoding::Utf16 { .. }) || has_lone_carriage_returns(bytes)
}

fn has_lone_carriage_returns(text: &[u8]) -> bool {
    let window = text.get(..LINE_END_WINDOW).unwrap_or(text);
    window.contains(&b'\r') && !window.contains(&b'\n')
}

fn from_utf16(bytes: &[u8], big_endian: bool) -> Vec<u8> {
    let (pairs, _half) = bytes.as_chunks::<2>();
    let units = pairs.iter().map(|&p| if big_endian { u16::from_be_bytes(p) } else { u16::from_le_bytes(p) });
    let mut text = Vec::with_capacity(pairs.len());
    for c in char::decode_utf16(units) {
        let c = c.unwrap_or(char::REPLACEMENT_CHARACTER);
        text.extend_from_slice(c.encode_utf8(&mut [0; 4]).as_bytes());
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn utf16_becomes_utf8_in_both_byte_orders_with_and_without_mark() {
        let text = "v 1 2 3\nusemtl grün 🎨\n";
        for mark in ["", "\u{feff}"] {
            let units: Vec<u16> = format!("{mark}{text}").encode_utf16().collect();
            let big: Vec<u8> = units.iter().flat_map(|u| u.to_be_bytes()).collect();
            let little: Vec<u8> = units.iter().flat_map(|u| u.to_le_bytes()).collect();
            assert_eq!(convert(&big), text.as_bytes());
            assert_eq!(convert(&little), text.as_bytes());
        }
    }

    #[test]
    fn plain_text_is_not_copied() {
        assert!(matches!(convert(b"\xef\xbb\xbfv 1\r\n"), Cow::Borrowed(b"v 1\r\n")));
    }

    #[test]
    fn lone_carriage_returns_become_line_feeds() {
        assert_eq!(convert(b"v 1\rv 2\r"), &b"v 1\nv 2\n"[..]);
    }
}
