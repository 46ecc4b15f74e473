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

/// Loads 16 numbers from an index on; those behind the end are `beyond`.
#[inline(always)]
pub fn load_part<S: Simd>(simd: S, from: &[f32], first: usize, beyond: f32) -> Lanes<S> {
    if let Some(all) = from.get(first..first + LANES) {
        return f32x16::from_slice(simd, all);
    }
    let mut some = [beyond; LANES];
    let from = from.get(first..).unwrap_or_default();
    some[..from.len()].copy_from_slice(from);
    load(simd, &some)
}

/// Loads four components of 16 vectors, one vector after the other.
#[inline(always)]
pub fn load_interleaved<S: Simd>(simd: S, from: &[[f32; 4]; LANES]) -> [Lanes<S>; 4] {
    let (sixteens, _) = from.as_flattened().as_chunks::<LANES>();
    let [a, b] = [load(simd, &sixteens[0]), load(simd, &sixteens[1])];
    let [c, d] = [load(simd, &sixteens[2]), load(simd, &sixteens[3])];
    let (xz, yw) = ([a.unzip_low(b), c.unzip_low(d)], [a.unzip_high(b), c.unzip_high(d)]);
    let (x, z) = (xz[0].unzip_low(xz[1]), xz[0].unzip_high(xz[1]));
    let (y, w) = (yw[0].unzip_low(yw[1]), yw[0].unzip_high(yw[1]));
    [x, y, z, w]
}

/// The reverse of [`load_interleaved`], as four times 16 numbers.
#[inline(always)]
pub fn interleaved<S: Simd>([x, y, z, w]: [Lanes<S>; 4]) -> [Lanes<S>; 4] {
    let (xz, yw) = ([x.zip_low(z), x.zip_high(z)], [y.zip_low(w), y.zip_high(w)]);
    let (low, high) =
        ([xz[0].zip_low(yw[0]), xz[0].zip_high(yw[0])], [xz[1].zip_low(yw[1]), xz[1].zip_high(yw[1])]);
    [low[0], low[1], high[0], high[1]]
}

/// Stores four components of 16 vectors, one vector after the other.
#[inline(always)]
pub fn store_interleaved<S: Simd>(components: [Lanes<S>; 4], to: &mut [[f32; 4]; LANES]) {
    let (sixteens, _) = to.as_flattened_mut().as_chunks_mut::<LANES>();
    let all = interleaved(components);
    all[0].store_slice(&mut sixteens[0]);
    all[1].store_slice(&mut sixteens[1]);
    all[2].store_slice(&mut sixteens[2]);
    all[3].store_slice(&mut sixteens[3]);
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

/// Limited to a range; NaN becomes `low`. `high` is not 0.
#[inline(always)]
pub fn clamp<S: Simd>(simd: S, v: Lanes<S>, low: f32, high: f32) -> Lanes<S> {
    let low = splat(simd, low);
    // Of the smaller of two numbers, unlike NaN and zeros of both signs, all levels have the same notion.
    v.simd_gt(low).select(v, low).min(splat(simd, high))
}
