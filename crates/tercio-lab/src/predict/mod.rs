//! Predictions for the real renderer: from a machine's description, measured, and compared.
//!
//! | module | what |
//! |---|---|
//! | [`views`] | the scenes and cameras of `tercio bench` |
//! | [`counts`] | the work of a frame, by the renderer's own counts |
//! | `occlusion` | the samples looked at to find out what is hidden |
//! | [`boxes`] | its triangles as boxes of samples, for simulated ranks |
//! | [`frame`] | times from counts and costs: one process with several threads |
//! | [`ranks`] | the same for ranks that share a frame |
//! | [`choose`] | how ranks share a frame, chosen before it is drawn: `--organisation auto` |
//! | [`advise`] | the best way to draw a model on a machine, and why |
//! | [`measure`] | the real renderer's counters and times |
//! | [`usage`] | page faults and context switches |
//! | [`hardware`] | caches and memory of this machine |
//! | [`messages`] | latency and bandwidth of messages, between threads or over MPI |
//! | [`fit`] | fits costs to measured frames |
//! | [`calibrate`] | measures the description of this machine |
//! | [`validate`] | predicted against measured |
//! | [`difference`] | the terms of the difference between both |
//! | [`validate_advice`] | the advised way to draw against all others |
//! | [`validate_ranks`] | the same for ranks, of one process or several |
//! | [`quoted`] | tables of results in the repository |

pub mod advise;
pub mod boxes;
pub mod calibrate;
pub mod choose;
pub mod counts;
pub mod difference;
pub mod fit;
pub mod frame;
pub mod hardware;
pub mod measure;
pub mod messages;
mod occlusion;
pub mod quoted;
pub mod ranks;
pub mod usage;
pub mod validate;
pub mod validate_advice;
pub mod validate_ranks;
pub mod views;

use thiserror::Error;

/// Why there is no prediction.
#[derive(Debug, Error)]
pub enum PredictError {
    /// The machine's description lacks something.
    #[error(transparent)]
    Machine(#[from] crate::machines::MachineError),
    /// The picture cannot be drawn.
    #[error(transparent)]
    Render(#[from] tercio_raster::RenderError),
    /// The camera makes no view.
    #[error(transparent)]
    Camera(#[from] tercio_scene::camera::CameraError),
    /// Messages could not be measured.
    #[error(transparent)]
    Messages(#[from] tercio_parallel::ParallelError),
    /// The pool of threads could not be started.
    #[error("{0} threads: {1}")]
    Threads(usize, rayon::ThreadPoolBuildError),
    /// The renderer's ranks share a frame in a way without a model.
    #[error("there is no model of {0} ranks of the renderer")]
    Organisation(tercio_parallel::Organisation),
    /// A calibration on a machine that was too busy.
    #[error(
        "this machine is too busy to be measured: {0}; measure it when it is idle, with more --rounds, or with --clock \
         processor"
    )]
    Noisy(String),
    /// Groups do not divide a SIMD ring.
    #[error(transparent)]
    Ring(#[from] crate::simulators::ring::AlgorithmError),
    /// What was decided leaves no way to share a frame.
    #[error(transparent)]
    NoCandidate(#[from] choose::candidates::NoCandidate),
}
