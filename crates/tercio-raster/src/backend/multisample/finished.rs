//! Blocks of a tile that are finished: no other rank can draw anything that is seen there.

use fearless_simd::Simd;

use super::fragments::NO_FRAGMENT;
use super::memory::SampleMemory;
use crate::context::FrameContext;
use crate::depth_bounds::{BLOCK_BITS, block, blocks_across};
use crate::frame::Outputs;
use crate::frame::fragments::FragmentHead;
use crate::screen::PixelRect;
use crate::simd::part;

/// Which blocks of a tile are finished, row by row.
#[derive(Debug, Default)]
pub struct FinishedBlocks {
    flags: Vec<bool>,
    across: usize,
}

impl FinishedBlocks {
    /// Those of a tile that was drawn, if a frame that keeps its fragments knows how near other ranks draw; else none. Blocks in which
    /// others may draw something that is hidden are appended to the fragments, and returned
    /// ([`FinishedPart::hides`](crate::frame::FinishedPart)). Removes what was drawn in blocks that another rank has finished.
    pub fn find<S: Simd>(
        &mut self,
        simd: S,
        context: &FrameContext,
        memory: &mut SampleMemory,
        tile: u32,
        outputs: &Outputs,
        out: &mut Vec<u8>,
    ) -> Vec<u8> {
        self.flags.clear();
        self.across = blocks_across(&context.grid);
        let Some(others) = context.others_in(tile) else { return Vec::new() };
        for (number, &nearest) in others.iter().enumerate() {
            let rect = rect(memory, number, self.across);
            if nearest == f32::INFINITY {
                memory.clear_pixels(rect);
            }
            let is_finished = nearest == 0.0
                || !rect.is_empty()
                    && part(
                        simd,
                        #[inline(always)]
                        || memory.are_nearer(simd, rect, nearest),
                    );
            self.flags.push(is_finished);
        }
        let hides = |number: usize| self.flags[number] && others[number] > 0.0;
        if !(0..self.flags.len()).any(hides) {
            return Vec::new();
        }
        let mut bits = vec![0; self.flags.len().div_ceil(8)];
        (0..self.flags.len()).filter(|&number| hides(number)).for_each(|k| bits[k / 8] |= 1 << (k % 8));
        let layout = context.fragment_layout(outputs);
        let mut first = 0;
        while let Some(begin) = (first..self.flags.len()).find(|&number| hides(number)) {
            first = (begin..self.flags.len()).find(|&number| !hides(number)).unwrap_or(self.flags.len());
            let end = out.len() + layout.bytes(0);
            out.extend_from_slice(bytemuck::bytes_of(&blocks_head(begin, first - begin)));
            out.resize(end, 0);
        }
        bits
    }

    /// Is any block finished?
    #[inline(always)]
    pub fn any(&self) -> bool {
        self.flags.contains(&true)
    }

    /// Is the block finished that has this pixel, given by its column and row in the tile?
    #[inline(always)]
    pub fn contains(&self, [column, row]: [usize; 2]) -> bool {
        let number = (row >> BLOCK_BITS) * self.across + (column >> BLOCK_BITS);
        self.flags.get(number).is_some_and(|&is_finished| is_finished)
    }

    /// Removes what was drawn elsewhere.
    pub fn retain(&self, memory: &mut SampleMemory) {
        for (number, _) in self.flags.iter().enumerate().filter(|(_, is_finished)| !**is_finished) {
            memory.clear_pixels(rect(memory, number, self.across));
        }
    }
}

/// The record of a run of finished blocks among the fragments: see [`crate::frame::fragments`].
fn blocks_head(first: usize, count: usize) -> FragmentHead {
    FragmentHead { primitive: count as u32, place: first as u16, mask: 0, color: [0.0; 4] }
}

/// The numbers of the blocks of such a record; `None` if the tile does not have them.
pub fn blocks_of(context: &FrameContext, head: &FragmentHead) -> Option<std::ops::Range<usize>> {
    let first = usize::from(head.place);
    let end = first.checked_add(usize::try_from(head.primitive).ok()?)?;
    (first < end && end <= blocks_across(&context.grid).pow(2)).then_some(first..end)
}

/// The pixels of a block that are in the tile, counted from the first one in memory.
fn rect(memory: &SampleMemory, number: usize, across: usize) -> PixelRect {
    let PixelRect { x0, x1, y0, y1 } = memory.rect;
    block(number, across).intersect(PixelRect { x0: 0, x1: x1 - x0, y0: 0, y1: y1 - y0 })
}

impl SampleMemory {
    /// Removes what was drawn in blocks that another rank has finished.
    pub fn clear_block(&mut self, context: &FrameContext, number: usize) {
        self.clear_pixels(rect(self, number, blocks_across(&context.grid)));
    }

    /// Removes what was drawn in some pixels, counted from the first one in memory.
    fn clear_pixels(&mut self, rect: PixelRect) {
        if rect.is_empty() {
            return;
        }
        for y in rect.y0..=rect.y1 {
            let first = (y as usize) << self.stride_bits;
            let samples = (first + rect.x0 as usize) << self.count_bits
                ..(first + rect.x1 as usize + 1) << self.count_bits;
            self.depth[samples.clone()].fill(0.0);
            self.fragment[samples].fill(NO_FRAGMENT);
        }
    }
}
