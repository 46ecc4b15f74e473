//! Blends layers: sorted by their visibility keys, the nearest first, over what is opaque behind them.

use std::ops::Range;

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x4, f32x8, f32x16, mask32x4, mask32x8, mask32x16};

use super::layers::Layers;
use super::load::Origin;
use super::memory::SampleMemory;
use crate::context::FrameContext;
use crate::simd::part;

/// What the layers of each sample of a tile amount to. The samples of a pixel are lanes of a vector of at least 4.
#[derive(Debug, Default)]
pub struct Blended {
    /// Premultiplied linear colours: four vectors for each pixel.
    color: Vec<f32>,
    /// The share of light that passes all layers, a vector for each pixel; 1 where there is none.
    passing: Vec<f32>,
    /// The nearest layer at each sample, if it is needed for anything but colours; valid where `passing` is below 1.
    nearest: Vec<Nearest>,
    /// log2 of the number of samples per pixel.
    count_bits: u32,
    /// log2 of the number of lanes of a vector.
    lane_bits: u32,
}

/// The nearest layer at a sample.
#[derive(Clone, Copy, Debug, Default)]
pub struct Nearest {
    /// Its depth.
    pub depth: f32,
    /// Slot of its triangle.
    pub slot: u32,
    /// Its normal, if normals are requested.
    pub normal: [f32; 3],
}

impl Blended {
    /// Clears the samples of some pixels: no layers.
    pub fn clear(&mut self, pixels: usize, count_bits: u32, nearest: bool) {
        (self.count_bits, self.lane_bits) = (count_bits, count_bits.max(2));
        self.color.clear();
        self.color.resize((4 * pixels) << self.lane_bits, 0.0);
        self.passing.clear();
        self.passing.resize(pixels << self.lane_bits, 1.0);
        self.nearest.resize(if nearest { pixels << count_bits } else { 0 }, Nearest::default());
    }

    /// The index of a sample in `passing`.
    #[inline(always)]
    fn lane(&self, sample: usize) -> usize {
        let (pixel, sample) = (sample >> self.count_bits, sample & ((1 << self.count_bits) - 1));
        pixel << self.lane_bits | sample
    }

    /// The index of a channel of a sample in `color`.
    #[inline(always)]
    fn channel(&self, sample: usize, k: usize) -> usize {
        let (pixel, sample) = (sample >> self.count_bits, sample & ((1 << self.count_bits) - 1));
        (4 * pixel + k) << self.lane_bits | sample
    }

    /// May there be layers?
    pub fn is_in_use(&self) -> bool {
        !self.passing.is_empty()
    }

    /// Are there layers at a sample?
    #[inline(always)]
    pub fn is_at(&self, sample: usize) -> bool {
        self.passing.get(self.lane(sample)).is_some_and(|&passing| passing < 1.0)
    }

    /// Does any light pass the layers of some pixels in a row?
    fn passes_any(&self, pixels: Range<usize>) -> bool {
        let lanes = &self.passing[pixels.start << self.lane_bits..pixels.end << self.lane_bits];
        let of_pixel = |pixel: &[f32]| pixel[..1 << self.count_bits].iter().any(|&passing| passing > 0.0);
        lanes.chunks_exact(1 << self.lane_bits).any(of_pixel)
    }

    /// The premultiplied linear colour of a sample over what is behind its layers.
    #[inline(always)]
    pub fn over(&self, sample: usize, behind: [f32; 4]) -> [f32; 4] {
        let passing = self.passing[self.lane(sample)];
        let color = std::array::from_fn(|k| self.color[self.channel(sample, k)]);
        if passing == 0.0 {
            return color;
        }
        std::array::from_fn(|k| color[k] + passing * behind[k])
    }

    /// The nearest layer of a sample that has layers.
    pub fn nearest(&self, sample: usize) -> Nearest {
        self.nearest[sample]
    }

    /// Adds the next layer to a sample; false if nothing behind it is visible.
    #[inline(always)]
    fn add(&mut self, layers: &Layers, sample: usize, number: usize, depth: f32) -> bool {
        let color = layers.list.colors[number];
        let passes = 1.0 - color[3];
        if passes == 1.0 {
            return true;
        }
        let lane = self.lane(sample);
        let passing = self.passing[lane];
        if passing == 1.0 && !self.nearest.is_empty() {
            let slot = layers.list.fragments[number].slot;
            let normal = layers.list.normals.get(number).copied().unwrap_or_default();
            self.nearest[sample] = Nearest { depth, slot, normal };
        }
        for (k, &c) in color.iter().enumerate() {
            let channel = self.channel(sample, k);
            self.color[channel] += passing * c;
        }
        self.passing[lane] = passing * passes;
        self.passing[lane] > 0.0
    }
}

/// Sorts the layers of a pixel.
#[derive(Debug, Default)]
pub struct Order {
    /// The fragments of the pixel, ordered by the first depth of each.
    of_pixel: Vec<(f32, u32)>,
    /// Those at a sample, with their depths there.
    at_sample: Vec<(f32, u32)>,
}

/// Adds the layers of a pixel to all of its samples at a time, in an order that was made for one depth of each; false, and
/// nothing added, if it is not the order at every sample.
macro_rules! blend_pixel {
    ($name:ident, $lanes:literal, $floats:ident, $mask:ident) => {
        #[inline(always)]
        fn $name<S: Simd>(
            simd: S,
            layers: &Layers,
            order: &[(f32, u32)],
            pixel: usize,
            blended: &mut Blended,
        ) -> bool {
            part(
                simd,
                #[inline(always)]
                || {
                    let lanes = pixel * $lanes..(pixel + 1) * $lanes;
                    let channels = &mut blended.color[4 * lanes.start..4 * lanes.end];
                    let passing_of = &mut blended.passing[lanes];
                    let zero = $floats::splat(simd, 0.0);
                    let mut sum: [_; 4] =
                        std::array::from_fn(|k| $floats::from_slice(simd, &channels[k * $lanes..][..$lanes]));
                    let mut passing = $floats::from_slice(simd, passing_of);
                    let mut depth_before = $floats::splat(simd, f32::INFINITY);
                    for &(_, number) in order {
                        let number = number as usize;
                        let is_layer = $mask::from_bitmask(simd, u64::from(layers.mask(number)));
                        let depth = match layers.depths_of(number) {
                            [only] => $floats::splat(simd, *only),
                            depths => $floats::from_slice(simd, &depths[..$lanes]),
                        };
                        if (is_layer & depth.simd_ge(depth_before)).any_true() {
                            return false;
                        }
                        depth_before = is_layer.select(depth, depth_before);
                        let color = layers.list.colors[number];
                        let passes = 1.0 - color[3];
                        if passes == 1.0 {
                            continue;
                        }
                        let light = is_layer.select(passing, zero);
                        for (sum, c) in sum.iter_mut().zip(color) {
                            *sum += light * c;
                        }
                        passing = is_layer.select(passing * passes, passing);
                    }
                    for (k, sum) in sum.into_iter().enumerate() {
                        sum.store_slice(&mut channels[k * $lanes..][..$lanes]);
                    }
                    passing.store_slice(passing_of);
                    true
                },
            )
        }
    };
}
blend_pixel!(blend_4, 4, f32x4, mask32x4);
blend_pixel!(blend_8, 8, f32x8, mask32x8);
blend_pixel!(blend_16, 16, f32x16, mask32x16);

/// Is anything visible behind the layers that are blended?
pub fn is_unfinished(memory: &SampleMemory) -> bool {
    let (rect, bits) = (memory.rect, memory.stride_bits);
    let width = (rect.x1 - rect.x0 + 1) as usize;
    let rows = 0..(rect.y1 - rect.y0 + 1) as usize;
    rows.map(|row| row << bits).any(|first| memory.blended.passes_any(first..first + width))
}

/// Blends all layers of a slice of depth, which are shaded, behind those that were blended before.
#[inline(always)]
pub fn slice<S: Simd>(simd: S, context: &FrameContext, memory: &mut SampleMemory, order: &mut Order) {
    let SampleMemory { layers, blended, rect, count_bits, stride_bits, origins, .. } = memory;
    for row in 0..(rect.y1 - rect.y0 + 1) as usize {
        for pixel in row << *stride_bits..(row << *stride_bits) + (rect.x1 - rect.x0 + 1) as usize {
            order.of_pixel.clear();
            order.of_pixel.extend(layers.in_pixel(pixel).map(|number| {
                let sample = layers.mask(number as usize).trailing_zeros() as usize;
                (layers.depth(number as usize, sample), number)
            }));
            if order.of_pixel.is_empty() {
                continue;
            }
            sort(&mut order.of_pixel);
            let needs_nearest = !blended.nearest.is_empty();
            let is_blended = !needs_nearest
                && match count_bits {
                    ..=2 => blend_4(simd, layers, &order.of_pixel, pixel, blended),
                    3 => blend_8(simd, layers, &order.of_pixel, pixel, blended),
                    _ => blend_16(simd, layers, &order.of_pixel, pixel, blended),
                };
            if !is_blended {
                samples((context, origins), layers, pixel, order, blended);
            }
        }
    }
}

/// Sorts layers by depth, the nearest first. They come almost in the reverse order: clusters are drawn front to back, and the
/// last layer is listed first.
#[inline(always)]
fn sort(layers: &mut [(f32, u32)]) {
    const INSERTION_SORT: usize = 32;
    layers.reverse();
    if layers.len() > INSERTION_SORT {
        return layers.sort_by(|a, b| b.0.total_cmp(&a.0));
    }
    for i in 1..layers.len() {
        let (new, mut at) = (layers[i], i);
        while at > 0 && layers[at - 1].0 < new.0 {
            layers[at] = layers[at - 1];
            at -= 1;
        }
        layers[at] = new;
    }
}

/// Blends the layers of a pixel sample by sample, each in its own order.
#[inline(never)]
fn samples(
    (context, origins): (&FrameContext, &[Origin]),
    layers: &Layers,
    pixel: usize,
    order: &mut Order,
    blended: &mut Blended,
) {
    let in_front = |a: &(f32, u32), b: &(f32, u32)| {
        b.0.total_cmp(&a.0).then_with(|| {
            let [new, old] = [a, b].map(|layer| &layers.list.fragments[layer.1 as usize]);
            let primitive = |slot: u32| origins.get(slot as usize).map(|origin| origin.primitive);
            match (primitive(new.slot), primitive(old.slot)) {
                (Some(new), Some(old)) => new.cmp(&old),
                _ => new.wins_tie(context, old).cmp(&old.wins_tie(context, new)).reverse(),
            }
        })
    };
    let Order { of_pixel, at_sample } = order;
    for sample in 0..1 << blended.count_bits {
        let there = of_pixel.iter().filter(|layer| layers.mask(layer.1 as usize) >> sample & 1 == 1);
        at_sample.clear();
        at_sample.extend(there.map(|layer| (layers.depth(layer.1 as usize, sample), layer.1)));
        at_sample.sort_by(in_front);
        for &(depth, number) in &*at_sample {
            if !blended.add(layers, (pixel << blended.count_bits) + sample, number as usize, depth) {
                break;
            }
        }
    }
}
