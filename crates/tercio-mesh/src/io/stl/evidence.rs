//! Is it binary STL? The format has no magic bytes, so only the count and the facets themselves are evidence.
//!
//! Decisions:
//! - A count that fits the size of the file is good evidence. It is believed unless most of the sampled facets hold
//!   garbage: coordinates that are not finite, or more than a factor of 2^80 apart, as those of random bytes are, or
//!   of an unusual size (1e-20, 1e20) without a valid normal to confirm them. Facets of zeros do not count.
//! - Where the count does not fit, the facets have to be evidence by themselves: nine in ten of the sampled ones have
//!   different corners, coordinates of similar sizes, and a normal of unit length or that of the corners; or none, if
//!   the sizes are usual. The reader then reports what is wrong with the count.
//! - No facets at all, or only zeros, are a model only if the file ends after them and its header is one line of
//!   text.

use glam::DVec3;

use super::binary::{HEADER, RECORD, Record, count, float, records, vertices};
use crate::io::input::Input;

/// Number of facets that are sampled, evenly over the file.
const SAMPLE: usize = 512;

/// If the file begins with this many facets, it is examined further, whatever the count is. Of a file of another kind
/// only this much is read.
const ROW: usize = 16;

/// 2^-80: a coordinate that is smaller than the largest of its facet by this factor, and not zero, is garbage.
const LEAST: f64 = 1.0 / (1u128 << 80) as f64;

/// Does the file hold exactly the facets that it counts, and are they valid? Then it is binary STL, whatever its
/// header begins with.
pub fn is_beyond_doubt(input: &Input) -> bool {
    let held = records(input.bytes());
    let size = (HEADER + held.len() * RECORD) as u64;
    size == input.bytes().len() as u64
        && count(input.bytes()) == Some(held.len() as u64)
        && are_facets(input, held)
}

/// Does the content look like binary STL, with a right count or a wrong one?
pub fn is_binary(input: &Input) -> bool {
    let bytes = input.bytes();
    let Some(stated) = count(bytes) else { return false };
    let body = bytes.get(HEADER..).unwrap_or_default();
    let held = records(bytes);
    if stated * RECORD as u64 == body.len() as u64 {
        return match share(input, held, is_possible) {
            Some(possible) => 2 * possible >= SCALE,
            None => is_line(bytes.get(..80).unwrap_or_default()),
        };
    }
    // A truncated file holds at least a thousandth of what it should, and where the count itself is broken, valid
    // facets in a row are no coincidence; a count that was never filled in is 0.
    let begins_well = || held.get(..ROW).is_some_and(|row| are_facets(input, row));
    let sensible = (stated / 1000 <= held.len() as u64 || begins_well())
        && (stated > 0 || body.len().is_multiple_of(RECORD));
    // A few facets followed by much else are believed only if that is more facets or zeros.
    let most = 2 * stated >= held.len() as u64;
    let facets = if most { held.len().min(stated as usize) } else { held.len() };
    sensible && are_facets(input, held.get(..facets).unwrap_or_default())
}

/// Are these facets beyond doubt, and at least one?
pub fn are_facets(input: &Input, records: &[Record]) -> bool {
    share(input, records, is_facet).is_some_and(|facets| 10 * facets >= 9 * SCALE)
}

/// The denominator of a [`share`].
const SCALE: usize = 1000;

/// For how many of a thousand records that are not all zeros `is_true` holds, estimated from a sample.
fn share(input: &Input, records: &[Record], is_true: impl Fn(&Record) -> bool) -> Option<usize> {
    let step = records.len().div_ceil(SAMPLE).max(1);
    let (mut sampled, mut found) = (0, 0);
    for record in records.iter().step_by(step) {
        if *record != [0; RECORD] {
            sampled += 1;
            found += usize::from(is_true(record));
        }
        input.looked_at(step * RECORD);
    }
    (sampled > 0).then(|| found * SCALE / sampled)
}

/// A line of printable characters, then zeros up to the end.
fn is_line(header: &[u8]) -> bool {
    let length = header.iter().rposition(|&b| b != 0).map_or(0, |last| last + 1);
    let text = header.get(..length).unwrap_or_default();
    text.iter().all(|b| (b' '..0x7f).contains(b)) && !text.trim_ascii().is_empty()
}

/// Are all coordinates finite and of sizes that one facet can have?
fn is_coherent(corners: &[[f32; 3]; 3]) -> bool {
    let sizes = || corners.as_flattened().iter().map(|x| f64::from(x.abs()));
    let largest = sizes().fold(0.0, f64::max);
    sizes().all(|x| x.is_finite() && (x == 0.0 || x >= largest * LEAST))
}

/// Could this be a facet, with whatever a program may write in place of the normal?
fn is_possible(record: &Record) -> bool {
    let corners = vertices(record);
    is_coherent(&corners) && (is_usual(&corners) || lacks_normal(record) || has_normal(record, &corners))
}

/// Is this a facet with an area and a normal?
fn is_facet(record: &Record) -> bool {
    let corners = vertices(record);
    let [a, b, c] = corners;
    let differ = a != b && b != c && c != a;
    let witnessed = has_normal(record, &corners) || lacks_normal(record) && is_usual(&corners);
    differ && is_coherent(&corners) && witnessed
}

/// Are the coordinates of sizes that nearly all models have?
fn is_usual(corners: &[[f32; 3]; 3]) -> bool {
    corners.as_flattened().iter().all(|&x| x == 0.0 || (1e-20..1e20).contains(&x.abs()))
}

fn normal(record: &Record) -> DVec3 {
    DVec3::from([0, 4, 8].map(|at| f64::from(float(record, at))))
}

/// Programs write zeros where they have no normal, or NaN where the facet has no area.
fn lacks_normal(record: &Record) -> bool {
    let normal = normal(record);
    normal == DVec3::ZERO || normal.is_nan()
}

/// Is the normal of unit length, or that of the corners?
fn has_normal(record: &Record, corners: &[[f32; 3]; 3]) -> bool {
    let [a, b, c] = corners.map(|p| DVec3::from(p.map(f64::from)));
    let (normal, direction) = (normal(record), (b - a).cross(c - a));
    let (length, area) = (normal.length(), direction.length());
    (0.98..1.02).contains(&length)
        || length * area > 0.0 && normal.dot(direction).abs() >= 0.9 * length * area
}
