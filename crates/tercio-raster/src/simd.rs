//! What the kernels need beyond `fearless_simd`: 16 lanes everywhere, chosen once a batch.
//!
//! Every kernel is generic over the level and works on 16 lanes at each of them, so that all levels compute
//! the same lanes in the same order. The level is picked by `dispatch!` where a batch of work begins
//! ([`crate::Renderer`] does it) and nowhere else.

use fearless_simd::prelude::*;
use fearless_simd::{Level, Simd, f32x16, i32x8, i32x16, u8x16};

/// Lanes of every kernel: one 4x4 block of samples, or 16 vertices, triangles or pixels.
pub const LANES: usize = 16;

/// Number of each lane.
pub const LANE_NUMBERS: [i32; LANES] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15];

/// One bit for each of the lanes that hold something, where `left` elements are left.
#[inline(always)]
pub fn live_lanes(left: usize) -> u32 {
    if left >= LANES { 0xffff } else { (1 << left) - 1 }
}

/// `[f(0), f(1), f(2)]`, written out: a closure would not be compiled at the kernel's SIMD level.
macro_rules! each3 {
    ($k:ident => $value:expr) => {
        [
            {
                const $k: usize = 0;
                $value
            },
            {
                const $k: usize = 1;
                $value
            },
            {
                const $k: usize = 2;
                $value
            },
        ]
    };
}
pub(crate) use each3;

/// Runs a part of a kernel. At the scalar level it is a function of its own: 16 lanes written out one by one
/// make code so long that compiling it in one piece takes minutes.
#[inline(always)]
pub fn part<S: Simd, R>(simd: S, work: impl FnOnce() -> R) -> R {
    #[inline(never)]
    fn on_its_own<R>(work: impl FnOnce() -> R) -> R {
        work()
    }
    if matches!(simd.level(), Level::Fallback(_)) { on_its_own(work) } else { work() }
}

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
    part(
        simd,
        #[inline(always)]
        || ((p[0] * r[0] + p[1] * r[1]) + p[2] * r[2]) + splat(simd, r[3]),
    )
}

/// `(a0 * b0 + a1 * b1) + a2 * b2`.
#[inline(always)]
pub fn dot<S: Simd>(a: [f32x16<S>; 3], b: [f32x16<S>; 3]) -> f32x16<S> {
    part(
        a[0].simd,
        #[inline(always)]
        || (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2],
    )
}

/// `a x b`.
#[inline(always)]
pub fn cross<S: Simd>(a: [f32x16<S>; 3], b: [f32x16<S>; 3]) -> [f32x16<S>; 3] {
    part(
        a[0].simd,
        #[inline(always)]
        || [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]],
    )
}

#[cfg(target_arch = "x86_64")]
fearless_simd::kernel!(
    /// 16 entries of a table of 64 that stays in four registers.
    #[inline]
    fn lookup_avx512(avx512: Avx512, table: &[i32; 64], index: &[u8; 16]) -> std::arch::x86_64::__m512i {
        use std::arch::x86_64::*;
        let part = |k: usize| -> __m512i { i32x16::from_slice(avx512, &table[16 * k..16 * k + 16]).into() };
        let packed: __m128i = u8x16::from_slice(avx512, index).into();
        let wide = _mm512_cvtepu8_epi32(packed);
        let low = _mm512_permutex2var_epi32(part(0), wide, part(1));
        let high = _mm512_permutex2var_epi32(part(2), wide, part(3));
        let upper = _mm512_test_epi32_mask(wide, _mm512_set1_epi32(32));
        _mm512_mask_blend_epi32(upper, low, high)
    }
);

#[cfg(target_arch = "x86_64")]
fearless_simd::kernel!(
    /// 16 entries of a table of 128 bytes that stays in two registers.
    #[inline]
    fn lookup_bytes_avx512(
        avx512: Avx512,
        table: &[u8; 128],
        index: &[u8; 16],
    ) -> std::arch::x86_64::__m128i {
        use std::arch::x86_64::*;
        let part = |k: usize| -> __m512i {
            fearless_simd::u8x64::from_slice(avx512, &table[64 * k..64 * k + 64]).into()
        };
        let index: __m128i = u8x16::from_slice(avx512, index).into();
        _mm512_castsi512_si128(_mm512_permutex2var_epi8(part(0), _mm512_castsi128_si512(index), part(1)))
    }
);

/// 16 entries of a table of 128 bytes; indices are taken modulo 128.
#[inline(always)]
pub fn lookup_bytes<S: Simd>(simd: S, table: &[u8; 128], index: &[u8; 16]) -> [u8; 16] {
    #[cfg(target_arch = "x86_64")]
    if let Level::Avx512(token) = simd.level() {
        let found: u8x16<S> = lookup_bytes_avx512(token, table, index).simd_into(simd);
        return found.to_array();
    }
    let mut found = [0; 16];
    for lane in 0..LANES {
        found[lane] = table[usize::from(index[lane] & 127)];
    }
    found
}

/// 16 entries of a table of 64; indices are taken modulo 64.
#[inline(always)]
pub fn lookup<S: Simd>(simd: S, table: &[i32; 64], index: &[u8; 16]) -> i32x16<S> {
    #[cfg(target_arch = "x86_64")]
    if let Level::Avx512(token) = simd.level() {
        return lookup_avx512(token, table, index).simd_into(simd);
    }
    part(
        simd,
        #[inline(always)]
        || i32x16::from_fn(simd, |lane| table[usize::from(index[lane] & 63)]),
    )
}

#[cfg(target_arch = "x86_64")]
fearless_simd::kernel!(
    /// 16 entries of a table of 128 that stays in eight registers.
    #[inline]
    fn lookup_128_avx512(
        avx512: Avx512,
        table: &[i32; 128],
        index: std::arch::x86_64::__m512i,
    ) -> std::arch::x86_64::__m512i {
        use std::arch::x86_64::*;
        let part = |k: usize| -> __m512i { i32x16::from_slice(avx512, &table[16 * k..16 * k + 16]).into() };
        let pair = |k: usize| -> __m512i { _mm512_permutex2var_epi32(part(2 * k), index, part(2 * k + 1)) };
        let odd = _mm512_test_epi32_mask(index, _mm512_set1_epi32(32));
        let upper = _mm512_test_epi32_mask(index, _mm512_set1_epi32(64));
        let low = _mm512_mask_blend_epi32(odd, pair(0), pair(1));
        let high = _mm512_mask_blend_epi32(odd, pair(2), pair(3));
        _mm512_mask_blend_epi32(upper, low, high)
    }
);

/// 16 entries of a table of 128; indices are taken modulo 128.
#[inline(always)]
pub fn lookup_128<S: Simd>(simd: S, table: &[i32; 128], index: i32x16<S>) -> i32x16<S> {
    #[cfg(target_arch = "x86_64")]
    if let Level::Avx512(token) = simd.level() {
        return lookup_128_avx512(token, table, index.into()).simd_into(simd);
    }
    part(
        simd,
        #[inline(always)]
        || i32x16::from_fn(simd, |lane| table[(index[lane] & 127) as usize]),
    )
}

#[cfg(target_arch = "x86_64")]
fearless_simd::kernel!(
    /// The chosen lanes, moved together to the front.
    #[inline]
    fn compress_avx512(
        avx512: Avx512,
        lanes: u16,
        from: std::arch::x86_64::__m512i,
    ) -> std::arch::x86_64::__m512i {
        let _ = avx512;
        std::arch::x86_64::_mm512_maskz_compress_epi32(lanes, from)
    }
);

/// Numbers of the bits that are set in a number, lowest first.
#[cfg(target_arch = "x86_64")]
static SET_BITS: [[u8; 8]; 256] = set_bits();

#[cfg(target_arch = "x86_64")]
const fn set_bits() -> [[u8; 8]; 256] {
    let mut all = [[0; 8]; 256];
    let mut number = 0;
    while number < 256 {
        let (mut bit, mut count) = (0, 0);
        while bit < 8 {
            if number >> bit & 1 == 1 {
                all[number][count] = bit as u8;
                count += 1;
            }
            bit += 1;
        }
        number += 1;
    }
    all
}

#[cfg(target_arch = "x86_64")]
fearless_simd::kernel!(
    /// The chosen lanes, moved together to the front.
    #[inline]
    fn compress_avx2(avx2: Avx2, lanes: u8, from: std::arch::x86_64::__m256i) -> std::arch::x86_64::__m256i {
        use std::arch::x86_64::*;
        let _ = avx2;
        let order = _mm_cvtsi64_si128(i64::from_le_bytes(SET_BITS[lanes as usize]));
        _mm256_permutevar8x32_epi32(from, _mm256_cvtepu8_epi32(order))
    }
);

#[cfg(target_arch = "x86_64")]
fearless_simd::kernel!(
    /// Of eight bytes the chosen ones, moved together to the front.
    #[inline]
    fn compress_bytes_avx2(avx2: Avx2, lanes: u8, from: u64) -> u64 {
        use std::arch::x86_64::*;
        let _ = avx2;
        let order = _mm_cvtsi64_si128(i64::from_le_bytes(SET_BITS[lanes as usize]));
        _mm_cvtsi128_si64(_mm_shuffle_epi8(_mm_cvtsi64_si128(from as i64), order)) as u64
    }
);

/// Writes the chosen lanes to `to`, one after another from place `at` on; there must be room for all 16.
#[inline(always)]
pub fn append<S: Simd>(simd: S, to: &mut [i32], at: usize, lanes: u32, from: i32x16<S>) {
    let to = &mut to[at..at + LANES];
    #[cfg(target_arch = "x86_64")]
    if let Level::Avx512(token) = simd.level() {
        let together: i32x16<S> = compress_avx512(token, lanes as u16, from.into()).simd_into(simd);
        together.store_slice(to);
        return;
    }
    #[cfg(target_arch = "x86_64")]
    if let Level::Avx2(token) = simd.level() {
        let (low, high) = from.split();
        let low: i32x8<S> = compress_avx2(token, lanes as u8, low.into()).simd_into(simd);
        let high: i32x8<S> = compress_avx2(token, (lanes >> 8) as u8, high.into()).simd_into(simd);
        let middle = (lanes & 0xff).count_ones() as usize;
        low.store_slice(&mut to[..8]);
        high.store_slice(&mut to[middle..middle + 8]);
        return;
    }
    move_to_front(to, lanes, &from.to_array());
}

#[cfg(target_arch = "x86_64")]
fearless_simd::kernel!(
    /// The chosen bytes, moved together to the front.
    #[inline]
    fn compress_bytes_avx512(
        avx512: Avx512,
        lanes: u16,
        from: std::arch::x86_64::__m128i,
    ) -> std::arch::x86_64::__m128i {
        let _ = avx512;
        std::arch::x86_64::_mm_maskz_compress_epi8(lanes, from)
    }
);

/// Writes the chosen bytes to `to`, one after another from place `at` on; there must be room for all 16.
#[inline(always)]
pub fn append_bytes<S: Simd>(simd: S, to: &mut [u8], at: usize, lanes: u32, from: u8x16<S>) {
    let to = &mut to[at..at + LANES];
    #[cfg(target_arch = "x86_64")]
    if let Level::Avx512(token) = simd.level() {
        let together: u8x16<S> = compress_bytes_avx512(token, lanes as u16, from.into()).simd_into(simd);
        together.store_slice(to);
        return;
    }
    #[cfg(target_arch = "x86_64")]
    if let Level::Avx2(token) = simd.level() {
        let both = u128::from_le_bytes(from.to_array());
        let low = compress_bytes_avx2(token, lanes as u8, both as u64);
        let high = compress_bytes_avx2(token, (lanes >> 8) as u8, (both >> 64) as u64);
        let middle = (lanes & 0xff).count_ones() as usize;
        to[..8].copy_from_slice(&low.to_le_bytes());
        to[middle..middle + 8].copy_from_slice(&high.to_le_bytes());
        return;
    }
    move_to_front(to, lanes, &from.to_array());
}

/// The chosen lanes, one after another.
#[inline(always)]
fn move_to_front<T: Copy>(to: &mut [T], lanes: u32, from: &[T; LANES]) {
    let (mut left, mut count) = (lanes & 0xffff, 0);
    while left != 0 {
        to[count] = from[left.trailing_zeros() as usize];
        count += 1;
        left &= left - 1;
    }
}

/// Asks the memory for some elements that will be read soon; those outside the slice are left out.
#[inline(always)]
pub fn prefetch<T>(from: &[T], first: usize, count: usize) {
    let Some(from) = from.get(first..(first + count).min(from.len())) else { return };
    let bytes = size_of_val(from);
    let mut at = 0;
    while at < bytes {
        #[cfg(target_arch = "x86_64")]
        // SAFETY: a prefetch reads nothing that the program could see, and never faults.
        unsafe {
            use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
            _mm_prefetch::<_MM_HINT_T0>(from.as_ptr().cast::<i8>().wrapping_add(at));
        }
        at += CACHE_LINE;
    }
}

/// Bytes that come from memory together.
const CACHE_LINE: usize = 64;
