//! Ambient occlusion in screen space: darkens what little of the surroundings can reach.
//!
//! What occludes a visible point is looked for among the other visible points, along lines of the picture through it: in
//! the plane of such a line and the line of sight, the surroundings are open above the horizons on both sides, and the
//! light that enters between them, weighted by its cosine with the normal, has a closed formula. A horizon counts the
//! less the farther away it is, and not at all beyond the radius. What is hidden, or outside the picture, occludes
//! nothing. Source: Jimenez, Wu, Pesce and Jarabo, "Practical real-time strategies for accurate indirect occlusion"
//! (2016).
//!
//! [`horizon`] does this for 16 points; [`blocks`] for every second pixel of every second row, with lines of 32 directions
//! that alternate in patterns of 4 x 4, so that pixels at the same place of the pattern see what lies side by side.
//! [`smooth`] averages over such a pattern, which has every direction once, along each of these pixels' tangent planes; the
//! other pixels take the means of their neighbours, or are computed themselves if none is near.

mod blocks;
mod coarse;
mod horizon;
mod pattern;
mod smooth;

use tercio_raster::{Frame, Outputs, RenderError, Settings};
use tercio_scene::{Camera, Scene};

use crate::darken::bands;
use crate::surface::Surface;
use blocks::{Finder, Visible};
use coarse::Coarse;
use smooth::Smoother;

/// How ambient occlusion looks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AmbientOcclusion {
    /// How far surfaces darken each other, relative to the radius of the scene; above 0, at most
    /// [`AmbientOcclusion::MAX_RADIUS`].
    pub radius: f64,
    /// 0 for none to 1: the share of light that is taken from what is wholly occluded.
    pub strength: f32,
}

impl Default for AmbientOcclusion {
    fn default() -> Self {
        Self { radius: 0.2, strength: 1.0 }
    }
}

impl AmbientOcclusion {
    /// The largest radius.
    pub const MAX_RADIUS: f64 = 2.0;

    /// The planes that it needs; frames may have others besides.
    pub const NEEDED: Outputs = Outputs { linear: true, depth: true, normals: true, ..Outputs::NONE };

    /// Darkens the colours of a finished frame of this scene, camera and settings: its linear plane, and the 8-bit and
    /// 16-bit planes if it has them.
    ///
    /// # Errors
    /// [`RenderError::Setting`] if radius or strength is out of range; [`RenderError::Camera`].
    ///
    /// # Panics
    /// If the frame does not have the planes [`AmbientOcclusion::NEEDED`] of a whole picture, or this processor does not
    /// have the SIMD level of the settings.
    pub fn apply(
        &self,
        frame: &mut Frame,
        scene: &Scene,
        camera: &Camera,
        settings: &Settings,
    ) -> Result<(), RenderError> {
        let setting = |what, range: String, value: f64| {
            Err(RenderError::Setting { what, range, value: value.to_string() })
        };
        if !(self.radius > 0.0 && self.radius <= Self::MAX_RADIUS) {
            let range = format!("above 0, at most {}", Self::MAX_RADIUS);
            return setting("radius of ambient occlusion", range, self.radius);
        }
        if !(0.0..=1.0).contains(&self.strength) {
            return setting("strength of ambient occlusion", "0 to 1".into(), self.strength.into());
        }
        let (surface, level) = Surface::of_frame(frame, scene, camera, settings, self.radius, &Self::NEEDED)?;
        // The other planes stay as they are while the colours change.
        let planes = &mut frame.planes;
        let (depth, normals) = (std::mem::take(&mut planes.depth), std::mem::take(&mut planes.normals));
        let visible = Visible { surface: &surface, depth: &depth, normals: &normals };
        let coarse = Coarse::new(&surface, &depth, &normals, level);
        let finder = Finder::new(visible, &coarse, level);
        let occlusion = finder.of_coarse(level);
        let smoother = Smoother { finder: &finder, occlusion: &occlusion, strength: self.strength, level };
        smoother.darken(bands(planes, surface.width, smooth::BAND));
        (planes.depth, planes.normals) = (depth, normals);
        Ok(())
    }
}
