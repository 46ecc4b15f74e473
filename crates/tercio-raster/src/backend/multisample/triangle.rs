//! Draws triangles of any size, one by one, in stamps of 16 samples: those of one or more pixels side by side.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16};

use super::memory::SampleMemory;
use super::sink::Sink;
use crate::context::FrameContext;
use crate::conventions::SUBPIXELS;
use crate::screen::{DepthPlane, Edges, PixelRect, ScreenTriangle};
use crate::simd::{LANE_NUMBERS, LANES, each3, splat, splat_i};
use crate::stats::BackEndCounts;

/// Rows of pixels in a block: all of its stamps are outside an edge, or all inside all edges, more often than not.
const BLOCK_ROWS: i32 = 8;

/// Edge functions are clamped to this magnitude: well above the largest change inside a stamp (2^29), well below the
/// limit of 32 bits.
const EDGE_LIMIT: i64 = 1 << 30;

/// Draws one triangle, whose area is not zero. Not inlined, so that it is compiled only once per SIMD level.
#[inline(never)]
pub fn draw<S: Simd, K: Sink>(
    simd: S,
    context: &FrameContext,
    triangle: &ScreenTriangle,
    memory: &mut SampleMemory,
    counts: &mut BackEndCounts,
) {
    let pixels = triangle.pixels(context.cells.origin, context.view.width, context.view.height);
    let Some(pixels) = pixels else { return };
    let rect = pixels.intersect(memory.rect);
    if !rect.is_empty() {
        simd.vectorize(
            #[inline(always)]
            || draw_stamps::<S, K>(simd, context, triangle, rect, memory, counts),
        );
    }
}

/// Draws a triangle in some of the tile's pixels.
#[inline(always)]
fn draw_stamps<S: Simd, K: Sink>(
    simd: S,
    context: &FrameContext,
    triangle: &ScreenTriangle,
    rect: PixelRect,
    memory: &mut SampleMemory,
    counts: &mut BackEndCounts,
) {
    let cells = &context.cells;
    let edges = Edges::of_cells(triangle, cells);
    let plane = DepthPlane::new(triangle);
    let (base, nearest) = (splat(simd, plane.range[0]), splat(simd, plane.range[1]));
    let [lane_x, lane_y] = memory.lane_cells.map(|cell| i32x16::load_array(simd, cell));
    let [right, down] = memory.lane_offset.map(|offset| f32x16::load_array(simd, offset));
    let step: [i32x16<S>; 3] = each3!(K => lane_x * edges.a[K] + lane_y * edges.b[K]);
    let lane_pixel = i32x16::load_array(simd, LANE_NUMBERS) >> memory.count_bits;
    let bits = cells.cell_bits();
    let width = (LANES >> memory.count_bits) as i32;
    let is_wide = rect.x1 - rect.x0 >= width || rect.y1 - rect.y0 >= BLOCK_ROWS;
    for x in (rect.x0..rect.x1 + 1).step_by(width as usize) {
        let in_columns = lane_pixel.simd_le(splat_i(simd, rect.x1 - x)).to_bitmask() as u32 & 0xffff;
        let dx: f32x16<S> = right + (x * SUBPIXELS + cells.origin - plane.anchor[0]) as f32;
        let along_x = dx * plane.dx;
        for y in (rect.y0..rect.y1 + 1).step_by(BLOCK_ROWS as usize) {
            let last = (y + BLOCK_ROWS - 1).min(rect.y1);
            let block = PixelRect { x0: x, x1: x + width - 1, y0: y, y1: last }.cells(bits);
            // Long thin triangles overlap few blocks of their bounding box.
            if is_wide && edges.leave_out(block) {
                continue;
            }
            let is_inside = is_wide && edges.enclose(block);
            let mut first = [0, 1, 2].map(|k| edges.at(k, x << bits, y << bits));
            for row in y..last + 1 {
                let mut covered = in_columns;
                if !is_inside {
                    let e = each3!(K => step[K] + first[K].clamp(-EDGE_LIMIT, EDGE_LIMIT) as i32);
                    covered &= ((e[0] | e[1]) | e[2]).simd_ge(splat_i(simd, 0)).to_bitmask() as u32;
                    first = [0, 1, 2].map(|k| first[k] + (i64::from(edges.b[k]) << bits));
                }
                counts.stamps += 1;
                counts.samples_covered += u64::from(covered.count_ones());
                if covered == 0 {
                    continue;
                }
                let dy = down + (row * SUBPIXELS + cells.origin - plane.anchor[1]) as f32;
                let depth = ((along_x + dy * plane.dy) + base).max(base).min(nearest);
                K::stamp(memory, simd, context, memory.pixel(x, row), covered, depth, triangle.slot);
            }
        }
    }
}
