//! Depth test of the samples that a cluster covers.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16};

use super::sieve::Size;
use crate::backend::memory::{TileMemory, lower_primitive};
use crate::context::FrameContext;
use crate::simd::{LANES, append};
use crate::stats::BackEndCounts;

/// The largest number of samples that one scan of 16 triangles can find.
const MAX_PER_SCAN: usize = match Size::Small.max_across() {
    Some(max) => LANES * (max * max) as usize,
    None => 0,
};
/// Capacity for the samples of previous scans plus one more scan.
const CAPACITY: usize = 2 * MAX_PER_SCAN;
/// Position of the lowest bit of a triangle's number in a word that holds it above a sample index.
pub const NUMBER_SHIFT: u32 = 16;

/// The queue of covered samples for the depth test, in the order in which they were found.
#[derive(Debug)]
pub struct Covered {
    /// Sample indices, with the triangles' numbers in their cluster in the bits from [`NUMBER_SHIFT`] on.
    packed: [i32; CAPACITY + LANES],
    /// Depths, as the bits of an `f32`.
    depth: [i32; CAPACITY + LANES],
    count: usize,
}

impl Default for Covered {
    fn default() -> Self {
        let zero = [0; CAPACITY + LANES];
        Self { packed: zero, depth: zero, count: 0 }
    }
}

/// The samples that a cluster won, in the order in which it won them. If a sample occurs more than once, its last entry
/// is the visible one.
#[derive(Debug, Default)]
pub struct Winners {
    /// Sample indices; only the first [`Winners::len`] are valid.
    sample_index: Vec<i32>,
    /// Numbers of the triangles in their cluster, likewise.
    triangle: Vec<u8>,
    count: usize,
}

impl Winners {
    /// Removes all.
    pub fn clear(&mut self) {
        self.count = 0;
    }

    /// The number of winners.
    pub fn len(&self) -> usize {
        self.count
    }

    /// Are there none?
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Their sample indices.
    pub fn sample_indices(&self) -> &[i32] {
        &self.sample_index[..self.count]
    }

    /// Sample indices and triangles of 16 winners from number `first` on, a multiple of 16. If there are fewer, the
    /// last one is repeated.
    #[inline(always)]
    pub fn sixteen(&mut self, first: usize) -> (&[i32; LANES], &[u8; LANES]) {
        for i in self.count..first + LANES {
            self.sample_index[i] = self.sample_index[self.count - 1];
            self.triangle[i] = self.triangle[self.count - 1];
        }
        let sample_index = self.sample_index[first..].first_chunk().unwrap_or(&[0; LANES]);
        (sample_index, self.triangle[first..].first_chunk().unwrap_or(&[0; LANES]))
    }

    /// Makes room for this many more, plus 16 because they are read and written 16 at a time.
    #[inline(always)]
    fn reserve(&mut self, more: usize) {
        let room = self.count + more + LANES;
        if self.sample_index.len() < room {
            self.grow(room);
        }
    }

    #[cold]
    #[inline(never)]
    fn grow(&mut self, room: usize) {
        self.sample_index.resize(2 * room, 0);
        self.triangle.resize(2 * room, 0);
    }

    /// A writer for the winners of one triangle, at most `most` samples.
    #[inline(always)]
    pub fn of_triangle(&mut self, triangle: u8, most: usize) -> TriangleWinners<'_> {
        self.reserve(most);
        let count = self.count;
        TriangleWinners {
            sample_index: &mut self.sample_index[count..],
            numbers: &mut self.triangle[count..],
            triangle,
            total: &mut self.count,
            count: 0,
        }
    }
}

/// Writer of the winners of one triangle into [`Winners`], which must be committed with [`TriangleWinners::end`].
pub struct TriangleWinners<'a> {
    sample_index: &'a mut [i32],
    numbers: &'a mut [u8],
    triangle: u8,
    /// Number of committed winners of all triangles.
    total: &'a mut usize,
    /// Number of winners of this triangle.
    count: usize,
}

impl TriangleWinners<'_> {
    /// Adds those of 16 samples, given by their indices, that the triangle `won`.
    #[inline(always)]
    pub fn push<S: Simd>(&mut self, simd: S, sample_indices: i32x16<S>, won: u32) {
        append(simd, self.sample_index, self.count, won, sample_indices);
        self.numbers[self.count..self.count + LANES].fill(self.triangle);
        self.count += won.count_ones() as usize;
    }

    /// Commits the winners.
    #[inline(always)]
    pub fn end(self) {
        *self.total += self.count;
    }
}

impl Covered {
    /// Adds the samples of some lanes; `packed` is the sample index with the triangle's number in the upper bits.
    #[inline(always)]
    pub fn push<S: Simd>(&mut self, simd: S, lanes: u32, packed: i32x16<S>, depth: f32x16<S>) {
        append(simd, &mut self.packed, self.count, lanes, packed);
        append(simd, &mut self.depth, self.count, lanes, depth.bitcast());
        self.count += lanes.count_ones() as usize;
    }

    /// Is there no room for another scan?
    #[inline(always)]
    pub fn is_nearly_full(&self) -> bool {
        self.count > CAPACITY - MAX_PER_SCAN
    }

    /// Tests the depths of all samples, one after another, and appends those that pass to the winners.
    #[inline(always)]
    pub fn test(
        &mut self,
        context: &FrameContext,
        first_slot: u32,
        tile: &mut TileMemory,
        winners: &mut Winners,
        counts: &mut BackEndCounts,
    ) {
        let count = std::mem::take(&mut self.count).min(CAPACITY);
        counts.samples_covered += count as u64;
        winners.reserve(count);
        let mut won = winners.count;
        let depths = &mut tile.depth[..];
        let slots = &mut tile.slot[..depths.len()];
        for (&packed, &depth) in self.packed[..count].iter().zip(&self.depth[..count]) {
            let triangle = (packed as u32) >> NUMBER_SHIFT;
            let index = packed as usize & ((1 << NUMBER_SHIFT) - 1);
            let (depth, slot) = (f32::from_bits(depth as u32), first_slot + triangle);
            let before = depths[index];
            let mut wins = depth > before;
            if depth == before {
                wins = lower_primitive(context, slot, slots[index]);
            }
            depths[index] = if wins { depth } else { before };
            slots[index] = if wins { slot } else { slots[index] };
            winners.sample_index[won] = index as i32;
            winners.triangle[won] = triangle as u8;
            won += usize::from(wins);
        }
        winners.count = won;
    }
}
