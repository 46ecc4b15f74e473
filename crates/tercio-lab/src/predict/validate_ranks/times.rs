//! How long ranks take: what they do, charged with costs that were fitted to other models.

use std::sync::Arc;

use serde::Serialize;
use tercio_mesh::builtin;
use tercio_mesh::cluster::{PartitionOptions, partition};
use tercio_parallel::report::{RankStages, Stage};
use tercio_parallel::{FrameReport, Organisation};
use tercio_raster::{Outputs, Part, Settings};
use tercio_scene::{Camera, Scene};

use super::{RankCounts, RanksError, measure, predict_counts, settings};
use crate::machines::Machine;
use crate::predict::counters::{Counters, count};
use crate::predict::frame::FrameTime;
use crate::predict::measure::{Clock, measure as measure_alone};
use crate::predict::{PredictError, fit, views};
use crate::simulators::sorting::{Assignment, Regions};
use crate::workloads::PixelBox;

/// Seconds of a frame. A stage is that of its busiest rank.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct StageSeconds {
    /// Drawing.
    pub draw: f64,
    /// Packing for other owners and composing.
    pub compose: f64,
    /// Packing for rank 0, unpacking there.
    pub collect: f64,
    /// The whole frame, until rank 0 has the picture.
    pub frame: f64,
}

impl StageSeconds {
    /// Adds one of `of` views.
    pub(super) fn add(&mut self, o: Self, of: f64) {
        self.draw += o.draw / of;
        self.compose += o.compose / of;
        self.collect += o.collect / of;
        self.frame += o.frame / of;
    }

    /// The fastest of some frames. Stages by processor time; the whole frame by the clock that was asked for.
    pub(super) fn measured(reports: &[FrameReport], clock: Clock, processors: usize) -> Self {
        let ranks = reports.first().map_or(0, |r| r.ranks.len());
        let stage = |of: fn(&RankStages) -> Stage| -> Vec<f64> {
            (0..ranks).map(|rank| busy(reports, rank, of)).collect()
        };
        let stages =
            Self::of_ranks(&stage(|s| s.draw), &stage(|s| s.compose), &stage(|s| s.collect), processors);
        match clock {
            Clock::Processor => stages,
            Clock::Wall => {
                let wall = reports.iter().map(|r| r.milliseconds * 1e-3);
                Self { frame: wall.fold(f64::INFINITY, f64::min), ..stages }
            }
        }
    }

    /// From the stages of all ranks. A stage ends with its busiest rank, and not before the processors have done
    /// everybody's; rank 0 unpacks what the others have packed before.
    fn of_ranks(draw: &[f64], compose: &[f64], collect: &[f64], processors: usize) -> Self {
        let busiest = |times: &[f64]| times.iter().copied().fold(0.0, f64::max);
        let stage = |times: &[f64]| busiest(times).max(times.iter().sum::<f64>() / processors.max(1) as f64);
        let (first, others) = collect.split_at(collect.len().min(1));
        Self {
            draw: busiest(draw),
            compose: busiest(compose),
            collect: busiest(collect),
            frame: stage(draw) + stage(compose) + stage(others) + busiest(first),
        }
    }
}

/// Seconds of processor time of a rank's stage, in the fastest of some frames.
fn busy(reports: &[FrameReport], rank: usize, of: fn(&RankStages) -> Stage) -> f64 {
    let of_frame = |r: &FrameReport| of(&r.ranks[rank].stages).busy_milliseconds * 1e-3;
    reports.iter().map(of_frame).fold(f64::INFINITY, f64::min)
}

/// Seconds of what ranks do beside drawing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct RankCosts {
    /// A pixel's key, where it shows something.
    pub key: f64,
    /// Composing: a pixel of others looked at, a pixel packed, a pixel compared.
    pub compose: [f64; 3],
    /// Collecting: an own pixel looked at, a pixel packed, a pixel unpacked, a pixel of others cleared.
    pub collect: [f64; 4],
}

/// Models, sizes of pictures and ranks that the costs are fitted to.
const MODELS: [&str; 3] = ["builtin:sphere@20k", "builtin:gyroid@100k", "builtin:terrain@50k"];
const SIZES: [(u32, u32); 2] = [(800, 500), (1900, 1100)];
const RANKS: [usize; 2] = [2, 3];

impl RankCosts {
    /// Measures this machine. `frames` are drawn of each picture, of which the fastest counts.
    ///
    /// # Errors
    /// [`RanksError`].
    pub fn measure(frames: u32) -> Result<Self, RanksError> {
        let (mut more, mut shown) = (0.0, 0.0);
        let mut rows: [Vec<(Vec<f64>, f64)>; 2] = Default::default();
        for model in MODELS {
            // The names are ours; a model that cannot be made takes no part.
            let Ok(mesh) = builtin::make(model) else { continue };
            let bounds = mesh.bounds();
            let scene = views::scene(Arc::new(partition(mesh, &PartitionOptions::default())));
            for size in SIZES {
                let camera = views::camera(&bounds, size, 1, 7);
                let plain = settings(size);
                let keyed = {
                    let mut keyed = plain.clone();
                    keyed.outputs = Outputs { keys: true, ..plain.outputs };
                    keyed
                };
                let without = measure_alone(&scene, &camera, &plain, 1, frames, Clock::Processor)?;
                let with = measure_alone(&scene, &camera, &keyed, 1, frames, Clock::Processor)?;
                more += with.seconds - without.seconds;
                shown += with.stats.backend.pixels_shaded as f64;
                let edge = plain.tile_edge();
                for ranks in RANKS {
                    for organisation in [Organisation::SortFirst, Organisation::SortLast] {
                        let reports = measure(&scene, &camera, size, ranks, organisation, frames)?;
                        let counts = predict_counts(&scene, &camera, size, edge, ranks, organisation)?;
                        let work = Work { size, edge, ranks, organisation, counts: &counts };
                        for rank in 0..ranks {
                            let compose = busy(&reports, rank, |s| s.compose);
                            rows[0].push((work.composing(rank).to_vec(), compose));
                            let collect = busy(&reports, rank, |s| s.collect);
                            rows[1].push((work.collecting(rank).to_vec(), collect));
                        }
                    }
                }
            }
        }
        let fitted = rows.map(|rows| {
            // Stages that did nothing tell nothing.
            let (counts, times): (Vec<_>, Vec<_>) = rows.into_iter().filter(|r| r.1 > 1e-6).unzip();
            if times.is_empty() { Vec::new() } else { fit::costs(&counts, &times) }
        });
        let cost = |of: usize, k: usize| fitted[of].get(k).copied().unwrap_or(0.0);
        Ok(Self {
            key: (more / f64::max(shown, 1.0)).max(0.0),
            compose: [0, 1, 2].map(|k| cost(0, k)),
            collect: [0, 1, 2, 3].map(|k| cost(1, k)),
        })
    }
}

/// What ranks do beside drawing.
struct Work<'a> {
    size: (u32, u32),
    edge: u32,
    ranks: usize,
    organisation: Organisation,
    counts: &'a [RankCounts],
}

impl Work<'_> {
    fn regions(&self) -> Regions {
        let ((width, height), edge) = (self.size, self.edge);
        Regions { width, height, edge, owners: self.ranks, assignment: Assignment::Interleaved }
    }

    /// Pixels that a rank owns.
    fn own(&self, rank: usize) -> f64 {
        let regions = self.regions();
        let all = regions.touched(PixelBox::screen(self.size.0, self.size.1));
        all.filter(|r| regions.owner(r.0) == rank).map(|r| r.1 as f64).sum()
    }

    fn others(&self, rank: usize) -> f64 {
        f64::from(self.size.0) * f64::from(self.size.1) - self.own(rank)
    }

    /// As [`RankCosts::compose`].
    fn composing(&self, rank: usize) -> [f64; 3] {
        let c = &self.counts[rank];
        let looks = self.organisation == Organisation::SortLast && c.triangles > 0;
        [if looks { self.others(rank) } else { 0.0 }, c.sent as f64, c.compared as f64]
    }

    /// As [`RankCosts::collect`].
    fn collecting(&self, rank: usize) -> [f64; 4] {
        let visible = |c: &RankCounts| c.visible as f64;
        if rank > 0 {
            return [self.own(rank), visible(&self.counts[rank]), 0.0, 0.0];
        }
        let clears = self.organisation == Organisation::SortFirst;
        let unpacked = self.counts[1..].iter().map(visible).sum();
        [self.own(0), 0.0, unpacked, if clears { self.others(0) } else { 0.0 }]
    }
}

/// What every rank's renderer does, all of it by [`count`]; nothing where a rank has neither
/// clusters to draw nor regions to own.
pub(super) fn drawing(
    scene: &Scene,
    camera: &Camera,
    size: (u32, u32),
    ranks: usize,
    organisation: Organisation,
) -> Result<Vec<Counters>, PredictError> {
    let whole = settings(size);
    let regions = size.0.div_ceil(whole.tile_edge()) as usize * size.1.div_ceil(whole.tile_edge()) as usize;
    let clusters = scene.instances.iter().map(|i| i.mesh.clusters.len() as u32).sum();
    let of_rank = |rank: usize| {
        let part = Part { number: rank as u32, of: ranks as u32 };
        let settings = match organisation {
            Organisation::SortLast if part.range(clusters).is_empty() && rank >= regions => {
                return Ok(Counters::default());
            }
            Organisation::SortLast => Settings { clusters: part, ..whole.clone() },
            Organisation::SortFirst if rank >= regions => return Ok(Counters::default()),
            Organisation::SortFirst => Settings { tiles: part, ..whole.clone() },
        };
        Ok(count(scene, camera, &settings, 1)?.frame)
    };
    (0..ranks).map(of_rank).collect()
}

/// Predicts a frame of ranks with one thread each on some processors.
#[expect(clippy::too_many_arguments, reason = "a struct would only rename them")]
pub(super) fn predict(
    machine: &Machine,
    costs: &RankCosts,
    counts: &[RankCounts],
    drawing: &[Counters],
    size: (u32, u32),
    edge: u32,
    organisation: Organisation,
    processors: usize,
) -> StageSeconds {
    let ranks = counts.len();
    let work = Work { size, edge, ranks, organisation, counts };
    let draw: Vec<f64> = drawing
        .iter()
        .map(|own| {
            let alone = FrameTime::on_one_thread(machine, own).total();
            if own.pixels > 0 { alone + costs.key * own.pixels_shaded as f64 } else { 0.0 }
        })
        .collect();
    let charge = |counts: &[f64], costs: &[f64]| counts.iter().zip(costs).map(|(n, c)| n * c).sum::<f64>();
    let compose: Vec<f64> = (0..ranks).map(|r| charge(&work.composing(r), &costs.compose)).collect();
    let collect: Vec<f64> = (0..ranks).map(|r| charge(&work.collecting(r), &costs.collect)).collect();

    // Ranks that work side by side hold each other up as threads do.
    let side_by_side = ranks.min(processors.max(1)) as f64;
    let serial = machine.processors.serial.as_ref().map_or(0.0, |s| s.value);
    let slower = 1.0 + serial * (side_by_side - 1.0);
    let [draw, compose, collect] = [draw, compose, collect].map(|times| {
        let slowed = times.into_iter().map(|t| t * slower);
        slowed.collect::<Vec<_>>()
    });
    StageSeconds::of_ranks(&draw, &compose, &collect, processors)
}
