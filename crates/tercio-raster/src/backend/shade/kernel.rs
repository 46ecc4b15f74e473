//! The shading kernel: shades 16 pixels of one instance, given the corners of their triangles, and writes them to a
//! [`Target`].

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16, mask32x16};

use super::features::Features;
use super::target::Target;
use crate::backend::corners::{ColorSource, Corners, Fragments, to_world};
use crate::backend::interpolate::Interpolation;
use crate::backend::light::{Vec3x16, bend, beside, diffuse, normalize, reflect, towards_viewer};
use crate::backend::{data, edges, material, tone};
use crate::context::FrameContext;
use crate::conventions::{SAMPLE, SUBPIXELS};
use crate::projection::relative;
use crate::settings::Shading;
use crate::simd::{LANES, cross, dot, each3, part, row, splat};
use crate::view::ObjectView;

/// The coordinate system of 16 pixels.
#[derive(Clone, Copy)]
pub struct At {
    /// log2 of the distance of two rows of pixels, in places.
    pub stride_bits: u32,
    /// The middle of the tile's first pixel, in the coordinate system of the corners.
    pub first_sample: [i32; 2],
    /// The offset from these coordinates to coordinates relative to the middle of the picture.
    pub from_middle: [i32; 2],
    /// What is known about the normals of all corners.
    pub facing: Facing,
}

/// What is known about the normals interpolated in a cluster, before those of clockwise triangles are negated.
#[derive(Clone, Copy, Debug, Default)]
pub struct Facing {
    /// All are known to point towards the viewer, as the normals of triangles that appear counter-clockwise should.
    pub viewer: bool,
    /// All are known to point away from the viewer, as the normals of triangles that appear clockwise should.
    pub away: bool,
}

impl Facing {
    /// Is it known that no normal of 16 pixels points away from the viewer? `whole` are the areas of their triangles.
    #[inline(always)]
    fn settles<S: Simd>(self, whole: f32x16<S>) -> bool {
        let zero = splat(whole.simd, 0.0);
        // Normals of triangles that appear clockwise are negated, because their areas are negative.
        self.viewer && !whole.simd_lt(zero).any_true() || self.away && !whole.simd_gt(zero).any_true()
    }
}

impl At {
    /// For corners in screen coordinates.
    pub fn in_picture(context: &FrameContext, stride_bits: u32, corner: [i32; 2]) -> Self {
        let first_sample = corner.map(|c| c * SUBPIXELS + SAMPLE);
        let from_middle = context.lights.sight.middle.map(|c| -c);
        Self { stride_bits, first_sample, from_middle, facing: Facing::default() }
    }

    /// Coordinates of the middles of 16 pixels, from their places.
    #[inline(always)]
    pub fn middles<S: Simd>(&self, simd: S, places: &[i32; LANES]) -> [i32x16<S>; 2] {
        let place = i32x16::load_array_ref(simd, places);
        let (x, y) = (place & ((1 << self.stride_bits) - 1), place >> self.stride_bits);
        [x * SUBPIXELS + self.first_sample[0], y * SUBPIXELS + self.first_sample[1]]
    }
}

/// [`shade_inline`], not inlined, so that the kernel is compiled only once per SIMD level and set of features.
#[expect(clippy::too_many_arguments, reason = "a struct would only rename them")]
#[inline(never)]
pub fn shade<S: Simd, F: Features, T: Target>(
    simd: S,
    context: &FrameContext,
    instance: usize,
    features: F,
    fragments: &Fragments,
    at: At,
    corners: &Corners<S>,
    target: &mut T,
) {
    simd.vectorize(
        #[inline(always)]
        || shade_inline(simd, context, instance, features, fragments, at, corners, target),
    );
}

/// The kernel: shades 16 pixels of one instance.
#[expect(clippy::too_many_arguments, reason = "a struct would only rename them")]
#[inline(always)]
pub fn shade_inline<S: Simd, F: Features, T: Target>(
    simd: S,
    context: &FrameContext,
    instance: usize,
    features: F,
    fragments: &Fragments,
    at: At,
    corners: &Corners<S>,
    target: &mut T,
) {
    let surface = &context.scene.instances[instance].surface;
    let (object, lights) = (&context.objects[instance], &context.lights);
    let sample = T::samples(simd, &at, fragments);
    let At { facing, from_middle, .. } = at;
    let at = Interpolation::new(simd, object, sample, corners);
    let zero = [splat(simd, 0.0); 3];

    let plane = features.plane().then(
        #[inline(always)]
        || seen_plane(simd, object, corners.position, at.clockwise),
    );
    let side = Side { plane };
    let normal = match side.plane {
        Some(plane) if features.shading() == Shading::Flat || !features.normals() => plane,
        _ => at.normal(corners.normal),
    };
    let is_settled = !features.plane() && facing.settles((at.area[0] + at.area[1]) + at.area[2]);
    let needs_viewer = features.materials() || features.highlights() || features.near_lights() || !is_settled;
    let to_viewer = if needs_viewer { towards_viewer(simd, lights, sample, from_middle) } else { zero };
    let normal = side.turned(simd, normal);
    let mut normal = normalize(simd, normal, beside(simd, lights));
    if !is_settled {
        normal = bend(simd, normal, to_viewer);
    }

    if features.materials() {
        let colors = features.colors();
        let pixels = material::Pixels { sample, at: &at, corners, colors, normal, to_viewer };
        let (lit, alpha) = material::shade(simd, context, instance, &pixels);
        let lit = if features.tone() { tone::map(simd, &context.settings.tone, &lit) } else { lit };
        let lit = match features.edges() {
            true => edges::over(simd, context, instance, fragments, (sample, from_middle), &at, corners, lit),
            false => lit,
        };
        target.write(simd, context, features, fragments, lit, alpha, normal);
        return;
    }

    let mut alpha = splat(simd, 1.0);
    let albedo: Vec3x16<S> = match features.colors() {
        ColorSource::Base => each3!(C => splat(simd, surface.base_color[C])),
        ColorSource::Vertex | ColorSource::Triangle => {
            if features.alpha() {
                alpha = at.alpha(corners.alpha);
            }
            at.mix(corners.color)
        }
        ColorSource::Data if F::ARE_SPECIAL => {
            // Copies, as for edges.
            let (weight, values) = (at.weight, corners.values());
            data::without_lines(simd, context, instance, &weight, &values)
        }
        ColorSource::Data => {
            let (color, opacity) = data::colors(simd, context, instance, sample, &at, corners);
            alpha = opacity;
            color
        }
    };
    let lit: Vec3x16<S> = match features.shading() {
        Shading::Unlit | Shading::Physical => albedo,
        Shading::Flat | Shading::Phong if !features.highlights() && !features.near_lights() => {
            let light = diffuse(simd, lights, normal);
            each3!(C => albedo[C] * light[C])
        }
        Shading::Flat | Shading::Phong => {
            let mut position = zero;
            if features.near_lights() {
                let relative = each3!(K => relative(simd, object, corners.position[K]));
                position = to_eye(simd, object, at.mix(relative));
            }
            let to_viewer = normalize(simd, to_viewer, beside(simd, lights));
            let light = reflect(simd, features, lights, surface, &normal, &to_viewer, &position);
            each3!(C => albedo[C] * light.diffuse[C] + light.specular[C])
        }
        Shading::Gouraud => {
            let at_corner = each3!(K => {
                let position = to_eye(simd, object, relative(simd, object, corners.position[K]));
                let mut to_viewer = beside(simd, lights);
                if object.perspective {
                    to_viewer = normalize(simd, each3!(A => -position[A]), to_viewer);
                }
                let normal = match side.plane {
                    Some(plane) if !features.normals() => plane,
                    _ => as_seen(simd, corners.normal[K], at.clockwise),
                };
                let normal = normalize(simd, side.turned(simd, normal), beside(simd, lights));
                let normal = bend(simd, normal, to_viewer);
                reflect(simd, features, lights, surface, &normal, &to_viewer, &position)
            });
            let diffuse = at.mix(each3!(K => at_corner[K].diffuse));
            let specular = at.mix(each3!(K => at_corner[K].specular));
            each3!(C => albedo[C] * diffuse[C] + specular[C])
        }
    };
    let lit = if features.tone() { tone::map(simd, &context.settings.tone, &lit) } else { lit };
    let lit = match features.edges() {
        true => edges::over(simd, context, instance, fragments, (sample, from_middle), &at, corners, lit),
        false => lit,
    };
    target.write(simd, context, features, fragments, lit, alpha, normal);
}

/// The geometric normals of 16 triangles in world space, not normalized, on the visible side.
#[inline(always)]
pub fn seen_plane<S: Simd>(
    simd: S,
    object: &ObjectView,
    p: Corners16<S>,
    clockwise: mask32x16<S>,
) -> Vec3x16<S> {
    let edge_1 = each3!(A => (p[1][A] - p[0][A]) * object.edge_scale);
    let edge_2 = each3!(A => (p[2][A] - p[0][A]) * object.edge_scale);
    as_seen(simd, to_world(simd, object, cross(edge_1, edge_2)), clockwise)
}

/// Negates the vectors of triangles that appear clockwise.
#[inline(always)]
fn as_seen<S: Simd>(simd: S, n: Vec3x16<S>, clockwise: mask32x16<S>) -> Vec3x16<S> {
    part(
        simd,
        #[inline(always)]
        || each3!(A => clockwise.select(-n[A], n[A])),
    )
}

/// Vectors of the three corners.
type Corners16<S> = [Vec3x16<S>; 3];

/// From positions relative to the pivot to world axes relative to the eye.
#[inline(always)]
pub fn to_eye<S: Simd>(simd: S, object: &ObjectView, q: Vec3x16<S>) -> Vec3x16<S> {
    let r = &object.eye_from_local;
    each3!(K => row(simd, &[r[K][0], r[K][1], r[K][2], object.eye_from_pivot[K]], q))
}

/// The visible side of the triangles of 16 pixels.
#[derive(Clone, Copy)]
struct Side<S: Simd> {
    /// [`seen_plane`]; `None` if the corners' normals are known to agree with the winding of their triangle.
    plane: Option<Vec3x16<S>>,
}

impl<S: Simd> Side<S> {
    /// Negates normals that are not on the visible side of their triangle.
    #[inline(always)]
    fn turned(&self, simd: S, n: Vec3x16<S>) -> Vec3x16<S> {
        match self.plane {
            Some(plane) => as_seen(simd, n, dot(n, plane).simd_lt(splat(simd, 0.0))),
            None => n,
        }
    }
}
