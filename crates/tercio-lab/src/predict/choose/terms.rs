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
    /// Seconds of work that ranks do at the same time: those of the busiest one, or of all on all processors.
    pub fn work(&self, of_ranks: impl Iterator<Item = f64>) -> f64 {
        let (most, sum) = of_ranks.fold((0.0f64, 0.0), |(most, sum), work| (most.max(work), sum + work));
        (most / self.threads.min(self.processors)).max(sum / self.processors)
    }

    /// Seconds of work that this many ranks share evenly.
    pub fn evenly(&self, work: f64, ranks: usize) -> f64 {
        let ranks = ranks.max(1) as f64;
        (work / ranks / self.threads.min(self.processors)).max(work / self.processors)
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
