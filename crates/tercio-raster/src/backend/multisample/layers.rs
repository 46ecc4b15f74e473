//! Layers: the fragments of triangles that may not be opaque. All that are in front of what is opaque are stored, whatever
//! their order, until [`super::blend`] sorts and blends them.
//!
//! If a tile has more of them than the memory for layers holds, it is drawn in slices of depth: when the memory is full,
//! the farther half is discarded and the slice ends there. After the slice is blended, what is behind it is drawn again.

use super::fragments::{Fragment, FragmentList, NO_FRAGMENT};
use crate::context::FrameContext;
use crate::frame::fragments::{FragmentHead, write_fragment};
use crate::frame::{Outputs, wide_key};
use crate::simd::LANES;

/// A range of visibility keys ([`wide_key`]), of which the largest is the nearest.
#[derive(Clone, Copy, Debug)]
struct Slice {
    /// Keys are below this.
    end: u128,
    /// Keys are at least this.
    start: u128,
}

impl Slice {
    const ALL: Self = Self { end: u128::MAX, start: 0 };

    fn is_all(self) -> bool {
        self.end == Self::ALL.end && self.start == Self::ALL.start
    }
}

impl Default for Slice {
    fn default() -> Self {
        Self::ALL
    }
}

/// A fragment as a layer of its pixel.
#[derive(Clone, Copy, Debug, Default)]
struct Link {
    /// The fragment that was drawn before it in the same pixel.
    before: u32,
    /// The samples at which it is a layer, one bit each.
    mask: u16,
}

/// The layers of a tile, or those in a slice of depth.
#[derive(Debug, Default)]
pub struct Layers {
    /// The fragments.
    pub list: FragmentList,
    links: Vec<Link>,
    /// Depths at the samples of the pixel: `depths_each` for each fragment, valid where its mask has a bit.
    depths: Vec<f32>,
    /// The number of samples per pixel; 1 if every sample is a fragment of its own.
    depths_each: usize,
    /// The last fragment in each pixel.
    newest: Vec<u32>,
    slice: Slice,
    /// Fragments are discarded if there are more than this.
    most: usize,
    /// The pieces of a clipped triangle are being drawn: the slice is not applied.
    is_in_pieces: bool,
}

impl Layers {
    /// Clears the layers for a tile with this many pixels, and begins with the first slice.
    pub fn clear(&mut self, context: &FrameContext, pixels: usize, depths_each: usize) {
        self.slice = Slice::ALL;
        if depths_each != self.depths_each {
            // The depths of earlier frames are room for fewer fragments, if each has more of them now.
            let room = self.depths.len().saturating_sub(LANES) / depths_each;
            self.list.fragments.truncate(room);
            self.depths_each = depths_each;
        }
        // With less, most slices would hold a single triangle. If all that is stored has the same key, nothing is discarded.
        let least = 2 * pixels * if depths_each == 1 { context.cells.count } else { 1 };
        self.most = (context.settings.layer_memory / context.workers / self.bytes_each()).max(least);
        self.clear_slice(pixels);
    }

    fn clear_slice(&mut self, pixels: usize) {
        self.list.clear();
        self.newest.clear();
        self.newest.resize(pixels, NO_FRAGMENT);
    }

    /// Bytes of a fragment with colour and normal, and of what [`Layers::end_earlier`] needs for it.
    fn bytes_each(&self) -> usize {
        size_of::<Fragment>()
            + size_of::<[f32; 4]>()
            + size_of::<[f32; 3]>()
            + size_of::<Link>()
            + self.depths_each * size_of::<f32>()
            + 2 * size_of::<u64>()
    }

    /// Begins the next slice; false if there is none.
    pub fn next_slice(&mut self) -> bool {
        if self.slice.start == 0 {
            return false;
        }
        self.slice = Slice { end: self.slice.start, start: 0 };
        self.clear_slice(self.newest.len());
        true
    }

    /// Adds a fragment of which the samples in `mask` are layers, with its depths at the samples of its pixel.
    #[inline(always)]
    pub fn push(&mut self, context: &FrameContext, fragment: Fragment, mask: u32, depths: &[f32]) {
        let mut mask = mask;
        if !self.slice.is_all() && !self.is_in_pieces {
            mask = self.in_slice(context, fragment.slot, mask, depths);
            if mask == 0 {
                return;
            }
        }
        if !self.list.has_room() {
            self.grow();
        }
        let number = self.list.count;
        let newest = &mut self.newest[usize::from(fragment.pixel)];
        let before = std::mem::replace(newest, number as u32);
        self.links[number] = Link { before, mask: mask as u16 };
        self.depths[number * self.depths_each..][..self.depths_each]
            .copy_from_slice(&depths[..self.depths_each]);
        self.list.push(fragment);
    }

    /// The samples of a mask whose keys are in the slice.
    fn in_slice(&self, context: &FrameContext, slot: u32, mask: u32, depths: &[f32]) -> u32 {
        // The depth decides, except at the ends of the slice. That of the largest key is not the depth of anything.
        let [start, end] = [self.slice.start, self.slice.end].map(|key| (key >> 64) as u32);
        let is_inside = |sample: &usize| {
            // A fragment of one sample has one depth, whichever sample it is.
            let depth = depths[sample & (self.depths_each - 1)];
            match depth.to_bits() {
                bits if bits < start || bits > end => false,
                bits if bits > start && bits < end => true,
                _ => {
                    let key = wide_key(depth, context.primitive(slot));
                    (self.slice.start..self.slice.end).contains(&key)
                }
            }
        };
        let samples = (0..LANES).filter(|sample| mask >> sample & 1 == 1);
        samples.filter(is_inside).map(|sample| 1 << sample).sum()
    }

    /// Makes room for more fragments.
    #[cold]
    #[inline(never)]
    fn grow(&mut self) {
        // To twice the size, but little beyond what is kept.
        let count = self.list.count;
        let length = (2 * count).min(self.most).max(count + count / 16) + 16 * LANES;
        self.list.grow_to(length);
        grow_to(&mut self.links, length);
        grow_to(&mut self.depths, length * self.depths_each + LANES);
    }

    /// Ends the slice earlier if the memory is full: about half of the fragments are left.
    #[inline(always)]
    pub fn make_room(&mut self, context: &FrameContext) {
        if self.list.count > self.most {
            self.end_earlier(context);
        }
    }

    #[cold]
    #[inline(never)]
    fn end_earlier(&mut self, context: &FrameContext) {
        let nearest = |number| self.samples(number).map(|(_, depth)| depth).fold(0.0, f32::max);
        // Where all that is left has one depth, by primitive.
        let by_depth = |number: usize| nearest(number).to_bits();
        let by_key =
            |number: usize| wide_key(nearest(number), context.primitive(self.list.fragments[number].slot));
        let all = 0..self.list.count;
        let of_depth = middle_key(all.clone().map(by_depth)).map(|depth| u128::from(depth) << 64);
        let start = of_depth.or_else(|| middle_key(all.map(by_key)));
        let Some(start) = start else { return };
        self.slice.start = start;
        for number in 0..self.list.count {
            let depths = &self.depths[number * self.depths_each..][..self.depths_each];
            let (slot, mask) = (self.list.fragments[number].slot, u32::from(self.links[number].mask));
            self.links[number].mask = self.in_slice(context, slot, mask, depths) as u16;
        }
        self.retain_layers();
    }

    /// Removes the fragments that are no layer at any sample.
    fn retain_layers(&mut self) {
        self.newest.fill(NO_FRAGMENT);
        let Self { list, links, depths, depths_each, newest, .. } = self;
        let is_layer: Vec<bool> = links[..list.count].iter().map(|link| link.mask != 0).collect();
        let mut pixels = list.fragments[..list.count].iter().map(|f| f.pixel).collect::<Vec<_>>().into_iter();
        let each = *depths_each;
        let mut last = 0;
        list.retain(
            |number| is_layer[number],
            |from, to| {
                depths.copy_within(from * each..(from + 1) * each, to * each);
                let pixel = pixels.nth(from - last).unwrap_or(0);
                last = from + 1;
                let before = std::mem::replace(&mut newest[usize::from(pixel)], to as u32);
                links[to] = Link { before, mask: links[from].mask };
            },
        );
    }

    /// Begins the pieces of a clipped triangle.
    pub fn begin_pieces(&mut self) {
        self.is_in_pieces = true;
    }

    /// Ends the pieces of a clipped triangle, whose fragments begin with number `first`: at samples that several pieces
    /// cover, the one in front is left.
    pub fn end_pieces(&mut self, context: &FrameContext, first: usize) {
        self.is_in_pieces = false;
        for number in first..self.list.count {
            let mut other = self.links[number].before;
            while other != NO_FRAGMENT && other as usize >= first {
                self.leave_one(context, number, other as usize);
                other = self.links[other as usize].before;
            }
        }
        for number in first..self.list.count {
            if !self.slice.is_all() && self.links[number].mask != 0 {
                let depths = &self.depths[number * self.depths_each..][..self.depths_each];
                let (slot, mask) = (self.list.fragments[number].slot, u32::from(self.links[number].mask));
                self.links[number].mask = self.in_slice(context, slot, mask, depths) as u16;
            }
        }
        // Restores the lists of the pixels, then adds the fragments that are left again.
        let count = self.list.count;
        for number in (first..count).rev() {
            self.newest[usize::from(self.list.fragments[number].pixel)] = self.links[number].before;
        }
        self.list.count = first;
        for number in (first..count).filter(|&number| self.links[number].mask != 0).collect::<Vec<_>>() {
            let (fragment, to) = (self.list.fragments[number], self.list.count);
            let each = self.depths_each;
            self.depths.copy_within(number * each..(number + 1) * each, to * each);
            let newest = &mut self.newest[usize::from(fragment.pixel)];
            let before = std::mem::replace(newest, to as u32);
            self.links[to] = Link { before, mask: self.links[number].mask };
            self.list.push(fragment);
        }
    }

    /// Of two fragments of one triangle in one pixel, leaves the one in front at each sample of both.
    fn leave_one(&mut self, context: &FrameContext, new: usize, old: usize) {
        let both = self.links[new].mask & self.links[old].mask;
        let [new_fragment, old_fragment] = [new, old].map(|number| self.list.fragments[number]);
        for sample in (0..LANES).filter(|sample| both >> sample & 1 == 1) {
            let [a, b] = [new, old].map(|number| self.depth(number, sample));
            let new_wins = a > b || a == b && new_fragment.wins_tie(context, &old_fragment);
            self.links[if new_wins { old } else { new }].mask &= !(1 << sample);
        }
    }

    /// The depth of a fragment at a sample of its mask.
    #[inline(always)]
    pub fn depth(&self, number: usize, sample: usize) -> f32 {
        self.depths[number * self.depths_each + (sample & (self.depths_each - 1))]
    }

    /// The samples at which a fragment is a layer, one bit each.
    #[inline(always)]
    pub fn mask(&self, number: usize) -> u16 {
        self.links[number].mask
    }

    /// The depths of a fragment at the samples of its pixel, valid where its mask has a bit, and what follows them; only
    /// one if every sample is a fragment of its own.
    #[inline(always)]
    pub fn depths_of(&self, number: usize) -> &[f32] {
        let first = number * self.depths_each;
        let length = if self.depths_each == 1 { 1 } else { LANES };
        &self.depths[first..first + length]
    }

    /// The samples at which a fragment is a layer, and its depths there.
    #[inline(always)]
    pub fn samples(&self, number: usize) -> impl Iterator<Item = (usize, f32)> {
        let mask = self.links[number].mask;
        (0..LANES)
            .filter(move |sample| mask >> sample & 1 == 1)
            .map(move |sample| (sample, self.depth(number, sample)))
    }

    /// Appends all layers, which are shaded, as bytes ([`crate::frame::fragments`]).
    pub fn write_bytes(&self, context: &FrameContext, outputs: &Outputs, out: &mut Vec<u8>) {
        let layout = context.fragment_layout(outputs);
        for number in 0..self.list.count {
            let Fragment { slot, pixel: place, .. } = self.list.fragments[number];
            let (primitive, mask) = (context.primitive(slot), self.mask(number));
            let head =
                FragmentHead { primitive: primitive as u32, place, mask, color: self.list.colors[number] };
            if mask != 0 {
                let normal = || self.list.normals[number];
                let begin = out.len();
                out.resize(begin + layout.bytes(mask.count_ones() as usize), 0);
                let face = || context.face(slot);
                write_fragment(
                    layout,
                    &head,
                    primitive,
                    normal,
                    face,
                    |sample| self.depth(number, sample),
                    &mut out[begin..],
                );
            }
        }
    }

    /// The fragments in a pixel, the last one first.
    #[inline(always)]
    pub fn in_pixel(&self, pixel: usize) -> impl Iterator<Item = u32> {
        let some = |number: u32| (number != NO_FRAGMENT).then_some(number);
        std::iter::successors(some(self.newest[pixel]), move |&number| {
            some(self.links[number as usize].before)
        })
    }
}

/// Makes an array at least this long, without more memory than that.
fn grow_to<T: Copy + Default>(array: &mut Vec<T>, length: usize) {
    array.reserve_exact(length.saturating_sub(array.len()));
    array.resize(length.max(array.len()), T::default());
}

/// A key of about the middle that is not the lowest; `None` if all are the same.
fn middle_key<K: Ord + Copy>(keys: impl Iterator<Item = K>) -> Option<K> {
    let mut keys: Vec<K> = keys.collect();
    let least = *keys.iter().min()?;
    let count = keys.len();
    let middle = *keys.select_nth_unstable(count / 2).1;
    if middle > least { Some(middle) } else { keys.into_iter().filter(|&key| key > least).min() }
}
