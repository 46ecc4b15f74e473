//! Edge functions and planes of a triangle (section 3.2 of the document), in screen coordinates.

use crate::models;
use crate::models::registry::Model;

/// Equations 3.5 to 3.8: the edge function of the edge from `v0` to `v1` at the point `at`, zero on the edge.
pub fn edge_function(v0: [f64; 2], v1: [f64; 2], at: [f64; 2]) -> f64 {
    let (dx, dy) = (v1[0] - v0[0], v1[1] - v0[1]);
    let (a, b, c) = (-dy, dx, v0[0] * v1[1] - v0[1] * v1[0]);
    a * at[0] + b * at[1] + c
}

/// Equations 3.10 to 3.14: the coefficients of z = A x + B y + C through three points. The document prints
/// C = z0 + A x0 + B y0, with which the plane misses v0: both signs have to be negative.
///
/// # Errors
/// Points in line, through which there is no single plane.
pub fn plane(v0: [f64; 3], v1: [f64; 3], v2: [f64; 3]) -> Result<[f64; 3], String> {
    let [d1, d2] = [v1, v2].map(|v| [v[0] - v0[0], v[1] - v0[1], v[2] - v0[2]]);
    let gamma = d1[0] * d2[1] - d1[1] * d2[0];
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

pub(crate) const MODELS: &[Model] = models! {
    "eldridge.3.5", "eq 3.5 to 3.8", "edge function of v0 to v1 at a point":
        edge_function["v0": [f64; 2], "v1": [f64; 2], "at": [f64; 2]] -> f64;
    "eldridge.3.10", "eq 3.10 to 3.14", "coefficients [A, B, C] of the plane through three points":
        plane["v0": [f64; 3], "v1": [f64; 3], "v2": [f64; 3]] -> Result<[f64; 3], String>;
    "eldridge.3.14", "eq 3.14", "constant of the plane through three points; printed with wrong signs":
        plane_constant["v0": [f64; 3], "v1": [f64; 3], "v2": [f64; 3]] -> Result<f64, String>;
};
