//! The tile memory: depth and fragment of every sample of a tile, and the list of fragments.

use fearless_simd::prelude::*;
use fearless_simd::{
    Simd, f32x4, f32x8, f32x16, i32x16, mask32x4, mask32x8, mask32x16, u32x4, u32x8, u32x16,
};

use super::blend::Blended;
use super::fragments::{Fragment, FragmentList, NO_FRAGMENT};
use super::layers::Layers;
use crate::context::FrameContext;
use crate::sampling::SampleShading;
use crate::screen::PixelRect;
use crate::simd::{LANE_NUMBERS, LANES, part, splat, splat_i};

/// A triangle in one pixel, to be tested at the pixel's samples.
#[derive(Default)]
pub struct InPixel {
    /// Place of the pixel.
    pub pixel: usize,
    /// The samples that the triangle covers, one bit each; not 0.
    pub covered: u32,
    /// Slot of the triangle.
    pub slot: u32,
    /// From the triangle's anchor to the first cell of the pixel, in sub-pixels.
    pub from_anchor: [f32; 2],
    /// Increments of depth per sub-pixel to the right and downwards.
    pub slope: [f32; 2],
    /// Smallest and largest depth of the triangle.
    pub range: [f32; 2],
}

/// Depth test of a triangle in one pixel, in vectors of as many lanes as the pixel has samples: a wider store would delay
/// the loads of the pixels beside it.
macro_rules! write_pixel {
    ($name:ident, $lanes:literal, $floats:ident, $numbers:ident, $mask:ident) => {
        /// Depth test of a triangle in one pixel: keeps the nearer of old and new where the triangle covers a sample, and
        /// adds its fragment if it won any.
        #[inline(always)]
        pub fn $name<S: Simd>(&mut self, simd: S, context: &FrameContext, t: &InPixel) {
            let samples = t.pixel << self.count_bits..(t.pixel << self.count_bits) + $lanes;
            let won = part(
                simd,
                #[inline(always)]
                || {
                    let dx = $floats::from_slice(simd, &self.lane_offset[0][..$lanes]) + t.from_anchor[0];
                    let dy = $floats::from_slice(simd, &self.lane_offset[1][..$lanes]) + t.from_anchor[1];
                    let [base, nearest] = t.range.map(|depth| $floats::splat(simd, depth));
                    let depth = ((dx * t.slope[0] + dy * t.slope[1]) + base).max(base).min(nearest);
                    let old_depth = &mut self.depth[samples.clone()];
                    let before = $floats::from_slice(simd, old_depth);
                    let is_covered = $mask::from_bitmask(simd, u64::from(t.covered));
                    let mut wins = is_covered & depth.simd_gt(before);
                    let tie = is_covered & depth.simd_eq(before);
                    if tie.any_true() {
                        let ties = tie.to_bitmask() as u32 & ((1 << $lanes) - 1);
                        let old = &self.fragment[samples.clone()];
                        let new = Fragment::new(t.slot, t.pixel, t.covered);
                        let more = tie_winners(context, ties, |_| new, old, &self.list.fragments);
                        wins |= $mask::from_bitmask(simd, u64::from(more));
                    }
                    wins.select(depth, before).store_slice(old_depth);
                    let old = &mut self.fragment[samples];
                    let number = $numbers::splat(simd, self.list.count as u32);
                    wins.select(number, $numbers::from_slice(simd, old)).store_slice(old);
                    wins.to_bitmask() as u32 & ((1 << $lanes) - 1)
                },
            );
            if won != 0 {
                self.add_in_pixel(t, won);
            }
        }
    };
}

/// Depth and fragment of every sample of a tile.
///
/// The samples of a pixel are side by side. The tile's pixels include those around it that the filter needs.
#[derive(Debug, Default)]
pub struct SampleMemory {
    /// Depth, 0 where nothing was drawn.
    pub depth: Vec<f32>,
    /// Number of the fragment, [`NO_FRAGMENT`] where nothing was drawn.
    pub fragment: Vec<u32>,
    /// The fragments of opaque triangles. Those that were hidden later remain until [`SampleMemory::make_room`] removes
    /// them.
    pub list: FragmentList,
    /// The fragments of other triangles.
    pub layers: Layers,
    /// What the layers amount to, if the frame may have any.
    pub blended: Blended,
    /// The pixels in memory.
    pub rect: PixelRect,
    /// The pixels of the tile that are inside the picture.
    pub own: PixelRect,
    /// log2 of the distance of two rows, in pixels.
    pub stride_bits: u32,
    /// log2 of the number of samples per pixel.
    pub count_bits: u32,
    /// Every sample is a fragment of its own.
    pub is_by_sample: bool,
    /// Columns and rows of cells of 16 consecutive samples, counted from the first cell of the first one's pixel.
    pub lane_cells: [[i32; LANES]; 2],
    /// The same in sub-pixels.
    pub lane_offset: [[f32; LANES]; 2],
    /// Four times the number of the pixel of each of these samples.
    lane_number_shift: [i32; LANES],
}

impl SampleMemory {
    /// Resizes and clears the memory for a tile.
    pub fn clear(&mut self, context: &FrameContext, tile: u32) {
        let size = [context.view.width, context.view.height];
        let halo = context.grid.halo;
        self.own = context.grid.rect(tile, size);
        self.rect = self.own.grow(halo as i32).intersect(context.picture());
        self.stride_bits = ((1 << context.grid.shift) + 2 * halo).next_power_of_two().trailing_zeros();
        let cells = &context.cells;
        self.count_bits = cells.count_bits();
        // The fragments of `write` are numbered for two samples and more.
        let is_by_sample = context.settings.sampling.shading == SampleShading::Sample;
        self.is_by_sample = is_by_sample || cells.count == 1;
        for lane in 0..LANES {
            let cell = cells.cells[lane % cells.count];
            let pixel = (lane >> self.count_bits) as i32;
            self.lane_number_shift[lane] = 4 * pixel;
            let cell = [(pixel << cells.cell_bits()) + cell[0], cell[1]];
            for (axis, cell) in cell.into_iter().enumerate() {
                self.lane_cells[axis][lane] = cell;
                self.lane_offset[axis][lane] = (cell << cells.pitch_bits) as f32;
            }
        }
        let rows = (self.rect.y1 - self.rect.y0 + 1) as usize;
        // Samples are read and written 16 at a time.
        let samples = (rows << self.stride_bits << self.count_bits) + LANES;
        self.depth.clear();
        self.depth.resize(samples, 0.0);
        self.fragment.clear();
        self.fragment.resize(samples, NO_FRAGMENT);
        self.list.clear();
        if context.is_translucent() {
            let depths_each = if self.is_by_sample { 1 } else { cells.count };
            self.layers.clear(context, rows << self.stride_bits, depths_each);
        }
        self.blended.clear(0, self.count_bits, false);
    }

    /// The place of a pixel of the picture.
    #[inline(always)]
    pub fn pixel(&self, x: i32, y: i32) -> usize {
        ((y - self.rect.y0) as usize) << self.stride_bits | (x - self.rect.x0) as usize
    }

    /// Is anything drawn at a sample?
    #[inline(always)]
    pub fn is_drawn(&self, sample: usize) -> bool {
        self.fragment[sample] != NO_FRAGMENT || self.blended.is_at(sample)
    }

    /// Is every sample of some pixels in memory nearer than this depth?
    #[inline(always)]
    pub fn all_nearer<S: Simd>(&self, simd: S, rect: PixelRect, depth: f32) -> bool {
        if rect.is_empty() {
            return true;
        }
        let depth = splat(simd, depth);
        let lanes = i32x16::load_array(simd, LANE_NUMBERS);
        let samples = (rect.x1 - rect.x0 + 1) << self.count_bits;
        for y in rect.y0..rect.y1 + 1 {
            let first = self.pixel(rect.x0, y) << self.count_bits;
            let mut done = 0;
            while done < samples {
                let inside = lanes.simd_lt(splat_i(simd, samples - done));
                let at = first + done as usize;
                let stamp = f32x16::from_slice(simd, &self.depth[at..at + LANES]);
                if (stamp.simd_le(depth) & inside).any_true() {
                    return false;
                }
                done += LANES as i32;
            }
        }
        true
    }

    write_pixel!(write_4, 4, f32x4, u32x4, mask32x4);
    write_pixel!(write_8, 8, f32x8, u32x8, mask32x8);
    write_pixel!(write_16, 16, f32x16, u32x16, mask32x16);

    /// Adds the fragment of a triangle that won some samples of a pixel, which have its number already.
    #[inline(always)]
    fn add_in_pixel(&mut self, t: &InPixel, won: u32) {
        if !self.list.has_room() {
            self.list.grow();
        }
        if self.is_by_sample {
            return self.add_by_sample(t.slot, t.pixel, won);
        }
        self.list.push(Fragment::new(t.slot, t.pixel, t.covered));
    }

    /// Adds a fragment for every sample that a triangle won, of 16 samples from the first one of a pixel on.
    fn add_by_sample(&mut self, slot: u32, pixel: usize, won: u32) {
        let first = pixel << self.count_bits;
        let mut left = won;
        while left != 0 {
            let lane = left.trailing_zeros();
            left &= left - 1;
            let at = pixel + (lane >> self.count_bits) as usize;
            self.fragment[first + lane as usize] = self.list.count as u32;
            self.list.push(Fragment::new(slot, at, 1 << (lane & ((1 << self.count_bits) - 1))));
        }
    }

    /// Depth test of a triangle at 16 consecutive samples, from the first one of a pixel on: keeps the nearer of old and
    /// new where `covered` has a bit, and adds the fragments that the triangle won.
    #[inline(always)]
    pub fn write<S: Simd>(
        &mut self,
        simd: S,
        context: &FrameContext,
        pixel: usize,
        covered: u32,
        depth: f32x16<S>,
        slot: u32,
    ) {
        let first = pixel << self.count_bits;
        let won = part(
            simd,
            #[inline(always)]
            || {
                let old_depth = &mut self.depth[first..first + LANES];
                let before = f32x16::from_slice(simd, old_depth);
                let is_covered = mask32x16::from_bitmask(simd, u64::from(covered));
                let mut wins = is_covered & depth.simd_gt(before);
                let tie = is_covered & depth.simd_eq(before);
                if tie.any_true() {
                    let old = &self.fragment[first..first + LANES];
                    let ties = tie.to_bitmask() as u32 & 0xffff;
                    let count_bits = self.count_bits;
                    let all = u32::MAX >> (32 - (1 << count_bits));
                    let new = |lane: usize| {
                        let first = lane >> count_bits << count_bits;
                        Fragment::new(slot, pixel + (lane >> count_bits), covered >> first & all)
                    };
                    let more = tie_winners(context, ties, new, old, &self.list.fragments);
                    wins |= mask32x16::from_bitmask(simd, u64::from(more));
                }
                wins.select(depth, before).store_slice(old_depth);
                wins.to_bitmask() as u32 & 0xffff
            },
        );
        if won == 0 {
            return;
        }
        let count = 1u32 << self.count_bits;
        let all = u32::MAX >> (32 - count);
        if !self.list.has_room() {
            self.list.grow();
        }
        if self.is_by_sample {
            return self.add_by_sample(slot, pixel, won);
        }
        // The fragments of the pixels in which the triangle won a sample are numbered one after another; `numbers` has the
        // number of each pixel in four bits.
        let (mut numbers, mut added) = (0, 0);
        let Some(new) = self.list.fragments[self.list.count..].first_chunk_mut::<LANES>() else {
            unreachable!("room was made")
        };
        for at in 0..LANES as u32 >> self.count_bits {
            let lane = at << self.count_bits;
            new[added as usize % LANES] = Fragment::new(slot, pixel + at as usize, covered >> lane & all);
            numbers |= added << (4 * at);
            added += u32::from(won >> lane & all != 0);
        }
        part(
            simd,
            #[inline(always)]
            || {
                let shift = i32x16::load_array(simd, self.lane_number_shift);
                let numbers = (splat_i(simd, numbers as i32) >> shift & 15) + self.list.count as i32;
                let old = &mut self.fragment[first..first + LANES];
                let wins = mask32x16::from_bitmask(simd, u64::from(won));
                let numbers: u32x16<S> = numbers.bitcast();
                wins.select(numbers, u32x16::from_slice(simd, old)).store_slice(old);
            },
        );
        self.list.count += added as usize;
    }

    /// Removes hidden fragments if there are many: more than four per sample, so that the memory of a tile is bounded.
    #[inline(always)]
    pub fn make_room(&mut self) {
        if self.list.count > 4 * self.fragment.len() {
            self.compact();
        }
    }

    /// Which fragments are visible at a sample.
    pub fn visible_fragments(&self) -> Vec<bool> {
        let mut is_visible = vec![false; self.list.count];
        for &fragment in self.fragment.iter().filter(|&&f| f != NO_FRAGMENT) {
            is_visible[fragment as usize] = true;
        }
        is_visible
    }

    /// Removes hidden fragments; the others keep their order.
    #[cold]
    #[inline(never)]
    fn compact(&mut self) {
        let is_visible = self.visible_fragments();
        let numbers = self.list.retain(|number| is_visible[number], |_, _| ());
        for fragment in self.fragment.iter_mut().filter(|f| **f != NO_FRAGMENT) {
            *fragment = numbers[*fragment as usize];
        }
    }

    /// Merges another memory of the same tile, in both of which all fragments are late: the nearer samples win.
    pub fn merge(&mut self, context: &FrameContext, other: &Self) {
        let mut numbers = vec![NO_FRAGMENT; other.list.count];
        for (at, (&depth, &theirs)) in other.depth.iter().zip(&other.fragment).enumerate() {
            if theirs == NO_FRAGMENT {
                continue;
            }
            let (before, own) = (self.depth[at], self.fragment[at]);
            let new = other.list.fragments[theirs as usize];
            let is_first = || own == NO_FRAGMENT || new.wins_tie(context, &self.list.fragments[own as usize]);
            if depth > before || depth == before && is_first() {
                let number = &mut numbers[theirs as usize];
                if *number == NO_FRAGMENT {
                    *number = self.list.count as u32;
                    if !self.list.has_room() {
                        self.list.grow();
                    }
                    self.list.push(new);
                }
                (self.depth[at], self.fragment[at]) = (depth, *number);
            }
        }
        self.list.all_are_late();
        self.make_room();
    }

    /// Number of pixels of the tile that show a triangle.
    pub fn visible(&self) -> u64 {
        let rows = self.own.y0..=self.own.y1;
        let pixels = rows.flat_map(|y| (self.own.x0..=self.own.x1).map(move |x| (x, y)));
        let is_drawn = |(x, y)| {
            let first = self.pixel(x, y) << self.count_bits;
            (first..first + (1 << self.count_bits)).any(|sample| self.is_drawn(sample))
        };
        pixels.map(|at| u64::from(is_drawn(at))).sum()
    }
}

/// Which of the lanes of equal depth the new fragment wins.
#[cold]
#[inline(never)]
pub fn tie_winners(
    context: &FrameContext,
    ties: u32,
    new: impl Fn(usize) -> Fragment,
    old: &[u32],
    fragments: &[Fragment],
) -> u32 {
    let mut wins = 0;
    for (lane, &old) in old.iter().enumerate().filter(|(lane, _)| ties >> lane & 1 == 1) {
        let is_first = old == NO_FRAGMENT || new(lane).wins_tie(context, &fragments[old as usize]);
        wins |= u32::from(is_first) << lane;
    }
    wins
}
