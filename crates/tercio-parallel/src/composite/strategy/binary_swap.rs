//! Binary swap, for any number of ranks.

use super::radix_k::{owners_of_groups, rounds_of_groups};
use super::{Round, Shared, Strategy};

/// Rounds of pairs, which exchange halves. Of `2^k + e` ranks, the e at odd places below 2 e send all that they have to the
/// rank before them first, and own nothing in the end.
pub struct BinarySwap;

/// The number of ranks that swap, a power of two, and the number of those that do not.
fn swapping(count: usize) -> (usize, usize) {
    let largest = 1 << count.ilog2();
    (largest, count - largest)
}

/// The place of rank `swapper` of those that swap.
fn place_of(swapper: usize, extra: usize) -> usize {
    if swapper < extra { 2 * swapper } else { swapper + extra }
}

impl Strategy for BinarySwap {
    fn rounds(&self, shared: &Shared, place: usize) -> Vec<Round> {
        let (swappers, extra) = swapping(shared.ranks.len());
        if place < 2 * extra && place % 2 == 1 {
            let all = vec![(place - 1, shared.tiles.to_vec())];
            return vec![Round { sends: all, receives: Vec::new() }];
        }
        let own = if place < 2 * extra { place / 2 } else { place - extra };
        let mut rounds = Vec::new();
        if place < 2 * extra {
            rounds.push(Round { sends: Vec::new(), receives: vec![place + 1] });
        }
        let pairs = vec![2; swappers.ilog2() as usize];
        rounds.extend(rounds_of_groups(&pairs, shared.tiles, own, |swapper| place_of(swapper, extra)));
        rounds
    }

    fn owners(&self, shared: &Shared) -> Vec<usize> {
        let (swappers, extra) = swapping(shared.ranks.len());
        let pairs = vec![2; swappers.ilog2() as usize];
        owners_of_groups(&pairs, shared.tiles.len(), |swapper| place_of(swapper, extra))
    }
}
