//! Coverage and depth tests of triangles of a few pixels: finds the pixels in which 16 triangles cover samples, then
//! tests the samples of one triangle in one pixel at a time.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, i32x16, mask32x16};

use super::memory::{InPixel, SampleMemory};
use super::sink::Sink;
use crate::backend::cluster::{Size, SmallTriangles};
use crate::context::FrameContext;
use crate::conventions::SUBPIXELS;
use crate::sampling::{MAX_SAMPLES, SampleCells};
use crate::simd::{LANE_NUMBERS, LANES, append, each3, part, splat_i};
use crate::stats::BackEndCounts;

/// The largest number of pixels that 16 triangles can reach.
const CAPACITY: usize = match Size::Small.max_across() {
    Some(max) => LANES * (max * max) as usize,
    None => 0,
};
/// Lowest bit of the lane, of the column and of the row of a pixel in its triangle, in a word with its place below.
const LANE_SHIFT: u32 = 16;
const COLUMN_SHIFT: u32 = 20;
const ROW_SHIFT: u32 = 24;

/// The pixels in which 16 triangles cover samples.
#[derive(Debug)]
pub struct Hits {
    /// Place of the pixel, lane of the triangle, column and row of the pixel in the triangle's bounding box.
    packed: [i32; CAPACITY + LANES],
    /// The samples that the triangle covers, one bit each.
    covered: [i32; CAPACITY + LANES],
    count: usize,
    /// Increments of the edge functions from the first cell of a pixel to the cells of its samples, by lane; valid for the
    /// samples that a pixel has.
    to_sample: [[[i32; LANES]; 3]; MAX_SAMPLES],
}

impl Default for Hits {
    fn default() -> Self {
        let zero = [0; CAPACITY + LANES];
        Self { packed: zero, covered: zero, count: 0, to_sample: [[[0; LANES]; 3]; MAX_SAMPLES] }
    }
}

impl Hits {
    /// Finds the pixels in which the triangles in some lanes cover samples.
    #[inline(always)]
    pub fn scan<S: Simd>(
        &mut self,
        simd: S,
        cells: &SampleCells,
        t: &SmallTriangles<S>,
        lanes: u32,
        memory: &SampleMemory,
    ) {
        self.count = 0;
        part(
            simd,
            #[inline(always)]
            || {
                let zero = splat_i(simd, 0);
                let all = splat_i(simd, cells.mask() as i32);
                let lanes = mask32x16::from_bitmask(simd, u64::from(lanes));
                let to_sample = &mut self.to_sample[..cells.count];
                for (to, [x, y]) in to_sample.iter_mut().zip(cells.cells) {
                    *to = each3!(K => (t.a[K] * x + t.b[K] * y).to_array());
                }
                let bits = cells.cell_bits();
                let right = each3!(K => t.a[K] << bits);
                let down = each3!(K => t.b[K] << bits);
                let lane = i32x16::load_array(simd, LANE_NUMBERS) << LANE_SHIFT;
                let mut row_start = ((t.first[1] << memory.stride_bits) + t.first[0]) | lane;
                let mut at_row = t.c;
                let mut row = 0;
                loop {
                    let in_rows = lanes & t.extent[1].simd_ge(splat_i(simd, row));
                    if !in_rows.any_true() {
                        break;
                    }
                    let (mut packed, mut e, mut column) = (row_start, at_row, 0);
                    loop {
                        let in_box = in_rows & t.extent[0].simd_ge(splat_i(simd, column));
                        if !in_box.any_true() {
                            break;
                        }
                        let mut outside = zero;
                        for (sample, to) in to_sample.iter().enumerate() {
                            let at = each3!(K => e[K] + i32x16::load_array_ref(simd, &to[K]));
                            let any = (at[0] | at[1]) | at[2];
                            // All bits of a negative number, shifted, are set.
                            outside |= (any >> 31) & (1 << sample);
                        }
                        let covered = outside ^ all;
                        let hits = in_box & covered.simd_gt(zero);
                        let hits = hits.to_bitmask() as u32 & 0xffff;
                        if hits != 0 {
                            append(simd, &mut self.packed, self.count, hits, packed);
                            append(simd, &mut self.covered, self.count, hits, covered);
                            self.count += hits.count_ones() as usize;
                        }
                        e = each3!(K => e[K] + right[K]);
                        packed += 1 | 1 << COLUMN_SHIFT;
                        column += 1;
                    }
                    at_row = each3!(K => at_row[K] + down[K]);
                    row_start += 1 << memory.stride_bits | 1 << ROW_SHIFT;
                    row += 1;
                }
            },
        );
    }

    /// Tests the depths of what was found in the same triangles, and adds the fragments that win. `first_slot` is the
    /// slot of the cluster's first triangle, `numbers` are the triangles' numbers in the cluster.
    #[expect(clippy::too_many_arguments, reason = "one call site; a struct would only rename them")]
    #[inline(always)]
    pub fn test<S: Simd, K: Sink>(
        &self,
        simd: S,
        context: &FrameContext,
        t: &SmallTriangles<S>,
        first_slot: u32,
        numbers: &[u8; LANES],
        memory: &mut SampleMemory,
        counts: &mut BackEndCounts,
    ) {
        if self.count == 0 {
            return;
        }
        let from_anchor = [t.from_anchor[0].to_array(), t.from_anchor[1].to_array()];
        let slope = [t.slope[0].to_array(), t.slope[1].to_array()];
        let (base, nearest) = (t.base.to_array(), t.nearest.to_array());
        let mut samples_covered = 0;
        for (&packed, &covered) in self.packed[..self.count].iter().zip(&self.covered) {
            let lane = (packed >> LANE_SHIFT) as usize % LANES;
            let (column, row) = (packed >> COLUMN_SHIFT & 15, packed >> ROW_SHIFT & 15);
            let in_pixel = InPixel {
                pixel: (packed & 0xffff) as usize,
                covered: covered as u32,
                slot: first_slot + u32::from(numbers[lane]),
                from_anchor: [
                    (from_anchor[0][lane] + column * SUBPIXELS) as f32,
                    (from_anchor[1][lane] + row * SUBPIXELS) as f32,
                ],
                slope: [slope[0][lane], slope[1][lane]],
                range: [base[lane], nearest[lane]],
            };
            samples_covered += covered.count_ones();
            K::in_pixel(memory, simd, context, &in_pixel);
        }
        counts.samples_covered += u64::from(samples_covered);
    }
}
