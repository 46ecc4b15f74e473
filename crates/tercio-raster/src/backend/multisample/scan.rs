//! Coverage and depth tests of triangles of a few pixels, with 8 or 16 samples per pixel: finds the pixels in which 16 triangles
//! cover samples, then tests the samples of one triangle in one pixel at a time, which fill a vector. With fewer samples:
//! [`super::few`].

use fearless_simd::prelude::*;
use fearless_simd::{Simd, i32x16, mask32x16};

use super::few::pixels;
use super::memory::SampleMemory;
use super::sink::Sink;
use super::write::InPixel;
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
/// Lowest bit of the samples that are covered in a word that has the place of the pixel below, as in [`super::fragments::Fragment`].
const COVERED_SHIFT: u32 = 16;
/// Lowest bit of the column and of the row of a pixel in the bounding box of its triangle, in a word with the triangle's lane
/// below.
const COLUMN_SHIFT: u32 = 4;
const ROW_SHIFT: u32 = 8;

/// The pixels in which 16 triangles cover samples.
#[derive(Debug)]
pub struct Hits {
    /// Place of the pixel, and the samples that the triangle covers, one bit each.
    places: Queue,
    /// Lane of the triangle, and the pixel's column and row in its bounding box.
    triangles: Queue,
    count: usize,
    /// Increments of the edge functions from the first cell of a pixel to the cells of its samples, by lane; valid for the
    /// samples that a pixel has.
    to_sample: [[[i32; LANES]; 3]; MAX_SAMPLES],
}

/// Room for all pixels, plus 16 because they are written and read 16 at a time.
type Queue = [i32; CAPACITY + LANES];

impl Default for Hits {
    fn default() -> Self {
        let zero = [0; CAPACITY + LANES];
        let to_sample = [[[0; LANES]; 3]; MAX_SAMPLES];
        Self { places: zero, triangles: zero, count: 0, to_sample }
    }
}

impl Hits {
    /// Finds the pixels in which the triangles in some lanes cover samples. Rows of pixels are `1 << stride_bits` apart. Not
    /// inlined, so that it is compiled only once per SIMD level.
    #[inline(never)]
    pub fn scan<S: Simd>(
        &mut self,
        simd: S,
        cells: &SampleCells,
        t: &SmallTriangles<S>,
        lanes: u32,
        stride_bits: u32,
    ) {
        simd.vectorize(
            #[inline(always)]
            || self.scan_pixels(simd, cells, t, lanes, stride_bits),
        );
    }

    #[inline(always)]
    fn scan_pixels<S: Simd>(
        &mut self,
        simd: S,
        cells: &SampleCells,
        t: &SmallTriangles<S>,
        lanes: u32,
        stride_bits: u32,
    ) {
        let Self { places, triangles, to_sample, .. } = self;
        let count = &mut 0;
        part(
            simd,
            #[inline(always)]
            || {
                let zero = splat_i(simd, 0);
                let all = splat_i(simd, cells.mask() as i32);
                let [across, down_to] = pixels(simd, t, lanes);
                let lanes = mask32x16::from_bitmask(simd, u64::from(lanes));
                // Whether a triangle of a few pixels covers one of them cannot be predicted.
                let is_tiny = across.max(down_to) <= 2;
                let to_sample = &mut to_sample[..cells.count];
                for (to, [x, y]) in to_sample.iter_mut().zip(cells.cells) {
                    *to = each3!(K => (t.a[K] * x + t.b[K] * y).to_array());
                }
                let bits = cells.cell_bits();
                let right = each3!(K => t.a[K] << bits);
                let down = each3!(K => t.b[K] << bits);
                let mut row_start = (t.first[1] << stride_bits) + t.first[0];
                let mut at_row = t.c;
                for row in 0..down_to {
                    let in_row = lanes & t.extent[1].simd_ge(splat_i(simd, row));
                    let (mut place, mut e) = (row_start, at_row);
                    for column in 0..across {
                        let in_box = in_row & t.extent[0].simd_ge(splat_i(simd, column));
                        let mut outside = zero;
                        // Written out for eight, so that the bits of samples are constants.
                        for to in to_sample.as_chunks::<8>().0.iter().rev() {
                            outside <<= 8;
                            for sample in 0..8 {
                                let at = each3!(K => e[K] + i32x16::load_array_ref(simd, &to[sample][K]));
                                let any = (at[0] | at[1]) | at[2];
                                // All bits of a negative number, shifted, are set.
                                outside |= (any >> 31) & (1 << sample);
                            }
                        }
                        let covered = outside ^ all;
                        let hits = in_box & covered.simd_gt(zero);
                        let hits = hits.to_bitmask() as u32 & 0xffff;
                        if is_tiny || hits != 0 {
                            append(simd, places, *count, hits, place | (covered << COVERED_SHIFT));
                            let at = column << COLUMN_SHIFT | row << ROW_SHIFT;
                            append(
                                simd,
                                triangles,
                                *count,
                                hits,
                                i32x16::load_array(simd, LANE_NUMBERS) | at,
                            );
                            *count += hits.count_ones() as usize;
                        }
                        e = each3!(K => e[K] + right[K]);
                        place += 1;
                    }
                    at_row = each3!(K => at_row[K] + down[K]);
                    row_start += 1 << stride_bits;
                }
            },
        );
        self.count = *count;
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
        for first in (0..self.count).step_by(LANES) {
            K::reserve_pixels(memory);
            let last = (first + LANES).min(self.count);
            for (&place, &triangle) in self.places[first..last].iter().zip(&self.triangles[first..last]) {
                let lane = triangle as usize % LANES;
                let (column, row) = (triangle >> COLUMN_SHIFT & 15, triangle >> ROW_SHIFT);
                let covered = place as u32 >> COVERED_SHIFT;
                let in_pixel = InPixel {
                    pixel: (place & 0xffff) as usize,
                    covered,
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
        }
        counts.samples_covered += u64::from(samples_covered);
    }
}
