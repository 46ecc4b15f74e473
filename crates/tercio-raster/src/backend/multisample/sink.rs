//! Where fragments go: opaque ones hide each other, the others become layers. Selected at compile time.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x4, f32x8, f32x16, mask32x4, mask32x8, mask32x16};

use super::fragments::{Fragment, FragmentList};
use super::memory::{InPixel, SampleMemory, tie_winners};
use crate::context::FrameContext;
use crate::simd::{LANES, part};

/// What happens to fragments.
pub trait Sink {
    /// Are triangles drawn that may not be opaque?
    const LAYERS: bool;

    /// Tests the depth of a triangle in one pixel.
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
    fn in_pixel<S: Simd>(memory: &mut SampleMemory, simd: S, context: &FrameContext, t: &InPixel) {
        match memory.count_bits {
            ..=2 => memory.write_4(simd, context, t),
            3 => memory.write_8(simd, context, t),
            _ => memory.write_16(simd, context, t),
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

/// The samples at which a triangle in one pixel is in front of what is opaque, and its depths at the pixel's samples.
macro_rules! in_front {
    ($name:ident, $lanes:literal, $floats:ident, $mask:ident) => {
        #[inline(always)]
        fn $name<S: Simd>(
            memory: &SampleMemory,
            simd: S,
            context: &FrameContext,
            t: &InPixel,
        ) -> (u32, [f32; $lanes]) {
            let samples = t.pixel << memory.count_bits..(t.pixel << memory.count_bits) + $lanes;
            part(
                simd,
                #[inline(always)]
                || {
                    let dx = $floats::from_slice(simd, &memory.lane_offset[0][..$lanes]) + t.from_anchor[0];
                    let dy = $floats::from_slice(simd, &memory.lane_offset[1][..$lanes]) + t.from_anchor[1];
                    let [base, nearest] = t.range.map(|depth| $floats::splat(simd, depth));
                    let depth = ((dx * t.slope[0] + dy * t.slope[1]) + base).max(base).min(nearest);
                    let opaque = $floats::from_slice(simd, &memory.depth[samples.clone()]);
                    let covered = $mask::from_bitmask(simd, u64::from(t.covered));
                    let mut front = (covered & depth.simd_gt(opaque)).to_bitmask() as u32;
                    let tie = (covered & depth.simd_eq(opaque)).to_bitmask() as u32 & ((1 << $lanes) - 1);
                    if tie != 0 {
                        let new = Fragment::new(t.slot, t.pixel, t.covered);
                        let old = &memory.fragment[samples];
                        front |= tie_winners(context, tie, |_| new, old, &memory.list.fragments);
                    }
                    (front & ((1 << $lanes) - 1), depth.to_array())
                },
            )
        }
    };
}
in_front!(in_front_4, 4, f32x4, mask32x4);
in_front!(in_front_8, 8, f32x8, mask32x8);
in_front!(in_front_16, 16, f32x16, mask32x16);

impl Sink for Translucent {
    const LAYERS: bool = true;

    #[inline(always)]
    fn in_pixel<S: Simd>(memory: &mut SampleMemory, simd: S, context: &FrameContext, t: &InPixel) {
        match memory.count_bits {
            ..=2 => {
                let (front, depths) = in_front_4(memory, simd, context, t);
                add(memory, context, t, front, &depths);
            }
            3 => {
                let (front, depths) = in_front_8(memory, simd, context, t);
                add(memory, context, t, front, &depths);
            }
            _ => {
                let (front, depths) = in_front_16(memory, simd, context, t);
                add(memory, context, t, front, &depths);
            }
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
            let t = InPixel {
                pixel: pixel + (lane >> memory.count_bits),
                covered: of_pixel(lane),
                slot,
                ..InPixel::default()
            };
            add(memory, context, &t, front >> begin & all, &depths[begin..]);
            front &= !(all << begin);
        }
    }

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
fn add(memory: &mut SampleMemory, context: &FrameContext, t: &InPixel, front: u32, depths: &[f32]) {
    if front == 0 {
        return;
    }
    if !memory.is_by_sample {
        let fragment = Fragment::new(t.slot, t.pixel, t.covered);
        return memory.layers.push(context, fragment, front, depths);
    }
    let mut left = front;
    while left != 0 {
        let sample = left.trailing_zeros() as usize;
        left &= left - 1;
        let fragment = Fragment::new(t.slot, t.pixel, 1 << sample);
        memory.layers.push(context, fragment, 1 << sample, &depths[sample..sample + 1]);
    }
}
