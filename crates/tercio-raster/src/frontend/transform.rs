//! Vertices to the screen, 16 at a time.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16, mask32x16};

use crate::conventions::GUARD;
use crate::simd::{row, splat, splat_i};
use crate::view::ObjectView;

/// 16 projected vertices.
pub struct Projected<S: Simd> {
    /// Screen coordinates.
    pub x: i32x16<S>,
    /// Screen coordinates.
    pub y: i32x16<S>,
    /// Depths.
    pub d: f32x16<S>,
    /// Lanes that lie inside the near plane and the guard band; the others hold nothing of use.
    pub inside: mask32x16<S>,
}

/// [`ObjectView::project`], lane by lane.
#[inline(always)]
pub fn project<S: Simd>(simd: S, view: &ObjectView, p: [f32x16<S>; 3]) -> Projected<S> {
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
    let snap = |v: f32x16<S>, offset: i32| v.round_ties_even().to_int::<i32x16<S>>() + splat_i(simd, offset);
    Projected {
        x: snap(x, view.offset[0]),
        y: snap(y, view.offset[1]),
        d,
        inside: in_front & x.abs().simd_le(guard) & y.abs().simd_le(guard),
    }
}
