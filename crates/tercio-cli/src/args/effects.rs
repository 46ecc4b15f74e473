//! Options of what happens to light after shading: exposure, tone mapping, and effects on the finished picture.

use clap::{Args, ValueEnum};
use serde_json::{Value, json};
use tercio::effects::{AmbientOcclusion, EyeDome};
use tercio::raster::{Frame, Outputs, RenderError, Settings, Tone, ToneCurve};
use tercio::scene::{Camera, Scene};

use super::values;

/// How bright light is compressed.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum ToneName {
    /// Not at all: what is brighter than white is white.
    None,
    /// By luminance.
    Reinhard,
    /// As film does, with more contrast.
    Filmic,
    /// Only bright colours are compressed; the others keep hue and saturation, a little darker.
    Neutral,
}

impl From<ToneName> for ToneCurve {
    fn from(name: ToneName) -> Self {
        match name {
            ToneName::None => Self::Clip,
            ToneName::Reinhard => Self::Reinhard,
            ToneName::Filmic => Self::Filmic,
            ToneName::Neutral => Self::Neutral,
        }
    }
}

/// Exposure, tone mapping and effects.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Drawing")]
pub struct EffectArgs {
    /// Makes reflected light brighter by this many stops, each a factor of 2, -15 to 15; the background stays as it is
    /// [default: 0].
    #[arg(long, value_name = "STOPS", allow_negative_numbers = true, value_parser = stops)]
    exposure: Option<f64>,
    /// How light brighter than white is compressed.
    #[arg(long, value_name = "CURVE", value_enum, default_value_t = ToneName::None)]
    tone: ToneName,
    /// Darkens gaps and pockets that little of the surroundings' light can reach, with a strength of 0 to 1: all of the
    /// nearest surface's light, by what is visible around it.
    #[arg(long, value_name = "STRENGTH", num_args = 0..=1, default_missing_value = "1", require_equals = true)]
    #[arg(value_parser = values::share)]
    ao: Option<f64>,
    /// How far surfaces darken each other with --ao, in radii of the model, at most 2 [default: 0.2].
    #[arg(long, value_name = "RADII", allow_negative_numbers = true, value_parser = radius, requires = "ao")]
    ao_radius: Option<f64>,
    /// Darkens what lies behind something else or slopes away (eye-dome lighting), for dense scans; with a strength of 0 to
    /// 100, 1 is usual. Points without a colour are light with it.
    #[arg(long, value_name = "STRENGTH", num_args = 0..=1, default_missing_value = "1", require_equals = true)]
    #[arg(value_parser = edl_strength)]
    edl: Option<f64>,
    /// Width of the outlines of --edl, 1 to 64 pixels [default: a thousandth of the picture's height].
    #[arg(long, value_name = "PIXELS", requires = "edl")]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=i64::from(EyeDome::MAX_RADIUS)))]
    edl_radius: Option<u32>,
}

/// 2 to a power of -15 to 15, the same on every machine: the product of the powers of its binary digits, which are repeated
/// square roots.
fn power_of_two(exponent: f64) -> f64 {
    let mut rest = exponent - exponent.floor();
    let (mut power, mut root) = (1.0, 2.0f64);
    for _ in 0..52 {
        root = root.sqrt();
        rest *= 2.0;
        if rest >= 1.0 {
            rest -= 1.0;
            power *= root;
        }
    }
    power * 2f64.powi(exponent.floor() as i32)
}

fn stops(text: &str) -> Result<f64, String> {
    let stops = values::number(text).ok().filter(|stops| stops.abs() <= 15.0);
    stops.ok_or_else(|| "expected a number of -15 to 15".into())
}

fn radius(text: &str) -> Result<f64, String> {
    let radius = values::positive(text).ok().filter(|&radius| radius <= AmbientOcclusion::MAX_RADIUS);
    radius.ok_or_else(|| format!("expected a number above 0, at most {}", AmbientOcclusion::MAX_RADIUS))
}

fn edl_strength(text: &str) -> Result<f64, String> {
    let strength = values::number(text).ok().filter(|s| (0.0..=100.0).contains(s));
    strength.ok_or_else(|| "expected a number of 0 to 100".into())
}

impl EffectArgs {
    /// Exposure and tone curve.
    pub fn tone(&self) -> Tone {
        Tone { exposure: power_of_two(self.exposure.unwrap_or(0.0)) as f32, curve: self.tone.into() }
    }

    fn occlusion(&self) -> Option<AmbientOcclusion> {
        let radius = self.ao_radius.unwrap_or(AmbientOcclusion::default().radius);
        let strength = self.ao.filter(|&strength| strength > 0.0);
        strength.map(|strength| AmbientOcclusion { radius, strength: strength as f32 })
    }

    fn eye_dome(&self) -> Option<EyeDome> {
        let strength = self.edl.filter(|&strength| strength > 0.0);
        strength.map(|strength| EyeDome { strength: strength as f32, radius: self.edl_radius })
    }

    /// Does an effect make forms visible by darkening what is deep?
    pub fn darkens(&self) -> bool {
        self.occlusion().is_some() || self.eye_dome().is_some()
    }

    /// The planes that the effects need.
    pub fn needed(&self) -> Outputs {
        let occlusion = self.occlusion().map_or(Outputs::NONE, |_| AmbientOcclusion::NEEDED);
        occlusion.with(self.eye_dome().map_or(Outputs::NONE, |_| EyeDome::NEEDED))
    }

    /// Whether there is an effect on the finished picture.
    pub fn are_applied(&self) -> bool {
        self.occlusion().is_some() || self.eye_dome().is_some()
    }

    /// Bytes of memory that the effects take for a picture, besides it, at most.
    pub fn bytes(&self, (width, height): (u32, u32)) -> u64 {
        // Depths of every fourth pixel, once more with margins as wide as the largest radius, and what occludes them.
        let pixels = (u64::from(width) + 1200) * (u64::from(height) + 1200);
        if self.occlusion().is_some() { pixels.saturating_mul(3) } else { 0 }
    }

    /// Applies the effects to a finished picture, which was drawn on a transparent background.
    ///
    /// # Errors
    /// [`RenderError`].
    pub fn apply(
        &self,
        frame: &mut Frame,
        scene: &Scene,
        camera: &Camera,
        settings: &Settings,
    ) -> Result<(), RenderError> {
        if let Some(occlusion) = self.occlusion() {
            occlusion.apply(frame, scene, camera, settings)?;
        }
        if let Some(eye_dome) = self.eye_dome() {
            eye_dome.apply(frame, scene, camera, settings)?;
        }
        Ok(())
    }

    /// What was requested, for reports; the radius of --ao is in radii of the model, that of --edl in pixels.
    pub fn json(&self) -> Value {
        json!({
            "exposure": self.exposure.unwrap_or(0.0),
            "tone": values::name(&self.tone),
            "ao": self.occlusion().map(|ao| json!({ "strength": self.ao, "radius": ao.radius })),
            "edl": self.eye_dome().map(|edl| json!({ "strength": self.edl, "radius": edl.radius })),
        })
    }

    /// Whether any option is given.
    pub fn are_given(&self) -> bool {
        self.are_applied() || self.changes_light()
    }

    /// Whether light is changed after shading, before the effects.
    pub fn changes_light(&self) -> bool {
        self.exposure.is_some() || !matches!(self.tone, ToneName::None)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_of_two() {
        for step in -150..=150 {
            let exponent = f64::from(step) * 0.1;
            assert!((power_of_two(exponent) / exponent.exp2() - 1.0).abs() < 1e-14, "{exponent}");
        }
        assert_eq!([-15.0, -1.0, 0.0, 3.0].map(power_of_two), [1.0 / 32768.0, 0.5, 1.0, 8.0]);
    }
}
