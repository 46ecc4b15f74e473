//! Whole clusters against the view volume, and against the eye.
//!
//! Both tests only ever drop what cannot reach a sample: they carry a margin for everything that rounding and
//! snapping may move.

use tercio_mesh::cluster::Cluster;

use crate::conventions::{GUARD, SUBPIXELS};
use crate::view::{ObjectView, View};

/// Where a cluster lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Placement {
    /// It reaches no sample of the picture.
    Outside,
    /// All of it is inside the near plane and the guard band: no triangle needs clipping.
    Inside,
    /// Triangles must be looked at one by one.
    Crossing,
}

/// The largest value of a row over a box, given as middle and half edges.
fn extremes(row: &[f64; 4], middle: [f64; 3], half: [f64; 3]) -> (f64, f64, f64) {
    let center = ((row[0] * middle[0] + row[1] * middle[1]) + row[2] * middle[2]) + row[3];
    let reach = (row[0].abs() * half[0] + row[1].abs() * half[1]) + row[2].abs() * half[2];
    // What `f32` may have rounded away on the way to these coordinates.
    let magnitude = (0..3).map(|k| row[k].abs() * (middle[k].abs() + half[k])).sum::<f64>() + row[3].abs();
    (center, reach, magnitude * 1e-6)
}

/// Places a cluster by its box.
pub fn place(view: &View, object: &ObjectView, cluster: &Cluster) -> Placement {
    let middle = std::array::from_fn(|k| (f64::from(cluster.min[k]) + f64::from(cluster.max[k])) * 0.5);
    let half = std::array::from_fn(|k| (f64::from(cluster.max[k]) - f64::from(cluster.min[k])) * 0.5);
    let rows = &object.exact;
    // The picture's border with a pixel to spare, in clip space: |x| <= border * w.
    let border = [view.width, view.height].map(|n| (f64::from(n) * 0.5 + 1.0) * f64::from(SUBPIXELS));
    let mut inside = true;
    let mut check = |row: [f64; 4]| {
        let (center, reach, slack) = extremes(&row, middle, half);
        inside &= center - reach > slack;
        center + reach < -slack
    };
    let near = if view.perspective {
        [rows.w[0], rows.w[1], rows.w[2], rows.w[3] - f64::from(object.near)]
    } else {
        [-rows.d[0], -rows.d[1], -rows.d[2], 1.0 - rows.d[3]]
    };
    if check(near) {
        return Placement::Outside;
    }
    let combine =
        |factor: f64, row: &[f64; 4], sign: f64| std::array::from_fn(|k| factor * rows.w[k] + sign * row[k]);
    let mut outside = false;
    for (row, border) in [(&rows.x, border[0]), (&rows.y, border[1])] {
        for sign in [1.0, -1.0] {
            let (center, reach, slack) = extremes(&combine(border, row, sign), middle, half);
            outside |= center + reach < -slack;
            check(combine(f64::from(GUARD) * 0.999, row, sign));
        }
    }
    match (outside, inside) {
        (true, _) => Placement::Outside,
        (_, true) => Placement::Inside,
        _ => Placement::Crossing,
    }
}

/// Snapping must not be able to turn a triangle over: at least this many sub-pixels of height are asked for.
/// Half a sub-pixel is rounded at each corner, which can turn over triangles of less than 5; the rest is room
/// for the rounding of `f32` on the way to the screen.
const SAFE_HEIGHT: f64 = 16.0;

/// True only if every triangle of a cluster shows its back (`back`) or its front (`!back`), and still does after
/// its corners were snapped. The cluster must lie [`Placement::Inside`].
///
/// The normal cone tells the facing in exact geometry, with a margin m: the sine of the angle between the line
/// of sight and each triangle's plane is at least 2/pi * m. On the screen the least height of a triangle is then
/// at least `scale * height * sine * w_min^2 / w_max^3` for a perspective camera (the projected area over the
/// longest projected edge), `scale * height * sine` for an orthographic one.
pub fn shows_one_side(view: &View, object: &ObjectView, cluster: &Cluster, back: bool) -> bool {
    let Some(similarity) = object.similarity else { return false };
    let axis = cluster.cone_axis.map(|a| f64::from(a) / 127.0);
    let cutoff = f64::from(cluster.cone_cutoff) / 127.0;
    let (center, radius) = cluster.sphere();
    let radius = f64::from(radius) * 1.0001;
    let viewer = object.viewer.map(f64::from);
    // Into the scene: from the eye to the middle of the cluster, or along the parallel rays.
    let d: [f64; 3] =
        std::array::from_fn(
            |k| {
                if object.perspective { f64::from(center[k]) - viewer[k] } else { -viewer[k] }
            },
        );
    let dot = |a: [f64; 3], b: [f64; 3]| (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2];
    let (along, length) = (dot(d, axis), dot(d, d).sqrt());
    let along = if back { along } else { -along };
    let reach = if object.perspective { radius } else { 0.0 };
    let margin = (along - reach) / (length + reach) - cutoff - 1e-5;
    if !(margin > 0.0) {
        return false;
    }
    let sine = margin * std::f64::consts::FRAC_2_PI;
    let height = f64::from(cluster.min_height) * similarity * view.scale * sine;
    let on_screen = if object.perspective {
        let [wx, wy, wz, w0] = object.exact.w;
        let w = dot([wx, wy, wz], center.map(f64::from)) + w0;
        let depth = radius * similarity;
        let (nearest, farthest) = (w - depth, w + depth);
        if nearest <= 0.0 {
            return false;
        }
        height * nearest * nearest / (farthest * farthest * farthest)
    } else {
        height
    };
    on_screen > SAFE_HEIGHT
}
