//! Counts and times of every rank.

use std::time::Instant;

use serde::{Deserialize, Serialize};
use tercio_raster::stats::{BackEndCounts, FrontEndCounts, StageTimes};
use tercio_raster::{FrameStats, Settings};

use crate::comm::{Kind, PartnerTraffic, Traffic};
use crate::composite::{Composition, Encoding};
use crate::division::{ClusterDivision, Division};
use crate::organisation::{Organisation, Sharing};
use crate::trace::{Span, Step, Timeline, now};

/// A stage of a rank's work.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Stage {
    /// Wall time in milliseconds.
    pub milliseconds: f64,
    /// Processor time in milliseconds of the rank's thread (while it draws, of one of its threads): what the stage
    /// takes if ranks do not share processors. If the system does not report it, wall time.
    pub busy_milliseconds: f64,
    /// When its parts ran, if that is recorded.
    #[serde(skip)]
    spans: Option<Vec<Span>>,
}

impl Stage {
    /// Runs a part of the stage, and adds its time.
    pub fn time<T>(&mut self, work: impl FnOnce() -> T) -> T {
        let begin_of_span = self.spans.is_some().then(now);
        let (begin, busy) = (Instant::now(), busy_milliseconds());
        let result = work();
        let wall = begin.elapsed().as_secs_f64() * 1e3;
        self.milliseconds += wall;
        self.busy_milliseconds += match (busy, busy_milliseconds()) {
            (Some(before), Some(after)) => after - before,
            _ => wall,
        };
        if let (Some(spans), Some(begin)) = (&mut self.spans, begin_of_span) {
            spans.push(Span::since(begin));
        }
        result
    }

    fn recording() -> Self {
        Self { spans: Some(Vec::new()), ..Self::default() }
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

/// The stages of a rank.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct RankStages {
    /// Drawing its share: front end and back end.
    pub draw: Stage,
    /// Dividing the picture; writing bins for other ranks of its group, and reading those from them.
    pub redistribute: Stage,
    /// Packing pixels for other owners, and merging those from other ranks.
    pub compose: Stage,
    /// Packing finished pixels for rank 0; there, unpacking them.
    pub collect: Stage,
    /// Waiting for messages.
    pub wait: Stage,
    /// The front end, whose times are in those of drawing, too.
    #[serde(skip)]
    pub(crate) front_end: Stage,
}

impl RankStages {
    /// Stages that record when their parts run.
    pub(crate) fn recording() -> Self {
        Self {
            draw: Stage::recording(),
            redistribute: Stage::recording(),
            compose: Stage::recording(),
            collect: Stage::recording(),
            wait: Stage::recording(),
            front_end: Stage::recording(),
        }
    }

    /// Moves what was recorded of a frame into a timeline.
    pub(crate) fn record(&mut self, frame: u32, timeline: &mut Timeline) {
        let stages = [
            (Step::FrontEnd, &mut self.front_end),
            (Step::Draw, &mut self.draw),
            (Step::Redistribute, &mut self.redistribute),
            (Step::Composite, &mut self.compose),
            (Step::Collect, &mut self.collect),
            (Step::Wait, &mut self.wait),
        ];
        for (step, stage) in stages {
            stage.spans.take().into_iter().flatten().for_each(|span| timeline.add(step, frame, span));
        }
    }
}

/// Counts of a rank's pixels. If pixels have several samples, or layers, fragments are composited instead of pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct RankPixels {
    /// Sent to other ranks with their keys.
    pub sent: u64,
    /// Received from other ranks with their keys.
    pub compared: u64,
    /// Those of them that were nearer than what this rank had.
    pub won: u64,
    /// Bytes of fragments sent to other ranks.
    pub fragment_bytes: u64,
    /// Drawn pixels of the tiles that this rank finished.
    pub visible: u64,
}

/// Report of one rank for a frame.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct RankReport {
    /// The rank.
    pub rank: usize,
    /// Clusters that it had to test.
    pub clusters: u64,
    /// Counts and times of its renderer; all zero if it had nothing to draw.
    pub frame: FrameStats,
    /// Bytes of bins sent to other ranks of its group.
    pub bin_bytes: u64,
    /// Bytes of clusters sent to other ranks of its group; only if models are in parts and the group has other ranks.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cluster_bytes: Option<u64>,
    /// Clusters that migrated: these were sent to other ranks of its group, each to as many as need it and do not have it. There where
    /// [`Self::cluster_bytes`] is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub clusters_sent: Option<u64>,
    /// Clusters that were not sent to other ranks of its group, because these have them since the last frame.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub clusters_kept: Option<u64>,
    /// Counts of pixels.
    pub pixels: RankPixels,
    /// Counts of messages.
    pub traffic: Traffic,
    /// The same by the other rank and by what messages are for, with those of agreement, barriers and the report itself,
    /// which [`Self::traffic`] does not count; in the order of ranks, then of kinds. Empty where only earlier frames than the
    /// last one are meant, where [`Rank::tell_partners`](crate::organisation::Rank::tell_partners) is off, and for one rank. The farewell at the end of a job, an empty message to each other process, is not
    /// in it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub partners: Vec<PartnerTraffic>,
    /// Times.
    pub stages: RankStages,
}

impl RankReport {
    /// Adds counts of other messages.
    pub(crate) fn add_partners(&mut self, others: impl IntoIterator<Item = PartnerTraffic>) {
        self.partners.extend(others);
        self.partners.sort_by_key(|with| (with.partner, with.kind));
    }
}

/// Report of all ranks for a frame.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct FrameReport {
    /// Where they redistributed work.
    pub organisation: Organisation,
    /// Ranks of a group of sort-twice.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub group: Option<usize>,
    /// How tiles were divided, if ranks shared the picture.
    pub division: Option<Division>,
    /// How pixels were composited, if they were.
    pub composition: Option<Composition>,
    /// Which pixels were sent to be composited.
    pub encoding: Option<Encoding>,
    /// How clusters were divided among ranks that composite; `None` if nothing is composited, or
    /// ranks have parts of the model.
    pub clusters: Option<ClusterDivision>,
    /// Pixels along the edge of a tile.
    pub region: u32,
    /// Milliseconds from the beginning of the first rank until the picture was complete on rank 0.
    pub milliseconds: f64,
    /// Messages between ranks.
    pub messages: u64,
    /// Their bytes.
    pub bytes: u64,
    /// Every rank, in order.
    pub ranks: Vec<RankReport>,
    /// Samples per pixel.
    pub samples: u64,
}

impl FrameReport {
    /// The report of the frame, with tiles of this edge, from those of the ranks.
    pub fn new(
        sharing: Sharing,
        region: u32,
        settings: &Settings,
        milliseconds: f64,
        ranks: Vec<RankReport>,
    ) -> Self {
        let samples = settings.sampling.pattern.count() as u64;
        let messages = ranks.iter().map(|r| r.traffic.sent_messages).sum();
        let bytes = ranks.iter().map(|r| r.traffic.sent_bytes).sum();
        let Sharing { organisation, division, composition, encoding, clusters } = sharing;
        let count = ranks.len();
        let in_parts = ranks.iter().any(|rank| rank.cluster_bytes.is_some());
        let group = matches!(organisation, Organisation::SortTwice { .. }).then(|| organisation.group(count));
        let division = (organisation.group(count) > 1).then_some(division);
        let composites = organisation.composites(count);
        let (composition, encoding) = (composites.then_some(composition), composites.then_some(encoding));
        Self {
            organisation,
            group,
            division,
            composition,
            encoding,
            clusters: (composites && !in_parts).then_some(clusters),
            region,
            milliseconds,
            messages,
            bytes,
            ranks,
            samples,
        }
    }

    /// Number of drawn pixels in the picture.
    pub fn pixels_visible(&self) -> u64 {
        self.ranks.iter().map(|r| r.pixels.visible).sum()
    }

    /// Messages that were sent, and their bytes, by what they are for, in the order of a frame; without kinds that were not
    /// sent. Empty without [`RankReport::partners`].
    pub fn by_kind(&self) -> Vec<(Kind, Traffic)> {
        let mut all = Kind::ALL.map(|kind| (kind, Traffic::default()));
        for with in self.ranks.iter().flat_map(|rank| &rank.partners) {
            let (_, sum) = &mut all[with.kind.number() as usize];
            *sum = sum.plus(with.traffic);
        }
        all.into_iter().filter(|(_, sum)| *sum != Traffic::default()).collect()
    }

    /// The statistics as if one renderer had drawn the frame: the work of all ranks, visible pixels counted once. In
    /// sort-first every rank tests every cluster, so the counts of the front end are rank 0's, unless models are in parts. Bins are those of rank
    /// 0. The times of front end and back end are those of the slowest rank.
    pub fn stats(&self) -> FrameStats {
        let Some(first) = self.ranks.first() else { return FrameStats::default() };
        let mut stats = first.frame.clone();
        if self.organisation != Organisation::SortFirst || first.cluster_bytes.is_some() {
            let counts = self.ranks.iter().map(|r| r.frame.frontend);
            stats.frontend = counts.fold(FrontEndCounts::default(), FrontEndCounts::plus);
        }
        let counts = self.ranks.iter().map(|r| r.frame.backend);
        let mut sum = counts.fold(BackEndCounts::default(), BackEndCounts::plus);
        sum.pixels_visible = self.pixels_visible();
        stats.backend = sum.finish(self.samples);
        let slowest = |of: fn(&StageTimes) -> f64| {
            self.ranks.iter().map(|r| of(&r.frame.milliseconds)).fold(0.0, f64::max)
        };
        stats.milliseconds.frontend = slowest(|times| times.frontend);
        stats.milliseconds.backend = slowest(|times| times.backend);
        stats.milliseconds.total = self.milliseconds;
        stats.threads = self.ranks.iter().map(|r| r.frame.threads).sum();
        stats
    }
}
