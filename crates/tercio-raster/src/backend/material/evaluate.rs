//! What the textures of materials make of them at 16 points.

use fearless_simd::Simd;
use tercio_scene::{AlphaMode, Material, TextureMap};

use super::texture::{Colors, TexturePoints, sample};
use super::{Lanes, NO_MATERIAL, Pixels};
use crate::context::FrameContext;
use crate::simd::LANES;

/// Materials at 16 points.
#[derive(Default)]
pub struct Evaluated {
    pub albedo: [Lanes; 3],
    pub alpha: Lanes,
    pub specular: [Lanes; 3],
    pub shininess_log2: [u32; LANES],
    pub roughness: Lanes,
    pub metallic: Lanes,
    pub emissive: [Lanes; 3],
    pub occlusion: Lanes,
    /// Lanes with a normal of a texture.
    pub bumped: u32,
    /// These normals, in tangent space.
    pub tangent: [Lanes; 3],
    /// The scale of the texture coordinates there.
    pub uv_scale: [Lanes; 2],
}

/// Colours of the mesh itself at 16 points, which override the material's. A texture overrides the colours, not their alpha.
pub struct Own {
    pub color: [Lanes; 3],
    pub alpha: Lanes,
}

impl Evaluated {
    /// Evaluates the materials of all lanes. Without `points` there are no textures.
    #[inline(always)]
    pub fn evaluate<S: Simd>(
        &mut self,
        simd: S,
        context: &FrameContext,
        instance: usize,
        pixels: &Pixels<S>,
        points: Option<&TexturePoints<S>>,
        own: Option<&Own>,
    ) {
        let mut left = 0xffff_u32;
        while left != 0 {
            let number = pixels.corners.material[left.trailing_zeros() as usize % LANES];
            let mut lanes = 0;
            for lane in 0..LANES {
                lanes |= u32::from(pixels.corners.material[lane] == number) << lane;
            }
            left &= !lanes;
            let surface;
            let material = match context.scene.materials.get(number as usize) {
                Some(material) if number != NO_MATERIAL => material,
                _ => {
                    surface = Material::of_surface(&context.scene.instances[instance].surface);
                    &surface
                }
            };
            self.material(simd, context, material, points, own, lanes);
        }
    }

    /// Evaluates one material in some lanes.
    #[inline(always)]
    fn material<S: Simd>(
        &mut self,
        simd: S,
        context: &FrameContext,
        material: &Material,
        points: Option<&TexturePoints<S>>,
        own: Option<&Own>,
        lanes: u32,
    ) {
        let lanes_of = move || (0..LANES).filter(move |lane| lanes >> lane & 1 == 1);
        let mut colors: Colors = [[0.0; LANES]; 4];
        // Samples a texture; returns whether there is one, and whether it is opaque.
        let sampled = |map: &Option<TextureMap>, colors: &mut Colors| {
            let (Some(map), Some(points)) = (map, points) else { return None };
            let texture = &context.scene.textures[map.texture as usize];
            sample(simd, texture, map, context.settings.texture_filter, points, lanes, colors);
            Some(texture.is_opaque())
        };
        let opacity = if material.opacity < 1.0 { material.opacity.max(0.0) } else { 1.0 };
        match own {
            Some(own) => lanes_of().for_each(|lane| self.alpha[lane] = opacity * own.alpha[lane]),
            None => lanes_of().for_each(|lane| self.alpha[lane] = opacity),
        }
        match (sampled(&material.base_color_map, &mut colors), own) {
            (Some(is_opaque), _) => {
                for lane in lanes_of() {
                    let a = colors[3][lane];
                    let by = if is_opaque { 1.0 } else { a };
                    for k in 0..3 {
                        let c = colors[k][lane];
                        let straight = if by == 0.0 { 0.0 } else { c / by };
                        self.albedo[k][lane] = material.base_color[k] * straight;
                    }
                    self.alpha[lane] = if is_opaque { self.alpha[lane] } else { self.alpha[lane] * a };
                }
            }
            (None, Some(own)) => {
                for lane in lanes_of() {
                    (0..3).for_each(|k| self.albedo[k][lane] = own.color[k][lane]);
                }
            }
            (None, None) => {
                for lane in lanes_of() {
                    (0..3).for_each(|k| self.albedo[k][lane] = material.base_color[k]);
                }
            }
        }
        if sampled(&material.opacity_map, &mut colors).is_some() {
            lanes_of().for_each(|lane| self.alpha[lane] *= colors[0][lane]);
        }
        for lane in lanes_of() {
            let alpha = self.alpha[lane];
            self.alpha[lane] = match material.alpha_mode {
                AlphaMode::Blend => alpha.min(1.0),
                AlphaMode::Cutout(least) => f32::from(u8::from(alpha >= least)),
                AlphaMode::Opaque => 1.0,
            };
            self.shininess_log2[lane] = material.shininess_log2;
        }
        let tint = |map: &Option<TextureMap>, color: [f32; 3], to: &mut [Lanes; 3], colors: &mut Colors| {
            let has_map = sampled(map, colors).is_some();
            for lane in lanes_of() {
                for k in 0..3 {
                    to[k][lane] = if has_map { color[k] * colors[k][lane] } else { color[k] };
                }
            }
        };
        tint(&material.specular_map, material.specular, &mut self.specular, &mut colors);
        tint(&material.emissive_map, material.emissive, &mut self.emissive, &mut colors);
        let share =
            |map: &Option<TextureMap>, channel: usize, of: f32, to: &mut Lanes, colors: &mut Colors| {
                let has_map = sampled(map, colors).is_some();
                for lane in lanes_of() {
                    to[lane] = if has_map { colors[channel][lane] * of } else { of };
                }
            };
        share(&material.roughness_map, 1, material.roughness, &mut self.roughness, &mut colors);
        share(&material.metallic_map, 2, material.metallic, &mut self.metallic, &mut colors);
        share(&material.occlusion_map, 0, 1.0, &mut self.occlusion, &mut colors);
        if let Some(map) = &material.normal_map
            && sampled(&material.normal_map, &mut colors).is_some()
        {
            self.bumped |= lanes;
            let scale = [material.normal_scale, material.normal_scale, 1.0];
            for lane in lanes_of() {
                (0..3).for_each(|k| self.tangent[k][lane] = (colors[k][lane] * 2.0 - 1.0) * scale[k]);
                (0..2).for_each(|k| self.uv_scale[k][lane] = map.scale[k]);
            }
        }
    }
}
