//! Tests the advice on this machine: all ways to draw that [`advise`](super::advise) compares are drawn, and the advised one is
//! compared with the fastest.

use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};
use tercio_parallel::{Ranks, draw_frames};
use tercio_raster::Settings;
use tercio_scene::Camera;

use super::advise::splits::Split;
use super::advise::uncertainty::Uncertainty;
use super::advise::{Advice, Candidate, Frame, How, advise, formulas};
use super::measure::{Clock, measure};
use super::ranks::{Picture, RanksError};
use super::validate::Model;
use super::{PredictError, views};
use crate::machines::Machine;

/// How much longer than the fastest the advised way may take.
pub const TOLERANCE: f64 = 0.1;

/// Ten models: closed surfaces, layers and triangle soups, of few triangles and many. None of them is one that `tercio lab
/// calibrate` fits costs to.
pub const MODELS: [&str; 10] = [
    "builtin:teapot@10k",
    "builtin:teapot@500k",
    "builtin:gyroid@20k",
    "builtin:gyroid@300k",
    "builtin:gyroid@2M",
    "builtin:terrain@50k",
    "builtin:terrain@1M",
    "builtin:sphere@20k",
    "builtin:sphere@1M",
    "builtin:soup@50k",
];

/// Frames that allocate memory and fill caches; they are not evaluated.
const WARM_UP: usize = 2;

/// How much is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options<'a> {
    /// Processors that are advised on.
    pub processors: usize,
    /// Numbers of ranks that are drawn, too, though there are not as many processors.
    pub more_ranks: &'a [usize],
    /// Frames of a way in a round, of which the fastest counts.
    pub frames: u32,
    /// Rounds through everything.
    pub rounds: u32,
}

/// A way to draw, predicted and measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Drawn {
    /// The prediction.
    pub candidate: Candidate,
    /// Seconds of the fastest frame.
    pub seconds: f64,
}

/// A model at one size.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Model.
    pub model: String,
    /// Pixels across and down.
    pub size: (u32, u32),
    /// All that was drawn; the advised one first, the others in the order of the advice.
    pub drawn: Vec<Drawn>,
    /// How far the predictions may be off, if that is known.
    pub uncertainty: Option<Uncertainty>,
}

/// How far predictions of a kind were off.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Errors {
    /// Ways to draw.
    pub number: usize,
    /// Root of the mean square of predicted over measured, minus 1.
    pub rms: f64,
}

/// How many measured times lie inside the interval that was stated with their prediction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Coverage {
    /// Inside, ends included.
    pub inside: usize,
    /// Of so many.
    pub of: usize,
}

impl Row {
    /// The advised way.
    pub fn advised(&self) -> &Drawn {
        &self.drawn[0]
    }

    /// The fastest way.
    pub fn best(&self) -> &Drawn {
        self.drawn.iter().fold(&self.drawn[0], |best, d| if d.seconds < best.seconds { d } else { best })
    }

    /// Seconds of the advised way over those of the fastest, minus 1.
    pub fn loss(&self) -> f64 {
        self.advised().seconds / self.best().seconds - 1.0
    }

    /// The ways that formulas predict, or all others.
    fn predicted(&self, by_formulas: bool) -> impl Iterator<Item = &Drawn> {
        self.drawn.iter().filter(move |d| matches!(d.candidate.frame, Frame::Formulas { .. }) == by_formulas)
    }

    /// How many measured times lie inside their intervals, of predictions by formulas, or of all others; `None` if no intervals are
    /// stated.
    pub fn coverage(&self, by_formulas: bool) -> Option<Coverage> {
        let uncertainty = self.uncertainty.as_ref()?;
        let mut coverage = Coverage::default();
        for drawn in self.predicted(by_formulas) {
            let [low, high] = uncertainty.interval(&drawn.candidate);
            coverage.of += 1;
            coverage.inside += usize::from((low..=high).contains(&drawn.seconds));
        }
        Some(coverage)
    }

    /// The errors of the predictions by formulas, or of all others.
    pub fn errors(&self, by_formulas: bool) -> Errors {
        let squares =
            self.predicted(by_formulas).map(|d| (d.candidate.frame.total() / d.seconds - 1.0).powi(2));
        let (number, sum) = squares.fold((0usize, 0.0), |(number, sum), square| (number + 1, sum + square));
        Errors { number, rms: (sum / number.max(1) as f64).sqrt() }
    }
}

/// Advises on all models at all sizes, then draws all candidates, round after round. `progress` is called after each picture.
///
/// # Errors
/// [`RanksError`]: a machine that has no costs of the renderer's ranks, too; a picture that cannot be drawn.
pub fn compare(
    machine: &Machine,
    models: &[Model],
    sizes: &[(u32, u32)],
    options: Options,
    mut progress: impl FnMut(),
) -> Result<Vec<Row>, RanksError> {
    super::ranks::exchange::ExchangeCosts::of(machine).map_err(PredictError::from)?;
    let mut pictures = Vec::new();
    for model in models {
        for &size in sizes {
            let (camera, settings) =
                (views::camera(&model.bounds, size, 0, 1), Settings::one_sample(size.0, size.1));
            let picture = Picture { scene: &model.scene, camera: &camera, settings: &settings };
            let (candidates, uncertainty) = candidates(machine, &picture, options)?;
            let drawn = candidates.into_iter().map(|candidate| Drawn { candidate, seconds: f64::INFINITY });
            let row = Row { model: model.name.clone(), size, drawn: drawn.collect(), uncertainty };
            pictures.push((model, camera, settings, row));
        }
    }
    for _ in 0..options.rounds.max(1) {
        for (model, camera, settings, row) in &mut pictures {
            let picture = Picture { scene: &model.scene, camera, settings };
            for drawn in &mut row.drawn {
                let seconds = draw(&picture, &drawn.candidate, options.frames)?;
                drawn.seconds = drawn.seconds.min(seconds);
            }
            progress();
        }
    }
    Ok(pictures.into_iter().map(|picture| picture.3).collect())
}

/// The advice, and more ranks than it considers, with how far predictions may be off.
fn candidates(
    machine: &Machine,
    picture: &Picture,
    options: Options,
) -> Result<(Vec<Candidate>, Option<Uncertainty>), PredictError> {
    let Advice { mut candidates, uncertainty, .. } = advise(machine, picture, options.processors, None)?;
    // As many ranks as processors and fewer are in the advice.
    let more: BTreeSet<usize> =
        options.more_ranks.iter().copied().filter(|&n| n > options.processors).collect();
    let more: Vec<Split> = more.into_iter().map(|ranks| Split { ranks, threads: 1 }).collect();
    candidates.extend(formulas::ranks(machine, picture, None, &more, Some(options.processors))?);
    Ok((candidates, uncertainty))
}

/// Seconds of the fastest frame.
fn draw(picture: &Picture, candidate: &Candidate, frames: u32) -> Result<f64, RanksError> {
    let Picture { scene, camera, settings } = *picture;
    let Split { ranks, threads } = candidate.split;
    match candidate.how {
        How::OneProcess { region } => {
            let settings = Settings { tile_size: Some(region), ..settings.clone() };
            Ok(measure(scene, camera, &settings, threads, frames, Clock::Wall)?.seconds)
        }
        How::Ranks { sharing, region } => {
            let settings = &Settings { tile_size: region.or(settings.tile_size), ..settings.clone() };
            let cameras: Vec<Camera> = vec![*camera; frames.max(1) as usize + WARM_UP];
            let ranks = Ranks { count: ranks, threads, sharing };
            let reports = draw_frames(ranks, scene, &cameras, settings, |_, _| ())?;
            let seconds = reports.iter().skip(WARM_UP).map(|report| report.milliseconds * 1e-3);
            Ok(seconds.fold(f64::INFINITY, f64::min))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machines::builtin;
    use crate::predict::calibrate::prepare;
    use crate::predict::choose::terms::{Sums, Terms};
    use crate::predict::frame::FrameTime;
    use crate::predict::quoted::{AdviceRow, QuotedRow as _};

    /// Structure only: times depend on what else runs.
    #[test]
    fn all_candidates_are_drawn_and_the_advised_one_is_first() {
        let machine = builtin("two-core-2026").unwrap().unwrap();
        let (scene, bounds) = prepare(tercio_mesh::builtin::make("builtin:teapot@1k").unwrap());
        let model = Model { name: "teapot".into(), scene, bounds };
        let options = Options { processors: 2, more_ranks: &[1, 2, 3, 3], frames: 1, rounds: 1 };
        let mut seen = 0;
        let rows = compare(&machine, &[model], &[(64, 48), (90, 70)], options, || seen += 1).unwrap();
        assert_eq!((rows.len(), seen), (2, 2));
        for row in &rows {
            let numbers = [(1, 1), (1, 2), (2, 1), (3, 1)].map(|(ranks, threads)| {
                row.drawn.iter().filter(|d| d.candidate.split == Split { ranks, threads }).count()
            });
            let limits = crate::predict::choose::candidates::Limits::ALL;
            let of_ranks = |ranks| limits.candidates(ranks).unwrap().len();
            assert_eq!(numbers, [5, 5, of_ranks(2), of_ranks(3)]);
            assert_eq!(row.drawn.len(), numbers.iter().sum::<usize>());
            assert!(row.drawn.iter().all(|d| d.seconds > 0.0 && d.seconds.is_finite()));
            let advised = row.advised().candidate.frame.total();
            let considered = row.drawn.iter().filter(|d| d.candidate.split.ranks <= 2);
            assert!(considered.map(|d| d.candidate.frame.total()).all(|t| t >= advised));
            assert!(row.drawn.iter().all(|d| d.seconds >= row.best().seconds) && row.loss() >= 0.0);
            let both = row.errors(true).number + row.errors(false).number;
            assert_eq!(both, row.drawn.len());
            let quoted = AdviceRow::from(row);
            assert_eq!(quoted.ways, row.drawn.len());
            assert_eq!(quoted.advised, row.advised().candidate.describe());
        }
    }

    #[test]
    fn a_row_holds_within_a_tenth_of_the_best() {
        let advised = |milliseconds| AdviceRow {
            model: "m".into(),
            size: [4, 3],
            ways: 2,
            advised: "a".into(),
            best: "b".into(),
            predicted: 1.0,
            measured: milliseconds,
            best_measured: 1.0,
            errors: [0.1, 0.2],
            coverage: Some([(1, 2), (30, 40)].map(|(inside, of)| Coverage { inside, of })),
        };
        assert!(advised(1.099).holds() && !advised(1.11).holds());
        let cells = ["1 of 2, 30 of 40", "+11.0 %", "misses"];
        assert_eq!(advised(1.11).cells()[8..], cells);
        assert_eq!(AdviceRow { coverage: None, ..advised(1.0) }.cells()[8], "not counted");
        assert_eq!(AdviceRow::HEADER.len(), advised(1.0).cells().len());
    }

    /// Predictions of 10 s that may be 5 % off (twice that counts), and formulas that may be 27 % off, measured at the ends of their
    /// intervals and beyond.
    #[test]
    fn measured_times_inside_their_intervals_are_counted() {
        let drawn = |by_formulas: bool, seconds: f64| {
            let (split, how) = (Split { ranks: 1, threads: 1 }, How::OneProcess { region: 8 });
            let time = FrameTime { raster: 10.0, ..FrameTime::default() };
            let terms = Terms { draw: 10.0, ..Terms::default() };
            let formulas = Frame::Formulas { terms, sent: Sums::default() };
            let frame = if by_formulas { formulas } else { Frame::Threads(time) };
            Drawn { candidate: Candidate { split, how, frame, assumed: None }, seconds }
        };
        let counted = [9.0, 9.1, 10.0, 11.1, 11.2].map(|seconds| drawn(false, seconds));
        let formulas = [6.4, 6.5, 21.7, 21.8].map(|seconds| drawn(true, seconds));
        let uncertainty = Some(Uncertainty { residual: 0.05, costs_of: None, is_assumed: false });
        let all = counted.into_iter().chain(formulas).collect();
        let row = Row { model: "m".into(), size: (4, 3), drawn: all, uncertainty };
        assert_eq!(row.coverage(false), Some(Coverage { inside: 3, of: 5 }));
        assert_eq!(row.coverage(true), Some(Coverage { inside: 2, of: 4 }));
        assert_eq!(AdviceRow::from(&row).coverage.map(|both| both[1].inside), Some(2));
        let none = Row { uncertainty: None, ..row };
        assert_eq!(none.coverage(true), None);
        assert_eq!(AdviceRow::from(&none).coverage, None);
    }

    #[test]
    fn a_machine_without_costs_of_ranks_is_refused() {
        let machine = builtin("princeton-engine").unwrap().unwrap();
        let options = Options { processors: 2, more_ranks: &[], frames: 1, rounds: 1 };
        assert!(compare(&machine, &[], &[], options, || ()).is_err());
    }
}
