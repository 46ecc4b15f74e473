//! Triangles of more than a few pixels, one by one, in stamps of 16 samples.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16};

use super::depth_test::Winners;
use super::setup::SmallTriangles;
use crate::backend::memory::{TileMemory, lane_columns, lane_rows};
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

/// Draws the triangles of some lanes, of at most `WIDTH` samples across, in stamps of rows of `WIDTH`. `first_slot` is
/// that of the cluster's first triangle, `numbers` the triangles' in the cluster.
#[expect(clippy::too_many_arguments, reason = "one call site; a struct would only rename them")]
#[inline(always)]
pub fn draw<S: Simd, const WIDTH: usize>(
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
    let rows = (LANES / WIDTH) as i32;
    let (lane_x, lane_y) = (lane_columns::<S, WIDTH>(simd), lane_rows::<S, WIDTH>(simd));
    let lane_dx = (lane_x * SUBPIXELS).to_float::<f32x16<S>>();
    let lane_dy = (lane_y * SUBPIXELS).to_float::<f32x16<S>>();
    let lane_place = tile.places(lane_x, lane_y);
    while lanes != 0 {
        let i = lanes.trailing_zeros() as usize % LANES;
        lanes &= lanes - 1;
        let slot = first_slot + u32::from(numbers[i]);
        let (column, row) = (t.first[0][i], t.first[1][i]);
        // A stamp does not reach over the end of a row: it begins so much further left.
        let first = tile.stamp_column::<WIDTH>(column);
        let right = first - column;
        let in_columns = lane_x.simd_le(splat_i(simd, t.extent[0][i] - right));
        let mut e: [i32x16<S>; 3] =
            each3!(K => lane_x * t.a[K][i] + lane_y * t.b[K][i] + (t.c[K][i] + t.a[K][i] * right));
        let (base, nearest) = (splat(simd, t.base[i]), splat(simd, t.nearest[i]));
        let dx = lane_dx + (right * SUBPIXELS + t.from_anchor[0][i]) as f32;
        let along_x = dx * t.slope[0][i];
        let mut dy = lane_dy + t.from_anchor[1][i] as f32;
        let mut place = tile.place(first, row);
        let mut below = t.extent[1][i];
        winners.reserve((below / rows + 1) as usize * LANES);
        while below >= 0 {
            let mut covered = in_columns & ((e[0] | e[1]) | e[2]).simd_ge(splat_i(simd, 0));
            if rows > 1 {
                covered &= lane_y.simd_le(splat_i(simd, below));
            }
            let depth = ((along_x + dy * t.slope[1][i]) + base).max(base).min(nearest);
            counts.stamps += 1;
            counts.samples_covered += u64::from(covered.to_bitmask().count_ones());
            let won = tile.write::<S, WIDTH>(simd, context, place, covered, depth, slot);
            winners.push(simd, lane_place + place as i32, won, numbers[i]);
            e = each3!(K => e[K] + t.b[K][i] * rows);
            dy += (SUBPIXELS * rows) as f32;
            place += rows as usize * tile.stride();
            below -= rows;
        }
    }
}
