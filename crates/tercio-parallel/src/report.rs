//! What every rank did, counted and timed.

use std::time::Instant;

use serde::{Deserialize, Serialize};
use tercio_raster::FrameStats;
use tercio_raster::stats::{BackEndCounts, FrontEndCounts};

use crate::comm::Traffic;
use crate::organisation::Organisation;

/// A stage of a rank's work.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Stage {
    /// Milliseconds from its beginning to its end.
    pub milliseconds: f64,
    /// Milliseconds of processor time of the rank's thread (while it draws, of one of its threads): what the stage
    /// takes where ranks do not share processors. Where the system does not tell, as above.
    pub busy_milliseconds: f64,
}

impl Stage {
    /// Does a part of the stage, and times it.
    pub fn time<T>(&mut self, work: impl FnOnce() -> T) -> T {
        let (begin, busy) = (Instant::now(), busy_milliseconds());
        let result = work();
        let wall = begin.elapsed().as_secs_f64() * 1e3;
        self.milliseconds += wall;
        self.busy_milliseconds += match (busy, busy_milliseconds()) {
            (Some(before), Some(after)) => after - before,
            _ => wall,
        };
        result
    }
}

/// Processor time of this thread.
fn busy_milliseconds() -> Option<f64> {
    #[cfg(unix)]
    {
        let t = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
        Some(t.tv_sec as f64 * 1e3 + t.tv_nsec as f64 * 1e-6)
    }
    #[cfg(not(unix))]
    None
}

/// The stages of a rank, in their order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct RankStages {
    /// Drawing its share.
    pub draw: Stage,
    /// Packing pixels for other owners, and composing what came from other ranks.
    pub compose: Stage,
    /// Packing finished pixels for rank 0; there, unpacking them.
    pub collect: Stage,
    /// Waiting for messages.
    pub wait: Stage,
}

/// Pixels of a rank, by what happened to them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct RankPixels {
    /// Sent to other owners with their keys.
    pub sent: u64,
    /// Came from other ranks and were compared.
    pub compared: u64,
    /// Those of them that were nearer than what stood there.
    pub won: u64,
    /// Pixels of the own regions that show something in the end.
    pub visible: u64,
}

/// What one rank did for a frame.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct RankReport {
    /// Which.
    pub rank: usize,
    /// Clusters that it had to look at.
    pub clusters: u64,
    /// What its renderer did; all zero where it had nothing to draw.
    pub frame: FrameStats,
    /// Pixels.
    pub pixels: RankPixels,
    /// Messages.
    pub traffic: Traffic,
    /// Times.
    pub stages: RankStages,
}

/// What all ranks did for a frame.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct FrameReport {
    /// How they shared it.
    pub organisation: Organisation,
    /// Pixels along the edge of a region.
    pub region: u32,
    /// Milliseconds from when the first rank began until the picture was whole, on rank 0.
    pub milliseconds: f64,
    /// Messages between ranks.
    pub messages: u64,
    /// Their bytes.
    pub bytes: u64,
    /// Every rank, in order.
    pub ranks: Vec<RankReport>,
}

impl FrameReport {
    /// Of the ranks' reports.
    pub fn new(organisation: Organisation, region: u32, milliseconds: f64, ranks: Vec<RankReport>) -> Self {
        let messages = ranks.iter().map(|r| r.traffic.sent_messages).sum();
        let bytes = ranks.iter().map(|r| r.traffic.sent_bytes).sum();
        Self { organisation, region, milliseconds, messages, bytes, ranks }
    }

    /// Pixels of the picture that show something.
    pub fn pixels_visible(&self) -> u64 {
        self.ranks.iter().map(|r| r.pixels.visible).sum()
    }

    /// The frame as if one renderer had drawn it: the work of all ranks, visible pixels counted once. Sort-first has
    /// every rank look at every cluster; there what the front end met is told by rank 0 alone. Bins are those of
    /// rank 0.
    pub fn stats(&self) -> FrameStats {
        let Some(first) = self.ranks.first() else { return FrameStats::default() };
        let mut stats = first.frame.clone();
        if self.organisation == Organisation::SortLast {
            let counts = self.ranks.iter().map(|r| r.frame.frontend);
            stats.frontend = counts.fold(FrontEndCounts::default(), FrontEndCounts::plus);
        }
        let counts = self.ranks.iter().map(|r| r.frame.backend);
        let mut sum = counts.fold(BackEndCounts::default(), BackEndCounts::plus);
        sum.pixels_visible = self.pixels_visible();
        stats.backend = sum.finish();
        stats.milliseconds.total = self.milliseconds;
        stats.threads = self.ranks.iter().map(|r| r.frame.threads).sum();
        stats
    }
}
