//! STL (stereolithography), ASCII and binary: a soup of triangles.
//!
//! Every facet has its own three vertices; joining them is left to the caller. Facet normals are not read: they say
//! no more than the vertices do, and often less.
//!
//! Source: 3D Systems, "StereoLithography Interface Specification" (1989), as programs write it today.

mod ascii;
mod binary;
mod evidence;
pub(super) mod share;

pub use evidence::is_beyond_doubt;

use crate::ReadError;
use crate::mesh::MAX_ELEMENTS;

use super::obj::transcode;
use super::{ReadModel, ReadOptions, input::Input};

/// How much of a file is examined for detecting the format.
const FRONT: usize = 1 << 16;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Dialect {
    Ascii,
    Binary,
}

/// Does the content look like STL?
pub fn looks_like(input: &Input) -> bool {
    dialect(input).is_some()
}

/// The word `solid` is weak evidence: binary files begin with it too, so the facets are tested first.
fn dialect(input: &Input) -> Option<Dialect> {
    if evidence::is_binary(input) {
        return Some(Dialect::Binary);
    }
    let text = transcode::front(input.bytes(), FRONT);
    is_ascii(&text).then_some(Dialect::Ascii)
}

/// The word `solid` comes first, or first in the second line; it is followed by facets or the end of the solid.
fn is_ascii(text: &[u8]) -> bool {
    fn words(text: &[u8]) -> impl Iterator<Item = &[u8]> {
        text.split(u8::is_ascii_whitespace).filter(|w| !w.is_empty())
    }
    let is_solid = |text: &[u8]| words(text).next().is_some_and(|w| w.eq_ignore_ascii_case(b"solid"));
    let mut text = text.trim_ascii_start();
    if !is_solid(text) {
        let line = text.iter().position(|&b| b == b'\n').unwrap_or(text.len());
        text = text.get(line..).unwrap_or_default();
    }
    let mut before: &[u8] = b"";
    is_solid(text)
        && words(text).any(|word| {
            let facet = before.eq_ignore_ascii_case(b"facet") && word.eq_ignore_ascii_case(b"normal");
            before = word;
            facet || word.eq_ignore_ascii_case(b"endsolid")
        })
}

/// Reads STL.
///
/// # Errors
/// Any [`ReadError`].
pub fn read(input: &Input, options: &ReadOptions) -> Result<ReadModel, ReadError> {
    match dialect(input) {
        Some(Dialect::Binary) => binary::read(input, options),
        _ => ascii::read(input, options),
    }
}

/// Checks that the vertices, three per facet, can be numbered.
fn check_facets(input: &Input, facets: u64) -> Result<(), ReadError> {
    let count = facets.saturating_mul(3);
    if count > MAX_ELEMENTS {
        return Err(ReadError::TooMany { file: input.name.clone(), what: "vertices", count });
    }
    Ok(())
}

/// Triangle i has the vertices 3i, 3i + 1, 3i + 2.
fn soup(facets: usize) -> Vec<[u32; 3]> {
    (0..facets as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect()
}

#[cfg(test)]
mod tests;
