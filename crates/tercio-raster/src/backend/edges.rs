//! Lines along the sides of triangles, drawn where these are shaded.
//!
//! Strips of triangles for all edges of a dense model are several times as many triangles as the model has, and each of them
//! costs what a triangle costs. But where a point of a triangle is shaded, its distances from the three sides are at hand: the
//! areas that interpolate (twice the area between the point and a side is the value of the side's edge function), divided by
//! the lengths of their gradients. They follow from the corners of the triangle alone, so the picture law holds, and nothing
//! is drawn that could be hidden or could flicker. Both triangles at a side draw half of its line; at a silhouette and at a
//! border, there is one half only, unless strips (`tercio::strokes`) complete it. The line of a polygon's side reaches over
//! the diagonals, where these are near: each triangle draws, besides its own, those that begin at its corners, whose edge functions
//! are combinations of its own.
//!
//! A line covers a point's footprint by the share of the footprint's extent across the line that it covers. The footprint is a
//! pixel, or the part of it that the triangle covers: if a side cuts the pixel, the middle of that part, where it is shaded, is
//! half of what is missing away from the middle of the pixel. See [`Footprint`].
//!
//! Beside this, a pass over finished tiles was considered: it would have to find the triangle of each sample, project its
//! corners again and keep colours of samples apart, all of which is known here.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16, mask32x16};
use tercio_mesh::edges::Beyond;
use tercio_scene::SurfaceEdges;

use super::corners::{Corners, Fragments};
use super::interpolate::Interpolation;
use super::light::Vec3x16;
use super::shade::displayable;
use crate::context::FrameContext;
use crate::simd::{LANES, each3, splat, splat_i};
use crate::surface_edges::{Footprint, PIXELS, apex_of};
use crate::view::ObjectView;

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
    let (area, numbers, depths) = (at.area, corners.numbers, (corners.d, corners.beyond));
    blend(simd, context, instance, &fragments.from_middle, &area, &slopes, &numbers, &depths, &light)
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
    numbers: &[u32; LANES],
    depths: &([f32x16<S>; 3], u32),
    light: &Vec3x16<S>,
) -> Vec3x16<S> {
    simd.vectorize(
        #[inline(always)]
        || {
            let Some(edges) = context.scene.instances[instance].edges.as_deref() else { return *light };
            let zero = splat(simd, 0.0);
            let mut bits = [i32::from(SurfaceEdges::ALL); LANES];
            if let Some(sides) = &edges.sides {
                (0..LANES).for_each(|lane| bits[lane] = sides[numbers[lane] as usize].into());
            }
            let sides = i32x16::load_array_ref(simd, &bits);
            let [x, y] = from_middle;
            let x: f32x16<S> = i32x16::load_array_ref(simd, x).to_float();
            let y: f32x16<S> = i32x16::load_array_ref(simd, y).to_float();
            let mut nearest = Nearest { distance: splat(simd, f32::INFINITY), across: zero };
            for k in 0..3 {
                let is_side = !(sides & (1 << k)).simd_eq(splat_i(simd, 0));
                nearest.add([area[k], slopes[0][k], slopes[1][k]], [x, y], is_side);
            }
            let functions = [area, &slopes[0], &slopes[1]];
            match &edges.beyond {
                Beyond::Nothing => {}
                Beyond::Quadrilaterals(all) => {
                    let (mut places, mut apexes) = ([[0.0; LANES]; 2], [0; LANES]);
                    for lane in 0..LANES {
                        let [first, second] = all[numbers[lane] as usize];
                        (places[0][lane], places[1][lane]) = (first, second);
                        apexes[lane] = apex_of(bits[lane] as u8) as i32;
                    }
                    let apexes = i32x16::load_array_ref(simd, &apexes);
                    let is_apex = each3!(K => apexes.simd_eq(splat_i(simd, K as i32)));
                    let scale = scales(simd, &context.objects[instance], depths);
                    for (n, place) in places.iter().enumerate() {
                        let place = f32x16::load_array_ref(simd, place);
                        let (by_apex, by_beside) =
                            (place * after(&is_apex, &scale, 0), after(&is_apex, &scale, 1 + n));
                        let line = each3!(K => {
                            after(&is_apex, functions[K], 0) * by_apex
                                + after(&is_apex, functions[K], 1 + n) * by_beside
                        });
                        nearest.add(line, [x, y], place.simd_gt(zero));
                    }
                }
                Beyond::Polygons(all) => {
                    let mut places = [[[0.0; LANES]; 2]; 3];
                    for lane in 0..LANES {
                        let of_lane = &all[numbers[lane] as usize];
                        for k in 0..3 {
                            (0..2).for_each(|n| places[k][n][lane] = of_lane[k][n]);
                        }
                    }
                    let scale = scales(simd, &context.objects[instance], depths);
                    for k in 0..3 {
                        for n in 0..2 {
                            let place = f32x16::load_array_ref(simd, &places[k][n]);
                            let beside = (k + 1 + n) % 3;
                            let (by_apex, by_beside) = (place * scale[k], scale[beside]);
                            let line =
                                each3!(K => functions[K][k] * by_apex + functions[K][beside] * by_beside);
                            nearest.add(line, [x, y], place.simd_gt(zero));
                        }
                    }
                }
            }
            let Nearest { distance: nearest, across } = nearest;
            let Footprint { size, shrinking, least } = context.footprint;
            let extent = splat(simd, size) - across * shrinking;
            let least = splat(simd, least);
            let extent = extent.simd_gt(least).select(extent, least);
            let width = splat(simd, edges.width);
            let covered = (width * 0.5 - nearest * PIXELS) + extent * 0.5;
            let covered = covered.simd_gt(zero).select(covered, zero);
            let most = width.simd_lt(extent).select(width, extent);
            let cover = covered.simd_lt(most).select(covered, most) / extent * edges.opacity;
            let shown = displayable(simd, *light);
            each3!(C => shown[C] + (splat(simd, edges.color[C]) - shown[C]) * cover)
        },
    )
}

/// The line that is nearest to 16 points: its distance in sub-pixels, and how far the point is from the middle of the pixel across
/// it.
struct Nearest<S: Simd> {
    distance: f32x16<S>,
    across: f32x16<S>,
}

impl<S: Simd> Nearest<S> {
    /// Adds the lines of some lanes, given by the values of their edge functions and the changes of these to the right and downwards.
    #[inline(always)]
    fn add(&mut self, line: Vec3x16<S>, [x, y]: [f32x16<S>; 2], is_line: mask32x16<S>) {
        let ([value, right, down], simd) = (line, x.simd);
        let inverse = splat(simd, 1.0) / (right * right + down * down).sqrt();
        let distance = value.abs() * inverse;
        let is_nearer = is_line & distance.simd_lt(self.distance);
        self.distance = is_nearer.select(distance, self.distance);
        self.across = is_nearer.select((x * right + y * down).abs() * inverse, self.across);
    }
}

/// What makes areas barycentric coordinates in perspective; those of clipped triangles are already.
#[inline(always)]
fn scales<S: Simd>(simd: S, object: &ObjectView, (d, beyond): &([f32x16<S>; 3], u32)) -> Vec3x16<S> {
    let one = splat(simd, 1.0);
    if !object.perspective {
        return [one; 3];
    }
    let beyond = mask32x16::from_bitmask(simd, u64::from(*beyond));
    each3!(K => beyond.select(one, d[K] * object.weight))
}

/// Of the values at corners, those of the corner that comes so many places after the apex.
#[inline(always)]
fn after<S: Simd>(is_apex: &[mask32x16<S>; 3], v: &Vec3x16<S>, places: usize) -> f32x16<S> {
    let beyond_first = is_apex[1].select(v[(1 + places) % 3], v[(2 + places) % 3]);
    is_apex[0].select(v[places % 3], beyond_first)
}
