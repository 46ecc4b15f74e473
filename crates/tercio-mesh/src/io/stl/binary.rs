//! Binary STL: 80 bytes of header, the number of facets, then 50 bytes per facet: normal, three vertices and two
//! bytes that were meant for the length of attributes and today hold a colour or nothing.
//!
//! Decisions for files whose size contradicts their count: after the last facet, zeros and bytes that are not facets
//! are ignored with a warning; fewer facets than the header counts are an error, and so are more, because nobody can
//! know what the file was meant to hold. The error states both numbers.

use crate::loops::prelude::*;
use glam::DVec3;

use crate::error::{Place, counted};
use crate::io::{ReadModel, ReadOptions, ReadReport, input::Input};
use crate::mesh::choose_origin;
use crate::strokes::Strokes;
use crate::{Aabb, Mesh, ReadError};

use super::{check_facets, evidence, soup};

pub(super) const HEADER: usize = 84;
pub(super) const RECORD: usize = 50;

/// A facet as it is stored in the file.
pub(super) type Record = [u8; RECORD];

/// Number of facets that one task reads: about 200 kilobytes.
const BATCH: usize = 1 << 12;

/// The number of facets that the header states.
pub(super) fn count(bytes: &[u8]) -> Option<u64> {
    let field = bytes.get(80..HEADER)?;
    Some(u64::from(u32::from_le_bytes(field.try_into().ok()?)))
}

/// All whole facets that the file has room for.
pub(super) fn records(bytes: &[u8]) -> &[Record] {
    bytes.get(HEADER..).unwrap_or_default().as_chunks::<RECORD>().0
}

/// Reads binary STL.
///
/// # Errors
/// Fewer facets than the header says, too many of them, or too little memory.
pub fn read(input: &Input, options: &ReadOptions) -> Result<ReadModel, ReadError> {
    let bytes = input.bytes();
    let malformed = |place: usize, expected: String, found: String| ReadError::Malformed {
        file: input.name.clone(),
        place: Place::Byte(place as u64),
        expected,
        found,
    };
    let Some(stated) = count(bytes) else {
        let found = counted(bytes.len() as u64, "byte");
        return Err(malformed(bytes.len(), format!("a header of {HEADER} bytes"), found));
    };
    let held = records(bytes);
    let triangles = |n: u64| counted(n, "triangle");
    let Some(records) = held.get(..usize::try_from(stated).unwrap_or(usize::MAX)) else {
        let needed = HEADER as u64 + stated * RECORD as u64;
        let expected = format!("the {} that the header counts ({needed} bytes)", triangles(stated));
        let found = format!("only {} ({} bytes)", triangles(held.len() as u64), bytes.len());
        return Err(malformed(bytes.len(), expected, found));
    };
    let rest = bytes.get(HEADER + records.len() * RECORD..).unwrap_or_default();
    // Bytes after the last whole facet, such as a line feed, do not affect the facets before them.
    let further = input.unpadded(rest).len().div_ceil(RECORD).min(held.len() - records.len());
    if evidence::are_facets(input, held.get(records.len()..records.len() + further).unwrap_or_default()) {
        let fit = (records.len() + further) as u64;
        let expected = format!("a count of {}, as many as fit in the {} bytes", triangles(fit), bytes.len());
        return Err(malformed(80, expected, stated.to_string()));
    }
    let mut warnings = Vec::new();
    if !rest.is_empty() {
        let what = if input.all(rest, |b| b == 0) { "zero byte" } else { "byte" };
        warnings.push(format!("ignored {} after the last triangle", counted(rest.len() as u64, what)));
    }
    check_facets(input, records.len() as u64)?;
    options.check_memory(&input.name, "triangles", input.held_bytes() + records.len() as u64 * 52)?;
    if let Some(p) = options.progress {
        p.begin("parsing", records.len() as u64 * RECORD as u64);
    }

    let coordinates = bounds(input, records);
    let origin = options.origin.unwrap_or_else(|| choose_origin(&coordinates));
    let mut positions = vec![[0.0f32; 3]; records.len() * 3];
    positions.par_chunks_mut(BATCH * 3).zip(records.par_chunks(BATCH)).for_each(|(positions, records)| {
        for (slots, record) in positions.as_chunks_mut::<3>().0.iter_mut().zip(records) {
            *slots = vertices(record);
            if origin != DVec3::ZERO {
                *slots = slots.map(|p| std::array::from_fn(|k| (f64::from(p[k]) - origin[k]) as f32));
            }
        }
        input.consumed(records.len() * RECORD);
        if let Some(p) = options.progress {
            p.advance((records.len() * RECORD) as u64);
        }
    });
    let mesh = Mesh {
        origin,
        positions,
        triangles: soup(records.len()),
        face_colors: colors(input, bytes.get(..80).unwrap_or_default(), records),
        ..Mesh::default()
    };
    let report = ReadReport {
        format: "STL, binary".into(),
        file_bytes: input.file_bytes,
        faces: records.len() as u64,
        warnings,
        ..ReadReport::default()
    };
    Ok(ReadModel { mesh, strokes: Strokes::default(), coordinates, report })
}

/// The number at an offset of a record.
#[inline]
pub(super) fn float(record: &Record, at: usize) -> f32 {
    f32::from_le_bytes([record[at], record[at + 1], record[at + 2], record[at + 3]])
}

/// The three vertices of a record.
#[inline]
pub(super) fn vertices(record: &Record) -> [[f32; 3]; 3] {
    std::array::from_fn(|corner| std::array::from_fn(|k| float(record, 12 + 12 * corner + 4 * k)))
}

/// The default colour that Materialise Magics states in the header.
pub(super) fn default_color(header: &[u8]) -> Option<[u8; 4]> {
    let at = header.windows(6).position(|w| w == b"COLOR=")?;
    Some(header.get(at + 6..at + 10).map_or([255; 4], |c| [c[0], c[1], c[2], c[3]]))
}

/// The colour of a facet whose attribute bytes are zero, if others have colours. With a default colour, zero is black.
pub(super) fn color_of_zero(has_default: bool) -> [u8; 4] {
    if has_default { [0, 0, 0, 255] } else { [255; 4] }
}

fn bounds(input: &Input, records: &[Record]) -> Aabb {
    records
        .par_chunks(BATCH)
        .map(|records| {
            let mut bounds = Aabb::EMPTY;
            for p in records.iter().flat_map(vertices) {
                let p = DVec3::new(p[0].into(), p[1].into(), p[2].into());
                if p.is_finite() {
                    bounds.add(p);
                }
            }
            input.consumed(records.len() * RECORD);
            bounds
        })
        .reduce(|| Aabb::EMPTY, Aabb::union)
}

/// The two bytes after the vertices.
pub(super) fn attribute(record: &Record) -> u16 {
    u16::from_le_bytes([record[RECORD - 2], record[RECORD - 1]])
}

/// Colours in the attribute bytes, if they are there beyond doubt.
///
/// Two incompatible conventions exist. VisCAM and SolidView set bit 15 where a facet has a colour and store blue in
/// the lowest bits. Materialise Magics states a default colour after `COLOR=` in the header, *clears* bit 15 where a
/// facet has its own, and stores red in the lowest bits. Other programs write arbitrary values here.
fn colors(input: &Input, header: &[u8], records: &[Record]) -> Option<Vec<[u8; 4]>> {
    let all = |holds: fn(u16) -> bool| {
        records.par_chunks(BATCH).all(|records| {
            let all = records.iter().all(|r| holds(attribute(r)));
            input.consumed(records.len() * RECORD);
            all
        })
    };
    let spread = |color: &(dyn Fn(u16) -> [u8; 4] + Sync)| {
        let mut colors = vec![[0; 4]; records.len()];
        colors.par_chunks_mut(BATCH).zip(records.par_chunks(BATCH)).for_each(|(colors, records)| {
            colors.iter_mut().zip(records).for_each(|(c, r)| *c = color(attribute(r)));
            input.consumed(records.len() * RECORD);
        });
        colors
    };
    if all(|a| a == 0) {
        return None;
    }
    let five = |a: u16, shift: u32| ((u32::from(a >> shift & 31) * 255 + 15) / 31) as u8;
    if let Some(default) = default_color(header) {
        let color = |a| if a & 0x8000 != 0 { default } else { [five(a, 0), five(a, 5), five(a, 10), 255] };
        return Some(spread(&color));
    }
    // A value that is neither zero nor marked as a colour shows that the bytes have another meaning.
    let has_meaning = all(|a| a == 0 || a & 0x8000 != 0);
    let color = |a| if a == 0 { color_of_zero(false) } else { [five(a, 10), five(a, 5), five(a, 0), 255] };
    has_meaning.then(|| spread(&color))
}
