//! Options of the light from all around.

use std::path::PathBuf;
use std::sync::Arc;

use anyhow::{Context, Result};
use clap::Args;
use serde_json::{Value, json};
use tercio::glam::DMat3;
use tercio::mesh::trig::sin_cos;
use tercio::panorama_from_file;
use tercio::scene::camera::CameraBasis;
use tercio::scene::{Environment, Panorama};

use super::values;
use crate::look;
use crate::named_files::NamedFiles;

/// Where the light from all around comes from.
#[derive(Clone, Debug, PartialEq)]
enum Source {
    /// Colours of zenith, horizon and ground.
    Gradient([[f32; 3]; 3]),
    /// A panorama.
    File(PathBuf),
}

/// A soft sky over a darker ground.
const SKY: [[f32; 3]; 3] = [[0.75, 0.95, 1.25], [1.0, 1.0, 1.0], [0.22, 0.20, 0.18]];

/// Light from all around.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Drawing")]
pub struct EnvironmentArgs {
    /// Lights the model from all around, in place of the default lights: gradient, gradient:ZENITH,HORIZON,GROUND with three
    /// colours (or nine numbers), or a panorama file (Radiance HDR, PNG, JPEG, WebP or TIFF; equirectangular, twice as wide as high). Its
    /// middle is what the front view looks at. Suns and other small sources of light in it cast shadows with --shadows. With
    /// --shading pbr, surfaces mirror it, too. It is not shown as the background.
    #[arg(long, value_name = "WHAT", value_parser = source)]
    environment: Option<Source>,
    /// Factor of the environment's light [default: 1].
    #[arg(long, value_name = "FACTOR", allow_negative_numbers = true, value_parser = values::not_negative)]
    #[arg(requires = "environment")]
    environment_strength: Option<f64>,
    /// Turns the environment round the up axis, counter-clockwise seen from above [default: 0].
    #[arg(long, value_name = "DEG", allow_negative_numbers = true, value_parser = values::number)]
    #[arg(requires = "environment")]
    environment_rotation: Option<f64>,
}

fn source(text: &str) -> Result<Source, String> {
    match text.split_once(':').map_or((text, None), |(kind, rest)| (kind, Some(rest))) {
        ("gradient", None) => Ok(Source::Gradient(SKY)),
        ("gradient", Some(colors)) => {
            let words = values::between_commas(colors);
            // Nine words are three colours of three numbers each.
            let of_each = if words.len() == 9 { 3 } else { 1 };
            let colors = words.chunks(of_each).map(|words| values::linear_color(&words.join(",")));
            let colors: Vec<_> = colors.collect::<Result<_, _>>()?;
            let colors =
                colors.try_into().map_err(|_| "expected gradient:ZENITH,HORIZON,GROUND".to_owned())?;
            Ok(Source::Gradient(colors))
        }
        _ if text.is_empty() || text == "-" => Err("expected gradient or the name of a file".into()),
        _ => Ok(Source::File(text.into())),
    }
}

impl EnvironmentArgs {
    /// Whether there is an environment.
    pub fn is_given(&self) -> bool {
        self.environment.is_some()
    }

    /// What was requested, for reports.
    pub fn json(&self) -> Value {
        let source = self.environment.as_ref().map(|source| match source {
            Source::Gradient(colors) => json!({ "gradient": colors.map(|color| look::numbers(&color)) }),
            Source::File(path) => json!({ "file": path.to_string_lossy() }),
        });
        source.map_or(Value::Null, |source| {
            json!({
                "source": source,
                "strength": self.environment_strength.unwrap_or(1.0),
                "rotation": self.environment_rotation.unwrap_or(0.0),
            })
        })
    }

    /// Whether the environment is the same all round, without any small source of light.
    pub fn is_gradient(&self) -> bool {
        matches!(self.environment, Some(Source::Gradient(_)))
    }

    /// Options without any effect are reported as a mistake.
    ///
    /// # Errors
    /// What has no effect.
    pub fn check(&self) -> Result<(), &'static str> {
        if self.is_gradient() && self.environment_rotation.is_some() {
            return Err("--environment-rotation has no effect on a gradient, which is the same all round");
        }
        Ok(())
    }

    /// Adds the panorama to the inputs.
    pub fn named_files(&self, files: NamedFiles) -> NamedFiles {
        match &self.environment {
            Some(Source::File(path)) => files.reads("the environment", path),
            _ => files,
        }
    }

    /// Reads the environment, if there is one.
    ///
    /// # Errors
    /// A file that is no panorama.
    pub fn read(&self, memory_limit: Option<u64>) -> Result<Option<Panorama>> {
        Ok(match &self.environment {
            None => None,
            Some(Source::File(path)) => {
                let read = panorama_from_file(path, memory_limit);
                Some(read.with_context(|| path.display().to_string())?)
            }
            Some(Source::Gradient([zenith, horizon, ground])) => {
                Some(Panorama::gradient(*zenith, *horizon, *ground)?)
            }
        })
    }

    /// Prepares the environment that was read; `front` are the axes of the front view.
    ///
    /// # Errors
    /// Light out of range.
    pub fn place(&self, panorama: &Panorama, front: CameraBasis) -> Result<Arc<Environment>> {
        let name = match &self.environment {
            Some(Source::File(path)) => path.display().to_string(),
            _ => "the gradient".into(),
        };
        let angle = self.environment_rotation.unwrap_or(0.0).rem_euclid(360.0).to_radians();
        let (sine, cosine) = sin_cos(angle);
        let (right, back) = (front.right, -front.forward);
        let axes = DMat3::from_cols(right * cosine - back * sine, front.up, back * cosine + right * sine);
        let strength = self.environment_strength.unwrap_or(1.0);
        Ok(Arc::new(Environment::new(panorama, axes, strength).context(name)?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gradients_and_files() {
        assert_eq!(source("gradient"), Ok(Source::Gradient(SKY)));
        let colors = [[1.0; 3], [0.0; 3], [1.0, 0.0, 0.0]];
        assert_eq!(source("gradient:#fff,#000,#f00"), Ok(Source::Gradient(colors)));
        assert_eq!(source("sky.hdr"), Ok(Source::File("sky.hdr".into())));
        assert_eq!(source("gradient:1,1,1,0,0,0,1,0,0"), Ok(Source::Gradient(colors)));
        assert_eq!(source("gradient:rgb(255, 255, 255),#000,red"), Ok(Source::Gradient(colors)));
        for bad in [
            "",
            "-",
            "gradient:",
            "gradient:#fff",
            "gradient:#fff,#000,#f00,#f00",
            "gradient:1,2,3",
            "gradient:1,1,1,0,0,0,1,0",
            "gradient:1,1,1,0,0,0,1,0,2",
            "gradient:red,red,red,red,red,red,red,red,red",
        ] {
            assert!(source(bad).is_err(), "{bad}");
        }
    }
}
