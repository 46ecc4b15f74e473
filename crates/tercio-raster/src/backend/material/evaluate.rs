//! What the textures of materials make of them at 16 points.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16, mask32x16};
use tercio_scene::{AlphaMode, Material, TextureMap};

use super::texture::{TexturePoints, sample};
use super::{NO_MATERIAL, Pixels};
use crate::backend::light::Vec3x16;
use crate::context::FrameContext;
use crate::simd::{LANES, each3, splat, splat_i};

/// Materials at 16 points.
pub struct Evaluated<S: Simd> {
    pub albedo: Vec3x16<S>,
    pub alpha: f32x16<S>,
    pub specular: Vec3x16<S>,
    pub shininess_log2: i32x16<S>,
    pub roughness: f32x16<S>,
    pub metallic: f32x16<S>,
    pub emissive: Vec3x16<S>,
    pub occlusion: f32x16<S>,
    /// Lanes with a normal of a texture.
    pub bumped: u32,
    /// These normals, in tangent space.
    pub tangent: Vec3x16<S>,
    /// The scale of the texture coordinates there.
    pub uv_scale: [f32x16<S>; 2],
}

/// Colours of the mesh itself at 16 points, which override the material's. A texture overrides the colours, not their alpha.
pub struct Own<S: Simd> {
    pub color: Vec3x16<S>,
    pub alpha: f32x16<S>,
}

/// The lanes of one material.
#[derive(Clone, Copy)]
struct Lanes<S: Simd> {
    lanes: u32,
    mask: mask32x16<S>,
}

impl<S: Simd> Lanes<S> {
    #[inline(always)]
    fn set(self, to: &mut f32x16<S>, value: f32x16<S>) {
        *to = self.mask.select(value, *to);
    }

    #[inline(always)]
    fn set_color(self, to: &mut Vec3x16<S>, value: Vec3x16<S>) {
        *to = each3!(K => self.mask.select(value[K], to[K]));
    }
}

impl<S: Simd> Evaluated<S> {
    /// Evaluates the materials of all lanes. Without `points` there are no textures.
    #[inline(always)]
    pub fn new(
        simd: S,
        context: &FrameContext,
        instance: usize,
        pixels: &Pixels<S>,
        points: Option<&TexturePoints<S>>,
        own: Option<&Own<S>>,
    ) -> Self {
        let zero = splat(simd, 0.0);
        let mut found = Self {
            albedo: [zero; 3],
            alpha: zero,
            specular: [zero; 3],
            shininess_log2: splat_i(simd, 0),
            roughness: zero,
            metallic: zero,
            emissive: [zero; 3],
            occlusion: zero,
            bumped: 0,
            tangent: [zero; 3],
            uv_scale: [zero; 2],
        };
        let numbers = pixels.corners.material.map(|number| number as i32);
        let numbers = i32x16::load_array(simd, numbers);
        let mut left = 0xffff_u32;
        while left != 0 {
            let number = pixels.corners.material[left.trailing_zeros() as usize % LANES];
            let mask = numbers.simd_eq(splat_i(simd, number as i32));
            let lanes = mask.to_bitmask() as u32 & 0xffff;
            left &= !lanes;
            let surface;
            let material = match context.scene.materials.get(number as usize) {
                Some(material) if number != NO_MATERIAL => material,
                _ => {
                    surface = Material::of_surface(&context.scene.instances[instance].surface);
                    &surface
                }
            };
            found.material(simd, context, material, points, own, Lanes { lanes, mask });
        }
        found
    }

    /// Evaluates one material in some lanes.
    #[inline(always)]
    fn material(
        &mut self,
        simd: S,
        context: &FrameContext,
        material: &Material,
        points: Option<&TexturePoints<S>>,
        own: Option<&Own<S>>,
        some: Lanes<S>,
    ) {
        let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
        let color = |c: [f32; 3]| -> Vec3x16<S> { each3!(K => splat(simd, c[K])) };
        // Samples a texture, if there is one; returns also whether it is opaque.
        let sampled = |map: &Option<TextureMap>| {
            let (Some(map), Some(points)) = (map, points) else { return None };
            let texture = &context.scene.textures[map.texture as usize];
            let found = sample(simd, texture, map, context.settings.texture_filter, points, some.lanes);
            Some((found, texture.is_opaque()))
        };
        let mut alpha = splat(simd, if material.opacity < 1.0 { material.opacity.max(0.0) } else { 1.0 });
        if let Some(own) = own {
            alpha *= own.alpha;
        }
        let base = color(material.base_color);
        let albedo: Vec3x16<S> = match (sampled(&material.base_color_map), own) {
            (Some(([r, g, b, _], true)), _) => each3!(K => base[K] * [r, g, b][K]),
            (Some(([r, g, b, a], false)), _) => {
                alpha *= a;
                let is_nothing = a.simd_eq(zero);
                each3!(K => base[K] * is_nothing.select(zero, [r, g, b][K] / a))
            }
            (None, Some(own)) => own.color,
            (None, None) => base,
        };
        some.set_color(&mut self.albedo, albedo);
        if let Some((found, _)) = sampled(&material.opacity_map) {
            alpha *= found[0];
        }
        let alpha = match material.alpha_mode {
            AlphaMode::Blend => alpha.simd_lt(one).select(alpha, one),
            AlphaMode::Cutout(least) => alpha.simd_ge(splat(simd, least)).select(one, zero),
            AlphaMode::Opaque => one,
        };
        some.set(&mut self.alpha, alpha);
        let shininess = splat_i(simd, material.shininess_log2 as i32);
        self.shininess_log2 = some.mask.select(shininess, self.shininess_log2);
        let tint = |map: &Option<TextureMap>, tint: [f32; 3], to: &mut Vec3x16<S>| {
            let mut value = color(tint);
            if let Some((found, _)) = sampled(map) {
                value = each3!(K => value[K] * found[K]);
            }
            some.set_color(to, value);
        };
        tint(&material.specular_map, material.specular, &mut self.specular);
        tint(&material.emissive_map, material.emissive, &mut self.emissive);
        let share = |map: &Option<TextureMap>, channel: usize, of: f32, to: &mut f32x16<S>| {
            let mut value = splat(simd, of);
            if let Some((found, _)) = sampled(map) {
                value = found[channel] * value;
            }
            some.set(to, value);
        };
        share(&material.roughness_map, 1, material.roughness, &mut self.roughness);
        share(&material.metallic_map, 2, material.metallic, &mut self.metallic);
        share(&material.occlusion_map, 0, 1.0, &mut self.occlusion);
        if let (Some(map), Some((found, _))) = (&material.normal_map, sampled(&material.normal_map)) {
            self.bumped |= some.lanes;
            let scale = [material.normal_scale, material.normal_scale, 1.0];
            some.set_color(&mut self.tangent, each3!(K => (found[K] * 2.0 - one) * scale[K]));
            some.set(&mut self.uv_scale[0], splat(simd, map.scale[0]));
            some.set(&mut self.uv_scale[1], splat(simd, map.scale[1]));
        }
    }
}
