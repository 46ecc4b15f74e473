//! 2-3 swap, for any number of ranks (Yu, Wang and Ma 2008).
//!
//! Ranks are the leaves of a tree whose inner nodes have two or three children, and whose leaves are all at the same depth,
//! log2 of their number, rounded down. The members of a node own equal parts of the tiles, with what all of them have
//! drawn there. When nodes are joined, the parts get smaller: each member sends what it no longer owns to its new owner,
//! of its own node or of another one.
//!
//! Members of the joined node get the new parts in the order of the middles of their old ones, so that a new part overlaps with
//! at most two old ones of each child: a rank receives at most 3 messages in a round that joins two nodes, and 5 in one that
//! joins three. With equal children, as with powers of two, that is binary swap, and each part is sent once.

use std::ops::Range;

use super::interlaced::{interlaced, owners_of_parts, part};
use super::{Round, Shared, Strategy};

/// Rounds in which nodes of a tree of ranks are joined by twos and threes.
pub struct TwoThreeSwap;

/// Levels below the root of the tree of so many ranks, at least 1.
fn height(count: usize) -> u32 {
    count.ilog2()
}

/// The sizes of the children of a node with `count` ranks, `height` levels above its leaves, at least 1: two, or three if two
/// would have more than the 3^(height - 1) ranks that there is room for.
fn children(count: usize, height: u32) -> Vec<usize> {
    let most = 3usize.saturating_pow(height - 1);
    let of = if count.div_ceil(2) <= most { 2 } else { 3 };
    (0..of).map(|child| part(&(0..count), child, of).len()).collect()
}

/// The members of a node, by their places among its ranks, in the order of their parts.
fn members(count: usize, height: u32) -> Vec<usize> {
    if height == 0 {
        return vec![0];
    }
    let mut first = 0;
    let mut all = Vec::with_capacity(count);
    for (child, size) in children(count, height).into_iter().enumerate() {
        // The middle of part `at` of a child: (2 at + 1) / (2 size).
        let of_child = members(size, height - 1).into_iter().enumerate();
        all.extend(of_child.map(|(at, member)| (2 * at + 1, size, child, first + member)));
        first += size;
    }
    all.sort_unstable_by(|a, b| (a.0 * b.1).cmp(&(b.0 * a.1)).then(a.2.cmp(&b.2)));
    all.into_iter().map(|(_, _, _, member)| member).collect()
}

/// The parts of `of` equal ones that overlap with part `number` of `count` equal ones of so many tiles, and where.
fn overlaps(
    (number, count): (usize, usize),
    of: usize,
    tiles: usize,
) -> impl Iterator<Item = (usize, Range<usize>)> {
    let all = 0..tiles;
    let own = part(&all, number, count);
    // Rounding to whole tiles keeps the order of the ends of parts.
    let parts = number * of / count..((number + 1) * of).div_ceil(count);
    parts.filter_map(move |other| {
        let theirs = part(&all, other, of);
        let both = own.start.max(theirs.start)..own.end.min(theirs.end);
        (!both.is_empty()).then_some((other, both))
    })
}

/// The round in which the children of a node are joined, for its rank `own`.
fn round(count: usize, height: u32, own: usize, first: usize, tiles: &[u32]) -> Round {
    let joined = members(count, height);
    let new = |member: usize| joined.iter().position(|&m| m == member).unwrap_or(0);
    let own_new = new(own);
    let mut round = Round::default();
    let mut start = 0;
    for size in children(count, height) {
        let of_child = members(size, height - 1);
        if (start..start + size).contains(&own) {
            let old = of_child.iter().position(|&m| start + m == own).unwrap_or(0);
            let sends = overlaps((old, size), count, tiles.len()).filter(|(to, _)| *to != own_new);
            let sends = sends.map(|(to, those)| (first + joined[to], tiles[those].to_vec()));
            round.sends.extend(sends);
        }
        let senders = overlaps((own_new, count), size, tiles.len());
        let senders = senders.map(|(from, _)| start + of_child[from]).filter(|&from| from != own);
        round.receives.extend(senders.map(|from| first + from));
        start += size;
    }
    // Every rank begins with the next one, so that no rank gets all messages at once.
    round.sends.sort_unstable_by_key(|(to, _)| *to);
    let next = round.sends.partition_point(|(to, _)| *to <= first + own);
    round.sends.rotate_left(next);
    round
}

impl Strategy for TwoThreeSwap {
    fn rounds(&self, shared: &Shared, place: usize) -> Vec<Round> {
        let order = interlaced(shared.tiles);
        let (mut first, mut count) = (0, shared.ranks.len());
        let mut rounds = Vec::new();
        // From the root to the rank: the last round comes first.
        for height in (1..=height(count)).rev() {
            rounds.push(round(count, height, place - first, first, &order));
            for size in children(count, height) {
                if place < first + size {
                    count = size;
                    break;
                }
                first += size;
            }
        }
        rounds.reverse();
        rounds
    }

    fn owners(&self, shared: &Shared) -> Vec<usize> {
        let (count, tiles) = (shared.ranks.len(), shared.tiles.len());
        let members = members(count, height(count)).into_iter().enumerate();
        owners_of_parts(tiles, members.map(|(number, member)| (part(&(0..tiles), number, count), member)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::composite::Touched;

    #[test]
    fn all_leaves_have_the_same_depth() {
        fn leaves(count: usize, height: u32) -> usize {
            if height == 0 {
                assert_eq!(count, 1);
                return 1;
            }
            let sizes = children(count, height);
            assert!(matches!(sizes.len(), 2 | 3) && sizes.iter().all(|&size| size > 0), "{count}: {sizes:?}");
            sizes.into_iter().map(|size| leaves(size, height - 1)).sum()
        }
        for count in 1..2000 {
            assert_eq!(leaves(count, height(count)), count);
        }
    }

    #[test]
    fn each_rank_is_a_member_once() {
        for count in 1..300 {
            let mut all = members(count, height(count));
            all.sort_unstable();
            assert!(all.into_iter().eq(0..count), "{count}");
        }
    }

    /// If each child of every node has as many ranks, each tile is sent once by all ranks but its owner, and each rank sends
    /// one message to each member of the other children that its part is divided among.
    #[test]
    fn messages_are_those_of_the_formulas() {
        const TILES: u32 = 7 * 64;
        let tiles: Vec<u32> = (0..TILES).collect();
        for count in 1usize..=64 {
            let touched = Touched::new(TILES as usize, (0..count).map(|_| |_| true));
            let ranks: Vec<usize> = (0..count).collect();
            let shared = Shared { tiles: &tiles, ranks: &ranks, touched: &touched };
            let schedules: Vec<_> = (0..count).map(|place| TwoThreeSwap.rounds(&shared, place)).collect();
            let sends = schedules.iter().flatten().flat_map(|round| &round.sends);
            let (messages, sent) = sends.fold((0, 0), |(n, sum), (_, tiles)| (n + 1, sum + tiles.len()));
            let pictures = TILES as usize * (count - 1);
            match (count.is_power_of_two(), count % 3 == 0 && (count / 3).is_power_of_two()) {
                (true, _) => {
                    assert_eq!((messages, sent), (count * count.ilog2() as usize, pictures), "{count}");
                }
                (_, true) => {
                    let doublings = (count / 3).ilog2() as usize;
                    assert_eq!((messages, sent), (count * (2 + doublings), pictures), "{count}");
                }
                // Other parts move within a node, too, but not more than between nodes.
                _ => assert!((pictures..2 * pictures).contains(&sent), "{count}: {sent} of {pictures}"),
            }
            for rounds in &schedules {
                assert_eq!(rounds.len(), count.ilog2() as usize);
                for round in rounds {
                    assert!(round.receives.len() <= 5, "{count}: {round:?}");
                }
            }
        }
    }
}
