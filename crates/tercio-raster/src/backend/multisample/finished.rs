//! Blocks of a tile that are finished: no other rank can draw anything that is seen there.

use fearless_simd::Simd;

use super::fragments::NO_FRAGMENT;
use super::memory::SampleMemory;
use crate::context::FrameContext;
use crate::depth_bounds::{BLOCK_BITS, blocks_across};
use crate::frame::Outputs;
use crate::frame::fragments::{FragmentHead, write_finished};
use crate::screen::PixelRect;
use crate::simd::part;

/// Which blocks of a tile are finished, row by row.
#[derive(Debug, Default)]
pub struct FinishedBlocks {
    flags: Vec<bool>,
    across: usize,
}

impl FinishedBlocks {
    /// Those of a tile that was drawn, if a frame that keeps its fragments knows how near other ranks draw; else none. Returns what
    /// others need not draw ([`FinishedPart::hides`](crate::frame::FinishedPart)), and appends finished blocks in which they may draw
    /// something to the fragments.
    pub fn find<S: Simd>(
        &mut self,
        simd: S,
        context: &FrameContext,
        memory: &SampleMemory,
        tile: u32,
        outputs: &Outputs,
        out: &mut Vec<u8>,
    ) -> Vec<f32> {
        self.flags.clear();
        self.across = blocks_across(&context.grid);
        let Some(others) = context.others_in(tile) else { return Vec::new() };
        let hidden = context.hidden_in(tile).unwrap_or_default();
        let mut hides = vec![0.0; others.len()];
        for (number, (&nearest, hides)) in others.iter().zip(&mut hides).enumerate() {
            let behind = hidden.get(number).copied().unwrap_or(0.0);
            // Another rank has finished the block.
            if behind == f32::INFINITY {
                self.flags.push(false);
                continue;
            }
            let rect = memory.block(number, self.across);
            let farthest = part(
                simd,
                #[inline(always)]
                || memory.farthest(simd, rect),
            );
            let is_finished = farthest > nearest || nearest == 0.0 && behind == 0.0;
            self.flags.push(is_finished);
            if nearest > 0.0 {
                *hides = if is_finished { f32::INFINITY } else { farthest };
            }
        }
        let is_run = |number: usize| hides[number] == f32::INFINITY;
        let layout = context.fragment_layout(outputs);
        let mut first = 0;
        while let Some(begin) = (first..hides.len()).find(|&number| is_run(number)) {
            first = (begin..hides.len()).find(|&number| !is_run(number)).unwrap_or(hides.len());
            write_finished(layout, begin, first - begin, out);
        }
        hides
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
            memory.clear_pixels(memory.block(number, self.across));
        }
    }
}

/// The numbers of the blocks of a record of finished blocks ([`crate::frame::fragments`]); `None` if the tile does not have them.
pub fn blocks_of(context: &FrameContext, head: &FragmentHead) -> Option<std::ops::Range<usize>> {
    let first = usize::from(head.place);
    let end = first.checked_add(usize::try_from(head.primitive).ok()?)?;
    (first < end && end <= blocks_across(&context.grid).pow(2)).then_some(first..end)
}

impl SampleMemory {
    /// Removes what was drawn in blocks that another rank has finished.
    pub fn clear_block(&mut self, context: &FrameContext, number: usize) {
        self.clear_pixels(self.block(number, blocks_across(&context.grid)));
    }

    /// Removes what was drawn in some pixels, counted from the first one in memory.
    fn clear_pixels(&mut self, rect: PixelRect) {
        self.fill_depth(rect, 0.0);
        for samples in self.rows_of_samples(rect) {
            self.fragment[samples].fill(NO_FRAGMENT);
        }
    }
}
