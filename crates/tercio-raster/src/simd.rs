//! What the kernels need beyond `fearless_simd`: 16 lanes everywhere, chosen once a batch.
//!
//! Every kernel is generic over the level and works on 16 lanes at each of them, so that all levels compute
//! the same lanes in the same order. The level is picked by `dispatch!` where a batch of work begins
//! ([`crate::Renderer`] does it) and nowhere else.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16};

/// Lanes of every kernel: one 4x4 block of samples, or 16 vertices, triangles or pixels.
pub const LANES: usize = 16;

/// Loads 16 numbers.
#[inline(always)]
pub fn load<S: Simd>(simd: S, from: &[f32]) -> f32x16<S> {
    f32x16::from_slice(simd, &from[..LANES])
}

/// The same number 16 times.
#[inline(always)]
pub fn splat<S: Simd>(simd: S, value: f32) -> f32x16<S> {
    f32x16::splat(simd, value)
}

/// The same whole number 16 times.
#[inline(always)]
pub fn splat_i<S: Simd>(simd: S, value: i32) -> i32x16<S> {
    i32x16::splat(simd, value)
}

/// `((x * r0 + y * r1) + z * r2) + r3`, each product and sum rounded.
#[inline(always)]
pub fn row<S: Simd>(simd: S, r: &[f32; 4], p: [f32x16<S>; 3]) -> f32x16<S> {
    let k = |i: usize| splat(simd, r[i]);
    ((p[0] * k(0) + p[1] * k(1)) + p[2] * k(2)) + k(3)
}

/// `(a0 * b0 + a1 * b1) + a2 * b2`.
#[inline(always)]
pub fn dot<S: Simd>(a: [f32x16<S>; 3], b: [f32x16<S>; 3]) -> f32x16<S> {
    (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2]
}

/// `a x b`.
#[inline(always)]
pub fn cross<S: Simd>(a: [f32x16<S>; 3], b: [f32x16<S>; 3]) -> [f32x16<S>; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[cfg(target_arch = "x86_64")]
fearless_simd::kernel!(
    /// 16 entries of a table of 64 that stays in four registers.
    #[inline]
    fn lookup_avx512(avx512: Avx512, table: &[i32; 64], index: &[u8; 16]) -> std::arch::x86_64::__m512i {
        use std::arch::x86_64::*;
        let part = |k: usize| -> __m512i { i32x16::from_slice(avx512, &table[16 * k..16 * k + 16]).into() };
        let packed: __m128i = fearless_simd::u8x16::from_slice(avx512, index).into();
        let wide = _mm512_cvtepu8_epi32(packed);
        let low = _mm512_permutex2var_epi32(part(0), wide, part(1));
        let high = _mm512_permutex2var_epi32(part(2), wide, part(3));
        let upper = _mm512_test_epi32_mask(wide, _mm512_set1_epi32(32));
        _mm512_mask_blend_epi32(upper, low, high)
    }
);

/// 16 entries of a table of 64; indices are taken modulo 64.
#[inline(always)]
pub fn lookup<S: Simd>(simd: S, table: &[i32; 64], index: &[u8; 16]) -> i32x16<S> {
    #[cfg(target_arch = "x86_64")]
    if let fearless_simd::Level::Avx512(token) = simd.level() {
        return lookup_avx512(token, table, index).simd_into(simd);
    }
    i32x16::from_fn(simd, |lane| table[usize::from(index[lane] & 63)])
}
