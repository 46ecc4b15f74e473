//! From points of the world to the picture, in `f64`, as the renderer's `View` does.

use glam::DVec3;
use tercio_mesh::trig;
use tercio_scene::camera::{CameraBasis, CameraError};
use tercio_scene::{Camera, Projection};

use crate::annotation::Shape;

/// Sub-pixels, to whole numbers of which a camera's shift is rounded.
const SUBPIXELS: f64 = 256.0;

/// What of a line's length before the eye is left out, relative to its other end: what is nearer cannot be projected.
const NEAREST: f64 = 1e-3;

/// How far points are from the middle of the picture of a camera, at most: across and down, in pixels of a picture of this size; `None` if
/// one is behind the eye, or none is beside the middle.
///
/// # Errors
/// [`CameraError`].
pub fn shape(
    camera: &Camera,
    (width, height): (u32, u32),
    points: impl IntoIterator<Item = DVec3>,
) -> Result<Option<Shape>, CameraError> {
    let projector = Projector::new(camera, [width, height].map(f64::from))?;
    let mut shape = [0.0f64; 2];
    for point in points {
        let Some(at) = projector.point(point) else { return Ok(None) };
        shape = [0, 1].map(|k| shape[k].max((at[k] - projector.middle[k]).abs()));
    }
    Ok(Some(shape).filter(|shape| shape.iter().all(|half| *half > 0.0 && half.is_finite())))
}

/// A camera's view of the world.
#[derive(Clone, Copy, Debug)]
pub struct Projector {
    /// The camera's axes.
    pub basis: CameraBasis,
    eye: DVec3,
    is_perspective: bool,
    /// Pixels per unit of length, at a distance of 1 for a perspective camera.
    scale: f64,
    middle: [f64; 2],
    target_distance: f64,
}

impl Projector {
    /// The view of a camera in a picture of this size.
    ///
    /// # Errors
    /// [`CameraError`].
    pub fn new(camera: &Camera, [width, height]: [f64; 2]) -> Result<Self, CameraError> {
        let basis = camera.basis()?;
        let (is_perspective, scale) = match camera.projection {
            Projection::Perspective { fov_y } => {
                let (sin, cos) = trig::sin_cos(fov_y * 0.5);
                (true, height * 0.5 * cos / sin)
            }
            Projection::Orthographic { height: units } => (false, height / units),
        };
        let at = |size: f64, shift: f64| size * 0.5 + (shift * height * SUBPIXELS).round() / SUBPIXELS;
        let middle = [at(width, camera.shift[0]), at(height, -camera.shift[1])];
        let target_distance = basis.forward.dot(camera.target - camera.eye);
        Ok(Self { basis, eye: camera.eye, is_perspective, scale, middle, target_distance })
    }

    /// A direction of the world in the picture's axes: to the right, downwards, away from the viewer.
    pub fn direction(&self, v: DVec3) -> DVec3 {
        DVec3::new(v.dot(self.basis.right), -v.dot(self.basis.up), v.dot(self.basis.forward))
    }

    /// Where a point is in the picture; `None` behind the eye of a perspective camera.
    pub fn point(&self, p: DVec3) -> Option<[f64; 2]> {
        let p = self.direction(p - self.eye);
        if !self.is_perspective {
            return Some([self.middle[0] + p.x * self.scale, self.middle[1] + p.y * self.scale]);
        }
        let factor = self.scale / p.z;
        (p.z > 0.0 && factor.is_finite())
            .then(|| [self.middle[0] + p.x * factor, self.middle[1] + p.y * factor])
    }

    /// What is seen of a line between two points.
    pub fn line(&self, a: DVec3, b: DVec3) -> Option<[[f64; 2]; 2]> {
        let [za, zb] = [a, b].map(|p| self.basis.forward.dot(p - self.eye));
        let nearest = za.max(zb) * NEAREST;
        let (mut a, mut b) = (a, b);
        if self.is_perspective {
            if !(nearest > 0.0) {
                return None;
            }
            if za < nearest {
                a = b + (a - b) * ((zb - nearest) / (zb - za));
            } else if zb < nearest {
                b = a + (b - a) * ((za - nearest) / (za - zb));
            }
        }
        Some([self.point(a)?, self.point(b)?])
    }

    /// Whether the outer side of a face of a box is seen: one that is perpendicular to an axis of the world, at `at`, with the
    /// rest of the box below it on the axis (`is_upper`) or above.
    pub fn sees(&self, axis: usize, at: f64, is_upper: bool) -> bool {
        let towards = if self.is_perspective { self.eye[axis] - at } else { -self.basis.forward[axis] };
        if is_upper { towards > 0.0 } else { towards < 0.0 }
    }

    /// Pixels per unit of length: everywhere for an orthographic camera, in the plane of its target for one with perspective.
    pub fn pixels_per_unit(&self) -> f64 {
        if self.is_perspective { self.scale / self.target_distance } else { self.scale }
    }

    /// Whether lengths depend on the distance.
    pub fn is_perspective(&self) -> bool {
        self.is_perspective
    }
}

/// A camera that shows in the inner part of a picture what `camera` shows in a picture of the size of that part: inside of
/// margins at the left, upper, right and lower border; `height` is that of the whole picture.
pub fn make_room(camera: &Camera, height: f64, margins: [f64; 4]) -> Camera {
    let [left, top, right, bottom] = margins;
    let inner = (height - top - bottom).max(1.0);
    let factor = height / inner;
    let projection = match camera.projection {
        Projection::Perspective { fov_y } => {
            let (sin, cos) = trig::sin_cos(fov_y * 0.5);
            Projection::Perspective { fov_y: 2.0 * trig::atan2(sin * factor, cos) }
        }
        Projection::Orthographic { height } => Projection::Orthographic { height: height * factor },
    };
    let shift = [(left - right) * 0.5 / height, (bottom - top) * 0.5 / height];
    Camera {
        projection,
        shift: [camera.shift[0] / factor + shift[0], camera.shift[1] / factor + shift[1]],
        ..*camera
    }
}
