//! Triangle setup: edge functions and depth planes of 16 small triangles at once.
//!
//! The values are exactly those of [`Edges`](crate::screen::Edges) and [`DepthPlane`](crate::screen::DepthPlane), but
//! relative to the first sample of the triangle's bounding box inside the tile.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16};

use crate::conventions::SUBPIXEL_BITS;
use crate::projection::{Anchored, CornerNumbers, LocalVertices, ScreenTriangles};
use crate::sampling::SampleCells;
use crate::screen::PixelRect;
use crate::simd::{each3, part, splat, splat_i};

/// 16 triangles of less than [`crate::conventions::SMALL_EXTENT`] sub-pixels across and down. Lanes whose bounding box
/// contains no sample are not valid.
pub struct SmallTriangles<S: Simd> {
    /// Column and row of the first pixel in the tile.
    pub first: [i32x16<S>; 2],
    /// Distance to the last column and row, in pixels.
    pub extent: [i32x16<S>; 2],
    /// Value of the edge functions at the first cell of the first pixel: with one sample per pixel, at its sample.
    pub c: [i32x16<S>; 3],
    /// Increments of the edge functions per cell to the right.
    pub a: [i32x16<S>; 3],
    /// Increments of the edge functions per cell downwards.
    pub b: [i32x16<S>; 3],
    /// From the anchor (the farthest corner, from which depth is interpolated) to that cell, in sub-pixels.
    pub from_anchor: [i32x16<S>; 2],
    /// Depth of the anchor, the smallest of the triangle.
    pub base: f32x16<S>,
    /// The largest depth of the triangle.
    pub nearest: f32x16<S>,
    /// Increments of depth per sub-pixel to the right and downwards.
    pub slope: [f32x16<S>; 2],
}

impl<S: Simd> SmallTriangles<S> {
    /// Sets up 16 triangles; only samples inside `rect` count, the part of the tile that is inside the picture.
    #[inline(always)]
    pub fn new(
        simd: S,
        vertices: &LocalVertices,
        corners: &CornerNumbers,
        cells: &SampleCells,
        rect: PixelRect,
    ) -> Self {
        let local = vertices.to_local(rect);
        let t = ScreenTriangles::new(simd, vertices.coordinates(simd, corners), cells.origin, local);
        let Anchored { x, y, d } = Anchored::new(simd, vertices.depths(simd, corners), &t);
        let area = part(
            simd,
            #[inline(always)]
            || t.area(),
        );
        let slope = depth_slope(simd, x, y, d, area);
        let [a, b] = edge_increments(simd, x, y, area);
        part(
            simd,
            #[inline(always)]
            || {
                let first = [t.columns[0], t.rows[0]];
                let sample_x = (first[0] << SUBPIXEL_BITS) + cells.origin;
                let sample_y = (first[1] << SUBPIXEL_BITS) + cells.origin;
                Self {
                    first: [first[0] - local.x0, first[1] - local.y0],
                    extent: [t.columns[1] - first[0], t.rows[1] - first[1]],
                    c: edge_values(simd, x, y, a, b, [sample_x, sample_y], cells.pitch_bits),
                    a,
                    b,
                    from_anchor: [sample_x - x[0], sample_y - y[0]],
                    base: d[0],
                    nearest: d[1].simd_gt(d[2]).select(d[1], d[2]),
                    slope,
                }
            },
        )
    }
}

/// Increments of depth per sub-pixel to the right and downwards, from corners of which the farthest comes first.
#[inline(always)]
fn depth_slope<S: Simd>(
    simd: S,
    x: [i32x16<S>; 3],
    y: [i32x16<S>; 3],
    d: [f32x16<S>; 3],
    area: i32x16<S>,
) -> [f32x16<S>; 2] {
    part(
        simd,
        #[inline(always)]
        || {
            let (x1, x2) = ((x[1] - x[0]).to_float::<f32x16<S>>(), (x[2] - x[0]).to_float::<f32x16<S>>());
            let (y1, y2) = ((y[1] - y[0]).to_float::<f32x16<S>>(), (y[2] - y[0]).to_float::<f32x16<S>>());
            let (d1, d2) = (d[1] - d[0], d[2] - d[0]);
            let inverse = splat(simd, 1.0) / area.to_float::<f32x16<S>>();
            [(d1 * y2 - d2 * y1) * inverse, (d2 * x1 - d1 * x2) * inverse]
        },
    )
}

/// Increments of the edge functions per cell to the right and downwards, with signs such that the inside is positive.
#[inline(always)]
fn edge_increments<S: Simd>(
    simd: S,
    x: [i32x16<S>; 3],
    y: [i32x16<S>; 3],
    area: i32x16<S>,
) -> [[i32x16<S>; 3]; 2] {
    part(
        simd,
        #[inline(always)]
        || {
            let counter = area.simd_lt(splat_i(simd, 0));
            let a = each3!(K => y[K] - y[(K + 1) % 3]);
            let b = each3!(K => x[(K + 1) % 3] - x[K]);
            [each3!(K => counter.select(-a[K], a[K])), each3!(K => counter.select(-b[K], b[K]))]
        },
    )
}

/// Values of the edge functions at a sample: see [`Edges`](crate::screen::Edges).
#[inline(always)]
fn edge_values<S: Simd>(
    simd: S,
    x: [i32x16<S>; 3],
    y: [i32x16<S>; 3],
    a: [i32x16<S>; 3],
    b: [i32x16<S>; 3],
    sample: [i32x16<S>; 2],
    pitch_bits: u32,
) -> [i32x16<S>; 3] {
    part(
        simd,
        #[inline(always)]
        || {
            let zero = splat_i(simd, 0);
            each3!(K => {
                let value = a[K] * (sample[0] - x[K]) + b[K] * (sample[1] - y[K]);
                let top_left = a[K].simd_gt(zero) | (a[K].simd_eq(zero) & b[K].simd_gt(zero));
                top_left.select(value, value - 1) >> pitch_bits
            })
        },
    )
}
