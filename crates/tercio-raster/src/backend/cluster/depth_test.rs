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
/// The bits of the sample index in such a word.
const INDEX_MASK: i32 = (1 << NUMBER_SHIFT) - 1;

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
    /// As in [`Covered`]; only the first [`Winners::len`] are valid.
    packed: Vec<i32>,
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
    pub fn sample_indices(&self) -> impl Iterator<Item = i32> {
        self.packed[..self.count].iter().map(|packed| packed & INDEX_MASK)
    }

    /// Sample indices and triangles of 16 winners from number `first` on, a multiple of 16. If there are fewer, the
    /// last one is repeated.
    #[inline(always)]
    pub fn sixteen(&mut self, first: usize) -> ([i32; LANES], [u8; LANES]) {
        for i in self.count..first + LANES {
            self.packed[i] = self.packed[self.count - 1];
        }
        let packed = self.packed[first..].first_chunk().unwrap_or(&[0; LANES]);
        let (mut sample_indices, mut triangles) = ([0; LANES], [0; LANES]);
        for lane in 0..LANES {
            sample_indices[lane] = packed[lane] & INDEX_MASK;
            triangles[lane] = (packed[lane] >> NUMBER_SHIFT) as u8;
        }
        (sample_indices, triangles)
    }

    /// Makes room for this many more, plus 16 because they are read and written 16 at a time.
    #[inline(always)]
    fn reserve(&mut self, more: usize) {
        let room = self.count + more + LANES;
        if self.packed.len() < room {
            self.grow(room);
        }
    }

    #[cold]
    #[inline(never)]
    fn grow(&mut self, room: usize) {
        self.packed.resize(2 * room, 0);
    }

    /// A writer for the winners of one triangle, at most `most` samples.
    #[inline(always)]
    pub fn of_triangle(&mut self, triangle: u8, most: usize) -> TriangleWinners<'_> {
        self.reserve(most);
        TriangleWinners {
            packed: &mut self.packed[self.count..],
            number: i32::from(triangle) << NUMBER_SHIFT,
            total: &mut self.count,
            count: 0,
        }
    }
}

/// Writer of the winners of one triangle into [`Winners`], which must be committed with [`TriangleWinners::end`].
pub struct TriangleWinners<'a> {
    packed: &'a mut [i32],
    /// The triangle, in the bits from [`NUMBER_SHIFT`] on.
    number: i32,
    /// Number of committed winners of all triangles.
    total: &'a mut usize,
    /// Number of winners of this triangle.
    count: usize,
}

impl TriangleWinners<'_> {
    /// Adds those of 16 samples, given by their indices, that the triangle `won`.
    #[inline(always)]
    pub fn push<S: Simd>(&mut self, simd: S, sample_indices: i32x16<S>, won: u32) {
        append(simd, self.packed, self.count, won, sample_indices | self.number);
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
        winners.reserve(CAPACITY);
        let mut won = 0;
        // A bound that is a power of two costs no branch.
        let Some(won_here) = winners.packed[winners.count..].first_chunk_mut::<CAPACITY>() else {
            unreachable!("room was made")
        };
        let depths = &mut tile.depth[..];
        let slots = &mut tile.slot[..depths.len()];
        for (&packed, &depth) in self.packed[..count].iter().zip(&self.depth[..count]) {
            let triangle = (packed as u32) >> NUMBER_SHIFT;
            let index = (packed & INDEX_MASK) as usize;
            let (depth, slot) = (f32::from_bits(depth as u32), first_slot + triangle);
            let before = depths[index];
            let mut wins = depth > before;
            if depth == before {
                wins = lower_primitive(context, slot, slots[index]);
            }
            depths[index] = if wins { depth } else { before };
            slots[index] = if wins { slot } else { slots[index] };
            won_here[won % CAPACITY] = packed;
            won += usize::from(wins);
        }
        winners.count += won;
    }
}
