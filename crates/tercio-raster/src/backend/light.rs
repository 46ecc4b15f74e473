//! Lighting: the light that 16 points of a surface reflect to the viewer.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16, mask32x16};
use tercio_scene::Surface;

use super::shade::Features;
use crate::lighting::{DistantLight, LightRig, NearLight, WideLight};
use crate::simd::{dot, each3, part, splat};

/// Vectors or colours of 16 points.
pub type Vec3x16<S> = [f32x16<S>; 3];

/// Reflected light of 16 points.
pub struct Reflected<S: Simd> {
    /// Diffuse light, linear RGB, to be multiplied by the surface's colour.
    pub diffuse: Vec3x16<S>,
    /// Specular light, linear RGB, to be added.
    pub specular: Vec3x16<S>,
}

/// A unit vector in the same direction; `instead` if the length is close to zero.
#[inline(always)]
pub fn normalize<S: Simd>(simd: S, v: Vec3x16<S>, instead: Vec3x16<S>) -> Vec3x16<S> {
    part(
        simd,
        #[inline(always)]
        || {
            let square = dot(v, v);
            let long_enough = square.simd_gt(splat(simd, 1e-30));
            let inverse = splat(simd, 1.0) / square.sqrt();
            each3!(K => long_enough.select(v[K] * inverse, instead[K]))
        },
    )
}

/// Lambert's diffuse light and Blinn's specular light of all lights.
///
/// `normal` and `to_viewer` are unit vectors in world axes, `position` is relative to the eye.
#[inline(always)]
pub fn reflect<S: Simd, F: Features>(
    simd: S,
    features: F,
    rig: &LightRig,
    surface: &Surface,
    normal: &Vec3x16<S>,
    to_viewer: &Vec3x16<S>,
    position: &Vec3x16<S>,
) -> Reflected<S> {
    if F::ARE_SPECIAL {
        sum_lights(simd, features, rig, surface, *normal, *to_viewer, *position)
    } else {
        reflect_apart(simd, features, rig, surface, normal, to_viewer, position)
    }
}

/// [`sum_lights`] as a function of its own. Not inlined, because it is long and called from four places.
#[inline(never)]
fn reflect_apart<S: Simd, F: Features>(
    simd: S,
    features: F,
    rig: &LightRig,
    surface: &Surface,
    normal: &Vec3x16<S>,
    to_viewer: &Vec3x16<S>,
    position: &Vec3x16<S>,
) -> Reflected<S> {
    simd.vectorize(
        #[inline(always)]
        || sum_lights(simd, features, rig, surface, *normal, *to_viewer, *position),
    )
}

/// The replacement for the direction of a zero vector: towards the viewer, in the middle of the view.
#[inline(always)]
pub fn beside<S: Simd>(simd: S, rig: &LightRig) -> Vec3x16<S> {
    each3!(K => splat(simd, rig.sight.base[K]))
}

/// Directions towards the viewer, not normalized, from samples in sub-pixels; `from_middle` is the offset that makes
/// their coordinates relative to the middle of the picture.
#[inline(always)]
pub fn towards_viewer<S: Simd>(
    simd: S,
    rig: &LightRig,
    sample: [i32x16<S>; 2],
    from_middle: [i32; 2],
) -> Vec3x16<S> {
    let x: f32x16<S> = (sample[0] + from_middle[0]).to_float();
    let y: f32x16<S> = (sample[1] + from_middle[1]).to_float();
    let sight = &rig.sight;
    part(
        simd,
        #[inline(always)]
        || each3!(K => (splat(simd, sight.base[K]) + x * sight.right[K]) + y * sight.down[K]),
    )
}

/// Bends unit normals that point away from the viewer until they are perpendicular to the line of sight; returns the
/// others unchanged. `to_viewer` need not be normalized.
#[inline(always)]
pub fn bend<S: Simd>(simd: S, normal: Vec3x16<S>, to_viewer: Vec3x16<S>) -> Vec3x16<S> {
    let away = dot(normal, to_viewer);
    let is_away = away.simd_lt(splat(simd, 0.0));
    if !is_away.any_true() {
        return normal;
    }
    let square = dot(to_viewer, to_viewer);
    let bent = each3!(K => normal[K] * square - to_viewer[K] * away);
    let bent = normalize(simd, bent, normal);
    each3!(K => is_away.select(bent[K], normal[K]))
}

/// The diffuse light of ambient and wide lights and of the environment.
#[inline(always)]
pub fn wide<S: Simd>(simd: S, rig: &LightRig, n: Vec3x16<S>) -> Vec3x16<S> {
    polynomial(simd, &rig.wide, n)
}

/// The values of a polynomial for 16 unit vectors.
#[inline(always)]
pub fn polynomial<S: Simd>(simd: S, light: &WideLight, n: Vec3x16<S>) -> Vec3x16<S> {
    let constant = each3!(K => splat(simd, light.constant[K]));
    if light.is_constant {
        return constant;
    }
    part(
        simd,
        #[inline(always)]
        || {
            let [x, y, z] = n;
            each3!(K => {
                let (l, q) = (&light.linear[K], &light.quadratic[K]);
                let of_x = x * ((x * q[0] + y * q[1]) + (z * q[2] + l[0]));
                let of_y = y * ((y * q[3] + z * q[4]) + l[1]);
                let of_z = z * (z * q[5] + l[2]);
                ((constant[K] + of_x) + of_y) + of_z
            })
        },
    )
}

/// Ambient light and Lambert's diffuse light of the directional lights: the result of [`reflect`] if there are no point
/// lights and no highlights.
#[inline(always)]
pub fn diffuse<S: Simd>(simd: S, rig: &LightRig, normal: Vec3x16<S>) -> Vec3x16<S> {
    let mut sum = wide(simd, rig, normal);
    for light in &rig.distant {
        let to_light = each3!(K => splat(simd, light.to_light[K]));
        let (cosine, _) = facing(simd, normal, to_light);
        sum = each3!(K => sum[K] + cosine * light.color[K]);
    }
    sum
}

/// The cosine of the angle between normal and light, clamped to at least 0, and the lanes where it is above 0.
#[inline(always)]
fn facing<S: Simd>(simd: S, normal: Vec3x16<S>, to_light: Vec3x16<S>) -> (f32x16<S>, mask32x16<S>) {
    part(
        simd,
        #[inline(always)]
        || {
            let zero = splat(simd, 0.0);
            let cosine = dot(normal, to_light);
            let lit = cosine.simd_gt(zero);
            (lit.select(cosine, zero), lit)
        },
    )
}

#[inline(always)]
fn square<S: Simd>(v: f32x16<S>) -> f32x16<S> {
    v * v
}

#[inline(always)]
fn sum_lights<S: Simd, F: Features>(
    simd: S,
    features: F,
    rig: &LightRig,
    surface: &Surface,
    normal: Vec3x16<S>,
    to_viewer: Vec3x16<S>,
    position: Vec3x16<S>,
) -> Reflected<S> {
    let zero = splat(simd, 0.0);
    let mut sum = Reflected { diffuse: wide(simd, rig, normal), specular: [zero; 3] };
    for light in &rig.distant {
        let to_light = each3!(K => splat(simd, light.to_light[K]));
        add_light(simd, features, rig, surface, normal, to_viewer, to_light, light.color, &mut sum);
    }
    let near: &[NearLight] = if features.near_lights() { &rig.near } else { &[] };
    for light in near {
        let offset = each3!(K => splat(simd, light.position[K]) - position[K]);
        let to_light = normalize(simd, offset, beside(simd, rig));
        add_light(simd, features, rig, surface, normal, to_viewer, to_light, light.color, &mut sum);
    }
    if features.highlights() {
        for light in &rig.highlights {
            add_highlight(simd, rig, surface, normal, to_viewer, light, &mut sum.specular);
        }
    }
    sum
}

/// Adds the highlight of a wide light, which fades with the cosine between normal and light.
#[inline(always)]
fn add_highlight<S: Simd>(
    simd: S,
    rig: &LightRig,
    surface: &Surface,
    normal: Vec3x16<S>,
    to_viewer: Vec3x16<S>,
    light: &DistantLight,
    specular: &mut Vec3x16<S>,
) {
    part(
        simd,
        #[inline(always)]
        || {
            let to_light = each3!(K => splat(simd, light.to_light[K]));
            let (cosine, lit) = facing(simd, normal, to_light);
            // It would add zeros.
            if !lit.any_true() {
                return;
            }
            let strength =
                (blinn(simd, rig, surface, normal, to_viewer, to_light, lit) * surface.specular) * cosine;
            for k in 0..3 {
                specular[k] += strength * light.color[k];
            }
        },
    );
}

/// Blinn's highlight in the lanes that are lit, 0 in the others.
#[inline(always)]
fn blinn<S: Simd>(
    simd: S,
    rig: &LightRig,
    surface: &Surface,
    normal: Vec3x16<S>,
    to_viewer: Vec3x16<S>,
    to_light: Vec3x16<S>,
    lit: mask32x16<S>,
) -> f32x16<S> {
    let zero = splat(simd, 0.0);
    let between = each3!(K => to_light[K] + to_viewer[K]);
    let half = normalize(simd, between, beside(simd, rig));
    let mut power = dot(normal, half);
    power = (power.simd_gt(zero) & lit).select(power, zero);
    if surface.shininess_log2 == 5 {
        // The default, without a loop.
        let to_the_8 = square(square(square(power)));
        return square(square(to_the_8));
    }
    for _ in 0..surface.shininess_log2 {
        power = square(power);
    }
    power
}

#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "locals of the callers; a struct would only rename them")]
fn add_light<S: Simd, F: Features>(
    simd: S,
    features: F,
    rig: &LightRig,
    surface: &Surface,
    normal: Vec3x16<S>,
    to_viewer: Vec3x16<S>,
    to_light: Vec3x16<S>,
    color: [f32; 3],
    sum: &mut Reflected<S>,
) {
    part(
        simd,
        #[inline(always)]
        || {
            let (cosine, lit) = facing(simd, normal, to_light);
            // It would add zeros.
            if !lit.any_true() {
                return;
            }
            for k in 0..3 {
                sum.diffuse[k] += cosine * color[k];
            }
            if features.highlights() {
                let power = blinn(simd, rig, surface, normal, to_viewer, to_light, lit);
                let strength = power * surface.specular;
                for k in 0..3 {
                    sum.specular[k] += strength * color[k];
                }
            }
        },
    )
}
