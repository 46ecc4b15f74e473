//! In which rounds ranks draw what is not opaque and composited.
//!
//! Fragments are kept until their owner has merged them, and there may be any number. So a frame is drawn in rounds, each a range
//! of tiles that have about as many, of all ranks together, as memory may hold; at least one tile. How many there are is
//! estimated, and the estimate is corrected by what earlier rounds had.

use std::ops::Range;

use bytemuck::{cast_slice, pod_read_unaligned};

use crate::ParallelError;
use crate::comm::Communicator;
use crate::composite::packet::PacketError;
use crate::report::Stage;

/// The rounds of a frame, as one rank goes through them.
pub struct Rounds {
    /// Estimated bytes of this rank's fragments in each of the tiles.
    estimates: Vec<u64>,
    /// Tiles of earlier rounds.
    done: usize,
    /// Most bytes of a round.
    most: u64,
    /// Estimated bytes of earlier rounds, and what they were.
    earlier: (u64, u64),
    /// There is one round, on which ranks need not agree.
    is_whole: bool,
}

impl Rounds {
    /// Rounds of at most about `most` bytes of all ranks together; `estimates` are of this rank's fragments in each tile.
    pub fn new(estimates: Vec<u64>, most: u64) -> Self {
        Self { estimates, done: 0, most, earlier: (0, 0), is_whole: false }
    }

    /// One round of this many tiles.
    pub fn whole(tiles: usize) -> Self {
        Self { is_whole: true, ..Self::new(vec![0; tiles], 0) }
    }

    /// Agrees on the next round: a range of tiles, or `None` after the last one. `takes_part(rank)` returns whether a rank
    /// takes part in the frame, which rank 0 does; the others do not call this.
    ///
    /// # Errors
    /// [`ParallelError::Comm`], [`ParallelError::Packet`].
    pub fn next(
        &mut self,
        comm: &mut impl Communicator,
        takes_part: impl Fn(usize) -> bool,
        wait: &mut Stage,
    ) -> Result<Option<Range<usize>>, ParallelError> {
        let start = self.done;
        let rest = &self.estimates[start..];
        if rest.is_empty() {
            return Ok(None);
        }
        if self.is_whole {
            self.done = self.estimates.len();
            return Ok(Some(0..self.done));
        }
        let (estimated, found) = self.earlier;
        // Nothing is known of the first round: it is smaller.
        let most = if start == 0 { self.most / 4 } else { self.most };
        let factor = if estimated > 0 { (found as f64 / estimated as f64).max(1.0) } else { 1.0 };
        let own: Vec<u64> = rest.iter().map(|&bytes| (bytes as f64 * factor) as u64).collect();
        let others = (1..comm.size()).filter(|&rank| takes_part(rank));
        let malformed = |from| ParallelError::Packet { from, source: PacketError::Short { at: 0 } };
        let length = if comm.rank() == 0 {
            let mut sum = own;
            for from in others.clone() {
                let message = wait.time(|| comm.receive(from))?;
                let theirs = numbers(&message).filter(|theirs| theirs.len() == sum.len());
                let theirs = theirs.ok_or_else(|| malformed(from))?;
                sum.iter_mut().zip(theirs).for_each(|(sum, theirs)| *sum = sum.saturating_add(theirs));
            }
            let length = length_of_round(&sum, most);
            for to in others {
                comm.send(to, (length as u64).to_ne_bytes().to_vec())?;
            }
            length
        } else {
            comm.send(0, cast_slice(&own).to_vec())?;
            let message = wait.time(|| comm.receive(0))?;
            let length = numbers(&message).and_then(|numbers| numbers.first().copied()).unwrap_or(0) as usize;
            if !(1..=rest.len()).contains(&length) {
                return Err(malformed(0));
            }
            length
        };
        self.done += length;
        Ok(Some(start..self.done))
    }

    /// Notes how many bytes of fragments this rank had in a round.
    pub fn found(&mut self, round: &Range<usize>, bytes: u64) {
        let estimates = &self.estimates[round.clone()];
        let estimated = estimates.iter().fold(0, |sum: u64, &bytes| sum.saturating_add(bytes));
        self.earlier = (self.earlier.0.saturating_add(estimated), self.earlier.1.saturating_add(bytes));
    }
}

fn numbers(message: &[u8]) -> Option<Vec<u64>> {
    let numbers = message.chunks_exact(size_of::<u64>());
    numbers.remainder().is_empty().then(|| numbers.map(pod_read_unaligned).collect())
}

/// The number of tiles of the next round.
fn length_of_round(bytes: &[u64], most: u64) -> usize {
    let mut sum = 0u64;
    let fits = |&bytes: &&u64| {
        let is_first = sum == 0;
        sum = sum.saturating_add(*bytes);
        is_first || sum <= most
    };
    bytes.iter().take_while(fits).count()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::comm::threads;

    proptest! {
        #[test]
        fn a_round_holds_no_more_than_it_may_and_as_much_as_it_can(
            bytes in prop::collection::vec(0u64..50, 1..40), most in 0u64..200,
        ) {
            let length = length_of_round(&bytes, most);
            prop_assert!((1..=bytes.len()).contains(&length));
            let round = &bytes[..length];
            let used = round.iter().filter(|&&bytes| bytes > 0).count();
            prop_assert!(used <= 1 || round.iter().sum::<u64>() <= most);
            if let Some(next) = bytes.get(length) {
                prop_assert!(round.iter().sum::<u64>() + next > most);
            }
        }
    }

    /// The rounds of each of four ranks, of which one does not take part; every tile has `times` as many bytes as estimated.
    fn rounds(most: u64, times: u64) -> Vec<Option<Vec<Range<usize>>>> {
        let found = threads::run(4, |comm| {
            if comm.rank() == 2 {
                return Ok(None);
            }
            let each = comm.rank() as u64 + 1;
            let (mut own, mut all) = (Rounds::new(vec![each; 12], most), Vec::new());
            while let Some(round) = own.next(comm, |rank| rank != 2, &mut Stage::default())? {
                own.found(&round, times * each * round.len() as u64);
                all.push(round);
            }
            Ok(Some(all))
        });
        found.expect("rounds")
    }

    #[test]
    fn all_ranks_that_take_part_get_the_same_rounds() {
        // One, two and four bytes in each tile; the first round may have a quarter of 28 bytes, the others have them.
        let expected = vec![0..1, 1..5, 5..9, 9..12];
        for (rank, rounds) in rounds(28, 1).into_iter().enumerate() {
            assert_eq!(rounds, (rank != 2).then(|| expected.clone()), "rank {rank}");
        }
    }

    #[test]
    fn rounds_get_smaller_if_there_are_more_fragments_than_estimated() {
        // Two tiles fit, since every tile has twice the seven bytes.
        let expected = vec![0..1, 1..3, 3..5, 5..7, 7..9, 9..11, 11..12];
        assert_eq!(rounds(28, 2)[0], Some(expected));
    }
}
