//! PCD, the point clouds of the Point Cloud Library: ASCII, binary, and compressed binary.
//!
//! A header names the fields of a point. Binary points are rows, little-endian; compressed ones are columns, one field
//! after the other, in the format of liblzf. Points become [strokes](crate::strokes): `x`, `y`, `z` their positions,
//! `rgb` or `rgba` their colours, all other fields attributes.
//!
//! Source: "The PCD (Point Cloud Data) file format", pointclouds.org.

mod body;
mod header;
mod lzf;

use super::{ReadModel, ReadOptions, ReadReport, input::Input, obj::transcode};
use crate::doubles::{Doubles, stored};
use crate::mesh::{MAX_ELEMENTS, localize_at};
use crate::strokes::Strokes;
use crate::{Attribute, Mesh, ReadError};
use body::Body;
use header::Header;

/// How much of a file is examined for detecting the format.
const FRONT: usize = 4096;

/// Does the content look like PCD? Lines for version, fields and sizes come first, after comments.
pub fn looks_like(bytes: &[u8]) -> bool {
    let front = transcode::front(bytes, FRONT);
    let mut lines = front.split(|&b| b == b'\n').map(<[u8]>::trim_ascii);
    let mut next = || lines.find(|line| !line.is_empty() && !line.starts_with(b"#"));
    let is = |line: Option<&[u8]>, word: &[u8]| {
        line.and_then(|l| l.strip_prefix(word)).and_then(<[u8]>::first).is_some_and(u8::is_ascii_whitespace)
    };
    is(next(), b"VERSION") && is(next(), b"FIELDS") && is(next(), b"SIZE")
}

/// Reads PCD.
///
/// # Errors
/// Any [`ReadError`].
pub fn read(input: &Input, options: &ReadOptions) -> Result<ReadModel, ReadError> {
    let header = Header::parse(input)?;
    let count = header.points;
    if count > MAX_ELEMENTS {
        return Err(ReadError::TooMany { file: input.name.clone(), what: "points", count });
    }
    // Before the points: with them a point has at least three numbers, and the bytes of the file limit their number.
    let axes = [header.axis(input, "x")?, header.axis(input, "y")?, header.axis(input, "z")?];
    let values: u64 = header.fields.iter().map(|f| f.count as u64).sum();
    // The body is checked against the bytes of the file first, so that this is not larger than these are.
    let body = Body::open(input, options, &header)?;
    let held = input.held_bytes().saturating_add(body.held());
    let names: u64 = header.fields.iter().map(|f| Attribute::bytes_of_names(&f.name, f.count)).sum();
    options.check_memory(
        &input.name,
        "its points",
        held.saturating_add(count.saturating_mul(48 + 4 * values)).saturating_add(names),
    )?;
    if let Some(progress) = options.progress {
        progress.begin("reading points", header.fields.len() as u64);
    }
    let [x, y, z] = axes.map(|field| body.column(&header, field, 0));
    let points: Vec<[f64; 3]> = x.zip(y).zip(z).map(|((x, y), z)| [x, y, z]).collect();
    let (coordinates, origin, positions) = localize_at(&points, options.origin);
    drop(points);
    let mut strokes =
        Strokes { origin, positions, points: (0..count as u32).collect(), ..Strokes::default() };
    let mut warnings = Vec::new();
    for (number, field) in header.fields.iter().enumerate() {
        if field.name == "rgb" || field.name == "rgba" {
            strokes.colors = Some(body.colors(&header, number).map(Some).collect());
        } else if !matches!(field.name.as_str(), "x" | "y" | "z" | "_") {
            for component in 0..field.count {
                let name = Attribute::component_name(&field.name, component, field.count);
                let column = || body.column(&header, number, component);
                let doubles = column().fold(Doubles::default(), Doubles::with);
                warnings.extend(doubles.warning(&name, field.kind != b'F'));
                let offset = doubles.offset();
                let values = column().map(|value| stored(value, offset)).collect();
                let domain = crate::AttributeDomain::Vertex;
                strokes.attributes.push(Attribute { name, domain, values, offset, component: None });
            }
        }
        if let Some(progress) = options.progress {
            progress.advance(1);
        }
    }
    let format = format!("PCD, {}", header.data.name());
    let mut report = ReadReport { format, warnings, ..ReadReport::default() };
    report.not_drawn.points = count;
    let mesh = Mesh { origin, ..Mesh::default() };
    Ok(ReadModel { mesh, strokes, coordinates, report })
}
