//! Where in its triangle a pixel lies, and which side of it the pixel shows.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16, mask32x16};

use super::corners::Corners;
use super::light::Vec3x16;
use crate::frontend::clip::barycentrics_unclipped;
use crate::simd::{LANES, each3, part, splat};
use crate::view::ObjectView;

/// 16 pixels in their triangles.
pub struct Barycentric<S: Simd> {
    /// Perspective barycentric coordinates of the samples: not negative, adding up to 1.
    pub weight: [f32x16<S>; 3],
    /// The triangle appears clockwise on the screen.
    pub clockwise: mask32x16<S>,
}

impl<S: Simd> Barycentric<S> {
    /// Of 16 samples; their coordinates are counted from where those of the corners are.
    #[inline(always)]
    pub fn new(simd: S, object: &ObjectView, sample: [i32x16<S>; 2], corners: &Corners<S>) -> Self {
        let mut found = part(
            simd,
            #[inline(always)]
            || {
                let zero = splat(simd, 0.0);
                // Corners as seen from the sample: whole numbers of at most 2^24, exact in `f32`.
                let x: [f32x16<S>; 3] = each3!(K => (corners.x[K] - sample[0]).to_float());
                let y: [f32x16<S>; 3] = each3!(K => (corners.y[K] - sample[1]).to_float());
                let mut b = each3!(K => {
                    let (i, j) = ((K + 1) % 3, (K + 2) % 3);
                    x[i] * y[j] - y[i] * x[j]
                });
                if object.perspective {
                    b = each3!(K => b[K] * corners.d[K]);
                }
                let area = (b[0] + b[1]) + b[2];
                let negative = area.simd_lt(zero);
                let b = each3!(K => negative.select(-b[K], b[K]));
                let b = each3!(K => b[K].simd_gt(zero).select(b[K], zero));
                let sum = (b[0] + b[1]) + b[2];
                let good = sum.simd_gt(zero);
                let inverse = splat(simd, 1.0) / sum;
                let one_corner = [splat(simd, 1.0), zero, zero];
                let weight = each3!(K => good.select(b[K] * inverse, one_corner[K]));
                Self { weight, clockwise: area.simd_gt(zero) }
            },
        );
        if corners.beyond != 0 {
            found.recompute(simd, object, sample, corners);
        }
        found
    }

    /// From unclipped corners, where one of them is not on the screen. Samples are counted from the picture's
    /// corner then.
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
            }
            clockwise = clockwise & !(1 << lane) | u64::from(is_clockwise) << lane;
        }
        self.clockwise = mask32x16::from_bitmask(simd, clockwise);
    }

    /// Interpolates a vector between the corners.
    #[inline(always)]
    pub fn mix(&self, v: [Vec3x16<S>; 3]) -> Vec3x16<S> {
        let w = &self.weight;
        part(
            w[0].simd,
            #[inline(always)]
            || each3!(A => (w[0] * v[0][A] + w[1] * v[1][A]) + w[2] * v[2][A]),
        )
    }
}
