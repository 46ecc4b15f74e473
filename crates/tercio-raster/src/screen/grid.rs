//! The division of a picture into tiles.

use std::ops::Range;

use super::{PixelRect, TileSet};

/// The grid of tiles of a picture.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TileGrid {
    /// log2 of a tile's edge in pixels.
    pub shift: u32,
    /// Number of columns of tiles.
    pub columns: u32,
    /// Number of rows of tiles.
    pub rows: u32,
    /// The first of these rows in the picture, counted in tiles.
    pub first_row: u32,
    /// The tiles that are drawn.
    pub drawn: TileSet,
    /// Pixels around a tile, in each direction, that it needs beside its own: those of the filter.
    pub halo: u32,
}

impl TileGrid {
    /// Divides a picture; `size` is a power of two.
    pub fn new(width: u32, height: u32, size: u32, drawn: TileSet) -> Self {
        let [columns, rows] = [width, height].map(|n| n.div_ceil(size));
        Self { shift: size.trailing_zeros(), columns, rows, first_row: 0, drawn, halo: 0 }
    }

    /// The grid of some rows of pixels only: whole rows of tiles, except at the lower border of the picture.
    pub fn of_rows(self, rows: &Range<u32>) -> Self {
        let first_row = rows.start >> self.shift;
        Self { first_row, rows: rows.end.div_ceil(1 << self.shift) - first_row, ..self }
    }

    /// log2 of the distance of two rows of the pixels that a tile needs, where these are counted or stored.
    pub fn needed_bits(&self) -> u32 {
        ((1 << self.shift) + 2 * self.halo).next_power_of_two().trailing_zeros()
    }

    /// The number of a tile, from its column and its row in the picture. Precondition: it is in the grid.
    #[inline(always)]
    pub fn number(&self, column: u32, row: u32) -> u32 {
        (row - self.first_row) * self.columns + column
    }

    /// Is the tile drawn?
    #[inline(always)]
    pub fn draws(&self, tile: u32) -> bool {
        self.drawn.contains(tile)
    }

    /// First and last column, first and last row of the tiles of the grid that need a rectangle of pixels; the first row
    /// is below the last if there are none. The rectangle is given by its first and last column, first and last row.
    #[inline(always)]
    pub fn tiles_that_need(&self, [x0, x1, y0, y1]: [u32; 4]) -> [u32; 4] {
        let first = |pixel: u32| pixel.saturating_sub(self.halo) >> self.shift;
        let last = |pixel: u32, tiles: u32| ((pixel + self.halo) >> self.shift).min(tiles.max(1) - 1);
        let end = self.first_row + self.rows;
        [first(x0), last(x1, self.columns), first(y0).max(self.first_row), last(y1, end)]
    }

    /// Is any of the tiles drawn that need a rectangle of pixels? The rectangle is given by its first and last column,
    /// first and last row.
    pub fn draws_some_of(&self, rect: [u16; 4]) -> bool {
        let [x0, x1, y0, y1] = self.tiles_that_need(rect.map(u32::from));
        if self.drawn.is_all() {
            return y0 <= y1;
        }
        (y0..=y1).any(|y| (x0..=x1).any(|x| self.draws(self.number(x, y))))
    }

    /// Number of tiles.
    pub fn count(&self) -> usize {
        self.columns as usize * self.rows as usize
    }

    /// Number of tiles that need a rectangle of pixels. The rectangle is given by its first and last column, first and
    /// last row.
    pub fn tiles_of(&self, rect: [u16; 4]) -> u32 {
        let [x0, x1, y0, y1] = self.tiles_that_need(rect.map(u32::from));
        (x1 - x0 + 1) * (y1 + 1).saturating_sub(y0)
    }

    /// The pixels of a tile that are inside a picture of this width and height.
    pub fn rect(&self, tile: u32, [width, height]: [u32; 2]) -> PixelRect {
        let (x, y) = self.corner(tile);
        let edge = 1u32 << self.shift;
        PixelRect {
            x0: x as i32,
            x1: (x + edge).min(width) as i32 - 1,
            y0: y as i32,
            y1: (y + edge).min(height) as i32 - 1,
        }
    }

    /// First pixel column and row of a tile.
    pub fn corner(&self, tile: u32) -> (u32, u32) {
        ((tile % self.columns) << self.shift, (tile / self.columns + self.first_row) << self.shift)
    }
}
