//! Options of the textures of a model.

use std::path::Path;

use clap::{Args, ValueEnum};
use tercio::mesh::Progress;
use tercio::raster::TextureFilter;
use tercio::scene::{AlphaMode, Scene};
use tercio::{LoadReport, TextureOptions, TextureReport, texture_folders};

use super::values;

/// What the alpha of textures means.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum TextureAlphaName {
    /// What is behind shines through.
    #[default]
    Blend,
    /// What is less opaque than --alpha-cutoff is invisible, everything else opaque.
    Cutout,
    /// Textures are opaque.
    Ignore,
}

/// How textures are sampled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum TextureFilterName {
    /// The nearest texel, as it is.
    Nearest,
    /// Interpolated between texels.
    Bilinear,
    /// Interpolated between texels and mipmaps.
    Trilinear,
    /// The same at up to 16 points along the ellipse that a pixel covers.
    #[default]
    Anisotropic,
}

/// Materials and textures of the model.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Textures")]
pub struct TextureArgs {
    /// Draws materials in their plain colours, without textures and highlights of their own.
    #[arg(long)]
    no_textures: bool,
    /// What the alpha of textures means.
    #[arg(long, value_name = "HOW", value_enum, default_value_t)]
    texture_alpha: TextureAlphaName,
    /// Least alpha that is drawn with --texture-alpha cutout, 0 to 1 [default: 0.5].
    #[arg(long, value_name = "ALPHA", allow_negative_numbers = true, value_parser = values::share)]
    alpha_cutoff: Option<f64>,
    /// How textures are sampled.
    #[arg(long, value_name = "HOW", value_enum, default_value_t)]
    texture_filter: TextureFilterName,
}

/// What textures may take, and what the command line says about highlights.
pub struct TextureLimits<'a> {
    /// Most bytes of textures and their decoding.
    pub memory: Option<u64>,
    /// Receives the progress.
    pub progress: &'a Progress,
    /// Strength of all highlights, if given.
    pub specular: Option<f32>,
    /// Whether nothing is lit.
    pub is_unlit: bool,
}

impl TextureArgs {
    /// How textures are sampled.
    pub fn filter(&self) -> TextureFilter {
        match self.texture_filter {
            TextureFilterName::Nearest => TextureFilter::Nearest,
            TextureFilterName::Bilinear => TextureFilter::Bilinear,
            TextureFilterName::Trilinear => TextureFilter::Trilinear,
            TextureFilterName::Anisotropic => TextureFilter::Anisotropic,
        }
    }

    /// `--alpha-cutoff` without any effect is reported as a mistake.
    pub fn check(&self) -> Result<(), &'static str> {
        if self.alpha_cutoff.is_some() && self.texture_alpha != TextureAlphaName::Cutout {
            return Err("--alpha-cutoff has no effect without --texture-alpha cutout");
        }
        Ok(())
    }

    /// Gives an instance of a scene the materials and textures of its model; `None` if they are not used.
    pub fn load(
        &self,
        (scene, number): (&mut Scene, usize),
        model: &Path,
        report: &LoadReport,
        limits: &TextureLimits,
    ) -> Option<TextureReport> {
        if !scene.instances[number].uses_mesh_colors() {
            return None;
        }
        let alpha_mode = match self.texture_alpha {
            TextureAlphaName::Blend => AlphaMode::Blend,
            TextureAlphaName::Cutout => AlphaMode::Cutout(self.alpha_cutoff.unwrap_or(0.5) as f32),
            TextureAlphaName::Ignore => AlphaMode::Opaque,
        };
        let options = TextureOptions {
            memory_limit: limits.memory,
            progress: Some(limits.progress),
            alpha_mode,
            specular: limits.specular,
            is_unlit: limits.is_unlit,
            is_plain: self.no_textures,
        };
        let report = options.load(scene, number, &texture_folders(model, report));
        (!self.no_textures).then_some(report)
    }
}
