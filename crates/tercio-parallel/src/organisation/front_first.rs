//! Tiles that several ranks have, drawn first by the rank that is in front in most of their blocks: what that has finished, the others
//! need not draw.
//!
//! The tiles are divided into a few sections, in their order. A rank draws those in which it is in front, section by section, and tells
//! the others after each section which blocks it has finished, one bit each: so they need not wait until it has drawn everything.

use std::collections::BTreeMap;

use tercio_raster::Frame;
use tercio_raster::context::FrameContext;
use tercio_raster::depth_bounds::{DepthBounds, blocks_across};
use tercio_raster::frame::TileFragments;

use super::Rank;
use super::depth_bounds::Others;
use crate::comm::Communicator;
use crate::composite::Shared;
use crate::composite::packet::PacketError;
use crate::{ParallelError, RankReport};

/// Sections of the shared tiles.
const SECTIONS: usize = 4;

/// Draws the shared tiles of this rank, and returns what it has of each. The frame then has the finished pixels of all of them, and the
/// background elsewhere in them.
///
/// # Errors
/// [`ParallelError::Comm`], [`ParallelError::Packet`].
pub fn draw(
    own: &mut Rank,
    comm: &mut impl Communicator,
    context: &mut FrameContext,
    others: Others,
    shared: &Shared,
    frame: &mut Frame,
    report: &mut RankReport,
) -> Result<Vec<TileFragments>, ParallelError> {
    let rank = comm.rank();
    let Others { mut bounds, fronts } = others;
    // Of each section, this rank's tiles by the rank in front.
    let mut sections = vec![BTreeMap::<usize, Vec<u32>>::new(); SECTIONS];
    for (&tile, front) in bounds.tiles().iter().zip(fronts) {
        let place = shared.tiles.partition_point(|&other| other < tile);
        sections[place * SECTIONS / shared.tiles.len()].entry(front).or_default().push(tile);
    }
    let size = blocks_across(&context.grid).pow(2).div_ceil(8);
    let mut drawn = Vec::new();
    for tiles in sections.iter_mut().filter_map(|section| section.remove(&rank)) {
        context.nearest_of_others = Some(bounds);
        own.draw_tiles(context, &tiles, frame, report);
        bounds = context.nearest_of_others.take().unwrap_or_default();
        let found = std::mem::take(&mut frame.fragments);
        let mut messages = BTreeMap::<usize, Vec<u8>>::new();
        for &tile in &tiles {
            let at = found.binary_search_by_key(&tile, |of_tile| of_tile.tile);
            let hides = at.map_or(&[][..], |at| &found[at].finished.hides[..]);
            for to in shared.touched.ranks_of(tile).filter(|&to| to != rank) {
                let message = messages.entry(to).or_default();
                message.extend_from_slice(hides);
                message.resize(message.len() + size - hides.len(), 0);
            }
        }
        for (to, message) in messages {
            comm.send(to, message)?;
        }
        drawn.extend(found);
    }
    for section in sections {
        let mut tiles = Vec::new();
        for (from, theirs) in section {
            let message = report.stages.wait.time(|| comm.receive(from))?;
            if message.len() != theirs.len() * size {
                return Err(ParallelError::Packet { from, source: PacketError::Short { at: message.len() } });
            }
            for (&tile, finished) in theirs.iter().zip(message.chunks_exact(size)) {
                hide(&mut bounds, tile, finished);
            }
            tiles.extend(theirs);
        }
        if !tiles.is_empty() {
            tiles.sort_unstable();
            context.nearest_of_others = Some(bounds);
            own.draw_tiles(context, &tiles, frame, report);
            bounds = context.nearest_of_others.take().unwrap_or_default();
            drawn.append(&mut frame.fragments);
        }
    }
    Ok(drawn)
}

/// Notes which blocks of a tile another rank has finished.
fn hide(bounds: &mut DepthBounds, tile: u32, finished: &[u8]) {
    let blocks = bounds.of_mut(tile).into_iter().flatten().enumerate();
    blocks.filter(|(k, _)| finished[k / 8] >> (k % 8) & 1 == 1).for_each(|(_, bound)| *bound = f32::INFINITY);
}
