//! The stages of a frame of ranks, charged.

use serde::Serialize;

use super::rates::Rates;
use super::wires::{Reach, Wires};

/// Predicted seconds of a frame; their sum is its time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Terms {
    /// Dividing the picture, testing clusters and sorting them into tiles, and the time until a rank's threads have woken up.
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
    pub wires: Wires,
    /// Seconds in which the threads of a rank do a second's work of one thread, while no other rank needs their processors.
    pub share: f64,
    /// Processors of all ranks together.
    pub processors: f64,
    /// Seconds until the other threads of a rank take part in a frame.
    pub waking: f64,
}

impl Stage<'_> {
    /// Seconds of work that ranks do at the same time, each with its threads. If there are more threads than processors, all ranks
    /// that still have work get the same share of them; those with the most work are alone in the end.
    pub fn work(&self, of_ranks: impl Iterator<Item = f64>) -> f64 {
        let mut works: Vec<f64> = of_ranks.collect();
        if self.slowdown(works.len() as f64) <= self.share {
            // Nobody waits for a processor: the one with the most work is the last.
            return works.into_iter().fold(0.0, f64::max) * self.share;
        }
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
        self.share.max(ranks / self.processors)
    }

    /// Seconds that work takes longer because threads have to wake up first: it takes so many seconds when they are awake, and never
    /// more than one thread needs alone.
    pub fn waking(&self, seconds: f64) -> f64 {
        self.waking.min(seconds * (1.0 / self.share - 1.0)).max(0.0)
    }

    /// Seconds of work that this many ranks share evenly.
    pub fn evenly(&self, work: f64, ranks: usize) -> f64 {
        let ranks = ranks.max(1) as f64;
        work / ranks * self.slowdown(ranks)
    }

    /// Seconds of an exchange: its work, the bytes through the busiest ports, and a latency.
    pub fn exchange(&self, loads: &[Load], reach: Reach) -> f64 {
        if loads.iter().all(|load| load.messages == 0.0) {
            return 0.0;
        }
        let busy = self.wires.busy(reach);
        let work = self.work(loads.iter().map(|load| load.work + load.messages * busy));
        work + self.wires.ports(loads, reach) + self.wires.latency(reach)
    }

    /// Seconds in which messages of all other ranks reach the first, one after another, without its work on what is in them.
    pub fn to_the_first(&self, sent: &Sums, ranks: usize) -> f64 {
        if sent.messages == 0.0 {
            return 0.0;
        }
        let all = Reach { within: ranks, stride: 1 };
        let into = Load { into: sent.bytes, ..Load::default() };
        let wires = &self.wires;
        sent.messages * wires.busy(all) + wires.latency(all) + wires.ports(&[into], all)
    }

    /// The same if this many ranks of so many, scattered evenly among them, have the same load.
    pub fn exchange_evenly(&self, load: &Load, (ranks, of): (usize, usize), reach: Reach) -> f64 {
        let ports = self.wires.ports_evenly(load.out.max(load.into), (ranks, of), reach);
        let work = load.work + load.messages * self.wires.busy(reach);
        self.evenly(work * ranks as f64, ranks) + ports + self.wires.latency(reach)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machines;
    use crate::predict::choose::network::Network;

    #[test]
    fn ranks_share_processors_until_they_are_done() {
        let machine = machines::load(crate::predict::choose::MACHINE).expect("built in");
        let settings = tercio_raster::Settings::new(8, 8);
        let rates = &Rates::of(&machine, &settings, false);
        let network = Network::in_process(&machine).expect("it has a network");
        let seconds = |threads: f64, processors: f64, works: &[f64]| {
            let share = 1.0 / threads.min(processors);
            let stage = Stage { rates, wires: network.into(), share, processors, waking: 0.0 };
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
        // As many processors as threads, and so few more ranks than processors that it makes no difference.
        let works: Vec<f64> = (1..100u32).map(|k| f64::from(k * 37 % 101)).collect();
        let (enough, almost) = (seconds(1.0, 99.0, &works), seconds(1.0, 99.0 * (1.0 - 1e-12), &works));
        assert!((enough / almost - 1.0).abs() < 1e-9 && enough == 100.0, "{enough} {almost}");
        // Threads of a rank divide its work.
        near(seconds(2.0, 4.0, &[4.0, 2.0]), 2.0);
        near(seconds(4.0, 2.0, &[4.0]), 2.0);
        let stage = Stage { rates, wires: network.into(), share: 0.5, processors: 3.0, waking: 0.25 };
        near(stage.evenly(6.0, 3), seconds(2.0, 3.0, &[2.0; 3]));
        // Two threads that work for a second save one; for a tenth of a second, only so much.
        near(stage.waking(1.0), 0.25);
        near(stage.waking(0.1), 0.1);
        near(Stage { share: 1.0, ..stage }.waking(1.0), 0.0);
    }
}
