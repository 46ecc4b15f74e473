//! From the samples of a tile to its pixels.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};

use super::memory::{NO_FRAGMENT, SampleMemory};
use crate::backend::encode::opaque;
use crate::context::FrameContext;
use crate::frame::{Outputs, Pixel, Planes, visibility_key};
use crate::resolve::{encode, mean, weighted_mean};
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
    let tile = Tile { context, memory, outputs };
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

struct Tile<'a> {
    context: &'a FrameContext<'a>,
    memory: &'a SampleMemory,
    outputs: &'a Outputs,
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
        if self.context.filter.taps.is_empty() {
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
                true => encode(color).0,
                false => (levels[lane % LANES] as u32).to_le_bytes(),
            };
        }
    }

    /// The premultiplied linear colour of a pixel; `None` where nothing was drawn.
    #[inline(always)]
    fn linear(&self, x: i32, y: i32, background: &Pixel) -> Option<[f32; 4]> {
        let own = self.memory.of_pixel(self.memory.pixel(x, y));
        let taps = &self.context.filter.taps;
        if taps.is_empty() {
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
        let is_drawn = taps.iter().any(|tap| self.tap(x, y, tap).is_some_and(|f| f != NO_FRAGMENT));
        is_drawn.then(|| {
            weighted_mean(taps, |tap| {
                let height = self.context.view.height;
                let row = y + tap.pixel[1];
                self.tap(x, y, tap).map(|fragment| {
                    if fragment != NO_FRAGMENT {
                        return self.memory.colors[fragment as usize];
                    }
                    Pixel::of_background(&self.context.scene.background, row as u32, height).linear
                })
            })
        })
    }

    /// The fragment of a sample that contributes to pixel (x, y); `None` outside the picture.
    #[inline(always)]
    fn tap(&self, x: i32, y: i32, tap: &Tap) -> Option<u32> {
        let (x, y) = (x + tap.pixel[0], y + tap.pixel[1]);
        let rect = self.memory.rect;
        let inside = (rect.x0..=rect.x1).contains(&x) && (rect.y0..=rect.y1).contains(&y);
        inside.then(|| self.memory.of_pixel(self.memory.pixel(x, y))[tap.sample])
    }

    /// A pixel with all requested planes; `None` where nothing was drawn.
    fn pixel(&self, x: i32, y: i32, background: &Pixel) -> Option<Pixel> {
        let linear = self.linear(x, y, background)?;
        let mut pixel = Pixel { linear, ..*background };
        (pixel.color, pixel.color16) = encode(linear);
        let place = self.memory.pixel(x, y);
        let samples = 0..self.memory.of_pixel(place).len();
        // The first of the samples with the largest key.
        let key = |sample: &usize| self.key(place, *sample);
        if let Some(nearest) = samples.clone().rev().max_by_key(key).filter(|sample| key(sample) > 0) {
            let sample = self.sample(place, nearest, background);
            (pixel.depth, pixel.ids, pixel.normals) = (sample.depth, sample.ids, sample.normals);
            pixel.keys = sample.keys;
        }
        if self.outputs.keys && !self.context.filter.taps.is_empty() {
            let keys = self.context.filter.taps.iter().filter(|tap| self.tap(x, y, tap).is_some());
            let key = |tap: &Tap| self.key(self.memory.pixel(x + tap.pixel[0], y + tap.pixel[1]), tap.sample);
            pixel.keys = keys.map(key).max().unwrap_or(0);
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
        let linear = self.color(fragment, background);
        let (color, color16) = encode(linear);
        Pixel {
            keys: self.key(place, sample),
            color,
            color16,
            linear,
            depth: self.context.view.distance(self.memory.depth[(place << self.memory.count_bits) + sample]),
            ids: self.context.face(slot),
            normals: self.memory.normals.get(fragment as usize).copied().unwrap_or_default(),
        }
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
