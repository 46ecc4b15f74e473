//! How long compositing takes, and what is sent for it, by strategy.

use tercio_parallel::Composition;

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
    /// The same when they are merged: fragments stay.
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
        let blocks = participants.div_ceil(merged.max(1)) as f64;
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
            Composition::RadixK(radix) => self.in_rounds(&sizes(count, radix), count, stage, steps),
            Composition::Tree => self.tree(count, stage, steps),
            // Whatever else there may be is as slow as the slowest.
            _ => self.ring(count, stage),
        }
    }

    fn direct(&self, stage: &Stage) -> Composited {
        let bytes = stage.rates.composited_bytes;
        let loads = self.direct.iter().zip(&self.of_rank).map(|([sent, taken, owned], of_rank)| Load {
            messages: self.partners.min(of_rank[1]).ceil(),
            out: sent * bytes,
            into: taken * bytes,
            work: owned * stage.rates.merged + (sent + taken) * bytes * stage.rates.byte,
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
        // Fragments are only concatenated before.
        let merging = if stage.rates.fragments { self.sum() * stage.rates.merged } else { 0.0 };
        all.seconds += stage.evenly(merging, count);
        all
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
        let merging = if stage.rates.fragments { self.sum() * stage.rates.merged } else { 0.0 };
        all.seconds += stage.evenly(merging, 1);
        all
    }

    fn ring(&self, count: usize, stage: &Stage) -> Composited {
        let mut all = Composited::default();
        let merged: f64 = self.tiles.iter().map(|tile| tile.merged).sum();
        for done in 1..count {
            let has = (self.sum() * done as f64 / count as f64).min(merged);
            all = all.plus(transfer(stage, 1, count, (1.0, has, 1.0), Reach { within: 2, stride: 1 }));
        }
        let merging = if stage.rates.fragments { self.sum() * stage.rates.merged } else { 0.0 };
        all.seconds += stage.evenly(merging, 1);
        all
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
    let merging = if stage.rates.fragments { 0.0 } else { shown * stage.rates.merged };
    let work = (merging + 2.0 * bytes * stage.rates.byte) * uneven;
    let load = Load { messages, out: bytes * uneven, into: bytes * uneven, work };
    let seconds = stage.exchange_evenly(&load, (ranks, of), reach);
    let sent = Sums { messages: messages * ranks as f64, bytes: bytes * ranks as f64 };
    Composited { seconds, sent }
}

impl Composited {
    fn plus(self, o: Self) -> Self {
        let sent =
            Sums { messages: self.sent.messages + o.sent.messages, bytes: self.sent.bytes + o.sent.bytes };
        Self { seconds: self.seconds + o.seconds, sent }
    }
}

/// The sizes of the groups of radix-k.
fn sizes(mut count: usize, radix: u32) -> Vec<usize> {
    let mut sizes = Vec::new();
    while count > 1 {
        let radix = (radix.max(2) as usize).min(count);
        let fitting = (2..=radix).rev().find(|&size| count.is_multiple_of(size));
        let size =
            fitting.or_else(|| (radix + 1..=count).find(|&size| count.is_multiple_of(size))).unwrap_or(count);
        sizes.push(size);
        count /= size;
    }
    sizes
}
