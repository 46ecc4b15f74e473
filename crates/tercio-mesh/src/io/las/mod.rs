//! LAS and LAZ, the point clouds of laser scanners, versions 1.0 to 1.4.
//!
//! Points become [strokes](crate::strokes): positions with the scale and the offset of the file, in `f64`, then relative to the
//! origin of the mesh; colours, which have 16 bits, or 8 in files in which none is above 255; and the attributes `intensity`,
//! `return_number`, `number_of_returns`, `classification`, `point_source_id`, `gps_time` (with an
//! [offset](crate::Attribute::offset)) and `nir`, as far as the format of the points has them. Extra bytes that the record EXTRA_BYTES
//! describes are attributes by its names, with their scale and offset, and NaN where a point has the value for no data; those of two
//! or three values, which the specification no longer has, are `NAME:0`, `NAME:1` and so on. Waveforms and other extra bytes are left
//! out. LAZ is decompressed by the crate `laz`, chunk by chunk in parallel.
//!
//! Source: ASPRS, "LAS Specification 1.4 - R15" (2019).

mod columns;
mod extra;
mod header;
mod packed;
mod skipped;
#[cfg(test)]
mod tests;

use crate::loops::prelude::*;

use super::{ReadModel, ReadOptions, ReadReport, input::Input};
use crate::error::{Place, counted};
use crate::mesh::{MAX_ELEMENTS, localize_at};
use crate::strokes::Strokes;
use crate::{Mesh, ReadError};
use columns::Columns;
use header::Header;

/// Points that are handled at a time.
const PIECE: usize = 1 << 16;

/// Does the content look like LAS or LAZ?
pub fn looks_like(bytes: &[u8]) -> bool {
    Header::is_at(bytes)
}

/// Reads LAS or LAZ.
///
/// # Errors
/// Any [`ReadError`].
pub fn read(input: &Input, options: &ReadOptions) -> Result<ReadModel, ReadError> {
    let header = Header::parse(input)?;
    let count = header.points;
    if count > MAX_ELEMENTS {
        return Err(ReadError::TooMany { file: input.name.clone(), what: "points", count });
    }
    let mut columns = Columns::new(&header);
    let each = 24 + 12 + 4 + columns.bytes_of_a_point();
    let pieces = (rayon::current_num_threads() * 4 * PIECE) as u64 * (header.record as u64 + each);
    let tables = if header.is_packed { packed::bytes_of_tables(&header) } else { 0 };
    let needed = count
        .saturating_mul(each)
        .saturating_add(pieces.min(count.saturating_mul(each)))
        .saturating_add(tables);
    options.check_memory(&input.name, "its points", input.held_bytes().saturating_add(needed))?;
    if let Some(progress) = options.progress {
        progress.begin("reading points", count);
    }
    let advance = |points: usize| {
        if let Some(progress) = options.progress {
            progress.advance(points as u64);
        }
    };
    if header.is_packed {
        packed::read(input, &header, &mut columns, advance)?;
    } else {
        plain(input, &header, &mut columns, advance)?;
    }
    let points = columns.points();
    let (coordinates, origin, positions) = localize_at(&points, options.origin);
    drop(points);
    let colors = columns.colors();
    let (attributes, warnings) = columns.attributes();
    let strokes = Strokes {
        origin,
        positions,
        colors,
        attributes,
        points: (0..count as u32).collect(),
        ..Strokes::default()
    };
    let mut report = ReadReport { format: header.name(), warnings, ..ReadReport::default() };
    report.not_drawn.points = count;
    if let Some((at, expected, found)) = &header.extra.mistake {
        report.warnings.push(format!(
            "byte {at}: expected {expected}, found {found}: extra bytes that this and what follows describe are left out"
        ));
    }
    let extra = header.layout.extra(header.record).unwrap_or(0).saturating_sub(header.extra.bytes());
    if extra > 0 {
        report.warnings.push(format!("left out {} of every point", counted(extra as u64, "extra byte")));
    }
    let mesh = Mesh { origin, ..Mesh::default() };
    Ok(ReadModel { mesh, strokes, coordinates, report })
}

/// Points that are not compressed.
fn plain<'a>(
    input: &Input,
    header: &'a Header,
    columns: &mut Columns<'a>,
    advance: impl Fn(usize) + Sync,
) -> Result<(), ReadError> {
    let rest = input.bytes().get(header.begin..).unwrap_or_default();
    let needed = header.points.saturating_mul(header.record as u64);
    let Some(bytes) = usize::try_from(needed).ok().and_then(|needed| rest.get(..needed)) else {
        return Err(ReadError::Malformed {
            file: input.name.clone(),
            place: Place::Byte(header.begin as u64),
            expected: format!("{} in {needed} bytes", counted(header.points, "point")),
            found: format!("{} of them", counted(rest.len() as u64, "byte")),
        });
    };
    let group = rayon::current_num_threads() * 4 * PIECE * header.record;
    for group in bytes.chunks(group.max(1)) {
        let read = |records: &[u8]| {
            let mut own = Columns::new(header);
            records.chunks_exact(header.record).for_each(|record| own.add(record));
            input.consumed(records.len());
            advance(records.len() / header.record);
            own
        };
        let pieces: Vec<Columns> = group.par_chunks(PIECE * header.record).map(read).collect();
        pieces.into_iter().for_each(|piece| columns.append(piece));
    }
    Ok(())
}
