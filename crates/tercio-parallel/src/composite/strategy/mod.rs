//! In which order ranks exchange what they have drawn of the same tiles, one strategy per file.
//!
//! A strategy is a schedule: it says which tiles a rank sends to which other one in each round. What is sent, and how it is
//! merged, does not depend on it ([`super::exchange`]).

mod binary_swap;
mod direct_send;
mod interlaced;
mod radix_k;
mod ring;
mod tree;
mod two_three_swap;

use std::fmt;

use serde::{Serialize, Serializer};

use super::Touched;
pub use radix_k::Radices;

/// How ranks composite what they have drawn of the same tiles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Composition {
    /// Every rank sends its part of a tile straight to the tile's owner, one of the ranks that drew something in it.
    #[default]
    DirectSend,
    /// In each round two ranks exchange halves of what they have (Ma et al. 1994). What the ranks beyond a power of two have is
    /// sent to others first.
    BinarySwap,
    /// In each round groups of ranks exchange parts of what they have, as in direct send (Peterka et al. 2009).
    RadixK(Radices),
    /// In each round groups of ranks are joined by twos and threes, and their members exchange parts: log2 of the ranks rounds,
    /// rounded down, for any number of ranks (Yu, Wang and Ma 2008).
    TwoThreeSwap,
    /// In each round half of the ranks send all that they have to the others, until one has everything: a binomial tree.
    Tree,
    /// One rank after another adds what it has to a picture that passes through all of them (document 000, chapter 6).
    Ring,
}

impl Composition {
    /// All of them, one radix.
    pub const ALL: [Self; 6] =
        [Self::DirectSend, Self::BinarySwap, Self::radix_k(4), Self::TwoThreeSwap, Self::Tree, Self::Ring];

    /// Radix-k with groups of up to this many ranks in every round.
    ///
    /// # Panics
    /// If it is less than 2 or more than 65,535.
    pub const fn radix_k(radix: u32) -> Self {
        Self::RadixK(Radices::same(radix))
    }

    fn strategy(self) -> Box<dyn Strategy> {
        match self {
            Self::DirectSend => Box::new(direct_send::DirectSend),
            Self::BinarySwap => Box::new(binary_swap::BinarySwap),
            Self::RadixK(radices) => Box::new(radix_k::RadixK { radices }),
            Self::TwoThreeSwap => Box::new(two_three_swap::TwoThreeSwap),
            Self::Tree => Box::new(tree::Tree),
            Self::Ring => Box::new(ring::Ring),
        }
    }

    /// What rank number `place` of the tiles' ranks does.
    pub fn rounds(self, shared: &Shared, place: usize) -> Vec<Round> {
        if shared.ranks.is_empty() { Vec::new() } else { self.strategy().rounds(shared, place) }
    }

    /// The place, among the ranks of the tiles, of the rank that has each tile in the end.
    pub fn owners(self, shared: &Shared) -> Vec<usize> {
        if shared.ranks.is_empty() { Vec::new() } else { self.strategy().owners(shared) }
    }
}

impl fmt::Display for Composition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::DirectSend => f.write_str("direct-send"),
            Self::BinarySwap => f.write_str("binary-swap"),
            Self::RadixK(radices) => write!(f, "radix-{radices}"),
            Self::TwoThreeSwap => f.write_str("2-3-swap"),
            Self::Tree => f.write_str("tree"),
            Self::Ring => f.write_str("ring"),
        }
    }
}

impl Serialize for Composition {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// Tiles that several ranks have drawn, and these ranks.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Shared<'a> {
    /// The tiles, in order.
    pub tiles: &'a [u32],
    /// The ranks that have any of them, in order. Strategies count them by their places in this list.
    pub ranks: &'a [usize],
    /// Which of them each rank has.
    pub touched: &'a Touched,
}

impl Shared<'_> {
    /// Those of the tiles that a rank has.
    pub fn tiles_of(&self, rank: usize) -> Vec<u32> {
        self.tiles.iter().copied().filter(|&tile| self.touched.is_touched(rank, tile)).collect()
    }
}

/// What one rank does in a round: it sends, then receives. Ranks are given by their places in [`Shared::ranks`].
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Round {
    /// Receivers, in the order in which it sends, and the tiles that are sent: all that the rank has of them.
    pub sends: Vec<(usize, Vec<u32>)>,
    /// Senders, in the order in which it receives.
    pub receives: Vec<usize>,
}

/// A way to bring all parts of every tile to one rank.
trait Strategy {
    /// What the rank at a place does.
    fn rounds(&self, shared: &Shared, place: usize) -> Vec<Round>;

    /// The place of the rank that has each tile in the end, in the order of the tiles.
    fn owners(&self, shared: &Shared) -> Vec<usize>;
}

#[cfg(test)]
mod tests {
    use std::collections::{HashMap, HashSet};

    use proptest::prelude::*;

    use super::*;

    /// Of each tile, the ranks whose parts it is merged from.
    type Parts = HashMap<u32, Vec<usize>>;

    /// Plays all rounds: afterwards each owner must have every rank's part of its tiles, exactly once, and nobody anything else.
    /// Returns the messages, as numbers of sender, receiver, and tiles.
    fn play(composition: Composition, shared: &Shared) -> Vec<(usize, usize, Vec<u32>)> {
        let count = shared.ranks.len();
        // What each rank has.
        let mut have: Vec<Parts> = vec![Parts::new(); count];
        for (have, &rank) in have.iter_mut().zip(shared.ranks) {
            have.extend(shared.tiles_of(rank).into_iter().map(|tile| (tile, vec![rank])));
        }
        let schedules: Vec<_> = (0..count).map(|place| composition.rounds(shared, place)).collect();
        let (mut done, mut messages) = (vec![0; count], Vec::new());
        let mut transit: HashMap<(usize, usize), Vec<Parts>> = HashMap::new();
        let mut sent = HashSet::new();
        loop {
            let mut moved = false;
            for place in 0..count {
                let Some(round) = schedules[place].get(done[place]) else { continue };
                if sent.insert((place, done[place])) {
                    moved = true;
                    for (to, tiles) in &round.sends {
                        let parts = tiles.iter().filter_map(|tile| have[place].remove_entry(tile)).collect();
                        transit.entry((place, *to)).or_default().push(parts);
                        messages.push((place, *to, tiles.clone()));
                    }
                }
                let arrived =
                    |from: &usize| transit.get(&(*from, place)).is_some_and(|queue| !queue.is_empty());
                if round.receives.iter().all(arrived) {
                    moved = true;
                    for from in &round.receives {
                        let queue = transit.get_mut(&(*from, place)).expect("arrived");
                        for (tile, parts) in queue.remove(0) {
                            have[place].entry(tile).or_default().extend(parts);
                        }
                    }
                    done[place] += 1;
                }
            }
            if !moved {
                break;
            }
        }
        assert!(
            done.iter().zip(&schedules).all(|(done, rounds)| *done == rounds.len()),
            "{composition}: a deadlock"
        );
        assert!(transit.values().all(Vec::is_empty), "{composition}: a message that nobody receives");
        for (&tile, owner) in shared.tiles.iter().zip(composition.owners(shared)) {
            let mut parts = have[owner].remove(&tile).expect("the owner has the tile");
            parts.sort_unstable();
            let expected: Vec<usize> = shared.touched.ranks_of(tile).collect();
            assert_eq!(parts, expected, "{composition}, tile {tile}");
        }
        assert!(have.iter().all(HashMap::is_empty), "{composition}: parts without an owner");
        messages
    }

    /// Touched tiles as bits, at most 64 of them.
    fn touched(of_rank: &[u64]) -> Touched {
        Touched::new(64, of_rank.iter().map(|&bits| move |tile: u32| bits >> tile & 1 == 1))
    }

    proptest! {
        #[test]
        fn all_parts_of_a_tile_reach_one_rank(
            of_rank in prop::collection::vec(prop_oneof![Just(0), any::<u64>(), Just(u64::MAX)], 0..40),
            radices in prop::collection::vec(2u32..9, 1..4),
        ) {
            let touched = touched(&of_rank);
            let tiles = touched.shared();
            let ranks = touched.ranks_of_any(&tiles);
            let shared = Shared { tiles: &tiles, ranks: &ranks, touched: &touched };
            let chosen = Composition::RadixK(Radices::new(&radices).unwrap());
            for composition in Composition::ALL.into_iter().chain([chosen]) {
                play(composition, &shared);
            }
        }
    }

    #[test]
    fn all_parts_of_a_tile_reach_one_of_many_ranks() {
        for count in [257u64, 1023] {
            // Each has a quarter of the tiles, some nothing.
            let bits = |rank: u64| {
                rank.wrapping_mul(0x9e37_79b9_7f4a_7c15) & rank.wrapping_mul(0xd1b5_4a32_d192_ed03)
            };
            let touched = touched(&(0..count).map(bits).collect::<Vec<_>>());
            let tiles = touched.shared();
            let ranks = touched.ranks_of_any(&tiles);
            assert!(ranks.len() as u64 + 1 >= count, "{} of {count}", ranks.len());
            let shared = Shared { tiles: &tiles, ranks: &ranks, touched: &touched };
            for composition in Composition::ALL {
                play(composition, &shared);
            }
        }
    }

    /// Messages and tiles sent by all of so many ranks that each touch everything.
    fn sent(composition: Composition, count: usize) -> (usize, usize) {
        let touched = touched(&vec![u64::MAX; count]);
        let (tiles, ranks): (Vec<u32>, Vec<usize>) = (touched.shared(), (0..count).collect());
        let messages = play(composition, &Shared { tiles: &tiles, ranks: &ranks, touched: &touched });
        (messages.len(), messages.iter().map(|(_, _, tiles)| tiles.len()).sum::<usize>())
    }

    /// Against the formulas of the literature: whatever the strategy, n pictures become one by sending n - 1 of them.
    #[test]
    fn messages_and_bytes_are_those_of_the_formulas() {
        for count in 2usize..=64 {
            let pictures = 64 * (count - 1);
            // Every rank sends (1 - 1/n) of the picture, in n - 1 messages.
            let direct = (count * (count - 1), pictures);
            assert_eq!(sent(Composition::DirectSend, count), direct, "{count}");
            assert_eq!(sent(Composition::radix_k(64), count), direct, "{count}");
            // In log2 n messages; of 2^k + e ranks, e send all that they have before.
            let k = count.ilog2() as usize;
            let swap = ((1 << k) * k + count - (1 << k), pictures);
            assert_eq!(sent(Composition::BinarySwap, count), swap, "{count}");
            // The whole picture, n - 1 times.
            assert_eq!(sent(Composition::Tree, count), (count - 1, pictures), "{count}");
            assert_eq!(sent(Composition::Ring, count), (count - 1, pictures), "{count}");
            if count.is_power_of_two() {
                assert_eq!(sent(Composition::radix_k(2), count), swap, "{count}");
                assert_eq!(sent(Composition::TwoThreeSwap, count), swap, "{count}");
            }
        }
    }

    /// Radix-k: n ranks as groups of k1, k2, ... send the sum of k - 1 messages each.
    #[test]
    fn messages_and_bytes_of_radix_k_are_those_of_the_formula() {
        let cases: [(u32, usize, &[usize]); 21] = [
            (3, 3, &[3]),
            (3, 6, &[3, 2]),
            (3, 8, &[2, 2, 2]),
            (3, 9, &[3, 3]),
            (3, 15, &[3, 5]),
            (3, 27, &[3, 3, 3]),
            (3, 54, &[3, 3, 3, 2]),
            (4, 7, &[7]),
            (4, 8, &[4, 2]),
            (4, 12, &[4, 3]),
            (4, 16, &[4, 4]),
            (4, 24, &[4, 3, 2]),
            (4, 44, &[4, 11]),
            (4, 64, &[4, 4, 4]),
            (8, 8, &[8]),
            (8, 12, &[6, 2]),
            (8, 31, &[31]),
            (8, 32, &[8, 4]),
            (8, 35, &[7, 5]),
            (8, 48, &[8, 6]),
            (8, 64, &[8, 8]),
        ];
        for (radix, count, groups) in cases {
            let of_rank: usize = groups.iter().map(|k| k - 1).sum();
            let expected = (count * of_rank, 64 * (count - 1));
            assert_eq!(sent(Composition::radix_k(radix), count), expected, "radix {radix}, {count} ranks");
        }
    }

    /// Whether a tile belongs to it.
    type Shape = Box<dyn Fn(u32) -> bool>;

    /// Ranks merge about the same where a part of the picture alone is shared by all of them: everywhere else there are four each.
    #[test]
    fn ranks_merge_about_the_same() {
        for columns in [16u32, 24, 32] {
            let at = move |tile: u32| {
                [tile % columns, tile / columns].map(|k| (f64::from(k) + 0.5) / f64::from(columns) - 0.5)
            };
            let shapes: [(&str, Shape); 4] = [
                ("an upright bar", Box::new(move |tile| at(tile)[0].abs() < 0.15)),
                ("a bar across", Box::new(move |tile| at(tile)[1].abs() < 0.15)),
                ("a disc", Box::new(move |tile| at(tile)[0].hypot(at(tile)[1]) < 0.3)),
                ("a quarter", Box::new(move |tile| at(tile).iter().all(|&k| k > 0.0))),
            ];
            for (what, is_inside) in shapes {
                for count in [8usize, 16, 32] {
                    let is_touched =
                        |rank: usize| move |tile: u32| rank % (count / 4) == tile as usize % (count / 4);
                    let inside = &is_inside;
                    let all = (0..count).map(|rank| move |tile: u32| inside(tile) || is_touched(rank)(tile));
                    let touched = Touched::new((columns * columns) as usize, all);
                    let (tiles, ranks): (Vec<u32>, Vec<usize>) = (touched.shared(), (0..count).collect());
                    let shared = Shared { tiles: &tiles, ranks: &ranks, touched: &touched };
                    for composition in [
                        Composition::DirectSend,
                        Composition::BinarySwap,
                        Composition::radix_k(4),
                        Composition::TwoThreeSwap,
                    ] {
                        let mut merged = vec![0; count];
                        for (&tile, owner) in tiles.iter().zip(composition.owners(&shared)) {
                            merged[owner] += touched.ranks_of(tile).count();
                        }
                        let most = (merged.iter().copied().max().unwrap_or(0) * count) as f64;
                        let uneven = most / merged.iter().sum::<usize>() as f64;
                        // In order, not interlaced, it would be up to 2.9.
                        let limit = if composition == Composition::DirectSend { 1.1 } else { 1.7 };
                        let of = format!("{composition}, {count} ranks, {columns} columns, {what}");
                        assert!(uneven < limit, "{of}: {uneven}");
                    }
                }
            }
        }
    }

    #[test]
    fn rounds_are_as_many_as_the_formulas_say() {
        let touched = touched(&[u64::MAX; 24]);
        let tiles = touched.shared();
        let rounds = |composition: Composition, count: usize| {
            let ranks: Vec<usize> = (0..count).collect();
            let shared = Shared { tiles: &tiles, ranks: &ranks, touched: &touched };
            (0..count).map(|place| composition.rounds(&shared, place).len()).max().unwrap()
        };
        assert_eq!([8, 16].map(|n| rounds(Composition::BinarySwap, n)), [3, 4]);
        // One more for the ranks beyond a power of two.
        assert_eq!([9, 15, 17].map(|n| rounds(Composition::BinarySwap, n)), [4, 4, 5]);
        // 4 * 4, 4 * 3 * 2, 7, 4 * 2.
        assert_eq!([16, 24, 7, 8].map(|n| rounds(Composition::radix_k(4), n)), [2, 3, 1, 2]);
        assert_eq!([7, 8, 9].map(|n| rounds(Composition::Tree, n)), [3, 3, 4]);
        assert_eq!([3, 7, 8, 15, 16].map(|n| rounds(Composition::TwoThreeSwap, n)), [1, 2, 3, 3, 4]);
    }
}
