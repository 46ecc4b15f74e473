//! Blends layers: sorted by their visibility keys, the nearest first, over what is opaque behind them.

use super::layers::Layers;
use super::memory::SampleMemory;
use crate::context::FrameContext;

/// What the layers of each sample of a tile amount to.
#[derive(Debug, Default)]
pub struct Blended {
    /// Premultiplied linear colours.
    color: Vec<[f32; 4]>,
    /// The share of light that passes all layers; 1 where there is none.
    passing: Vec<f32>,
    /// The nearest layer, if it is needed for anything but colours; valid where `passing` is below 1.
    nearest: Vec<Nearest>,
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
    /// Clears the samples: no layers.
    pub fn clear(&mut self, samples: usize, nearest: bool) {
        self.color.clear();
        self.color.resize(samples, [0.0; 4]);
        self.passing.clear();
        self.passing.resize(samples, 1.0);
        self.nearest.resize(if nearest { samples } else { 0 }, Nearest::default());
    }

    /// Are there layers at a sample?
    #[inline(always)]
    pub fn is_at(&self, sample: usize) -> bool {
        self.passing.get(sample).is_some_and(|&passing| passing < 1.0)
    }

    /// The premultiplied linear colour of a sample over what is behind its layers.
    #[inline(always)]
    pub fn over(&self, sample: usize, behind: [f32; 4]) -> [f32; 4] {
        let passing = self.passing[sample];
        if passing == 0.0 {
            return self.color[sample];
        }
        std::array::from_fn(|k| self.color[sample][k] + passing * behind[k])
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
        let passing = self.passing[sample];
        if passing == 1.0 && !self.nearest.is_empty() {
            let slot = layers.list.fragments[number].slot;
            let normal = layers.list.normals.get(number).copied().unwrap_or_default();
            self.nearest[sample] = Nearest { depth, slot, normal };
        }
        let to = &mut self.color[sample];
        *to = std::array::from_fn(|k| to[k] + passing * color[k]);
        self.passing[sample] = passing * passes;
        self.passing[sample] > 0.0
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

/// Blends all layers of a slice of depth, which are shaded, behind those that were blended before.
pub fn slice(context: &FrameContext, memory: &mut SampleMemory, order: &mut Order) {
    let SampleMemory { layers, blended, rect, count_bits, stride_bits, .. } = memory;
    let samples = 1 << *count_bits;
    let first_depth = |number: u32| {
        let depth = layers.samples(number as usize).next().map(|(_, depth)| depth);
        (depth.unwrap_or_default(), number)
    };
    let in_front = |a: &(f32, u32), b: &(f32, u32)| {
        b.0.total_cmp(&a.0).then_with(|| {
            let [new, old] = [a, b].map(|layer| &layers.list.fragments[layer.1 as usize]);
            new.wins_tie(context, old).cmp(&old.wins_tie(context, new)).reverse()
        })
    };
    for row in 0..(rect.y1 - rect.y0 + 1) as usize {
        for pixel in row << *stride_bits..(row << *stride_bits) + (rect.x1 - rect.x0 + 1) as usize {
            order.of_pixel.clear();
            order.of_pixel.extend(layers.in_pixel(pixel).map(first_depth));
            if order.of_pixel.is_empty() {
                continue;
            }
            // Most pixels are not crossed by an edge: then the order at all samples is this one, or almost.
            order.of_pixel.sort_by(in_front);
            for sample in 0..samples {
                let at = (pixel << *count_bits) + sample;
                let there = order.of_pixel.iter().filter(|layer| layers.is_at(layer.1 as usize, sample));
                order.at_sample.clear();
                order.at_sample.extend(there.map(|layer| (layers.depth(layer.1 as usize, sample), layer.1)));
                order.at_sample.sort_by(in_front);
                for &(depth, number) in &order.at_sample {
                    if !blended.add(layers, at, number as usize, depth) {
                        break;
                    }
                }
            }
        }
    }
}
