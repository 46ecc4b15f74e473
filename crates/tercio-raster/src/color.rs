//! Linear light to sRGB and back, as tables: the same on every machine.

use std::sync::LazyLock;

use tercio_scene::color::{linear_to_srgb, srgb_to_linear};

/// Linear light below this, 0.4 of a level, is black in 8 bits.
pub const ENCODE_MIN: f32 = 1.0 / 8192.0;
/// The largest number below 1.
pub const ENCODE_MAX: f32 = 1.0 - f32::EPSILON / 2.0;
/// The bits of an `f32` from this one upwards select the segment.
pub const ENCODE_SEGMENT_SHIFT: u32 = 20;
/// The bits from this one up to the segment's select the step in the segment.
pub const ENCODE_STEP_SHIFT: u32 = 12;
/// Steps per segment.
pub const ENCODE_STEPS: u32 = 1 << (ENCODE_SEGMENT_SHIFT - ENCODE_STEP_SHIFT);
/// Fraction bits of a level.
pub const ENCODE_FRACTION: u32 = 16;
/// The left shift of the upper half of an entry that gives it [`ENCODE_FRACTION`] fraction bits.
pub const ENCODE_BASE_SHIFT: u32 = 9;

/// 8-bit sRGB from linear light as a piecewise linear function with eight segments per octave, few enough for a table
/// in vector registers: the upper half of an entry is the level at the start of the segment, the lower half the
/// increment per step. A level is never more than 0.56 from the exact one.
pub static ENCODE: LazyLock<Box<[i32; 128]>> = LazyLock::new(|| {
    let first = ENCODE_MIN.to_bits() >> ENCODE_SEGMENT_SHIFT;
    let segments = (ENCODE_MAX.to_bits() >> ENCODE_SEGMENT_SHIFT) - first + 1;
    let mut table = Box::new([0; 128]);
    for (entry, segment) in table.iter_mut().zip(first..first + segments) {
        let at = |step: f64| {
            let edge = |s: u32| f64::from(f32::from_bits(s << ENCODE_SEGMENT_SHIFT));
            let part = (step + 0.5) / f64::from(ENCODE_STEPS);
            linear_to_srgb(edge(segment) + (edge(segment + 1) - edge(segment)) * part) * 255.0
        };
        let last = f64::from(ENCODE_STEPS - 1);
        let growth = (at(last) - at(0.0)) / last;
        // The curve is above the chord, farthest near the middle: raising the chord by half of that balances the error.
        let bulge = (at(0.5 * last) - (at(0.0) + at(last)) * 0.5) * 0.5;
        let base = (at(0.0) + bulge + 0.5) * f64::from(1 << (ENCODE_FRACTION - ENCODE_BASE_SHIFT));
        let growth = growth * f64::from(1 << ENCODE_FRACTION);
        *entry = ((base + 0.5) as i32) << 16 | (growth + 0.5) as i32;
    }
    table
});

/// 8-bit sRGB of linear light, clamped to the range from 0 to 1; NaN is encoded as black.
pub fn encode8(linear: f32) -> u8 {
    // NaN is detected by its bits: on AArch64, compilers replace a comparison by an instruction for the larger of two
    // numbers, for which a signalling NaN is the larger.
    let is_number = linear.to_bits() << 1 <= f32::INFINITY.to_bits() << 1;
    let bits = if is_number { linear.clamp(ENCODE_MIN, ENCODE_MAX) } else { ENCODE_MIN }.to_bits();
    let entry = ENCODE[((bits - ENCODE_MIN.to_bits()) >> ENCODE_SEGMENT_SHIFT) as usize] as u32;
    let step = (bits >> ENCODE_STEP_SHIFT) & (ENCODE_STEPS - 1);
    ((((entry >> 16) << ENCODE_BASE_SHIFT) + (entry & 0xffff) * step) >> ENCODE_FRACTION) as u8
}

/// Linear light of each 8-bit sRGB level.
pub static DECODE: LazyLock<Box<[f32; 256]>> =
    LazyLock::new(|| Box::new(std::array::from_fn(|i| srgb_to_linear(i as f64 / 255.0) as f32)));

/// 16-bit sRGB of linear light, clamped to the range from 0 to 1; NaN is encoded as black.
pub fn encode16(linear: f32) -> u16 {
    let linear = if linear.is_nan() { 0.0 } else { f64::from(linear).clamp(0.0, 1.0) };
    (linear_to_srgb(linear) * 65535.0 + 0.5) as u16
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_level_survives_the_round_trip() {
        for level in 0..=255u8 {
            let linear = DECODE[usize::from(level)];
            assert_eq!(encode8(linear), level);
            assert_eq!(encode16(linear), u16::from(level) * 257);
        }
    }

    #[test]
    fn levels_are_close_and_never_fall() {
        let mut before = 0;
        let most = 1.1f32.to_bits();
        for bits in (1e-6f32.to_bits()..most).step_by(37) {
            let linear = f32::from_bits(bits);
            let level = encode8(linear);
            assert!(level >= before, "{linear}");
            let exact = linear_to_srgb(f64::from(linear).min(1.0)) * 255.0;
            assert!((f64::from(level) - exact).abs() <= 0.56, "{linear}: {level}, {exact}");
            before = level;
        }
        let special = [f32::NAN, f32::NEG_INFINITY, -0.0, 2.0, f32::INFINITY];
        assert_eq!(special.map(encode8), [0, 0, 0, 255, 255]);
        assert_eq!(special.map(encode16), [0, 0, 0, 65535, 65535]);
    }
}
