//! Normals of textures.

use fearless_simd::Simd;
use fearless_simd::prelude::*;

use super::Pixels;
use super::evaluate::Evaluated;
use crate::backend::light::{Vec3x16, bend, normalize};
use crate::context::FrameContext;
use crate::simd::{dot, each3, part, splat};

/// The unit normals that the textures' normals stand for, bent if they point away from the viewer; in lanes without such a texture, the surface's.
#[inline(always)]
pub fn bumped<S: Simd>(
    simd: S,
    context: &FrameContext,
    instance: usize,
    pixels: &Pixels<S>,
    evaluated: &Evaluated<S>,
) -> Vec3x16<S> {
    let object = &context.objects[instance];
    let (p, uv) = (&pixels.corners.position, &pixels.corners.uv);
    let scale = evaluated.uv_scale;
    let normal = pixels.normal;
    part(
        simd,
        #[inline(always)]
        || {
            let zero = splat(simd, 0.0);
            // Edges of the triangles in world space, and in texture coordinates.
            let edge_1 = each3!(A => (p[1][A] - p[0][A]) * object.edge_scale);
            let edge_2 = each3!(A => (p[2][A] - p[0][A]) * object.edge_scale);
            let m = &object.eye_from_local;
            let e1 = each3!(K => (edge_1[0] * m[K][0] + edge_1[1] * m[K][1]) + edge_1[2] * m[K][2]);
            let e2 = each3!(K => (edge_2[0] * m[K][0] + edge_2[1] * m[K][1]) + edge_2[2] * m[K][2]);
            let [u1, v1] = [(uv[1][0] - uv[0][0]) * scale[0], (uv[1][1] - uv[0][1]) * scale[1]];
            let [u2, v2] = [(uv[2][0] - uv[0][0]) * scale[0], (uv[2][1] - uv[0][1]) * scale[1]];
            let is_mirrored = (u1 * v2 - u2 * v1).simd_lt(zero);
            let sign = is_mirrored.select(splat(simd, -1.0), splat(simd, 1.0));
            let along_u = each3!(K => (e1[K] * v2 - e2[K] * v1) * sign);
            let along_v = each3!(K => (e2[K] * u1 - e1[K] * u2) * sign);
            let (along_u, along_v) = (axis(simd, normal, along_u), axis(simd, normal, along_v));
            let t = evaluated.tangent;
            let bumped = each3!(K => (along_u[K] * t[0] + along_v[K] * t[1]) + normal[K] * t[2]);
            let bumped = normalize(simd, bumped, normal);
            let bumped = bend(simd, bumped, pixels.to_viewer);
            let is_bumped = fearless_simd::mask32x16::from_bitmask(simd, u64::from(evaluated.bumped));
            each3!(K => is_bumped.select(bumped[K], normal[K]))
        },
    )
}

/// A unit vector in the tangent plane; zero if there is none.
#[inline(always)]
fn axis<S: Simd>(simd: S, normal: Vec3x16<S>, v: Vec3x16<S>) -> Vec3x16<S> {
    let zero = splat(simd, 0.0);
    let largest = v[0].abs().max(v[1].abs()).max(v[2].abs());
    let has_length = largest.simd_gt(zero);
    let v = each3!(K => has_length.select(v[K] / largest, zero));
    let out = dot(normal, v);
    normalize(simd, each3!(K => v[K] - normal[K] * out), [zero; 3])
}
