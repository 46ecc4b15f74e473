//! Samples that a cluster covers against the depths of the tile.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16};

use super::sieve::Size;
use crate::backend::memory::{TileMemory, lower_primitive};
use crate::context::FrameContext;
use crate::simd::{LANES, append};
use crate::stats::BackEndCounts;

/// The most samples that one scan of 16 triangles finds.
const MOST_AT_ONCE: usize = match Size::Small.most_across() {
    Some(most) => LANES * (most * most) as usize,
    None => 0,
};
/// Room for one scan beside what other scans found.
const CAPACITY: usize = 2 * MOST_AT_ONCE;
/// Where the number of a triangle stands beside a place in the tile memory.
pub const NUMBER_SHIFT: u32 = 16;

/// Covered samples that wait for their depth test, in the order they were found.
#[derive(Debug)]
pub struct Covered {
    /// Places in the tile memory, and the numbers of the triangles in their cluster above [`NUMBER_SHIFT`].
    place: [i32; CAPACITY + LANES],
    /// Depths, as the bits of an `f32`.
    depth: [i32; CAPACITY + LANES],
    count: usize,
}

impl Default for Covered {
    fn default() -> Self {
        let zero = [0; CAPACITY + LANES];
        Self { place: zero, depth: zero, count: 0 }
    }
}

/// The samples that a cluster won, in the order in which it won them: of a sample that stands here more than
/// once the last counts.
#[derive(Debug, Default)]
pub struct Winners {
    /// Places in the tile memory; only the first [`Winners::len`] count.
    place: Vec<i32>,
    /// Numbers of the triangles in their cluster, likewise.
    triangle: Vec<u8>,
    count: usize,
}

impl Winners {
    /// Forgets all.
    pub fn clear(&mut self) {
        self.count = 0;
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.count
    }

    /// There are none.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Their places in the tile memory.
    pub fn places(&self) -> &[i32] {
        &self.place[..self.count]
    }

    /// 16 of them from number `first` on, a multiple of 16: places and triangles. The last is repeated where
    /// there are fewer.
    #[inline(always)]
    pub fn sixteen(&mut self, first: usize) -> (&[i32; LANES], &[u8; LANES]) {
        for i in self.count..first + LANES {
            self.place[i] = self.place[self.count - 1];
            self.triangle[i] = self.triangle[self.count - 1];
        }
        let place = self.place[first..].first_chunk().unwrap_or(&[0; LANES]);
        (place, self.triangle[first..].first_chunk().unwrap_or(&[0; LANES]))
    }

    /// Makes room for some more, and for reading and writing 16 at a time.
    #[inline(always)]
    fn reserve(&mut self, more: usize) {
        let room = self.count + more + LANES;
        if self.place.len() < room {
            self.grow(room);
        }
    }

    #[cold]
    #[inline(never)]
    fn grow(&mut self, room: usize) {
        self.place.resize(2 * room, 0);
        self.triangle.resize(2 * room, 0);
    }

    /// To list what a triangle wins, at most `most` samples.
    #[inline(always)]
    pub fn of_triangle(&mut self, triangle: u8, most: usize) -> TriangleWinners<'_> {
        self.reserve(most);
        let count = self.count;
        TriangleWinners {
            place: &mut self.place[count..],
            numbers: &mut self.triangle[count..],
            triangle,
            total: &mut self.count,
            count: 0,
        }
    }
}

/// What one triangle wins, on its way into [`Winners`].
pub struct TriangleWinners<'a> {
    place: &'a mut [i32],
    numbers: &'a mut [u8],
    triangle: u8,
    /// Of all triangles up to this one.
    total: &'a mut usize,
    count: usize,
}

impl TriangleWinners<'_> {
    /// Adds those of 16 samples, given by their places, that it won.
    #[inline(always)]
    pub fn push<S: Simd>(&mut self, simd: S, places: i32x16<S>, won: u32) {
        append(simd, self.place, self.count, won, places);
        self.numbers[self.count..self.count + LANES].fill(self.triangle);
        self.count += won.count_ones() as usize;
    }

    /// That was all.
    #[inline(always)]
    pub fn end(self) {
        *self.total += self.count;
    }
}

impl Covered {
    /// Adds the samples of some lanes; `place` holds the triangles' numbers too.
    #[inline(always)]
    pub fn push<S: Simd>(&mut self, simd: S, lanes: u32, place: i32x16<S>, depth: f32x16<S>) {
        append(simd, &mut self.place, self.count, lanes, place);
        append(simd, &mut self.depth, self.count, lanes, depth.bitcast());
        self.count += lanes.count_ones() as usize;
    }

    /// Has no room for another scan.
    #[inline(always)]
    pub fn is_nearly_full(&self) -> bool {
        self.count > CAPACITY - MOST_AT_ONCE
    }

    /// Tests all samples, one after another, and lists those that won.
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
        for (&place, &depth) in self.place[..count].iter().zip(&self.depth[..count]) {
            let triangle = (place as u32) >> NUMBER_SHIFT;
            let place = place as usize & ((1 << NUMBER_SHIFT) - 1);
            let (depth, slot) = (f32::from_bits(depth as u32), first_slot + triangle);
            let before = depths[place];
            let mut wins = depth > before;
            if depth == before {
                wins = lower_primitive(context, slot, slots[place]);
            }
            depths[place] = if wins { depth } else { before };
            slots[place] = if wins { slot } else { slots[place] };
            winners.place[won] = place as i32;
            winners.triangle[won] = triangle as u8;
            won += usize::from(wins);
        }
        winners.count = won;
    }
}
