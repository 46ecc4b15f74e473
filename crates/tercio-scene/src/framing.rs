//! Places a camera so that the model fills the picture.

use glam::DVec3;

use crate::{Camera, Projection};
use tercio_mesh::Aabb;

/// Which world axis points upwards.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum UpAxis {
    /// +x
    X,
    /// +y
    #[default]
    Y,
    /// +z
    Z,
}

/// Where the camera stands, seen from the model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum View {
    /// Looks at the side that faces the viewer.
    Front,
    /// From behind.
    Back,
    /// From the model's left in the front view.
    Left,
    /// From the model's right in the front view.
    Right,
    /// From above.
    Top,
    /// From below.
    Bottom,
    /// From above, front and right.
    Iso,
}

/// What the user asks of the camera; everything else follows from the model's bounds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Framing {
    /// Which axis points upwards.
    pub up_axis: UpAxis,
    /// Degrees round the up axis; 0 is the front, positive turns the camera to the model's right.
    pub azimuth: f64,
    /// Degrees above the horizon.
    pub elevation: f64,
    /// Degrees round the line of sight; positive turns the camera counter-clockwise.
    pub roll: f64,
    /// Above 1 shows the model larger.
    pub zoom: f64,
    /// Width by height of the picture.
    pub aspect: f64,
    /// Full vertical angle of view in degrees; `None` for an orthographic camera.
    pub fov_y: Option<f64>,
    /// The part of the picture that the model's bounds fill at zoom 1.
    pub fill: f64,
}

impl Framing {
    /// The camera for a model with these bounds.
    pub fn camera(&self, _bounds: &Aabb) -> Camera {
        Camera {
            eye: DVec3::Z,
            target: DVec3::ZERO,
            up: DVec3::Y,
            projection: Projection::Orthographic { height: 1.0 },
            near: None,
        }
    }
}
