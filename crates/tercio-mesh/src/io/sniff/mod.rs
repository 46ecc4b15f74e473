//! Detects the format of a file by its content alone.
//!
//! The rule: a file of another kind is never taken for a model, and a model is not rejected for what somebody put
//! around it. So each format requires evidence from more than its first bytes ([`super::stl`] examines facets,
//! [`super::obj`] statements), and a byte order mark, blank lines, one extra line in front, and zeros at the end are
//! skipped with a warning.
//!
//! The header of a binary STL file may hold anything, including the signatures of other formats. So a file that
//! consists of exactly the facets that it counts is STL before any other test.
//!
//! Formats that are known but not read are named in the error. `magic` recognises them by bytes that no text holds,
//! so it is tried before the readers; `words` recognises them by words that could also be the name in the header of a
//! binary STL file with a wrong count, so it is tried last.

mod magic;
#[cfg(test)]
mod tests;
mod words;

use super::input::Input;
use super::{Format, las, obj, off, pcd, ply, stl, vtk, xyz};
use crate::ReadError;
use crate::error::printable;

/// Detects the format; `None` for a file that is not supported.
pub fn sniff(input: &Input) -> Option<Format> {
    let bytes = input.bytes();
    if stl::is_beyond_doubt(input) {
        Some(Format::Stl)
    } else if vtk::looks_like_legacy(bytes) {
        Some(Format::Vtk)
    } else if vtk::looks_like_xml(bytes) {
        Some(Format::VtkXml)
    } else if pcd::looks_like(bytes) {
        Some(Format::Pcd)
    } else if las::looks_like(bytes) {
        Some(Format::Las)
    } else if magic::name(bytes).is_some() || words::comment_name(bytes).is_some() {
        None
    } else if ply::looks_like(input) {
        Some(Format::Ply)
    } else if off::looks_like(bytes) {
        Some(Format::Off)
    } else if stl::looks_like(input) {
        Some(Format::Stl)
    } else if obj::looks_like(input) {
        Some(Format::Obj)
    } else if words::name(bytes).is_none() && xyz::looks_like(input) {
        Some(Format::Xyz)
    } else {
        None
    }
}

/// The error that says what an unsupported file is.
pub(super) fn refusal(input: &Input) -> ReadError {
    let bytes = input.bytes();
    let file = input.name.clone();
    if bytes.is_empty() {
        let what = if input.file_bytes == 0 { "" } else { ": the gzip data holds nothing" };
        return ReadError::Empty { file, what };
    }
    let known = magic::name(bytes).or_else(|| words::comment_name(bytes)).or_else(|| words::name(bytes));
    if let Some(what) = known {
        return ReadError::Unread { file, what };
    }
    if let Some(but) = nothing_but(input) {
        return ReadError::HoldsNothing { file, but };
    }
    ReadError::UnknownFormat { file, begins: printable(&bytes[..bytes.len().min(24)]) }
}

/// What a file without any information holds.
fn nothing_but(input: &Input) -> Option<&'static str> {
    if obj::transcode::without_mark(input.bytes()).is_some_and(<[u8]>::is_empty) {
        Some("a byte order mark")
    } else if input.all(input.bytes(), |b| b == 0) {
        Some("zeros")
    } else if input.all(input.bytes(), |b| b.is_ascii_whitespace() || b == 0) {
        Some("white space")
    } else {
        obj::holds_nothing_but(input)
    }
}
