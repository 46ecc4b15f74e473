//! A quick conservative test that proves nearly all triangles to be good.

/// Triangles that are tested side by side.
const LANES: usize = 16;

/// Appends to `suspects` the indices of the triangles that could be faulty: their cross product may be zero or not
/// finite. Written without closures, which would not be compiled at the SIMD level of the caller.
#[inline(always)]
pub(super) fn find_suspects(positions: &[[f32; 3]], triangles: &[[u32; 3]], suspects: &mut Vec<u32>) {
    // Coordinates: corner, axis, triangle.
    let mut points = [[[0.0f32; LANES]; 3]; 3];
    for (n, triangles) in triangles.chunks(LANES).enumerate() {
        for lane in 0..triangles.len() {
            for k in 0..3 {
                let p = positions[triangles[lane][k] as usize];
                for axis in 0..3 {
                    points[k][axis][lane] = p[axis];
                }
            }
        }
        let good = surely_good(&points);
        for lane in 0..triangles.len() {
            if !good[lane] {
                suspects.push((n * LANES + lane) as u32);
            }
        }
    }
}

#[inline(always)]
fn surely_good([a, b, c]: &[[[f32; LANES]; 3]; 3]) -> [bool; LANES] {
    let mut good = [false; LANES];
    for i in 0..LANES {
        let e = [b[0][i] - a[0][i], b[1][i] - a[1][i], b[2][i] - a[2][i]];
        let f = [c[0][i] - a[0][i], c[1][i] - a[1][i], c[2][i] - a[2][i]];
        // A component of the cross product does not depend on the coordinates along its own axis: these are finite if
        // their product with 0 is 0.
        good[i] = is_clear(e[0] * f[1], e[1] * f[0]) & ((e[2] + f[2] + a[2][i]) * 0.0 == 0.0)
            | is_clear(e[1] * f[2], e[2] * f[1]) & ((e[0] + f[0] + a[0][i]) * 0.0 == 0.0)
            | is_clear(e[2] * f[0], e[0] * f[2]) & ((e[1] + f[1] + a[1][i]) * 0.0 == 0.0);
    }
    good
}

/// Is the difference of two products certainly finite and not zero? The bound is well above the rounding errors of
/// the products and of underflow; the test is false for NaN, and for infinity, where the right side would be infinite
/// too.
#[inline(always)]
fn is_clear(p: f32, q: f32) -> bool {
    (p - q).abs() > 1e-5 * (p.abs() + q.abs()) + 1e-30
}
