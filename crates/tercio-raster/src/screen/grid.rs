//! The division of a picture into tiles.

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
    /// The tiles that are drawn.
    pub drawn: TileSet,
}

impl TileGrid {
    /// Divides a picture; `size` is a power of two.
    pub fn new(width: u32, height: u32, size: u32, drawn: TileSet) -> Self {
        let [columns, rows] = [width, height].map(|n| n.div_ceil(size));
        Self { shift: size.trailing_zeros(), columns, rows, drawn }
    }

    /// Is the tile drawn?
    #[inline(always)]
    pub fn draws(&self, tile: u32) -> bool {
        self.drawn.contains(tile)
    }

    /// Is any of the tiles drawn that a rectangle of pixels overlaps? The rectangle is given by its first and last
    /// column, first and last row.
    pub fn draws_some_of(&self, rect: [u16; 4]) -> bool {
        let [x0, x1, y0, y1] = rect.map(|pixel| u32::from(pixel) >> self.shift);
        self.drawn.is_all() || (y0..=y1).any(|y| (x0..=x1).any(|x| self.draws(y * self.columns + x)))
    }

    /// Number of tiles of the picture.
    pub fn count(&self) -> usize {
        self.columns as usize * self.rows as usize
    }

    /// Number of tiles that a rectangle of pixels overlaps. The rectangle is given by its first and last column, first
    /// and last row.
    pub fn tiles_of(&self, [x0, x1, y0, y1]: [u16; 4]) -> u32 {
        let along =
            |first: u16, last: u16| (u32::from(last) >> self.shift) - (u32::from(first) >> self.shift) + 1;
        along(x0, x1) * along(y0, y1)
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
        ((tile % self.columns) << self.shift, (tile / self.columns) << self.shift)
    }
}
