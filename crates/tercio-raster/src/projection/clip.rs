//! Clips the few triangles that cross the near plane or the guard band.
//!
//! Sutherland-Hodgman clipping, in `f64` on unrounded clip coordinates. A new corner is computed from the two ends of
//! its edge in an order that does not depend on the triangle, so that the two triangles at an edge still meet at the
//! same sub-pixel, and no sample between them is missed or covered twice.

use crate::conventions::GUARD;
use crate::view::{ObjectView, ScreenVertex};

/// A corner in clip space.
#[derive(Clone, Copy, Debug, PartialEq)]
struct ClipVertex {
    x: f64,
    y: f64,
    w: f64,
    /// Depth times w.
    d: f64,
    /// For an input corner that is inside: the screen position that it has in unclipped neighbours, which it keeps.
    kept: Option<ScreenVertex>,
}

/// Number of clipping planes: the near plane and the four sides of the guard band.
const PLANES: usize = 5;
/// A triangle clipped by five planes has at most eight corners.
const MAX_CORNERS: usize = 3 + PLANES;

/// Clips one triangle, given by its positions and by the projected vertices of [`ObjectView::project`]. Emits the rest
/// as triangles of the same winding.
pub fn clip_triangle(
    view: &ObjectView,
    positions: [[f32; 3]; 3],
    projected: [ScreenVertex; 3],
    mut emit: impl FnMut([ScreenVertex; 3]),
) {
    let mut polygon = [ClipVertex { x: 0.0, y: 0.0, w: 1.0, d: 1.0, kept: None }; MAX_CORNERS + 1];
    let mut corners = 3;
    for k in 0..3 {
        polygon[k] = to_clip(view, positions[k]);
        polygon[k].kept = Some(projected[k]).filter(|v| v.inside);
    }
    for plane in 0..PLANES {
        let mut next = polygon;
        let mut count = 0;
        for i in 0..corners {
            let (a, b) = (polygon[i], polygon[(i + 1) % corners]);
            let (da, db) = (distance(view, plane, &a), distance(view, plane, &b));
            if da >= 0.0 {
                next[count] = a;
                count += 1;
            }
            if (da >= 0.0) != (db >= 0.0) {
                next[count] = cut(a, da, b, db);
                count += 1;
            }
        }
        polygon = next;
        corners = count;
        if corners < 3 {
            return;
        }
    }
    let screen = |v: &ClipVertex| v.kept.unwrap_or_else(|| to_screen(view, v));
    let first = screen(&polygon[0]);
    for i in 1..corners - 1 {
        emit([first, screen(&polygon[i]), screen(&polygon[i + 1])]);
    }
}

fn to_clip(view: &ObjectView, p: [f32; 3]) -> ClipVertex {
    let row =
        |r: &[f64; 4]| ((f64::from(p[0]) * r[0] + f64::from(p[1]) * r[1]) + f64::from(p[2]) * r[2]) + r[3];
    let rows = &view.exact;
    ClipVertex { x: row(&rows.x), y: row(&rows.y), w: row(&rows.w), d: row(&rows.d), kept: None }
}

/// Signed distance of a corner from a plane, positive inside; at least 0 for a corner that projection found to be
/// inside, whatever rounding does here.
fn distance(view: &ObjectView, plane: usize, v: &ClipVertex) -> f64 {
    let guard = f64::from(GUARD);
    let distance = match plane {
        0 if view.perspective => v.w - f64::from(view.near),
        0 => 1.0 - v.d,
        1 => guard * v.w - v.x,
        2 => guard * v.w + v.x,
        3 => guard * v.w - v.y,
        _ => guard * v.w + v.y,
    };
    if v.kept.is_some() { distance.max(0.0) } else { distance }
}

/// The intersection of an edge with a plane, the same for both directions of the edge.
fn cut(a: ClipVertex, da: f64, b: ClipVertex, db: f64) -> ClipVertex {
    let key = |v: &ClipVertex| (v.x, v.y, v.w, v.d);
    let (p, dp, q, dq) = if key(&a) <= key(&b) { (a, da, b, db) } else { (b, db, a, da) };
    let t = dp / (dp - dq);
    let mix = |from: f64, to: f64| from + (to - from) * t;
    ClipVertex { x: mix(p.x, q.x), y: mix(p.y, q.y), w: mix(p.w, q.w), d: mix(p.d, q.d), kept: None }
}

fn to_screen(view: &ObjectView, v: &ClipVertex) -> ScreenVertex {
    let guard = f64::from(GUARD);
    let snap = |c: f64| (c / v.w).round_ties_even().clamp(-guard, guard) as i32;
    let d = if view.perspective { f64::from(view.near) / v.w } else { v.d };
    ScreenVertex {
        x: snap(v.x) + view.offset[0],
        y: snap(v.y) + view.offset[1],
        d: d.min(1.0) as f32,
        inside: true,
    }
}

/// Perspective-correct barycentric coordinates of a sample in a triangle that needs clipping, from its unclipped
/// corners (Olano and Greer 1997). Also returns whether the triangle appears clockwise on the screen.
///
/// `sample` is in sub-pixels from the middle of the picture. The coordinates are not negative and add up to 1.
pub fn barycentrics_unclipped(
    view: &ObjectView,
    positions: [[f32; 3]; 3],
    sample: [f64; 2],
) -> ([f32; 3], bool) {
    let (e, sum) = areas(view, positions, sample);
    let l = e.map(|e| (e / sum).max(0.0));
    let total = (l[0] + l[1]) + l[2];
    let l = if total > 0.0 && total.is_finite() { l.map(|l| (l / total) as f32) } else { [1.0, 0.0, 0.0] };
    (l, sum > 0.0)
}

/// The change of [`barycentrics_unclipped`] inside the triangle from a sample to the one next to it, which may be outside.
pub fn barycentric_change(
    view: &ObjectView,
    positions: [[f32; 3]; 3],
    sample: [f64; 2],
    beside: [f64; 2],
) -> [f32; 3] {
    let [here, there] = [sample, beside].map(|at| {
        let (e, sum) = areas(view, positions, at);
        e.map(|e| e / sum)
    });
    let change = [0, 1, 2].map(|k| (there[k] - here[k]) as f32);
    if change.iter().all(|c| c.is_finite()) { change } else { [0.0; 3] }
}

/// Twice the areas between a sample and two corners, in homogeneous coordinates, and their sum.
fn areas(view: &ObjectView, positions: [[f32; 3]; 3], sample: [f64; 2]) -> ([f64; 3], f64) {
    let v = positions.map(|p| to_clip(view, p));
    // Each corner relative to the sample, whose own x and y become 0.
    let s = v.map(|v| [v.x - sample[0] * v.w, v.y - sample[1] * v.w]);
    let cross = |a: [f64; 2], b: [f64; 2]| a[0] * b[1] - a[1] * b[0];
    let e = [cross(s[1], s[2]), cross(s[2], s[0]), cross(s[0], s[1])];
    (e, (e[0] + e[1]) + e[2])
}
