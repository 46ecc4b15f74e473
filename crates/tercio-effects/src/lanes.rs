//! Functions of 16 lanes, of operations whose results are the same at every SIMD level.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};

/// Lanes of every kernel.
pub const LANES: usize = 16;

/// 16 numbers.
pub type Lanes<S> = f32x16<S>;

/// Three coordinates of 16 points or directions.
pub type Vec3<S> = [f32x16<S>; 3];

/// Loads 16 numbers.
#[inline(always)]
pub fn load<S: Simd>(simd: S, from: &[f32; LANES]) -> Lanes<S> {
    f32x16::load_array(simd, *from)
}

/// Broadcasts a number to 16 lanes.
#[inline(always)]
pub fn splat<S: Simd>(simd: S, value: f32) -> Lanes<S> {
    f32x16::splat(simd, value)
}

/// The scalar product.
#[inline(always)]
pub fn dot<S: Simd>(a: Vec3<S>, b: Vec3<S>) -> Lanes<S> {
    (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2]
}

/// `a - b`.
#[inline(always)]
pub fn minus<S: Simd>(a: Vec3<S>, b: Vec3<S>) -> Vec3<S> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// `v * factor`.
#[inline(always)]
pub fn scaled<S: Simd>(v: Vec3<S>, factor: Lanes<S>) -> Vec3<S> {
    [v[0] * factor, v[1] * factor, v[2] * factor]
}

/// Limited to a range; NaN becomes `low`.
#[inline(always)]
pub fn clamp<S: Simd>(simd: S, v: Lanes<S>, low: f32, high: f32) -> Lanes<S> {
    let (low, high) = (splat(simd, low), splat(simd, high));
    let v = v.simd_gt(low).select(v, low);
    v.simd_lt(high).select(v, high)
}

/// The angle of a cosine from -1 to 1, radians; off by at most 1e-4. Source: Abramowitz and Stegun, "Handbook of
/// mathematical functions" (1964), formula 4.4.45.
#[inline(always)]
pub fn arc_cosine<S: Simd>(simd: S, cosine: Lanes<S>) -> Lanes<S> {
    let x = cosine.abs();
    let polynomial = ((x * -0.018_729_3 + 0.074_261) * x - 0.212_114_4) * x + 1.570_728_8;
    let angle = (splat(simd, 1.0) - x).sqrt() * polynomial;
    cosine.simd_lt(splat(simd, 0.0)).select(splat(simd, std::f32::consts::PI) - angle, angle)
}
