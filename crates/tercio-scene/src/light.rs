//! Lights.

use glam::DVec3;

/// The coordinate system of a light's direction or position.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LightSpace {
    /// The light is fixed in the world.
    World,
    /// The light moves with the camera: x right, y up, z towards the viewer, origin at the eye.
    Camera,
}

/// A light. Colours are linear and may be above 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Light {
    /// The same from all directions.
    Ambient {
        /// Linear RGB.
        color: [f32; 3],
    },
    /// From infinitely far away.
    Directional {
        /// Towards the light; any length above 0.
        to_light: DVec3,
        /// Coordinate system of `to_light`.
        space: LightSpace,
        /// Linear RGB.
        color: [f32; 3],
    },
    /// From a point; brightness does not fall off with distance.
    Point {
        /// Its position.
        position: DVec3,
        /// Coordinate system of `position`.
        space: LightSpace,
        /// Linear RGB.
        color: [f32; 3],
    },
}

impl Light {
    /// A directional light at the camera that shines along the line of sight.
    pub fn headlight(color: [f32; 3]) -> Self {
        Self::Directional { to_light: DVec3::Z, space: LightSpace::Camera, color }
    }

    /// The lights of a picture for which none were chosen: a warm key light over the viewer's left shoulder, a cool
    /// fill light from the right, and a little ambient light.
    pub fn studio() -> Vec<Self> {
        let camera = |x, y, z, color| Self::Directional {
            to_light: DVec3::new(x, y, z),
            space: LightSpace::Camera,
            color,
        };
        vec![
            Self::Ambient { color: [0.070, 0.074, 0.088] },
            camera(-0.5, 0.75, 0.6, [1.0, 0.92, 0.82]),
            camera(0.9, 0.05, 0.35, [0.12, 0.16, 0.23]),
            camera(0.1, -0.9, 0.2, [0.05, 0.04, 0.03]),
        ]
    }
}
