//! Lights in the form that the shading formulas use: in world axes, relative to the eye, in `f32` and [`View::unit`].

use std::sync::Arc;

use glam::DVec3;
use tercio_scene::{Environment, Light, LightSpace};

use crate::view::{Sight, View};

/// A directional light.
#[derive(Clone, Copy, Debug)]
pub struct DistantLight {
    /// Unit vector towards it.
    pub to_light: [f32; 3],
    /// Linear RGB.
    pub color: [f32; 3],
}

/// A point or spot light.
#[derive(Clone, Copy, Debug)]
pub struct NearLight {
    /// Position relative to the eye, in world axes and [`View::unit`].
    pub position: [f32; 3],
    /// Linear RGB.
    pub color: [f32; 3],
    /// The cone of a spot light.
    pub cone: Option<Cone>,
}

/// The cone of a spot light.
#[derive(Clone, Copy, Debug)]
pub struct Cone {
    /// Unit vector from points in the middle of the cone towards the light.
    pub to_light: [f32; 3],
    /// Cosine of the angle between the middle and the edge.
    pub edge: f32,
    /// By which the cosine exceeds `edge` where the light is as bright as in the middle; above 0.
    pub fade: f32,
}

/// The share of the way from the edge of a spot light's cone to its middle, as cosines, on which it fades.
const FADE: f64 = 0.2;

/// The diffuse light of all ambient and wide lights and of the environment: a polynomial of the normal for each channel.
#[derive(Clone, Copy, Debug, Default)]
pub struct WideLight {
    /// Constant terms.
    pub constant: [f32; 3],
    /// Factors of x, y and z, by channel.
    pub linear: [[f32; 3]; 3],
    /// Factors of xx, xy, xz, yy, yz and zz, by channel.
    pub quadratic: [[f32; 6]; 3],
    /// Are there only ambient lights?
    pub is_constant: bool,
}

impl WideLight {
    /// The sum of the scene's ambient and wide lights and of an environment. `to_world` takes directions towards lights.
    fn new(
        lights: &[Light],
        environment: Option<&Environment>,
        to_world: impl Fn(DVec3, LightSpace) -> DVec3,
    ) -> Self {
        let mut sum = Self { is_constant: true, ..Self::default() };
        let (mut linear, mut quadratic) = ([[0.0; 3]; 3], [[0.0; 6]; 3]);
        let mut constant = [0.0; 3];
        for light in lights {
            match *light {
                Light::Ambient { color } => (0..3).for_each(|k| constant[k] += f64::from(color[k])),
                Light::Wide { to_light, space, color, .. } => {
                    sum.is_constant = false;
                    let [x, y, z] = to_world(to_light, space).to_array();
                    // ((1 + n . l) / 2)^2, multiplied out.
                    for (k, color) in color.into_iter().enumerate() {
                        let quarter = 0.25 * f64::from(color);
                        constant[k] += quarter;
                        let terms = [x, y, z].into_iter().zip(&mut linear[k]);
                        terms.for_each(|(term, to)| *to += 2.0 * quarter * term);
                        let terms = [x * x, 2.0 * x * y, 2.0 * x * z, y * y, 2.0 * y * z, z * z];
                        let terms = terms.into_iter().zip(&mut quadratic[k]);
                        terms.for_each(|(term, to)| *to += quarter * term);
                    }
                }
                Light::Directional { .. } | Light::Point { .. } | Light::Spot { .. } => {}
            }
        }
        if let Some(environment) = environment {
            sum.is_constant = false;
            for (k, light) in environment.diffuse().iter().enumerate() {
                constant[k] += light.constant;
                linear[k].iter_mut().zip(light.linear).for_each(|(to, term)| *to += term);
                quadratic[k].iter_mut().zip(light.quadratic).for_each(|(to, term)| *to += term);
            }
        }
        sum.constant = constant.map(|c| c as f32);
        sum.linear = linear.map(|channel| channel.map(|c| c as f32));
        sum.quadratic = quadratic.map(|channel| channel.map(|c| c as f32));
        sum
    }
}

/// All lights of a frame.
#[derive(Clone, Debug, Default)]
pub struct LightRig {
    /// Ambient and wide lights, and the environment.
    pub wide: WideLight,
    /// What smooth surfaces mirror of the ambient and wide lights.
    pub mirrored: WideLight,
    /// What they mirror besides.
    pub environment: Option<Arc<Environment>>,
    /// The wide lights that have a highlight, in the order of the scene.
    pub highlights: Vec<DistantLight>,
    /// Directional lights, in the order of the scene.
    pub distant: Vec<DistantLight>,
    /// Point lights, in the order of the scene.
    pub near: Vec<NearLight>,
    /// The directions towards the viewer.
    pub sight: Sight,
}

impl LightRig {
    /// The scene's lights relative to the eye.
    pub fn new(lights: &[Light], environment: Option<&Arc<Environment>>, view: &View) -> Self {
        let basis = &view.basis;
        let from_camera = |v: DVec3| basis.right * v.x + basis.up * v.y - basis.forward * v.z;
        let f = |v: DVec3| [v.x as f32, v.y as f32, v.z as f32];
        let to_world = |to_light: DVec3, space| {
            let world = match space {
                LightSpace::World => to_light,
                LightSpace::Camera => from_camera(to_light),
            };
            world.normalize_or_zero()
        };
        let wide = WideLight::new(lights, environment.map(|e| &**e), to_world);
        let mirrored = WideLight::new(lights, None, to_world);
        let environment = environment.cloned();
        let mut rig = Self { sight: view.sight(), wide, mirrored, environment, ..Self::default() };
        for light in lights {
            match *light {
                Light::Ambient { .. } => {}
                Light::Wide { to_light, space, color, highlight } => {
                    if highlight {
                        rig.highlights.push(DistantLight { to_light: f(to_world(to_light, space)), color });
                    }
                }
                Light::Directional { to_light, space, color } => {
                    rig.distant.push(DistantLight { to_light: f(to_world(to_light, space)), color });
                }
                Light::Point { position, space, color } => {
                    let relative = match space {
                        LightSpace::World => position - view.eye,
                        LightSpace::Camera => from_camera(position),
                    };
                    rig.near.push(NearLight { position: f(relative / view.unit), color, cone: None });
                }
                Light::Spot { position, direction, space, angle, color } => {
                    let relative = match space {
                        LightSpace::World => position - view.eye,
                        LightSpace::Camera => from_camera(position),
                    };
                    let (_, edge) = tercio_mesh::trig::sin_cos(angle);
                    let fade = ((1.0 - edge) * FADE).max(f64::from(f32::EPSILON)) as f32;
                    let to_light = f(-to_world(direction, space));
                    let cone = Some(Cone { to_light, edge: edge as f32, fade });
                    rig.near.push(NearLight { position: f(relative / view.unit), color, cone });
                }
            }
        }
        rig
    }
}
