//! Projection from space to the plane, and the orientation of three points there.

/// Twice the signed area of a triangle, positive when counter-clockwise.
#[inline]
pub(super) fn orient(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

pub(super) fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(super) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(super) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Twice the polygon's vector area (Newell), relative to the first corner so that polygons far from zero keep their
/// precision.
pub(super) fn newell_normal(corners: &[[f64; 3]]) -> [f64; 3] {
    let o = corners[0];
    corners.windows(2).skip(1).fold([0.0; 3], |sum, w| {
        let c = cross(sub(w[0], o), sub(w[1], o));
        [sum[0] + c[0], sum[1] + c[1], sum[2] + c[2]]
    })
}

/// The two coordinates to keep, in the order that makes the polygon counter-clockwise.
pub(super) fn projection_axes(corners: &[[f64; 3]], normal: [f64; 3]) -> [usize; 2] {
    let mut weight = normal.map(f64::abs);
    if !weight.iter().any(|&w| w > 0.0) {
        // No area: project along the direction in which the polygon is thinnest.
        weight = std::array::from_fn(|k| {
            let (lo, hi) = corners
                .iter()
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), c| (l.min(c[k]), h.max(c[k])));
            lo - hi
        });
    }
    let drop = (1..3).fold(0, |best, k| if weight[k] > weight[best] { k } else { best });
    let (x, y) = ((drop + 1) % 3, (drop + 2) % 3);
    if normal[drop] < 0.0 { [y, x] } else { [x, y] }
}

pub(super) fn quad([a, b, c, d]: [[f64; 3]; 4]) -> [[usize; 3]; 2] {
    let (ac, bd) = (sub(c, a), sub(d, b));
    let normal = cross(ac, bd);
    let faces_out = |p, q, r| dot(cross(sub(q, p), sub(r, p)), normal) > 0.0;
    let ac_inside = faces_out(a, b, c) && faces_out(a, c, d);
    let bd_inside = faces_out(a, b, d) && faces_out(b, c, d);
    let cut_ac = if ac_inside == bd_inside { dot(ac, ac) <= dot(bd, bd) } else { ac_inside };
    if cut_ac { [[0, 1, 2], [0, 2, 3]] } else { [[0, 1, 3], [1, 2, 3]] }
}
