//! Box, sphere, normal cone and smallest height of a cluster.

use glam::{DVec3, Vec3};

use super::{Cluster, MAX_TRIANGLES, cone::middle};

/// Below this sine between two edges a normal cannot be trusted, even in `f64`.
const SINE_LIMIT: f64 = 1e-10;

/// Fills in all that bounds a cluster. `x`, `y`, `z` hold its vertices, `corners` its triangles.
pub(super) fn bound(cluster: &mut Cluster, [x, y, z]: [&[f32]; 3], corners: [&[u8]; 3]) {
    let point = |i: u8| DVec3::new(x[i as usize].into(), y[i as usize].into(), z[i as usize].into());
    (cluster.min, cluster.max) =
        (std::array::from_fn(|k| least([x, y, z][k])), std::array::from_fn(|k| most([x, y, z][k])));
    let center: [f32; 3] = std::array::from_fn(|k| middle(cluster.min[k], cluster.max[k]));
    let center = Vec3::from(center).as_dvec3();
    let far = (0..x.len()).map(|i| point(i as u8).distance_squared(center)).fold(0.0, f64::max);
    cluster.radius = round_up(far.sqrt());

    let mut normals = [DVec3::ZERO; MAX_TRIANGLES];
    let (mut count, mut sum, mut height, mut trusted) = (0, DVec3::ZERO, f64::INFINITY, true);
    for ((&a, &b), &c) in corners[0].iter().zip(corners[1]).zip(corners[2]) {
        let (a, b, c) = (point(a), point(b), point(c));
        let (u, v) = (b - a, c - a);
        let normal = u.cross(v);
        let square = normal.length_squared();
        let (uu, vv, ww) = (u.length_squared(), v.length_squared(), (v - u).length_squared());
        if square > 0.0 {
            height = height.min(square / uu.max(vv).max(ww));
            trusted &= square > SINE_LIMIT * SINE_LIMIT * (uu * vv);
            normals[count] = normal * (1.0 / square.sqrt());
            sum += normals[count];
            count += 1;
        } else {
            height = 0.0;
        }
    }
    cluster.min_height = round_down(height.sqrt());
    (cluster.cone_axis, cluster.cone_cutoff) =
        if trusted { cone(&normals[..count], sum) } else { ([0; 3], Cluster::NO_CONE) };
}

/// Axis and cut-off, in 1/127, of a cone about `direction` that holds all unit normals.
fn cone(normals: &[DVec3], direction: DVec3) -> ([i8; 3], i8) {
    const NONE: ([i8; 3], i8) = ([0; 3], Cluster::NO_CONE);
    // Scaled by 126, so that rounding never makes the axis longer than 127.
    let scaled = direction.normalize_or_zero() * 126.0;
    let axis = scaled.to_array().map(|v| v.round() as i8);
    let quantised = DVec3::from_array(axis.map(f64::from));
    let length = quantised.length();
    let cosine = normals.iter().map(|n| n.dot(quantised)).fold(f64::INFINITY, f64::min) / length;
    // A cone of a right angle or more holds a normal that faces every eye.
    if !(cosine > 1e-3 && cosine.is_finite()) {
        return NONE;
    }
    let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
    let cutoff = (length * sine + 1e-4).ceil();
    if cutoff >= f64::from(Cluster::NO_CONE) { NONE } else { (axis, cutoff as i8) }
}

fn least(values: &[f32]) -> f32 {
    values.iter().copied().fold(f32::INFINITY, f32::min)
}

fn most(values: &[f32]) -> f32 {
    values.iter().copied().fold(f32::NEG_INFINITY, f32::max)
}

/// The nearest `f32` that is surely not smaller, whatever a few roundings did to `v`.
fn round_up(v: f64) -> f32 {
    (v as f32 * (1.0 + 2.0 * f32::EPSILON)).max(f32::MIN_POSITIVE)
}

fn round_down(v: f64) -> f32 {
    v.min(f32::MAX.into()) as f32 * (1.0 - 2.0 * f32::EPSILON)
}
