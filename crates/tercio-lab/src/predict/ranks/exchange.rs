//! The work of ranks besides drawing, and its costs: keys, packing, compositing, collecting.

use serde::Serialize;

use super::traffic::{Messages, Pixels, Sharing};
use crate::machines::{Machine, MachineError, Operation};
use crate::predict::counts::Counters;
use tercio_parallel::Organisation;

/// Bytes of a line of memory, of a key and of a colour.
const LINE: f64 = 64.0;
const KEY: f64 = 8.0;
const COLOR: f64 = 4.0;

/// The share of a cache that is available to pictures and messages; the model, the bins and other programs take the
/// rest. On the machine of `docs/laboratory/ranks.md` scanning a picture of half the nominal size takes halfway between
/// the times for a picture in cache and one in memory.
const CACHE_SHARE: f64 = 0.5;

/// Kinds of work that are charged.
pub const KINDS: usize = 10;

/// How often each kind of work is done, or its costs, in the order of [`OPERATIONS`].
pub type Charges = [f64; KINDS];

/// The kinds of work: keys while drawing first, then the exchange.
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
];

/// Seconds of each kind of work.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ExchangeCosts(pub Charges);

impl ExchangeCosts {
    /// Whether a description has costs of ranks.
    pub fn are_known(machine: &Machine) -> bool {
        OPERATIONS.iter().any(|&o| machine.seconds(o).is_some())
    }

    /// The costs of a description. Costs that a fit made zero are omitted there, so a missing one is zero.
    ///
    /// # Errors
    /// [`MachineError::Missing`] if it has none at all.
    pub fn of(machine: &Machine) -> Result<Self, MachineError> {
        let known = Self::are_known(machine).then_some(&());
        machine.need(known, "costs.scanned-pixel")?;
        Ok(Self(OPERATIONS.map(|o| machine.seconds_or_0(o))))
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
    owned: Vec<u64>,
    /// Whether the receiver of a message has a copy of its own.
    copied: bool,
    /// The share of the lines of pictures and messages that no cache holds.
    missed: f64,
}

impl<'a> Exchange<'a> {
    /// `together` ranks share a memory, with a cache of `cache` bytes. Messages are `copied`, or their memory is handed
    /// over.
    pub fn new(
        sharing: &'a Sharing,
        messages: &'a Messages,
        drawing: &'a [Counters],
        (together, cache): (usize, f64),
        copied: bool,
    ) -> Self {
        let owned = sharing.owned();
        let mut exchange = Self { sharing, messages, drawing, owned, copied, missed: 0.0 };
        let bytes: u64 = (0..sharing.ranks).map(|rank| exchange.memory(rank).total()).sum();
        let share = together.clamp(1, sharing.ranks) as f64 / sharing.ranks as f64;
        exchange.missed = missed(bytes as f64 * share, cache);
        exchange
    }

    /// Memory of a rank.
    pub fn memory(&self, rank: usize) -> RankMemory {
        let drawn = &self.drawing[rank];
        // Rank 0 has the whole picture in the end; a rank of sort-last draws anywhere in it.
        let pixels = match self.sharing.organisation {
            Organisation::SortFirst if rank > 0 => drawn.pixels,
            _ if rank > 0 && drawn.pixels == 0 => 0,
            _ => self.sharing.pixels(),
        };
        RankMemory {
            picture: pixels * (KEY + COLOR) as u64,
            messages: self.messages.counts(rank).bytes
                + if self.copied { self.messages.bytes_taken(rank) } else { 0 },
            model: drawn.bytes_touched,
        }
    }

    /// Keys while a rank draws.
    pub fn keys(&self, rank: usize) -> Charges {
        keys(&self.drawing[rank], self.missed)
    }

    /// Packing what a rank sends to another for compositing. `None` if it sends nothing.
    pub fn packing(&self, from: usize, to: usize) -> Option<Charges> {
        let pixels = self.messages.between(from, to)?;
        Some(self.packed(pixels, self.owned[to], true))
    }

    /// Compositing what a rank receives from another. `None` if it receives nothing.
    pub fn composing(&self, from: usize, rank: usize) -> Option<Charges> {
        Some(self.unpacked(self.messages.between(from, rank)?, true))
    }

    /// An owner's part of collecting the finished pixels: others pack them; rank 0 scans its own, and clears the pixels
    /// of its picture in which the other owners drew nothing.
    pub fn finishing(&self, rank: usize) -> Charges {
        if rank > 0 {
            return self.packed(self.messages.finished[rank], self.owned[rank], false);
        }
        let own = self.owned[0] as f64;
        let cleared = match self.sharing.organisation {
            Organisation::SortFirst => self.sharing.pixels() as f64 - own,
            _ => 0.0,
        };
        let mut charges = [0.0; KINDS];
        charges[3] = own;
        charges[8] = cleared;
        charges[9] = (own * KEY + cleared * (KEY + COLOR)) / LINE * self.missed;
        charges
    }

    /// Rank 0 puts an owner's pixels into the picture.
    pub fn collecting(&self, from: usize) -> Charges {
        self.unpacked(self.messages.finished[from], false)
    }

    fn packed(&self, sent: Pixels, scanned: u64, keys: bool) -> Charges {
        let (samples, scanned) = (samples(sent, keys), scanned as f64);
        let mut charges = [0.0; KINDS];
        charges[3] = scanned;
        charges[4] = sent.spans as f64;
        charges[5] = samples;
        let colors = sent.pixels as f64 * COLOR;
        charges[9] = (scanned * KEY + colors + sent.bytes(keys) as f64) / LINE * self.missed;
        charges
    }

    fn unpacked(&self, taken: Pixels, keys: bool) -> Charges {
        let mut charges = [0.0; KINDS];
        charges[6] = taken.spans as f64;
        charges[7] = samples(taken, keys);
        let picture = taken.pixels as f64 * if keys { KEY + COLOR } else { COLOR };
        charges[9] = (taken.bytes(keys) as f64 + picture) / LINE * self.missed;
        charges
    }
}

/// Number of keys and colours sent.
fn samples(pixels: Pixels, keys: bool) -> f64 {
    pixels.pixels as f64 * if keys { 2.0 } else { 1.0 }
}

/// The share of memory, scanned repeatedly, that misses a cache.
pub fn missed(bytes: f64, cache: f64) -> f64 {
    if bytes > 0.0 { (1.0 - CACHE_SHARE * cache / bytes).max(0.0) } else { 0.0 }
}

/// The keys of a picture, or of its drawn part.
pub fn keys(drawn: &Counters, missed: f64) -> Charges {
    let pixels = drawn.pixels as f64;
    let mut charges = [0.0; KINDS];
    charges[0] = pixels;
    charges[1] = drawn.pixels_shaded as f64;
    charges[2] = pixels * KEY / LINE * missed;
    charges
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_that_fits_into_the_cache_takes_no_time() {
        assert_eq!([missed(0.0, 8.0), missed(4.0, 8.0), missed(16.0, 8.0)], [0.0, 0.0, 0.75]);
        assert_eq!(missed(1e12, f64::INFINITY), 0.0);
    }

    #[test]
    fn ranks_pack_what_others_receive() {
        let sharing = Sharing { organisation: Organisation::SortLast, ranks: 2, size: (32, 16), edge: 16 };
        let pixels = |spans, pixels| Pixels { spans, pixels };
        let messages = Messages {
            triangles: vec![1, 1],
            composed: vec![vec![None, Some(pixels(3, 30))], vec![Some(pixels(1, 10)), None]],
            finished: vec![pixels(4, 40), pixels(5, 50)],
        };
        let drawn = Counters { pixels: 512, pixels_shaded: 40, bytes_touched: 1000, ..Counters::default() };
        let drawing = [drawn; 2];
        let exchange = Exchange::new(&sharing, &messages, &drawing, (2, 0.0), false);
        assert_eq!(exchange.missed, 1.0);
        let lines = |bytes: f64| bytes / 64.0;
        // 256 pixels of the other are scanned, 30 of them are sent with key and colour.
        let packing = exchange.packing(0, 1).unwrap();
        assert_eq!(packing[3..6], [256.0, 3.0, 60.0]);
        assert_eq!(packing[9], lines(256.0 * 8.0 + 30.0 * 4.0 + 3.0 * 6.0 + 30.0 * 12.0));
        let composing = exchange.composing(0, 1).unwrap();
        assert_eq!((composing[6], composing[7]), (packing[4], packing[5]));
        assert_eq!(exchange.packing(0, 0), None);
        // Finished colours without keys.
        assert_eq!(exchange.finishing(1)[3..6], [256.0, 5.0, 50.0]);
        assert_eq!(exchange.collecting(1)[6..8], [5.0, 50.0]);
        assert_eq!((exchange.finishing(0)[3], exchange.finishing(0)[8]), (256.0, 0.0));
        assert_eq!(exchange.keys(0)[..3], [512.0, 40.0, 64.0]);
        let memory = exchange.memory(0);
        assert_eq!(memory, RankMemory { picture: 512 * 12, messages: 18 + 360, model: 1000 });
        // If messages are copied, rank 0 also has those it receives: 10 pixels with keys, 50 finished ones.
        let copied = Exchange::new(&sharing, &messages, &drawing, (2, 0.0), true).memory(0);
        assert_eq!(copied, RankMemory { messages: memory.messages + 6 + 120 + 30 + 200, ..memory });
    }
}
