//! Tiles that several ranks have, drawn first by the rank that is in front in most of their blocks: what is behind that, the others need
//! not draw.
//!
//! A rank draws the tiles in which it is in front in a few groups with about the same work. After each group it sends the others the
//! depths behind which it hides everything, so that they need not wait until it has drawn everything. Then it draws the tiles in which
//! another rank is in front, as messages about them arrive.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

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
                let bytes = size_of::<u32>() + blocks * BYTES;
                if message.len() + bytes > MOST_BYTES && !message.is_empty() {
                    comm.send(to, std::mem::take(message))?;
                }
                let end = message.len() + bytes;
                message.extend(tile.to_ne_bytes());
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
        let mut arrived = vec![report.stages.wait.time(|| comm.receive_any(&mut awaited))?];
        // What else has arrived is drawn together with that.
        for from in awaited.iter() {
            let message = comm.receive_within(from, Duration::ZERO)?;
            arrived.extend(message.map(|message| (from, message)));
        }
        let mut tiles = Vec::new();
        for (from, message) in arrived {
            let theirs = by_front.entry(from).or_default();
            let hidden = context.hidden_by_others.as_mut().ok_or_else(|| malformed(from))?;
            read(&message, blocks, theirs, hidden, &mut tiles).ok_or_else(|| malformed(from))?;
            if theirs.is_empty() {
                by_front.remove(&from);
            }
        }
        tiles.sort_unstable();
        own.draw_tiles(context, &tiles, frame, report);
        drawn.append(&mut frame.fragments);
    }
    Ok(drawn)
}

/// Reads what a rank hides in some of its tiles, which are removed from those that it has not reported, and appended to the `reported`
/// ones; `None` if that cannot be.
fn read(
    message: &[u8],
    blocks: usize,
    left: &mut BTreeSet<u32>,
    hidden: &mut DepthBounds,
    reported: &mut Vec<u32>,
) -> Option<()> {
    for of_tile in message.chunks(size_of::<u32>() + blocks * BYTES) {
        let (tile, halves) = of_tile.split_first_chunk()?;
        let tile = u32::from_ne_bytes(*tile);
        let is_whole = halves.len() == blocks * BYTES && left.remove(&tile);
        for (hidden, half) in
            hidden.of_mut(tile).filter(|_| is_whole)?.iter_mut().zip(halves.chunks_exact(BYTES))
        {
            // Also infinity, of finished blocks; anything else is not a depth.
            *hidden = Some(get(half)).filter(|depth| *depth >= 0.0)?;
        }
        reported.push(tile);
    }
    Some(())
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

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use tercio_raster::TileSet;
    use tercio_raster::screen::TileGrid;

    use super::*;

    proptest! {
        #[test]
        fn groups_have_all_tiles_in_their_order_and_about_the_same_work(
            work in prop::collection::vec(0u64..100, 0..40),
        ) {
            let tiles: BTreeSet<u32> = (0..work.len() as u32).map(|number| 3 * number).collect();
            let found = groups(tiles.clone(), |tile| work[tile as usize / 3]);
            prop_assert!(found.len() <= GROUPS as usize && found.iter().all(|tiles| !tiles.is_empty()));
            prop_assert!(found.iter().flatten().eq(&tiles));
            // No group has more than its share and half of its first and last tile.
            let most = work.iter().max().copied().unwrap_or(0);
            for tiles in found {
                let sum: u64 = tiles.iter().map(|&tile| work[tile as usize / 3]).sum();
                prop_assert!(sum <= work.iter().sum::<u64>() / GROUPS + most + 2, "{sum}");
            }
        }
    }

    /// Two tiles of four blocks, of which a rank is in front in the second.
    #[test]
    fn what_a_rank_cannot_tell_is_refused() {
        let grid = TileGrid::new(32, 16, 16, TileSet::ALL);
        let read = |message: &[u8]| {
            let (mut left, mut tiles) = (BTreeSet::from([1]), Vec::new());
            let mut hidden = DepthBounds::new(&grid, vec![0, 1]);
            read(message, 4, &mut left, &mut hidden, &mut tiles)?;
            Some((left.len(), tiles, hidden.of(1).expect("a tile").to_vec()))
        };
        let mut good = 1u32.to_ne_bytes().to_vec();
        [0.0, 0.5, 2.0, f32::INFINITY].into_iter().for_each(|depth| put(depth, &mut good));
        assert_eq!(read(&good), Some((0, vec![1], vec![0.0, 0.5, 2.0, f32::INFINITY])));
        assert_eq!(read(&[]), Some((1, Vec::new(), vec![0.0; 4])));
        let other = [&0u32.to_ne_bytes()[..], &good[4..]].concat();
        let wrong = [f32::NAN, -1.0].map(|depth| {
            let mut message = good[..10].to_vec();
            put(depth, &mut message);
            message
        });
        for message in [&good[..11], &good[..3], &[&good[..], &good].concat(), &other, &wrong[0], &wrong[1]] {
            assert_eq!(read(message), None, "{message:?}");
        }
    }
}
