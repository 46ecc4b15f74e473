//! Tone mapping: from the light that surfaces reflect, which may be brighter than any display, to what is shown.
//!
//! Every sample is mapped by itself, before samples are averaged and layers blended, so that the edges of bright surfaces
//! are as smooth as others. Unlit colours and backgrounds are not mapped.

use crate::error::RenderError;

/// How bright light is compressed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum ToneCurve {
    /// Not at all: what is brighter than the display is clipped.
    #[default]
    Clip,
    /// By luminance Y, with 1 / (1 + Y). Source: Reinhard et al., "Photographic tone reproduction for digital images" (2002),
    /// equation 3.
    Reinhard,
    /// Each channel by an S-shaped curve as of film: contrast is higher, bright colours fade to white. Source: Narkowicz,
    /// "ACES filmic tone mapping curve" (2016).
    Filmic,
    /// Colours up to 0.8 stay as they are, but for 0.04 that is taken from all; brighter ones are compressed and fade to
    /// white. Source: Khronos Group, "PBR neutral tone mapper" (2024).
    Neutral,
}

/// Exposure and tone curve of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tone {
    /// The factor of all light; above 0, at most 1e6.
    pub exposure: f32,
    /// How bright light is compressed, after that.
    pub curve: ToneCurve,
}

impl Default for Tone {
    fn default() -> Self {
        Self::NONE
    }
}

/// Brighter light is no brighter.
pub const BRIGHTEST: f32 = 1e6;
/// The shares of the channels in luminance (ITU-R BT.709).
pub const LUMINANCE: [f32; 3] = [0.2126, 0.7152, 0.0722];
/// Of [`ToneCurve::Filmic`]: the factors of the numerator and of the denominator.
pub const FILMIC: [f32; 5] = [2.51, 0.03, 2.43, 0.59, 0.14];
/// Of [`ToneCurve::Neutral`]: where compression begins, and how fast bright colours fade.
pub const NEUTRAL_START: f32 = 0.8 - 0.04;
/// See [`NEUTRAL_START`].
pub const NEUTRAL_FADE: f32 = 0.15;

impl Tone {
    /// Light as it is.
    pub const NONE: Self = Self { exposure: 1.0, curve: ToneCurve::Clip };

    /// Fails for an exposure out of range.
    ///
    /// # Errors
    /// [`RenderError::Setting`].
    pub fn check(&self) -> Result<(), RenderError> {
        if self.exposure > 0.0 && self.exposure <= BRIGHTEST {
            return Ok(());
        }
        let (range, value) = (format!("above 0, at most {BRIGHTEST}"), self.exposure.to_string());
        Err(RenderError::Setting { what: "exposure", range, value })
    }

    /// Maps linear RGB; NaN becomes 0. The result may be above 1 where one channel is.
    pub fn map(&self, light: [f32; 3]) -> [f32; 3] {
        let [r, g, b] = light.map(|c| limited(c * self.exposure));
        match self.curve {
            ToneCurve::Clip => [r, g, b],
            ToneCurve::Reinhard => {
                let luminance = (r * LUMINANCE[0] + g * LUMINANCE[1]) + b * LUMINANCE[2];
                let scale = 1.0 / (luminance + 1.0);
                [r * scale, g * scale, b * scale]
            }
            ToneCurve::Filmic => {
                let [a, b0, c0, d, e] = FILMIC;
                [r, g, b].map(|c| (c * (c * a + b0)) / (c * (c * c0 + d) + e))
            }
            ToneCurve::Neutral => {
                let least = if r < g { r } else { g };
                let least = if least < b { least } else { b };
                let offset = if least < 0.08 { least - (least * least) * 6.25 } else { 0.04 };
                let [r, g, b] = [r - offset, g - offset, b - offset];
                let peak = if r > g { r } else { g };
                let peak = if peak > b { peak } else { b };
                if !(peak > NEUTRAL_START) {
                    return [r, g, b];
                }
                let range = 1.0 - NEUTRAL_START;
                let new = 1.0 - (range * range) / (peak + (range - NEUTRAL_START));
                let (scale, white) = (new / peak, 1.0 - 1.0 / ((peak - new) * NEUTRAL_FADE + 1.0));
                [r, g, b].map(|c| {
                    let c = c * scale;
                    c + (new - c) * white
                })
            }
        }
    }
}

/// Light from 0 to [`BRIGHTEST`]; NaN becomes 0.
fn limited(c: f32) -> f32 {
    let c = if c > 0.0 { c } else { 0.0 };
    if c < BRIGHTEST { c } else { BRIGHTEST }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CURVES: [ToneCurve; 4] =
        [ToneCurve::Clip, ToneCurve::Reinhard, ToneCurve::Filmic, ToneCurve::Neutral];

    /// Values that follow from the published formulas.
    #[test]
    fn known_values() {
        let near = |curve, light: [f32; 3], expected: [f32; 3]| {
            let found = Tone { exposure: 1.0, curve }.map(light);
            let is_near = found.iter().zip(expected).all(|(f, e)| (f - e).abs() < 2e-6);
            assert!(is_near, "{curve:?} {light:?}: {found:?}, not {expected:?}");
        };
        near(ToneCurve::Reinhard, [1.0; 3], [0.5; 3]);
        near(ToneCurve::Reinhard, [3.0; 3], [0.75; 3]);
        near(ToneCurve::Filmic, [1.0; 3], [2.54 / 3.16; 3]);
        near(ToneCurve::Filmic, [0.0; 3], [0.0; 3]);
        near(ToneCurve::Neutral, [0.5; 3], [0.46; 3]);
        // Without a least channel, nothing is taken away; compression begins at 0.76.
        near(ToneCurve::Neutral, [0.0, 0.5, 0.7], [0.0, 0.5, 0.7]);
        // A peak of 0.96 becomes 1 - 0.24^2 / (0.96 + 0.24 - 0.76).
        near(ToneCurve::Neutral, [1.0; 3], [1.0 - 0.0576 / 0.44; 3]);
    }

    #[test]
    fn brighter_light_is_shown_no_darker_and_nothing_is_undefined() {
        for curve in CURVES {
            let grey = |c: f32| Tone { exposure: 1.0, curve }.map([c; 3]);
            let mut before = -1.0;
            for step in 0..4000 {
                let [r, g, b] = grey(1e-4 * 1.005f32.powi(step));
                assert!(r == g && g == b && r >= before - 1e-6, "{curve:?} {step}: {r} after {before}");
                before = r;
            }
            for strange in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0, 1e38, 1e-40] {
                let [r, g, b] = Tone { exposure: 3.0, curve }.map([strange, 0.5, strange]);
                assert!(r.is_finite() && g.is_finite() && b.is_finite(), "{curve:?} {strange}");
            }
        }
    }

    #[test]
    fn exposure_is_a_factor() {
        for curve in CURVES {
            let [once, twice] = [1.0, 2.0].map(|exposure| Tone { exposure, curve });
            assert_eq!(twice.map([0.1, 0.2, 0.4]), once.map([0.2, 0.4, 0.8]));
        }
        for exposure in [0.0, -1.0, f32::NAN, f32::INFINITY, 2e6] {
            assert!(Tone { exposure, curve: ToneCurve::Clip }.check().is_err(), "{exposure}");
        }
    }
}
