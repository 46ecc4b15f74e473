//! Projects vertices to the screen, 16 at a time, and assembles screen-space triangles from them.

pub mod clip;
mod cluster;
mod corners;
mod local;
mod triangles;

pub(crate) use cluster::ClusterVertices;
pub(crate) use corners::{CornerNumbers, CornerTable, corner_numbers};
pub(crate) use local::LocalVertices;
pub(crate) use triangles::{Anchored, ScreenTriangles};

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16, mask32x16};

use crate::conventions::GUARD;
use crate::simd::{each3, load, part, row, splat};
use crate::view::ObjectView;

/// 16 projected vertices.
pub(crate) struct Projected<S: Simd> {
    /// Screen coordinates.
    pub x: i32x16<S>,
    /// Screen coordinates.
    pub y: i32x16<S>,
    /// Depths.
    pub d: f32x16<S>,
    /// Lanes that are inside the near plane and the guard band; the values of the others are not valid.
    pub inside: mask32x16<S>,
}

/// [`ObjectView::project`], lane by lane.
#[inline(always)]
pub(crate) fn project<S: Simd>(simd: S, view: &ObjectView, p: [f32x16<S>; 3]) -> Projected<S> {
    part(
        simd,
        #[inline(always)]
        || {
            let p = relative(simd, view, p);
            let (cx, cy) = (row(simd, &view.x, p), row(simd, &view.y, p));
            let (x, y, d, in_front) = if view.perspective {
                let w = row(simd, &view.w, p);
                let inverse = splat(simd, 1.0) / w;
                let near = splat(simd, view.near);
                (cx * inverse, cy * inverse, near * inverse, w.simd_ge(near))
            } else {
                let d = row(simd, &view.d, p);
                (cx, cy, d, d.simd_le(splat(simd, 1.0)))
            };
            let guard = splat(simd, GUARD);
            Projected {
                x: snap(x) + view.offset[0],
                y: snap(y) + view.offset[1],
                d,
                inside: in_front & x.abs().simd_le(guard) & y.abs().simd_le(guard),
            }
        },
    )
}

/// [`ObjectView::homogeneous`], lane by lane.
#[inline(always)]
pub(crate) fn homogeneous<S: Simd>(simd: S, view: &ObjectView, p: [f32x16<S>; 3]) -> [f32x16<S>; 3] {
    let p = relative(simd, view, p);
    let w = if view.perspective { row(simd, &view.w, p) } else { splat(simd, 1.0) };
    [row(simd, &view.x, p), row(simd, &view.y, p), w]
}

/// [`ObjectView::relative`], lane by lane.
#[inline(always)]
pub(crate) fn relative<S: Simd>(simd: S, view: &ObjectView, p: [f32x16<S>; 3]) -> [f32x16<S>; 3] {
    each3!(K => p[K] - splat(simd, view.pivot[K]))
}

/// 16 vertices of a cluster, from number `first` on.
#[inline(always)]
fn positions<S: Simd>(simd: S, axes: &[&[f32]; 3], first: usize) -> [f32x16<S>; 3] {
    each3!(K => load(simd, &axes[K][first..]))
}

/// Rounds to whole sub-pixels, ties to even.
#[inline(always)]
fn snap<S: Simd>(v: f32x16<S>) -> i32x16<S> {
    part(
        v.simd,
        #[inline(always)]
        || v.round_ties_even().to_int(),
    )
}
