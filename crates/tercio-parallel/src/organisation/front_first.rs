//! Tiles that several ranks have, drawn first by the rank that is in front in most of their blocks: what that has finished, the others
//! need not draw.
//!
//! The tiles are divided into a few sections, in their order. A rank draws those in which it is in front, section by section, and tells
//! the others after each section which blocks it has finished: so they need not wait until it has drawn everything.

use std::ops::Range;

use tercio_raster::Frame;
use tercio_raster::context::FrameContext;
use tercio_raster::depth_bounds::blocks_across;
use tercio_raster::frame::TileFragments;

use super::Rank;
use super::depth_bounds::Others;
use crate::comm::Communicator;
use crate::composite::Shared;
use crate::composite::packet::PacketError;
use crate::{ParallelError, RankReport};

/// Sections of the shared tiles.
const SECTIONS: usize = 4;

/// The shared tiles of each section, as places in their list.
fn sections(shared: &Shared) -> impl Iterator<Item = Range<usize>> + use<> {
    let count = shared.tiles.len();
    (0..SECTIONS).map(move |k| count * k / SECTIONS..count * (k + 1) / SECTIONS)
}

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
    let Others { bounds, fronts } = others;
    let tiles = bounds.tiles().to_vec();
    context.nearest_of_others = Some(bounds);
    let front_of = |tile: &u32| tiles.binary_search(tile).map_or(rank, |at| fronts[at]);
    // This rank's tiles in a section with that rank in front.
    let of = |section: &Range<usize>, front: usize| -> Vec<u32> {
        let own = shared.tiles[section.clone()]
            .iter()
            .copied()
            .filter(|&tile| shared.touched.is_touched(rank, tile));
        own.filter(|tile| front_of(tile) == front).collect()
    };
    let mut drawn = Vec::new();
    for section in sections(shared) {
        let tiles = of(&section, rank);
        if tiles.is_empty() {
            continue;
        }
        own.draw_tiles(context, &tiles, frame, report);
        let found = std::mem::take(&mut frame.fragments);
        for &to in shared.ranks.iter().filter(|&&to| to != rank) {
            let theirs = tiles.iter().filter(|&&tile| shared.touched.is_touched(to, tile));
            let mut message = comm.buffer(to);
            let mut is_sent = false;
            for tile in theirs {
                is_sent = true;
                let at = found.binary_search_by_key(tile, |of_tile| of_tile.tile);
                let hides = at.map_or(&[][..], |at| &found[at].finished.hides[..]);
                message.extend((0..bytes_of_tile(context)).map(|k| hides.get(k).copied().unwrap_or(0)));
            }
            if is_sent {
                comm.send(to, message)?;
            }
        }
        drawn.extend(found);
    }
    for section in sections(shared) {
        let mut tiles = Vec::new();
        for &from in shared.ranks.iter().filter(|&&from| from != rank) {
            let theirs = of(&section, from);
            if theirs.is_empty() {
                continue;
            }
            let message = report.stages.wait.time(|| comm.receive(from))?;
            if message.len() != theirs.len() * bytes_of_tile(context) {
                return Err(ParallelError::Packet { from, source: PacketError::Short { at: message.len() } });
            }
            let size = bytes_of_tile(context);
            for (&tile, hidden) in theirs.iter().zip(message.chunks_exact(size)) {
                let bounds = context.nearest_of_others.as_mut().and_then(|bounds| bounds.of_mut(tile));
                let blocks = bounds.into_iter().flatten().enumerate();
                blocks
                    .filter(|(k, _)| hidden[k / 8] >> (k % 8) & 1 == 1)
                    .for_each(|(_, bound)| *bound = f32::INFINITY);
            }
            comm.give_back(from, message);
            tiles.extend(theirs);
        }
        if !tiles.is_empty() {
            tiles.sort_unstable();
            own.draw_tiles(context, &tiles, frame, report);
            drawn.append(&mut frame.fragments);
        }
    }
    Ok(drawn)
}

/// Bytes of the blocks of a tile, one bit each.
fn bytes_of_tile(context: &FrameContext) -> usize {
    blocks_across(&context.grid).pow(2).div_ceil(8)
}
