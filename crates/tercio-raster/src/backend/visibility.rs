//! Draws triangles of any size into the tile memory, one by one.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16};

use super::cluster::Winners;
use super::memory::{TileMemory, lane_columns};
use crate::context::FrameContext;
use crate::conventions::{SAMPLE, SUBPIXELS};
use crate::screen::{DepthPlane, Edges, PixelRect, ScreenTriangle};
use crate::simd::{LANES, each3, splat, splat_i};
use crate::stats::BackEndCounts;

/// Edge of the blocks of samples in which wide triangles are drawn: each row of a block is a stamp.
const BLOCK: i32 = LANES as i32;

/// Edge functions are clamped to this magnitude: well above the largest change inside a block (2^29), well below the
/// limit of 32 bits.
const EDGE_LIMIT: i64 = 1 << 30;

/// Draws one triangle, and appends the samples that it wins if `winners` is `Some`, together with the triangle's number
/// in its cluster. Not inlined, so that it is compiled only once per SIMD level.
#[inline(never)]
pub fn draw<S: Simd>(
    simd: S,
    context: &FrameContext,
    triangle: &ScreenTriangle,
    tile: &mut TileMemory,
    winners: Option<(&mut Winners, u8)>,
    counts: &mut BackEndCounts,
) {
    let Some(samples) = triangle.samples(context.view.width, context.view.height) else { return };
    let rect = samples.intersect(tile.rect());
    if rect.is_empty() {
        return;
    }
    simd.vectorize(
        #[inline(always)]
        || draw_stamps(simd, context, triangle, rect, tile, winners, counts),
    );
}

/// Draws the samples of a triangle in a part of the tile.
#[inline(always)]
fn draw_stamps<S: Simd>(
    simd: S,
    context: &FrameContext,
    triangle: &ScreenTriangle,
    rect: PixelRect,
    tile: &mut TileMemory,
    mut winners: Option<(&mut Winners, u8)>,
    counts: &mut BackEndCounts,
) {
    let edges = Edges::new(triangle);
    let plane = DepthPlane::new(triangle);
    let lane = lane_columns::<S, LANES>(simd);
    let step: [i32x16<S>; 3] = each3!(K => lane * edges.a[K]);
    let lane_dx = (lane * SUBPIXELS).to_float::<f32x16<S>>();
    let (base, nearest) = (splat(simd, plane.range[0]), splat(simd, plane.range[1]));
    let [left, top] = tile.corner;

    let is_wide = rect.x1 - rect.x0 >= BLOCK;
    let first = if is_wide {
        left + (rect.x0 - left) / BLOCK * BLOCK
    } else {
        rect.x0.min(left + tile.last_column_of_stamps::<LANES>())
    };
    for x in (first..rect.x1 + 1).step_by(BLOCK as usize) {
        let in_columns = lane.simd_le(splat_i(simd, rect.x1 - x));
        let dx = lane_dx + (x * SUBPIXELS + SAMPLE - plane.anchor[0]) as f32;
        let along_x = dx * plane.dx;
        for y in (rect.y0..rect.y1 + 1).step_by(BLOCK as usize) {
            let block = PixelRect { x0: x, x1: x + BLOCK - 1, y0: y, y1: (y + BLOCK - 1).min(rect.y1) };
            // Long thin triangles overlap few blocks of their bounding box.
            if is_wide && edges.leave_out(block) {
                continue;
            }
            let is_inside = is_wide && edges.enclose(block);
            let mut e = each3!(K => step[K] + edges.at(K, x, y).clamp(-EDGE_LIMIT, EDGE_LIMIT) as i32);
            let mut won =
                winners.as_mut().map(|(winners, number)| winners.of_triangle(*number, LANES * LANES));
            for row in y..block.y1 + 1 {
                let mut covered = in_columns;
                if !is_inside {
                    covered &= ((e[0] | e[1]) | e[2]).simd_ge(splat_i(simd, 0));
                    e = each3!(K => e[K] + edges.b[K]);
                }
                let along_y = (row * SUBPIXELS + SAMPLE - plane.anchor[1]) as f32 * plane.dy;
                let depth = ((along_x + along_y) + plane.base).max(base).min(nearest);
                counts.stamps += 1;
                counts.samples_covered += u64::from(covered.to_bitmask().count_ones());
                let place = tile.place(x - left, row - top);
                let mut samples = tile.samples_mut();
                let wins = samples.write::<S, LANES>(simd, context, place, covered, depth, triangle.slot);
                if let Some(won) = &mut won {
                    won.push(simd, lane + place as i32, wins);
                }
            }
            if let Some(won) = won {
                won.end();
            }
        }
    }
}
