//! A frame of one candidate, by formulas over the tiles: no message is simulated.

use tercio_parallel::division::Division;
use tercio_parallel::organisation::redistribute::FEW;
use tercio_parallel::{Organisation, Sharing};

use super::compose::{SharedTile, SharedTiles};
use super::rates::{BIN_HEAD, BIN_TILE, TILE_HEAD};
use super::terms::{Load, Stage, Sums, Terms};
use super::tiles::{Part, Tiles};
use super::wires::Reach;

/// A picture for candidates with the same tiles and groups.
pub struct Grouped<'a> {
    /// The tiles.
    pub tiles: &'a Tiles,
    /// Ranks.
    pub ranks: usize,
    /// Ranks of a group; the last group may have fewer.
    pub group: usize,
    /// What groups have in tiles.
    pub parts: &'a [Part],
    /// The owner of each tile, by its place in the group.
    pub owners: &'a [u32],
    /// The same in the last group.
    pub owners_of_last: &'a [u32],
}

/// The same for one division: the terms that do not depend on the composition.
pub struct Divided {
    /// Without compositing; collecting is added by [`Divided::with`].
    terms: Terms,
    sent: Sums,
    shared: SharedTiles,
    /// Pixels that each rank finishes without compositing, and those that are composited.
    finished: Vec<f64>,
    composited: f64,
    picture: f64,
}

impl Grouped<'_> {
    fn groups(&self) -> usize {
        self.ranks.div_ceil(self.group)
    }

    fn length_of(&self, group: usize) -> usize {
        self.group.min(self.ranks - group * self.group)
    }

    /// Divides the picture. `steps` counts parts and tiles that are looked at.
    pub fn divide(
        &self,
        organisation: Organisation,
        division: Division,
        stage: &Stage,
        steps: &mut u64,
    ) -> Divided {
        let rates = stage.rates;
        let (ranks, tiles) = (self.ranks, self.tiles);
        let last = self.groups() - 1;
        *steps += (tiles.load.len() + 2 * self.parts.len()) as u64;
        let rank_of = |part: &Part| {
            let group = part.group as usize;
            let owners = if group == last { self.owners_of_last } else { self.owners };
            group * self.group + owners[part.tile as usize] as usize
        };

        let mut in_tile = vec![SharedTile { ranks: 0.0, sum: 0.0, merged: 0.0 }; tiles.load.len()];
        // Pixels in which groups show something, of all together.
        let mut shown = vec![0.0; tiles.load.len()];
        for part in self.parts {
            let tile = &mut in_tile[part.tile as usize];
            tile.ranks += 1.0;
            tile.sum += part.shown;
            shown[part.tile as usize] += part.pixels;
        }
        let (mut draw, mut sorting, mut bins) = (vec![0.0; ranks], vec![0.0; ranks], vec![0.0; ranks]);
        let mut shared = SharedTiles {
            of_rank: vec![[0.0; 2]; ranks],
            direct: vec![[0.0; 3]; ranks],
            partners: (self.groups() - 1) as f64,
            apart: self.group,
            tiles: Vec::new(),
        };
        let mut finished = vec![0.0; ranks];
        for part in self.parts {
            let (rank, tile) = (rank_of(part), &in_tile[part.tile as usize]);
            draw[rank] += part.triangles * rates.triangle + part.shown * rates.shown;
            sorting[rank] += part.sorting;
            bins[rank] += part.bin_bytes;
            if tile.ranks < 2.0 {
                finished[rank] += part.pixels;
                continue;
            }
            draw[rank] += part.shown * rates.kept;
            let of_rank = &mut shared.of_rank[rank];
            of_rank[0] += part.shown;
            of_rank[1] += 1.0;
            let direct = &mut shared.direct[rank];
            direct[0] += part.shown * (1.0 - 1.0 / tile.ranks) + TILE_HEAD / rates.composited_bytes;
            direct[1] += (tile.sum - part.shown) / tile.ranks;
            direct[2] += tile.sum / tile.ranks;
        }
        let mut composited = 0.0;
        for ((tile, &pixels), &shown) in in_tile.iter_mut().zip(&tiles.covered).zip(&shown) {
            if tile.ranks >= 2.0 {
                // Of a pixel as many fragments are seen as one group has there. What is not opaque hides nothing.
                let seen = if rates.translucent { 1.0 } else { (pixels / shown.max(1e-9)).min(1.0) };
                tile.merged = tile.sum * seen;
                composited += pixels;
                shared.tiles.push(*tile);
            }
        }
        let mut sent = Sums::default();
        let front_end = self.front_end(organisation, division, &sorting, stage);
        let bins = self.bins(organisation, &bins, stage, &mut sent);
        let touched = self.touched(organisation, stage, &mut sent);
        let draw = stage.work(draw.into_iter());
        let front_end = front_end + stage.waking(front_end + draw);
        let terms = Terms { front_end, exchange: bins + touched, draw, ..Terms::default() };
        Divided { terms, sent, shared, finished, composited, picture: tiles.pixels.iter().sum() }
    }

    fn front_end(
        &self,
        organisation: Organisation,
        division: Division,
        sorting_of_tiles: &[f64],
        stage: &Stage,
    ) -> f64 {
        let (rates, tiles) = (stage.rates, self.tiles);
        let dividing = match (self.group > 1, division.needs_load()) {
            (false, _) => 0.0,
            (true, false) => tiles.load.len() as f64 * 2e-9,
            // One thread of each rank does it.
            (true, true) => tiles.survey + tiles.load.len() as f64 * rates.survey[2],
        };
        let composites = organisation.composites(self.ranks);
        let dividing = dividing + if composites { tiles.survey_of_clusters } else { 0.0 };
        let of_rank = dividing.max(dividing * self.ranks as f64 / stage.processors);
        let tests = tiles.clusters * rates.cluster;
        of_rank
            + if organisation == Organisation::SortFirst {
                stage.work(sorting_of_tiles.iter().map(|sorting| tests + sorting))
            } else {
                let sorted = &tiles.sorted[usize::from(composites)];
                stage.work(sorted.iter().map(|[sorting, _]| tests / self.ranks as f64 + sorting))
            }
    }

    /// Bins to the owners of tiles: all but those of a rank's own tiles.
    fn bins(&self, organisation: Organisation, received: &[f64], stage: &Stage, sent: &mut Sums) -> f64 {
        if organisation == Organisation::SortFirst || self.group == 1 {
            return 0.0;
        }
        let load = |rank: usize| {
            let others = (self.length_of(rank / self.group) - 1) as f64;
            let away = others / (others + 1.0);
            let bytes = self.tiles.sorted[usize::from(organisation.composites(self.ranks))][rank][1];
            let reached = bytes / 24.0;
            // A head for each tile that its clusters reach, of which it may have several in a tile.
            let heads = reached.min(self.tiles.load.len() as f64) * BIN_TILE + others * BIN_HEAD;
            let (out, into) = ((bytes + heads) * away, received[rank] * away);
            let work = (out + into) * stage.rates.byte * 4.0;
            Load { messages: bin_messages(others, reached), out, into, work }
        };
        let loads: Vec<Load> = (0..self.ranks).map(load).collect();
        let sums = Sums::of(&loads);
        *sent = Sums { messages: sent.messages + sums.messages, bytes: sent.bytes + sums.bytes };
        stage.exchange(&loads, Reach { within: self.group, stride: 1 })
    }

    /// A bit for each tile, to all ranks, in as many rounds as the logarithm of their number.
    fn touched(&self, organisation: Organisation, stage: &Stage, sent: &mut Sums) -> f64 {
        if !organisation.composites(self.ranks) {
            return 0.0;
        }
        let rounds = f64::from(self.ranks.next_power_of_two().ilog2());
        let bytes = (self.ranks - 1) as f64 * self.tiles.load.len().div_ceil(64) as f64 * 8.0;
        sent.messages += rounds * self.ranks as f64;
        sent.bytes += bytes * self.ranks as f64;
        // Each rank then finds the tiles that several have: a word at a time.
        let load = Load { messages: rounds, out: bytes, into: bytes, work: bytes * stage.rates.byte };
        let all = Reach { within: self.ranks, stride: 1 };
        stage.exchange_evenly(&load, (self.ranks, self.ranks), all)
            + (rounds - 1.0) * stage.wires.latency(all)
    }
}

/// Messages with bins that a rank sends to others, if its clusters reach so many tiles. Many ranks send no empty ones, after they
/// have learned who sends to whom. Tiles are scattered among the others.
fn bin_messages(others: f64, tiles: f64) -> f64 {
    if others < FEW as f64 {
        return others;
    }
    others * (1.0 - (1.0 - 1.0 / others).powf(tiles)) + (others + 1.0).log2().ceil()
}

impl Divided {
    /// The frame with a composition. `steps` counts tiles that are looked at.
    pub fn with(&self, sharing: &Sharing, stage: &Stage, steps: &mut u64) -> (Terms, Sums) {
        let composited =
            self.shared.composite(sharing.composition, stage, steps).plus(self.shared.telling(stage));
        let collect = self.collect(sharing, stage);
        let sent = Sums {
            messages: self.sent.messages + composited.sent.messages + collect.1.messages,
            bytes: self.sent.bytes + composited.sent.bytes + collect.1.bytes,
        };
        (Terms { composite: composited.seconds, collect: collect.0, ..self.terms }, sent)
    }

    /// Every rank packs what it has finished, rank 0 unpacks one message after another.
    fn collect(&self, sharing: &Sharing, stage: &Stage) -> (f64, Sums) {
        use tercio_parallel::Composition::{Ring, Tree};
        let (rates, ranks) = (stage.rates, self.finished.len());
        let cleared = self.picture * rates.cleared;
        if ranks == 1 {
            return (0.0, Sums::default());
        }
        // Where composited pixels are in the end.
        let of_composited = match sharing.composition {
            Tree => 0.0,
            Ring => self.composited,
            _ => self.composited / ranks as f64,
        };
        let finishes = |rank: usize| {
            let is_last = sharing.composition != Ring || rank + 1 == ranks;
            self.finished[rank] + if is_last { of_composited } else { 0.0 }
        };
        let packing = stage.work((1..ranks).map(|rank| finishes(rank) * rates.collected[0]));
        // A composited tile has one owner: of many ranks, most may own none.
        let owning = match sharing.composition {
            Ring => 1.0,
            _ => (self.shared.tiles.len() as f64 / ranks as f64).min(1.0),
        };
        let (mut pixels, mut messages) = (0.0, 0.0);
        for rank in 1..ranks {
            pixels += finishes(rank);
            messages += match (self.finished[rank] > 0.0, finishes(rank) > 0.0) {
                (true, _) => 1.0,
                (false, true) => owning,
                (false, false) => 0.0,
            };
        }
        let bytes = pixels * rates.finished_bytes;
        // Others have nothing to do now: rank 0 works with one thread.
        let first = cleared + pixels * rates.collected[1];
        let sent = Sums { messages, bytes };
        (packing + stage.to_the_first(&sent, ranks) + first, sent)
    }
}
