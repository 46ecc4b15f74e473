//! Which lights reach 16 points of an instance.

use fearless_simd::{Simd, f32x16};

use super::light::Shadows;
use crate::backend::light::Vec3x16;
use crate::context::FrameContext;
use crate::shadow_map::LightNumber;
use crate::simd::{LANES, load, splat};

/// 16 points of an instance.
pub struct ShadowedPoints<'a, S: Simd> {
    pub context: &'a FrameContext<'a>,
    pub instance: usize,
    /// Relative to the pivot.
    pub position: Vec3x16<S>,
    /// Normals of the triangles' planes in world axes, of any length.
    pub plane: Vec3x16<S>,
}

impl<S: Simd> Shadows<S> for ShadowedPoints<'_, S> {
    #[inline(always)]
    fn lit(&self, simd: S, light: LightNumber, lanes: u32) -> f32x16<S> {
        match &self.context.settings.shadows {
            Some(_) => lit_apart(simd, self, light, lanes),
            None => splat(simd, 1.0),
        }
    }
}

/// The share of a light that reaches the points. The points are looked up one by one. Not inlined, because it is called from
/// several places.
#[inline(never)]
fn lit_apart<S: Simd>(simd: S, points: &ShadowedPoints<S>, light: LightNumber, lanes: u32) -> f32x16<S> {
    let mut lit = [1.0; LANES];
    if let (Some(maps), Some(shadows)) =
        (&points.context.settings.shadows, points.context.shadows.get(points.instance))
    {
        for lane in (0..LANES).filter(|lane| lanes >> lane & 1 == 1) {
            let of_lane = |v: &Vec3x16<S>| [v[0][lane], v[1][lane], v[2][lane]];
            lit[lane] = shadows.lit(maps, light, of_lane(&points.position), of_lane(&points.plane));
        }
    }
    load(simd, &lit)
}
