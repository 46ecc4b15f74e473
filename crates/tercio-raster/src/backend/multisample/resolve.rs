//! From the samples of a tile to its pixels.

use std::ops::Range;

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x4, u8x64, u32x4, u32x16};

use super::blend::Nearest;
use super::fragments::NO_FRAGMENT;
use super::memory::SampleMemory;
use super::nearest::NearestOfRow;
use super::shade::is_needed;
use crate::backend::encode::opaque;
use crate::context::FrameContext;
use crate::frame::{Outputs, Pixel, Planes, key_and_tie, wide_key};
use crate::resolve::{color8, color16, mean, set_colors, weighted_mean};
use crate::sampling::{MAX_SAMPLES, Tap};
use crate::simd::{LANES, load_interleaved, splat};

/// Writes a tile, in which all visible fragments are shaded, to planes that have the background. Returns the number of
/// pixels in which something is drawn, if it is found on the way.
pub fn tile<S: Simd>(
    simd: S,
    context: &FrameContext,
    memory: &SampleMemory,
    background: &[Pixel],
    stride: usize,
    pixels: &mut Planes,
    outputs: &Outputs,
) -> Option<u64> {
    let tile = Tile::new(context, memory, outputs);
    let own = memory.own;
    let has_colors = is_needed(outputs);
    let mut visible = 0;
    for (row, y) in (own.y0..own.y1 + 1).enumerate() {
        let background = &background[row];
        if context.settings.unresolved {
            tile.write_samples(y, row * stride, background, pixels);
            continue;
        }
        for x in (own.x0..own.x1 + 1).step_by(LANES) {
            let place = row * stride + (x - own.x0) as usize;
            let last = (x + LANES as i32 - 1).min(own.x1);
            if has_colors {
                let drawn = tile.write_colors(simd, [x, last], y, place, background, pixels);
                visible += u64::from(drawn.count_ones());
            }
            if tile.has_geometry {
                tile.write_geometry(simd, [x, last], y, place, pixels);
            }
        }
    }
    // The filter draws pixels whose own samples show nothing.
    (has_colors && tile.steps.is_empty() && !context.settings.unresolved).then_some(visible)
}

/// Premultiplied linear colours of 16 pixels.
struct Row {
    colors: [[f32; 4]; LANES],
    /// The pixels in which something was drawn, one bit each.
    drawn: u32,
}

impl Row {
    /// Averages the colours of N samples in each pixel, from the numbers of their fragments. Not inlined, so that it is
    /// compiled only once per SIMD level.
    #[inline(never)]
    fn average<S: Simd, const N: usize>(
        &mut self,
        simd: S,
        fragments: &[u32],
        colors: &[[f32; 4]],
        background: &Pixel,
    ) {
        simd.vectorize(
            #[inline(always)]
            || {
                if are_empty(simd, fragments) {
                    return;
                }
                for (lane, own) in fragments.as_chunks::<N>().0.iter().enumerate().take(LANES) {
                    if let Some(color) = mean_of(simd, own, colors, &background.linear) {
                        self.colors[lane] = color;
                        self.drawn |= 1 << lane;
                    }
                }
            },
        );
    }

    /// Writes the 8-bit colours of the first `count` pixels, where something was drawn.
    #[inline(always)]
    fn write<S: Simd>(&self, simd: S, to: &mut [[u8; 4]], count: usize) {
        let [r, g, b, alpha] = load_interleaved(simd, &self.colors);
        let levels = opaque(simd, [r, g, b]);
        let is_opaque = !alpha.simd_lt(splat(simd, 1.0)).to_bitmask() as u32;
        if self.drawn & is_opaque & 0xffff == 0xffff
            && let Some(to) = to.first_chunk_mut::<LANES>()
        {
            levels.bitcast::<u8x64<S>>().store_slice(to.as_flattened_mut());
            return;
        }
        let levels = levels.to_array();
        for (lane, to) in to.iter_mut().enumerate().take(count) {
            if self.drawn >> lane & 1 == 1 {
                *to = match is_opaque >> lane & 1 {
                    1 => (levels[lane] as u32).to_le_bytes(),
                    _ => color8(self.colors[lane]),
                };
            }
        }
    }
}

/// Was nothing drawn at any of some samples?
#[inline(always)]
fn are_empty<S: Simd>(simd: S, fragments: &[u32]) -> bool {
    let (chunks, rest) = fragments.as_chunks::<LANES>();
    // All bits of `NO_FRAGMENT` are set.
    let mut all = u32x16::splat(simd, NO_FRAGMENT);
    for chunk in chunks {
        all &= u32x16::load_array_ref(simd, chunk);
    }
    all.simd_eq(NO_FRAGMENT).all_true() && rest.iter().all(|&fragment| fragment == NO_FRAGMENT)
}

/// [`mean`] of the colours of N samples, from the numbers of their fragments; `None` where nothing was drawn.
#[inline(always)]
fn mean_of<S: Simd, const N: usize>(
    simd: S,
    fragments: &[u32; N],
    colors: &[[f32; 4]],
    background: &[f32; 4],
) -> Option<[f32; 4]> {
    let first = fragments[0];
    if N > 4 {
        // The mean of equal colours is that colour. No colour is above 1, so that this is also what the sums below amount
        // to: it saves time where there are many samples.
        let mut are_same = u32x4::from_slice(simd, &fragments[..4]).simd_eq(first);
        for four in fragments.as_chunks::<4>().0 {
            are_same &= u32x4::load_array_ref(simd, four).simd_eq(first);
        }
        if are_same.all_true() {
            return colors.get(first as usize).copied();
        }
    } else {
        // All bits of `NO_FRAGMENT` are set.
        let mut all = first;
        for &fragment in fragments {
            all &= fragment;
        }
        if all == NO_FRAGMENT {
            return None;
        }
    }
    let mut sums = [f32x4::splat(simd, 0.0); N];
    for (sum, &fragment) in sums.iter_mut().zip(fragments) {
        // `NO_FRAGMENT` is beyond the end.
        *sum = f32x4::load_array_ref(simd, colors.get(fragment as usize).unwrap_or(background));
    }
    let mut count = N;
    while count > 1 {
        count /= 2;
        for i in 0..count {
            sums[i] = sums[2 * i] + sums[2 * i + 1];
        }
    }
    Some((sums[0] * (1.0 / N as f32)).to_array())
}

/// A sample that contributes to a pixel: see [`Tap`](crate::sampling::Tap).
struct Step {
    /// Its pixel, relative to the filtered one: columns to the right, rows downwards.
    pixel: [i32; 2],
    /// The distance of its index in the tile memory from that of the filtered pixel's first sample.
    offset: isize,
    weight: f32,
}

/// Is any plane requested that is not a colour?
pub fn has_geometry(outputs: &Outputs) -> bool {
    Outputs { color: false, color16: false, linear: false, ..*outputs } != Outputs::NONE
}

struct Tile<'a> {
    context: &'a FrameContext<'a>,
    memory: &'a SampleMemory,
    outputs: &'a Outputs,
    /// Is any plane requested that is not a colour?
    has_geometry: bool,
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
            Step { pixel, offset, weight }
        });
        let of_row =
            |y: i32| Pixel::of_background(&context.scene.background, y as u32, context.view.height).linear;
        let rows = memory.rect.y0..memory.rect.y1 + 1;
        let background = if context.filter.taps.is_empty() { Vec::new() } else { rows.map(of_row).collect() };
        let has_geometry = has_geometry(outputs);
        Self { context, memory, outputs, has_geometry, steps: steps.collect(), background }
    }
}

impl Tile<'_> {
    /// The premultiplied linear colour of a sample over that of the background.
    #[inline(always)]
    fn color(&self, sample: usize, background: [f32; 4]) -> [f32; 4] {
        let fragment = self.memory.fragment[sample];
        let opaque =
            if fragment == NO_FRAGMENT { background } else { self.memory.list.colors[fragment as usize] };
        if self.memory.blended.is_at(sample) { self.memory.blended.over(sample, opaque) } else { opaque }
    }

    /// Writes the colours of at most 16 pixels of a row, from column x0 to x1. Returns those in which something was drawn, one
    /// bit each.
    #[inline(always)]
    fn write_colors<S: Simd>(
        &self,
        simd: S,
        [x0, x1]: [i32; 2],
        y: i32,
        place: usize,
        background: &Pixel,
        pixels: &mut Planes,
    ) -> u32 {
        let count = (x1 - x0 + 1) as usize;
        let mut row = Row { colors: [[0.0; 4]; LANES], drawn: 0 };
        if self.steps.is_empty() && !self.context.is_translucent() {
            let first = self.memory.pixel(x0, y) << self.memory.count_bits;
            let fragments = &self.memory.fragment[first..first + (count << self.memory.count_bits)];
            let colors = &self.memory.list.colors[..];
            match self.memory.count_bits {
                0 => row.average::<S, 1>(simd, fragments, colors, background),
                1 => row.average::<S, 2>(simd, fragments, colors, background),
                2 => row.average::<S, 4>(simd, fragments, colors, background),
                3 => row.average::<S, 8>(simd, fragments, colors, background),
                _ => row.average::<S, 16>(simd, fragments, colors, background),
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
            return 0;
        }
        if self.outputs.color {
            simd.vectorize(
                #[inline(always)]
                || row.write(simd, &mut pixels.color[place..], count),
            );
        }
        let drawn = (0..count).filter(|lane| row.drawn >> lane & 1 == 1);
        if self.outputs.linear {
            drawn.clone().for_each(|lane| pixels.linear[place + lane] = row.colors[lane]);
        }
        if self.outputs.color16 {
            drawn.for_each(|lane| pixels.color16[place + lane] = color16(row.colors[lane]));
        }
        row.drawn
    }

    /// The premultiplied linear colour of a pixel; `None` where nothing was drawn.
    #[inline(always)]
    fn linear(&self, x: i32, y: i32, background: &Pixel) -> Option<[f32; 4]> {
        if self.steps.is_empty() {
            let own = self.samples(x, y);
            if !own.clone().any(|sample| self.memory.is_drawn(sample)) {
                return None;
            }
            let count = own.len();
            let mut colors = [[0.0; 4]; MAX_SAMPLES];
            for (color, sample) in colors.iter_mut().zip(own) {
                *color = self.color(sample, background.linear);
            }
            return Some(mean(&mut colors[..count]));
        }
        let samples = self.contributing(x, y);
        if !samples.clone().any(|(sample, _)| self.memory.is_drawn(sample)) {
            return None;
        }
        Some(weighted_mean(samples.map(|(sample, step)| {
            let background = self.background[(y + step.pixel[1] - self.memory.rect.y0) as usize];
            (self.color(sample, background), step.weight)
        })))
    }

    /// The samples of a pixel, as indices into the tile memory.
    #[inline(always)]
    fn samples(&self, x: i32, y: i32) -> Range<usize> {
        let first = self.memory.pixel(x, y) << self.memory.count_bits;
        first..first + (1 << self.memory.count_bits)
    }

    /// The samples that contribute to pixel (x, y), as indices into the tile memory, with the steps that lead to them.
    #[inline(always)]
    fn contributing(&self, x: i32, y: i32) -> impl Iterator<Item = (usize, &Step)> + Clone {
        let rect = self.memory.rect;
        let is_inner = rect.x0 < x && x < rect.x1 && rect.y0 < y && y < rect.y1;
        let first = self.memory.pixel(x, y) << self.memory.count_bits;
        // Beyond the picture there are no samples.
        let is_inside = move |[right, down]: [i32; 2]| {
            (rect.x0..=rect.x1).contains(&(x + right)) && (rect.y0..=rect.y1).contains(&(y + down))
        };
        let steps = self.steps.iter().filter(move |step| is_inner || is_inside(step.pixel));
        steps.map(move |step| (first.wrapping_add_signed(step.offset), step))
    }

    /// Writes the planes that are no colours of at most 16 pixels of a row, from column x0 to x1.
    #[inline(always)]
    fn write_geometry<S: Simd>(
        &self,
        simd: S,
        [x0, x1]: [i32; 2],
        y: i32,
        place: usize,
        pixels: &mut Planes,
    ) {
        let (count, outputs) = ((x1 - x0 + 1) as usize, self.outputs);
        if (outputs.keys || outputs.ties) && !self.steps.is_empty() {
            for (x, index) in (x0..).zip(place..place + count) {
                let key = self.contributing(x, y).map(|(sample, _)| self.key(sample)).max().unwrap_or(0);
                self.write_key(key, index, pixels);
            }
        }
        let mut nearest = NearestOfRow::default();
        if self.context.is_translucent() {
            nearest.undecided = 0xffff;
        } else {
            let first = self.memory.pixel(x0, y) << self.memory.count_bits;
            let samples = first..first + (count << self.memory.count_bits);
            let (depths, fragments) = (&self.memory.depth[samples.clone()], &self.memory.fragment[samples]);
            match self.memory.count_bits {
                0 => nearest.find::<S, 1>(simd, depths, fragments),
                1 => nearest.find::<S, 2>(simd, depths, fragments),
                2 => nearest.find::<S, 4>(simd, depths, fragments),
                3 => nearest.find::<S, 8>(simd, depths, fragments),
                _ => nearest.find::<S, 16>(simd, depths, fragments),
            }
            if outputs.depth && nearest.depth != [0.0; LANES] {
                simd.vectorize(
                    #[inline(always)]
                    || nearest.write_distances(&self.context.view, &mut pixels.depth[place..place + count]),
                );
            }
        }
        for lane in 0..count {
            let index = place + lane;
            if nearest.undecided >> lane & 1 == 1 {
                if let Some(nearest) = self.nearest_in(x0 + lane as i32, y) {
                    if outputs.depth {
                        pixels.depth[index] = self.context.view.distance(nearest.depth);
                    }
                    self.write_nearest(&nearest, index, pixels);
                }
            } else if let Some(fragment) = self.memory.list.fragments.get(nearest.fragment[lane] as usize) {
                let normals = &self.memory.list.normals;
                let normal = normals.get(nearest.fragment[lane] as usize).copied().unwrap_or_default();
                let nearest = Nearest { depth: nearest.depth[lane], slot: fragment.slot, normal };
                self.write_nearest(&nearest, index, pixels);
            }
        }
    }

    /// Writes the planes of a pixel that are neither colours nor depth.
    #[inline(always)]
    fn write_nearest(&self, nearest: &Nearest, index: usize, pixels: &mut Planes) {
        let outputs = self.outputs;
        if outputs.ids {
            pixels.ids[index] = self.face(nearest.slot);
        }
        if outputs.normals {
            pixels.normals[index] = nearest.normal;
        }
        if (outputs.keys || outputs.ties) && self.steps.is_empty() {
            self.write_key(self.key_of(nearest), index, pixels);
        }
    }

    fn write_key(&self, key: u128, index: usize, pixels: &mut Planes) {
        let (key, tie) = key_and_tie(key, self.context.is_wide());
        pixels.keys.get_mut(index).into_iter().for_each(|own| *own = key);
        pixels.ties.get_mut(index).into_iter().for_each(|own| *own = tie);
    }

    /// What is nearest in a pixel. Keys compare depths first: primitives are looked up only where depths are the same.
    fn nearest_in(&self, x: i32, y: i32) -> Option<Nearest> {
        let mut found: Option<Nearest> = None;
        for nearest in self.samples(x, y).filter_map(|sample| self.nearest(sample)) {
            let is_nearer = found.as_ref().is_none_or(|found| {
                let (own, other) = (nearest.depth.to_bits(), found.depth.to_bits());
                own > other
                    || own == other
                        && nearest.slot != found.slot
                        && self.key_of(&nearest) > self.key_of(found)
            });
            if is_nearer {
                found = Some(nearest);
            }
        }
        found
    }

    /// What is nearest at a sample, opaque or not; `None` where nothing was drawn.
    fn nearest(&self, sample: usize) -> Option<Nearest> {
        let memory = self.memory;
        if memory.blended.is_at(sample) {
            return Some(memory.blended.nearest(sample));
        }
        let fragment = memory.fragment[sample];
        let slot = memory.list.fragments.get(fragment as usize)?.slot;
        let normal = memory.list.normals.get(fragment as usize).copied().unwrap_or_default();
        Some(Nearest { depth: memory.depth[sample], slot, normal })
    }

    /// The visibility key of a sample; 0 where nothing was drawn.
    fn key(&self, sample: usize) -> u128 {
        self.nearest(sample).map_or(0, |nearest| self.key_of(&nearest))
    }

    /// Number of the face of the triangle in a slot.
    fn face(&self, slot: u32) -> u32 {
        let origin = self.memory.origins.get(slot as usize);
        origin.map_or_else(|| self.context.face(slot), |origin| origin.face)
    }

    fn key_of(&self, nearest: &Nearest) -> u128 {
        wide_key(nearest.depth, self.memory.primitive(self.context, nearest.slot))
    }

    /// A sample that was drawn, as a pixel.
    fn sample(&self, sample: usize, background: &Pixel) -> Pixel {
        let nearest = self.nearest(sample).unwrap_or_default();
        let (keys, ties) = key_and_tie(self.key(sample), self.context.is_wide());
        let mut pixel = Pixel {
            keys,
            ties,
            depth: self.context.view.distance(nearest.depth),
            ids: self.face(nearest.slot),
            normals: nearest.normal,
            ..*background
        };
        if is_needed(self.outputs) {
            set_colors(&mut pixel, self.color(sample, background.linear), self.outputs);
        }
        pixel
    }

    /// Writes the samples of a row of pixels side by side, from index `first` on.
    fn write_samples(&self, y: i32, first: usize, background: &Pixel, pixels: &mut Planes) {
        let own = self.memory.own;
        for x in own.x0..own.x1 + 1 {
            for (number, sample) in self.samples(x, y).enumerate() {
                if self.memory.is_drawn(sample) {
                    let column = (x - own.x0) as usize;
                    let index = first + (column << self.memory.count_bits) + number;
                    pixels.put(index, &self.sample(sample, background));
                }
            }
        }
    }
}
