//! Options of the look of the model and of how it is drawn.

use std::sync::Arc;

use clap::{Args, ValueEnum};
use serde_json::{Value, json};
use tercio::Normals;
use tercio::parallel::{Communicator, ParallelError, parts};
use tercio::raster::{
    Binning, Cull, Outputs, RenderError, Settings, Shading, ShadowArea, ShadowMaps, SimdLevel, Sorting,
};
use tercio::scene::{AlphaMode, Background, Camera, Instance, Light, Scene, Surface};

use super::effects::EffectArgs;
use super::environment::EnvironmentArgs;
use super::light::{self, LightSpec};
use super::sampling::SamplingArgs;
use super::values;
use crate::look;

/// Where lighting is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ShadingName {
    /// Once a triangle: facets are visible.
    Flat,
    /// At the vertices.
    Gouraud,
    /// At every pixel.
    Phong,
    /// At every pixel, physically based: from roughness and metallicity, with a Fresnel term.
    Pbr,
    /// Not at all: plain colours.
    Unlit,
}

/// Which triangles are culled by their facing.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum CullName {
    /// Both sides are drawn; hidden back faces are skipped where the picture stays the same.
    Auto,
    /// Both sides are drawn, nothing is skipped.
    None,
    /// Triangles that show their back are left out.
    Back,
    /// Triangles that show their front are left out.
    Front,
}

impl From<CullName> for Cull {
    fn from(name: CullName) -> Self {
        match name {
            CullName::Auto => Self::Auto,
            CullName::None => Self::None,
            CullName::Back => Self::Back,
            CullName::Front => Self::Front,
        }
    }
}

/// How triangles are sorted into tiles.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum BinningName {
    /// By bounding box.
    Bbox,
    /// Exactly.
    Exact,
}

/// The unit that is sorted into tiles.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum SortingName {
    /// Clusters that are small on the screen as a whole; of larger ones, every triangle.
    Clusters,
    /// Every triangle.
    Triangles,
}

impl From<SortingName> for Sorting {
    fn from(name: SortingName) -> Self {
        match name {
            SortingName::Clusters => Self::Clusters,
            SortingName::Triangles => Self::Triangles,
        }
    }
}

/// The look of the model.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Drawing")]
pub struct DrawingArgs {
    /// Size of the picture in pixels, up to 65536x65536.
    ///
    /// A PNG with more pixels than 8192x8192, without ranks, stereo, --ao, --edl and other outputs, is drawn in bands: little
    /// memory is enough.
    #[arg(short, long, aliases = ["resolution", "window-size"], value_name = "WxH", value_parser = values::size, default_value = "1280x960")]
    pub size: (u32, u32),
    /// Where lighting is computed.
    #[arg(long, value_name = "HOW", value_enum, default_value_t = ShadingName::Phong)]
    shading: ShadingName,
    /// Which triangles to leave out by their facing.
    #[arg(long, value_name = "SIDE", value_enum, default_value_t = CullName::Auto)]
    cull: CullName,
    /// A light, such as head, dir:1,1,0 or ambient:#404040; --help lists all kinds.
    #[arg(long = "light", value_name = "LIGHT", long_help = light::HELP)]
    lights: Vec<LightSpec>,
    /// Colour of a model that has none of its own.
    #[arg(long, value_name = "COLOR", value_parser = values::linear_color)]
    color: Option<[f32; 3]>,
    /// Draws everything in --color, whatever colours, materials and textures the model has.
    #[arg(long)]
    no_mesh_colors: bool,
    /// Opacity of the model, 0 to 1: of its surfaces, lines and points. That of edges on a surface is the alpha of --edge-color.
    ///
    /// What it covers shines through, in linear light and in the right order, however many layers there are. The alpha of the
    /// model's colours and materials is drawn without this option, too, unless --color-by takes their place.
    #[arg(long, value_name = "ALPHA", allow_negative_numbers = true, value_parser = values::opacity)]
    opacity: Option<f64>,
    /// A colour, two colours TOP,BOTTOM for a gradient, or transparent.
    ///
    /// Colours of all options: #c0ffee, white, rgb(255, 128, 0), or red, green and blue from 0 to 1: 0.2,0.2,0.2.
    #[arg(long, aliases = ["bg-color", "background-color"], value_name = "COLOR", value_parser = values::background)]
    background: Option<Background>,
    /// Strength of highlights, 0 for none.
    #[arg(long, value_name = "STRENGTH", allow_negative_numbers = true, value_parser = values::not_negative)]
    specular: Option<f64>,
    /// Roughness of surfaces without one of their own, 0 to 1, for --shading pbr [default: 0.5].
    #[arg(long, value_name = "SHARE", allow_negative_numbers = true, value_parser = values::share)]
    roughness: Option<f64>,
    /// Metallicity of surfaces without one of their own, 0 to 1, for --shading pbr [default: 0].
    #[arg(long, value_name = "SHARE", allow_negative_numbers = true, value_parser = values::share)]
    metallic: Option<f64>,
    /// Draws the shadows of directional, point and spot lights, from shadow maps with this many texels along an edge, 16 to
    /// 16384 [default: 2048]. Without --light, the brightest of the default lights becomes a directional one. What shines
    /// through because of its own alpha casts the shadow of an opaque surface; a model with --opacity below 1 casts none.
    #[arg(long, value_name = "TEXELS", num_args = 0..=1, default_missing_value = "2048", require_equals = true)]
    #[arg(value_parser = clap::value_parser!(u32).range(16..=16384))]
    shadows: Option<u32>,
    /// Edges sharper than this many degrees stay sharp where normals are made; 180 smooths all
    /// [default: 30].
    #[arg(long, value_name = "DEG", allow_negative_numbers = true, value_parser = values::crease_angle)]
    pub crease_angle: Option<f64>,
}

/// Options that change only the speed. The picture is the same.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Tuning (the picture stays the same)")]
pub struct TuningArgs {
    /// SIMD level: sse2, avx2, avx512 or neon; scalar if compiled in [default: the best of this processor].
    #[arg(long, value_name = "LEVEL")]
    simd: Option<SimdLevel>,
    /// Pixels along the edge of a tile: 8, 16, 32, 64 or 128 [default: chosen by the renderer].
    #[arg(long, value_name = "N")]
    tile_size: Option<u32>,
    /// What is sorted into tiles.
    #[arg(long, value_name = "WHAT", value_enum, default_value_t = SortingName::Clusters)]
    sorting: SortingName,
    /// How triangles are sorted into tiles.
    #[arg(long, value_name = "HOW", value_enum, default_value_t = BinningName::Exact)]
    binning: BinningName,
    /// Tests every triangle, not whole clusters first.
    #[arg(long)]
    no_cluster_culling: bool,
}

impl TuningArgs {
    /// Settings of a picture of this size with one sample per pixel, and defaults for everything else.
    pub fn settings(&self, (width, height): (u32, u32)) -> Settings {
        Settings {
            tile_size: self.tile_size,
            sorting: self.sorting.into(),
            binning: match self.binning {
                BinningName::Bbox => Binning::BoundingBox,
                BinningName::Exact => Binning::Exact,
            },
            cluster_culling: !self.no_cluster_culling,
            simd: self.simd,
            ..Settings::one_sample(width, height)
        }
    }
}

impl DrawingArgs {
    /// Settings of the renderer.
    pub fn settings(&self, tuning: &TuningArgs, sampling: &SamplingArgs, outputs: Outputs) -> Settings {
        Settings {
            cull: self.cull(),
            shading: match self.shading {
                ShadingName::Flat => Shading::Flat,
                ShadingName::Gouraud => Shading::Gouraud,
                ShadingName::Phong => Shading::Phong,
                ShadingName::Pbr => Shading::Physical,
                ShadingName::Unlit => Shading::Unlit,
            },
            sampling: sampling.sampling(),
            outputs,
            ..tuning.settings(self.size)
        }
    }

    /// The look of a scene that was dressed, for reports: colours in linear RGB, those of the background in sRGB with
    /// alpha; the size of shadow maps in texels.
    pub fn look(
        &self,
        scene: &Scene,
        background: &Background,
        environment: &EnvironmentArgs,
        effects: &EffectArgs,
    ) -> Value {
        // That of the model; caps follow.
        let surface = scene.instances.first().map(|instance| &instance.surface);
        json!({
            "shading": values::name(&self.shading),
            "cull": values::name(&self.cull),
            "color": surface.map(|s| look::numbers(&s.base_color)),
            "mesh_colors": surface.map(|s| s.use_mesh_colors),
            "opacity": surface.map(|s| look::number(s.opacity)),
            "specular": surface.map(|s| look::number(s.specular)),
            "roughness": surface.map(|s| look::number(s.roughness)),
            "metallic": surface.map(|s| look::number(s.metallic)),
            "lights": scene.lights.iter().map(look::light_json).collect::<Value>(),
            "shadows": self.shadows,
            "background": look::background_json(background),
            "environment": environment.json(),
            "effects": effects.json(),
        })
    }

    /// Which triangles are culled by their facing.
    pub fn cull(&self) -> Cull {
        self.cull.into()
    }

    /// The normals that the picture needs: making normals that are not visible takes time.
    pub fn normals(&self, outputs: Outputs) -> Normals {
        let seen = match self.shading {
            ShadingName::Flat => false,
            ShadingName::Unlit => outputs.normals,
            ShadingName::Gouraud | ShadingName::Phong | ShadingName::Pbr => true,
        };
        match self.crease_angle {
            _ if !seen => Normals::File,
            Some(degrees) => Normals::FileOrMade { crease_angle: Some(degrees.to_radians()) },
            None => Normals::default(),
        }
    }

    /// Is nothing lit?
    pub fn is_unlit(&self) -> bool {
        matches!(self.shading, ShadingName::Unlit)
    }

    /// The colour of the model, if it is given.
    pub fn color(&self) -> Option<[f32; 3]> {
        self.color
    }

    /// Strength of highlights, if it is given.
    pub fn specular(&self) -> Option<f32> {
        self.specular.map(|strength| strength as f32)
    }

    /// Whether shadows are requested.
    pub fn casts_shadows(&self) -> bool {
        self.shadows.is_some()
    }

    /// The shadows of a scene's lights, if they are requested.
    ///
    /// # Errors
    /// [`RenderError`].
    pub fn shadows(
        &self,
        scene: &Scene,
        camera: &Camera,
        settings: &Settings,
        area: ShadowArea,
    ) -> Result<Option<Arc<ShadowMaps>>, RenderError> {
        let draw = |size| ShadowMaps::draw(scene, camera, settings, (size, area)).map(Arc::new);
        self.shadows.map(draw).transpose()
    }

    /// The shadow maps of a scene of which each rank has a part; all ranks have to call this.
    ///
    /// # Errors
    /// As [`DrawingArgs::shadows`], or another rank is gone.
    pub fn shadows_of_parts(
        &self,
        comm: &mut impl Communicator,
        scene: &Scene,
        camera: &Camera,
        settings: &Settings,
        area: ShadowArea,
    ) -> Result<Option<Arc<ShadowMaps>>, ParallelError> {
        let draw = |size| parts::shadow_maps(comm, scene, camera, settings, (size, area)).map(Arc::new);
        self.shadows.map(draw).transpose()
    }

    /// How shadows of instances of a scene differ from those of what is drawn, if they do.
    pub fn shadow_warning(&self, scene: &Scene, instances: &[Instance]) -> Option<String> {
        self.shadows?;
        if instances.iter().any(|i| i.surface.opacity < 1.0) {
            return Some("surfaces with an opacity below 1 cast no shadows".into());
        }
        let is_cut_out = scene.materials.iter().any(|m| matches!(m.alpha_mode, AlphaMode::Cutout(_)));
        let is_too_dark = !is_cut_out && instances.iter().any(Instance::is_translucent);
        is_too_dark.then(|| "what is not opaque casts the shadows of opaque surfaces".into())
    }

    /// Bytes of the shadow maps, at most.
    pub fn shadow_bytes(&self, scene: &Scene) -> u64 {
        self.shadows.map_or(0, |size| ShadowMaps::needed_bytes(&scene.lights, size))
    }

    /// The surface of the model.
    pub fn surface(&self) -> Surface {
        let usual = Surface::default();
        Surface {
            base_color: self.color.unwrap_or(usual.base_color),
            use_mesh_colors: !self.no_mesh_colors,
            opacity: self.opacity.map_or(usual.opacity, |alpha| alpha as f32),
            specular: self.specular().unwrap_or(usual.specular),
            roughness: self.roughness.map_or(usual.roughness, |r| r as f32),
            metallic: self.metallic.map_or(usual.metallic, |m| m as f32),
            ..usual
        }
    }

    /// Sets lights and background of a scene. An environment replaces the default lights.
    pub fn dress(&self, scene: &mut Scene) {
        let sources = scene.environment.as_ref().map(|environment| environment.sources().to_vec());
        if !self.lights.is_empty() {
            scene.lights = self.lights.iter().flat_map(|l| l.0.clone()).collect();
        } else if sources.is_some() {
            scene.lights.clear();
        } else if self.shadows.is_some() {
            scene.lights = Light::sunlit_studio();
        }
        scene.lights.extend(sources.unwrap_or_default());
        scene.background = self.background.unwrap_or(scene.background);
    }

    /// Whether the background is translucent.
    pub fn is_transparent(&self) -> bool {
        match self.background {
            None => false,
            Some(Background::Solid(c)) => c[3] < 1.0,
            Some(Background::Gradient { top, bottom }) => top[3].min(bottom[3]) < 1.0,
        }
    }

    /// Options without any effect are reported as a mistake.
    pub fn check(&self, effects: &EffectArgs, environment: &EnvironmentArgs) -> Result<(), &'static str> {
        if self.shading == ShadingName::Unlit && !self.lights.is_empty() {
            return Err("--light has no effect with --shading unlit");
        }
        if self.shading == ShadingName::Unlit && effects.changes_light() {
            return Err("--exposure and --tone have no effect with --shading unlit");
        }
        if self.shading == ShadingName::Unlit && environment.is_given() {
            return Err("--environment has no effect with --shading unlit");
        }
        if self.shadows.is_some() && environment.is_gradient() && self.lights.is_empty() {
            return Err(
                "a gradient casts no shadows: --shadows needs a light besides, such as --light dir:1,2,1",
            );
        }
        if self.shading == ShadingName::Unlit && self.shadows.is_some() {
            return Err("--shadows has no effect with --shading unlit");
        }
        let casts = |light: &Light| !matches!(light, Light::Ambient { .. } | Light::Wide { .. });
        let lights = || self.lights.iter().flat_map(|spec| &spec.0);
        if self.shadows.is_some() && !self.lights.is_empty() && !lights().any(casts) {
            return Err("--shadows needs a directional, point or spot light, such as --light dir:1,2,1");
        }
        if self.shading == ShadingName::Pbr && self.specular.is_some() {
            return Err("--specular has no effect with --shading pbr, which has --roughness and --metallic");
        }
        if self.shading != ShadingName::Pbr && (self.roughness.is_some() || self.metallic.is_some()) {
            return Err("--roughness and --metallic have no effect without --shading pbr");
        }
        Ok(())
    }
}
