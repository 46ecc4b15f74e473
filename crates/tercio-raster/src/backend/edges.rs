//! Lines along the sides of triangles, drawn where these are shaded.
//!
//! Strips of triangles for all edges of a dense model are several times as many triangles as the model has, and each of them
//! costs what a triangle costs. But where a point of a triangle is shaded, its distances from the three sides are at hand: the
//! areas that interpolate (twice the area between the point and a side is the value of the side's edge function), divided by
//! the lengths of their gradients. They follow from the corners of the triangle alone, so the picture law holds, and nothing
//! is drawn that could be hidden or could flicker. Both triangles at a side draw half of its line; at a silhouette and at a
//! border, there is one half only, unless strips (`tercio::strokes`) complete it.
//!
//! A line covers a point's footprint by the share of the footprint's extent across the line that it covers. The footprint is a
//! pixel, or the part of it that the triangle covers: if a side cuts the pixel, the middle of that part, where it is shaded, is
//! half of what is missing away from the middle of the pixel. See [`Footprint`].
//!
//! Beside this, a pass over finished tiles was considered: it would have to find the triangle of each sample, project its
//! corners again and keep colours of samples apart, all of which is known here.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16};

use super::corners::{Corners, Fragments};
use super::interpolate::Interpolation;
use super::light::Vec3x16;
use super::shade::displayable;
use crate::context::FrameContext;
use crate::simd::{LANES, each3, splat, splat_i};
use crate::surface_edges::{Footprint, PIXELS};

/// Light with the lines of 16 triangles over it.
#[expect(clippy::too_many_arguments, reason = "a struct would only rename them")]
#[inline(always)]
pub fn over<S: Simd>(
    simd: S,
    context: &FrameContext,
    instance: usize,
    fragments: &Fragments,
    sample: [i32x16<S>; 2],
    at: &Interpolation<S>,
    corners: &Corners<S>,
    light: Vec3x16<S>,
) -> Vec3x16<S> {
    let slopes = at.slopes(simd, &context.objects[instance], sample, corners);
    // Copies, so that the others of the corners, of which no address is taken, stay in registers.
    let (area, sides) = (at.area, corners.sides);
    blend(simd, context, instance, &fragments.from_middle, &area, &slopes, &sides, &light)
}

/// Not inlined, so that it is compiled only once per SIMD level, and kernels of pictures without edges stay small.
#[expect(clippy::too_many_arguments, reason = "a struct would only rename them")]
#[inline(never)]
fn blend<S: Simd>(
    simd: S,
    context: &FrameContext,
    instance: usize,
    from_middle: &[[i32; LANES]; 2],
    area: &[f32x16<S>; 3],
    slopes: &[Vec3x16<S>; 2],
    sides: &[i32; LANES],
    light: &Vec3x16<S>,
) -> Vec3x16<S> {
    simd.vectorize(
        #[inline(always)]
        || {
            let Some(edges) = context.scene.instances[instance].edges.as_deref() else { return *light };
            let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
            let sides = i32x16::load_array_ref(simd, sides);
            let [x, y] = from_middle;
            let x: f32x16<S> = i32x16::load_array_ref(simd, x).to_float();
            let y: f32x16<S> = i32x16::load_array_ref(simd, y).to_float();
            let (mut nearest, mut across) = (splat(simd, f32::INFINITY), zero);
            for k in 0..3 {
                let (right, down) = (slopes[0][k], slopes[1][k]);
                let inverse = one / (right * right + down * down).sqrt();
                let distance = area[k].abs() * inverse;
                let is_side = !(sides & (1 << k)).simd_eq(splat_i(simd, 0));
                let is_nearer = is_side & distance.simd_lt(nearest);
                nearest = is_nearer.select(distance, nearest);
                across = is_nearer.select((x * right + y * down).abs() * inverse, across);
            }
            let Footprint { size, shrinking, least } = context.footprint;
            let extent = splat(simd, size) - across * shrinking;
            let least = splat(simd, least);
            let extent = extent.simd_gt(least).select(extent, least);
            let width = splat(simd, edges.width);
            let covered = (width * 0.5 - nearest * PIXELS) + extent * 0.5;
            let covered = covered.simd_gt(zero).select(covered, zero);
            let most = width.simd_lt(extent).select(width, extent);
            let cover = covered.simd_lt(most).select(covered, most) / extent;
            let shown = displayable(simd, *light);
            each3!(C => shown[C] + (splat(simd, edges.color[C]) - shown[C]) * cover)
        },
    )
}
