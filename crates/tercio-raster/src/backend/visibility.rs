//! Which triangle is seen at each sample of a tile.
//!
//! The tile memory stands in blocks of 4x4 samples, one vector operation each. A block's samples are row-major,
//! the blocks of a tile too.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16, mask32x16};

use super::edges::Edges;
use crate::binning::{ScreenTriangle, SmallTriangle};
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

/// Depth and triangle of every sample of a tile.
#[derive(Debug, Default)]
pub struct TileMemory {
    /// Depth, 0 where nothing was drawn.
    pub depth: Vec<f32>,
    /// Slot, [`NO_SLOT`] where nothing was drawn.
    pub slot: Vec<u32>,
    /// First column and row of pixels.
    pub corner: [i32; 2],
    /// Last column and row of pixels inside the picture.
    pub last: [i32; 2],
    /// Blocks along the edge.
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
        self.blocks = edge >> BLOCK_BITS;
        self.depth.clear();
        self.depth.resize(edge * edge, 0.0);
        self.slot.clear();
        self.slot.resize(edge * edge, NO_SLOT);
    }

    /// Draws one triangle.
    #[inline(always)]
    pub fn draw<S: Simd>(
        &mut self,
        simd: S,
        context: &FrameContext,
        triangle: &ScreenTriangle,
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
        let slots = splat_i(simd, triangle.slot as i32);

        for by in by0..=by1 {
            let py = self.corner[1] + (by << BLOCK_BITS);
            let dy = lane_dy + (py * SUBPIXELS + SAMPLE - plane.anchor[1]) as f32;
            let along_y = dy * plane.dy;
            for bx in bx0..=bx1 {
                let px = self.corner[0] + (bx << BLOCK_BITS);
                let e = each3!(K => step[K] + edges.at(K, px, py).clamp(-EDGE_LIMIT, EDGE_LIMIT) as i32);
                let covered = ((e[0] | e[1]) | e[2]).simd_ge(splat_i(simd, 0));
                counts.blocks += 1;
                if !covered.any_true() {
                    continue;
                }
                let dx = lane_dx + (px * SUBPIXELS + SAMPLE - plane.anchor[0]) as f32;
                let depth = (dx * plane.dx + along_y) + plane.base;
                let depth = depth.max(splat(simd, plane.range[0])).min(splat(simd, plane.range[1]));
                counts.samples_covered += u64::from(covered.to_bitmask().count_ones());
                let at = (by as usize * self.blocks + bx as usize) * LANES;
                self.write(simd, context, at, covered, depth, slots);
            }
        }
    }

    /// Draws one small triangle: [`TileMemory::draw`] with everything set up and no product over 32 bits.
    #[inline(always)]
    pub fn draw_small<S: Simd>(
        &mut self,
        simd: S,
        context: &FrameContext,
        t: &SmallTriangle,
        counts: &mut BackEndCounts,
    ) {
        let (first_x, first_y) = (i32::from(t.first[0]), i32::from(t.first[1]));
        let (x0, x1) = (first_x.max(self.corner[0]), i32::from(t.last[0]).min(self.last[0]));
        let (y0, y1) = (first_y.max(self.corner[1]), i32::from(t.last[1]).min(self.last[1]));
        let (bx0, bx1) = ((x0 - self.corner[0]) >> BLOCK_BITS, (x1 - self.corner[0]) >> BLOCK_BITS);
        let (by0, by1) = ((y0 - self.corner[1]) >> BLOCK_BITS, (y1 - self.corner[1]) >> BLOCK_BITS);

        let lane_x = i32x16::load_array(simd, LANE_X);
        let lane_y = i32x16::load_array(simd, LANE_Y);
        let a = each3!(K => i32::from(t.a[K]));
        let b = each3!(K => i32::from(t.b[K]));
        let step: [i32x16<S>; 3] = each3!(K => lane_x * a[K] + lane_y * b[K]);
        let lane_dx = (lane_x * SUBPIXELS).to_float::<f32x16<S>>();
        let lane_dy = (lane_y * SUBPIXELS).to_float::<f32x16<S>>();
        let slots = splat_i(simd, t.slot as i32);
        let (base, nearest) = (splat(simd, t.base), splat(simd, t.nearest));

        for by in by0..=by1 {
            let down = self.corner[1] + (by << BLOCK_BITS) - first_y;
            let dy = lane_dy + (down * SUBPIXELS - i32::from(t.anchor[1])) as f32;
            let along_y = dy * t.slope[1];
            for bx in bx0..=bx1 {
                let right = self.corner[0] + (bx << BLOCK_BITS) - first_x;
                let e = each3!(K => step[K] + (t.c[K] + a[K] * right + b[K] * down));
                let covered = ((e[0] | e[1]) | e[2]).simd_ge(splat_i(simd, 0));
                counts.blocks += 1;
                if !covered.any_true() {
                    continue;
                }
                let dx = lane_dx + (right * SUBPIXELS - i32::from(t.anchor[0])) as f32;
                let depth = ((dx * t.slope[0] + along_y) + t.base).max(base).min(nearest);
                counts.samples_covered += u64::from(covered.to_bitmask().count_ones());
                let at = (by as usize * self.blocks + bx as usize) * LANES;
                self.write(simd, context, at, covered, depth, slots);
            }
        }
    }

    /// Keeps the nearer of old and new at the covered samples of a block.
    #[inline(always)]
    fn write<S: Simd>(
        &mut self,
        simd: S,
        context: &FrameContext,
        at: usize,
        covered: mask32x16<S>,
        depth: f32x16<S>,
        slots: i32x16<S>,
    ) {
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
                    let bits = tie.to_bitmask() as u32;
                    let more = lower_primitives(context, bits, slots[0] as u32, old_slot);
                    wins |= mask32x16::from_bitmask(simd, u64::from(more));
                }
                wins.select(depth, before).store_slice(old_depth);
                let before: i32x16<S> = fearless_simd::u32x16::from_slice(simd, old_slot).bitcast();
                wins.select(slots, before).bitcast::<fearless_simd::u32x16<S>>().store_slice(old_slot);
            },
        )
    }
}

/// Which of the lanes of equal depth belong to `slot` because its primitive number is lower.
#[cold]
#[inline(never)]
fn lower_primitives(context: &FrameContext, ties: u32, slot: u32, old: &[u32]) -> u32 {
    let own = context.primitive(slot);
    let mut wins = 0;
    for (lane, &old) in old.iter().enumerate() {
        if ties >> lane & 1 == 1 && (old == NO_SLOT || own < context.primitive(old)) {
            wins |= 1 << lane;
        }
    }
    wins
}
