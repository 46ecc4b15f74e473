//! The stages of a frame of ranks, charged.

use serde::Serialize;

use super::network::{Network, Source};
use super::rates::Rates;

/// Seconds of a message of which the processor is busy, at most.
const BUSY: f64 = 2e-6;

/// Predicted seconds of a frame; their sum is its time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Terms {
    /// Dividing the picture, testing clusters and sorting them into tiles.
    pub front_end: f64,
    /// Sending bins to the owners of tiles, and telling others which tiles are touched.
    pub exchange: f64,
    /// Drawing tiles.
    pub draw: f64,
    /// Compositing.
    pub composite: f64,
    /// Bringing finished pixels to rank 0.
    pub collect: f64,
}

impl Terms {
    /// The whole frame.
    pub fn total(&self) -> f64 {
        self.front_end + self.exchange + self.draw + self.composite + self.collect
    }
}

/// Messages and bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Sums {
    /// Messages.
    pub messages: f64,
    /// Bytes.
    pub bytes: f64,
}

impl Sums {
    /// Those that ranks send.
    pub fn of(loads: &[Load]) -> Self {
        let sum = |of: fn(&Load) -> f64| loads.iter().map(of).sum();
        Self { messages: sum(|load| load.messages), bytes: sum(|load| load.out) }
    }
}

/// What a rank does in an exchange.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Load {
    /// Messages that it sends, and about as many that it receives.
    pub messages: f64,
    /// Bytes that it sends.
    pub out: f64,
    /// Bytes that it receives.
    pub into: f64,
    /// Seconds of work on one thread.
    pub work: f64,
}

/// On what the stages run.
#[derive(Clone, Copy, Debug)]
pub struct Stage<'a> {
    /// Costs of work.
    pub rates: &'a Rates,
    /// Costs of messages.
    pub network: Network,
    /// Threads of each rank.
    pub threads: f64,
    /// Processors of all ranks together.
    pub processors: f64,
}

impl Stage<'_> {
    /// Seconds of work that ranks do at the same time, each with its threads. If there are more threads than processors, all ranks
    /// that still have work get the same share of them; those with the most work are alone in the end.
    pub fn work(&self, of_ranks: impl Iterator<Item = f64>) -> f64 {
        let mut works: Vec<f64> = of_ranks.collect();
        works.sort_unstable_by(f64::total_cmp);
        let (mut seconds, mut done, mut left) = (0.0, 0.0, works.len() as f64);
        for work in works {
            seconds += (work - done) * self.slowdown(left);
            (done, left) = (work, left - 1.0);
        }
        seconds
    }

    /// Seconds for a second of work on one thread, while this many ranks work.
    fn slowdown(&self, ranks: f64) -> f64 {
        (1.0 / self.threads.min(self.processors)).max(ranks / self.processors)
    }

    /// Seconds of work that this many ranks share evenly.
    pub fn evenly(&self, work: f64, ranks: usize) -> f64 {
        let ranks = ranks.max(1) as f64;
        work / ranks * self.slowdown(ranks)
    }

    /// Seconds of an exchange: its work, the bytes through the ports of the busiest rank, and a latency.
    pub fn exchange(&self, loads: &[Load]) -> f64 {
        let most = |of: fn(&Load) -> f64| loads.iter().map(of).fold(0.0, f64::max);
        if most(|load| load.messages) == 0.0 {
            return 0.0;
        }
        let port = most(|load| load.out.max(load.into)) / self.network.bandwidth;
        let work = self.work(loads.iter().map(|load| load.work + load.messages * self.busy()));
        work + port + self.latency()
    }

    /// The same if this many ranks have the same load.
    pub fn exchange_evenly(&self, load: &Load, ranks: usize) -> f64 {
        let port = load.out.max(load.into) / self.network.bandwidth;
        self.evenly((load.work + load.messages * self.busy()) * ranks as f64, ranks) + port + self.latency()
    }

    /// Seconds of a small message.
    pub fn latency(&self) -> f64 {
        self.network.latency
    }

    /// Processor time of a message. Between threads of a process that is all of it.
    pub fn busy(&self) -> f64 {
        match self.network.source {
            Source::Constants => self.network.latency,
            Source::Measured { .. } => self.network.latency.min(BUSY),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machines;

    #[test]
    fn ranks_share_processors_until_they_are_done() {
        let machine = machines::load(crate::predict::choose::MACHINE).expect("built in");
        let settings = tercio_raster::Settings::new(8, 8);
        let rates = &Rates::of(&machine, &settings, false);
        let network = Network::in_process(&machine).expect("it has a network");
        let seconds = |threads: f64, processors: f64, works: &[f64]| {
            let stage = Stage { rates, network, threads, processors };
            stage.work(works.iter().copied())
        };
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} {b}");
        // As many processors as ranks: the busiest one.
        near(seconds(1.0, 4.0, &[3.0, 1.0, 2.0, 0.5]), 3.0);
        near(seconds(1.0, 99.0, &[3.0, 1.0]), 3.0);
        // One processor: all work.
        near(seconds(1.0, 1.0, &[3.0, 1.0, 2.0]), 6.0);
        // Two: even work is divided, the last rank is alone with what it has more.
        near(seconds(1.0, 2.0, &[1.0; 6]), 3.0);
        near(seconds(1.0, 2.0, &[1.0, 1.0, 1.0, 5.0]), 2.0 + 4.0);
        // Threads of a rank divide its work.
        near(seconds(2.0, 4.0, &[4.0, 2.0]), 2.0);
        near(seconds(4.0, 2.0, &[4.0]), 2.0);
        let stage = Stage { rates, network, threads: 2.0, processors: 3.0 };
        near(stage.evenly(6.0, 3), seconds(2.0, 3.0, &[2.0; 3]));
    }
}
