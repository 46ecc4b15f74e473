//! Experiments that need a simulator and a scene.
//!
//! The documents' scenes are lost. They are replaced by built-in models under a camera, by scenes made from the
//! statistics that a document prints, or by random ones; each experiment names its replacement.

pub(super) mod mcmanus;
pub(super) mod objects;
pub(super) mod ortega;
pub(super) mod parks;
pub(super) mod ring;
pub(super) mod sections;

use super::ExperimentError;
use crate::workloads::projection::Model;
use crate::workloads::{BoxScene, PolygonScene};
use tercio_mesh::builtin;
use tercio_scene::Framing;

/// Boxes of a built-in model that fills a screen.
fn model_boxes(spec: &str, size: (u32, u32)) -> Result<BoxScene, ExperimentError> {
    let model = Model::new(builtin::make(spec)?);
    let camera = Framing::new(size.0, size.1).camera_for_scene(model.scene());
    Ok(model.boxes(&camera, size)?)
}

/// Polygons of a built-in model that fills a screen.
fn model_polygons(spec: &str, size: (u32, u32)) -> Result<PolygonScene, ExperimentError> {
    let model = Model::new(builtin::make(spec)?);
    let camera = Framing::new(size.0, size.1).camera_for_scene(model.scene());
    Ok(model.polygons(&camera, size)?)
}
