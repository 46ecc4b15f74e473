//! Surfaces with scene-wide materials, textures and physically based shading: the light that 16 pixels of an instance
//! reflect.

mod evaluate;
mod light;
mod normal;
mod shadow;
mod texture;

use fearless_simd::Simd;
use fearless_simd::{f32x16, i32x16};
use tercio_scene::Instance;

use super::corners::{ColorSource, Corners};
use super::data;
use super::interpolate::Interpolation;
use super::light::{Vec3x16, beside, normalize};
use super::shade::{seen_plane, to_eye};
use crate::context::FrameContext;
use crate::projection::relative;
use crate::settings::Shading;
use crate::simd::{each3, splat};
use crate::view::ObjectView;
use evaluate::{Evaluated, Own};
use shadow::ShadowedPoints;
use texture::TexturePoints;

/// The number of a material for surfaces that have none: the surface's own.
pub const NO_MATERIAL: u32 = u32::MAX;

/// Is an instance shaded by [`shade`]?
pub fn is_used(context: &FrameContext, instance: usize) -> bool {
    context.is_elaborate || has_materials(&context.scene.instances[instance])
}

/// Does an instance use scene-wide materials?
pub fn has_materials(instance: &Instance) -> bool {
    instance.materials.is_some() && instance.uses_mesh_colors()
}

/// What the kernel knows about 16 pixels.
pub struct Pixels<'a, S: Simd> {
    /// The points that are shaded; see [`Interpolation::new`].
    pub sample: [i32x16<S>; 2],
    pub at: &'a Interpolation<S>,
    pub corners: &'a Corners<S>,
    /// Where the colours of the mesh are.
    pub colors: ColorSource,
    /// Unit normals.
    pub normal: Vec3x16<S>,
    /// Not normalized.
    pub to_viewer: Vec3x16<S>,
}

/// The linear light and alpha of 16 pixels of one instance. Not inlined, so that it is compiled only once per SIMD level.
#[inline(never)]
pub fn shade<S: Simd>(
    simd: S,
    context: &FrameContext,
    instance: usize,
    pixels: &Pixels<S>,
) -> (Vec3x16<S>, f32x16<S>) {
    simd.vectorize(
        #[inline(always)]
        || {
            let corners = pixels.corners;
            let object = &context.objects[instance];
            let points = points(simd, context, object, pixels);
            let relative = each3!(K => relative(simd, object, corners.position[K]));
            let from_pivot = pixels.at.mix(relative);
            let position = to_eye(simd, object, from_pivot);
            let shadows = &ShadowedPoints {
                context,
                instance,
                position: from_pivot,
                plane: seen_plane(simd, object, corners.position, pixels.at.clockwise),
            };
            let has_alpha = {
                let instance = &context.scene.instances[instance];
                instance.colors_are_translucent(instance.mesh.is_translucent())
            };
            let own = match pixels.colors {
                ColorSource::Base => None,
                ColorSource::Data => {
                    let (color, alpha) =
                        data::colors(simd, context, instance, pixels.sample, pixels.at, corners);
                    Some(Own { color, alpha })
                }
                _ => Some(Own {
                    color: pixels.at.mix(corners.color),
                    alpha: if has_alpha { pixels.at.alpha(corners.alpha) } else { splat(simd, 1.0) },
                }),
            };
            let evaluated = Evaluated::new(simd, context, instance, pixels, points.as_ref(), own.as_ref());
            let rig = &context.lights;
            let mut normal = pixels.normal;
            if evaluated.bumped != 0 {
                normal = normal::bumped(simd, context, instance, pixels, &evaluated);
            }
            let to_viewer = normalize(simd, pixels.to_viewer, beside(simd, rig));
            let lit = match context.shading_of(instance) {
                Shading::Unlit => evaluated.albedo,
                Shading::Physical => {
                    light::physical(simd, rig, shadows, &evaluated, normal, to_viewer, position)
                }
                Shading::Flat | Shading::Gouraud | Shading::Phong => {
                    light::phong(simd, rig, shadows, &evaluated, normal, to_viewer, position)
                }
            };
            (lit, evaluated.alpha)
        },
    )
}

/// Texture coordinates and their derivatives, if the mesh has any.
#[inline(always)]
fn points<S: Simd>(
    simd: S,
    context: &FrameContext,
    object: &ObjectView,
    pixels: &Pixels<S>,
) -> Option<TexturePoints<S>> {
    let corners = pixels.corners;
    if !corners.has_uv {
        return None;
    }
    let at = pixels.at;
    // Not closures, which would not be compiled at the kernel's SIMD level.
    let uv = [between(corners, &at.weight, 0), between(corners, &at.weight, 1)];
    let [right, down] = at.gradients(simd, context, object, pixels.sample, corners);
    Some(TexturePoints {
        uv,
        right: [change(corners, uv, &right, 0), change(corners, uv, &right, 1)],
        down: [change(corners, uv, &down, 0), change(corners, uv, &down, 1)],
    })
}

/// Interpolates a texture coordinate.
#[inline(always)]
fn between<S: Simd>(corners: &Corners<S>, weight: &Vec3x16<S>, k: usize) -> f32x16<S> {
    let [a, b, c] = [corners.uv[0][k], corners.uv[1][k], corners.uv[2][k]];
    (weight[0] * a + weight[1] * b) + weight[2] * c
}

/// The change of a texture coordinate, from [`Interpolation::gradients`].
#[inline(always)]
fn change<S: Simd>(corners: &Corners<S>, uv: [f32x16<S>; 2], by: &Vec3x16<S>, k: usize) -> f32x16<S> {
    let [a, b, c] = [corners.uv[0][k] - uv[k], corners.uv[1][k] - uv[k], corners.uv[2][k] - uv[k]];
    (by[0] * a + by[1] * b) + by[2] * c
}
