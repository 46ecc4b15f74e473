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
    /// From infinitely far away, and from a wide area: diffuse light falls off with the square of half of one plus the
    /// cosine between normal and light, so that there is no visible line between lit and unlit sides. Any number of wide
    /// lights takes the time of one.
    ///
    /// Source: the wrapped ("half Lambert") diffuse term of Mitchell, McTaggart and Green, "Shading in Valve's Source
    /// Engine" (2006), squared as there.
    Wide {
        /// Towards the middle of the light; any length above 0.
        to_light: DVec3,
        /// Coordinate system of `to_light`.
        space: LightSpace,
        /// Linear RGB.
        color: [f32; 3],
        /// Whether it is reflected in specular surfaces; its highlight fades with the cosine.
        highlight: bool,
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
    /// From a point into a cone; brightness does not fall off with distance, and fades towards the edge of the cone.
    Spot {
        /// Its position.
        position: DVec3,
        /// The direction of the middle of the cone, away from the light; any length above 0.
        direction: DVec3,
        /// Coordinate system of `position` and `direction`.
        space: LightSpace,
        /// Half of the cone's opening, radians: above 0 and below half of pi.
        angle: f64,
        /// Linear RGB.
        color: [f32; 3],
    },
}

impl Light {
    /// A directional light at the camera that shines along the line of sight.
    pub fn headlight(color: [f32; 3]) -> Self {
        Self::Directional { to_light: DVec3::Z, space: LightSpace::Camera, color }
    }

    /// The lights of a picture for which none were chosen, all of them wide: a warm key light over the viewer's left
    /// shoulder, a cool fill light from the right, and a little light from below. A surface that faces the viewer shows
    /// about nine tenths of its colour.
    pub fn studio() -> Vec<Self> {
        let camera = |x, y, z, color, highlight| Self::Wide {
            to_light: DVec3::new(x, y, z),
            space: LightSpace::Camera,
            color,
            highlight,
        };
        vec![
            camera(-0.62, 0.8, 0.65, [1.18, 1.14, 1.08], true),
            camera(0.9, 0.1, 0.4, [0.08, 0.10, 0.13], false),
            camera(0.1, -0.9, 0.2, [0.03, 0.027, 0.025], false),
        ]
    }

    /// [`Light::studio`] with a key light that casts shadows: half of it directional, the other half wide, so that what is in
    /// shadow keeps its form.
    pub fn sunlit_studio() -> Vec<Self> {
        let mut lights = Self::studio();
        if let Some(Self::Wide { to_light, space, color, highlight }) = lights.first_mut() {
            let (to_light, space) = (*to_light, *space);
            let sun = Self::Directional { to_light, space, color: color.map(|c| 0.62 * c) };
            *color = color.map(|c| 0.45 * c);
            *highlight = false;
            lights.push(sun);
        }
        lights
    }
}
