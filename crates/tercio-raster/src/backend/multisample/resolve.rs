//! From the samples of a tile to its pixels.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};

use super::memory::{NO_FRAGMENT, SampleMemory};
use super::shade::is_needed;
use crate::backend::encode::opaque;
use crate::context::FrameContext;
use crate::frame::{Outputs, Pixel, Planes, visibility_key};
use crate::resolve::{color8, mean, set_colors, weighted_mean};
use crate::sampling::{MAX_SAMPLES, Tap};
use crate::simd::{LANES, each3};

/// Writes a tile, in which all visible fragments are shaded, to planes that have the background.
pub fn tile<S: Simd>(
    simd: S,
    context: &FrameContext,
    memory: &SampleMemory,
    background: &[Pixel],
    stride: usize,
    pixels: &mut Planes,
    outputs: &Outputs,
) {
    let tile = Tile::new(context, memory, outputs);
    let own = memory.own;
    let only_color = *outputs == Outputs { color: true, ..Outputs::NONE };
    for (row, y) in (own.y0..own.y1 + 1).enumerate() {
        let background = &background[row];
        if context.settings.unresolved {
            tile.write_samples(y, row * stride, background, pixels);
            continue;
        }
        for x in (own.x0..own.x1 + 1).step_by(LANES) {
            let place = row * stride + (x - own.x0) as usize;
            let last = (x + LANES as i32 - 1).min(own.x1);
            if only_color {
                tile.write_colors(simd, [x, last], y, place, background, pixels);
                continue;
            }
            for x in x..last + 1 {
                if let Some(pixel) = tile.pixel(x, y, background) {
                    pixels.put(row * stride + (x - own.x0) as usize, &pixel);
                }
            }
        }
    }
}

/// Premultiplied linear colours of 16 pixels.
struct Row {
    colors: [[f32; 4]; LANES],
    /// The pixels in which something was drawn, one bit each.
    drawn: u32,
}

impl Row {
    /// Averages the colours of N samples in each pixel, from the numbers of their fragments.
    #[inline(never)]
    fn average<const N: usize>(&mut self, fragments: &[u32], colors: &[[f32; 4]], background: &Pixel) {
        for (lane, own) in fragments.as_chunks::<N>().0.iter().enumerate().take(LANES) {
            let first = own[0];
            if *own == [first; N] {
                if first != NO_FRAGMENT {
                    // The mean of equal colours is that colour.
                    self.colors[lane] = colors[first as usize];
                    self.drawn |= 1 << lane;
                }
                continue;
            }
            let color = |fragment: u32| match fragment {
                NO_FRAGMENT => background.linear,
                fragment => colors[fragment as usize],
            };
            self.colors[lane] = mean(&mut own.map(color));
            self.drawn |= 1 << lane;
        }
    }
}

/// A sample that contributes to a pixel: see [`Tap`](crate::sampling::Tap).
struct Step {
    /// Its pixel, relative to the filtered one: columns to the right, rows downwards.
    pixel: [i32; 2],
    /// Its number in its pixel.
    sample: usize,
    /// The distance of its index in the tile memory from that of the filtered pixel's first sample.
    offset: isize,
    weight: f32,
}

struct Tile<'a> {
    context: &'a FrameContext<'a>,
    memory: &'a SampleMemory,
    outputs: &'a Outputs,
    /// The samples that contribute to a pixel; empty if these are its own.
    steps: Vec<Step>,
    /// The linear colour of the background in each row of the tile memory; empty without steps.
    background: Vec<[f32; 4]>,
}

impl<'a> Tile<'a> {
    fn new(context: &'a FrameContext<'a>, memory: &'a SampleMemory, outputs: &'a Outputs) -> Self {
        let steps = context.filter.taps.iter().map(|&Tap { pixel, sample, weight }| {
            let pixels = (pixel[1] as isize * (1 << memory.stride_bits)) + pixel[0] as isize;
            let offset = pixels * (1 << memory.count_bits) + sample as isize;
            Step { pixel, sample, offset, weight }
        });
        let of_row =
            |y: i32| Pixel::of_background(&context.scene.background, y as u32, context.view.height).linear;
        let rows = memory.rect.y0..memory.rect.y1 + 1;
        let background = if context.filter.taps.is_empty() { Vec::new() } else { rows.map(of_row).collect() };
        Self { context, memory, outputs, steps: steps.collect(), background }
    }
}

impl Tile<'_> {
    /// The colour of a sample.
    #[inline(always)]
    fn color(&self, fragment: u32, background: &Pixel) -> [f32; 4] {
        if fragment == NO_FRAGMENT { background.linear } else { self.memory.colors[fragment as usize] }
    }

    /// Writes the 8-bit colours of at most 16 pixels of a row, from column x0 to x1.
    #[inline(always)]
    fn write_colors<S: Simd>(
        &self,
        simd: S,
        [x0, x1]: [i32; 2],
        y: i32,
        place: usize,
        background: &Pixel,
        pixels: &mut Planes,
    ) {
        let count = (x1 - x0 + 1) as usize;
        let mut row = Row { colors: [[0.0; 4]; LANES], drawn: 0 };
        if self.steps.is_empty() {
            let first = self.memory.pixel(x0, y) << self.memory.count_bits;
            let fragments = &self.memory.fragment[first..first + (count << self.memory.count_bits)];
            match 1 << self.memory.count_bits {
                2 => row.average::<2>(fragments, &self.memory.colors, background),
                4 => row.average::<4>(fragments, &self.memory.colors, background),
                8 => row.average::<8>(fragments, &self.memory.colors, background),
                _ => row.average::<16>(fragments, &self.memory.colors, background),
            }
        } else {
            for lane in 0..count {
                if let Some(color) = self.linear(x0 + lane as i32, y, background) {
                    row.colors[lane % LANES] = color;
                    row.drawn |= 1 << lane;
                }
            }
        }
        if row.drawn == 0 {
            return;
        }
        let levels = simd.vectorize(
            #[inline(always)]
            || {
                let linear = each3!(K => {
                    let mut one = [0.0; LANES];
                    for (to, color) in one.iter_mut().zip(&row.colors) {
                        *to = color[K];
                    }
                    f32x16::load_array(simd, one)
                });
                opaque(simd, linear).to_array()
            },
        );
        for (lane, to) in pixels.color[place..].iter_mut().enumerate().take(count) {
            let color = row.colors[lane % LANES];
            if row.drawn >> lane & 1 == 0 {
                continue;
            }
            *to = match color[3] < 1.0 {
                true => color8(color),
                false => (levels[lane % LANES] as u32).to_le_bytes(),
            };
        }
    }

    /// The premultiplied linear colour of a pixel; `None` where nothing was drawn.
    #[inline(always)]
    fn linear(&self, x: i32, y: i32, background: &Pixel) -> Option<[f32; 4]> {
        let own = self.memory.of_pixel(self.memory.pixel(x, y));
        if self.steps.is_empty() {
            let first = own[0];
            if own.iter().all(|&fragment| fragment == first) {
                // The mean of equal colours is that colour.
                return (first != NO_FRAGMENT).then(|| self.color(first, background));
            }
            let mut colors = [[0.0; 4]; MAX_SAMPLES];
            for (color, &fragment) in colors.iter_mut().zip(own) {
                *color = self.color(fragment, background);
            }
            return Some(mean(&mut colors[..own.len()]));
        }
        let fragments = self.contributing(x, y);
        if fragments.clone().all(|(fragment, _)| fragment == NO_FRAGMENT) {
            return None;
        }
        Some(weighted_mean(fragments.map(|(fragment, step)| {
            let color = match fragment {
                NO_FRAGMENT => self.background[(y + step.pixel[1] - self.memory.rect.y0) as usize],
                fragment => self.memory.colors[fragment as usize],
            };
            (color, step.weight)
        })))
    }

    /// The fragments of the samples that contribute to pixel (x, y), with the steps that lead to them.
    #[inline(always)]
    fn contributing(&self, x: i32, y: i32) -> impl Iterator<Item = (u32, &Step)> + Clone {
        let rect = self.memory.rect;
        let is_inner = rect.x0 < x && x < rect.x1 && rect.y0 < y && y < rect.y1;
        let first = self.memory.pixel(x, y) << self.memory.count_bits;
        // Beyond the picture there are no samples.
        let is_inside = move |[right, down]: [i32; 2]| {
            (rect.x0..=rect.x1).contains(&(x + right)) && (rect.y0..=rect.y1).contains(&(y + down))
        };
        let steps = self.steps.iter().filter(move |step| is_inner || is_inside(step.pixel));
        steps.map(move |step| (self.memory.fragment[first.wrapping_add_signed(step.offset)], step))
    }

    /// A pixel with all requested planes; `None` where nothing was drawn.
    fn pixel(&self, x: i32, y: i32, background: &Pixel) -> Option<Pixel> {
        let place = self.memory.pixel(x, y);
        let samples = 0..self.memory.of_pixel(place).len();
        let mut pixel = *background;
        if is_needed(self.outputs) {
            set_colors(&mut pixel, self.linear(x, y, background)?, self.outputs);
        }
        // The first of the samples with the largest key.
        let key = |sample: &usize| self.key(place, *sample);
        if let Some(nearest) = samples.clone().rev().max_by_key(key).filter(|sample| key(sample) > 0) {
            let sample = self.sample(place, nearest, background);
            (pixel.depth, pixel.ids, pixel.normals) = (sample.depth, sample.ids, sample.normals);
            pixel.keys = sample.keys;
        }
        if self.outputs.keys && !self.steps.is_empty() {
            let key = |(_, step): (u32, &Step)| {
                self.key(self.memory.pixel(x + step.pixel[0], y + step.pixel[1]), step.sample)
            };
            pixel.keys = self.contributing(x, y).map(key).max().unwrap_or(0);
        }
        Some(pixel)
    }

    /// The visibility key of a sample of the pixel at a place; 0 where nothing was drawn.
    fn key(&self, place: usize, sample: usize) -> u64 {
        let fragment = self.memory.of_pixel(place)[sample];
        if fragment == NO_FRAGMENT {
            return 0;
        }
        let slot = self.memory.fragments[fragment as usize].slot;
        let depth = self.memory.depth[(place << self.memory.count_bits) + sample];
        visibility_key(depth, self.context.primitive(slot) as u32)
    }

    /// A sample that was drawn, as a pixel.
    fn sample(&self, place: usize, sample: usize, background: &Pixel) -> Pixel {
        let fragment = self.memory.of_pixel(place)[sample];
        let slot = self.memory.fragments[fragment as usize].slot;
        let mut pixel = Pixel {
            keys: self.key(place, sample),
            depth: self.context.view.distance(self.memory.depth[(place << self.memory.count_bits) + sample]),
            ids: self.context.face(slot),
            normals: self.memory.normals.get(fragment as usize).copied().unwrap_or_default(),
            ..*background
        };
        if is_needed(self.outputs) {
            set_colors(&mut pixel, self.color(fragment, background), self.outputs);
        }
        pixel
    }

    /// Writes the samples of a row of pixels side by side, from index `first` on.
    fn write_samples(&self, y: i32, first: usize, background: &Pixel, pixels: &mut Planes) {
        let own = self.memory.own;
        for x in own.x0..own.x1 + 1 {
            let place = self.memory.pixel(x, y);
            let count = 1 << self.memory.count_bits;
            for sample in 0..count {
                if self.memory.of_pixel(place)[sample] != NO_FRAGMENT {
                    let index = first + (x - own.x0) as usize * count + sample;
                    pixels.put(index, &self.sample(place, sample, background));
                }
            }
        }
    }
}
