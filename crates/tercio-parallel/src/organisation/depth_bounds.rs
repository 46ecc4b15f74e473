//! How near ranks may draw in the tiles that several of them have, exchanged before they draw these.
//!
//! Each rank sends the bounds of its blocks to the owner of their tile, 2 bytes each. The owner replies with the rank that is in front in
//! the tile, 4 bytes, and for each block how near any other rank may draw, 2 bytes: at most two messages each way between two ranks.

use std::collections::BTreeMap;

use bytemuck::pod_read_unaligned;
use tercio_mesh::loops::prelude::*;
use tercio_raster::binning::Sorted;
use tercio_raster::context::FrameContext;
use tercio_raster::depth_bounds::DepthBounds;
use tercio_raster::screen::TileGrid;

use crate::ParallelError;
use crate::comm::Communicator;
use crate::composite::packet::PacketError;
use crate::composite::{Composition, Shared};
use crate::report::RankStages;

/// Bytes of the bound of a block: the upper half of a number.
pub const BYTES: usize = size_of::<u16>();

/// The bounds of this rank's own blocks, which the owners of the tiles have been sent.
pub struct Own {
    bounds: DepthBounds,
    /// The tiles, by their owners.
    by_owner: BTreeMap<usize, Vec<u32>>,
}

/// Finds how near this rank may draw in the shared tiles that it has, from what is sorted into them, and sends it to their owners.
///
/// # Errors
/// [`ParallelError::Comm`].
pub fn send(
    comm: &mut impl Communicator,
    context: &FrameContext,
    sorted: &Sorted,
    shared: &Shared,
    stages: &mut RankStages,
) -> Result<Own, ParallelError> {
    let rank = comm.rank();
    let own = stages.compose.time(|| {
        let mut bounds = DepthBounds::new(&context.grid, shared.tiles_of(rank));
        let tiles: Vec<(u32, &mut [f32])> = bounds.tiles_mut().collect();
        tiles.into_par_iter().for_each(|(tile, of)| {
            sorted.raise_bounds(context, tile, of);
            of.iter_mut().for_each(|depth| *depth = rounded(*depth));
        });
        let mut by_owner = BTreeMap::<usize, Vec<u32>>::new();
        for (&tile, owner) in shared.tiles.iter().zip(Composition::DirectSend.owners(shared)) {
            if shared.touched.is_touched(rank, tile) {
                by_owner.entry(shared.ranks[owner]).or_default().push(tile);
            }
        }
        Own { bounds, by_owner }
    });
    for (&owner, tiles) in own.by_owner.iter().filter(|(owner, _)| **owner != rank) {
        // These messages are small: memory of earlier ones is for the large ones.
        let mut message = Vec::new();
        let bounds = tiles.iter().filter_map(|&tile| own.bounds.of(tile)).flatten();
        bounds.for_each(|&depth| put(depth, &mut message));
        comm.send(owner, message)?;
    }
    Ok(own)
}

/// What a rank knows of others in the shared tiles that it has.
pub struct Others {
    /// How near they may draw.
    pub bounds: DepthBounds,
    /// Of each of the tiles, the rank that is nearest in most blocks.
    pub fronts: Vec<usize>,
}

impl Own {
    /// Waits for the bounds of the tiles that this rank owns, replies to them, and returns what is known of others in the shared tiles
    /// that this rank has.
    ///
    /// # Errors
    /// [`ParallelError::Comm`], [`ParallelError::Packet`].
    pub fn receive(
        mut self,
        comm: &mut impl Communicator,
        context: &FrameContext,
        shared: &Shared,
        stages: &mut RankStages,
    ) -> Result<Others, ParallelError> {
        let (rank, grid) = (comm.rank(), &context.grid);
        // Owners have all of their tiles.
        let owned = self.by_owner.remove(&rank).unwrap_or_default();
        let mut known = Vec::new();
        for &from in shared.ranks {
            let is_theirs = |tile: &u32| shared.touched.is_touched(from, *tile);
            let tiles: Vec<u32> = owned.iter().copied().filter(is_theirs).collect();
            if tiles.is_empty() {
                continue;
            }
            let mut bounds = DepthBounds::new(grid, tiles);
            if from == rank {
                let of = |tile: u32| self.bounds.of(tile).unwrap_or_default();
                bounds.tiles_mut().for_each(|(tile, to)| to.copy_from_slice(of(tile)));
            } else {
                let message = stages.wait.time(|| comm.receive(from))?;
                read(&message, &mut bounds).ok_or_else(|| malformed(from))?;
            }
            known.push((from, bounds));
        }
        let nearest = stages.compose.time(|| Nearest::of(grid, owned, &known));
        let mut others = Others {
            fronts: vec![rank; self.bounds.tiles().len()],
            bounds: DepthBounds::new(grid, self.bounds.tiles().to_vec()),
        };
        for (to, bounds) in known {
            let mut message = Vec::new();
            nearest.reply(&bounds, &mut message);
            match to == rank {
                true => others.read(shared, bounds.tiles(), &message).ok_or_else(|| malformed(rank))?,
                false => comm.send(to, message)?,
            }
        }
        for (from, tiles) in self.by_owner {
            let message = stages.wait.time(|| comm.receive(from))?;
            others.read(shared, &tiles, &message).ok_or_else(|| malformed(from))?;
        }
        Ok(others)
    }
}

impl Others {
    /// Reads what the owner of some tiles replied: of each the rank in front, and the bounds of its blocks; `None` if that cannot be.
    fn read(&mut self, shared: &Shared, tiles: &[u32], message: &[u8]) -> Option<()> {
        let mut unread = Unread(message);
        for tile in tiles {
            let at = self.bounds.tiles().binary_search(tile).ok()?;
            let front = pod_read_unaligned::<u32>(unread.take(size_of::<u32>())?) as usize;
            let is_there = shared.ranks.binary_search(&front).is_ok();
            self.fronts[at] = (is_there && shared.touched.is_touched(front, *tile)).then_some(front)?;
            unread.bounds(self.bounds.of_mut(*tile)?)?;
        }
        unread.end()
    }
}

/// The nearest ranks in the blocks of tiles.
struct Nearest {
    /// How near any rank may draw.
    first: DepthBounds,
    /// How near any but one of those may that are as near.
    second: DepthBounds,
    /// The rank that is nearest in most blocks of each tile, and in how many.
    fronts: Vec<Option<(usize, usize)>>,
}

impl Nearest {
    /// Of the tiles of an owner, and the bounds of all ranks that have some of them.
    fn of(grid: &TileGrid, tiles: Vec<u32>, ranks: &[(usize, DepthBounds)]) -> Self {
        let (mut first, mut second) = (DepthBounds::new(grid, tiles.clone()), DepthBounds::new(grid, tiles));
        for (_, bounds) in ranks {
            for ((tile, first), (_, second)) in first.tiles_mut().zip(second.tiles_mut()) {
                let own = bounds.of(tile).into_iter().flatten();
                for ((first, second), &depth) in first.iter_mut().zip(second).zip(own) {
                    *second = second.max(depth.min(*first));
                    *first = first.max(depth);
                }
            }
        }
        let mut fronts = vec![None; first.tiles().len()];
        for (rank, bounds) in ranks {
            for (tile, front) in first.tiles().iter().zip(&mut fronts) {
                let (Some(first), Some(own)) = (first.of(*tile), bounds.of(*tile)) else { continue };
                let blocks = own.iter().zip(first).filter(|(own, first)| own == first && **own > 0.0).count();
                if front.is_none_or(|(_, most)| blocks > most) {
                    *front = Some((*rank, blocks));
                }
            }
        }
        Self { first, second, fronts }
    }

    /// Appends the reply to a rank with these bounds: of each tile the rank in front, and how near others may draw.
    fn reply(&self, bounds: &DepthBounds, message: &mut Vec<u8>) {
        for &tile in bounds.tiles() {
            let Ok(at) = self.first.tiles().binary_search(&tile) else { continue };
            let front = self.fronts[at].map_or(0, |(rank, _)| rank);
            message.extend((front as u32).to_ne_bytes());
            let [own, first, second] =
                [bounds, &self.first, &self.second].map(|of| of.of(tile).unwrap_or_default());
            for ((own, first), second) in own.iter().zip(first).zip(second) {
                put(if own == first { *second } else { *first }, message);
            }
        }
    }
}

pub fn malformed(from: usize) -> ParallelError {
    ParallelError::Packet { from, source: PacketError::Short { at: 0 } }
}

/// The next number, upwards, whose lower half is 0. Precondition: it is not negative.
fn rounded(depth: f32) -> f32 {
    f32::from_bits(depth.to_bits().saturating_add(0xffff) & 0xffff_0000)
}

/// Appends the upper half of a depth.
pub fn put(depth: f32, message: &mut Vec<u8>) {
    message.extend(((depth.to_bits() >> 16) as u16).to_ne_bytes());
}

/// Reads a depth, whose lower half is 0.
pub fn get(half: &[u8]) -> f32 {
    f32::from_bits(u32::from(pod_read_unaligned::<u16>(half)) << 16)
}

/// Reads the bounds of all tiles; `None` if they are not as many, or not valid.
fn read(message: &[u8], bounds: &mut DepthBounds) -> Option<()> {
    let mut unread = Unread(message);
    bounds.tiles_mut().try_for_each(|(_, of)| unread.bounds(of))?;
    unread.end()
}

/// What is left to read of a message.
struct Unread<'a>(&'a [u8]);

impl<'a> Unread<'a> {
    /// The next bytes; `None` if there are not so many.
    fn take(&mut self, bytes: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(bytes)?;
        self.0 = rest;
        Some(taken)
    }

    /// The bounds of a tile; `None` if there are not so many, or any is not valid.
    fn bounds(&mut self, bounds: &mut [f32]) -> Option<()> {
        let halves = self.take(bounds.len() * BYTES)?;
        for (to, half) in bounds.iter_mut().zip(halves.chunks_exact(BYTES)) {
            let depth = get(half);
            *to = (depth.is_finite() && depth >= 0.0).then_some(depth)?;
        }
        Some(())
    }

    /// `None` if something is left.
    fn end(self) -> Option<()> {
        self.0.is_empty().then_some(())
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use tercio_raster::TileSet;

    use super::*;
    use crate::composite::Touched;

    proptest! {
        #[test]
        fn bounds_are_rounded_towards_the_viewer(depth in 0.0f32..f32::MAX) {
            let found = rounded(depth);
            prop_assert!(found >= depth && found.to_bits() & 0xffff == 0);
            prop_assert!(found == f32::INFINITY || found - depth <= depth / 128.0 + f32::MIN_POSITIVE);
            prop_assert_eq!(rounded(found), found);
        }

        /// Against each rank's bounds compared with those of all others.
        #[test]
        fn replies_have_the_nearest_of_the_others(
            ranks in prop::collection::vec((0u8..8, prop::collection::vec(0u16..4, 12)), 1..6),
        ) {
            // Three tiles of four blocks. The first rank, the owner, has all of them.
            let grid = TileGrid::new(48, 16, 16, TileSet::ALL);
            let mut known = Vec::new();
            for (rank, (has, depths)) in ranks.iter().enumerate() {
                let tiles = (0..3).filter(|tile| rank == 0 || has >> tile & 1 == 1).collect();
                let mut bounds = DepthBounds::new(&grid, tiles);
                for (tile, to) in bounds.tiles_mut() {
                    let depths = &depths[4 * tile as usize..];
                    to.iter_mut().zip(depths).for_each(|(to, &depth)| *to = f32::from(depth));
                }
                known.push((10 + rank, bounds));
            }
            let nearest = Nearest::of(&grid, vec![0, 1, 2], &known);
            // Numbers of ranks are not their places.
            let ranks = &ranks;
            let touches = |rank: usize| move |tile: u32| rank == 10 || rank > 10 && ranks.get(rank - 10).is_some_and(|of| of.0 >> tile & 1 == 1);
            let touched = Touched::new(3, (0..10 + known.len()).map(touches));
            let among: Vec<usize> = known.iter().map(|(rank, _)| *rank).collect();
            let shared = Shared { tiles: &[0, 1, 2], ranks: &among, touched: &touched };
            for (rank, bounds) in &known {
                let mut message = Vec::new();
                nearest.reply(bounds, &mut message);
                let fresh = || Others { bounds: DepthBounds::new(&grid, vec![0, 1, 2]), fronts: vec![0; 3] };
                let mut found = fresh();
                found.read(&shared, bounds.tiles(), &message).expect("a reply");
                for &tile in bounds.tiles() {
                    let others = known.iter().filter(|(other, _)| other != rank);
                    let all: Vec<&[f32]> = others.filter_map(|(_, bounds)| bounds.of(tile)).collect();
                    let expected: Vec<f32> =
                        (0..4).map(|block| all.iter().fold(0.0, |most, of| of[block].max(most))).collect();
                    prop_assert_eq!(found.bounds.of(tile), Some(&expected[..]));
                    // The rank with the most blocks in which none is nearer; of several the first.
                    let nearer = |(_, bounds): &&(usize, DepthBounds)| {
                        let most = |block: usize| known.iter().filter_map(|(_, b)| b.of(tile)).fold(0.0, |m: f32, of| m.max(of[block]));
                        let Some(own) = bounds.of(tile) else { return -1 };
                        (0..4).filter(|&block| own[block] > 0.0 && own[block] == most(block)).count() as i32
                    };
                    let front = known.iter().rev().max_by_key(nearer).expect("a rank").0;
                    prop_assert_eq!(found.fronts[tile as usize], front);
                }
                // Nothing is missing, nothing more, and nothing that cannot be: a rank that has nothing there, or a depth beyond all.
                if !bounds.tiles().is_empty() {
                    let read = |message: &[u8]| fresh().read(&shared, bounds.tiles(), message);
                    prop_assert!(read(&message[..message.len() - 1]).is_none());
                    for (at, bytes) in [(0, 3u32.to_ne_bytes()), (4, [0xff; 4])] {
                        let mut wrong = message.clone();
                        wrong[at..at + 4].copy_from_slice(&bytes);
                        prop_assert!(read(&wrong).is_none());
                    }
                    message.push(0);
                    prop_assert!(read(&message).is_none());
                }
            }
        }
    }
}
