//! Which ranks may have drawn something in which tiles. All ranks know it before pixels are exchanged, so that nobody sends,
//! or waits for, what does not exist.

use bytemuck::{cast_slice, pod_read_unaligned};

use crate::ParallelError;
use crate::comm::Communicator;
use crate::report::Stage;

/// The tiles of every rank.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Touched {
    tiles: usize,
    /// One bit for each tile, for each rank.
    of_rank: Vec<Vec<u64>>,
}

impl Touched {
    /// The tiles of each rank, in a picture of this many tiles.
    pub fn new(tiles: usize, of_rank: impl IntoIterator<Item = impl Fn(u32) -> bool>) -> Self {
        Self { tiles, of_rank: of_rank.into_iter().map(|is_touched| bits(tiles, is_touched)).collect() }
    }

    /// Exchanges the tiles of all ranks; all of them have to call this with the same number of tiles.
    ///
    /// # Errors
    /// [`ParallelError::Comm`].
    pub fn gather(
        comm: &mut impl Communicator,
        tiles: usize,
        own: impl Fn(u32) -> bool,
        wait: &mut Stage,
    ) -> Result<Self, ParallelError> {
        let own = cast_slice(&bits(tiles, own)).to_vec();
        let all = wait.time(|| comm.all_gather(own))?;
        let words = |bytes: Vec<u8>| bytes.chunks_exact(size_of::<u64>()).map(pod_read_unaligned).collect();
        Ok(Self { tiles, of_rank: all.into_iter().map(words).collect() })
    }

    /// May a rank have drawn something in a tile?
    pub fn is_touched(&self, rank: usize, tile: u32) -> bool {
        self.of_rank[rank][tile as usize / 64] >> (tile % 64) & 1 == 1
    }

    /// The ranks that may have drawn something in a tile, in order.
    pub fn ranks_of(&self, tile: u32) -> impl Iterator<Item = usize> + '_ {
        (0..self.of_rank.len()).filter(move |&rank| self.is_touched(rank, tile))
    }

    /// The tiles in which more than one rank may have drawn something, in order: those that are composited.
    pub fn shared(&self) -> Vec<u32> {
        let (mut any, mut several) = (vec![0; self.tiles.div_ceil(64)], vec![0; self.tiles.div_ceil(64)]);
        for bits in &self.of_rank {
            for ((any, several), bits) in any.iter_mut().zip(&mut several).zip(bits) {
                *several |= *any & bits;
                *any |= bits;
            }
        }
        (0..self.tiles as u32).filter(|&tile| several[tile as usize / 64] >> (tile % 64) & 1 == 1).collect()
    }

    /// The ranks that may have drawn something in any of these tiles, in order.
    pub fn ranks_of_any(&self, tiles: &[u32]) -> Vec<usize> {
        let ranks = 0..self.of_rank.len();
        ranks.filter(|&rank| tiles.iter().any(|&tile| self.is_touched(rank, tile))).collect()
    }

    /// Does a rank have a tile that no other rank has?
    pub fn has_sole(&self, rank: usize, shared: &[u32]) -> bool {
        let own = self.of_rank[rank].iter().map(|bits| bits.count_ones() as usize).sum::<usize>();
        own > shared.iter().filter(|&&tile| self.is_touched(rank, tile)).count()
    }
}

fn bits(tiles: usize, is_touched: impl Fn(u32) -> bool) -> Vec<u64> {
    let mut bits = vec![0; tiles.div_ceil(64)];
    for tile in (0..tiles as u32).filter(|&tile| is_touched(tile)) {
        bits[tile as usize / 64] |= 1 << (tile % 64);
    }
    bits
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::comm::threads;

    #[test]
    fn all_ranks_know_what_each_of_them_touches() {
        const TILES: usize = 130;
        let touches = |rank: usize| move |tile: u32| (tile as usize).is_multiple_of(rank + 2);
        for ranks in 1..8 {
            let expected = Touched::new(TILES, (0..ranks).map(touches));
            let found = threads::run(ranks, |comm| {
                let own = touches(comm.rank());
                Touched::gather(comm, TILES, own, &mut Stage::default())
            });
            assert!(found.expect("gathered").iter().all(|found| *found == expected));
            let shared = expected.shared();
            for tile in 0..TILES as u32 {
                let of: Vec<usize> = (0..ranks).filter(|&rank| touches(rank)(tile)).collect();
                assert!(expected.ranks_of(tile).eq(of.iter().copied()));
                assert_eq!(shared.contains(&tile), of.len() > 1, "{tile}");
            }
            for rank in 0..ranks {
                let sole = (0..TILES as u32).any(|tile| expected.ranks_of(tile).eq([rank]));
                assert_eq!(expected.has_sole(rank, &shared), sole);
            }
        }
        let two = Touched::new(9, [0, 4].map(|own| move |tile| tile == own || tile == 7));
        assert_eq!(
            (two.shared(), two.ranks_of_any(&[0, 7]), two.ranks_of_any(&[4])),
            (vec![7], vec![0, 1], vec![1])
        );
    }
}
