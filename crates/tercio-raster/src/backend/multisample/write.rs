//! Depth tests: the nearer of old and new is kept at the samples that a triangle covers, and the fragments that it won are
//! added.

use fearless_simd::prelude::*;
use fearless_simd::{
    Simd, f32x4, f32x8, f32x16, i32x16, mask32x4, mask32x8, mask32x16, u32x4, u32x8, u32x16,
};

use super::fragments::{Fragment, NO_FRAGMENT};
use super::memory::SampleMemory;
use crate::context::FrameContext;
use crate::simd::{LANES, part, splat_i};

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
        /// adds its fragment if it won any. The depths are NaN where it does not cover a sample. Precondition: the list has
        /// room.
        #[inline(always)]
        pub fn $name<S: Simd>(&mut self, simd: S, context: &FrameContext, new: Fragment, depth: $floats<S>) {
            let first = usize::from(new.pixel) << self.count_bits;
            let samples = first..first + $lanes;
            let won = part(
                simd,
                #[inline(always)]
                || {
                    let old_depth = &mut self.depth[samples.clone()];
                    let before = $floats::from_slice(simd, old_depth);
                    let mut wins = depth.simd_gt(before);
                    let tie = depth.simd_eq(before);
                    if tie.any_true() {
                        let ties = tie.to_bitmask() as u32 & ((1 << $lanes) - 1);
                        let old = &self.fragment[samples.clone()];
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
            if self.is_by_sample {
                return self.add_by_sample(new.slot, usize::from(new.pixel), won);
            }
            self.list.fragments[self.list.count] = new;
            self.list.count += usize::from(won != 0);
        }
    };
}

impl SampleMemory {
    write_pixel!(write_4, 4, f32x4, u32x4, mask32x4);
    write_pixel!(write_8, 8, f32x8, u32x8, mask32x8);
    write_pixel!(write_16, 16, f32x16, u32x16, mask32x16);

    /// [`SampleMemory::write_4`] in at most 16 pixels, one after another.
    #[inline(always)]
    pub fn write_few<S: Simd>(
        &mut self,
        simd: S,
        context: &FrameContext,
        new: &[Fragment],
        depths: &[[f32; 4]; LANES],
    ) {
        self.list.reserve_pixels();
        if self.is_by_sample {
            for (&new, depths) in new.iter().zip(depths) {
                self.write_4(simd, context, new, f32x4::load_array_ref(simd, depths));
            }
            return;
        }
        // Borrowed once, so that they stay in registers: otherwise every store could change them.
        let Self { depth, fragment, list, count_bits, .. } = self;
        // At most 4; the compiler learns that places do not overflow.
        let (depth_of, count_bits) = (&mut depth[..], *count_bits & 7);
        let fragment_of = &mut fragment[..depth_of.len()];
        let mut count = list.count;
        for (&new, depths) in new.iter().zip(depths) {
            let first = usize::from(new.pixel) << count_bits;
            part(
                simd,
                #[inline(always)]
                || {
                    let (old_depth, old) =
                        (&mut depth_of[first..first + 4], &mut fragment_of[first..first + 4]);
                    let depth = f32x4::load_array_ref(simd, depths);
                    let before = f32x4::from_slice(simd, old_depth);
                    let mut wins = depth.simd_gt(before);
                    let tie = depth.simd_eq(before);
                    if tie.any_true() {
                        let ties = tie.to_bitmask() as u32 & 15;
                        let more = tie_winners(context, ties, |_| new, old, &list.fragments);
                        wins |= mask32x4::from_bitmask(simd, u64::from(more));
                    }
                    wins.select(depth, before).store_slice(old_depth);
                    let number = u32x4::splat(simd, count as u32);
                    wins.select(number, u32x4::from_slice(simd, old)).store_slice(old);
                    list.fragments[count] = new;
                    count += usize::from(wins.any_true());
                },
            );
        }
        list.count = count;
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
    /// new where `covered` has a bit, and adds the fragments that the triangle won. There is no branch on whether it won any,
    /// which cannot be predicted.
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
        if !self.list.has_room() {
            self.list.grow();
        }
        if self.is_by_sample {
            return self.add_by_sample(slot, pixel, won);
        }
        let numbers = self.add_in_pixels(slot, pixel, covered, won);
        part(
            simd,
            #[inline(always)]
            || {
                let shift = i32x16::load_array(simd, self.lane_number_shift);
                let numbers = (splat_i(simd, numbers.in_pixels as i32) >> shift & 15) + numbers.first as i32;
                let old = &mut self.fragment[first..first + LANES];
                let wins = mask32x16::from_bitmask(simd, u64::from(won));
                let numbers: u32x16<S> = numbers.bitcast();
                wins.select(numbers, u32x16::from_slice(simd, old)).store_slice(old);
            },
        );
    }

    /// Adds the fragments of the pixels in which a triangle won some of 16 consecutive samples, one after another.
    /// Precondition: the list has room.
    #[inline(always)]
    fn add_in_pixels(&mut self, slot: u32, pixel: usize, covered: u32, won: u32) -> Numbers {
        let first = self.list.count;
        let Some(new) = self.list.fragments[first..].first_chunk_mut::<LANES>() else {
            unreachable!("room was made")
        };
        let (mut in_pixels, mut added) = (0, 0);
        match self.count_bits {
            // The most common numbers of samples, without branches.
            2 => {
                for at in 0..4 {
                    new[added as usize % LANES] = Fragment::new(slot, pixel + at, covered >> (4 * at) & 15);
                    in_pixels |= added << (4 * at);
                    added += u32::from(won & 15 << (4 * at) != 0);
                }
            }
            4 => {
                new[0] = Fragment::new(slot, pixel, covered);
                added = u32::from(won != 0);
            }
            count_bits => {
                let all = u32::MAX >> (32 - (1 << count_bits));
                for at in 0..LANES >> count_bits {
                    let lane = at << count_bits;
                    new[added as usize % LANES] = Fragment::new(slot, pixel + at, covered >> lane & all);
                    in_pixels |= added << (4 * at);
                    added += u32::from(won >> lane & all != 0);
                }
            }
        }
        self.list.count += added as usize;
        Numbers { first, in_pixels }
    }
}

/// The numbers of the fragments of neighbouring pixels.
struct Numbers {
    /// The first one.
    first: usize,
    /// What to add to it for each pixel, in four bits.
    in_pixels: u32,
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
