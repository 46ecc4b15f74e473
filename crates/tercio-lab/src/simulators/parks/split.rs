//! A splitter's work on one polygon: clipping it to a chunk (document 002, section 3.1).
//!
//! A chunk's piece is the part of the polygon in its columns and between its first and last line. Its pixels are
//! exactly the polygon's pixels there, so that chunks together draw what one processor draws. Its corners are those of
//! the clipped polygon, moved to the pixels in which they lie; corners that coincide are merged.

use super::polygon::{Polygon, Span, crossing};
use crate::workloads::PixelBox;

/// The part of a polygon in a chunk.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Piece {
    /// Number of corners.
    pub vertices: u32,
    /// Its lines, the lowest first.
    pub spans: Vec<Span>,
}

/// Clips a polygon; `None` if it has no pixel in the chunk.
pub fn clip(polygon: &Polygon, chunk: &PixelBox) -> Option<Piece> {
    let [low, high] = polygon.lines();
    let lines = low.max(chunk.y0)..=high.min(chunk.y1);
    let spans: Vec<Span> = lines
        .filter_map(|y| polygon.span(y))
        .map(|s| Span { first: s.first.max(chunk.x0), last: s.last.min(chunk.x1), ..s })
        .filter(|s| s.first <= s.last)
        .collect();
    (!spans.is_empty()).then(|| Piece { vertices: vertices(polygon, chunk), spans })
}

/// Number of corners of the clipped polygon.
fn vertices(polygon: &Polygon, chunk: &PixelBox) -> u32 {
    let &PixelBox { x0, y0, x1, y1 } = chunk;
    let inside = |&[x, y]: &[i32; 2]| (x0..=x1).contains(&x) && (y0..=y1).contains(&y);
    let own = polygon.corners().iter().filter(|c| inside(c)).count();
    if own == polygon.corners().len() {
        return own as u32;
    }
    let mut found: Vec<[i32; 2]> = polygon.corners().iter().copied().filter(inside).collect();
    let mut add = |corner: [i32; 2]| {
        if !found.contains(&corner) {
            found.push(corner);
        }
    };
    // A chunk's columns end where the next pixel begins; corners of that cut are in its last column.
    let columns = [(x0, x0), (x1 + 1, x1)];
    for (a, b) in polygon.sides() {
        for (border, column) in columns {
            if (a[0] < border) != (b[0] < border) {
                let y = crossing(a, b, 0, border);
                if y.at_least(y0) && y.at_most(y1) {
                    add([column, y.floor()]);
                }
            }
        }
        for line in [y0, y1] {
            if (a[1] < line) != (b[1] < line) {
                let x = crossing(a, b, 1, line).floor();
                if (x0..=x1).contains(&x) {
                    add([x, line]);
                }
            }
        }
    }
    for line in [y0, y1] {
        for (border, column) in columns {
            if holds(polygon, [border, line]) {
                add([column, line]);
            }
        }
    }
    found.len() as u32
}

/// Whether a point lies in the polygon or on its side.
fn holds(polygon: &Polygon, [x, y]: [i32; 2]) -> bool {
    let (mut left, mut right) = (false, false);
    for (a, b) in polygon.sides() {
        if y < a[1].min(b[1]) || y > a[1].max(b[1]) {
            continue;
        }
        if a[1] == b[1] {
            left |= a[0].min(b[0]) <= x;
            right |= a[0].max(b[0]) >= x;
        } else {
            let side = crossing(a, b, 1, y);
            left |= side.at_most(x);
            right |= side.at_least(x);
        }
    }
    left && right
}
