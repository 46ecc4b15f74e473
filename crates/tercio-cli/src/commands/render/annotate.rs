//! What explains a picture.

use std::borrow::Cow;

use anyhow::{Context, Result};
use tercio::annotate::{Annotation, LaidOut};
use tercio::glam::DVec3;
use tercio::scene::Camera;

use super::Render;
use crate::args::annotation;
use crate::series::pattern::Names;

/// What the layout of the annotation depends on, besides the camera.
pub(super) struct Annotated {
    /// With placeholders in its texts.
    pub annotation: Annotation,
    /// What they stand for in every picture; empty if there are none, and no doubled braces.
    pub names: Vec<Names>,
    /// The number of the picture that is drawn.
    pub shot: usize,
    /// The box of the model.
    pub bounds: [DVec3; 2],
    /// The axis that points upwards.
    pub up: DVec3,
}

impl Annotated {
    /// The annotation of the picture that is drawn.
    pub fn of_picture(&self) -> Cow<'_, Annotation> {
        match self.names.get(self.shot) {
            Some(names) => Cow::Owned(annotation::of_picture(&self.annotation, names)),
            None => Cow::Borrowed(&self.annotation),
        }
    }
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
        let Annotated { bounds, up, .. } = annotated;
        let annotation = annotated.of_picture();
        if annotation.is_empty() {
            return Ok(LaidOut::default());
        }
        let laid_out = annotation.lay_out(camera, self.drawing.size, *bounds, *up);
        laid_out.with_context(|| self.model.name())
    }
}
