//! The work of ranks besides drawing, and its costs: keys, packing, compositing, collecting.

use serde::Serialize;
use tercio_parallel::Organisation;
use tercio_raster::survey::Effort;

use super::traffic::{Messages, Pixels, Sharing};
use crate::machines::{Machine, MachineError, Operation};
use crate::predict::choose::rates;
use crate::predict::choose::tiles::looked_at;
use crate::predict::counts::Counters;

/// Bytes of a line of memory, of a key and of a colour.
const LINE: f64 = 64.0;
const KEY: f64 = 8.0;
const COLOR: f64 = 4.0;

/// Kinds of work that are charged.
pub const KINDS: usize = 13;

/// The first kind of work that is about dividing the picture; they come last.
pub const OF_DIVISION: usize = KINDS - 2;

/// How often each kind of work is done, or its costs, in the order of [`OPERATIONS`].
pub type Charges = [f64; KINDS];

/// The kinds of work: keys while drawing first, then the exchange, and last the division of the picture.
pub const OPERATIONS: [Operation; KINDS] = [
    Operation::PictureKey,
    Operation::ShadedKey,
    Operation::KeyLine,
    Operation::ScannedPixel,
    Operation::PackedSpan,
    Operation::PackedSample,
    Operation::UnpackedSpan,
    Operation::UnpackedSample,
    Operation::ClearedPixel,
    Operation::ExchangeLine,
    Operation::MergedPixel,
    Operation::SurveyedCluster,
    Operation::DividedTile,
];

/// Seconds of each kind of work.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ExchangeCosts(pub Charges);

impl ExchangeCosts {
    /// Whether a description has costs of ranks.
    pub fn are_known(machine: &Machine) -> bool {
        Self::are_fitted(machine) || OPERATIONS.iter().any(|&o| machine.seconds(o).is_some())
    }

    /// Whether all that a description has are fitted, those of zero omitted: the cache that ranks have is fitted with them.
    fn are_fitted(machine: &Machine) -> bool {
        machine.processors.exchange_cache.is_some()
    }

    /// The costs of a description. Costs that a fit made zero are omitted there, so a missing one is zero. Older descriptions, without
    /// `processors.exchange-cache`, lack some that are then others: of dividing a picture, those of `--organisation auto`; of merging a
    /// pixel, a sample unpacked.
    ///
    /// # Errors
    /// [`MachineError::Missing`] if it has none at all.
    pub fn of(machine: &Machine) -> Result<Self, MachineError> {
        let known = Self::are_known(machine).then_some(&());
        machine.need(known, "costs.scanned-pixel")?;
        let usual = |operation| match operation {
            _ if Self::are_fitted(machine) => 0.0,
            Operation::SurveyedCluster => rates::SURVEYED,
            Operation::DividedTile => rates::DIVIDED,
            Operation::MergedPixel => machine.seconds_or_0(Operation::UnpackedSample),
            _ => 0.0,
        };
        Ok(Self(OPERATIONS.map(|o| machine.seconds(o).unwrap_or_else(|| usual(o)))))
    }

    /// Seconds of the work `charges`.
    pub fn seconds(&self, charges: &Charges) -> f64 {
        self.0.iter().zip(charges).map(|(cost, count)| cost * count).sum()
    }
}

/// The memory of a rank in bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct RankMemory {
    /// Its picture with keys.
    pub picture: u64,
    /// Messages that it sends, and those that it receives if they are copied; their memory is reused in the next frame.
    pub messages: u64,
    /// The part of model and bins that it touches.
    pub model: u64,
}

impl RankMemory {
    /// All of it.
    pub fn total(&self) -> u64 {
        self.picture + self.messages + self.model
    }
}

/// The work of a frame besides drawing.
#[derive(Clone, Debug)]
pub struct Exchange<'a> {
    sharing: &'a Sharing,
    messages: &'a Messages,
    drawing: &'a [Counters],
    /// Whether the receiver of a message has a copy of its own.
    copied: bool,
    /// The share of the lines of pictures and messages that their part of the cache does not hold.
    missed: f64,
}

impl<'a> Exchange<'a> {
    /// `together` ranks share a memory, with a cache of which their pictures and messages have `cache` bytes. Messages are
    /// `copied`, or their memory is handed over.
    pub fn new(
        sharing: &'a Sharing,
        messages: &'a Messages,
        drawing: &'a [Counters],
        (together, cache): (usize, f64),
        copied: bool,
    ) -> Self {
        let mut exchange = Self { sharing, messages, drawing, copied, missed: 0.0 };
        let bytes: u64 = (0..sharing.ranks).map(|rank| exchange.memory(rank).total()).sum();
        let share = together.clamp(1, sharing.ranks) as f64 / sharing.ranks as f64;
        exchange.missed = missed(bytes as f64 * share, cache);
        exchange
    }

    /// Memory of a rank.
    pub fn memory(&self, rank: usize) -> RankMemory {
        let drawn = &self.drawing[rank];
        // Rank 0 has the whole picture in the end; others write the tiles only in which they have drawn something.
        let colors = if rank == 0 { self.sharing.pixels() } else { drawn.pixels };
        RankMemory {
            picture: colors * COLOR as u64 + self.messages.shared[rank].1 * KEY as u64,
            messages: self.messages.counts(rank).bytes
                + if self.copied { self.messages.bytes_taken(rank) } else { 0 },
            model: drawn.bytes_touched,
        }
    }

    /// Dividing the picture among the ranks of sort-first, and the clusters among those of sort-last, by an estimate of the work; all of
    /// them do all of it.
    pub fn dividing(&self) -> Charges {
        let mut charges = [0.0; KINDS];
        let Sharing { organisation, division, ranks, size, edge } = *self.sharing;
        if organisation == Organisation::SortFirst && ranks > 1 && division.needs_load() {
            charges[OF_DIVISION] = looked_at(Effort::OF_TILES, self.drawing[0].clusters) as f64;
            charges[OF_DIVISION + 1] = f64::from(size.0.div_ceil(edge)) * f64::from(size.1.div_ceil(edge));
        }
        if organisation == Organisation::SortLast && ranks > 1 {
            let clusters = self.drawing.iter().map(|drawn| drawn.clusters).sum();
            charges[OF_DIVISION] = looked_at(Effort::of_clusters(ranks), clusters) as f64;
        }
        charges
    }

    /// Keys while a rank draws, in tiles that other ranks draw, too.
    pub fn keys(&self, rank: usize) -> Charges {
        let (drawn, pixels) = self.messages.shared[rank];
        keys(pixels, drawn.pixels, self.missed)
    }

    /// Packing what a rank has drawn in tiles that other ranks draw, too.
    pub fn packing(&self, rank: usize) -> Charges {
        let (drawn, scanned) = self.messages.shared[rank];
        self.packed(drawn, scanned, true)
    }

    /// Merging what a rank receives from others, in the order in which it does: each into what it has then, from itself and from those
    /// before.
    pub fn composing(&self, rank: usize) -> Vec<(usize, Charges)> {
        let (ranks, composited) = (self.sharing.ranks, self.messages.finished[rank].composited);
        let sent: u64 = self.messages.composed[rank].iter().flatten().map(|sent| sent.pixels).sum();
        let mut has = self.messages.shared[rank].0.pixels - sent;
        let mut merges = Vec::new();
        for from in (1..ranks).map(|step| (rank + ranks - step) % ranks) {
            let Some(taken) = self.messages.between(from, rank) else { continue };
            // What one hides of another is not known: at most what the rank shows in the end. Of that, what it has in the tiles that
            // it receives, as if all had the same number of pixels.
            let share = (taken.tiles as f64 / composited.tiles.max(1) as f64).min(1.0);
            let own = has.min(composited.pixels) as f64 * share;
            let mut charges = [0.0; KINDS];
            charges[6] = taken.spans as f64;
            charges[10] = own + taken.pixels as f64;
            let written = taken.pixels as f64 * (KEY + COLOR);
            charges[9] = (taken.keyed_bytes() as f64 + written) / LINE * self.missed;
            merges.push((from, charges));
            has += taken.pixels;
        }
        merges
    }

    /// A rank's part of collecting the finished pixels: others pack them; rank 0 clears the pixels of its picture that it has
    /// not drawn, and unpacks what it has composited.
    pub fn finishing(&self, rank: usize) -> Charges {
        let finished = &self.messages.finished[rank];
        if rank > 0 {
            let mut charges = self.packed(finished.shown, finished.scanned, false);
            charges[9] += 2.0 * finished.composited.bytes() as f64 / LINE * self.missed;
            return charges;
        }
        let mut charges = self.unpacked(finished.composited);
        let cleared = (self.sharing.pixels() - finished.scanned) as f64;
        charges[8] = cleared;
        charges[9] += cleared * COLOR / LINE * self.missed;
        charges
    }

    /// Rank 0 puts another rank's pixels into the picture.
    pub fn collecting(&self, from: usize) -> Charges {
        self.unpacked(self.messages.finished[from].sent())
    }

    fn packed(&self, sent: Pixels, scanned: u64, keys: bool) -> Charges {
        let (samples, scanned) = (samples(sent, keys), scanned as f64);
        let mut charges = [0.0; KINDS];
        charges[3] = scanned;
        charges[4] = sent.spans as f64;
        charges[5] = samples;
        // Keys are scanned, or colours that are compared with the background.
        let (read, bytes) = if keys {
            (scanned * KEY + sent.pixels as f64 * COLOR, sent.keyed_bytes())
        } else {
            (scanned * COLOR, sent.bytes())
        };
        charges[9] = (read + bytes as f64) / LINE * self.missed;
        charges
    }

    fn unpacked(&self, taken: Pixels) -> Charges {
        let mut charges = [0.0; KINDS];
        charges[6] = taken.spans as f64;
        charges[7] = taken.pixels as f64;
        charges[9] = (taken.bytes() as f64 + taken.pixels as f64 * COLOR) / LINE * self.missed;
        charges
    }
}

/// Number of keys and colours sent.
fn samples(pixels: Pixels, keys: bool) -> f64 {
    pixels.pixels as f64 * if keys { 2.0 } else { 1.0 }
}

/// The share of memory, scanned repeatedly, that misses a cache of so many bytes.
pub fn missed(bytes: f64, cache: f64) -> f64 {
    if bytes > 0.0 { (1.0 - cache / bytes).max(0.0) } else { 0.0 }
}

/// The keys of tiles with so many pixels, of which so many show something.
pub fn keys(pixels: u64, drawn: u64, missed: f64) -> Charges {
    let mut charges = [0.0; KINDS];
    charges[0] = pixels as f64;
    charges[1] = drawn as f64;
    charges[2] = pixels as f64 * KEY / LINE * missed;
    charges
}

#[cfg(test)]
mod tests {
    use tercio_parallel::organisation::envelope::TRAILER;
    use tercio_parallel::{Division, Organisation};

    use super::super::traffic::Finished;
    use super::*;

    #[test]
    fn memory_that_fits_into_the_cache_takes_no_time() {
        assert_eq!([missed(0.0, 4.0), missed(4.0, 4.0), missed(16.0, 4.0)], [0.0, 0.0, 0.75]);
        assert_eq!(missed(1e12, f64::INFINITY), 0.0);
    }

    #[test]
    fn ranks_pack_what_others_receive() {
        let (organisation, division) = (Organisation::SortLast, Division::default());
        let sharing = Sharing { organisation, division, ranks: 2, size: (32, 32), edge: 16 };
        let pixels = |spans, pixels| Pixels { spans, pixels, tiles: 1 };
        let finished = |scanned, shown, composited, is_sent| {
            let visible = 90;
            Finished { scanned, shown, composited, visible, is_sent }
        };
        // Two of four tiles are composited, each rank owns one of them and one that it has drawn alone.
        let messages = Messages {
            triangles: vec![1, 1],
            gathered: (1, 8),
            shared: vec![(pixels(7, 70), 512), (pixels(3, 30), 512)],
            composed: vec![vec![None, Some(pixels(3, 30))], vec![Some(pixels(1, 10)), None]],
            finished: vec![
                finished(256, pixels(4, 40), pixels(6, 60), false),
                finished(256, pixels(5, 50), pixels(2, 20), true),
            ],
        };
        let drawn = Counters { pixels: 768, bytes_touched: 1000, ..Counters::default() };
        let drawing = [drawn; 2];
        let exchange = Exchange::new(&sharing, &messages, &drawing, (2, 0.0), false);
        assert_eq!(exchange.missed, 1.0);
        let lines = |bytes: f64| bytes / 64.0;
        assert_eq!(exchange.keys(0)[..3], [512.0, 70.0, 64.0]);
        let packing = exchange.packing(0);
        assert_eq!(packing[3..6], [512.0, 7.0, 140.0]);
        assert_eq!(packing[9], lines(512.0 * 8.0 + 70.0 * 4.0 + 7.0 * 6.0 + 70.0 * 12.0 + 12.0));
        let [(from, composing)] = exchange.composing(1)[..] else { panic!("one message") };
        assert_eq!(from, 0);
        // Rank 1 keeps 20 of its 30 pixels, and shows 20 in the end.
        assert_eq!((composing[6], composing[7], composing[10]), (3.0, 0.0, 50.0));
        // Nothing from itself.
        assert!(exchange.composing(0).iter().all(|merge| merge.0 == 1));
        // Finished colours without keys.
        assert_eq!(exchange.finishing(1)[3..6], [256.0, 5.0, 50.0]);
        assert_eq!(exchange.collecting(1)[6..8], [7.0, 70.0]);
        let finishing = exchange.finishing(0);
        assert_eq!((finishing[3], finishing[6..9].to_vec()), (0.0, vec![6.0, 60.0, 768.0]));
        let memory = exchange.memory(0);
        let trailer = TRAILER as u64;
        // Two messages, and below three.
        let sent = 8 + 12 + 3 * 6 + 30 * 12 + 2 * trailer;
        assert_eq!(memory, RankMemory { picture: 1024 * 4 + 512 * 8, messages: sent, model: 1000 });
        assert_eq!(exchange.memory(1).picture, 768 * 4 + 512 * 8);
        // If messages are copied, rank 0 also has those it receives: 10 pixels with keys, 70 finished ones.
        let copied = Exchange::new(&sharing, &messages, &drawing, (2, 0.0), true).memory(0);
        let taken = 8 + 12 + 6 + 120 + 7 * 6 + 70 * 4 + 3 * trailer;
        assert_eq!(copied, RankMemory { messages: sent + taken, ..memory });
        assert_eq!(messages.total(), (2 + 2 + 1, 2 * 8 + 390 + 138 + 322 + 5 * trailer));
    }
}
