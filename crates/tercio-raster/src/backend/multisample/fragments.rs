//! Fragments and lists of them.

use bytemuck::{Pod, Zeroable};
use fearless_simd::prelude::*;
use fearless_simd::{Simd, mask32x16, u32x16};

use crate::backend::memory::lower_primitive;
use crate::context::FrameContext;
use crate::sampling::MAX_SAMPLES;
use crate::simd::{LANES, live_lanes};

/// The fragment of a sample where nothing was drawn.
pub const NO_FRAGMENT: u32 = u32::MAX;

/// A triangle in a pixel. In memory, slot, pixel and samples follow each other, so that 16 fragments are read as vectors.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct Fragment {
    /// Slot of the triangle.
    pub slot: u32,
    /// Place of the pixel: its row in the tile memory times the distance of rows, plus its column.
    pub pixel: u16,
    /// The samples of the pixel at whose centre it is shaded, one bit each: those that the triangle covers, or one.
    pub covered: u16,
}

impl Fragment {
    /// A fragment.
    #[inline(always)]
    pub fn new(slot: u32, pixel: usize, covered: u32) -> Self {
        // As one number, it is written with one store.
        bytemuck::cast(u64::from(slot) | (pixel as u64 & 0xffff) << 32 | u64::from(covered) << 48)
    }

    /// Is it in front of another one at equal depth? It is if its primitive number is lower. Of two pieces of one clipped
    /// triangle, which may overlap after snapping, it is the one whose mask of covered samples is larger.
    pub fn wins_tie(&self, context: &FrameContext, other: &Self) -> bool {
        match self.slot == other.slot {
            true => self.covered > other.covered,
            false => lower_primitive(context, self.slot, other.slot),
        }
    }
}

/// The fragments of a tile, in the order in which they were drawn.
#[derive(Debug, Default)]
pub struct FragmentList {
    /// The fragments; only the first [`FragmentList::count`] are valid.
    pub fragments: Vec<Fragment>,
    /// Number of fragments.
    pub count: usize,
    /// Premultiplied linear colours of the fragments; valid where they are shaded.
    pub colors: Vec<[f32; 4]>,
    /// Normals of the fragments, likewise, if they are requested.
    pub normals: Vec<[f32; 3]>,
    /// Number of the first fragment that is not shaded late: the others are shaded with their cluster.
    pub late: usize,
    /// Number of the first fragment of the cluster that is being drawn.
    pub of_cluster: usize,
}

impl FragmentList {
    /// Removes all.
    pub fn clear(&mut self) {
        (self.count, self.late, self.of_cluster) = (0, 0, 0);
    }

    /// Is there room for [`LANES`] more fragments? As many remain behind them, because fragments are read 16 at a time.
    #[inline(always)]
    pub fn has_room(&self) -> bool {
        self.count + 2 * LANES <= self.fragments.len()
    }

    /// Makes room for the fragments of 16 pixels, also if each of their samples is one.
    #[inline(always)]
    pub fn reserve_pixels(&mut self) {
        if self.count + LANES * (MAX_SAMPLES + 1) > self.fragments.len() {
            self.grow();
        }
    }

    /// Makes room for more fragments: those of 16 pixels at least.
    #[cold]
    #[inline(never)]
    pub fn grow(&mut self) {
        self.fragments.resize(2 * self.count + LANES * (MAX_SAMPLES + 1), Fragment::default());
    }

    /// Makes room for this many fragments and their colours, without more memory than that.
    pub fn grow_to(&mut self, count: usize) {
        self.fragments.reserve_exact(count.saturating_sub(self.fragments.len()));
        self.fragments.resize(count.max(self.fragments.len()), Fragment::default());
        self.colors.reserve_exact((count + LANES).saturating_sub(self.colors.len()));
    }

    /// Adds a fragment. Precondition: there is room.
    #[inline(always)]
    pub fn push(&mut self, fragment: Fragment) {
        self.fragments[self.count] = fragment;
        self.count += 1;
    }

    /// Declares that all fragments added so far are not shaded with a cluster, but late.
    pub fn all_are_late(&mut self) {
        self.late = self.count;
    }

    /// Begins a cluster: the fragments that follow belong to it.
    pub fn begin_cluster(&mut self) {
        self.of_cluster = self.count;
    }

    /// Slots of the fragments from number `first` on, and their pixels with the samples in the upper 16 bits. If there are
    /// fewer than 16, the first is repeated.
    #[inline(always)]
    pub fn sixteen<S: Simd>(&self, simd: S, first: usize) -> [u32x16<S>; 2] {
        let words: &[u32] = bytemuck::cast_slice(&self.fragments[first..first + LANES]);
        let low = u32x16::from_slice(simd, &words[..LANES]);
        let high = u32x16::from_slice(simd, &words[LANES..]);
        let live = mask32x16::from_bitmask(simd, u64::from(live_lanes(self.count - first)));
        let (slot, place) = (low.unzip_low(high), low.unzip_high(high));
        [live.select(slot, u32x16::splat(simd, words[0])), live.select(place, u32x16::splat(simd, words[1]))]
    }

    /// Makes room for the colours of all fragments, which are written 16 at a time, and for their normals if they are
    /// requested.
    pub fn resize_shaded(&mut self, normals: bool) {
        let room = self.count + LANES;
        self.colors.resize(room.max(self.colors.len()), [0.0; 4]);
        if normals {
            self.normals.resize(self.count.max(self.normals.len()), [0.0; 3]);
        }
    }

    /// Removes the fragments whose new number is [`NO_FRAGMENT`], and calls `moved(from, to)` for each of the others in
    /// order. Returns the new numbers.
    pub fn retain(
        &mut self,
        mut keeps: impl FnMut(usize) -> bool,
        mut moved: impl FnMut(usize, usize),
    ) -> Vec<u32> {
        let (mut numbers, mut kept) = (vec![NO_FRAGMENT; self.count], 0);
        let (mut late, mut of_cluster) = (0, 0);
        for (number, new) in numbers.iter_mut().enumerate() {
            if !keeps(number) {
                continue;
            }
            *new = kept as u32;
            self.fragments[kept] = self.fragments[number];
            if number < self.colors.len() {
                self.colors[kept] = self.colors[number];
            }
            if number < self.normals.len() {
                self.normals[kept] = self.normals[number];
            }
            moved(number, kept);
            late += usize::from(number < self.late);
            of_cluster += usize::from(number < self.of_cluster);
            kept += 1;
        }
        (self.count, self.late, self.of_cluster) = (kept, late, of_cluster);
        numbers
    }
}
