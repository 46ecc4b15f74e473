//! Predicted against measured.

use serde::Serialize;
use tercio_mesh::Aabb;
use tercio_raster::{Settings, Sorting};
use tercio_scene::Scene;

use super::counters::{Counters, count};
use super::frame::FrameTime;
use super::measure::{Clock, measure};
use super::{PredictError, views};
use crate::machines::Machine;

/// Times hold if they lie this close.
pub const TOLERANCE: f64 = 0.25;

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
}

impl Row {
    /// Predicted over measured, less 1.
    pub fn error(&self) -> f64 {
        self.predicted / self.measured - 1.0
    }

    /// All counters equal, and the time within [`TOLERANCE`].
    pub fn holds(&self) -> bool {
        self.differing.is_empty() && self.error().abs() <= TOLERANCE
    }
}

/// What is compared and how.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Options {
    /// Views round the model.
    pub views: u32,
    /// Frames of a view, of which the fastest counts.
    pub frames: u32,
    /// Which clock.
    pub clock: Clock,
    /// What is sorted into tiles.
    pub sorting: Sorting,
}

/// Compares one model at one size on some threads.
///
/// # Errors
/// [`PredictError`].
pub fn compare(
    machine: &Machine,
    (name, scene, bounds): (&str, &Scene, &Aabb),
    size: (u32, u32),
    threads: usize,
    o: Options,
) -> Result<Row, PredictError> {
    let mut row = Row {
        model: name.into(),
        size,
        threads,
        clock: o.clock,
        differing: Vec::new(),
        compared: 0,
        predicted: 0.0,
        measured: 0.0,
    };
    for view in 0..o.views.max(1) {
        let camera = views::camera(bounds, size, view, o.views);
        let settings = Settings { sorting: o.sorting, ..Settings::new(size.0, size.1) };
        let real = measure(scene, &camera, &settings, threads, o.frames, o.clock)?;
        let counted = count(scene, &camera, &settings, threads)?;
        let pairs = counted.frame.comparable().into_iter().zip(Counters::counted(&real.stats));
        for ((name, ours), (_, theirs)) in pairs {
            row.compared += 1;
            if ours != theirs {
                row.differing.push((name, ours, theirs));
            }
        }
        row.predicted +=
            FrameTime::on_threads(machine, &counted, threads).total() / f64::from(o.views.max(1));
        row.measured += real.seconds / f64::from(o.views.max(1));
    }
    Ok(row)
}
