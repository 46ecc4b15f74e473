//! Experiments that need a simulator and a scene.
//!
//! The documents' scenes are lost. They are replaced by built-in models under a camera, by scenes made from the
//! statistics that a document prints, or by random ones; each experiment says by which.

mod mcmanus;
mod ortega;
mod parks;
mod ring;

use super::{Experiment, ExperimentError};
use crate::workloads::projection::Model;
use crate::workloads::{BoxScene, PolygonScene};
use tercio_mesh::builtin;
use tercio_scene::Framing;

pub(super) const ROOMS: [&[Experiment]; 4] =
    [ring::EXPERIMENTS, parks::EXPERIMENTS, mcmanus::EXPERIMENTS, ortega::EXPERIMENTS];

/// Boxes of a built-in model that fills a screen.
fn model_boxes(spec: &str, size: (u32, u32)) -> Result<BoxScene, ExperimentError> {
    let model = Model::new(builtin::make(spec)?);
    let camera = Framing::for_size(size.0, size.1).camera_for_scene(model.scene());
    Ok(model.boxes(&camera, size)?)
}

/// Polygons of a built-in model that fills a screen.
fn model_polygons(spec: &str, size: (u32, u32)) -> Result<PolygonScene, ExperimentError> {
    let model = Model::new(builtin::make(spec)?);
    let camera = Framing::for_size(size.0, size.1).camera_for_scene(model.scene());
    Ok(model.polygons(&camera, size)?)
}

/// 1 for true: a comparison of shapes.
fn truth(claim: bool) -> f64 {
    f64::from(u8::from(claim))
}

#[cfg(test)]
mod tests {
    use super::super::{Outcome, Verdict};
    use super::*;
    use rayon::prelude::*;

    #[test]
    fn no_experiment_is_contradicted() {
        let experiments: Vec<_> = ROOMS.iter().flat_map(|room| room.iter().copied()).collect();
        let run = |&experiment: &Experiment| Outcome { experiment, findings: (experiment.run)() };
        let outcomes: Vec<Outcome> = experiments.par_iter().map(run).collect();
        let failed = outcomes.iter().filter_map(|o| match &o.findings {
            Ok(findings) => match &findings.verdict {
                Verdict::Contradicted { why } => Some(format!("{}: {why}", o.experiment.id)),
                _ => None,
            },
            Err(error) => Some(format!("{}: {error}", o.experiment.id)),
        });
        let failed: Vec<_> = failed.collect();
        assert!(failed.is_empty(), "{failed:#?}");
    }
}
