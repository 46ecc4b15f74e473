//! The tile memory: depth and fragment of every sample of a tile, and the list of fragments. Depth tests: [`super::write`].

use std::ops::Range;

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16, u32x16};

use super::blend::Blended;
use super::fragments::{FragmentList, NO_FRAGMENT};
use super::layers::Layers;
use super::load::Origin;
use super::stamps::MOST_ROWS;
use crate::context::FrameContext;
use crate::depth_bounds::{BLOCK_BITS, block, blocks_across};
use crate::sampling::SampleShading;
use crate::screen::PixelRect;
use crate::simd::{LANE_NUMBERS, LANES, baseline, live_lanes, splat, splat_i};

/// Blocks of pixels, whose depths are remembered, across and down.
const BLOCKS: usize = MOST_ROWS.div_ceil(1 << BLOCK_BITS);

/// Depth and fragment of every sample of a tile.
///
/// The samples of a pixel are side by side. The tile's pixels include those around it that the filter needs.
#[derive(Debug, Default)]
pub struct SampleMemory {
    /// Depth; where nothing was drawn 0, or the depth behind which other ranks hide everything.
    pub depth: Vec<f32>,
    /// Number of the fragment, [`NO_FRAGMENT`] where nothing was drawn.
    pub fragment: Vec<u32>,
    /// Of each block of pixels, a depth that all of its samples are nearer than; below 0 where none is known.
    known: Vec<f32>,
    /// The fragments of opaque triangles. Those that were hidden later remain until [`SampleMemory::make_room`] removes
    /// them.
    pub list: FragmentList,
    /// The fragments of other triangles.
    pub layers: Layers,
    /// What the layers amount to, if the frame may have any.
    pub blended: Blended,
    /// Where the fragments come from, if these are of several ranks: then their slots are indices into this.
    pub origins: Vec<Origin>,
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
    pub lane_number_shift: [i32; LANES],
}

impl SampleMemory {
    /// Resizes and clears the memory for a tile.
    pub fn clear(&mut self, context: &FrameContext, tile: u32) {
        let size = [context.view.width, context.view.height];
        let halo = context.grid.halo;
        self.own = context.grid.rect(tile, size);
        self.rect = self.own.grow(halo as i32).intersect(context.picture());
        self.stride_bits = context.grid.needed_bits();
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
        let [across, rows] =
            [self.rect.x1 - self.rect.x0 + 1, self.rect.y1 - self.rect.y0 + 1].map(|edge| edge as usize);
        assert!(across.max(rows) <= MOST_ROWS, "a tile of {across} x {rows} pixels");
        // Samples are read and written 16 at a time.
        let samples = (rows << self.stride_bits << self.count_bits) + LANES;
        self.depth.clear();
        self.depth.resize(samples, 0.0);
        self.fragment.clear();
        self.fragment.resize(samples, NO_FRAGMENT);
        self.known.clear();
        self.known.resize(BLOCKS * BLOCKS, -1.0);
        if let Some(hidden) = context.hidden_in(tile) {
            let across = blocks_across(&context.grid);
            for (number, &depth) in hidden.iter().enumerate().filter(|(_, depth)| **depth > 0.0) {
                self.fill_depth(self.block(number, across), depth);
                self.known[number / across * BLOCKS + number % across] = depth.next_down();
            }
        }
        self.list.clear();
        if context.is_translucent() {
            let depths_each = if self.is_by_sample { 1 } else { cells.count };
            self.layers.clear(context, rows << self.stride_bits, depths_each);
        }
        self.blended.clear(0, self.count_bits, false);
        self.origins.clear();
    }

    /// The place of a pixel of the picture.
    #[inline(always)]
    pub fn pixel(&self, x: i32, y: i32) -> usize {
        ((y - self.rect.y0) as usize) << self.stride_bits | (x - self.rect.x0) as usize
    }

    /// The pixels of a block that are in memory, counted from the first one there.
    #[inline(always)]
    pub fn block(&self, number: usize, across: usize) -> PixelRect {
        let PixelRect { x0, x1, y0, y1 } = self.rect;
        block(number, across).intersect(PixelRect { x0: 0, x1: x1 - x0, y0: 0, y1: y1 - y0 })
    }

    /// Sets the depth of the samples of some pixels, counted from the first one in memory.
    pub fn fill_depth(&mut self, rect: PixelRect, depth: f32) {
        for samples in self.rows_of_samples(rect) {
            self.depth[samples].fill(depth);
        }
    }

    /// The samples of some pixels, counted from the first one in memory, row by row; none if there are no pixels.
    #[inline(always)]
    pub fn rows_of_samples(&self, rect: PixelRect) -> impl Iterator<Item = Range<usize>> + use<> {
        let (stride_bits, count_bits) = (self.stride_bits, self.count_bits);
        let rows = if rect.is_empty() { 0..0 } else { rect.y0..rect.y1 + 1 };
        rows.map(move |y| {
            let first = (y as usize) << stride_bits;
            (first + rect.x0 as usize) << count_bits..(first + rect.x1 as usize + 1) << count_bits
        })
    }

    /// The depth of the farthest sample of some pixels, counted from the first one in memory; 0 if there are none.
    #[inline(always)]
    pub fn farthest<S: Simd>(&self, simd: S, rect: PixelRect) -> f32 {
        if rect.is_empty() {
            return 0.0;
        }
        let mut farthest = splat(simd, f32::INFINITY);
        for samples in self.rows_of_samples(rect) {
            let (stamps, rest) = self.depth[samples].as_chunks::<LANES>();
            for stamp in stamps {
                farthest = farthest.min(f32x16::load_array_ref(simd, stamp));
            }
            for &depth in rest {
                farthest = farthest.min(splat(simd, depth));
            }
        }
        farthest.to_array().into_iter().fold(f32::INFINITY, f32::min)
    }

    /// Is anything drawn at a sample?
    #[inline(always)]
    pub fn is_drawn(&self, sample: usize) -> bool {
        self.fragment[sample] != NO_FRAGMENT || self.blended.is_at(sample)
    }

    /// Is every sample of some pixels in memory nearer than this depth? Remembers the depth for the blocks that are in these pixels:
    /// there, depths only become nearer, and most clusters come front to back.
    #[inline(always)]
    pub fn all_nearer<S: Simd>(&mut self, simd: S, rect: PixelRect, depth: f32) -> bool {
        if rect.is_empty() {
            return true;
        }
        let PixelRect { x0, y0, .. } = self.rect;
        let rect = PixelRect { x0: rect.x0 - x0, x1: rect.x1 - x0, y0: rect.y0 - y0, y1: rect.y1 - y0 };
        for row in rect.y0 >> BLOCK_BITS..(rect.y1 >> BLOCK_BITS) + 1 {
            for column in rect.x0 >> BLOCK_BITS..(rect.x1 >> BLOCK_BITS) + 1 {
                let number = row as usize * BLOCKS + column as usize;
                if self.known[number] >= depth {
                    continue;
                }
                let block = self.block(number, BLOCKS);
                let part = block.intersect(rect);
                if !self.are_nearer(simd, part, depth) {
                    return false;
                }
                if part == block {
                    self.known[number] = depth;
                }
            }
        }
        true
    }

    /// Is every sample of some pixels nearer than this depth? Columns and rows are those in memory.
    #[inline(always)]
    pub fn are_nearer<S: Simd>(&self, simd: S, rect: PixelRect, depth: f32) -> bool {
        let depth = splat(simd, depth);
        let lanes = i32x16::load_array(simd, LANE_NUMBERS);
        let samples = (rect.x1 - rect.x0 + 1) << self.count_bits;
        for y in rect.y0..rect.y1 + 1 {
            let first = ((y as usize) << self.stride_bits | rect.x0 as usize) << self.count_bits;
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

    /// Removes hidden fragments if there are many: more than four per sample, so that the memory of a tile is bounded.
    #[inline(always)]
    pub fn make_room(&mut self) {
        if self.list.count > 4 * self.fragment.len() {
            self.compact();
        }
    }

    /// Which of the first `count` fragments are visible at a sample.
    #[inline(always)]
    pub fn visible_fragments<S: Simd>(&self, simd: S, count: usize) -> Vec<bool> {
        let mut is_visible = vec![false; count];
        for fragments in self.fragment.as_chunks::<LANES>().0 {
            // In most of a tile there are none.
            let some = u32x16::load_array_ref(simd, fragments).simd_lt(count as u32);
            if some.any_true() {
                for &fragment in fragments {
                    if let Some(is_visible) = is_visible.get_mut(fragment as usize) {
                        *is_visible = true;
                    }
                }
            }
        }
        is_visible
    }

    /// Removes hidden fragments; the others keep their order.
    #[cold]
    #[inline(never)]
    fn compact(&mut self) {
        let is_visible = self.visible_fragments(baseline(), self.list.count);
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
    #[inline(always)]
    pub fn visible<S: Simd>(&self, simd: S) -> u64 {
        let (mut visible, across) = (0, (self.own.x1 - self.own.x0 + 1) as usize);
        let firsts = [0xffff, 0x5555, 0x1111, 0x0101, 0x0001][self.count_bits as usize];
        for y in self.own.y0..self.own.y1 + 1 {
            let first = self.pixel(self.own.x0, y) << self.count_bits;
            let end = first + (across << self.count_bits);
            for at in (first..end).step_by(LANES) {
                let fragments = u32x16::from_slice(simd, &self.fragment[at..at + LANES]);
                let mut drawn = !fragments.simd_eq(NO_FRAGMENT).to_bitmask() as u32;
                if self.blended.is_in_use() {
                    for lane in 0..LANES.min(end - at) {
                        drawn |= u32::from(self.blended.is_at(at + lane)) << lane;
                    }
                }
                // The first sample of a pixel stands for all.
                drawn &= live_lanes(end - at);
                for k in 0..self.count_bits {
                    drawn |= drawn >> (1 << k);
                }
                visible += u64::from((drawn & firsts).count_ones());
            }
        }
        visible
    }
}

#[cfg(test)]
mod tests {
    use crate::dispatch;
    use proptest::prelude::*;

    use super::*;
    use crate::simd::SimdLevel;

    /// The largest tile, of a picture that it is cut off by, with 4 samples per pixel.
    fn memory(right: i32, bottom: i32) -> SampleMemory {
        let (stride_bits, count_bits) = (8, 2);
        let rect = PixelRect { x0: 40, x1: 40 + right, y0: 900, y1: 900 + bottom };
        let samples = ((bottom + 1) as usize) << stride_bits << count_bits;
        let depth = vec![0.0; samples + LANES];
        let known = vec![-1.0; BLOCKS * BLOCKS];
        SampleMemory { depth, known, rect, stride_bits, count_bits, ..SampleMemory::default() }
    }

    /// A rectangle and a depth, in parts of the tile and in quarters.
    type Part = ([f64; 4], u8);

    fn part() -> impl Strategy<Value = Part> {
        ([0.0..1.0, 0.0..1.0, 0.0..1.0, 0.0..1.0], 0_u8..=4)
    }

    fn rect_of(memory: &SampleMemory, [a, b, c, d]: [f64; 4]) -> PixelRect {
        let PixelRect { x0, x1, y0, y1 } = memory.rect;
        let at = |first: i32, last: i32, part: f64| first + (part * f64::from(last - first + 1)) as i32;
        let (x, y) = ([at(x0, x1, a), at(x0, x1, b)], [at(y0, y1, c), at(y0, y1, d)]);
        PixelRect { x0: x[0].min(x[1]), x1: x[0].max(x[1]), y0: y[0].min(y[1]), y1: y[0].max(y[1]) }
    }

    proptest! {
        #[test]
        fn what_is_remembered_changes_no_answer(
            right in 0..130_i32, bottom in 0..130_i32, steps in prop::collection::vec((part(), part()), 1..40),
        ) {
            for level in SimdLevel::available() {
                let mut memory = memory(right, bottom);
                for ((drawn, nearness), (asked, depth)) in &steps {
                    // Depths only become nearer.
                    let rect = rect_of(&memory, *drawn);
                    for y in rect.y0..=rect.y1 {
                        let first = memory.pixel(rect.x0, y) << 2;
                        let count = ((rect.x1 - rect.x0 + 1) as usize) << 2;
                        for old in &mut memory.depth[first..first + count] {
                            *old = old.max(f32::from(*nearness) / 4.0);
                        }
                    }
                    let (rect, depth) = (rect_of(&memory, *asked), f32::from(*depth) / 4.0);
                    let mut samples = (rect.y0..=rect.y1).flat_map(|y| {
                        let first = memory.pixel(rect.x0, y) << 2;
                        &memory.depth[first..first + (((rect.x1 - rect.x0 + 1) as usize) << 2)]
                    });
                    let expected = samples.all(|&sample| sample > depth);
                    let found = dispatch!(level.level().unwrap(), simd => memory.all_nearer(simd, rect, depth));
                    prop_assert_eq!(found, expected, "{:?}: {:?}, {}", level, rect, depth);
                }
            }
        }
    }
}
