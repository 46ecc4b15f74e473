//! The input of an engine: the rows of triangles in a tile.

use super::super::Triangle;
use super::super::triangle::PixelBox;

/// A span of pixels with exclusive end, before and after clipping at the tile's border.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Span {
    /// First column.
    pub(super) first: i32,
    /// Column after the last.
    pub(super) end: i32,
}

impl Span {
    /// Pixels at every `step`-th column, those with remainder `lane`.
    pub(super) fn pixels(self, lane: usize, step: usize) -> u32 {
        let (lane, step) = (lane as i32, step as i32);
        let up_to = |x: i32| (x - lane + step - 1).div_euclid(step);
        (up_to(self.end) - up_to(self.first)).max(0) as u32
    }
}

/// A triangle's rows in one tile.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TileWork {
    pub(super) first_row: i32,
    pub(super) spans: Vec<Span>,
}

impl TileWork {
    /// The part of a triangle in a tile.
    pub fn new(triangle: &Triangle, tile: PixelBox) -> Self {
        let Some(rows) = triangle.rounded_box() else { return Self::default() };
        let (y0, y1) = (rows.y0.max(tile.y0), rows.y1.min(tile.y1));
        let span = |row| {
            let (first, end) = triangle.span(row);
            Span { first: first.max(tile.x0), end: end.min(tile.x1) }
        };
        Self { first_row: y0, spans: (y0..y1).map(span).collect() }
    }

    /// The same rows with other spans: `change` gets the row, the first column and the one after the last.
    #[must_use]
    pub fn with_spans(mut self, change: impl Fn(i32, i32, i32) -> (i32, i32)) -> Self {
        for (row, span) in (self.first_row..).zip(&mut self.spans) {
            (span.first, span.end) = change(row, span.first, span.end);
        }
        self
    }

    /// Pixels drawn.
    pub fn pixels(&self) -> u64 {
        self.spans.iter().map(|s| u64::from(s.pixels(0, 1))).sum()
    }

    /// Number of rows.
    pub fn rows(&self) -> u64 {
        self.spans.len() as u64
    }
}
