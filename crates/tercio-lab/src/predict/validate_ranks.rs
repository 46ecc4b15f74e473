//! Compares predictions for ranks with measurements: [`tercio_parallel`] draws, in one process or between processes,
//! and the counters and messages of its ranks have to equal those computed by [`ranks`](super::ranks). Times are of
//! ranks with one thread each, by the model of [`renderer`](super::ranks::renderer) that `tercio lab predict` and
//! `advise` use.

use serde::Serialize;
use tercio_parallel::organisation::tile_edge;
use tercio_parallel::report::{RankStages, Stage};
use tercio_parallel::{Communicator, Division, Organisation, ParallelError};
use tercio_raster::Settings;
use tercio_scene::{Camera, Scene};

use super::counts::Counters;
use super::difference::{RANK_TERMS, Term, terms};
use super::measure::Clock;
use super::ranks::RanksError;
use super::ranks::exchange::ExchangeCosts;
use super::ranks::measure::MeasuredRanks;
use super::ranks::renderer::{Carrier, RankSeconds, RanksFrame, RanksWork, predict};
use super::ranks::traffic::{RankCounts, Sharing};
use super::validate::{self, Model};
use super::{PredictError, views};
use crate::machines::Machine;

/// Largest relative error of processes that holds: they poll while they wait, which takes time from others if there are
/// more of them than processors.
pub const MPI_TOLERANCE: f64 = 0.25;

/// The tolerance of ranks that are processes, or threads of one.
pub fn tolerance(is_over_mpi: bool) -> f64 {
    if is_over_mpi { MPI_TOLERANCE } else { validate::TOLERANCE }
}

/// Seconds of the [terms](RANK_TERMS) of a frame.
type TermSeconds = [f64; RANK_TERMS.len()];

/// The terms of a predicted frame on rank 0; by processor time, those of all ranks together.
fn predicted_terms(frame: &RanksFrame, clock: Clock) -> TermSeconds {
    let first = frame.ranks.first().copied().unwrap_or_default();
    match clock {
        Clock::Wall => {
            [first.divide, first.draw, first.compose, first.collect, first.wait + first.message, first.queue]
        }
        Clock::Processor => {
            let sum = |of: fn(&RankSeconds) -> f64| frame.ranks.iter().map(of).sum();
            [sum(|r| r.divide), sum(|r| r.draw), sum(|r| r.compose), sum(|r| r.collect), 0.0, 0.0]
        }
    }
}

/// The terms of the measured frame that counts.
fn measured_terms(ranks: usize, measured: &MeasuredRanks, clock: Clock) -> TermSeconds {
    match clock {
        Clock::Wall => measured.terms_of_the_fastest(),
        Clock::Processor => {
            let sum = |of: fn(&RankStages) -> &Stage| (0..ranks).map(|r| measured.busy(r, of)).sum();
            [sum(|s| &s.redistribute), sum(|s| &s.draw), sum(|s| &s.compose), sum(|s| &s.collect), 0.0, 0.0]
        }
    }
}

/// Seconds of a frame. The time of a stage is that of its busiest rank.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct StageSeconds {
    /// Drawing.
    pub draw: f64,
    /// Packing for other owners and compositing.
    pub compose: f64,
    /// Packing for rank 0, unpacking there.
    pub collect: f64,
    /// Rank 0 waiting for messages and receiving them.
    pub wait: f64,
    /// The whole frame, until rank 0 has the picture.
    pub frame: f64,
}

impl StageSeconds {
    /// Adds one of `of` views to the mean.
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
            wait: frame.ranks.first().map_or(0.0, |first| first.wait + first.message),
            frame: match clock {
                Clock::Wall => frame.total(),
                Clock::Processor => frame.ranks.iter().map(|r| r.draw + r.compose + r.collect).sum(),
            },
        }
    }

    fn measured(ranks: usize, measured: &MeasuredRanks, clock: Clock) -> Self {
        let draw = |rank| measured.busy(rank, |s| &s.draw);
        let compose = |rank| measured.busy(rank, |s| &s.compose);
        let collect = |rank| measured.busy(rank, |s| &s.collect);
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
    /// Context switches in a frame, likewise.
    pub switches: f64,
    /// Whether ranks are processes.
    pub is_over_mpi: bool,
    /// The [terms](RANK_TERMS) of both frames, the largest difference first.
    pub terms: Vec<Term>,
}

impl Row {
    /// Predicted over measured, minus 1, of the whole frame.
    pub fn error(&self) -> f64 {
        self.predicted.frame / self.measured.frame - 1.0
    }

    /// Largest relative error that holds.
    pub fn tolerance(&self) -> f64 {
        tolerance(self.is_over_mpi)
    }

    /// All counters equal, and the frame's time within the tolerance.
    pub fn holds(&self) -> bool {
        self.differing.is_empty() && self.error().abs() <= self.tolerance()
    }
}

/// How much is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Options {
    /// Views round the model.
    pub views: u32,
    /// Frames of a view in a round, of which the fastest counts.
    pub frames: u32,
    /// Rounds through everything: other users of the machine do not disturb every one.
    pub rounds: u32,
    /// Processors that the ranks share.
    pub processors: usize,
    /// Which clock times whole frames. By processor time a frame is the work of all its ranks together, which then
    /// never wait for processors that other programs use; stages are always timed by it.
    pub clock: Clock,
}

/// What is compared: every model at every size, shared in every way.
#[derive(Clone, Copy, Debug)]
pub struct Table<'a> {
    /// Models.
    pub models: &'a [Model],
    /// Pixels across and down.
    pub sizes: &'a [(u32, u32)],
    /// Ranks, and how they share a frame.
    pub how: &'a [(usize, Organisation)],
    /// How much is measured.
    pub options: Options,
}

/// The model, size and sharing of a row.
#[derive(Clone, Copy)]
struct Place<'a> {
    model: &'a Model,
    size: (u32, u32),
    how: (usize, Organisation),
    views: u32,
}

impl<'a> Table<'a> {
    /// The places of all rows, in order.
    fn places(self) -> impl Iterator<Item = Place<'a>> {
        let Self { models, sizes, how, options } = self;
        let views = options.views.max(1);
        let of_size = move |model, size| how.iter().map(move |&how| Place { model, size, how, views });
        models.iter().flat_map(move |model| sizes.iter().flat_map(move |&size| of_size(model, size)))
    }
}

impl<'a> Place<'a> {
    /// Predicts every view.
    fn views(
        &self,
        machine: &Machine,
        costs: &ExchangeCosts,
        processors: usize,
    ) -> Result<Vec<View<'a>>, RanksError> {
        let model = self.model;
        let view = |camera| {
            let work =
                RanksWork::count(&model.scene, &camera, &self.settings(), (self.how.0, self.how.1.into()))?;
            let predicted = predict(machine, costs, &work, processors).map_err(PredictError::from)?;
            let measured = MeasuredRanks::default();
            Ok(View { model, camera, work, predicted, measured, differing: Vec::new(), compared: 0 })
        };
        self.cameras().map(view).collect()
    }

    fn cameras(&self) -> impl Iterator<Item = Camera> {
        (0..self.views).map(|view| views::camera(&self.model.bounds, self.size, view, self.views))
    }

    fn settings(&self) -> Settings {
        Settings::one_sample(self.size.0, self.size.1)
    }
}

/// One view of a row.
struct View<'a> {
    model: &'a Model,
    camera: Camera,
    work: RanksWork,
    predicted: RanksFrame,
    measured: MeasuredRanks,
    differing: Vec<(usize, &'static str, u64, u64)>,
    compared: usize,
}

impl View<'_> {
    /// Compares all measured frames with the prediction.
    fn add(&mut self, measured: MeasuredRanks) {
        for report in &measured.reports {
            for (rank, theirs) in report.ranks.iter().enumerate() {
                let ours = self.work.messages.counts(rank).by_name();
                let sent = ours.into_iter().zip(RankCounts::measured(theirs).by_name());
                let ours = self.work.drawing[rank].comparable();
                let drawn = ours.into_iter().zip(Counters::from_stats(&theirs.frame).comparable());
                for ((name, ours), (_, theirs)) in sent.chain(drawn) {
                    self.compared += 1;
                    if ours != theirs {
                        self.differing.push((rank, name, ours, theirs));
                    }
                }
            }
        }
        self.measured.add(measured);
    }
}

/// Predicts all rows, then draws all of them, round after round, by `draw`: [`MeasuredRanks::draw`] for ranks of this
/// process, [`MeasuredRanks::draw_between`] for rank 0 of a job whose other ranks [`follow`]. In that case the
/// description is that of a machine [over MPI](Machine::over_mpi). `progress` is called after each picture.
///
/// # Errors
/// [`RanksError`].
pub fn compare(
    machine: &Machine,
    costs: &ExchangeCosts,
    table: Table,
    mut draw: impl FnMut(&Scene, &Camera, &Sharing, u32) -> Result<MeasuredRanks, ParallelError>,
    mut progress: impl FnMut(),
) -> Result<Vec<Row>, RanksError> {
    let o = table.options;
    let predicted = table.places().map(|place| place.views(machine, costs, o.processors));
    let mut rows = predicted.collect::<Result<Vec<_>, _>>()?;
    for _ in 0..o.rounds.max(1) {
        for row in &mut rows {
            for view in row {
                view.add(draw(&view.model.scene, &view.camera, &view.work.sharing, o.frames)?);
            }
            progress();
        }
    }
    Ok(rows.iter().map(|views| row(views, o.clock)).collect())
}

/// The part of the other ranks of a job while rank 0 compares a table: they draw the same pictures in the same order.
///
/// # Errors
/// [`ParallelError`].
pub fn follow(comm: &mut impl Communicator, table: Table) -> Result<(), ParallelError> {
    let o = table.options;
    for _ in 0..o.rounds.max(1) {
        for place in table.places() {
            let ((ranks, organisation), size) = (place.how, place.size);
            let edge = tile_edge(&place.model.scene, &place.settings(), organisation, ranks);
            let sharing = Sharing { organisation, division: Division::default(), ranks, size, edge };
            for camera in place.cameras() {
                MeasuredRanks::draw_between(comm, &place.model.scene, &camera, &sharing, o.frames)?;
            }
        }
    }
    Ok(())
}

fn row(views: &[View], clock: Clock) -> Row {
    let first = &views[0];
    let sharing = first.work.sharing;
    let of = views.len() as f64;
    let (mut predicted, mut measured) = (StageSeconds::default(), StageSeconds::default());
    let (mut messages, mut bytes, mut usage) = (0, 0, [0.0; 2]);
    let mut of_terms = [TermSeconds::default(); 2];
    for view in views {
        predicted.add(StageSeconds::predicted(&view.predicted, clock), of);
        measured.add(StageSeconds::measured(sharing.ranks, &view.measured, clock), of);
        if let Some(report) = view.measured.reports.first() {
            messages += report.messages;
            bytes += report.bytes;
        }
        usage.iter_mut().zip(view.measured.usage()).for_each(|(sum, u)| *sum += u / of);
        let both =
            [predicted_terms(&view.predicted, clock), measured_terms(sharing.ranks, &view.measured, clock)];
        for (sums, seconds) in of_terms.iter_mut().zip(both) {
            sums.iter_mut().zip(seconds).for_each(|(sum, s)| *sum += s / of);
        }
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
        is_over_mpi: first.predicted.carrier != Carrier::Threads,
        terms: terms(RANK_TERMS, of_terms[0], of_terms[1]),
    }
}

#[cfg(test)]
mod tests;
