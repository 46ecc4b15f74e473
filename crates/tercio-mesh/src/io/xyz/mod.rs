//! Point clouds as text: XYZ, TXT, ASC, CSV and PTS.
//!
//! A point a line; its numbers are separated by blanks, tabs, commas or semicolons. Empty lines and those that begin with `#` or
//! `//` are skipped. A first line with the single number of the points (PTS) is checked against them. A first line of names, also
//! behind `#` or `//`, says what the columns are: `x`, `y`, `z`; `r`, `g`, `b` (`red`, `green`, `blue`) and `a` (`alpha`); all
//! others are attributes of these names. Capital letters do not matter for these.
//!
//! Without names, the first three columns are the position. Three further columns of whole numbers from 0 to 255 are
//! colours: the fourth to sixth, or, if there are seven as in PTS, the last three. Three columns behind colours, or behind the
//! position of six, are the components of `normal` if none is greater than 1. A column left over is `value`, several are
//! `value:0`, `value:1` and so on.
//!
//! An empty field between commas, semicolons or tabs is no number (NaN); a point without a coordinate is counted and not drawn.
//! Without a line of names or a number of points before it, the first point has to have all three.
//!
//! Points become [strokes](crate::strokes). The text is parsed in parallel, in pieces of whole lines.

mod columns;
mod front;
mod parse;

use super::obj::transcode;
use super::{ReadModel, ReadOptions, ReadReport, input::Input};
use crate::error::{Place, counted};
use crate::mesh::{MAX_ELEMENTS, localize_at};
use crate::strokes::Strokes;
use crate::{Mesh, ReadError};
use front::Front;

/// Does the content look like a point cloud? Every line of its front has as many numbers as the others, three at least; there are
/// three such lines, or a line before them that says what or how many they are. After ten of them, or such a line before, another
/// line is an error in a cloud.
pub fn looks_like(input: &Input) -> bool {
    Front::of(&transcode::front(input.bytes(), front::FRONT), input.bytes().len() > front::FRONT).is_some()
}

/// Reads a text cloud.
///
/// # Errors
/// Any [`ReadError`].
pub fn read(input: &Input, options: &ReadOptions) -> Result<ReadModel, ReadError> {
    let mut report = ReadReport::default();
    let text = transcode::text(input, options, &mut report.warnings)?;
    let Some(front) = Front::of(&text, false) else {
        return Err(ReadError::Malformed {
            file: input.name.clone(),
            place: Place::File,
            expected: "lines of as many numbers each, at least three".into(),
            found: "other text".into(),
        });
    };
    if let Some(progress) = options.progress {
        progress.begin("reading points", text.len() as u64);
    }
    let table = parse::all(input, options, &text, &front)?;
    let count = table.points.len() as u64;
    if count > MAX_ELEMENTS {
        return Err(ReadError::TooMany { file: input.name.clone(), what: "points", count });
    }
    match front.count {
        Some(announced) if announced > count => {
            return Err(ReadError::Malformed {
                file: input.name.clone(),
                place: Place::File,
                expected: counted(announced, "point"),
                found: format!("{count} of them"),
            });
        }
        Some(announced) if announced < count => report
            .warnings
            .push(format!("the first line announces {}, there are {count}", counted(announced, "point"))),
        _ => {}
    }
    let left_out: Vec<&str> = front.left_out().collect();
    if !left_out.is_empty() {
        report.warnings.push(format!("left out columns that are not numbers: {}", left_out.join(", ")));
    }
    let (coordinates, origin, positions) = localize_at(&table.points, options.origin);
    let (colors, attributes) = columns::meaning(&front, table.columns, &mut report.warnings);
    let points = (0..count as u32).collect();
    let strokes = Strokes { origin, positions, colors, attributes, points, ..Strokes::default() };
    report.format = format!("text point cloud, {}", front.delimiter.name());
    report.not_drawn.points = count;
    let mesh = Mesh { origin, ..Mesh::default() };
    Ok(ReadModel { mesh, strokes, coordinates, report })
}
