//! Triangles in screen space, 16 at a time.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16};

use crate::conventions::{SMALL_EXTENT, SUBPIXEL_BITS};
use crate::screen::PixelRect;
#[cfg(doc)]
use crate::screen::ScreenTriangle;
use crate::simd::{each3, part, splat_i};

/// 16 triangles in screen space, their corners in the order of the mesh.
#[derive(Clone, Copy)]
pub struct ScreenTriangles<S: Simd> {
    /// Screen coordinates of the corners.
    pub x: [i32x16<S>; 3],
    /// Screen coordinates of the corners.
    pub y: [i32x16<S>; 3],
    /// First and last column of the pixels that have a column of samples in the bounding box.
    pub columns: [i32x16<S>; 2],
    /// First and last row of the pixels that have a row of samples there.
    pub rows: [i32x16<S>; 2],
}

impl<S: Simd> ScreenTriangles<S> {
    /// From the coordinates of the corners; the ranges of pixels are clamped to `rect`. The samples of a pixel are at
    /// least `origin` sub-pixels from its borders.
    #[inline(always)]
    pub fn new(simd: S, [x, y]: [[i32x16<S>; 3]; 2], origin: i32, rect: PixelRect) -> Self {
        part(
            simd,
            #[inline(always)]
            || Self {
                x,
                y,
                columns: pixels(simd, x, origin, [rect.x0, rect.x1]),
                rows: pixels(simd, y, origin, [rect.y0, rect.y1]),
            },
        )
    }

    /// Lanes whose bounding box contains a column and a row of samples.
    #[inline(always)]
    pub fn hits(&self) -> u32 {
        let hits = self.columns[0].simd_le(self.columns[1]) & self.rows[0].simd_le(self.rows[1]);
        hits.to_bitmask() as u32
    }

    /// Lanes of triangles that extend over [`SMALL_EXTENT`] sub-pixels or more, across or down.
    #[inline(always)]
    pub fn large(&self, simd: S) -> u32 {
        part(
            simd,
            #[inline(always)]
            || {
                let limit = splat_i(simd, SMALL_EXTENT);
                let large = extent(self.x).simd_ge(limit) | extent(self.y).simd_ge(limit);
                large.to_bitmask() as u32
            },
        )
    }

    /// Twice the signed area, in square sub-pixels; valid only in lanes that are not [`ScreenTriangles::large`],
    /// because it is computed in 32 bits.
    #[inline(always)]
    pub fn area(&self) -> i32x16<S> {
        let (x, y) = (&self.x, &self.y);
        (x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0])
    }
}

/// Largest difference of three coordinates.
#[inline(always)]
fn extent<S: Simd>(v: [i32x16<S>; 3]) -> i32x16<S> {
    v[0].max(v[1]).max(v[2]) - v[0].min(v[1]).min(v[2])
}

/// First and last pixel with samples between the smallest and the largest of three coordinates, clamped to `range`.
#[inline(always)]
fn pixels<S: Simd>(simd: S, v: [i32x16<S>; 3], origin: i32, range: [i32; 2]) -> [i32x16<S>; 2] {
    let (least, most) = (v[0].min(v[1]).min(v[2]), v[0].max(v[1]).max(v[2]));
    [
        ((least + (origin - 1)) >> SUBPIXEL_BITS).max(splat_i(simd, range[0])),
        ((most - origin) >> SUBPIXEL_BITS).min(splat_i(simd, range[1])),
    ]
}

/// The corners of 16 triangles, rotated so that the anchor comes first, as in [`ScreenTriangle::new`]: the farthest
/// corner, from which depth is interpolated.
#[derive(Clone, Copy)]
pub struct Anchored<S: Simd> {
    /// Screen coordinates.
    pub x: [i32x16<S>; 3],
    /// Screen coordinates.
    pub y: [i32x16<S>; 3],
    /// Depths.
    pub d: [f32x16<S>; 3],
}

impl<S: Simd> Anchored<S> {
    /// Rotates the corners so that the farthest, the first among equals, comes first.
    #[inline(always)]
    pub fn new(simd: S, d: [f32x16<S>; 3], t: &ScreenTriangles<S>) -> Self {
        part(
            simd,
            #[inline(always)]
            || {
                let second = d[1].simd_lt(d[0]) & d[1].simd_le(d[2]);
                let third = d[2].simd_lt(d[0]) & d[2].simd_lt(d[1]);
                Self {
                    x: each3!(K => third.select(t.x[(K + 2) % 3], second.select(t.x[(K + 1) % 3], t.x[K]))),
                    y: each3!(K => third.select(t.y[(K + 2) % 3], second.select(t.y[(K + 1) % 3], t.y[K]))),
                    d: each3!(K => third.select(d[(K + 2) % 3], second.select(d[(K + 1) % 3], d[K]))),
                }
            },
        )
    }
}
