//! Coverage of triangles of a few pixels: tests one sample in each of 16 triangles at a time.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16, mask32x16};

use super::depth_test::{Covered, NUMBER_SHIFT};
use super::setup::SmallTriangles;
use crate::backend::memory::TileMemory;
use crate::backend::tally::Tally;
use crate::conventions::SUBPIXELS;
use crate::simd::{LANES, each3, part, splat_i};

/// [`scan`] for triangles whose bounding boxes contain at most 2x2 samples, branch-free: whether a sample is covered
/// cannot be predicted.
#[inline(always)]
pub fn scan_tiny<S: Simd, T: Tally>(
    simd: S,
    t: &SmallTriangles<S>,
    lanes: u32,
    numbers: &[u8; LANES],
    tile: &TileMemory,
    covered: &mut Covered,
    tally: &mut T,
) {
    for row in 0..2 {
        part(
            simd,
            #[inline(always)]
            || {
                let lanes = mask32x16::from_bitmask(simd, u64::from(lanes));
                let number = number_bits(simd, numbers);
                let in_row = lanes & t.extent[1].simd_ge(splat_i(simd, row));
                let row_start = tile.places(t.first[0], t.first[1] + row) + number;
                let along_y = (t.from_anchor[1] + row * SUBPIXELS).to_float::<f32x16<S>>() * t.slope[1];
                for column in 0..2 {
                    let in_box = in_row & t.extent[0].simd_ge(splat_i(simd, column));
                    if let Some(full) = tally.full() {
                        full.details.steps += u64::from(in_box.any_true());
                    }
                    let e = each3!(K => t.c[K] + t.a[K] * column + t.b[K] * row);
                    let hits = in_box & ((e[0] | e[1]) | e[2]).simd_ge(splat_i(simd, 0));
                    let right = (t.from_anchor[0] + column * SUBPIXELS).to_float::<f32x16<S>>();
                    let depth = ((right * t.slope[0] + along_y) + t.base).max(t.base).min(t.nearest);
                    covered.push(simd, hits.to_bitmask() as u32 & 0xffff, row_start + column, depth);
                }
            },
        );
    }
}

/// Numbers of triangles, shifted to the bits where [`Covered`] expects them.
#[inline(always)]
fn number_bits<S: Simd>(simd: S, numbers: &[u8; LANES]) -> i32x16<S> {
    let mut wide = [0; LANES];
    for lane in 0..LANES {
        wide[lane] = i32::from(numbers[lane]) << NUMBER_SHIFT;
    }
    i32x16::load_array(simd, wide)
}

/// Appends the samples that the triangles in some lanes cover; `numbers` are the triangles' numbers in their cluster.
#[inline(always)]
pub fn scan<S: Simd, T: Tally>(
    simd: S,
    t: &SmallTriangles<S>,
    lanes: u32,
    numbers: &[u8; LANES],
    tile: &TileMemory,
    covered: &mut Covered,
    tally: &mut T,
) {
    part(
        simd,
        #[inline(always)]
        || {
            let lanes = mask32x16::from_bitmask(simd, u64::from(lanes));
            let mut row_start = tile.places(t.first[0], t.first[1]) + number_bits(simd, numbers);
            let mut down = t.from_anchor[1];
            let mut at_row = t.c;
            let mut row = 0;
            loop {
                let in_rows = lanes & t.extent[1].simd_ge(splat_i(simd, row));
                if !in_rows.any_true() {
                    break;
                }
                let along_y = down.to_float::<f32x16<S>>() * t.slope[1];
                let mut packed = row_start;
                let mut right = t.from_anchor[0];
                let mut e = at_row;
                let mut column = 0;
                loop {
                    let in_box = in_rows & t.extent[0].simd_ge(splat_i(simd, column));
                    if !in_box.any_true() {
                        break;
                    }
                    if let Some(full) = tally.full() {
                        full.details.steps += 1;
                    }
                    let hits = in_box & ((e[0] | e[1]) | e[2]).simd_ge(splat_i(simd, 0));
                    let bits = hits.to_bitmask() as u32 & 0xffff;
                    if bits != 0 {
                        let depth = (right.to_float::<f32x16<S>>() * t.slope[0] + along_y) + t.base;
                        let depth = depth.max(t.base).min(t.nearest);
                        covered.push(simd, bits, packed, depth);
                    }
                    e = each3!(K => e[K] + t.a[K]);
                    packed += 1;
                    right += SUBPIXELS;
                    column += 1;
                }
                at_row = each3!(K => at_row[K] + t.b[K]);
                row_start += tile.stride() as i32;
                down += SUBPIXELS;
                row += 1;
            }
        },
    )
}
