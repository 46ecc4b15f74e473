//! Tone mapping, 16 pixels at a time: [`Tone::map`], lane by lane.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};

use super::light::Vec3x16;
use crate::simd::{each3, splat};
use crate::tone::{BRIGHTEST, FILMIC, LUMINANCE, NEUTRAL_FADE, NEUTRAL_START, Tone, ToneCurve};

/// Maps linear RGB. Not inlined, so that kernels of pictures without tone mapping stay small.
#[inline(never)]
pub fn map<S: Simd>(simd: S, tone: &Tone, light: &Vec3x16<S>) -> Vec3x16<S> {
    simd.vectorize(
        #[inline(always)]
        || map_inline(simd, tone, light),
    )
}

#[inline(always)]
fn map_inline<S: Simd>(simd: S, tone: &Tone, light: &Vec3x16<S>) -> Vec3x16<S> {
    let one = splat(simd, 1.0);
    let light: Vec3x16<S> = each3!(C => limited(simd, light[C] * tone.exposure));
    match tone.curve {
        ToneCurve::Clip => light,
        ToneCurve::Reinhard => {
            let luminance = (light[0] * LUMINANCE[0] + light[1] * LUMINANCE[1]) + light[2] * LUMINANCE[2];
            let scale = one / (luminance + one);
            each3!(C => light[C] * scale)
        }
        ToneCurve::Filmic => {
            let [a, b, c, d, e] = FILMIC;
            each3!(C => {
                let above = light[C] * (light[C] * a + splat(simd, b));
                above / (light[C] * (light[C] * c + splat(simd, d)) + splat(simd, e))
            })
        }
        ToneCurve::Neutral => {
            let [r, g, b] = light;
            let least = r.simd_lt(g).select(r, g);
            let least = least.simd_lt(b).select(least, b);
            let dark = least - (least * least) * 6.25;
            let offset = least.simd_lt(splat(simd, 0.08)).select(dark, splat(simd, 0.04));
            let [r, g, b] = [r - offset, g - offset, b - offset];
            let peak = r.simd_gt(g).select(r, g);
            let peak = peak.simd_gt(b).select(peak, b);
            let is_bright = peak.simd_gt(splat(simd, NEUTRAL_START));
            let range = 1.0 - NEUTRAL_START;
            let new = one - splat(simd, range * range) / (peak + splat(simd, range - NEUTRAL_START));
            let scale = new / peak;
            let white = one - one / ((peak - new) * NEUTRAL_FADE + one);
            let light = [r, g, b];
            each3!(C => {
                let c = light[C] * scale;
                is_bright.select(c + (new - c) * white, light[C])
            })
        }
    }
}

#[inline(always)]
fn limited<S: Simd>(simd: S, c: f32x16<S>) -> f32x16<S> {
    let (zero, most) = (splat(simd, 0.0), splat(simd, BRIGHTEST));
    let c = c.simd_gt(zero).select(c, zero);
    c.simd_lt(most).select(c, most)
}

#[cfg(test)]
mod tests {
    use crate::dispatch;

    use super::*;
    use crate::settings::SimdLevel;
    use crate::simd::LANES;

    #[test]
    fn every_simd_level_maps_as_the_scalar_function() {
        let special = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -0.0, 0.0, 1e38];
        for level in SimdLevel::available() {
            let level = level.level().unwrap();
            for curve in [ToneCurve::Clip, ToneCurve::Reinhard, ToneCurve::Filmic, ToneCurve::Neutral] {
                let tone = Tone { exposure: 1.7, curve };
                for round in 0..400 {
                    let value = |i: usize| match (round + i) % 23 {
                        n if n < special.len() => special[n],
                        _ => 1e-3 * 1.03f32.powi(((round * 31 + i * 17) % 500) as i32),
                    };
                    let light: [[f32; LANES]; 3] = [0, 7, 13].map(|c| std::array::from_fn(|i| value(i + c)));
                    let found = dispatch!(level, simd => {
                        let light = light.map(|c| f32x16::load_array(simd, c));
                        map(simd, &tone, &light).map(|c| c.to_array())
                    });
                    for i in 0..LANES {
                        let expected = tone.map([0, 1, 2].map(|c| light[c][i]));
                        assert_eq!([0, 1, 2].map(|c| found[c][i]), expected, "{curve:?}");
                    }
                }
            }
        }
    }
}
