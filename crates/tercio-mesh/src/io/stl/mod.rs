//! STL (stereolithography), ASCII and binary: a soup of triangles.
//!
//! Every facet brings its own three vertices; joining them is left to the caller. Facet normals are not
//! read: they say no more than the vertices do, and often less.
//!
//! Source: 3D Systems, "StereoLithography Interface Specification" (1989), as programs write it today.

mod ascii;
mod binary;

use crate::ReadError;
use crate::mesh::MAX_ELEMENTS;

use super::obj::transcode;
use super::{ReadModel, ReadOptions, input::Input};

/// How much of a file is looked at to find out what it is.
const FRONT: usize = 1 << 16;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Dialect {
    Ascii,
    Binary,
}

/// Does the content look like STL?
pub fn looks_like(bytes: &[u8]) -> bool {
    dialect(bytes).is_some()
}

/// The word `solid` means little: binary files begin with it too, so the size is asked first.
fn dialect(bytes: &[u8]) -> Option<Dialect> {
    if binary::has_exact_size(bytes) {
        return Some(Dialect::Binary);
    }
    let text = transcode::front(bytes, FRONT);
    let mut words = text.split(u8::is_ascii_whitespace).filter(|w| !w.is_empty());
    if words.next().is_some_and(|w| w.eq_ignore_ascii_case(b"solid")) {
        let has_structure =
            words.any(|w| [&b"facet"[..], b"endsolid"].iter().any(|k| w.eq_ignore_ascii_case(k)));
        // Names may be in any 8-bit code; zeros are in no text but in the header of nearly every binary file.
        return match has_structure {
            true => Some(Dialect::Ascii),
            false => (binary::has_header(bytes) && text.contains(&0)).then_some(Dialect::Binary),
        };
    }
    binary::is_plausible(bytes).then_some(Dialect::Binary)
}

/// Reads STL.
///
/// # Errors
/// Any [`ReadError`].
pub fn read(input: &Input, options: &ReadOptions) -> Result<ReadModel, ReadError> {
    match dialect(input.bytes()) {
        Some(Dialect::Binary) => binary::read(input, options),
        _ => ascii::read(input, options),
    }
}

/// Vertices are numbered, three a facet.
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
