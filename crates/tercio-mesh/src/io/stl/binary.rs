//! Binary STL: 80 bytes of header, the number of facets, then 50 bytes a facet: normal, three vertices and
//! two bytes that were meant for the length of attributes and today hold a colour or nothing.
//!
//! What was decided where files disagree with their size: bytes behind the last facet are ignored with a
//! warning; fewer facets than the header says are an error; a count of 0 before whole facets is taken as one
//! that was never filled in, and all facets are read, with a warning.

use glam::DVec3;
use rayon::prelude::*;

use crate::error::Place;
use crate::io::{ReadModel, ReadOptions, ReadReport, input::Input};
use crate::mesh::choose_origin;
use crate::{Aabb, Mesh, ReadError};

use super::{check_facets, soup};

const HEADER: usize = 84;
const RECORD: usize = 50;

/// Facets that one task reads: about 200 kilobytes.
const BATCH: usize = 1 << 12;

fn count(bytes: &[u8]) -> Option<u64> {
    let field = bytes.get(80..HEADER)?;
    Some(u64::from(u32::from_le_bytes(field.try_into().ok()?)))
}

/// True if the size is that of the number of facets in the header.
pub fn has_exact_size(bytes: &[u8]) -> bool {
    count(bytes).is_some_and(|n| bytes.len() as u64 == HEADER as u64 + n * RECORD as u64)
}

/// True if the file is long enough for a header.
pub fn has_header(bytes: &[u8]) -> bool {
    bytes.len() >= HEADER
}

/// For files whose size is wrong: true if the count and the first facet look like those of a binary STL file,
/// so that a damaged file is told to be one, and no other file is taken for one.
pub fn is_plausible(bytes: &[u8]) -> bool {
    let (Some(n), Some(&first)) = (count(bytes), records(bytes).first()) else { return false };
    let facets_held = (bytes.len() - HEADER) / RECORD;
    // A truncated file holds no less than a thousandth of what it should, a count never filled in is 0.
    let sensible = match n {
        0 => (bytes.len() - HEADER).is_multiple_of(RECORD),
        _ => n / 1000 <= facets_held as u64,
    };
    let usual = |x: f32| x == 0.0 || (1e-20..1e20).contains(&x.abs());
    let floats = first.as_chunks::<4>().0.iter().map(|&f| f32::from_le_bytes(f));
    // The first bytes of some other binary formats; their content could look like floats.
    let is_other = [&b"\x89PNG"[..], b"PK\x03\x04", b"glTF", b"\x7fELF", b"Kaydara", b"%PDF"]
        .iter()
        .any(|magic| bytes.starts_with(magic));
    sensible && !is_other && floats.clone().all(usual) && floats.skip(3).any(|x| x != 0.0)
}

fn records(bytes: &[u8]) -> &[[u8; RECORD]] {
    bytes.get(HEADER..).unwrap_or_default().as_chunks::<RECORD>().0
}

/// Reads binary STL.
///
/// # Errors
/// Fewer facets than the header says, too many of them, or too little memory.
pub fn read(input: &Input, options: &ReadOptions) -> Result<ReadModel, ReadError> {
    let bytes = input.bytes();
    let malformed = |expected: String, found: String| ReadError::Malformed {
        file: input.name.clone(),
        place: Place::Byte(bytes.len() as u64),
        expected,
        found,
    };
    let Some(stated) = count(bytes) else {
        return Err(malformed(format!("a header of {HEADER} bytes"), format!("{} bytes", bytes.len())));
    };
    let held = records(bytes);
    let extra = bytes.len() as i128 - HEADER as i128 - i128::from(stated) * RECORD as i128;
    let mut warnings = Vec::new();
    let records = match held.get(..usize::try_from(stated).unwrap_or(usize::MAX)) {
        _ if stated == 0 && extra > 0 && extra as usize == held.len() * RECORD => {
            warnings.push(format!("read {} triangles, although the header says 0", held.len()));
            held
        }
        Some(records) => {
            if extra > 0 {
                warnings.push(format!("ignored {extra} bytes behind the last triangle"));
            }
            records
        }
        None => {
            return Err(malformed(
                format!("{stated} triangles ({} bytes)", HEADER as u64 + stated * RECORD as u64),
                format!("{} triangles ({} bytes)", held.len(), bytes.len()),
            ));
        }
    };
    check_facets(input, records.len() as u64)?;
    options.check_memory(&input.name, "triangles", input.held_bytes() + records.len() as u64 * 52)?;
    if let Some(p) = options.progress {
        p.begin("parsing", records.len() as u64 * RECORD as u64);
    }

    let origin = choose_origin(&bounds(input, records));
    let mut positions = vec![[0.0f32; 3]; records.len() * 3];
    positions.par_chunks_mut(BATCH * 3).zip(records.par_chunks(BATCH)).for_each(|(positions, records)| {
        for (slots, record) in positions.as_chunks_mut::<3>().0.iter_mut().zip(records) {
            *slots = vertices(record);
            if origin != DVec3::ZERO {
                *slots = slots.map(|p| std::array::from_fn(|k| (f64::from(p[k]) - origin[k]) as f32));
            }
        }
        input.was_read(records.len() * RECORD);
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
        ignored_points_and_lines: 0,
        warnings,
    };
    Ok(ReadModel { mesh, report })
}

/// The three vertices of a record.
#[inline]
fn vertices(record: &[u8; RECORD]) -> [[f32; 3]; 3] {
    let float = |i: usize| f32::from_le_bytes([record[i], record[i + 1], record[i + 2], record[i + 3]]);
    std::array::from_fn(|corner| std::array::from_fn(|k| float(12 + 12 * corner + 4 * k)))
}

fn bounds(input: &Input, records: &[[u8; RECORD]]) -> Aabb {
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
            input.was_read(records.len() * RECORD);
            bounds
        })
        .reduce(|| Aabb::EMPTY, Aabb::union)
}

/// Colours in the attribute bytes, if they are there beyond doubt.
///
/// Two incompatible ways exist. VisCAM and SolidView set bit 15 where a facet has a colour and store blue in
/// the lowest bits. Materialise Magics states a default colour behind `COLOR=` in the header, *clears* bit 15
/// where a facet has its own, and stores red in the lowest bits. Other programs leave anything here.
fn colors(input: &Input, header: &[u8], records: &[[u8; RECORD]]) -> Option<Vec<[u8; 4]>> {
    let attribute = |r: &[u8; RECORD]| u16::from_le_bytes([r[RECORD - 2], r[RECORD - 1]]);
    let all = |holds: fn(u16) -> bool| {
        records.par_chunks(BATCH).all(|records| {
            let all = records.iter().all(|r| holds(attribute(r)));
            input.was_read(records.len() * RECORD);
            all
        })
    };
    let spread = |color: &(dyn Fn(u16) -> [u8; 4] + Sync)| {
        let mut colors = vec![[0; 4]; records.len()];
        colors.par_chunks_mut(BATCH).zip(records.par_chunks(BATCH)).for_each(|(colors, records)| {
            colors.iter_mut().zip(records).for_each(|(c, r)| *c = color(attribute(r)));
            input.was_read(records.len() * RECORD);
        });
        colors
    };
    if all(|a| a == 0) {
        return None;
    }
    let five = |a: u16, shift: u32| ((u32::from(a >> shift & 31) * 255 + 15) / 31) as u8;
    if let Some(at) = header.windows(6).position(|w| w == b"COLOR=") {
        let default = match header.get(at + 6..at + 10) {
            Some(&[r, g, b, a]) => [r, g, b, a],
            _ => [255; 4],
        };
        let color = |a| if a & 0x8000 != 0 { default } else { [five(a, 0), five(a, 5), five(a, 10), 255] };
        return Some(spread(&color));
    }
    // A value that is neither empty nor marked as a colour shows that the bytes mean something else.
    let has_meaning = all(|a| a == 0 || a & 0x8000 != 0);
    let color = |a| if a == 0 { [255; 4] } else { [five(a, 10), five(a, 5), five(a, 0), 255] };
    has_meaning.then(|| spread(&color))
}
