//! What the textures of materials make of them at 16 points.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16, mask32x16, u32x16};
use tercio_scene::{AlphaMode, Material, TextureMap};

use super::texture::{Colors, TexturePoints, sample};
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
struct Lanes<'a, S: Simd> {
    simd: S,
    lanes: u32,
    mask: mask32x16<S>,
    context: &'a FrameContext<'a>,
    points: Option<&'a TexturePoints<S>>,
}

// Methods and not closures, which would not be compiled at the kernel's SIMD level.
impl<S: Simd> Lanes<'_, S> {
    #[inline(always)]
    fn set(self, to: &mut f32x16<S>, value: f32x16<S>) {
        *to = self.mask.select(value, *to);
    }

    #[inline(always)]
    fn set_color(self, to: &mut Vec3x16<S>, value: Vec3x16<S>) {
        *to = each3!(K => self.mask.select(value[K], to[K]));
    }

    /// Samples a texture, if there is one; returns also whether it is opaque.
    #[inline(always)]
    fn sampled(self, map: Option<&TextureMap>) -> Option<(Colors<S>, bool)> {
        let (map, points) = (map?, self.points?);
        let texture = &self.context.scene.textures[map.texture as usize];
        let filter = self.context.settings.texture_filter;
        Some((sample(self.simd, texture, map, filter, points, self.lanes), texture.is_opaque()))
    }

    /// Sets a colour that a texture may tint.
    #[inline(always)]
    fn tint(self, map: Option<&TextureMap>, color: [f32; 3], to: &mut Vec3x16<S>) {
        let mut value = each3!(K => splat(self.simd, color[K]));
        if let Some((found, _)) = self.sampled(map) {
            value = each3!(K => value[K] * found[K]);
        }
        self.set_color(to, value);
    }

    /// Sets a number that a channel of a texture may scale.
    #[inline(always)]
    fn scale(self, map: Option<&TextureMap>, channel: usize, value: f32, to: &mut f32x16<S>) {
        let mut value = splat(self.simd, value);
        if let Some((found, _)) = self.sampled(map) {
            value = found[channel] * value;
        }
        self.set(to, value);
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
        let numbers = u32x16::load_array_ref(simd, &pixels.corners.material);
        let mut left = 0xffff_u32;
        while left != 0 {
            let number = pixels.corners.material[left.trailing_zeros() as usize % LANES];
            let mask = numbers.simd_eq(number);
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
            found.material(simd, material, own, Lanes { simd, lanes, mask, context, points });
        }
        found
    }

    /// Evaluates one material in some lanes.
    #[inline(always)]
    fn material(&mut self, simd: S, material: &Material, own: Option<&Own<S>>, of: Lanes<S>) {
        let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
        let mut alpha = splat(simd, if material.opacity < 1.0 { material.opacity.max(0.0) } else { 1.0 });
        if let Some(own) = own {
            alpha *= own.alpha;
        }
        let base = each3!(K => splat(simd, material.base_color[K]));
        let albedo: Vec3x16<S> = match (of.sampled(material.base_color_map.as_ref()), own) {
            (Some(([r, g, b, _], true)), _) => each3!(K => base[K] * [r, g, b][K]),
            (Some(([r, g, b, a], false)), _) => {
                alpha *= a;
                let is_nothing = a.simd_eq(zero);
                each3!(K => base[K] * is_nothing.select(zero, [r, g, b][K] / a))
            }
            (None, Some(own)) => own.color,
            (None, None) => base,
        };
        of.set_color(&mut self.albedo, albedo);
        if let Some((found, _)) = of.sampled(material.opacity_map.as_ref()) {
            alpha *= found[0];
        }
        let alpha = match material.alpha_mode {
            AlphaMode::Blend => alpha.simd_lt(one).select(alpha, one),
            AlphaMode::Cutout(least) => alpha.simd_ge(splat(simd, least)).select(one, zero),
            AlphaMode::Opaque => one,
        };
        of.set(&mut self.alpha, alpha);
        let shininess = splat_i(simd, material.shininess_log2 as i32);
        self.shininess_log2 = of.mask.select(shininess, self.shininess_log2);
        of.tint(material.specular_map.as_ref(), material.specular, &mut self.specular);
        of.tint(material.emissive_map.as_ref(), material.emissive, &mut self.emissive);
        of.scale(material.roughness_map.as_ref(), 1, material.roughness, &mut self.roughness);
        of.scale(material.metallic_map.as_ref(), 2, material.metallic, &mut self.metallic);
        of.scale(material.occlusion_map.as_ref(), 0, 1.0, &mut self.occlusion);
        let map = material.normal_map.as_ref();
        if let (Some(map), Some((found, _))) = (map, of.sampled(map)) {
            self.bumped |= of.lanes;
            let scale = [material.normal_scale, material.normal_scale, 1.0];
            of.set_color(&mut self.tangent, each3!(K => (found[K] * 2.0 - one) * scale[K]));
            of.set(&mut self.uv_scale[0], splat(simd, map.scale[0]));
            of.set(&mut self.uv_scale[1], splat(simd, map.scale[1]));
        }
    }
}
