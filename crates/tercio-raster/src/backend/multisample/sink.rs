//! Where fragments go: opaque ones hide each other, the others become layers. Selected at compile time.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x4, f32x8, f32x16, mask32x8, mask32x16};

use super::fragments::{Fragment, FragmentList};
use super::memory::SampleMemory;
use super::write::{InPixel, tie_winners};
use crate::context::FrameContext;
use crate::simd::{LANES, part};

/// What happens to fragments.
pub trait Sink {
    /// Are triangles drawn that may not be opaque?
    const LAYERS: bool;

    /// Tests the depths of at most 16 triangles in one pixel each, of at most 4 samples; depths are NaN at other samples than
    /// those that they cover.
    fn in_small_pixels<S: Simd>(
        memory: &mut SampleMemory,
        simd: S,
        context: &FrameContext,
        new: &[Fragment],
        depths: &[[f32; 4]; LANES],
    );

    /// Tests the depth of a triangle in one pixel of 8 or 16 samples. Precondition: [`Sink::reserve_pixels`].
    fn in_pixel<S: Simd>(memory: &mut SampleMemory, simd: S, context: &FrameContext, t: &InPixel);

    /// Tests the depth of a triangle at 16 consecutive samples, from the first one of a pixel on; `covered` has a bit for
    /// each that the triangle covers.
    fn stamp<S: Simd>(
        memory: &mut SampleMemory,
        simd: S,
        context: &FrameContext,
        pixel: usize,
        covered: u32,
        depth: f32x16<S>,
        slot: u32,
    );

    /// Makes room for the fragments of 16 pixels.
    fn reserve_pixels(memory: &mut SampleMemory);

    /// The list that fragments are added to.
    fn list(memory: &mut SampleMemory) -> &mut FragmentList;

    /// Removes fragments if there are too many.
    fn make_room(memory: &mut SampleMemory, context: &FrameContext);
}

/// The nearest triangle at each sample is kept.
pub struct Opaque;

impl Sink for Opaque {
    const LAYERS: bool = false;

    #[inline(always)]
    fn in_small_pixels<S: Simd>(
        memory: &mut SampleMemory,
        simd: S,
        context: &FrameContext,
        new: &[Fragment],
        depths: &[[f32; 4]; LANES],
    ) {
        memory.write_few(simd, context, new, depths);
    }

    #[inline(always)]
    fn in_pixel<S: Simd>(memory: &mut SampleMemory, simd: S, context: &FrameContext, t: &InPixel) {
        let new = Fragment::new(t.slot, t.pixel, t.covered);
        if memory.count_bits == 3 {
            let depth = depths_8(memory, simd, t);
            memory.write_8(simd, context, new, depth);
        } else {
            let depth = depths_16(memory, simd, t);
            memory.write_16(simd, context, new, depth);
        }
    }

    #[inline(always)]
    fn stamp<S: Simd>(
        memory: &mut SampleMemory,
        simd: S,
        context: &FrameContext,
        pixel: usize,
        covered: u32,
        depth: f32x16<S>,
        slot: u32,
    ) {
        memory.write(simd, context, pixel, covered, depth, slot);
    }

    #[inline(always)]
    fn reserve_pixels(memory: &mut SampleMemory) {
        memory.list.reserve_pixels();
    }

    #[inline(always)]
    fn list(memory: &mut SampleMemory) -> &mut FragmentList {
        &mut memory.list
    }

    #[inline(always)]
    fn make_room(memory: &mut SampleMemory, _: &FrameContext) {
        memory.make_room();
    }
}

/// Every triangle in front of what is opaque is kept.
pub struct Translucent;

/// The depths of a triangle at the samples of one pixel, NaN where it does not cover them.
macro_rules! depths {
    ($name:ident, $lanes:literal, $floats:ident, $mask:ident) => {
        #[inline(always)]
        fn $name<S: Simd>(memory: &SampleMemory, simd: S, t: &InPixel) -> $floats<S> {
            part(
                simd,
                #[inline(always)]
                || {
                    let dx = $floats::from_slice(simd, &memory.lane_offset[0][..$lanes]) + t.from_anchor[0];
                    let dy = $floats::from_slice(simd, &memory.lane_offset[1][..$lanes]) + t.from_anchor[1];
                    let base = $floats::splat(simd, t.range[0]);
                    let nearest = $floats::splat(simd, t.range[1]);
                    let depth = ((dx * t.slope[0] + dy * t.slope[1]) + base).max(base).min(nearest);
                    let covered = $mask::from_bitmask(simd, u64::from(t.covered));
                    covered.select(depth, $floats::splat(simd, f32::NAN))
                },
            )
        }
    };
}
depths!(depths_8, 8, f32x8, mask32x8);
depths!(depths_16, 16, f32x16, mask32x16);

/// The samples at which a triangle in one pixel is in front of what is opaque, from its depths.
macro_rules! in_front {
    ($name:ident, $lanes:literal, $floats:ident) => {
        #[inline(always)]
        fn $name<S: Simd>(
            memory: &SampleMemory,
            simd: S,
            context: &FrameContext,
            new: Fragment,
            depth: $floats<S>,
        ) -> u32 {
            let first = usize::from(new.pixel) << memory.count_bits;
            let samples = first..first + $lanes;
            part(
                simd,
                #[inline(always)]
                || {
                    let opaque = $floats::from_slice(simd, &memory.depth[samples.clone()]);
                    let mut front = depth.simd_gt(opaque).to_bitmask() as u32;
                    let tie = depth.simd_eq(opaque).to_bitmask() as u32 & ((1 << $lanes) - 1);
                    if tie != 0 {
                        let old = &memory.fragment[samples];
                        front |= tie_winners(context, tie, |_| new, old, &memory.list.fragments);
                    }
                    front & ((1 << $lanes) - 1)
                },
            )
        }
    };
}
in_front!(in_front_4, 4, f32x4);
in_front!(in_front_8, 8, f32x8);
in_front!(in_front_16, 16, f32x16);

impl Sink for Translucent {
    const LAYERS: bool = true;

    #[inline(always)]
    fn in_small_pixels<S: Simd>(
        memory: &mut SampleMemory,
        simd: S,
        context: &FrameContext,
        new: &[Fragment],
        depths: &[[f32; 4]; LANES],
    ) {
        for (&new, depths) in new.iter().zip(depths) {
            let front = in_front_4(memory, simd, context, new, f32x4::load_array_ref(simd, depths));
            add(memory, context, new, front, depths);
        }
    }

    #[inline(always)]
    fn in_pixel<S: Simd>(memory: &mut SampleMemory, simd: S, context: &FrameContext, t: &InPixel) {
        let new = Fragment::new(t.slot, t.pixel, t.covered);
        if memory.count_bits == 3 {
            let depth = depths_8(memory, simd, t);
            let front = in_front_8(memory, simd, context, new, depth);
            add(memory, context, new, front, &depth.to_array());
        } else {
            let depth = depths_16(memory, simd, t);
            let front = in_front_16(memory, simd, context, new, depth);
            add(memory, context, new, front, &depth.to_array());
        }
    }

    #[inline(always)]
    fn stamp<S: Simd>(
        memory: &mut SampleMemory,
        simd: S,
        context: &FrameContext,
        pixel: usize,
        covered: u32,
        depth: f32x16<S>,
        slot: u32,
    ) {
        let first = pixel << memory.count_bits;
        let (count, all) = (1 << memory.count_bits, u32::MAX >> (32 - (1 << memory.count_bits)));
        let of_pixel = |lane: usize| covered >> (lane & !(count - 1)) & all;
        let mut front = part(
            simd,
            #[inline(always)]
            || {
                let opaque = f32x16::from_slice(simd, &memory.depth[first..first + LANES]);
                let is_covered = mask32x16::from_bitmask(simd, u64::from(covered));
                let front = (is_covered & depth.simd_gt(opaque)).to_bitmask() as u32;
                let tie = (is_covered & depth.simd_eq(opaque)).to_bitmask() as u32 & 0xffff;
                if tie == 0 {
                    return front & 0xffff;
                }
                let new =
                    |lane: usize| Fragment::new(slot, pixel + (lane >> memory.count_bits), of_pixel(lane));
                let old = &memory.fragment[first..first + LANES];
                (front | tie_winners(context, tie, new, old, &memory.list.fragments)) & 0xffff
            },
        );
        let depths = depth.to_array();
        while front != 0 {
            let lane = front.trailing_zeros() as usize % LANES;
            let begin = lane & !(count - 1);
            let new = Fragment::new(slot, pixel + (lane >> memory.count_bits), of_pixel(lane));
            add(memory, context, new, front >> begin & all, &depths[begin..]);
            front &= !(all << begin);
        }
    }

    #[inline(always)]
    fn reserve_pixels(_: &mut SampleMemory) {}

    #[inline(always)]
    fn list(memory: &mut SampleMemory) -> &mut FragmentList {
        &mut memory.layers.list
    }

    #[inline(always)]
    fn make_room(memory: &mut SampleMemory, context: &FrameContext) {
        memory.layers.make_room(context);
    }
}

/// Adds a triangle in a pixel as a layer at some of the pixel's samples.
#[inline(always)]
fn add(memory: &mut SampleMemory, context: &FrameContext, new: Fragment, front: u32, depths: &[f32]) {
    if front == 0 {
        return;
    }
    if !memory.is_by_sample {
        return memory.layers.push(context, new, front, depths);
    }
    let mut left = front;
    while left != 0 {
        let sample = left.trailing_zeros() as usize;
        left &= left - 1;
        let fragment = Fragment { covered: 1 << sample, ..new };
        memory.layers.push(context, fragment, 1 << sample, &depths[sample..sample + 1]);
    }
}
