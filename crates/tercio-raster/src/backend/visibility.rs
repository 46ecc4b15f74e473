//! Which triangle is seen at each sample of a tile.
//!
//! The tile memory stands in blocks of 4x4 samples, one vector operation each. A block's samples are row-major,
//! the blocks of a tile too.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16, mask32x16};

use super::cluster::Winners;
use super::edges::Edges;
use crate::binning::{PixelRect, ScreenTriangle};
use crate::context::{FrameContext, NO_SLOT};
use crate::conventions::{SAMPLE, SUBPIXELS};
use crate::simd::{LANES, each3, part, splat, splat_i};
use crate::stats::BackEndCounts;

/// log2 of a block's edge in pixels.
pub const BLOCK_BITS: u32 = 2;
/// Column of each lane inside its block.
pub const LANE_X: [i32; LANES] = [0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3];
/// Row of each lane inside its block.
pub const LANE_Y: [i32; LANES] = [0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3];

/// Edge functions are cut off here: far beyond what they can change inside a block (2^27), far from the ends
/// of 32 bits.
const EDGE_LIMIT: i64 = 1 << 30;

/// In rows of fewer blocks every block is tested.
const LEAST_SPAN: i32 = 4;

/// Depth and triangle of every sample of a tile.
#[derive(Debug, Default)]
pub struct TileMemory {
    /// Depth, 0 where nothing was drawn.
    pub depth: Vec<f32>,
    /// Slot, [`NO_SLOT`] where nothing was drawn.
    pub slot: Vec<u32>,
    /// Samples whose pixels are shaded already, one bit each, a block an entry.
    pub shaded: Vec<u16>,
    /// First column and row of pixels.
    pub corner: [i32; 2],
    /// Last column and row of pixels inside the picture.
    pub last: [i32; 2],
    /// The border of the picture cuts the tile: blocks may hold samples beyond it.
    pub is_cut: bool,
    /// Blocks along the edge, a power of two.
    pub blocks: usize,
}

/// The depth of a triangle as a function of the screen.
#[derive(Clone, Copy, Debug)]
pub struct DepthPlane {
    /// Screen coordinates of the corner from which it is reckoned.
    pub anchor: [i32; 2],
    /// Depth there.
    pub base: f32,
    /// Growth a sub-pixel to the right.
    pub dx: f32,
    /// Growth a sub-pixel downwards.
    pub dy: f32,
    /// Depths of the corners: no sample is farther or nearer, however steep the plane.
    pub range: [f32; 2],
}

impl DepthPlane {
    /// Of a triangle with area.
    #[inline(always)]
    pub fn new(t: &ScreenTriangle) -> Self {
        let (x1, x2) = ((t.x[1] - t.x[0]) as f32, (t.x[2] - t.x[0]) as f32);
        let (y1, y2) = ((t.y[1] - t.y[0]) as f32, (t.y[2] - t.y[0]) as f32);
        let (d1, d2) = (t.d[1] - t.d[0], t.d[2] - t.d[0]);
        let inverse = 1.0 / t.area() as f32;
        Self {
            anchor: [t.x[0], t.y[0]],
            base: t.d[0],
            dx: (d1 * y2 - d2 * y1) * inverse,
            dy: (d2 * x1 - d1 * x2) * inverse,
            range: [t.d[0], if t.d[1] > t.d[2] { t.d[1] } else { t.d[2] }],
        }
    }
}

impl TileMemory {
    /// Makes the memory ready for a tile.
    pub fn clear(&mut self, context: &FrameContext, tile: u32) {
        let (x, y) = context.grid.corner(tile);
        let edge = 1usize << context.grid.shift;
        self.corner = [x as i32, y as i32];
        self.last = [
            (x as i32 + edge as i32).min(context.view.width as i32) - 1,
            (y as i32 + edge as i32).min(context.view.height as i32) - 1,
        ];
        self.is_cut = self.last != [x, y].map(|c| (c as usize + edge - 1) as i32);
        self.blocks = edge >> BLOCK_BITS;
        self.depth.clear();
        self.depth.resize(edge * edge, 0.0);
        self.slot.clear();
        self.slot.resize(edge * edge, NO_SLOT);
        self.shaded.clear();
        self.shaded.resize(edge * edge / LANES, 0);
    }

    /// Draws one triangle, and lists the samples that it wins if it is told its number in its cluster. Not
    /// inlined, so that it is compiled once a level.
    #[inline(never)]
    pub fn draw<S: Simd>(
        &mut self,
        simd: S,
        context: &FrameContext,
        triangle: &ScreenTriangle,
        winners: Option<(&mut Winners, u8)>,
        counts: &mut BackEndCounts,
    ) {
        simd.vectorize(
            #[inline(always)]
            || self.draw_blocks(simd, context, triangle, winners, counts),
        );
    }

    #[inline(always)]
    fn draw_blocks<S: Simd>(
        &mut self,
        simd: S,
        context: &FrameContext,
        triangle: &ScreenTriangle,
        mut winners: Option<(&mut Winners, u8)>,
        counts: &mut BackEndCounts,
    ) {
        let Some(rect) = triangle.samples(context.view.width, context.view.height) else { return };
        let (x0, x1) = (rect.x0.max(self.corner[0]), rect.x1.min(self.last[0]));
        let (y0, y1) = (rect.y0.max(self.corner[1]), rect.y1.min(self.last[1]));
        if x0 > x1 || y0 > y1 {
            return;
        }
        let (bx0, bx1) = ((x0 - self.corner[0]) >> BLOCK_BITS, (x1 - self.corner[0]) >> BLOCK_BITS);
        let (by0, by1) = ((y0 - self.corner[1]) >> BLOCK_BITS, (y1 - self.corner[1]) >> BLOCK_BITS);

        let edges = Edges::new(triangle);
        let plane = DepthPlane::new(triangle);
        let lane_x = i32x16::load_array(simd, LANE_X);
        let lane_y = i32x16::load_array(simd, LANE_Y);
        let step: [i32x16<S>; 3] = each3!(K => lane_x * edges.a[K] + lane_y * edges.b[K]);
        let lane_dx = (lane_x * SUBPIXELS).to_float::<f32x16<S>>();
        let lane_dy = (lane_y * SUBPIXELS).to_float::<f32x16<S>>();

        for by in by0..by1 + 1 {
            let py = self.corner[1] + (by << BLOCK_BITS);
            let dy = lane_dy + (py * SUBPIXELS + SAMPLE - plane.anchor[1]) as f32;
            let along_y = dy * plane.dy;
            // Long thin triangles touch few blocks of their bounding box.
            let (bx0, bx1) = if bx1 - bx0 >= LEAST_SPAN {
                let [first, last] = edges.blocks_in_row(self.corner[0], py);
                (bx0.max(first), bx1.min(last))
            } else {
                (bx0, bx1)
            };
            for bx in bx0..bx1 + 1 {
                let px = self.corner[0] + (bx << BLOCK_BITS);
                let e = each3!(K => step[K] + edges.at(K, px, py).clamp(-EDGE_LIMIT, EDGE_LIMIT) as i32);
                let mut covered = ((e[0] | e[1]) | e[2]).simd_ge(splat_i(simd, 0));
                if self.is_cut {
                    covered &= self.inside(simd, bx, by);
                }
                counts.blocks += 1;
                if !covered.any_true() {
                    continue;
                }
                let dx = lane_dx + (px * SUBPIXELS + SAMPLE - plane.anchor[0]) as f32;
                let depth = (dx * plane.dx + along_y) + plane.base;
                let depth = depth.max(splat(simd, plane.range[0])).min(splat(simd, plane.range[1]));
                counts.samples_covered += u64::from(covered.to_bitmask().count_ones());
                let at = (by as usize * self.blocks + bx as usize) * LANES;
                let won = self.write(simd, context, at, covered, depth, triangle.slot);
                if let Some((winners, number)) = &mut winners {
                    winners.push_block(simd, at, won, *number);
                }
            }
        }
    }

    /// Samples of a block that lie inside the picture.
    #[inline(always)]
    pub fn inside<S: Simd>(&self, simd: S, bx: i32, by: i32) -> mask32x16<S> {
        let left = [0, 1].map(|k| self.last[k] - self.corner[k]);
        let (across, below) = (left[0] - (bx << BLOCK_BITS), left[1] - (by << BLOCK_BITS));
        i32x16::load_array(simd, LANE_X).simd_le(splat_i(simd, across))
            & i32x16::load_array(simd, LANE_Y).simd_le(splat_i(simd, below))
    }

    /// Keeps the nearer of old and new at the covered samples of a block, and tells where the new one won.
    #[inline(always)]
    pub fn write<S: Simd>(
        &mut self,
        simd: S,
        context: &FrameContext,
        at: usize,
        covered: mask32x16<S>,
        depth: f32x16<S>,
        slot: u32,
    ) -> u32 {
        part(
            simd,
            #[inline(always)]
            || {
                let old_depth = &mut self.depth[at..at + LANES];
                let old_slot = &mut self.slot[at..at + LANES];
                let before = f32x16::from_slice(simd, old_depth);
                let mut wins = covered & depth.simd_gt(before);
                let tie = covered & depth.simd_eq(before);
                if tie.any_true() {
                    let more = lower_primitives(context, tie.to_bitmask() as u32, slot, old_slot);
                    wins |= mask32x16::from_bitmask(simd, u64::from(more));
                }
                wins.select(depth, before).store_slice(old_depth);
                let before: i32x16<S> = fearless_simd::u32x16::from_slice(simd, old_slot).bitcast();
                let slots = splat_i(simd, slot as i32);
                wins.select(slots, before).bitcast::<fearless_simd::u32x16<S>>().store_slice(old_slot);
                wins.to_bitmask() as u32 & 0xffff
            },
        )
    }

    /// Is every sample of a part of the tile nearer than this depth?
    #[inline(always)]
    pub fn all_nearer<S: Simd>(&self, simd: S, rect: PixelRect, depth: f32) -> bool {
        let block = |pixel: i32, corner: i32| (pixel - corner) as usize >> BLOCK_BITS;
        let (bx0, bx1) = (block(rect.x0, self.corner[0]), block(rect.x1, self.corner[0]));
        let (by0, by1) = (block(rect.y0, self.corner[1]), block(rect.y1, self.corner[1]));
        let depth = splat(simd, depth);
        for by in by0..by1 + 1 {
            let row = by * self.blocks * LANES;
            for block in self.depth[row + bx0 * LANES..row + (bx1 + 1) * LANES].chunks_exact(LANES) {
                if f32x16::from_slice(simd, block).simd_le(depth).any_true() {
                    return false;
                }
            }
        }
        true
    }

    /// Takes over what another memory of the same tile holds nearer.
    pub fn merge(&mut self, context: &FrameContext, other: &Self) {
        for (place, (&depth, &slot)) in other.depth.iter().zip(&other.slot).enumerate() {
            let before = self.depth[place];
            let wins = depth > before
                || (slot != NO_SLOT && depth == before && lower_primitive(context, slot, self.slot[place]));
            if wins {
                self.depth[place] = depth;
                self.slot[place] = slot;
            }
        }
    }

    /// Notes that the pixels of some samples are shaded.
    #[inline(always)]
    pub fn mark_shaded(&mut self, places: &[i32]) {
        for &place in places {
            self.shaded[place as usize / LANES] |= 1 << (place as usize % LANES);
        }
    }

    /// Pixels of the picture that show something.
    pub fn visible(&self) -> u64 {
        u64::from(self.slot.iter().map(|&slot| u32::from(slot != NO_SLOT)).sum::<u32>())
    }

    /// The pixels of the tile that lie inside the picture.
    #[inline(always)]
    pub fn rect(&self) -> PixelRect {
        PixelRect { x0: self.corner[0], x1: self.last[0], y0: self.corner[1], y1: self.last[1] }
    }

    /// Where rows of samples begin, counted from the tile's first; [`TileMemory::place_in_row`] is to be added.
    #[inline(always)]
    pub fn place_of_row<S: Simd>(&self, y: i32x16<S>) -> i32x16<S> {
        let blocks = self.blocks.trailing_zeros() + 2 * BLOCK_BITS;
        ((y >> BLOCK_BITS) << blocks) + ((y & 3) << BLOCK_BITS)
    }

    /// Column and row of samples in the tile, from their places.
    #[inline(always)]
    pub fn column_and_row<S: Simd>(&self, place: i32x16<S>) -> [i32x16<S>; 2] {
        let block = place >> (2 * BLOCK_BITS);
        let (bx, by) = (block & (self.blocks as i32 - 1), block >> self.blocks.trailing_zeros());
        [(bx << BLOCK_BITS) + (place & 3), (by << BLOCK_BITS) + ((place >> BLOCK_BITS) & 3)]
    }

    /// Where columns of samples stand in a row.
    #[inline(always)]
    pub fn place_in_row<S: Simd>(&self, x: i32x16<S>) -> i32x16<S> {
        ((x >> BLOCK_BITS) << (2 * BLOCK_BITS)) + (x & 3)
    }
}

/// Which of the lanes of equal depth belong to `slot` because its primitive number is lower.
#[cold]
#[inline(never)]
fn lower_primitives(context: &FrameContext, ties: u32, slot: u32, old: &[u32]) -> u32 {
    let mut wins = 0;
    for (lane, &old) in old.iter().enumerate() {
        if ties >> lane & 1 == 1 && lower_primitive(context, slot, old) {
            wins |= 1 << lane;
        }
    }
    wins
}

/// Does a sample belong to `slot` because its primitive number is lower than that of `old`?
#[cold]
#[inline(never)]
pub fn lower_primitive(context: &FrameContext, slot: u32, old: u32) -> bool {
    old == NO_SLOT || context.primitive(slot) < context.primitive(old)
}
