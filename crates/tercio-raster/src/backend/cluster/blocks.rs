//! Triangles of more than a few pixels, one by one, in blocks of 4x4 samples.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16};

use super::depth_test::Winners;
use super::setup::SmallTriangles;
use crate::backend::visibility::{BLOCK_BITS, LANE_X, LANE_Y, TileMemory};
use crate::context::FrameContext;
use crate::conventions::SUBPIXELS;
use crate::simd::{LANES, each3, splat, splat_i};
use crate::stats::BackEndCounts;

/// [`SmallTriangles`], to be read lane by lane.
pub struct Lanes {
    first: [[i32; LANES]; 2],
    extent: [[i32; LANES]; 2],
    c: [[i32; LANES]; 3],
    a: [[i32; LANES]; 3],
    b: [[i32; LANES]; 3],
    from_anchor: [[i32; LANES]; 2],
    base: [f32; LANES],
    nearest: [f32; LANES],
    slope: [[f32; LANES]; 2],
}

impl Lanes {
    /// Writes the lanes out.
    #[inline(always)]
    pub fn new<S: Simd>(t: &SmallTriangles<S>) -> Self {
        Self {
            first: [t.first[0].to_array(), t.first[1].to_array()],
            extent: [t.extent[0].to_array(), t.extent[1].to_array()],
            c: each3!(K => t.c[K].to_array()),
            a: each3!(K => t.a[K].to_array()),
            b: each3!(K => t.b[K].to_array()),
            from_anchor: [t.from_anchor[0].to_array(), t.from_anchor[1].to_array()],
            base: t.base.to_array(),
            nearest: t.nearest.to_array(),
            slope: [t.slope[0].to_array(), t.slope[1].to_array()],
        }
    }
}

/// Draws the triangles of some lanes; `first_slot` is that of the cluster's first triangle, `numbers` the
/// triangles' in the cluster.
#[expect(clippy::too_many_arguments, reason = "one call site; a struct would only rename them")]
#[inline(always)]
pub fn draw<S: Simd>(
    simd: S,
    context: &FrameContext,
    t: &Lanes,
    mut lanes: u32,
    first_slot: u32,
    numbers: &[u8; LANES],
    tile: &mut TileMemory,
    winners: &mut Winners,
    counts: &mut BackEndCounts,
) {
    let lane_x = i32x16::load_array(simd, LANE_X);
    let lane_y = i32x16::load_array(simd, LANE_Y);
    let lane_dx = (lane_x * SUBPIXELS).to_float::<f32x16<S>>();
    let lane_dy = (lane_y * SUBPIXELS).to_float::<f32x16<S>>();
    while lanes != 0 {
        let i = lanes.trailing_zeros() as usize % LANES;
        lanes &= lanes - 1;
        let slot = first_slot + u32::from(numbers[i]);
        let (x0, y0) = (t.first[0][i], t.first[1][i]);
        let (bx0, bx1) = (x0 >> BLOCK_BITS, (x0 + t.extent[0][i]) >> BLOCK_BITS);
        let (by0, by1) = (y0 >> BLOCK_BITS, (y0 + t.extent[1][i]) >> BLOCK_BITS);
        let step: [i32x16<S>; 3] = each3!(K => lane_x * t.a[K][i] + lane_y * t.b[K][i]);
        let (base, nearest) = (splat(simd, t.base[i]), splat(simd, t.nearest[i]));
        for by in by0..by1 + 1 {
            let down = (by << BLOCK_BITS) - y0;
            let dy = lane_dy + (down * SUBPIXELS + t.from_anchor[1][i]) as f32;
            let along_y = dy * t.slope[1][i];
            for bx in bx0..bx1 + 1 {
                let right = (bx << BLOCK_BITS) - x0;
                let e = each3!(K => step[K] + (t.c[K][i] + t.a[K][i] * right + t.b[K][i] * down));
                let mut covered = ((e[0] | e[1]) | e[2]).simd_ge(splat_i(simd, 0));
                if tile.is_cut {
                    covered &= tile.inside(simd, bx, by);
                }
                counts.blocks += 1;
                if !covered.any_true() {
                    continue;
                }
                let dx = lane_dx + (right * SUBPIXELS + t.from_anchor[0][i]) as f32;
                let depth = ((dx * t.slope[0][i] + along_y) + base).max(base).min(nearest);
                counts.samples_covered += u64::from(covered.to_bitmask().count_ones());
                let at = (by as usize * tile.blocks + bx as usize) * LANES;
                let won = tile.write(simd, context, at, covered, depth, slot);
                winners.push_block(simd, at, won, numbers[i]);
            }
        }
    }
}
