//! Draws triangles of up to 16 pixels across in stamps of 16 samples: set up 16 at a time, drawn one by one. First, the stamps
//! are found in which they cover samples, then depths are tested there. Whether they do cannot be predicted, so that there is
//! no branch on it.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16};

use super::memory::SampleMemory;
use super::sink::Sink;
use crate::backend::cluster::SmallTriangles;
use crate::context::FrameContext;
use crate::conventions::SUBPIXELS;
use crate::simd::{LANE_NUMBERS, LANES, each3, part, splat, splat_i};
use crate::stats::BackEndCounts;

/// [`SmallTriangles`], unpacked to draw them one by one.
pub struct Lanes {
    /// Column and row of the first pixel.
    first: [[i32; LANES]; 2],
    /// Distance to the last column and row, in pixels.
    extent: [[i32; LANES]; 2],
    /// Values of the edge functions at the first cell of the first pixel.
    c: [[i32; LANES]; 3],
    /// Increments of the edge functions per cell to the right.
    a: [[i32; LANES]; 3],
    /// Increments of the edge functions per cell downwards.
    b: [[i32; LANES]; 3],
    /// From the anchor to the first cell, in sub-pixels.
    from_anchor: [[i32; LANES]; 2],
    base: [f32; LANES],
    nearest: [f32; LANES],
    slope: [[f32; LANES]; 2],
}

impl Lanes {
    /// Unpacks the lanes.
    #[inline(always)]
    pub fn new<S: Simd>(simd: S, t: &SmallTriangles<S>) -> Self {
        part(
            simd,
            #[inline(always)]
            || Self {
                first: [t.first[0].to_array(), t.first[1].to_array()],
                extent: [t.extent[0].to_array(), t.extent[1].to_array()],
                c: each3!(K => t.c[K].to_array()),
                a: each3!(K => t.a[K].to_array()),
                b: each3!(K => t.b[K].to_array()),
                from_anchor: [t.from_anchor[0].to_array(), t.from_anchor[1].to_array()],
                base: t.base.to_array(),
                nearest: t.nearest.to_array(),
                slope: [t.slope[0].to_array(), t.slope[1].to_array()],
            },
        )
    }

    /// Draws the triangles in some lanes. `first_slot` is the slot of the cluster's first triangle, `numbers` are the
    /// triangles' numbers in the cluster.
    #[expect(clippy::too_many_arguments, reason = "one call site; a struct would only rename them")]
    #[inline(always)]
    pub fn draw<S: Simd, K: Sink>(
        &self,
        simd: S,
        context: &FrameContext,
        mut lanes: u32,
        first_slot: u32,
        numbers: &[u8; LANES],
        found: &mut Found,
        memory: &mut SampleMemory,
        counts: &mut BackEndCounts,
    ) {
        let bits = context.cells.cell_bits();
        let [lane_x, lane_y] = memory.lane_cells.map(|cell| i32x16::load_array(simd, cell));
        let lane_pixel = i32x16::load_array(simd, LANE_NUMBERS) >> memory.count_bits;
        let width = (LANES >> memory.count_bits) as i32;
        let stride = 1 << memory.stride_bits;
        while lanes != 0 {
            let i = lanes.trailing_zeros() as usize % LANES;
            lanes &= lanes - 1;
            let to_lane: [i32x16<S>; 3] =
                each3!(K => (lane_x * self.a[K][i] + lane_y * self.b[K][i]) + self.c[K][i]);
            let e_step = each3!(K => splat_i(simd, self.b[K][i]) << bits);
            let first = (self.first[1][i] << memory.stride_bits) + self.first[0][i];
            let rows = self.extent[1][i] + 1;
            for column in (0..self.extent[0][i] + 1).step_by(width as usize) {
                let in_columns = lane_pixel.simd_le(splat_i(simd, self.extent[0][i] - column));
                let mut e = each3!(K => to_lane[K] + self.a[K][i] * (column << bits));
                let mut place = (first + column) as u32;
                let mut triangle = i as u32 | (column as u32) << COLUMN_SHIFT;
                for _ in 0..rows {
                    let covered = in_columns & ((e[0] | e[1]) | e[2]).simd_ge(splat_i(simd, 0));
                    found.push(place, covered.to_bitmask() as u32, triangle);
                    e = each3!(K => e[K] + e_step[K]);
                    place += stride;
                    triangle += 1 << ROW_SHIFT;
                }
                counts.stamps += rows as u64;
                if found.count > CAPACITY - MOST_ROWS {
                    self.test::<S, K>(simd, context, first_slot, numbers, found, memory, counts);
                }
            }
        }
        self.test::<S, K>(simd, context, first_slot, numbers, found, memory, counts);
    }

    /// Tests the depths in the stamps that were found, and forgets them.
    #[expect(clippy::too_many_arguments, reason = "a struct would only rename them")]
    #[inline(always)]
    fn test<S: Simd, K: Sink>(
        &self,
        simd: S,
        context: &FrameContext,
        first_slot: u32,
        numbers: &[u8; LANES],
        found: &mut Found,
        memory: &mut SampleMemory,
        counts: &mut BackEndCounts,
    ) {
        let [right, down] = memory.lane_offset.map(|offset| f32x16::load_array(simd, offset));
        let mut samples_covered = 0;
        let count = std::mem::take(&mut found.count).min(CAPACITY);
        for (&place, &triangle) in found.places[..count].iter().zip(&found.triangles[..count]) {
            let i = triangle as usize % LANES;
            let (column, row) = ((triangle >> COLUMN_SHIFT & 0xff) as i32, (triangle >> ROW_SHIFT) as i32);
            let (pixel, covered) = (place as usize & 0xffff, place >> COVERED_SHIFT);
            let dx = right + (self.from_anchor[0][i] + column * SUBPIXELS) as f32;
            let dy = down + (self.from_anchor[1][i] + row * SUBPIXELS) as f32;
            let (base, nearest) = (splat(simd, self.base[i]), splat(simd, self.nearest[i]));
            let depth = ((dx * self.slope[0][i] + dy * self.slope[1][i]) + base).max(base).min(nearest);
            samples_covered += covered.count_ones();
            let slot = first_slot + u32::from(numbers[i]);
            K::stamp(memory, simd, context, pixel, covered, depth, slot);
        }
        counts.samples_covered += u64::from(samples_covered);
    }
}

/// Room for stamps: a power of two, which costs no branch.
const CAPACITY: usize = 512;
/// The largest number of rows, and of columns, of pixels in a tile's memory.
pub const MOST_ROWS: usize = 130;
/// Lowest bit of the samples that are covered in a word with the place of the pixel below.
const COVERED_SHIFT: u32 = 16;
/// Lowest bit of the column and of the row of a stamp in the bounding box of its triangle, in a word with the triangle's lane
/// below.
const COLUMN_SHIFT: u32 = 4;
const ROW_SHIFT: u32 = 12;

/// The stamps in which triangles cover samples.
#[derive(Debug)]
pub struct Found {
    /// Place of the first pixel, and the samples that are covered, one bit each.
    places: [u32; CAPACITY],
    /// Lane of the triangle, column and row of the stamp in its bounding box.
    triangles: [u32; CAPACITY],
    count: usize,
}

impl Default for Found {
    fn default() -> Self {
        Self { places: [0; CAPACITY], triangles: [0; CAPACITY], count: 0 }
    }
}

impl Found {
    /// Adds a stamp if any of its samples are covered.
    #[inline(always)]
    fn push(&mut self, place: u32, covered: u32, triangle: u32) {
        self.places[self.count % CAPACITY] = place | covered << COVERED_SHIFT;
        self.triangles[self.count % CAPACITY] = triangle;
        self.count += usize::from(covered & 0xffff != 0);
    }
}
