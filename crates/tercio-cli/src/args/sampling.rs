//! Options of anti-aliasing.

use clap::{Args, ValueEnum};
use serde_json::{Value, json};
use tercio::raster::{Filter, SamplePattern, SampleShading, Sampling};

use super::values;

/// How often a triangle is shaded in a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum ShadingName {
    /// Once, at the centre of the samples that it covers.
    Pixel,
    /// At each sample that it covers.
    Sample,
}

/// How samples become pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum FilterName {
    /// The mean of the pixel's own samples.
    Box,
    /// A tent over the pixel and its neighbours: softer.
    Tent,
}

/// Anti-aliasing.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Anti-aliasing")]
pub struct SamplingArgs {
    /// Samples per pixel: 1, 2, 4, 8 or 16, well spread; 2x2 or 4x4 on a grid.
    ///
    /// Colours are averaged in linear light, from 0 to 1; alpha, too, and colours are not multiplied by it. Depths and
    /// ids of a pixel with several samples are those of the nearest sample, normals those that its triangle is shaded
    /// with; with 1 sample, all are those at the centre of the pixel.
    #[arg(long, value_name = "N", allow_hyphen_values = true, default_value_t = SamplePattern::default())]
    aa: SamplePattern,
    /// How often a triangle is shaded in a pixel; changes --output-normals, too.
    #[arg(long, value_name = "HOW", value_enum, default_value_t = ShadingName::Pixel)]
    aa_shading: ShadingName,
    /// How samples become pixels.
    #[arg(long, value_name = "FILTER", value_enum, default_value_t = FilterName::Box)]
    aa_filter: FilterName,
}

impl SamplingArgs {
    /// The requested anti-aliasing.
    pub fn sampling(&self) -> Sampling {
        let shading = match self.aa_shading {
            ShadingName::Pixel => SampleShading::Pixel,
            ShadingName::Sample => SampleShading::Sample,
        };
        let filter = match self.aa_filter {
            FilterName::Box => Filter::Box,
            FilterName::Tent => Filter::Tent,
        };
        Sampling { pattern: self.aa, shading, filter }
    }

    /// The requested anti-aliasing, for reports.
    pub fn json(&self) -> Value {
        json!({
            "samples": self.aa.count(),
            "pattern": self.aa.name(),
            "shading": values::name(&self.aa_shading),
            "filter": values::name(&self.aa_filter),
        })
    }

    /// Options that have no effect with one sample are reported as a mistake.
    pub fn check(&self) -> Result<(), &'static str> {
        if self.aa != SamplePattern::Center {
            return Ok(());
        }
        if self.aa_filter != FilterName::Box {
            return Err("--aa-filter has no effect with one sample per pixel: give --aa 4, for example");
        }
        if self.aa_shading != ShadingName::Pixel {
            return Err("--aa-shading has no effect with one sample per pixel: give --aa 4, for example");
        }
        Ok(())
    }
}
