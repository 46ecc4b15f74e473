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
