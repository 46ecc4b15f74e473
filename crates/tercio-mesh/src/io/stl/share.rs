//! Ranges of the facets of a binary STL file.

use std::ops::Range;

use super::binary::{self, HEADER, RECORD, Record, attribute, count, records};
use super::{Dialect, dialect};
use crate::ReadError;
use crate::error::Place;
use crate::io::input::Input;
use crate::io::share::refusal;
use crate::io::{ReadModel, ReadOptions};

/// Reads a share, whatever its facets look like.
///
/// # Errors
/// Any [`ReadError`].
pub(in crate::io) fn read(input: &Input, options: &ReadOptions) -> Result<ReadModel, ReadError> {
    binary::read(input, options)
}

/// The facets of a file.
pub(in crate::io) struct Facets<'a> {
    input: &'a Input,
    records: &'a [Record],
}

/// All attribute bytes are zero.
const ZERO: u64 = 1;
/// All attribute bytes are zero, or marked as a colour.
const COLOR: u64 = 2;

impl<'a> Facets<'a> {
    /// The facets, if the file is binary and has exactly those that its head counts.
    pub fn open(input: &'a Input) -> Result<Self, ReadError> {
        if dialect(input) != Some(Dialect::Binary) {
            return Err(refusal(input, "an ASCII STL file"));
        }
        let (bytes, records) = (input.bytes(), records(input.bytes()));
        let stated = count(bytes).unwrap_or_default();
        let needed = HEADER as u64 + stated * RECORD as u64;
        if needed != bytes.len() as u64 {
            return Err(ReadError::Malformed {
                file: input.name.clone(),
                place: Place::Byte(80),
                expected: format!("{needed} bytes for the {stated} triangles that the header counts"),
                found: format!("{} bytes", bytes.len()),
            });
        }
        Ok(Self { input, records })
    }

    pub fn count(&self) -> usize {
        self.records.len()
    }

    /// Which rules the attribute bytes follow.
    pub fn marks(&self, range: &Range<usize>) -> u64 {
        let all = |holds: fn(u16) -> bool| self.records[range.clone()].iter().all(|r| holds(attribute(r)));
        let zero = if all(|a| a == 0) { ZERO } else { 0 };
        let color = if all(|a| a == 0 || a & 0x8000 != 0) { COLOR } else { 0 };
        zero | color
    }

    /// The colour of all of some facets, if their attribute bytes say nothing, but those of others are colours. `marks` are those
    /// of all facets.
    pub fn plain_color(&self, range: &Range<usize>, marks: u64) -> Option<[u8; 4]> {
        let has_colors = marks & ZERO == 0 && (self.has_default() || marks & COLOR > 0);
        let plain = binary::color_of_zero(self.has_default());
        (has_colors && self.marks(range) & ZERO > 0).then_some(plain)
    }

    fn has_default(&self) -> bool {
        binary::default_color(self.input.bytes().get(..80).unwrap_or_default()).is_some()
    }

    /// A file of some facets. Attribute bytes that are no colours are left out.
    pub fn take(
        &self,
        range: &Range<usize>,
        marks: u64,
        options: &ReadOptions,
    ) -> Result<Vec<u8>, ReadError> {
        let records = &self.records[range.clone()];
        let bytes = HEADER + size_of_val(records);
        options.check_memory(&self.input.name, "a part of the triangles", bytes as u64)?;
        let head = self.input.bytes().get(..80).unwrap_or_default();
        let mut out = Vec::with_capacity(bytes);
        out.extend_from_slice(head);
        out.extend_from_slice(&(records.len() as u32).to_le_bytes());
        out.extend_from_slice(records.as_flattened());
        self.input.finished(records.as_flattened());
        if marks & ZERO == 0 && marks & COLOR == 0 && !self.has_default() {
            let (copies, _) = out[HEADER..].as_chunks_mut::<RECORD>();
            copies.iter_mut().for_each(|record| record[RECORD - 2..].fill(0));
        }
        Ok(out)
    }
}
