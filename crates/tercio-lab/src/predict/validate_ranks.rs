//! Ranks in one process, predicted against measured: [`tercio_parallel`] draws, and what its ranks count and send has to
//! be what [`ranks`](super::ranks) reckons. Times are of ranks with one thread each, by the model of
//! [`renderer`](super::ranks::renderer) that `tercio lab predict` and `advise` use.

use serde::Serialize;
use tercio_parallel::Organisation;
use tercio_raster::Settings;

use super::counters::Counters;
use super::measure::Clock;
use super::ranks::RanksError;
use super::ranks::exchange::ExchangeCosts;
use super::ranks::measure::MeasuredRanks;
use super::ranks::renderer::{RankSeconds, RanksFrame, RanksWork, predict};
use super::ranks::traffic::RankCounts;
use super::validate::{Model, TOLERANCE};
use super::{PredictError, views};
use crate::machines::Machine;

/// Seconds of a frame. A stage is that of its busiest rank.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct StageSeconds {
    /// Drawing.
    pub draw: f64,
    /// Packing for other owners and composing.
    pub compose: f64,
    /// Packing for rank 0, unpacking there.
    pub collect: f64,
    /// Rank 0 waiting for messages.
    pub wait: f64,
    /// The whole frame, until rank 0 has the picture.
    pub frame: f64,
}

impl StageSeconds {
    /// Adds one of `of` views.
    fn add(&mut self, o: Self, of: f64) {
        self.draw += o.draw / of;
        self.compose += o.compose / of;
        self.collect += o.collect / of;
        self.wait += o.wait / of;
        self.frame += o.frame / of;
    }

    fn predicted(frame: &RanksFrame, clock: Clock) -> Self {
        let busiest = |of: fn(&RankSeconds) -> f64| frame.busiest_and_mean(of).0;
        Self {
            draw: busiest(|r| r.draw),
            compose: busiest(|r| r.compose),
            collect: busiest(|r| r.collect),
            wait: frame.ranks.first().map_or(0.0, |first| first.wait),
            frame: match clock {
                Clock::Wall => frame.total(),
                Clock::Processor => frame.ranks.iter().map(|r| r.draw + r.compose + r.collect).sum(),
            },
        }
    }

    fn measured(ranks: usize, measured: &MeasuredRanks, clock: Clock) -> Self {
        let draw = |rank| measured.busy(rank, |s| s.draw);
        let compose = |rank| measured.busy(rank, |s| s.compose);
        let collect = |rank| measured.busy(rank, |s| s.collect);
        let busiest = |of: &dyn Fn(usize) -> f64| (0..ranks).map(of).fold(0.0, f64::max);
        Self {
            draw: busiest(&draw),
            compose: busiest(&compose),
            collect: busiest(&collect),
            wait: measured.waited(),
            frame: match clock {
                Clock::Wall => measured.fastest(),
                Clock::Processor => (0..ranks).map(|r| draw(r) + compose(r) + collect(r)).sum(),
            },
        }
    }
}

/// One model, size and way to share it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Model.
    pub model: String,
    /// Pixels across and down.
    pub size: (u32, u32),
    /// Ranks.
    pub ranks: usize,
    /// How they share a frame.
    pub organisation: Organisation,
    /// Messages of a frame, summed over the views.
    pub messages: u64,
    /// Their bytes.
    pub bytes: u64,
    /// Counters that differ: rank, name, ours, the rank's.
    pub differing: Vec<(usize, &'static str, u64, u64)>,
    /// Counters that were compared.
    pub compared: usize,
    /// Predicted seconds of a frame, stage by stage, the mean of the views.
    pub predicted: StageSeconds,
    /// Measured ones.
    pub measured: StageSeconds,
    /// Page faults of a frame, the mean of the views.
    pub page_faults: f64,
    /// Switches of threads in a frame, likewise.
    pub switches: f64,
}

impl Row {
    /// Predicted over measured, less 1, of the whole frame.
    pub fn error(&self) -> f64 {
        self.predicted.frame / self.measured.frame - 1.0
    }

    /// All counters equal, and the frame's time within [`TOLERANCE`].
    pub fn holds(&self) -> bool {
        self.differing.is_empty() && self.error().abs() <= TOLERANCE
    }
}

/// How much is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Options {
    /// Views round the model.
    pub views: u32,
    /// Frames of a view in a round, of which the fastest counts.
    pub frames: u32,
    /// Rounds through everything: who else uses the machine does not do so in every one.
    pub rounds: u32,
    /// Processors that the ranks share.
    pub processors: usize,
    /// Which clock times whole frames. By processor time a frame is the work of all its ranks together, which then never
    /// wait for a processor that other programs have; stages are timed by it always.
    pub clock: Clock,
}

/// One view of a row.
struct View<'a> {
    model: &'a Model,
    camera: tercio_scene::Camera,
    work: RanksWork,
    predicted: RanksFrame,
    measured: MeasuredRanks,
    differing: Vec<(usize, &'static str, u64, u64)>,
    compared: usize,
}

impl View<'_> {
    fn measure(&mut self, o: Options) -> Result<(), RanksError> {
        let sharing = &self.work.sharing;
        let measured = MeasuredRanks::draw(&self.model.scene, &self.camera, sharing, o.frames)?;
        for report in &measured.reports {
            for (rank, theirs) in report.ranks.iter().enumerate() {
                let ours = self.work.messages.counts(rank).by_name();
                let sent = ours.into_iter().zip(RankCounts::measured(theirs).by_name());
                let ours = self.work.drawing[rank].comparable();
                let drawn = ours.into_iter().zip(Counters::counted(&theirs.frame));
                for ((name, ours), (_, theirs)) in sent.chain(drawn) {
                    self.compared += 1;
                    if ours != theirs {
                        self.differing.push((rank, name, ours, theirs));
                    }
                }
            }
        }
        self.measured.add(measured);
        Ok(())
    }
}

/// Predicts models at some sizes on some ranks, then draws all of them, round after round. `tell` is told after each
/// picture.
///
/// # Errors
/// [`RanksError`].
pub fn compare(
    machine: &Machine,
    costs: &ExchangeCosts,
    models: &[Model],
    sizes: &[(u32, u32)],
    how: &[(usize, Organisation)],
    o: Options,
    mut tell: impl FnMut(),
) -> Result<Vec<Row>, RanksError> {
    let mut rows = Vec::new();
    for model in models {
        for &size in sizes {
            for &how in how {
                let views = (0..o.views.max(1)).map(|view| {
                    let camera = views::camera(&model.bounds, size, view, o.views);
                    let work = RanksWork::count(&model.scene, &camera, &Settings::new(size.0, size.1), how)?;
                    let predicted =
                        predict(machine, costs, &work, o.processors).map_err(PredictError::from)?;
                    let measured = MeasuredRanks::default();
                    Ok(View { model, camera, work, predicted, measured, differing: Vec::new(), compared: 0 })
                });
                rows.push(views.collect::<Result<Vec<_>, RanksError>>()?);
            }
        }
    }
    for _ in 0..o.rounds.max(1) {
        for row in &mut rows {
            row.iter_mut().try_for_each(|view| view.measure(o))?;
            tell();
        }
    }
    Ok(rows.iter().map(|views| row(views, o.clock)).collect())
}

fn row(views: &[View], clock: Clock) -> Row {
    let first = &views[0];
    let sharing = first.work.sharing;
    let of = views.len() as f64;
    let (mut predicted, mut measured) = (StageSeconds::default(), StageSeconds::default());
    let (mut messages, mut bytes, mut usage) = (0, 0, [0.0; 2]);
    for view in views {
        predicted.add(StageSeconds::predicted(&view.predicted, clock), of);
        measured.add(StageSeconds::measured(sharing.ranks, &view.measured, clock), of);
        if let Some(report) = view.measured.reports.first() {
            messages += report.messages;
            bytes += report.bytes;
        }
        usage.iter_mut().zip(view.measured.usage()).for_each(|(sum, u)| *sum += u / of);
    }
    Row {
        model: first.model.name.clone(),
        size: sharing.size,
        ranks: sharing.ranks,
        organisation: sharing.organisation,
        messages,
        bytes,
        differing: views.iter().flat_map(|v| v.differing.iter().copied()).collect(),
        compared: views.iter().map(|v| v.compared).sum(),
        predicted,
        measured,
        page_faults: usage[0],
        switches: usage[1],
    }
}

#[cfg(test)]
mod tests;
