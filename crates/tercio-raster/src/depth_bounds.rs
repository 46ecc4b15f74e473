//! Bounds of depth in blocks of pixels: what a rank knows of what others draw in a tile before it draws it itself.
//!
//! Where nothing of others can be as near as what a rank has drawn, its pixels are finished: fragments need not be sent. And what is
//! behind everything that another rank has drawn in a block is not seen: it need not be drawn.

use crate::screen::{PixelRect, TileGrid};

/// log2 of the edge of a block.
pub const BLOCK_BITS: u32 = 3;

/// Blocks across a tile; its last ones may be cut off by the border of the picture.
pub fn blocks_across(grid: &TileGrid) -> usize {
    (1usize << grid.shift).div_ceil(1 << BLOCK_BITS)
}

/// The pixels of a block, counted from the first pixel of the tile; those beyond a small tile are included.
pub fn block(number: usize, across: usize) -> PixelRect {
    let [x0, y0] = [number % across, number / across].map(|k| (k << BLOCK_BITS) as i32);
    let last = (1 << BLOCK_BITS) - 1;
    PixelRect { x0, x1: x0 + last, y0, y1: y0 + last }
}

/// Of some tiles, row by row the blocks of each, a depth. Larger ones are nearer, as everywhere.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DepthBounds {
    /// In ascending order.
    tiles: Vec<u32>,
    blocks: usize,
    depths: Vec<f32>,
}

impl DepthBounds {
    /// Bounds of tiles, given in ascending order, that are 0.
    pub fn new(grid: &TileGrid, tiles: Vec<u32>) -> Self {
        let blocks = blocks_across(grid).pow(2);
        Self { depths: vec![0.0; tiles.len() * blocks], tiles, blocks }
    }

    /// The tiles.
    pub fn tiles(&self) -> &[u32] {
        &self.tiles
    }

    /// The bounds of a tile, if they are known.
    pub fn of(&self, tile: u32) -> Option<&[f32]> {
        let at = self.tiles.binary_search(&tile).ok()?;
        self.depths.get(at * self.blocks..(at + 1) * self.blocks)
    }

    /// The bounds of a tile, to be set.
    pub fn of_mut(&mut self, tile: u32) -> Option<&mut [f32]> {
        let at = self.tiles.binary_search(&tile).ok()?;
        self.depths.get_mut(at * self.blocks..(at + 1) * self.blocks)
    }

    /// The bounds of all tiles, to be set.
    pub fn tiles_mut(&mut self) -> impl Iterator<Item = (u32, &mut [f32])> {
        self.tiles.iter().copied().zip(self.depths.chunks_exact_mut(self.blocks.max(1)))
    }
}
