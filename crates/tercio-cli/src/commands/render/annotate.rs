//! What explains a picture.

use anyhow::{Context, Result};
use tercio::annotate::{Annotation, LaidOut};
use tercio::glam::DVec3;
use tercio::scene::Camera;

use super::Render;

/// What the layout of the annotation depends on, besides the camera.
pub(super) struct Annotated {
    pub annotation: Annotation,
    /// The box of the model.
    pub bounds: [DVec3; 2],
    /// The number of the axis that points upwards.
    pub up: usize,
}

impl Render {
    /// Whether the picture is drawn without its background, which is put behind it afterwards.
    pub(super) fn needs_transparency(&self) -> bool {
        self.effects.are_applied() || self.annotation.is_behind()
    }

    /// What is drawn onto the picture of a camera, and behind it.
    ///
    /// # Errors
    /// A camera that cannot be used.
    pub(super) fn lay_out(&self, annotated: &Annotated, camera: &Camera) -> Result<LaidOut> {
        let Annotated { annotation, bounds, up } = annotated;
        if annotation.is_empty() {
            return Ok(LaidOut::default());
        }
        let laid_out = annotation.lay_out(camera, self.drawing.size, *bounds, *up);
        laid_out.with_context(|| self.model.name())
    }
}
