//! The position of a pixel's sample in its triangle, and the side of the triangle that is visible.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16, mask32x16};

use super::corners::Corners;
use super::light::Vec3x16;
use crate::context::FrameContext;
use crate::conventions::SMALL_EXTENT;
use crate::projection::clip::{barycentric_change, barycentrics_unclipped};
use crate::simd::{LANES, each3, part, splat, splat_i};
use crate::view::ObjectView;

/// Interpolation weights of 16 samples in their triangles.
pub struct Interpolation<S: Simd> {
    /// Twice the areas of the triangles between the sample and two corners, in square sub-pixels: none is negative if
    /// the triangle appears counter-clockwise, none is positive if it appears clockwise. Exact except for the final
    /// rounding to `f32`, if all corners are less than [`SMALL_EXTENT`] from the sample.
    pub area: [f32x16<S>; 3],
    /// Perspective-correct barycentric coordinates of the samples: not negative, adding up to 1.
    pub weight: [f32x16<S>; 3],
    /// Lanes whose triangle appears clockwise on the screen.
    pub clockwise: mask32x16<S>,
}

impl<S: Simd> Interpolation<S> {
    /// The weights of 16 samples, whose coordinates have the same origin as those of the corners.
    #[inline(always)]
    pub fn new(simd: S, object: &ObjectView, sample: [i32x16<S>; 2], corners: &Corners<S>) -> Self {
        let area = areas(simd, sample, corners);
        let mut found = part(
            simd,
            #[inline(always)]
            || {
                let mut b = each3!(K => area[K].abs());
                if object.perspective {
                    b = each3!(K => b[K] * (corners.d[K] * object.weight));
                }
                let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
                let sum = (b[0] + b[1]) + b[2];
                let (inverse, has_area) = (one / sum, sum.simd_gt(zero));
                let one_corner = [one, zero, zero];
                let weight = each3!(K => has_area.select(b[K] * inverse, one_corner[K]));
                let clockwise = ((area[0] + area[1]) + area[2]).simd_lt(zero);
                Self { area, weight, clockwise }
            },
        );
        if corners.beyond != 0 {
            found.recompute(simd, object, sample, corners);
        }
        found
    }

    /// Recomputes the lanes whose triangles need clipping, from their unclipped corners. Precondition: `sample` is in
    /// screen coordinates.
    #[cold]
    #[inline(never)]
    fn recompute(&mut self, simd: S, object: &ObjectView, sample: [i32x16<S>; 2], corners: &Corners<S>) {
        let mut clockwise = self.clockwise.to_bitmask();
        for lane in (0..LANES).filter(|lane| corners.beyond >> lane & 1 == 1) {
            let positions = corners.position.map(|corner| corner.map(|axis: f32x16<S>| axis[lane]));
            let at = |k: usize| f64::from(sample[k][lane]) - f64::from(object.offset[k]);
            let (weight, is_clockwise) = barycentrics_unclipped(object, positions, [at(0), at(1)]);
            for k in 0..3 {
                self.weight[k][lane] = weight[k];
                self.area[k][lane] = if is_clockwise { -weight[k] } else { weight[k] };
            }
            clockwise = clockwise & !(1 << lane) | u64::from(is_clockwise) << lane;
        }
        self.clockwise = mask32x16::from_bitmask(simd, clockwise);
    }

    /// The change of something from one shaded point to the next, to the right and downwards, is the sum of these times its
    /// differences between the corners and the point. Exact but for rounding: areas are linear.
    #[inline(always)]
    pub fn gradients(
        &self,
        simd: S,
        context: &FrameContext,
        object: &ObjectView,
        sample: [i32x16<S>; 2],
        corners: &Corners<S>,
    ) -> [Vec3x16<S>; 2] {
        let step = context.shading_distance;
        let mut gradients = part(
            simd,
            #[inline(always)]
            || {
                let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
                let mut scale = [one; 3];
                let mut b = each3!(K => self.area[K].abs());
                if object.perspective {
                    scale = each3!(K => corners.d[K] * object.weight);
                    b = each3!(K => b[K] * scale[K]);
                }
                let sum = (b[0] + b[1]) + b[2];
                let per_sum = sum.simd_gt(zero).select(splat(simd, step) / sum, zero);
                let right = each3!(K => {
                    let by: f32x16<S> = (corners.y[(K + 2) % 3] - corners.y[(K + 1) % 3]).to_float();
                    (by * scale[K]) * per_sum
                });
                let down = each3!(K => {
                    let by: f32x16<S> = (corners.x[(K + 1) % 3] - corners.x[(K + 2) % 3]).to_float();
                    (by * scale[K]) * per_sum
                });
                [right, down]
            },
        );
        if corners.beyond != 0 {
            recompute_gradients(object, sample, corners, f64::from(step), &mut gradients);
        }
        gradients
    }

    /// The change of [`Self::area`] from one sub-pixel to the next, to the right and downwards.
    #[inline(always)]
    pub fn slopes(
        &self,
        simd: S,
        object: &ObjectView,
        sample: [i32x16<S>; 2],
        corners: &Corners<S>,
    ) -> [Vec3x16<S>; 2] {
        let mut slopes = part(
            simd,
            #[inline(always)]
            || {
                let right = each3!(K => (corners.y[(K + 2) % 3] - corners.y[(K + 1) % 3]).to_float());
                let down = each3!(K => (corners.x[(K + 1) % 3] - corners.x[(K + 2) % 3]).to_float());
                [right, down]
            },
        );
        if corners.beyond != 0 {
            recompute_gradients(object, sample, corners, 1.0, &mut slopes);
        }
        slopes
    }

    /// Interpolates a vector between the corners.
    #[inline(always)]
    pub fn mix(&self, v: [Vec3x16<S>; 3]) -> Vec3x16<S> {
        weighted(&self.weight, v)
    }

    /// Interpolates alpha between the corners: exactly theirs if they have the same.
    #[inline(always)]
    pub fn alpha(&self, a: [f32x16<S>; 3]) -> f32x16<S> {
        let ([_, w1, w2], simd) = (self.weight, a[0].simd);
        let mixed = (a[0] + w1 * (a[1] - a[0])) + w2 * (a[2] - a[0]);
        mixed.max(splat(simd, 0.0)).min(splat(simd, 1.0))
    }

    /// The interpolated normal, not normalized, on the visible side of the triangle, from those of [`Corners::normal`].
    #[inline(always)]
    pub fn normal(&self, normals: [Vec3x16<S>; 3]) -> Vec3x16<S> {
        weighted(&self.area, normals)
    }
}

/// `(w0 * v0 + w1 * v1) + w2 * v2`.
#[inline(always)]
pub fn weighted<S: Simd>(w: &[f32x16<S>; 3], v: [Vec3x16<S>; 3]) -> Vec3x16<S> {
    part(
        w[0].simd,
        #[inline(always)]
        || each3!(A => (w[0] * v[0][A] + w[1] * v[1][A]) + w[2] * v[2][A]),
    )
}

/// [`Interpolation::area`].
#[inline(always)]
fn areas<S: Simd>(simd: S, sample: [i32x16<S>; 2], corners: &Corners<S>) -> [f32x16<S>; 3] {
    let near = near_areas(simd, sample, corners.x, corners.y);
    if corners.are_near {
        return near;
    }
    // Corners relative to the sample.
    let x = each3!(K => corners.x[K] - sample[0]);
    let y = each3!(K => corners.y[K] - sample[1]);
    let are_near = are_near(simd, x, y);
    if are_near.all_true() {
        return near;
    }
    let far = far_areas(simd, x, y);
    each3!(K => are_near.select(near[K], far[K]))
}

/// [`Interpolation::area`] of triangles whose corners are less than [`SMALL_EXTENT`] from the sample, so that the areas
/// fit into 32 bits.
#[inline(always)]
pub fn near_areas<S: Simd>(
    simd: S,
    sample: [i32x16<S>; 2],
    x: [i32x16<S>; 3],
    y: [i32x16<S>; 3],
) -> [f32x16<S>; 3] {
    part(
        simd,
        #[inline(always)]
        || {
            let x = each3!(K => x[K] - sample[0]);
            let y = each3!(K => y[K] - sample[1]);
            each3!(K => {
                let (i, j) = ((K + 1) % 3, (K + 2) % 3);
                (y[i] * x[j] - x[i] * y[j]).to_float()
            })
        },
    )
}

/// Lanes whose corners are all less than [`SMALL_EXTENT`] from the sample, across and down.
#[inline(always)]
fn are_near<S: Simd>(simd: S, x: [i32x16<S>; 3], y: [i32x16<S>; 3]) -> mask32x16<S> {
    part(
        simd,
        #[inline(always)]
        || {
            let shifted = each3!(K => (x[K] + SMALL_EXTENT) | (y[K] + SMALL_EXTENT));
            let out_of_range = (shifted[0] | shifted[1] | shifted[2]) & !(2 * SMALL_EXTENT - 1);
            out_of_range.simd_eq(splat_i(simd, 0))
        },
    )
}

/// [`Interpolation::area`] of triangles of any size; areas that rounding gives the wrong sign are set to 0.
#[inline(always)]
fn far_areas<S: Simd>(simd: S, x: [i32x16<S>; 3], y: [i32x16<S>; 3]) -> [f32x16<S>; 3] {
    part(
        simd,
        #[inline(always)]
        || {
            // Whole numbers of at most 2^24, exact in `f32`.
            let x: [f32x16<S>; 3] = each3!(K => x[K].to_float());
            let y: [f32x16<S>; 3] = each3!(K => y[K].to_float());
            let area = each3!(K => {
                let (i, j) = ((K + 1) % 3, (K + 2) % 3);
                y[i] * x[j] - x[i] * y[j]
            });
            let zero = splat(simd, 0.0);
            let clockwise = ((area[0] + area[1]) + area[2]).simd_lt(zero);
            each3!(K => {
                let wrong = (area[K].simd_lt(zero) & !clockwise) | (area[K].simd_gt(zero) & clockwise);
                wrong.select(zero, area[K])
            })
        },
    )
}

/// Recomputes the gradients of lanes whose triangles need clipping, as differences of weights.
#[cold]
#[inline(never)]
fn recompute_gradients<S: Simd>(
    object: &ObjectView,
    sample: [i32x16<S>; 2],
    corners: &Corners<S>,
    step: f64,
    gradients: &mut [Vec3x16<S>; 2],
) {
    for lane in (0..LANES).filter(|lane| corners.beyond >> lane & 1 == 1) {
        let positions = corners.position.map(|corner| corner.map(|axis: f32x16<S>| axis[lane]));
        let at = [0, 1].map(|k| f64::from(sample[k][lane]) - f64::from(object.offset[k]));
        for (k, of_axis) in gradients.iter_mut().enumerate() {
            let mut beside = at;
            beside[k] += step;
            let change = barycentric_change(object, positions, at, beside);
            for (to, change) in of_axis.iter_mut().zip(change) {
                to[lane] = change;
            }
        }
    }
}
