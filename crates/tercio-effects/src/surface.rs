//! Where the visible surface is, in the camera's axes: x to the right, y upwards, z towards the viewer.

use fearless_simd::{Level, Simd};
use tercio_raster::conventions::SUBPIXELS;
use tercio_raster::view::View;
use tercio_raster::{Frame, Outputs, RenderError, Settings, SimdLevel};
use tercio_scene::{Camera, Scene};

use crate::lanes::{Lanes, Vec3};

/// What makes points of a frame's depths. Lengths are in a unit of the caller's.
pub struct Surface {
    /// Pixels across.
    pub width: usize,
    /// Pixels down.
    pub height: usize,
    /// False for an orthographic camera.
    pub perspective: bool,
    /// Pixels per unit of length; at a distance of one unit for a perspective camera.
    pub scale: f32,
    /// The middle of the projection, in pixels from the upper left corner of the picture.
    pub middle: [f32; 2],
    /// The camera's axes in world space.
    pub axes: [[f32; 3]; 3],
    /// Units of length per unit of the scene, in which the frame's depths are.
    pub per_world: f32,
}

impl Surface {
    /// The surface of a finished frame of this scene, camera and settings, and the SIMD level of the settings. The unit of
    /// length is `radii` times the radius of the scene.
    ///
    /// # Errors
    /// [`RenderError::Camera`].
    ///
    /// # Panics
    /// If the frame does not have the planes `needed` of a whole picture, or this processor does not have the SIMD level.
    pub fn of_frame(
        frame: &Frame,
        scene: &Scene,
        camera: &Camera,
        settings: &Settings,
        radii: f64,
        needed: &Outputs,
    ) -> Result<(Self, Level), RenderError> {
        let bounds = scene.bounds();
        let view = View::new(camera, &bounds, settings.width, settings.height)?;
        let pixels = settings.width as usize * settings.height as usize;
        let planes = &frame.planes;
        let is_complete = |is_needed: bool, length: usize| !is_needed || length == pixels;
        assert!(
            is_complete(needed.linear, planes.linear.len())
                && is_complete(needed.depth, planes.depth.len())
                && is_complete(needed.normals, planes.normals.len()),
            "the frame has the planes that the effect needs"
        );
        let level = settings.simd.unwrap_or_else(SimdLevel::best).level();
        let level = level.expect("the level with which the picture was drawn");
        let unit = (radii * bounds.radius()).max(f64::MIN_POSITIVE);
        Ok((Self::new(&view, unit), level))
    }

    /// The surface that a camera sees. `unit` is the unit of length, in world units.
    fn new(view: &View, unit: f64) -> Self {
        let per_world_unit = view.scale / f64::from(SUBPIXELS);
        let axes = [view.basis.right, view.basis.up, -view.basis.forward];
        Self {
            width: view.width as usize,
            height: view.height as usize,
            perspective: view.perspective,
            scale: if view.perspective { per_world_unit } else { per_world_unit * unit } as f32,
            middle: view.sight().middle.map(|m| m as f32 / SUBPIXELS as f32),
            axes: axes.map(|axis| axis.as_vec3().to_array()),
            // A scene of denormal size has no finite one.
            per_world: ((1.0 / unit) as f32).min(f32::MAX),
        }
    }

    /// Directions in world space, in the camera's axes.
    #[inline(always)]
    pub fn to_camera<S: Simd>(&self, v: Vec3<S>) -> Vec3<S> {
        let [x, y, z] = &self.axes;
        [along(x, v), along(y, v), along(z, v)]
    }
}

#[inline(always)]
fn along<S: Simd>(axis: &[f32; 3], v: Vec3<S>) -> Lanes<S> {
    (v[0] * axis[0] + v[1] * axis[1]) + v[2] * axis[2]
}
