//! SIMD operations that the kernels need in addition to those of `fearless_simd`.
//!
//! Every kernel is generic over the SIMD level and works on 16 lanes at each level, so that all levels compute the same
//! lanes in the same order. The level is selected with `dispatch!` at the start of a batch of work and nowhere else:
//! [`crate::Renderer`] does it; the kernels with the full counts of [`crate::tally`] always run at the baseline level.

pub mod dispatch;
mod level;
#[cfg(target_arch = "x86_64")]
mod x86_64;

pub use level::SimdLevel;

#[cfg(target_arch = "x86_64")]
use fearless_simd::i32x8;
use fearless_simd::prelude::*;
use fearless_simd::{Level, Simd, f32x16, i32x16, mask8x64, u8x16, u8x64};
use tercio_mesh::cluster::Line;

/// Lanes of every kernel: one 4x4 block of samples, or 16 vertices, triangles or pixels.
pub const LANES: usize = 16;

/// Bytes of the widest register: lanes of kernels that work on one byte per triangle.
pub const BYTE_LANES: usize = 64;

/// The index of each lane.
pub const LANE_NUMBERS: [i32; LANES] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15];

/// The mask of the lanes in use, if `left` elements remain.
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

/// The SIMD level that every processor of the target supports, for kernels that need not be fast and are compiled at
/// this level only.
pub fn baseline() -> impl Simd {
    #[cfg(target_arch = "x86_64")]
    {
        let Some(simd) = Level::baseline().as_sse2() else { unreachable!("part of x86-64") };
        simd
    }
    #[cfg(target_arch = "aarch64")]
    {
        let Some(simd) = Level::baseline().as_neon() else { unreachable!("part of AArch64") };
        simd
    }
    #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
    fearless_simd::Fallback::new()
}

/// Runs a part of a kernel. At the scalar level, the part is compiled as a function of its own: 16 lanes, unrolled,
/// make code so long that compiling a kernel in one piece takes minutes.
#[inline(always)]
pub fn part<S: Simd, R>(simd: S, work: impl FnOnce() -> R) -> R {
    #[cfg(any(feature = "scalar", not(any(target_arch = "x86_64", target_arch = "aarch64"))))]
    #[inline(never)]
    fn not_inlined<R>(work: impl FnOnce() -> R) -> R {
        work()
    }
    #[cfg(any(feature = "scalar", not(any(target_arch = "x86_64", target_arch = "aarch64"))))]
    if simd.level().is_fallback() {
        return not_inlined(work);
    }
    let _ = simd;
    work()
}

/// Loads 16 numbers.
#[inline(always)]
pub fn load<S: Simd>(simd: S, from: &[f32]) -> f32x16<S> {
    f32x16::from_slice(simd, &from[..LANES])
}

/// Stores four components of 16 vectors, one vector after the other.
#[inline(always)]
pub fn store_interleaved<S: Simd>([x, y, z, w]: [f32x16<S>; 4], to: &mut [[f32; 4]; LANES]) {
    part(
        x.simd,
        #[inline(always)]
        || {
            let (xz, yw) = ([x.zip_low(z), x.zip_high(z)], [y.zip_low(w), y.zip_high(w)]);
            let (sixteens, _) = to.as_flattened_mut().as_chunks_mut::<LANES>();
            xz[0].zip_low(yw[0]).store_slice(&mut sixteens[0]);
            xz[0].zip_high(yw[0]).store_slice(&mut sixteens[1]);
            xz[1].zip_low(yw[1]).store_slice(&mut sixteens[2]);
            xz[1].zip_high(yw[1]).store_slice(&mut sixteens[3]);
        },
    );
}

/// The reverse of [`store_interleaved`].
#[inline(always)]
pub fn load_interleaved<S: Simd>(simd: S, from: &[[f32; 4]; LANES]) -> [f32x16<S>; 4] {
    part(
        simd,
        #[inline(always)]
        || {
            let sixteens = from.as_flattened();
            let [a, b] = [load(simd, sixteens), load(simd, &sixteens[LANES..])];
            let [c, d] = [load(simd, &sixteens[2 * LANES..]), load(simd, &sixteens[3 * LANES..])];
            let (xz, yw) = ([a.unzip_low(b), c.unzip_low(d)], [a.unzip_high(b), c.unzip_high(d)]);
            let (x, z) = (xz[0].unzip_low(xz[1]), xz[0].unzip_high(xz[1]));
            let (y, w) = (yw[0].unzip_low(yw[1]), yw[0].unzip_high(yw[1]));
            [x, y, z, w]
        },
    )
}

/// Broadcasts a number to 16 lanes.
#[inline(always)]
pub fn splat<S: Simd>(simd: S, value: f32) -> f32x16<S> {
    f32x16::splat(simd, value)
}

/// Broadcasts an integer to 16 lanes.
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

/// 16 entries of a table of 128 bytes; indices are taken modulo 128.
#[inline(always)]
pub fn lookup_bytes<S: Simd>(simd: S, table: &[u8; 128], index: &[u8; 16]) -> [u8; 16] {
    match simd.level() {
        #[cfg(target_arch = "x86_64")]
        Level::Avx512(token) => {
            let found: u8x16<S> = x86_64::lookup_bytes_avx512(token, table, index).simd_into(simd);
            found.to_array()
        }
        #[cfg(target_arch = "x86_64")]
        Level::Avx2(token) => {
            let found: u8x16<S> = x86_64::lookup_bytes_avx2(token, table, index).simd_into(simd);
            found.to_array()
        }
        // SSE2 and the scalar level have no byte shuffles.
        #[cfg(target_arch = "x86_64")]
        Level::Sse2(_) => lookup_bytes_one_by_one(table, index),
        #[cfg(any(feature = "scalar", not(any(target_arch = "x86_64", target_arch = "aarch64"))))]
        Level::Fallback(_) => lookup_bytes_one_by_one(table, index),
        _ => {
            let mut index = u8x16::load_array_ref(simd, index) & 127;
            let mut found = u8x16::splat(simd, 0);
            for chunk in table.as_chunks::<LANES>().0 {
                found |= u8x16::load_array_ref(simd, chunk).swizzle_dyn_precise(index);
                index -= LANES as u8;
            }
            found.to_array()
        }
    }
}

#[cfg(not(all(target_arch = "aarch64", not(feature = "scalar"))))]
fn lookup_bytes_one_by_one(table: &[u8; 128], index: &[u8; 16]) -> [u8; 16] {
    let mut found = [0; 16];
    for lane in 0..LANES {
        found[lane] = table[usize::from(index[lane] & 127)];
    }
    found
}

/// Are 16 lanes at most two registers? Kernels for rare pictures are compiled for these levels alone: at the others they are several
/// times as long.
#[inline(always)]
pub fn has_wide_registers<S: Simd>(simd: S) -> bool {
    match simd.level() {
        #[cfg(target_arch = "x86_64")]
        Level::Avx512(_) | Level::Avx2(_) => true,
        _ => false,
    }
}

/// 16 entries of a table of 64; indices are taken modulo 64.
#[inline(always)]
pub fn lookup<S: Simd>(simd: S, table: &[i32; 64], index: &[u8; 16]) -> i32x16<S> {
    match simd.level() {
        #[cfg(target_arch = "x86_64")]
        Level::Avx512(token) => x86_64::lookup_avx512(token, table, index).simd_into(simd),
        _ => part(
            simd,
            #[inline(always)]
            || i32x16::from_fn(simd, |lane| table[usize::from(index[lane] & 63)]),
        ),
    }
}

/// 16 entries of a table of 16. Precondition: indices are from 0 to 15.
#[inline(always)]
pub fn lookup_16<S: Simd>(simd: S, table: i32x16<S>, index: i32x16<S>) -> i32x16<S> {
    match simd.level() {
        #[cfg(target_arch = "x86_64")]
        Level::Avx512(token) => x86_64::lookup_16_avx512(token, table.into(), index.into()).simd_into(simd),
        #[cfg(target_arch = "x86_64")]
        Level::Avx2(token) => {
            let ((low, high), (first, last)) = (table.split(), index.split());
            let (low, high) = (low.into(), high.into());
            let first: i32x8<S> = x86_64::lookup_16_avx2(token, low, high, first.into()).simd_into(simd);
            let last: i32x8<S> = x86_64::lookup_16_avx2(token, low, high, last.into()).simd_into(simd);
            first.combine(last)
        }
        _ => {
            let (table, index) = (table.to_array(), index.to_array());
            let mut found = [0; LANES];
            for lane in 0..LANES {
                found[lane] = table[index[lane] as usize % LANES];
            }
            i32x16::load_array(simd, found)
        }
    }
}

/// 16 entries of a table of 128; indices are taken modulo 128.
#[inline(always)]
pub fn lookup_128<S: Simd>(simd: S, table: &[i32; 128], index: i32x16<S>) -> i32x16<S> {
    match simd.level() {
        #[cfg(target_arch = "x86_64")]
        Level::Avx512(token) => x86_64::lookup_128_avx512(token, table, index.into()).simd_into(simd),
        _ => part(
            simd,
            #[inline(always)]
            || i32x16::from_fn(simd, |lane| table[(index[lane] & 127) as usize]),
        ),
    }
}

/// 16 entries of a table of four numbers each: the first two and the last two as 32 bits, the first of them in the lower 16.
///
/// # Panics
/// If an index is not in the table.
#[inline(always)]
pub fn lookup_fours<S: Simd>(simd: S, table: &[[u16; 4]], index: i32x16<S>) -> [i32x16<S>; 2] {
    let (low, high): (i32x16<S>, i32x16<S>) = match simd.level() {
        #[cfg(target_arch = "x86_64")]
        Level::Avx512(token) => {
            let (low, high) = x86_64::lookup_fours_avx512(token, table, index.into());
            (low.simd_into(simd), high.simd_into(simd))
        }
        #[cfg(target_arch = "x86_64")]
        Level::Avx2(token) => {
            let (first, last) = index.split();
            let (a, b) = x86_64::lookup_fours_avx2(token, table, first.into());
            let (c, d) = x86_64::lookup_fours_avx2(token, table, last.into());
            let (a, b): (i32x8<S>, i32x8<S>) = (a.simd_into(simd), b.simd_into(simd));
            let (c, d): (i32x8<S>, i32x8<S>) = (c.simd_into(simd), d.simd_into(simd));
            (a.combine(b), c.combine(d))
        }
        _ => {
            let (mut found, index) = ([[0; 2]; LANES], index.to_array());
            for lane in 0..LANES {
                let [a, b, c, d] = table[index[lane] as usize].map(u32::from);
                found[lane] = [(a | b << 16) as i32, (c | d << 16) as i32];
            }
            let (low, high) = found.as_flattened().split_at(LANES);
            (i32x16::from_slice(simd, low), i32x16::from_slice(simd, high))
        }
    };
    [low.unzip_low(high), low.unzip_high(high)]
}

/// Writes the selected lanes consecutively to `to`, from index `at` on. Precondition: `to` has room for all 16.
#[inline(always)]
pub fn append<S: Simd>(simd: S, to: &mut [i32], at: usize, lanes: u32, from: i32x16<S>) {
    let to = &mut to[at..at + LANES];
    match simd.level() {
        #[cfg(target_arch = "x86_64")]
        Level::Avx512(token) => {
            let packed: i32x16<S> = x86_64::compress_avx512(token, lanes as u16, from.into()).simd_into(simd);
            packed.store_slice(to);
        }
        #[cfg(target_arch = "x86_64")]
        Level::Avx2(token) => {
            let (low, high) = from.split();
            let low: i32x8<S> = x86_64::compress_avx2(token, lanes as u8, low.into()).simd_into(simd);
            let high: i32x8<S> =
                x86_64::compress_avx2(token, (lanes >> 8) as u8, high.into()).simd_into(simd);
            let middle = (lanes & 0xff).count_ones() as usize;
            low.store_slice(&mut to[..8]);
            high.store_slice(&mut to[middle..middle + 8]);
        }
        _ => move_to_front(to, lanes, &from.to_array()),
    }
}

/// Writes the numbers of the set bits consecutively to `to`, from index `at` on; the lowest bit has number `first`.
/// Precondition: `to` has room for all 64.
#[inline(always)]
pub fn append_numbers<S: Simd>(simd: S, to: &mut [u8], at: usize, bits: u64, first: u8) {
    let to = &mut to[at..at + BYTE_LANES];
    match simd.level() {
        #[cfg(target_arch = "x86_64")]
        Level::Avx512(_) => {
            let numbers = u8x64::load_array(simd, BYTE_NUMBERS) + first;
            numbers.compress(mask8x64::from_bitmask(simd, bits)).store_slice(to);
        }
        _ => {
            let first = u64::from_le_bytes([first; 8]);
            let mut count = 0;
            for (byte, offset) in
                bits.to_le_bytes().into_iter().zip((0..8).map(|k| u64::from_le_bytes([8 * k; 8])))
            {
                let numbers = u64::from_le_bytes(SET_BITS[usize::from(byte)]) + (first + offset);
                to[count..count + 8].copy_from_slice(&numbers.to_le_bytes());
                count += byte.count_ones() as usize;
            }
        }
    }
}

/// The index of each byte of a register.
const BYTE_NUMBERS: [u8; BYTE_LANES] = {
    let mut numbers = [0; BYTE_LANES];
    let mut k = 0;
    while k < BYTE_LANES {
        numbers[k] = k as u8;
        k += 1;
    }
    numbers
};

/// For every byte, the numbers of its set bits, lowest first.
static SET_BITS: [[u8; 8]; 256] = set_bits();

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

/// Writes the selected lanes consecutively.
#[inline(always)]
fn move_to_front<T: Copy>(to: &mut [T], lanes: u32, from: &[T; LANES]) {
    let (mut left, mut count) = (lanes & 0xffff, 0);
    while left != 0 {
        to[count] = from[left.trailing_zeros() as usize];
        count += 1;
        left &= left - 1;
    }
}

/// Prefetches cache lines that will be read soon.
#[inline(always)]
pub fn prefetch(lines: &[Line]) {
    for line in lines {
        #[cfg(target_arch = "x86_64")]
        // SAFETY: a prefetch has no effect that the program can observe, and never faults.
        unsafe {
            use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
            _mm_prefetch::<_MM_HINT_T0>(std::ptr::from_ref(line).cast());
        }
        #[cfg(not(target_arch = "x86_64"))]
        let _ = line;
    }
}

#[cfg(test)]
mod tests {
    use std::panic::{AssertUnwindSafe, catch_unwind};

    use super::*;
    use crate::dispatch;

    /// The entries of a table with these numbers, or `None` after a panic.
    fn looked_up(level: SimdLevel, table: &[[u16; 4]], index: [i32; LANES]) -> Option<Vec<[u16; 4]>> {
        let found = catch_unwind(AssertUnwindSafe(|| {
            dispatch!(level.level().unwrap(), simd => {
                lookup_fours(simd, table, i32x16::load_array(simd, index)).map(|half| half.to_array())
            })
        }));
        let [low, high] = found.ok()?;
        let of = |lane: usize| {
            let [low, high] = [low[lane] as u32, high[lane] as u32];
            [low as u16, (low >> 16) as u16, high as u16, (high >> 16) as u16]
        };
        Some((0..LANES).map(of).collect())
    }

    #[test]
    fn fours_are_those_of_the_table_and_no_others_are_read() {
        let table: Vec<[u16; 4]> =
            (0..1000_u16).map(|n| [n, n.wrapping_mul(77), 65535 - n, n.rotate_left(9)]).collect();
        let index: [i32; LANES] = std::array::from_fn(|lane| (lane as i32 * 311 + 999) % 1000);
        for level in SimdLevel::available() {
            let expected: Vec<[u16; 4]> = index.iter().map(|&n| table[n as usize]).collect();
            assert_eq!(looked_up(level, &table, index), Some(expected), "{level}");
            assert_eq!(looked_up(level, &table[..1], [0; LANES]), Some(vec![table[0]; LANES]), "{level}");
            for (table, wrong) in
                [(&table[..], 1000), (&table, -1), (&table, i32::MIN), (&table, i32::MAX), (&[], 0)]
            {
                for lane in [0, 7, 8, LANES - 1] {
                    let mut index = [0; LANES];
                    index[lane] = wrong;
                    assert_eq!(looked_up(level, table, index), None, "{level}, {wrong} in lane {lane}");
                }
            }
        }
    }
}
