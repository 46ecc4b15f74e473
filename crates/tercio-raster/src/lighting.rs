//! Lights in the form that the shading formulas use: in world axes, relative to the eye, in `f32` and [`View::unit`].

use glam::DVec3;
use tercio_scene::{Light, LightSpace};

use crate::view::{Sight, View};

/// A directional light.
#[derive(Clone, Copy, Debug)]
pub struct DistantLight {
    /// Unit vector towards it.
    pub to_light: [f32; 3],
    /// Linear RGB.
    pub color: [f32; 3],
}

/// A point light.
#[derive(Clone, Copy, Debug)]
pub struct NearLight {
    /// Position relative to the eye, in world axes and [`View::unit`].
    pub position: [f32; 3],
    /// Linear RGB.
    pub color: [f32; 3],
}

/// All lights of a frame.
#[derive(Clone, Debug, Default)]
pub struct LightRig {
    /// The sum of the ambient lights.
    pub ambient: [f32; 3],
    /// Directional lights, in the order of the scene.
    pub distant: Vec<DistantLight>,
    /// Point lights, in the order of the scene.
    pub near: Vec<NearLight>,
    /// The directions towards the viewer.
    pub sight: Sight,
}

impl LightRig {
    /// The scene's lights relative to the eye.
    pub fn new(lights: &[Light], view: &View) -> Self {
        let basis = &view.basis;
        let from_camera = |v: DVec3| basis.right * v.x + basis.up * v.y - basis.forward * v.z;
        let f = |v: DVec3| [v.x as f32, v.y as f32, v.z as f32];
        let mut rig = Self { sight: view.sight(), ..Self::default() };
        for light in lights {
            match *light {
                Light::Ambient { color } => {
                    rig.ambient = std::array::from_fn(|k| rig.ambient[k] + color[k]);
                }
                Light::Directional { to_light, space, color } => {
                    let world = match space {
                        LightSpace::World => to_light,
                        LightSpace::Camera => from_camera(to_light),
                    };
                    rig.distant.push(DistantLight { to_light: f(world.normalize_or_zero()), color });
                }
                Light::Point { position, space, color } => {
                    let relative = match space {
                        LightSpace::World => position - view.eye,
                        LightSpace::Camera => from_camera(position),
                    };
                    rig.near.push(NearLight { position: f(relative / view.unit), color });
                }
            }
        }
        rig
    }
}
