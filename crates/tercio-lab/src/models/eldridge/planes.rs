//! Edge functions and planes of a triangle (section 3.2 of the document), in screen coordinates.

use crate::models;
use crate::models::common::linear;
use crate::models::registry::Model;

/// Equations 3.6 to 3.8: the coefficients [A, B, C] of the edge function of the edge from `v0` to `v1`.
pub fn edge_coefficients(v0: [f64; 2], v1: [f64; 2]) -> [f64; 3] {
    let (dx, dy) = (v1[0] - v0[0], v1[1] - v0[1]);
    [-dy, dx, v0[0] * v1[1] - v0[1] * v1[0]]
}

/// Equation 3.5: the edge function of the edge from `v0` to `v1` at the point `at`, zero on the edge, positive to the
/// left of it where y points upwards.
pub fn edge_function(v0: [f64; 2], v1: [f64; 2], at: [f64; 2]) -> f64 {
    linear(edge_coefficients(v0, v1), at)
}

/// Equation 3.11: Gamma, twice the signed area of the triangle on the screen.
pub fn plane_divisor(v0: [f64; 3], v1: [f64; 3], v2: [f64; 3]) -> f64 {
    let [d1, d2] = [v1, v2].map(|v| [v[0] - v0[0], v[1] - v0[1]]);
    d1[0] * d2[1] - d1[1] * d2[0]
}

/// Equations 3.10 to 3.14: the coefficients of z = A x + B y + C through three points. The document prints
/// C = z0 + A x0 + B y0, with which the plane misses v0: both signs have to be negative.
///
/// # Errors
/// Collinear points, through which there is no single plane.
pub fn plane(v0: [f64; 3], v1: [f64; 3], v2: [f64; 3]) -> Result<[f64; 3], String> {
    let [d1, d2] = [v1, v2].map(|v| [v[0] - v0[0], v[1] - v0[1], v[2] - v0[2]]);
    let gamma = plane_divisor(v0, v1, v2);
    if gamma == 0.0 {
        return Err("the three points lie in line on the screen".into());
    }
    let a = (d1[2] * d2[1] - d1[1] * d2[2]) / gamma;
    let b = (d1[0] * d2[2] - d1[2] * d2[0]) / gamma;
    Ok([a, b, v0[2] - a * v0[0] - b * v0[1]])
}

/// Equation 3.14, corrected: the constant C of [`plane`].
///
/// # Errors
/// As [`plane`].
pub fn plane_constant(v0: [f64; 3], v1: [f64; 3], v2: [f64; 3]) -> Result<f64, String> {
    plane(v0, v1, v2).map(|[_, _, c]| c)
}

/// Equation 3.14 as it is printed, with both signs positive.
///
/// # Errors
/// As [`plane`].
pub fn plane_constant_as_printed(v0: [f64; 3], v1: [f64; 3], v2: [f64; 3]) -> Result<f64, String> {
    plane(v0, v1, v2).map(|[a, b, _]| v0[2] + a * v0[0] + b * v0[1])
}

/// The constant C' = C + A s_x of a linear equation on the processor of column `column`, which only steps in y (7.5.1).
pub fn column_constant(coefficients: [f64; 3], column: f64) -> f64 {
    linear(coefficients, [column, 0.0])
}

pub(crate) const MODELS: &[Model] = models! {
    "eldridge.3.6", "eq 3.6 to 3.8", "coefficients [A, B, C] of the edge function of v0 to v1":
        edge_coefficients["v0": [f64; 2], "v1": [f64; 2]] -> [f64; 3];
    "eldridge.3.5", "eq 3.5", "edge function of v0 to v1 at a point":
        edge_function["v0": [f64; 2], "v1": [f64; 2], "at": [f64; 2]] -> f64;
    "eldridge.3.10", "eq 3.10 to 3.14", "coefficients [A, B, C] of the plane through three points":
        plane["v0": [f64; 3], "v1": [f64; 3], "v2": [f64; 3]] -> Result<[f64; 3], String>;
    "eldridge.3.11", "eq 3.11", "Gamma, twice the signed area of a triangle on the screen":
        plane_divisor["v0": [f64; 3], "v1": [f64; 3], "v2": [f64; 3]] -> f64;
    "eldridge.3.14", "eq 3.14", "constant of the plane through three points; printed with wrong signs":
        plane_constant["v0": [f64; 3], "v1": [f64; 3], "v2": [f64; 3]] -> Result<f64, String>;
    "eldridge.3.14-as-printed", "eq 3.14", "the same as printed, with both signs positive: the plane misses v0":
        plane_constant_as_printed["v0": [f64; 3], "v1": [f64; 3], "v2": [f64; 3]] -> Result<f64, String>;
    "eldridge.column-constant", "7.5.1", "constant C' of a linear equation on the processor of a column":
        column_constant["coefficients": [f64; 3], "column": f64] -> f64;
};

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        /// The plane goes through its points, in every column as on the whole screen; with the printed signs it does
        /// not, unless the first vertex happens to have no weight.
        #[test]
        fn the_plane_goes_through_its_points(c in prop::array::uniform9(-50i32..50)) {
            let v = [0, 3, 6].map(|i| [0, 1, 2].map(|k| f64::from(c[i + k])));
            let Ok(found) = plane(v[0], v[1], v[2]) else { return Ok(()) };
            for p in v {
                prop_assert!((linear(found, [p[0], p[1]]) - p[2]).abs() < 1e-6);
                let in_column = [0.0, found[1], column_constant(found, p[0])];
                prop_assert!((linear(in_column, [0.0, p[1]]) - p[2]).abs() < 1e-6);
            }
            let printed = plane_constant_as_printed(v[0], v[1], v[2]).unwrap();
            let missed = linear([found[0], found[1], printed], [v[0][0], v[0][1]]) - v[0][2];
            let weight = found[0] * v[0][0] + found[1] * v[0][1];
            prop_assert!((missed - 2.0 * weight).abs() < 1e-6);
        }
    }
}
