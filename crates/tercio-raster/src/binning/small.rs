//! Small triangles, set up once, 16 at a time, for the back end to draw with few operations each.
//!
//! In a large model nearly all triangles are small. Their edge functions and depth plane fit into 64 bytes, one
//! cache line, as whole numbers relative to the first sample of their box; the numbers are the very same that
//! [`crate::backend::edges::Edges`] and [`crate::backend::visibility::DepthPlane`] find for any triangle.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16};

use super::{PixelRect, ScreenTriangle};
use crate::backend::edges::Edges;
use crate::conventions::{SAMPLE, SUBPIXEL_BITS};
use crate::simd::{LANES, each3, part, splat, splat_i};

/// A triangle of less than [`crate::conventions::SMALL_EXTENT`] sub-pixels across and down.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(64))]
pub struct SmallTriangle {
    /// First column and row of its samples in the picture.
    pub first: [u16; 2],
    /// Last column and row of its samples in the picture.
    pub last: [u16; 2],
    /// Value of the edge functions at the first sample.
    pub c: [i32; 3],
    /// Growth a pixel to the right.
    pub a: [i16; 3],
    /// Growth a pixel downwards.
    pub b: [i16; 3],
    /// The farthest corner, from which depth is reckoned, in sub-pixels from the first sample.
    pub anchor: [i16; 2],
    /// Depth there: the least of the triangle.
    pub base: f32,
    /// The greatest depth of the triangle.
    pub nearest: f32,
    /// Growth of depth a sub-pixel to the right and downwards.
    pub slope: [f32; 2],
    /// As [`ScreenTriangle::slot`].
    pub slot: u32,
}

impl SmallTriangle {
    /// Its edge functions over the whole picture.
    pub fn edges(&self) -> Edges {
        let (x, y) = (i64::from(self.first[0]), i64::from(self.first[1]));
        let c = each3!(K => i64::from(self.c[K]) - i64::from(self.a[K]) * x - i64::from(self.b[K]) * y);
        Edges { a: self.a.map(i32::from), b: self.b.map(i32::from), c }
    }
}

/// 16 triangles on their way into the bins, the farthest corner first as [`ScreenTriangle::new`] has it.
pub struct TriangleLanes {
    x: [[i32; LANES]; 3],
    y: [[i32; LANES]; 3],
    d: [[f32; LANES]; 3],
    /// First and last column, first and last row.
    rect: [[i32; LANES]; 4],
    a: [[i32; LANES]; 3],
    b: [[i32; LANES]; 3],
    c: [[i32; LANES]; 3],
    anchor: [[i32; LANES]; 2],
    slope: [[f32; LANES]; 2],
    nearest: [f32; LANES],
}

/// Coordinates and depths of the corners of 16 triangles, in mesh order.
pub struct Corners<S: Simd> {
    /// Screen coordinates.
    pub x: [i32x16<S>; 3],
    /// Screen coordinates.
    pub y: [i32x16<S>; 3],
    /// Depths.
    pub d: [f32x16<S>; 3],
}

impl TriangleLanes {
    /// Sets 16 triangles up; `area` is twice their signed area, `rect` first and last column and row of their
    /// samples. What concerns small triangles holds nothing of use in the lanes of others.
    #[inline(always)]
    pub fn new<S: Simd>(corners: Corners<S>, area: i32x16<S>, rect: [i32x16<S>; 4]) -> Self {
        let simd = area.simd;
        part(
            simd,
            #[inline(always)]
            || {
                let Corners { x, y, d } = corners;
                let second = d[1].simd_lt(d[0]) & d[1].simd_le(d[2]);
                let third = d[2].simd_lt(d[0]) & d[2].simd_lt(d[1]);
                let x = each3!(K => third.select(x[(K + 2) % 3], second.select(x[(K + 1) % 3], x[K])));
                let y = each3!(K => third.select(y[(K + 2) % 3], second.select(y[(K + 1) % 3], y[K])));
                let d = each3!(K => third.select(d[(K + 2) % 3], second.select(d[(K + 1) % 3], d[K])));

                let zero = splat_i(simd, 0);
                let counter = area.simd_lt(zero);
                let first_x = (rect[0] << SUBPIXEL_BITS) + SAMPLE;
                let first_y = (rect[2] << SUBPIXEL_BITS) + SAMPLE;
                let a = each3!(K => y[K] - y[(K + 1) % 3]);
                let b = each3!(K => x[(K + 1) % 3] - x[K]);
                let a = each3!(K => counter.select(-a[K], a[K]));
                let b = each3!(K => counter.select(-b[K], b[K]));
                let c = each3!(K => {
                    let at_first = a[K] * (first_x - x[K]) + b[K] * (first_y - y[K]);
                    let top_left = a[K].simd_gt(zero) | (a[K].simd_eq(zero) & b[K].simd_gt(zero));
                    top_left.select(at_first, at_first - 1) >> SUBPIXEL_BITS
                });

                let (x1, x2) = ((x[1] - x[0]).to_float::<f32x16<S>>(), (x[2] - x[0]).to_float::<f32x16<S>>());
                let (y1, y2) = ((y[1] - y[0]).to_float::<f32x16<S>>(), (y[2] - y[0]).to_float::<f32x16<S>>());
                let (d1, d2) = (d[1] - d[0], d[2] - d[0]);
                let inverse = splat(simd, 1.0) / area.to_float::<f32x16<S>>();
                let slope_x = (d1 * y2 - d2 * y1) * inverse;
                let slope_y = (d2 * x1 - d1 * x2) * inverse;
                Self {
                    x: each3!(K => x[K].to_array()),
                    y: each3!(K => y[K].to_array()),
                    d: each3!(K => d[K].to_array()),
                    rect: [rect[0].to_array(), rect[1].to_array(), rect[2].to_array(), rect[3].to_array()],
                    a: each3!(K => a[K].to_array()),
                    b: each3!(K => b[K].to_array()),
                    c: each3!(K => c[K].to_array()),
                    anchor: [(x[0] - first_x).to_array(), (y[0] - first_y).to_array()],
                    slope: [slope_x.to_array(), slope_y.to_array()],
                    nearest: d[1].simd_gt(d[2]).select(d[1], d[2]).to_array(),
                }
            },
        )
    }

    /// The samples of a lane.
    #[inline(always)]
    pub fn rect(&self, lane: usize) -> PixelRect {
        let [x0, x1, y0, y1] = &self.rect;
        PixelRect { x0: x0[lane], x1: x1[lane], y0: y0[lane], y1: y1[lane] }
    }

    /// A lane as a triangle of any size.
    #[inline(always)]
    pub fn triangle(&self, lane: usize, slot: u32) -> ScreenTriangle {
        ScreenTriangle {
            x: each3!(K => self.x[K][lane]),
            y: each3!(K => self.y[K][lane]),
            d: each3!(K => self.d[K][lane]),
            slot,
        }
    }

    /// A lane that holds a small triangle.
    #[inline(always)]
    pub fn small(&self, lane: usize, slot: u32) -> SmallTriangle {
        let [x0, x1, y0, y1] = &self.rect;
        SmallTriangle {
            first: [x0[lane] as u16, y0[lane] as u16],
            last: [x1[lane] as u16, y1[lane] as u16],
            c: each3!(K => self.c[K][lane]),
            a: each3!(K => self.a[K][lane] as i16),
            b: each3!(K => self.b[K][lane] as i16),
            anchor: [self.anchor[0][lane] as i16, self.anchor[1][lane] as i16],
            base: self.d[0][lane],
            nearest: self.nearest[lane],
            slope: [self.slope[0][lane], self.slope[1][lane]],
            slot,
        }
    }
}
