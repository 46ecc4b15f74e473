//! Draws triangles of more than a few pixels one by one, in stamps of 16 samples.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16};

use super::depth_test::Winners;
use super::setup::SmallTriangles;
use crate::backend::memory::{TileMemory, lane_columns, lane_rows};
use crate::context::FrameContext;
use crate::conventions::SUBPIXELS;
use crate::simd::{LANES, each3, part, splat, splat_i};
use crate::stats::BackEndCounts;

/// [`SmallTriangles`] of at most `WIDTH` samples across, unpacked to draw them one by one in stamps with rows of
/// `WIDTH` samples.
pub struct Lanes<const WIDTH: usize> {
    /// Index of the first sample of the first stamp.
    sample_index: [i32; LANES],
    /// Last column of a stamp that is in the bounding box.
    last_column: [i32; LANES],
    /// Number of rows below the first.
    below: [i32; LANES],
    /// Values of the edge functions at the first sample of the first stamp.
    c: [[i32; LANES]; 3],
    /// Increments of the edge functions per pixel to the right.
    a: [[i32; LANES]; 3],
    /// Increments of the edge functions per pixel downwards.
    b: [[i32; LANES]; 3],
    /// From the anchor to the first sample of the first stamp, in sub-pixels.
    from_anchor: [[f32; LANES]; 2],
    base: [f32; LANES],
    nearest: [f32; LANES],
    slope: [[f32; LANES]; 2],
}

impl<const WIDTH: usize> Lanes<WIDTH> {
    /// Unpacks the lanes.
    #[inline(always)]
    pub fn new<S: Simd>(simd: S, t: &SmallTriangles<S>, tile: &TileMemory) -> Self {
        part(
            simd,
            #[inline(always)]
            || {
                // A stamp must not extend over the end of a row of the tile: near the end it is moved to the left.
                let first = t.first[0].min(splat_i(simd, tile.last_column_of_stamps::<WIDTH>()));
                let right = first - t.first[0];
                let c = each3!(K => t.c[K] + t.a[K] * right);
                Self {
                    sample_index: tile.places(first, t.first[1]).to_array(),
                    last_column: (t.extent[0] - right).to_array(),
                    below: t.extent[1].to_array(),
                    c: each3!(K => c[K].to_array()),
                    a: each3!(K => t.a[K].to_array()),
                    b: each3!(K => t.b[K].to_array()),
                    from_anchor: [
                        (t.from_anchor[0] + right * SUBPIXELS).to_float::<f32x16<S>>().to_array(),
                        t.from_anchor[1].to_float::<f32x16<S>>().to_array(),
                    ],
                    base: t.base.to_array(),
                    nearest: t.nearest.to_array(),
                    slope: [t.slope[0].to_array(), t.slope[1].to_array()],
                }
            },
        )
    }
}

/// Draws the triangles in some lanes. `first_slot` is the slot of the cluster's first triangle, `numbers` are the
/// triangles' numbers in the cluster.
#[expect(clippy::too_many_arguments, reason = "one call site; a struct would only rename them")]
#[inline(always)]
pub fn draw<S: Simd, const WIDTH: usize>(
    simd: S,
    context: &FrameContext,
    t: &Lanes<WIDTH>,
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
    let lane_index = tile.places(lane_x, lane_y);
    let step = rows as usize * tile.stride();
    let mut samples = tile.samples_mut();
    let (mut stamps, mut samples_covered) = (0, 0);
    while lanes != 0 {
        let i = lanes.trailing_zeros() as usize % LANES;
        lanes &= lanes - 1;
        let slot = first_slot + u32::from(numbers[i]);
        let in_columns = lane_x.simd_le(splat_i(simd, t.last_column[i]));
        let mut e: [i32x16<S>; 3] = each3!(K => (lane_x * t.a[K][i] + lane_y * t.b[K][i]) + t.c[K][i]);
        let e_step = each3!(K => splat_i(simd, t.b[K][i]) * rows);
        let (base, nearest) = (splat(simd, t.base[i]), splat(simd, t.nearest[i]));
        let along_x = (lane_dx + t.from_anchor[0][i]) * t.slope[0][i];
        let mut dy = lane_dy + t.from_anchor[1][i];
        let mut index = t.sample_index[i] as usize;
        let mut below = t.below[i];
        let mut won = winners.of_triangle(numbers[i], (below / rows + 1) as usize * LANES);
        while below >= 0 {
            let mut covered = in_columns & ((e[0] | e[1]) | e[2]).simd_ge(splat_i(simd, 0));
            if rows > 1 {
                covered &= lane_y.simd_le(splat_i(simd, below));
            }
            let depth = ((along_x + dy * t.slope[1][i]) + base).max(base).min(nearest);
            stamps += 1;
            samples_covered += covered.to_bitmask().count_ones();
            let wins = samples.write::<S, WIDTH>(simd, context, index, covered, depth, slot);
            won.push(simd, lane_index + index as i32, wins);
            e = each3!(K => e[K] + e_step[K]);
            dy += (SUBPIXELS * rows) as f32;
            index += step;
            below -= rows;
        }
        won.end();
    }
    counts.stamps += stamps;
    counts.samples_covered += u64::from(samples_covered);
}
