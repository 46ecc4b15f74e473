//! Ranks and threads that are compared.

use std::collections::BTreeSet;

use serde::Serialize;

use crate::machines::Machine;
use crate::predict::choose::candidates::MANY;

/// The largest number of ranks that the formulas predict: twice as many take twice as long, and this many already seconds.
pub const MOST_BY_FORMULAS: usize = 1 << 15;

/// Ranks, and threads of each.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub struct Split {
    /// Ranks.
    pub ranks: usize,
    /// Threads of each.
    pub threads: usize,
}

impl Split {
    /// Processors of all ranks together.
    pub fn processors(self) -> usize {
        self.ranks * self.threads
    }
}

/// Up to so many processors every number of them is compared.
pub const EVERY: usize = 16;

/// Numbers of processors: all of few, then powers of two and the middle between two of them; whole nodes in powers of two and as many
/// as fit; and all.
fn numbers(machine: &Machine, processors: usize) -> BTreeSet<usize> {
    let powers = || (0..usize::BITS - 2).map(|bit| 1usize << bit);
    let middles = powers().map(|power| power + power / 2);
    let node = usize::try_from(machine.most_threads()).unwrap_or(usize::MAX).max(1);
    let nodes = powers().chain([processors / node]).filter_map(|nodes| node.checked_mul(nodes));
    let found = (1..=EVERY).chain(powers()).chain(middles).chain(nodes).chain([processors]);
    found.filter(|number| (1..=processors).contains(number)).collect()
}

/// Numbers of threads of one process: of the same numbers those that may share a memory.
pub fn threads(machine: &Machine, processors: usize) -> Vec<usize> {
    let shares = |&number: &usize| number as u64 <= machine.most_threads();
    numbers(machine, processors).into_iter().filter(shares).collect()
}

/// All ways to divide each of the numbers of processors into two or more ranks of as many threads each, which share a memory; of
/// more than 64 ranks only those with threads that are a power of two, or divide a node. Few processors first.
pub fn of_ranks(machine: &Machine, processors: usize) -> Vec<Split> {
    let mut splits = Vec::new();
    for number in numbers(machine, processors) {
        let node = usize::try_from(machine.most_threads()).unwrap_or(usize::MAX);
        let divides = (1..=node.min(number / 2)).filter(|threads| number.is_multiple_of(*threads));
        let all = divides.map(|threads| Split { ranks: number / threads, threads });
        let is_usual = |threads: usize| threads.is_power_of_two() || node.is_multiple_of(threads);
        splits.extend(all.filter(|split| split.ranks <= MANY || is_usual(split.threads)));
    }
    splits
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machines::builtin;

    #[test]
    fn every_number_of_processors_is_divided_in_all_ways() {
        let machine = builtin("server-128").unwrap().unwrap();
        let split = |ranks, threads| Split { ranks, threads };
        assert_eq!(threads(&machine, 6), [1, 2, 3, 4, 5, 6]);
        let expected =
            [(2, 1), (3, 1), (4, 1), (2, 2), (5, 1), (6, 1), (3, 2), (2, 3)].map(|(r, t)| split(r, t));
        assert_eq!(of_ranks(&machine, 6), expected);
        // By plain counting: all ranks and threads that make up to 16 processors.
        let all: BTreeSet<Split> = of_ranks(&machine, 16).into_iter().collect();
        let pairs = (2..=16).flat_map(|ranks| (1..=16).map(move |threads| split(ranks, threads)));
        assert_eq!(all, pairs.filter(|s| s.processors() <= 16).collect());
        assert_eq!(threads(&machine, 128)[15..], [16, 24, 32, 48, 64, 96, 128]);
        assert!(of_ranks(&machine, 1).is_empty());
    }

    #[test]
    fn no_process_is_larger_than_a_node_and_whole_nodes_are_there() {
        let machine = builtin("cluster-64").unwrap().unwrap();
        let all = of_ranks(&machine, 1000);
        assert!(all.iter().all(|s| s.threads <= 128 && s.processors() <= 1000 && s.ranks > 1));
        for (ranks, threads) in [(2, 128), (4, 128), (7, 128), (896, 1), (1000, 1), (8, 125), (512, 1)] {
            assert!(all.contains(&Split { ranks, threads }), "{ranks} x {threads}");
        }
        let distinct: BTreeSet<_> = all.iter().collect();
        assert_eq!(distinct.len(), all.len());
        assert_eq!(threads(&machine, 1000).last(), Some(&128));
        // Of a million processors each has work in some split that can be predicted.
        let all = of_ranks(&machine, 1_000_000);
        let can = |s: &&Split| s.ranks <= MOST_BY_FORMULAS && s.processors() == 1_000_000;
        assert!(all.iter().any(|s| s.ranks > MOST_BY_FORMULAS) && all.iter().any(|s| can(&s)));
        // About eight for each of the 16 + 2 * 16 numbers, and whole nodes.
        assert!(all.len() < 400, "{}", all.len());
    }
}
