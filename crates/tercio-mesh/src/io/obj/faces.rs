//! The corners of faces: `v`, `v/vt`, `v//vn`, `v/vt/vn`, with indices counted from the front or from the back.

use crate::ReadError;
use crate::error::expected_index;
use crate::io::text::parse_integer;

use super::lines::Counts;
use super::parse::{Words, ends_word};

/// The index of a corner that has no texture coordinate or normal.
pub const NONE: u32 = u32::MAX;

/// The corners of all faces of a chunk, one face after the other. Indices count from zero over the whole file and are
/// in range.
#[derive(Debug, Default, PartialEq)]
pub struct Corners {
    /// Vertices.
    pub v: Vec<u32>,
    /// Texture coordinates or [`NONE`]; empty if no corner has any.
    pub vt: Vec<u32>,
    /// Normals or [`NONE`]; empty if no corner has any.
    pub vn: Vec<u32>,
    /// Number of corners of each face; empty while all faces are triangles.
    sizes: Vec<u32>,
    faces: u32,
    /// Indices of texture coordinates or normals in a file that holds none at all. Such files exist, and the indices
    /// can be ignored.
    pub pointless: u64,
}

impl Corners {
    /// Number of faces.
    pub fn faces(&self) -> u32 {
        self.faces
    }

    /// The faces' numbers of corners, if not all are 3.
    pub fn sizes(&self) -> Option<&[u32]> {
        (!self.sizes.is_empty()).then_some(&self.sizes)
    }

    /// Number of triangles that the faces will become.
    pub fn triangles(&self) -> u64 {
        self.v.len() as u64 - 2 * u64::from(self.faces)
    }

    /// Reads the corners of one face and returns their number. A face with fewer than three is read but not kept.
    ///
    /// # Errors
    /// A word that is not a corner, or an index that is out of range.
    #[inline]
    pub fn push_face(
        &mut self,
        words: &mut Words,
        seen: &Counts,
        total: &Counts,
    ) -> Result<usize, ReadError> {
        let first = self.v.len();
        while !words.is_over() {
            self.push_corner(words, seen, total)?;
        }
        let corners = self.v.len() - first;
        if corners < 3 {
            self.v.truncate(first);
            self.vt.truncate(first);
            self.vn.truncate(first);
            return Ok(corners);
        }
        if corners != 3 && self.sizes.is_empty() {
            self.sizes.resize(self.faces as usize, 3);
            self.sizes.push(corners as u32);
        } else if !self.sizes.is_empty() {
            self.sizes.push(corners as u32);
        }
        // A face takes at least seven bytes and a chunk is far below 2^32 bytes.
        self.faces += 1;
        Ok(corners)
    }

    #[inline]
    fn push_corner(&mut self, words: &mut Words, seen: &Counts, total: &Counts) -> Result<(), ReadError> {
        let line = words.rest;
        let Some((v, mut at)) = integer(line) else { return Err(words.expected("a vertex index")) };
        let v = match resolve(v, seen.vertices, total.vertices) {
            Some(v) => v,
            None => return Err(outside(words, ["vertex", "vertices"], total.vertices)),
        };
        let (mut vt, mut vn) = (NONE, NONE);
        if line.get(at) == Some(&b'/') {
            at += 1;
            if let Some((i, len)) = integer(&line[at..]) {
                at += len;
                match resolve(i, seen.texcoords, total.texcoords) {
                    Some(i) => vt = i,
                    None if total.texcoords == 0 => self.pointless += 1,
                    None => {
                        return Err(outside(
                            words,
                            ["texture coordinate", "texture coordinates"],
                            total.texcoords,
                        ));
                    }
                }
            }
            if line.get(at) == Some(&b'/') {
                at += 1;
                if let Some((i, len)) = integer(&line[at..]) {
                    at += len;
                    match resolve(i, seen.normals, total.normals) {
                        Some(i) => vn = i,
                        None if total.normals == 0 => self.pointless += 1,
                        None => return Err(outside(words, ["normal", "normals"], total.normals)),
                    }
                }
            }
        }
        if !ends_word(line.get(at).copied()) {
            return Err(words.expected("a corner such as 1, 1/2, 1//3 or 1/2/3"));
        }
        words.rest = &line[at..];
        push_sparse(&mut self.vt, vt, self.v.len());
        push_sparse(&mut self.vn, vn, self.v.len());
        self.v.push(v);
        Ok(())
    }
}

/// Appends to an array that stays empty as long as all values are [`NONE`].
#[inline]
fn push_sparse(values: &mut Vec<u32>, value: u32, len: usize) {
    if value != NONE && values.len() < len {
        values.resize(len, NONE);
    }
    if value != NONE || !values.is_empty() {
        values.push(value);
    }
}

/// Most indices are short and without a sign; the others are left to the general parser.
#[inline]
fn integer(bytes: &[u8]) -> Option<(i64, usize)> {
    let mut value = 0i64;
    for (n, &byte) in bytes.iter().take(10).enumerate() {
        let digit = byte.wrapping_sub(b'0');
        if digit > 9 {
            return if n > 0 { Some((value, n)) } else { parse_integer(bytes) };
        }
        value = value * 10 + i64::from(digit);
    }
    parse_integer(bytes)
}

/// The vertex number of a word of an `l` or `p` line; what follows a slash is not read.
pub fn vertex_number(word: &[u8], seen: &Counts, total: &Counts) -> Option<u32> {
    let (number, length) = integer(word)?;
    let is_whole = matches!(word.get(length), None | Some(b'/'));
    resolve(number, seen.vertices, total.vertices).filter(|_| is_whole)
}

/// Converts an index of the file (1 is the first, -1 the last before this line) to a zero-based index.
///
/// Indices may refer to elements that follow later in the file: the specification forbids it, but files do it, and it
/// is harmless.
#[inline]
fn resolve(index: i64, seen: u64, total: u64) -> Option<u32> {
    let index = if index < 0 { index.checked_add_unsigned(seen)? } else { index.checked_sub(1)? };
    u64::try_from(index).ok().filter(|&i| i < total).and_then(|i| u32::try_from(i).ok())
}

#[cold]
fn outside(words: &Words, [what, plural]: [&str; 2], total: u64) -> ReadError {
    let range = || format!("a {what} index from 1 to {total}, or below 0 to count from the last one back");
    words.expected(expected_index(what, plural, total, range))
}
