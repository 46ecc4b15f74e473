//! The light that materials reflect. For the sources, see the reference.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};
use tercio_scene::Environment;

use super::evaluate::Evaluated;
use crate::backend::light::{Vec3x16, beside, normalize, polynomial, wide};
use crate::conventions::{DIELECTRIC, LEAST_ROUGHNESS};
use crate::lighting::LightRig;
use crate::shadow_map::LightNumber;
use crate::simd::{LANES, dot, each3, load, part, splat, splat_i};

/// A light as seen from 16 points.
struct Seen<S: Simd> {
    to_light: Vec3x16<S>,
    color: [f32; 3],
    /// Its highlight fades with the cosine, and its diffuse light is part of the ambient light.
    is_wide: bool,
    /// The share that reaches each point.
    share: f32x16<S>,
}

/// What of a light is in shadow.
pub trait Shadows<S: Simd> {
    /// The share of a light that reaches the points in some lanes; anything in the other lanes.
    fn lit(&self, simd: S, light: LightNumber, lanes: u32) -> f32x16<S>;
}

/// Calls `add` for each light: directional, point and spot, then wide ones with a highlight. `normal` is that of the surface:
/// lights behind it are skipped.
#[inline(always)]
fn for_each_light<S: Simd>(
    simd: S,
    rig: &LightRig,
    shadows: &impl Shadows<S>,
    position: Vec3x16<S>,
    normal: Vec3x16<S>,
    mut add: impl FnMut(Seen<S>),
) {
    let one = splat(simd, 1.0);
    for (number, light) in rig.distant.iter().enumerate() {
        let to_light = each3!(K => splat(simd, light.to_light[K]));
        let lanes = lit(simd, normal, to_light);
        if lanes != 0 {
            let share = shadows.lit(simd, LightNumber::Distant(number), lanes);
            add(Seen { to_light, color: light.color, is_wide: false, share });
        }
    }
    for (number, light) in rig.near.iter().enumerate() {
        let offset = each3!(K => splat(simd, light.position[K]) - position[K]);
        let to_light = normalize(simd, offset, beside(simd, rig));
        let lanes = lit(simd, normal, to_light);
        if lanes != 0 {
            let mut in_cone = one;
            if let Some(cone) = light.cone {
                let middle = each3!(K => splat(simd, cone.to_light[K]));
                let cosine = dot(to_light, middle);
                let inside = share(simd, (cosine - splat(simd, cone.edge)) / splat(simd, cone.fade));
                in_cone = (inside * inside) * (splat(simd, 3.0) - inside * 2.0);
            }
            let share = shadows.lit(simd, LightNumber::Near(number), lanes) * in_cone;
            add(Seen { to_light, color: light.color, is_wide: false, share });
        }
    }
    for light in &rig.highlights {
        let to_light = each3!(K => splat(simd, light.to_light[K]));
        if lit(simd, normal, to_light) != 0 {
            add(Seen { to_light, color: light.color, is_wide: true, share: one });
        }
    }
}

/// The lanes of surfaces that face a light.
#[inline(always)]
fn lit<S: Simd>(simd: S, normal: Vec3x16<S>, to_light: Vec3x16<S>) -> u32 {
    dot(normal, to_light).simd_gt(splat(simd, 0.0)).to_bitmask() as u32 & 0xffff
}

/// A number that is 0 where it is not above 0, and at most 1.
#[inline(always)]
fn share<S: Simd>(simd: S, c: f32x16<S>) -> f32x16<S> {
    let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
    let c = c.simd_gt(zero).select(c, zero);
    c.simd_lt(one).select(c, one)
}

/// The light of Phong shading.
#[inline(always)]
pub fn phong<S: Simd>(
    simd: S,
    rig: &LightRig,
    shadows: &impl Shadows<S>,
    m: &Evaluated<S>,
    normal: Vec3x16<S>,
    to_viewer: Vec3x16<S>,
    position: Vec3x16<S>,
) -> Vec3x16<S> {
    let occlusion = m.occlusion;
    let ambient = wide(simd, rig, normal);
    let mut diffuse = each3!(K => ambient[K] * occlusion);
    let zero = splat(simd, 0.0);
    let mut specular = [zero; 3];
    let most = m.shininess_log2.to_array().into_iter().max().unwrap_or(0);
    for_each_light(
        simd,
        rig,
        shadows,
        position,
        normal,
        #[inline(always)]
        |light| {
            part(
                simd,
                #[inline(always)]
                || {
                    let cosine = dot(normal, light.to_light);
                    let lit = cosine.simd_gt(zero);
                    if !light.is_wide {
                        diffuse = each3!(K => lit.select(diffuse[K] + (cosine * light.share) * light.color[K], diffuse[K]));
                    }
                    let between = each3!(K => light.to_light[K] + to_viewer[K]);
                    let half = normalize(simd, between, beside(simd, rig));
                    let mut power = dot(normal, half);
                    power = power.simd_gt(zero).select(power, zero);
                    for square in 0..most {
                        let goes_on = m.shininess_log2.simd_gt(splat_i(simd, square));
                        power = goes_on.select(power * power, power);
                    }
                    let strength = power * if light.is_wide { cosine } else { light.share };
                    specular = each3!(K => {
                        let more = (strength * m.specular[K]) * light.color[K];
                        lit.select(specular[K] + more, specular[K])
                    });
                },
            );
        },
    );
    each3!(K => {
        let reflected = m.albedo[K] * diffuse[K] + specular[K];
        reflected + m.emissive[K]
    })
}

/// The light of physically based shading.
#[inline(always)]
pub fn physical<S: Simd>(
    simd: S,
    rig: &LightRig,
    shadows: &impl Shadows<S>,
    m: &Evaluated<S>,
    normal: Vec3x16<S>,
    to_viewer: Vec3x16<S>,
    position: Vec3x16<S>,
) -> Vec3x16<S> {
    let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
    let (metallic, occlusion) = (m.metallic, m.occlusion);
    let dielectric = splat(simd, DIELECTRIC);
    let base = each3!(K => (m.albedo[K] - dielectric) * metallic + dielectric);
    let diffuse_color = each3!(K => m.albedo[K] * (one - metallic));
    let roughness = m.roughness;
    let least = splat(simd, LEAST_ROUGHNESS);
    let roughness = share(simd, roughness.simd_gt(least).select(roughness, least));
    let a = roughness * roughness;
    let facing = share(simd, dot(normal, to_viewer));
    let grazing = fifth(one - facing);
    let twice = facing * 2.0;
    let mirrored = each3!(K => normal[K] * twice - to_viewer[K]);
    let mut reflected = polynomial(simd, &rig.mirrored, mirrored);
    if let Some(environment) = &rig.environment {
        let more = from_environment(simd, environment, &mirrored, roughness);
        reflected = each3!(K => reflected[K] + more[K]);
    }
    let irradiance = wide(simd, rig, normal);
    let smooth = one - roughness;
    let mut sum = each3!(K => {
        let limit = smooth.simd_gt(base[K]).select(smooth, base[K]);
        let fresnel = base[K] + (limit - base[K]) * grazing;
        ((diffuse_color[K] * (one - fresnel)) * irradiance[K] + fresnel * reflected[K]) * occlusion
    });
    for_each_light(
        simd,
        rig,
        shadows,
        position,
        normal,
        #[inline(always)]
        |light| {
            part(
                simd,
                #[inline(always)]
                || {
                    let cosine = dot(normal, light.to_light);
                    let lit = cosine.simd_gt(zero);
                    let cosine = cosine.simd_lt(one).select(cosine, one);
                    let between = each3!(K => light.to_light[K] + to_viewer[K]);
                    let half = normalize(simd, between, beside(simd, rig));
                    let nh = share(simd, dot(normal, half));
                    let grazing = fifth(one - share(simd, dot(to_viewer, half)));
                    let spread = (nh * nh) * (a * a - one) + one;
                    let together = (cosine * facing) * 2.0;
                    let apart = cosine + facing;
                    let masking = splat(simd, 0.5) / (together + (apart - together) * a);
                    let lobe = ((a * a) / (spread * spread)) * masking;
                    let strength = cosine * if light.is_wide { cosine } else { light.share };
                    sum = each3!(K => {
                        let fresnel = base[K] + (one - base[K]) * grazing;
                        let below = if light.is_wide { zero } else { diffuse_color[K] * (one - fresnel) };
                        let more = ((below + fresnel * lobe) * strength) * light.color[K];
                        lit.select(sum[K] + more, sum[K])
                    });
                },
            );
        },
    );
    each3!(K => sum[K] + m.emissive[K])
}

/// What surfaces mirror of the environment. The points are looked up one by one.
#[inline(never)]
fn from_environment<S: Simd>(
    simd: S,
    environment: &Environment,
    direction: &Vec3x16<S>,
    roughness: f32x16<S>,
) -> Vec3x16<S> {
    let mut found = [[0.0; LANES]; 3];
    for lane in 0..LANES {
        let light = environment.mirrored([0, 1, 2].map(|k| direction[k][lane]), roughness[lane]);
        (0..3).for_each(|k| found[k][lane] = light[k]);
    }
    each3!(K => load(simd, &found[K]))
}

#[inline(always)]
fn fifth<S: Simd>(x: f32x16<S>) -> f32x16<S> {
    let square = x * x;
    (square * square) * x
}
