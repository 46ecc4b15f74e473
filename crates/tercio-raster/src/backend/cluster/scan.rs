//! Triangles of a few pixels: one sample of each of 16 triangles at a time.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16, mask32x16};

use super::depth_test::Covered;
use super::setup::SmallTriangles;
use crate::backend::visibility::TileMemory;
use crate::conventions::SUBPIXELS;
use crate::simd::{each3, part, splat_i};

/// Bounding boxes of at most this many samples across and down are scanned.
pub const MOST_SAMPLES_ALONG: i32 = 4;

/// Number of each lane.
const NUMBERS: [i32; 16] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15];

/// Lists the samples that the triangles of some lanes cover. `first` is the number of the first lane's triangle
/// in its cluster.
#[inline(always)]
pub fn scan<S: Simd>(
    simd: S,
    t: &SmallTriangles<S>,
    lanes: u32,
    first: u32,
    tile: &TileMemory,
    covered: &mut Covered,
) {
    part(
        simd,
        #[inline(always)]
        || {
            let lanes = mask32x16::from_bitmask(simd, u64::from(lanes));
            let number = i32x16::load_array(simd, NUMBERS) + first as i32;
            let mut y = t.first[1] - tile.corner[1];
            let mut down = t.from_anchor[1];
            let mut at_row = t.c;
            let mut row = 0;
            loop {
                let in_rows = lanes & t.extent[1].simd_ge(splat_i(simd, row));
                if !in_rows.any_true() {
                    break;
                }
                let along_y = down.to_float::<f32x16<S>>() * t.slope[1];
                let row_place = tile.place_of_row(y);
                let mut x = t.first[0] - tile.corner[0];
                let mut right = t.from_anchor[0];
                let mut e = at_row;
                let mut column = 0;
                loop {
                    let in_box = in_rows & t.extent[0].simd_ge(splat_i(simd, column));
                    if !in_box.any_true() {
                        break;
                    }
                    let hits = in_box & ((e[0] | e[1]) | e[2]).simd_ge(splat_i(simd, 0));
                    let bits = hits.to_bitmask() as u32 & 0xffff;
                    if bits != 0 {
                        let depth = (right.to_float::<f32x16<S>>() * t.slope[0] + along_y) + t.base;
                        let depth = depth.max(t.base).min(t.nearest);
                        covered.push(simd, bits, row_place + tile.place_in_row(x), depth, number);
                    }
                    e = each3!(K => e[K] + t.a[K]);
                    x = x + 1;
                    right = right + SUBPIXELS;
                    column += 1;
                }
                at_row = each3!(K => at_row[K] + t.b[K]);
                y = y + 1;
                down = down + SUBPIXELS;
                row += 1;
            }
        },
    )
}
