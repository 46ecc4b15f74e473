//! Linear light to sRGB and back, the same on every machine: tables made by basic operations only, without
//! the system's mathematical library, whose last digit differs from one to the next.

use std::sync::LazyLock;

/// Steps of the table from linear light to 8-bit sRGB. At the dark end, where sRGB is steepest, one step is
/// 0.4 of a level.
pub const ENCODE_STEPS: usize = 8192;

/// 8-bit sRGB of linear light `i / (ENCODE_STEPS - 1)`.
pub static ENCODE: LazyLock<Box<[u8; ENCODE_STEPS]>> = LazyLock::new(|| {
    let mut table = Box::new([0; ENCODE_STEPS]);
    for (i, entry) in table.iter_mut().enumerate() {
        *entry = (encode(i as f64 / (ENCODE_STEPS - 1) as f64) * 255.0 + 0.5) as u8;
    }
    table
});

/// Linear light of each 8-bit sRGB level.
pub static DECODE: LazyLock<Box<[f32; 256]>> =
    LazyLock::new(|| Box::new(std::array::from_fn(|i| decode(i as f64 / 255.0) as f32)));

/// 16-bit sRGB of linear light, clamped to 0 to 1.
pub fn encode16(linear: f32) -> u16 {
    (encode(f64::from(linear).clamp(0.0, 1.0)) * 65535.0 + 0.5) as u16
}

/// sRGB of linear light, both 0 to 1. Source: IEC 61966-2-1.
fn encode(linear: f64) -> f64 {
    if linear <= 0.003_130_8 {
        return linear * 12.92;
    }
    // x^(1/2.4) = x^(5/12) = x^(1/4) * x^(1/6)
    let root = linear.sqrt();
    1.055 * (root.sqrt() * nth_root::<3>(root)) - 0.055
}

/// Linear light of sRGB, both 0 to 1.
fn decode(srgb: f64) -> f64 {
    if srgb <= 0.04045 {
        return srgb / 12.92;
    }
    // x^2.4 = x^2 * (x^(1/5))^2
    let x = (srgb + 0.055) / 1.055;
    let root = nth_root::<5>(x);
    (x * x) * (root * root)
}

/// The N-th root of a number from 0 to 1 by Newton's iteration from above, where it falls without overshooting.
fn nth_root<const N: i32>(x: f64) -> f64 {
    let n = f64::from(N);
    let mut root = 1.0;
    loop {
        let mut power = 1.0;
        (1..N).for_each(|_| power *= root);
        let next = ((n - 1.0) * root + x / power) / n;
        if next >= root {
            return root;
        }
        root = next;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn encoding_follows_the_standard() {
        for i in 0..=10_000 {
            let x = f64::from(i) / 10_000.0;
            assert!((encode(x) - tercio_scene::color::linear_to_srgb(x)).abs() < 1e-12, "{x}");
            assert!((decode(x) - tercio_scene::color::srgb_to_linear(x)).abs() < 1e-12, "{x}");
        }
    }

    #[test]
    fn every_level_survives_the_round_trip() {
        for level in 0..=255u8 {
            let linear = DECODE[usize::from(level)];
            let index = (linear * (ENCODE_STEPS - 1) as f32 + 0.5) as usize;
            assert_eq!(ENCODE[index], level);
            assert_eq!(encode16(linear), u16::from(level) * 257);
        }
    }
}
