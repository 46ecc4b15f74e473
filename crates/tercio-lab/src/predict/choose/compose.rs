//! How long compositing takes, and what is sent for it, by strategy.

use tercio_parallel::Composition;
use tercio_parallel::numbers::gcd;

use super::terms::{Load, Stage, Sums};
use super::wires::Reach;

/// Tiles in which several ranks have something.
#[derive(Clone, Debug, Default)]
pub struct SharedTiles {
    /// Each of them.
    pub tiles: Vec<SharedTile>,
    /// Of each rank: pixels or fragments that it has in them; the number of such tiles.
    pub of_rank: Vec<[f64; 2]>,
    /// For direct send: what each rank sends, receives and owns, in pixels or fragments.
    pub direct: Vec<[f64; 3]>,
    /// The largest number of ranks that a rank may have tiles in common with.
    pub partners: f64,
    /// How many ranks apart these are: the ranks of a group. 0 is 1.
    pub apart: usize,
}

/// A tile in which several ranks have something.
#[derive(Clone, Copy, Debug)]
pub struct SharedTile {
    /// Ranks.
    pub ranks: f64,
    /// Pixels or fragments of all of them together.
    pub sum: f64,
    /// The same when they are merged: those that are seen.
    pub merged: f64,
}

/// What compositing takes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Composited {
    /// Seconds.
    pub seconds: f64,
    /// Messages and bytes of all ranks.
    pub sent: Sums,
}

impl SharedTiles {
    /// The ranks that have any of the tiles.
    fn participants(&self) -> usize {
        self.of_rank.iter().filter(|of| of[1] > 0.0).count()
    }

    /// Of ranks that have the same tiles: they have the same place in their groups.
    fn owners_of_the_same(&self) -> Reach {
        Reach { within: self.of_rank.len(), stride: self.apart.max(1) }
    }

    /// Pixels or fragments of all ranks, when those of this many consecutive ranks are merged.
    fn after(&self, merged: usize, participants: usize) -> f64 {
        self.in_blocks(participants.div_ceil(merged.max(1)))
    }

    /// The same, when those of each of so many blocks of ranks are merged.
    fn in_blocks(&self, blocks: usize) -> f64 {
        let blocks = blocks as f64;
        self.tiles.iter().map(|tile| tile.sum.min(tile.merged * tile.ranks.min(blocks))).sum()
    }

    /// The time of a strategy. `steps` counts the tiles that are looked at.
    pub fn composite(&self, composition: Composition, stage: &Stage, steps: &mut u64) -> Composited {
        let count = self.participants();
        if count < 2 {
            return Composited::default();
        }
        match composition {
            Composition::DirectSend => self.direct(stage),
            Composition::BinarySwap => {
                let swapping = 1usize << count.ilog2();
                let pairs = vec![2; swapping.ilog2() as usize];
                let mut all = self.in_rounds(&pairs, swapping, stage, steps);
                let extra = count - swapping;
                if extra > 0 {
                    // These send all that they have to the rank before them first.
                    let neighbours = Reach { within: 2, stride: 1 };
                    let all_of_one = self.after(1, count) / count as f64;
                    all = all.plus(transfer(stage, extra, count, (1.0, all_of_one, 1.0), neighbours));
                }
                all
            }
            Composition::RadixK(radices) => self.in_rounds(&radices.groups(count), count, stage, steps),
            Composition::TwoThreeSwap => self.two_three_swap(count, stage, steps),
            Composition::Tree => self.tree(count, stage, steps),
            // Whatever else there may be is as slow as the slowest.
            _ => self.ring(count, stage),
        }
    }

    /// What ranks tell each other before and while they draw the tiles, so that blocks of pixels are finished: how near they may draw, to
    /// the owners of tiles and back, and what the rank in front hides, in up to four messages to each other rank, or as many as its bytes
    /// need.
    pub fn telling(&self, stage: &Stage) -> Composited {
        /// Messages to each partner on average, and bytes of a tile of 64 pixels.
        const EXCHANGES: [[f64; 2]; 3] = [[1.0, 128.0], [1.0, 132.0], [2.0, 132.0]];
        if !stage.rates.finishes_blocks || self.participants() < 2 {
            return Composited::default();
        }
        let exchange = |[messages, bytes]: [f64; 2]| {
            let loads = self.of_rank.iter().map(|of_rank| {
                let bytes = of_rank[1] * bytes;
                let partners = self.partners.min(of_rank[1]).ceil();
                let work = 2.0 * bytes * stage.rates.byte;
                Load { messages: messages * partners, out: bytes, into: bytes, work }
            });
            let loads: Vec<Load> = loads.collect();
            Composited { seconds: stage.exchange(&loads, self.owners_of_the_same()), sent: Sums::of(&loads) }
        };
        EXCHANGES.into_iter().map(exchange).fold(Composited::default(), Composited::plus)
    }

    fn direct(&self, stage: &Stage) -> Composited {
        let bytes = stage.rates.composited_bytes;
        let loads = self.direct.iter().zip(&self.of_rank).map(|([sent, taken, owned], of_rank)| Load {
            messages: self.partners.min(of_rank[1]).ceil(),
            out: sent * bytes,
            into: taken * bytes,
            work: if stage.rates.fragments { owned } else { taken } * stage.rates.merged
                + (sent + taken) * bytes * stage.rates.byte,
        });
        let loads: Vec<Load> = loads.collect();
        Composited { seconds: stage.exchange(&loads, self.owners_of_the_same()), sent: Sums::of(&loads) }
    }

    /// Rounds in which groups of ranks exchange parts of their tiles; the sizes of the groups of each round.
    fn in_rounds(&self, sizes: &[usize], count: usize, stage: &Stage, steps: &mut u64) -> Composited {
        let mut all = Composited::default();
        let mut merged = 1;
        for &size in sizes {
            *steps += self.tiles.len() as u64;
            let has = self.after(merged, count) / count as f64;
            let share = (size - 1) as f64 / size as f64;
            let each = ((size - 1) as f64, has * share, self.unevenness());
            let reach = Reach { within: merged * size, stride: merged };
            all = all.plus(transfer(stage, count, count, each, reach));
            merged *= size;
        }
        all.plus(self.merging(count, stage))
    }

    /// Rounds in which the nodes of a tree of ranks are joined by twos and threes.
    fn two_three_swap(&self, count: usize, stage: &Stage, steps: &mut u64) -> Composited {
        let mut all = Composited::default();
        for joined in joined(count).iter().rev() {
            *steps += self.tiles.len() as u64;
            let blocks = joined.iter().map(|j| j.nodes * j.children).sum();
            let has = self.in_blocks(blocks) / count as f64;
            // Each member keeps its part of what it and the other children had.
            let mean = |of: fn(&Joined) -> f64| {
                joined.iter().map(|j| (j.nodes * j.size) as f64 * of(j)).sum::<f64>() / count as f64
            };
            let share = mean(|j| 1.0 - 1.0 / j.children as f64);
            let each = (mean(Joined::messages), has * share, self.unevenness());
            let largest = joined.iter().map(|j| j.size).max().unwrap_or(1);
            let stride = joined.iter().map(|j| j.size / j.children).min().unwrap_or(1);
            all = all.plus(transfer(stage, count, count, each, Reach { within: largest, stride }));
        }
        all.plus(self.merging(count, stage))
    }

    /// So many ranks make pixels of the fragments of what they own.
    fn merging(&self, owners: usize, stage: &Stage) -> Composited {
        let work = if stage.rates.fragments { self.sum() * stage.rates.merged } else { 0.0 };
        Composited { seconds: stage.evenly(work, owners), sent: Sums::default() }
    }

    fn tree(&self, count: usize, stage: &Stage, steps: &mut u64) -> Composited {
        let mut all = Composited::default();
        let mut merged = 1;
        while merged < count {
            *steps += self.tiles.len() as u64;
            // The last sender may have what fewer ranks had.
            let senders = (merged..count).step_by(2 * merged);
            let number = senders.clone().count();
            let sent: usize = senders.map(|sender| merged.min(count - sender)).sum();
            let has = self.after(merged, count) * sent as f64 / (count * number.max(1)) as f64;
            let uneven = (merged * number) as f64 / sent.max(1) as f64;
            let reach = Reach { within: 2 * merged, stride: merged };
            all = all.plus(transfer(stage, number, count, (1.0, has, uneven), reach));
            merged *= 2;
        }
        all.plus(self.merging(1, stage))
    }

    fn ring(&self, count: usize, stage: &Stage) -> Composited {
        let mut all = Composited::default();
        let merged: f64 = self.tiles.iter().map(|tile| tile.merged).sum();
        let sum = self.sum();
        for done in 1..count {
            let has = (sum * done as f64 / count as f64).min(merged);
            all = all.plus(transfer(stage, 1, count, (1.0, has, 1.0), Reach { within: 2, stride: 1 }));
        }
        all.plus(self.merging(1, stage))
    }

    fn sum(&self) -> f64 {
        self.tiles.iter().map(|tile| tile.sum).sum()
    }

    /// Most over mean rank, of those that take part; merging evens it out, so at most 2.
    fn unevenness(&self) -> f64 {
        let (most, sum) =
            self.of_rank.iter().fold((0.0f64, 0.0), |(most, sum), of| (most.max(of[0]), sum + of[0]));
        (most * self.participants() as f64 / sum.max(1e-9)).clamp(1.0, 2.0)
    }
}

/// This many ranks `of` all send so many messages and pixels or fragments each, to as many others, which merge them; the busiest
/// one has `uneven` times as many.
fn transfer(
    stage: &Stage,
    ranks: usize,
    of: usize,
    (messages, shown, uneven): (f64, f64, f64),
    reach: Reach,
) -> Composited {
    let bytes = shown * stage.rates.composited_bytes;
    let merging = shown * if stage.rates.fragments { stage.rates.joined } else { stage.rates.merged };
    let work = (merging + 2.0 * bytes * stage.rates.byte) * uneven;
    let load = Load { messages, out: bytes * uneven, into: bytes * uneven, work };
    let seconds = stage.exchange_evenly(&load, (ranks, of), reach);
    let sent = Sums { messages: messages * ranks as f64, bytes: bytes * ranks as f64 };
    Composited { seconds, sent }
}

impl Composited {
    /// One after the other.
    pub fn plus(self, o: Self) -> Self {
        let sent =
            Sums { messages: self.sent.messages + o.sent.messages, bytes: self.sent.bytes + o.sent.bytes };
        Self { seconds: self.seconds + o.seconds, sent }
    }
}

/// Nodes of one size that a round of 2-3 swap joins from their children.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Joined {
    nodes: usize,
    /// Ranks of each.
    size: usize,
    children: usize,
}

impl Joined {
    /// The sizes of its children, and how many have them.
    fn of_children(&self) -> [(usize, usize); 2] {
        let (size, larger) = (self.size / self.children, self.size % self.children);
        [(size, self.children - larger), (size + 1, larger)]
    }

    /// Messages that a rank sends, on average. Each child's equal parts are cut at the ends of the node's equal parts: that many pieces,
    /// of which each member keeps one.
    fn messages(&self) -> f64 {
        let pieces = |child: usize| child + self.size - gcd(child, self.size);
        let all: usize = self.of_children().iter().map(|&(child, number)| number * pieces(child)).sum();
        (all - self.size) as f64 / self.size as f64
    }
}

/// What each round of 2-3 swap joins, the last round first: log2 of the ranks levels, each node with two children, or three if two
/// would have more than the 3^levels ranks that there is room for (Yu, Wang and Ma 2008).
fn joined(count: usize) -> Vec<Vec<Joined>> {
    let mut rounds = Vec::new();
    let mut sizes = vec![(count, 1usize)];
    for below in (0..count.max(1).ilog2()).rev() {
        let (mut round, mut smaller) = (Vec::new(), Vec::<(usize, usize)>::new());
        for &(size, nodes) in &sizes {
            let children = if size.div_ceil(2) <= 3usize.saturating_pow(below) { 2 } else { 3 };
            let node = Joined { nodes, size, children };
            round.push(node);
            for (of, number) in node.of_children() {
                match smaller.iter_mut().find(|(known, _)| *known == of) {
                    Some((_, all)) => *all += nodes * number,
                    None if number > 0 => smaller.push((of, nodes * number)),
                    None => {}
                }
            }
        }
        rounds.push(round);
        sizes = smaller;
    }
    rounds
}

/// The sizes of the groups of each round of 2-3 swap if all groups of a round have the same: then it is radix-k with other names.
pub(super) fn even_groups(count: usize) -> Option<Vec<usize>> {
    let even = |round: &Vec<Joined>| match round[..] {
        [node] if node.size.is_multiple_of(node.children) => Some(node.children),
        _ => None,
    };
    joined(count).iter().rev().map(even).collect()
}

#[cfg(test)]
mod tests {
    use tercio_parallel::composite::{Shared, Touched};

    use super::*;
    use crate::predict::choose::network::Network;
    use crate::predict::choose::rates::Rates;

    /// Messages and bytes against those of the renderer's schedules, message by message: every rank has the same number of fragments in
    /// every tile, and all are seen when they are merged.
    #[test]
    fn messages_and_bytes_of_rounds_are_those_of_the_schedules() {
        const TILES: usize = 5040;
        let machine = crate::predict::choose::machine().expect("built in");
        let rates = Rates { fragments: true, composited_bytes: 1.0, ..rates(&machine) };
        let wires = Network::in_process(&machine).expect("it has a network").into();
        let stage = Stage { rates: &rates, wires, share: 1.0, processors: 64.0, waking: 0.0 };
        let tiles: Vec<u32> = (0..TILES as u32).collect();
        for count in 2..=40usize {
            let places: Vec<usize> = (0..count).collect();
            let touched = Touched::new(TILES, (0..count).map(|_| |_| true));
            let shared = Shared { tiles: &tiles, ranks: &places, touched: &touched };
            let (ranks, sum) = (count as f64, count as f64);
            let all = SharedTiles {
                tiles: vec![SharedTile { ranks, sum, merged: sum }; TILES],
                of_rank: vec![[TILES as f64, TILES as f64]; count],
                ..SharedTiles::default()
            };
            for composition in [Composition::TwoThreeSwap, Composition::BinarySwap, Composition::radix_k(4)] {
                let found = all.composite(composition, &stage, &mut 0).sent;
                // Of every tile, the fragments that each rank has in each round.
                let schedules: Vec<_> = places.iter().map(|&p| composition.rounds(&shared, p)).collect();
                let mut has = vec![vec![1.0f64; TILES]; count];
                let (mut messages, mut bytes) = (0.0, 0.0);
                // Of binary swap some ranks send only, in the round before the others'.
                let before = usize::from(composition == Composition::BinarySwap && !count.is_power_of_two());
                let most = schedules.iter().map(Vec::len).max().unwrap_or(0);
                for number in 0..most {
                    let mut moved = Vec::new();
                    for (from, rounds) in schedules.iter().enumerate() {
                        let sends_only = rounds.len() == 1 && rounds[0].receives.is_empty() && before == 1;
                        let skipped = if sends_only || rounds.len() == most { 0 } else { before };
                        let Some(round) = number.checked_sub(skipped).and_then(|own| rounds.get(own)) else {
                            continue;
                        };
                        for (to, those) in &round.sends {
                            messages += 1.0;
                            moved.extend(those.iter().map(|&tile| (from, *to, tile as usize)));
                        }
                    }
                    let sizes: Vec<f64> =
                        moved.iter().map(|&(from, _, tile)| std::mem::take(&mut has[from][tile])).collect();
                    for (&(_, to, tile), size) in moved.iter().zip(&sizes) {
                        has[to][tile] += size;
                    }
                    bytes += sizes.iter().sum::<f64>();
                }
                let what = format!("{composition} of {count}: {found:?}, {messages} messages, {bytes} bytes");
                let near = |a: f64, b: f64, off: f64| assert!((a / b - 1.0).abs() < off, "{what}");
                near(found.bytes, bytes, 0.03);
                near(found.messages, messages, 0.03);
            }
        }
    }

    fn rates(machine: &crate::machines::Machine) -> Rates {
        Rates::of(machine, &tercio_raster::Settings::one_sample(64, 64), false)
    }

    #[test]
    fn two_three_swap_of_powers_of_two_is_binary_swap() {
        let machine = crate::predict::choose::machine().expect("built in");
        let rates = rates(&machine);
        let wires = Network::in_process(&machine).expect("it has a network").into();
        let stage = Stage { rates: &rates, wires, share: 1.0, processors: 8.0, waking: 0.0 };
        for count in [2usize, 4, 8, 32] {
            let tiles = (1..90).map(|k| SharedTile {
                ranks: count as f64,
                sum: f64::from(k),
                merged: f64::from(k) / 2.0,
            });
            let of_rank = (0..count).map(|rank| [10.0 + rank as f64, 89.0]);
            let all =
                SharedTiles { tiles: tiles.collect(), of_rank: of_rank.collect(), ..SharedTiles::default() };
            let of = |composition| all.composite(composition, &stage, &mut 0);
            let (swap, other) = (of(Composition::BinarySwap), of(Composition::TwoThreeSwap));
            assert!((swap.seconds / other.seconds - 1.0).abs() < 1e-9, "{swap:?} {other:?}");
            assert!((swap.sent.bytes / other.sent.bytes - 1.0).abs() < 1e-9, "{swap:?} {other:?}");
        }
    }
}
