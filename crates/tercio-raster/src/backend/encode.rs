//! Linear light to 8-bit sRGB, 16 pixels at a time: [`encode8`](crate::color::encode8) and [`color8`](crate::color8), lane
//! by lane.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16};

use super::light::Vec3x16;
use crate::color::{
    ENCODE, ENCODE_BASE_SHIFT, ENCODE_FRACTION, ENCODE_MAX, ENCODE_MIN, ENCODE_SEGMENT_SHIFT,
    ENCODE_STEP_SHIFT, ENCODE_STEPS,
};
use crate::simd::{each3, lookup_128, part, splat};

/// Opaque RGBA pixels, red in the lowest byte, which is their order in memory.
#[inline(always)]
pub fn opaque<S: Simd>(simd: S, linear: Vec3x16<S>) -> i32x16<S> {
    let table = &**ENCODE;
    let [r, g, b] = each3!(C => level(simd, table, linear[C]));
    part(
        simd,
        #[inline(always)]
        || ((r | (g << 8)) | (b << 16)) | (255 << 24),
    )
}

/// [`color8`](crate::color8) of 16 colours, given by their components: RGBA pixels, red in the lowest byte, which is their
/// order in memory.
#[inline(always)]
pub fn color8_lanes<S: Simd>(simd: S, [r, g, b, alpha]: [f32x16<S>; 4]) -> i32x16<S> {
    let (none, one) = (splat(simd, 0.0), splat(simd, 1.0));
    let mut linear = [r, g, b];
    let is_opaque = alpha.simd_ge(one);
    // Most pixels are opaque, and three divisions take longer than all the rest.
    if is_opaque.any_false() {
        let shows = alpha.simd_gt(none);
        let divisor = is_opaque.select(one, alpha);
        linear = each3!(C => shows.select(linear[C] / divisor, none));
    }
    let table = &**ENCODE;
    let [r, g, b] = each3!(C => level(simd, table, linear[C]));
    part(
        simd,
        #[inline(always)]
        || {
            // NaN becomes 0, as it does in a conversion of single numbers.
            let alpha = alpha.simd_gt(none).select(alpha, none);
            let alpha = is_opaque.select(one, alpha) * 255.0 + 0.5;
            let alpha: i32x16<S> = alpha.to_int();
            ((r | (g << 8)) | (b << 16)) | (alpha << 24)
        },
    )
}

/// 8-bit levels of one colour component.
#[inline(always)]
fn level<S: Simd>(simd: S, table: &[i32; 128], linear: f32x16<S>) -> i32x16<S> {
    let bits: i32x16<S> = part(
        simd,
        #[inline(always)]
        || {
            let (least, most) = (splat(simd, ENCODE_MIN), splat(simd, ENCODE_MAX));
            let above = linear.simd_gt(least).select(linear, least);
            above.simd_lt(most).select(above, most).bitcast()
        },
    );
    let entry = lookup_128(simd, table, (bits - ENCODE_MIN.to_bits() as i32) >> ENCODE_SEGMENT_SHIFT);
    part(
        simd,
        #[inline(always)]
        || {
            let step = (bits >> ENCODE_STEP_SHIFT) & (ENCODE_STEPS as i32 - 1);
            // Entries are not negative: their upper half is less than 2^15.
            (((entry >> 16) << ENCODE_BASE_SHIFT) + (entry & 0xffff) * step) >> ENCODE_FRACTION
        },
    )
}

#[cfg(test)]
mod tests {
    use crate::dispatch;

    use super::*;
    use crate::color::encode8;
    use crate::color8;
    use crate::settings::SimdLevel;
    use crate::simd::LANES;

    #[test]
    fn every_simd_level_encodes_as_the_scalar_function() {
        for level in SimdLevel::available() {
            let level = level.level().unwrap();
            for bits in (0..u32::MAX - 16).step_by(1_000_003) {
                let red: [f32; LANES] = std::array::from_fn(|i| f32::from_bits(bits + i as u32));
                let green = red.map(|v| -v);
                let blue: [f32; LANES] =
                    std::array::from_fn(|i| (bits >> 16) as f32 / 65536.0 + i as f32 * 1e-5);
                let found = dispatch!(level, simd => {
                    let linear = [red, green, blue].map(|c| f32x16::load_array(simd, c));
                    opaque(simd, linear).to_array()
                });
                for i in 0..LANES {
                    let expected = [encode8(red[i]), encode8(green[i]), encode8(blue[i]), 255];
                    assert_eq!((found[i] as u32).to_le_bytes(), expected, "{} {}", red[i], blue[i]);
                }
            }
        }
    }

    #[test]
    fn every_simd_level_encodes_colors_as_the_scalar_function() {
        let alphas =
            [0.0, -0.0, 1.0, 0.25, 0.999, 1.5, -1.0, 1e-40, f32::NAN, f32::INFINITY, f32::NEG_INFINITY];
        for level in SimdLevel::available() {
            let level = level.level().unwrap();
            for (turn, bits) in (0..u32::MAX - 16).step_by(1_000_003).enumerate() {
                let red: [f32; LANES] = std::array::from_fn(|i| f32::from_bits(bits + i as u32));
                let green: [f32; LANES] =
                    std::array::from_fn(|i| (bits >> 16) as f32 / 65536.0 + i as f32 * 1e-5);
                let blue = green.map(|v| v * 0.5);
                let mut alpha: [f32; LANES] = std::array::from_fn(|i| alphas[(turn + i) % alphas.len()]);
                if turn % 3 == 0 {
                    alpha = [1.0; LANES];
                }
                let found = dispatch!(level, simd => {
                    let linear = [red, green, blue, alpha].map(|c| f32x16::load_array(simd, c));
                    color8_lanes(simd, linear).to_array()
                });
                for i in 0..LANES {
                    let color = [red[i], green[i], blue[i], alpha[i]];
                    assert_eq!((found[i] as u32).to_le_bytes(), color8(color), "{color:?}");
                }
            }
        }
    }
}
