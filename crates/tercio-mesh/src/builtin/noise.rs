//! Random numbers and noise from integer hashes.

/// A well mixed 64-bit hash of a number (the finaliser of SplitMix64, Steele et al. 2014).
#[inline]
pub fn hash(x: u64) -> u64 {
    let mut h = x.wrapping_add(0x9E37_79B9_7F4A_7C15);
    h = (h ^ (h >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    h = (h ^ (h >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    h ^ (h >> 31)
}

/// The top half of a hash as a number from 0 (inclusive) to 1 (exclusive).
#[inline]
pub fn unit(hash: u64) -> f64 {
    (hash >> 40) as f64 * (1.0 / (1u64 << 24) as f64)
}

/// Gradient noise in the plane (Perlin 2002): smooth, 0 at whole numbers, about -1 to 1.
#[inline]
pub fn gradient_noise(x: f64, y: f64, seed: u64) -> f64 {
    let (fx, fy) = (x.floor(), y.floor());
    let (ix, iy) = (fx as i64 as u64, fy as i64 as u64);
    let (x, y) = (x - fx, y - fy);
    let corner = |dx: u64, dy: u64| {
        let cell = ix.wrapping_add(dx) << 32 | iy.wrapping_add(dy) & 0xFFFF_FFFF;
        let h = hash(cell ^ seed);
        // A gradient from a square is good enough: its anisotropy is not visible among the octaves.
        let (gx, gy) = (unit(h) * 2.0 - 1.0, unit(h << 24) * 2.0 - 1.0);
        gx * (x - dx as f64) + gy * (y - dy as f64)
    };
    let fade = |t: f64| t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
    let (u, v) = (fade(x), fade(y));
    let mix = |a: f64, b: f64, t: f64| a + (b - a) * t;
    1.5 * mix(mix(corner(0, 0), corner(1, 0), u), mix(corner(0, 1), corner(1, 1), u), v)
}
