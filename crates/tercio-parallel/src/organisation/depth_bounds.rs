//! How near ranks may draw in the tiles that several of them have, exchanged before they draw these.
//!
//! Each rank sends the bounds of its blocks to the owner of their tile, and gets for each block how near any other rank may draw: at
//! most two messages for each pair of ranks, and two bytes a block each way.

use std::collections::BTreeMap;
use std::slice::ChunksExact;

use bytemuck::pod_read_unaligned;
use tercio_mesh::loops::prelude::*;
use tercio_raster::binning::Sorted;
use tercio_raster::context::FrameContext;
use tercio_raster::depth_bounds::DepthBounds;

use crate::ParallelError;
use crate::comm::Communicator;
use crate::composite::packet::PacketError;
use crate::composite::{Composition, Shared};
use crate::report::RankStages;

/// Bytes of the bound of a block: the upper half of a number.
const BYTES: usize = size_of::<u16>();

/// The bounds of this rank's own blocks, which the owners of the tiles have been sent.
pub struct Own {
    bounds: DepthBounds,
    /// The rank that owns each of the shared tiles.
    owners: Vec<usize>,
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
    let owners =
        Composition::DirectSend.owners(shared).into_iter().map(|place| shared.ranks[place]).collect();
    let bounds = stages.compose.time(|| {
        let mut bounds = DepthBounds::new(&context.grid, shared.tiles_of(rank));
        let tiles: Vec<(u32, &mut [f32])> = bounds.tiles_mut().collect();
        tiles.into_par_iter().for_each(|(tile, of)| {
            sorted.raise_bounds(context, tile, of);
            of.iter_mut().for_each(|depth| *depth = rounded(*depth));
        });
        bounds
    });
    let own = Own { bounds, owners };
    for (owner, tiles) in own.by_owner(shared, rank) {
        if owner != rank {
            let mut message = comm.buffer(owner);
            let bounds = tiles.iter().filter_map(|&tile| own.bounds.of(tile)).flatten();
            bounds.for_each(|&depth| put(depth, &mut message));
            comm.send(owner, message)?;
        }
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
        self,
        comm: &mut impl Communicator,
        context: &FrameContext,
        shared: &Shared,
        stages: &mut RankStages,
    ) -> Result<Others, ParallelError> {
        let (rank, grid) = (comm.rank(), &context.grid);
        // Of the tiles that this rank owns, the bounds of all ranks that have some of them; this rank has all.
        let mut known = Vec::new();
        for &from in shared.ranks {
            let tiles = self.owned_by(rank, shared, from);
            if tiles.is_empty() {
                continue;
            }
            let mut bounds = DepthBounds::new(grid, tiles);
            if from == rank {
                bounds
                    .tiles_mut()
                    .for_each(|(tile, to)| to.copy_from_slice(self.bounds.of(tile).unwrap_or_default()));
            } else {
                let message = stages.wait.time(|| comm.receive(from))?;
                let done = read(&mut message.chunks_exact(BYTES), &mut bounds);
                done.ok_or_else(|| malformed(from))?;
                comm.give_back(from, message);
            }
            known.push((from, bounds));
        }
        let nearest = stages.compose.time(|| Nearest::of(&known));
        let mut others = Others {
            bounds: DepthBounds::new(grid, self.bounds.tiles().to_vec()),
            fronts: vec![rank; self.bounds.tiles().len()],
        };
        for (to, bounds) in known {
            let mut message = if to == rank { Vec::new() } else { comm.buffer(to) };
            nearest.reply(&bounds, &mut message);
            match to == rank {
                true => others.read(bounds.tiles(), &message).ok_or_else(|| malformed(rank))?,
                false => comm.send(to, message)?,
            }
        }
        for (from, tiles) in self.by_owner(shared, rank).into_iter().filter(|(from, _)| *from != rank) {
            let message = stages.wait.time(|| comm.receive(from))?;
            others.read(&tiles, &message).ok_or_else(|| malformed(from))?;
            comm.give_back(from, message);
        }
        Ok(others)
    }

    /// The shared tiles that `rank` has, by their owners.
    fn by_owner(&self, shared: &Shared, rank: usize) -> BTreeMap<usize, Vec<u32>> {
        let mut by_owner = BTreeMap::<usize, Vec<u32>>::new();
        for (&tile, &owner) in shared.tiles.iter().zip(&self.owners) {
            if shared.touched.is_touched(rank, tile) {
                by_owner.entry(owner).or_default().push(tile);
            }
        }
        by_owner
    }

    /// The shared tiles that `owner` owns and `rank` has.
    fn owned_by(&self, owner: usize, shared: &Shared, rank: usize) -> Vec<u32> {
        self.by_owner(shared, rank).remove(&owner).unwrap_or_default()
    }
}

impl Others {
    /// Reads what the owner of some tiles replied: of each the rank in front, and the bounds of its blocks.
    fn read(&mut self, tiles: &[u32], message: &[u8]) -> Option<()> {
        let mut rest = message;
        for tile in tiles {
            let at = self.bounds.tiles().binary_search(tile).ok()?;
            let bounds = self.bounds.of_mut(*tile)?;
            let (head, body) = rest.split_at_checked(size_of::<u32>())?;
            let (halves, behind) = body.split_at_checked(bounds.len() * BYTES)?;
            self.fronts[at] = pod_read_unaligned::<u32>(head) as usize;
            read_tile(&mut halves.chunks_exact(BYTES), bounds)?;
            rest = behind;
        }
        rest.is_empty().then_some(())
    }
}

/// The nearest ranks in the blocks of tiles.
struct Nearest {
    /// How near any rank may draw.
    first: DepthBounds,
    /// How near any but one of those may that are as near.
    second: DepthBounds,
    /// The rank that is nearest in most blocks of each tile, and in how many.
    fronts: Vec<(usize, usize)>,
}

impl Nearest {
    /// Of some ranks; the first one that has all of the tiles says which they are.
    fn of(ranks: &[(usize, DepthBounds)]) -> Self {
        let Some((_, all)) = ranks.iter().max_by_key(|(_, bounds)| bounds.tiles().len()) else {
            return Self {
                first: DepthBounds::default(),
                second: DepthBounds::default(),
                fronts: Vec::new(),
            };
        };
        let (mut first, mut second) = (all.clone(), all.clone());
        first.tiles_mut().chain(second.tiles_mut()).for_each(|(_, of)| of.fill(0.0));
        for (_, bounds) in ranks {
            for ((tile, first), (_, second)) in first.tiles_mut().zip(second.tiles_mut()) {
                for ((first, second), &depth) in
                    first.iter_mut().zip(second).zip(bounds.of(tile).into_iter().flatten())
                {
                    *second = second.max(depth.min(*first));
                    *first = first.max(depth);
                }
            }
        }
        let mut fronts = vec![(0, 0); first.tiles().len()];
        for (rank, bounds) in ranks {
            for (tile, front) in first.tiles().iter().zip(&mut fronts) {
                let (Some(first), Some(own)) = (first.of(*tile), bounds.of(*tile)) else { continue };
                let blocks = own.iter().zip(first).filter(|(own, first)| own == first && **own > 0.0).count();
                if blocks > front.1 || front.1 == 0 {
                    *front = (*rank, blocks);
                }
            }
        }
        Self { first, second, fronts }
    }

    /// Appends the reply to a rank with these bounds: of each tile the rank in front, and how near others may draw.
    fn reply(&self, bounds: &DepthBounds, message: &mut Vec<u8>) {
        for &tile in bounds.tiles() {
            let (Ok(at), Some(own)) = (self.first.tiles().binary_search(&tile), bounds.of(tile)) else {
                continue;
            };
            message.extend((self.fronts[at].0 as u32).to_ne_bytes());
            let nearest =
                self.first.of(tile).unwrap_or_default().iter().zip(self.second.of(tile).unwrap_or_default());
            for (own, (first, second)) in own.iter().zip(nearest) {
                put(if own == first { *second } else { *first }, message);
            }
        }
    }
}

fn malformed(from: usize) -> ParallelError {
    ParallelError::Packet { from, source: PacketError::Short { at: 0 } }
}

/// The next number, upwards, whose lower half is 0. Precondition: it is not negative.
fn rounded(depth: f32) -> f32 {
    f32::from_bits(depth.to_bits().saturating_add(0xffff) & 0xffff_0000)
}

/// Appends a bound, which is rounded.
fn put(depth: f32, message: &mut Vec<u8>) {
    message.extend(((depth.to_bits() >> 16) as u16).to_ne_bytes());
}

/// Reads the bounds of all tiles; `None` if there are fewer.
fn read(halves: &mut ChunksExact<u8>, bounds: &mut DepthBounds) -> Option<()> {
    bounds.tiles_mut().try_for_each(|(_, of)| read_tile(halves, of))
}

fn read_tile(halves: &mut ChunksExact<u8>, bounds: &mut [f32]) -> Option<()> {
    for to in bounds {
        *to = f32::from_bits(u32::from(pod_read_unaligned::<u16>(halves.next()?)) << 16);
    }
    Some(())
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use tercio_raster::TileSet;
    use tercio_raster::screen::TileGrid;

    use super::*;

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
            let nearest = Nearest::of(&known);
            for (rank, bounds) in &known {
                let mut message = Vec::new();
                nearest.reply(bounds, &mut message);
                let fresh = || Others { bounds: DepthBounds::new(&grid, vec![0, 1, 2]), fronts: vec![0; 3] };
                let mut found = fresh();
                found.read(bounds.tiles(), &message).expect("a reply");
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
                // Nothing is missing, and nothing more.
                prop_assert!(bounds.tiles().is_empty() || fresh().read(bounds.tiles(), &message[1..]).is_none());
                message.push(0);
                prop_assert!(fresh().read(bounds.tiles(), &message).is_none());
            }
        }
    }
}
