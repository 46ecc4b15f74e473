//! Tiles that several ranks have, drawn first by the rank that is in front in most of their blocks: what is behind that, the others need
//! not draw.
//!
//! A rank draws the tiles in which it is in front in a few groups with about the same work, and tells the others after each group
//! behind which depth it hides everything: so they need not wait until it has drawn everything. Then it draws the tiles in which another
//! one is in front, as they are told.

use std::collections::{BTreeMap, BTreeSet};

use tercio_raster::Frame;
use tercio_raster::context::FrameContext;
use tercio_raster::depth_bounds::{DepthBounds, blocks_across};
use tercio_raster::frame::TileFragments;

use super::Rank;
use super::depth_bounds::{BYTES, Others, get, malformed, put};
use crate::comm::{Awaited, Communicator};
use crate::composite::Shared;
use crate::{ParallelError, RankReport};

/// Groups of the tiles in which a rank is in front.
const GROUPS: u64 = 4;
/// Bytes of a message, unless it is of one tile: MPI libraries deliver messages of up to 4 KB while their sender draws, and larger
/// ones not before it sends or receives again.
const MOST_BYTES: usize = 3500;

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
    // This rank's tiles by the rank in front.
    let mut by_front = BTreeMap::<usize, BTreeSet<u32>>::new();
    for (&tile, front) in bounds.tiles().iter().zip(fronts) {
        by_front.entry(front).or_default().insert(tile);
    }
    let blocks = blocks_across(&context.grid).pow(2);
    context.hidden_by_others = Some(DepthBounds::new(&context.grid, bounds.tiles().to_vec()));
    context.nearest_of_others = Some(bounds);
    let mut drawn = Vec::new();
    for tiles in groups(by_front.remove(&rank).unwrap_or_default(), |tile| own.sorted.fill(tile)) {
        own.draw_tiles(context, &tiles, frame, report);
        let found = std::mem::take(&mut frame.fragments);
        let mut messages = BTreeMap::<usize, Vec<u8>>::new();
        for &tile in &tiles {
            let at = found.binary_search_by_key(&tile, |of_tile| of_tile.tile);
            let hides = at.map_or(&[][..], |at| &found[at].finished.hides[..]);
            for to in shared.touched.ranks_of(tile).filter(|&to| to != rank) {
                let message = messages.entry(to).or_default();
                if message.len() + blocks * BYTES > MOST_BYTES {
                    comm.send(to, std::mem::take(message))?;
                }
                message.extend(tile.to_ne_bytes());
                let end = message.len() + blocks * BYTES;
                // The lower half of a depth is cut off: it becomes farther.
                hides.iter().for_each(|&depth| put(depth, message));
                message.resize(end, 0);
            }
        }
        for (to, message) in messages.into_iter().filter(|(_, message)| !message.is_empty()) {
            comm.send(to, message)?;
        }
        drawn.extend(found);
    }
    while !by_front.is_empty() {
        let mut awaited = Awaited::new(by_front.keys().copied());
        let (from, message) = report.stages.wait.time(|| comm.receive_any(&mut awaited))?;
        let mut tiles = Vec::new();
        let theirs = by_front.entry(from).or_default();
        for of_tile in message.chunks(size_of::<u32>() + blocks * BYTES) {
            let told = of_tile.split_first_chunk().filter(|(_, halves)| halves.len() == blocks * BYTES);
            let (tile, halves) = told.ok_or_else(|| malformed(from))?;
            let tile = u32::from_ne_bytes(*tile);
            if !theirs.remove(&tile) {
                return Err(malformed(from));
            }
            let hidden = context.hidden_by_others.as_mut().and_then(|hidden| hidden.of_mut(tile));
            for (hidden, half) in hidden.into_iter().flatten().zip(halves.chunks_exact(BYTES)) {
                // Also infinity, of finished blocks; anything else is not a depth.
                *hidden = Some(get(half)).filter(|depth| *depth >= 0.0).ok_or_else(|| malformed(from))?;
            }
            tiles.push(tile);
        }
        if theirs.is_empty() {
            by_front.remove(&from);
        }
        own.draw_tiles(context, &tiles, frame, report);
        drawn.append(&mut frame.fragments);
    }
    Ok(drawn)
}

/// Consecutive tiles in groups of about the same work.
fn groups(tiles: BTreeSet<u32>, work: impl Fn(u32) -> u64) -> Vec<Vec<u32>> {
    let all: u64 = tiles.iter().map(|&tile| work(tile)).sum();
    let (mut groups, mut before) = (vec![Vec::new(); GROUPS as usize], 0);
    for tile in tiles {
        // By the middle of its work.
        let middle = before + work(tile) / 2;
        groups[(middle * GROUPS / all.max(1)).min(GROUPS - 1) as usize].push(tile);
        before += work(tile);
    }
    groups.retain(|tiles| !tiles.is_empty());
    groups
}
