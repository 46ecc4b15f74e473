//! In which rounds ranks draw what is not opaque.
//!
//! Layers are kept until their owner blends them, and there may be any number. So a frame is drawn in rounds, each a range of
//! tiles that have about as many layers, of all ranks together, as memory may hold. A round has at least one tile.

use std::ops::Range;

use bytemuck::{cast_slice, pod_read_unaligned};

use crate::ParallelError;
use crate::comm::Communicator;
use crate::composite::packet::PacketError;
use crate::report::Stage;

/// Agrees on the rounds of a frame. `layers` are estimates of the bytes of this rank's layers in each tile; a round has at most
/// `most` bytes of all ranks together, or one tile. `takes_part(rank)` returns whether a rank takes part in the frame, which
/// rank 0 does; the others do not call this.
///
/// # Errors
/// [`ParallelError::Comm`], [`ParallelError::Packet`].
pub fn agree(
    comm: &mut impl Communicator,
    layers: Vec<u64>,
    most: u64,
    takes_part: impl Fn(usize) -> bool,
    wait: &mut Stage,
) -> Result<Vec<Range<u64>>, ParallelError> {
    let others = (1..comm.size()).filter(|&rank| takes_part(rank));
    let ends: Vec<u64> = if comm.rank() == 0 {
        let mut sum = layers;
        for from in others.clone() {
            let message = wait.time(|| comm.receive(from))?;
            let theirs = numbers(&message).filter(|theirs| theirs.len() == sum.len());
            let theirs =
                theirs.ok_or(ParallelError::Packet { from, source: PacketError::Short { at: 0 } })?;
            sum.iter_mut().zip(theirs).for_each(|(sum, theirs)| *sum = sum.saturating_add(theirs));
        }
        let ends = ends_of(&sum, most);
        for to in others {
            comm.send(to, cast_slice(&ends).to_vec())?;
        }
        ends
    } else {
        comm.send(0, cast_slice(&layers).to_vec())?;
        let message = wait.time(|| comm.receive(0))?;
        let is_valid = |ends: &Vec<u64>| {
            ends.is_sorted_by(|a, b| a < b) && ends.last().copied().unwrap_or(0) == layers.len() as u64
        };
        let ends = numbers(&message).filter(is_valid);
        ends.ok_or(ParallelError::Packet { from: 0, source: PacketError::Short { at: 0 } })?
    };
    let starts = std::iter::once(0).chain(ends.iter().copied());
    Ok(starts.zip(&ends).map(|(start, &end)| start..end).collect())
}

fn numbers(message: &[u8]) -> Option<Vec<u64>> {
    let numbers = message.chunks_exact(size_of::<u64>());
    numbers.remainder().is_empty().then(|| numbers.map(pod_read_unaligned).collect())
}

/// Where rounds end, in tiles.
fn ends_of(layers: &[u64], most: u64) -> Vec<u64> {
    let (mut ends, mut sum) = (Vec::new(), 0u64);
    for (tile, &bytes) in layers.iter().enumerate() {
        if sum > 0 && sum.saturating_add(bytes) > most {
            ends.push(tile as u64);
            sum = 0;
        }
        sum = sum.saturating_add(bytes);
    }
    ends.push(layers.len() as u64);
    ends
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::comm::threads;

    proptest! {
        #[test]
        fn rounds_are_all_tiles_and_hold_no_more_than_they_may(
            layers in prop::collection::vec(0u64..50, 1..40), most in 0u64..200,
        ) {
            let ends = ends_of(&layers, most);
            let mut start = 0;
            for &end in &ends {
                prop_assert!(end as usize > start);
                let round = &layers[start..end as usize];
                let used = round.iter().filter(|&&bytes| bytes > 0).count();
                prop_assert!(used <= 1 || round.iter().sum::<u64>() <= most);
                start = end as usize;
            }
            prop_assert_eq!(start, layers.len());
            // No more rounds than that needs: two neighbours together hold more.
            let sum_to = |end: usize| layers[..end].iter().sum::<u64>();
            let starts: Vec<usize> = std::iter::once(0).chain(ends.iter().map(|&end| end as usize)).collect();
            for three in starts.windows(3) {
                prop_assert!(sum_to(three[2]) - sum_to(three[0]) > most);
            }
        }
    }

    #[test]
    fn all_ranks_that_take_part_get_the_same_rounds() {
        let found = threads::run(4, |comm| {
            if comm.rank() == 2 {
                return Ok(None);
            }
            let layers = vec![comm.rank() as u64 + 1; 6];
            agree(comm, layers, 14, |rank| rank != 2, &mut Stage::default()).map(Some)
        });
        // One, two and four bytes in each tile: two tiles have at most fourteen.
        let expected = vec![0..2, 2..4, 4..6];
        for (rank, rounds) in found.unwrap().into_iter().enumerate() {
            assert_eq!(rounds, (rank != 2).then(|| expected.clone()), "rank {rank}");
        }
    }
}
