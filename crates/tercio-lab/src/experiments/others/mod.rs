//! Published scalings of others, predicted by the formulas behind `--organisation auto` and `tercio lab advise`.
//!
//! Only compositing and delivery are predicted: how long others draw is not known. Their pictures are lost, too, so the ranks of a
//! [`Job`] all have the same share of the picture, evenly distributed. What a pixel costs on their processors, and how many bytes it
//! has, is nowhere published where we looked: both are swept.

pub(super) mod frames;
pub(super) mod megapixels;
pub(super) mod radix_k;

use tercio_parallel::Composition;
use tercio_raster::Settings;

use super::ExperimentError;
use crate::machines::{Machine, builtin};
use crate::predict::choose::compose::{SharedTile, SharedTiles};
use crate::predict::choose::rates::Rates;
use crate::predict::choose::terms::{Stage, Sums};
use crate::predict::choose::wires::Wires;

const MEGAPIXEL: f64 = (1u32 << 20) as f64;
/// Radices that are tried; the fastest counts.
const RADICES: [u32; 6] = [4, 8, 16, 32, 64, 128];
/// Bytes of a pixel: four colour components of a byte, or of a `f32`.
const BYTES: [f64; 2] = [4.0, 16.0];

/// A built-in machine.
fn machine(name: &str) -> Result<Machine, ExperimentError> {
    Ok(builtin(name).ok_or_else(|| format!("there is no machine '{name}'"))??)
}

/// Ranks on a machine.
#[derive(Clone, Copy, Debug)]
struct Job<'a> {
    machine: &'a Machine,
    ranks: usize,
    threads: usize,
    wires: Wires,
}

/// A picture of which all ranks have as much, and what a pixel of it costs.
#[derive(Clone, Copy, Debug)]
struct Shared {
    /// Pixels.
    pixels: f64,
    /// The share of them that each rank has.
    share: f64,
    /// Bytes of a pixel in a message.
    bytes: f64,
    /// Seconds in which a thread blends a pixel of a message into its own, packing included.
    blend: f64,
}

impl<'a> Job<'a> {
    fn new(machine: &'a Machine, ranks: usize, threads: usize) -> Result<Self, ExperimentError> {
        // The shape is given, so that messages are never those between threads of one process.
        let topology = machine.need(machine.network.as_ref(), "network")?.topology;
        let wires = Wires::of(machine, Some(topology), ranks, threads)?;
        Ok(Self { machine, ranks, threads, wires })
    }

    fn rates(&self, of: &Shared) -> Rates {
        let rates = Rates::of(self.machine, &Settings::one_sample(1, 1), false);
        // Copying is part of what a blended pixel costs.
        Rates { merged: of.blend, byte: 0.0, composited_bytes: of.bytes, ..rates }
    }

    fn stage<'r>(&self, rates: &'r Rates) -> Stage<'r> {
        let (ranks, threads) = (self.ranks as f64, self.threads as f64);
        Stage { rates, wires: self.wires, share: 1.0 / threads, processors: ranks * threads, waking: 0.0 }
    }

    /// Seconds of compositing.
    fn composite(&self, of: &Shared, composition: Composition) -> f64 {
        let ranks = self.ranks as f64;
        let has = of.share * of.pixels;
        let sum = ranks * has;
        // The whole picture is one tile: all parts of it have as much.
        let tile = SharedTile { ranks: ranks * of.share, sum, merged: of.pixels.min(sum) };
        let others = 1.0 - 1.0 / ranks;
        let shared = SharedTiles {
            tiles: vec![tile],
            // Direct send: as many owners as have that share of the picture.
            of_rank: vec![[has, (ranks * of.share).max(1.0)]; self.ranks],
            direct: vec![[has * others, has * others, has]; self.ranks],
            partners: ranks - 1.0,
            apart: 1,
        };
        let rates = self.rates(of);
        shared.composite(composition, &self.stage(&rates), &mut 0).seconds
    }

    /// The fastest radix, and its seconds.
    fn radix_k(&self, of: &Shared) -> (u32, f64) {
        let all = RADICES.map(|radix| (radix, self.composite(of, Composition::radix_k(radix))));
        all.into_iter().fold((0, f64::INFINITY), |best, one| if one.1 < best.1 { one } else { best })
    }

    /// Seconds in which the picture, evenly distributed among all ranks, comes to one of them.
    fn deliver(&self, pixels: f64, bytes: f64) -> f64 {
        let others = (self.ranks - 1) as f64;
        let sent = Sums { messages: others, bytes: pixels * bytes * others / self.ranks as f64 };
        let rates = self.rates(&Shared { pixels, share: 1.0, bytes, blend: 0.0 });
        self.stage(&rates).to_the_first(&sent, self.ranks)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machines::Topology;

    /// A rank a node, one link each, no latency: closed formulas of the strategies.
    fn plain() -> Machine {
        let mut machine = machine("slic-cluster").unwrap();
        for network in [machine.network.as_mut().unwrap(), machine.node.as_mut().unwrap()] {
            (network.message.value, network.hop.value) = (0.0, 0.0);
            network.topology = Topology::Crossbar;
        }
        machine
    }

    #[test]
    fn full_pictures_take_what_the_closed_formulas_say() {
        let machine = plain();
        let of = Shared { pixels: MEGAPIXEL, share: 1.0, bytes: 4.0, blend: 3e-9 };
        for ranks in [2usize, 8, 64] {
            let job = Job::new(&machine, ranks, 1).unwrap();
            // Each rank sends and blends all pixels but those that it keeps, whatever the radix.
            let pixels = MEGAPIXEL * (1.0 - 1.0 / ranks as f64);
            let expected = pixels * (4.0 / 12.5e6 + 3e-9);
            for composition in [Composition::BinarySwap, Composition::radix_k(8)] {
                let seconds = job.composite(&of, composition);
                assert!(
                    (seconds / expected - 1.0).abs() < 1e-9,
                    "{ranks} {composition:?} {seconds} {expected}"
                );
            }
            // In a tree of the same ranks the first receives the whole picture in each round.
            let rounds = f64::from(ranks.ilog2());
            let tree = rounds * MEGAPIXEL * (4.0 / 12.5e6 + 3e-9);
            let seconds = job.composite(&of, Composition::Tree);
            assert!((seconds / tree - 1.0).abs() < 1e-9, "{ranks} {seconds} {tree}");
            let delivered = job.deliver(MEGAPIXEL, 4.0);
            assert!((delivered / (pixels * 4.0 / 12.5e6) - 1.0).abs() < 1e-9, "{delivered}");
        }
    }

    #[test]
    fn messages_without_pixels_cost_their_rounds() {
        let mut machine = plain();
        machine.network.as_mut().unwrap().message.value = 1.0;
        let job = Job::new(&machine, 64, 1).unwrap();
        let of = Shared { pixels: 1e-9, share: 1.0, bytes: 4.0, blend: 0.0 };
        // Six rounds of a message, whose second is that of the sender and that of the wire.
        let swap = job.composite(&of, Composition::BinarySwap);
        assert!((swap - 12.0).abs() < 1e-6, "{swap}");
        // Two rounds of seven.
        let radix = job.composite(&of, Composition::radix_k(8));
        assert!((radix - 2.0 * (7.0 + 1.0)).abs() < 1e-6, "{radix}");
    }

    #[test]
    fn sparse_pictures_grow_until_they_cover_everything() {
        let machine = plain();
        let job = Job::new(&machine, 64, 1).unwrap();
        let of = |share| Shared { pixels: MEGAPIXEL, share, bytes: 4.0, blend: 0.0 };
        let seconds = |share| job.composite(&of(share), Composition::BinarySwap);
        // A picture of which each rank has 1/64, none twice, costs six rounds of half of what a rank has.
        let expected = 6.0 * MEGAPIXEL / 64.0 / 2.0 * 4.0 / 12.5e6;
        assert!((seconds(1.0 / 64.0) / expected - 1.0).abs() < 1e-9);
        assert!(seconds(1.0 / 64.0) < seconds(0.1) && seconds(0.1) < seconds(1.0));
    }
}
