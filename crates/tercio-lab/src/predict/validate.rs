//! Compares predictions with measurements.

use serde::Serialize;
use tercio_mesh::Aabb;
use tercio_raster::{Settings, Sorting};
use tercio_scene::{Camera, Scene};

use super::counts::{Counters, count};
use super::difference::{STAGES, Term, of_stages, terms};
use super::frame::FrameTime;
use super::measure::{Clock, measure};
use super::{PredictError, views};
use crate::machines::Machine;

/// Largest relative error of a time that holds.
pub const TOLERANCE: f64 = 0.15;
/// The same for models of loose triangles, of which no two share a vertex: each is a cluster of its own, so that what
/// differs between clusters does not average out.
pub const LOOSE_TOLERANCE: f64 = 0.2;

/// The tolerance of a model's times.
pub fn tolerance(is_loose: bool) -> f64 {
    if is_loose { LOOSE_TOLERANCE } else { TOLERANCE }
}

/// Whether no two triangles of a scene share a vertex.
pub fn is_loose(scene: &Scene) -> bool {
    let mut clusters = scene.instances.iter().flat_map(|i| i.mesh.views());
    clusters.all(|c| c.vertices() == 3 * c.triangles())
}

/// One model, size and number of threads.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Model.
    pub model: String,
    /// Pixels across and down.
    pub size: (u32, u32),
    /// Threads.
    pub threads: usize,
    /// Which clock.
    pub clock: Clock,
    /// Counters that differ: name, ours, the renderer's.
    pub differing: Vec<(&'static str, u64, u64)>,
    /// Counters that were compared.
    pub compared: usize,
    /// Predicted seconds, the mean of the views.
    pub predicted: f64,
    /// Measured seconds, the mean of the views.
    pub measured: f64,
    /// Whether no two triangles of the model share a vertex.
    pub is_loose: bool,
    /// The [stages](STAGES) of both, the largest difference first.
    pub terms: Vec<Term>,
}

impl Row {
    /// Predicted over measured, minus 1.
    pub fn error(&self) -> f64 {
        self.predicted / self.measured - 1.0
    }

    /// Largest relative error that holds.
    pub fn tolerance(&self) -> f64 {
        tolerance(self.is_loose)
    }

    /// All counters equal, and the time within the tolerance.
    pub fn holds(&self) -> bool {
        self.differing.is_empty() && self.error().abs() <= self.tolerance()
    }
}

/// Extent and settings of a comparison.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Options {
    /// Views round the model.
    pub views: u32,
    /// Frames of a view, of which the fastest counts.
    pub frames: u32,
    /// Rounds through everything: other users of the machine do not disturb every one.
    pub rounds: u32,
    /// Which clock.
    pub clock: Clock,
    /// What is sorted into tiles.
    pub sorting: Sorting,
}

/// A model to draw.
#[derive(Clone, Debug)]
pub struct Model {
    /// Its name in the table.
    pub name: String,
    /// The model under a light.
    pub scene: Scene,
    /// Its bounding box.
    pub bounds: Aabb,
}

/// One view of a row.
struct View<'a> {
    scene: &'a Scene,
    camera: Camera,
    settings: Settings,
    threads: usize,
    counters: Counters,
    /// Seconds until the end of each stage; the last one's are those of the frame.
    predicted: [f64; STAGES.len()],
    measured: [f64; STAGES.len()],
    differing: Vec<(&'static str, u64, u64)>,
}

impl View<'_> {
    fn measure(&mut self, o: Options) -> Result<(), PredictError> {
        let draw = |settings: &Settings| {
            measure(self.scene, &self.camera, settings, self.threads, o.frames, o.clock)
        };
        for ((last_stage, _), seconds) in STAGES.into_iter().zip(&mut self.measured).take(STAGES.len() - 1) {
            let settings = Settings { last_stage, ..self.settings.clone() };
            *seconds = seconds.min(draw(&settings)?.seconds);
        }
        let real = draw(&self.settings)?;
        let whole = &mut self.measured[STAGES.len() - 1];
        *whole = whole.min(real.seconds);
        let pairs =
            self.counters.comparable().into_iter().zip(Counters::from_stats(&real.stats).comparable());
        let differing = pairs.filter(|(ours, theirs)| ours != theirs);
        self.differing = differing.map(|((name, ours), (_, theirs))| (name, ours, theirs)).collect();
        Ok(())
    }
}

/// Predicts models at all sizes and numbers of threads, then draws all of them, round after round. `progress` is called
/// after each picture.
///
/// # Errors
/// [`PredictError`].
pub fn compare(
    machine: &Machine,
    models: &[Model],
    sizes: &[(u32, u32)],
    threads: &[usize],
    o: Options,
    mut progress: impl FnMut(),
) -> Result<Vec<Row>, PredictError> {
    let mut rows: Vec<(&Model, Vec<View>)> = Vec::new();
    for model in models {
        for &size in sizes {
            for &threads in threads {
                let views = (0..o.views.max(1)).map(|view| {
                    let camera = views::camera(&model.bounds, size, view, o.views);
                    let settings = Settings { sorting: o.sorting, ..Settings::one_sample(size.0, size.1) };
                    let (mut counters, mut predicted) = (Counters::default(), [0.0; STAGES.len()]);
                    for ((last_stage, _), seconds) in STAGES.into_iter().zip(&mut predicted) {
                        let settings = Settings { last_stage, ..settings.clone() };
                        let counted = count(&model.scene, &camera, &settings, threads)?;
                        *seconds = FrameTime::on_threads(machine, &counted, threads).total();
                        // Those of the last stage remain.
                        counters = counted.frame;
                    }
                    let (measured, differing) = ([f64::INFINITY; STAGES.len()], Vec::new());
                    let scene = &model.scene;
                    Ok(View { scene, camera, settings, threads, counters, predicted, measured, differing })
                });
                rows.push((model, views.collect::<Result<_, PredictError>>()?));
            }
        }
    }
    for _ in 0..o.rounds.max(1) {
        for (_, views) in &mut rows {
            views.iter_mut().try_for_each(|v| v.measure(o))?;
            progress();
        }
    }
    Ok(rows.into_iter().map(|(model, views)| row(model, &views, o.clock)).collect())
}

fn row(model: &Model, views: &[View], clock: Clock) -> Row {
    let first = &views[0];
    let mean = |of: fn(&View) -> [f64; STAGES.len()]| {
        let of_stage = |k: usize| views.iter().map(|v| of(v)[k]).sum::<f64>() / views.len() as f64;
        std::array::from_fn(of_stage)
    };
    let (predicted, measured) = (mean(|v| v.predicted), mean(|v| v.measured));
    Row {
        model: model.name.clone(),
        size: (first.settings.width, first.settings.height),
        threads: first.threads,
        clock,
        differing: views.iter().flat_map(|v| v.differing.iter().copied()).collect(),
        compared: views.iter().map(|v| v.counters.comparable().len()).sum(),
        predicted: predicted[STAGES.len() - 1],
        measured: measured[STAGES.len() - 1],
        is_loose: is_loose(&model.scene),
        terms: terms(STAGES.map(|s| s.1), of_stages(predicted), of_stages(measured)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machines::builtin;
    use crate::predict::calibrate::prepare;

    #[test]
    fn rows_compare_all_counters_of_all_views() {
        let machine = builtin("two-core-2026").unwrap().unwrap();
        let (scene, bounds) = prepare(tercio_mesh::builtin::make("builtin:gyroid@20k").unwrap());
        let models = [Model { name: "gyroid".into(), scene, bounds }];
        for sorting in [Sorting::Clusters, Sorting::Triangles] {
            let o = Options { views: 2, frames: 1, rounds: 2, clock: Clock::Wall, sorting };
            let mut calls = 0;
            let rows = compare(&machine, &models, &[(64, 48), (99, 77)], &[1, 2], o, || calls += 1).unwrap();
            assert_eq!((rows.len(), calls), (4, 8));
            for row in rows {
                assert_eq!((row.differing.len(), row.compared), (0, 44), "{row:?}");
                assert!(row.measured.is_finite() && row.predicted > 0.0 && !row.is_loose);
                let sum = |of: fn(&Term) -> f64| row.terms.iter().map(of).sum::<f64>();
                assert!((sum(|t| t.predicted) / row.predicted - 1.0).abs() < 1e-9, "{row:?}");
                assert!((sum(|t| t.measured) / row.measured - 1.0).abs() < 1e-9, "{row:?}");
            }
        }
    }

    #[test]
    fn triangles_are_loose_if_no_two_share_a_vertex() {
        for (model, expected) in [("builtin:soup@300", true), ("builtin:gyroid@2k", false)] {
            let (scene, _) = prepare(tercio_mesh::builtin::make(model).unwrap());
            assert_eq!(is_loose(&scene), expected, "{model}");
        }
    }

    #[test]
    fn a_row_holds_where_counters_are_equal_and_times_near() {
        let mut row = Row {
            model: "m".into(),
            size: (1, 1),
            threads: 1,
            clock: Clock::Wall,
            differing: vec![],
            compared: 1,
            predicted: 1.18,
            measured: 1.0,
            is_loose: true,
            terms: vec![],
        };
        assert!(row.holds());
        row.is_loose = false;
        assert!(!row.holds(), "a mesh has the smaller tolerance");
        row.predicted = 1.14;
        assert!(row.holds());
        row.differing.push(("triangles", 1, 2));
        assert!(!row.holds());
        row.differing.clear();
        row.measured = 2.0;
        assert!(!row.holds());
    }
}
