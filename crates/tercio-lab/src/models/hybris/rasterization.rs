//! Fixed point, spans, edges and planes (section 3.2).

use crate::models;
use crate::models::common::linear;
use crate::models::registry::Model;
use crate::units::Count;

/// A float converted to fixed point with `n` fractional bits by adding 2^(23-n) in single precision, which moves the
/// wanted bits to the end of the mantissa, and masking with 0x007FFFFF (3.2.3). The document prints the mask with nine
/// digits; 0x007FFFFFF would keep four bits of the exponent.
///
/// # Errors
/// More than 23 fractional bits, or a value outside of 0 <= v < 2^(23-n).
pub fn float_to_fixed(v: f64, n: Count) -> Result<f64, String> {
    if n.get() > 23.0 {
        return Err(format!("n: expected at most 23 fractional bits, found {n}"));
    }
    let one = (23.0 - n.get()).exp2();
    if !(0.0..one).contains(&v) {
        return Err(format!("v: expected a number from 0 to below {one}, found {v}"));
    }
    let sum = v as f32 + one as f32;
    Ok(f64::from(sum.to_bits() & 0x007F_FFFF))
}

/// Pixels of a span from the rounded `start` to the rounded `end`: with the last one (first number) and without it
/// (second). The document swaps start and end in both (3.2.6).
///
/// # Errors
/// An end before the start.
pub fn span_pixels(start: Count, end: Count) -> Result<[Count; 2], String> {
    if end.get() < start.get() {
        return Err(format!("end: expected at least {start}, found {end}"));
    }
    Ok([end - start + Count::new(1.0), end - start])
}

/// Equation 3.2: the distance from the edge at `x_left` to the first sample of a span, at the right side of its pixel;
/// `rx_left` is `x_left` rounded down.
pub fn sub_pixel_correction(x_left: f64, rx_left: f64) -> f64 {
    1.0 - (x_left - rx_left)
}

/// Equation 3.1: a parameter at the first pixel of a span, from its value `left` at the edge and `dpdx` per pixel, by
/// [`sub_pixel_correction`].
pub fn span_start(left: f64, dpdx: f64, x_left: f64, rx_left: f64) -> f64 {
    left + sub_pixel_correction(x_left, rx_left) * dpdx
}

/// Equation 3.4: the edge function, positive to the right of the edge from `v0` to `v1`.
pub fn edge_function(v0: [f64; 2], v1: [f64; 2], at: [f64; 2]) -> f64 {
    (at[0] - v0[0]) * (v1[1] - v0[1]) - (at[1] - v0[1]) * (v1[0] - v0[0])
}

/// Equation 3.5: the edge function `steps` pixels to the right and below a point where it is `value`, for the edge
/// from `v0` to `v1`; the document writes the four steps of one pixel.
pub fn edge_step(value: f64, v0: [f64; 2], v1: [f64; 2], steps: [f64; 2]) -> f64 {
    value + steps[0] * (v1[1] - v0[1]) - steps[1] * (v1[0] - v0[0])
}

/// Equation 3.8: the normal [N_x, N_y, N_p] of the plane of a parameter over a triangle of vertices (x, y, p).
pub fn normal(v0: [f64; 3], v1: [f64; 3], v2: [f64; 3]) -> [f64; 3] {
    let (u, w) =
        ([v1[0] - v0[0], v1[1] - v0[1], v1[2] - v0[2]], [v2[0] - v1[0], v2[1] - v1[1], v2[2] - v1[2]]);
    [u[1] * w[2] - u[2] * w[1], u[2] * w[0] - u[0] * w[2], u[0] * w[1] - u[1] * w[0]]
}

/// Equations 3.11 and 3.12: dp/dx and dp/dy of a parameter over a triangle of vertices (x, y, p).
///
/// # Errors
/// A triangle without area.
pub fn gradient(v0: [f64; 3], v1: [f64; 3], v2: [f64; 3]) -> Result<[f64; 2], String> {
    let [x, y, p] = normal(v0, v1, v2);
    if p == 0.0 {
        return Err("the three points lie in line on the screen".into());
    }
    Ok([-x / p, -y / p])
}

/// Equation 3.7: the coefficients [A, B, C] of p = A x + B y + C through three points, solved by Cramer's rule.
///
/// # Errors
/// As [`gradient`].
pub fn coefficients(v0: [f64; 3], v1: [f64; 3], v2: [f64; 3]) -> Result<[f64; 3], String> {
    let minor = |a: [f64; 3], b: [f64; 3]| a[0] * b[1] - a[1] * b[0];
    let minors = [minor(v1, v2), minor(v2, v0), minor(v0, v1)];
    let determinant: f64 = minors.iter().sum();
    if determinant == 0.0 {
        return Err("the three points lie in line on the screen".into());
    }
    let (v, next) = ([v0, v1, v2], |i: usize| (i + 1) % 3);
    let sum = |of: &dyn Fn(usize) -> f64| (0..3).map(of).sum::<f64>() / determinant;
    let opposite = |i: usize| (v[next(i)], v[next(next(i))]);
    let a = sum(&|i| v[i][2] * (opposite(i).0[1] - opposite(i).1[1]));
    let b = sum(&|i| v[i][2] * (opposite(i).1[0] - opposite(i).0[0]));
    Ok([a, b, sum(&|i| v[i][2] * minors[i])])
}

/// Equation 3.9: N . (v - v0), zero where the point (x, y, p) lies in the plane of the triangle.
pub fn plane_distance(v0: [f64; 3], v1: [f64; 3], v2: [f64; 3], at: [f64; 3]) -> f64 {
    let n = normal(v0, v1, v2);
    (0..3).map(|k| n[k] * (at[k] - v0[k])).sum()
}

/// Equation 3.10: the parameter at a point of the screen.
///
/// # Errors
/// As [`gradient`].
pub fn interpolate(v0: [f64; 3], v1: [f64; 3], v2: [f64; 3], at: [f64; 2]) -> Result<f64, String> {
    let [dx, dy] = gradient(v0, v1, v2)?;
    Ok(v0[2] + dx * (at[0] - v0[0]) + dy * (at[1] - v0[1]))
}

pub(crate) const MODELS: &[Model] = models! {
    "hybris.float-to-fixed", "3.2.3", "fixed point with n fractional bits, by adding in single precision":
        float_to_fixed["v": f64, "n": Count = 12.0] -> Result<f64, String>;
    "hybris.span-pixels", "3.2.6", "pixels of a span with its last pixel, and without":
        span_pixels["start": Count, "end": Count] -> Result<[Count; 2], String>;
    "hybris.3.1", "eq 3.1", "parameter at the first pixel of a span":
        span_start["left": f64, "dpdx": f64, "x_left": f64, "rx_left": f64] -> f64;
    "hybris.3.2", "eq 3.2", "k, from the edge to the first sample of a span":
        sub_pixel_correction["x_left": f64, "rx_left": f64] -> f64;
    "hybris.3.3", "eq 3.3, 3.6", "a linear function A x + B y + C at a point":
        linear["coefficients": [f64; 3], "at": [f64; 2]] -> f64;
    "hybris.3.4", "eq 3.4", "edge function of v0 to v1 at a point":
        edge_function["v0": [f64; 2], "v1": [f64; 2], "at": [f64; 2]] -> f64;
    "hybris.3.5", "eq 3.5", "edge function of v0 to v1, steps pixels to the right and below":
        edge_step["value": f64, "v0": [f64; 2], "v1": [f64; 2], "steps": [f64; 2]] -> f64;
    "hybris.3.7", "eq 3.7", "coefficients [A, B, C] of a parameter through three points":
        coefficients["v0": [f64; 3], "v1": [f64; 3], "v2": [f64; 3]] -> Result<[f64; 3], String>;
    "hybris.3.8", "eq 3.8", "normal [N_x, N_y, N_p] of a parameter's plane":
        normal["v0": [f64; 3], "v1": [f64; 3], "v2": [f64; 3]] -> [f64; 3];
    "hybris.3.9", "eq 3.9", "N . (at - v0), zero in the plane of the triangle":
        plane_distance["v0": [f64; 3], "v1": [f64; 3], "v2": [f64; 3], "at": [f64; 3]] -> f64;
    "hybris.3.10", "eq 3.10", "parameter at a point of the screen":
        interpolate["v0": [f64; 3], "v1": [f64; 3], "v2": [f64; 3], "at": [f64; 2]] -> Result<f64, String>;
    "hybris.3.11", "eq 3.11, 3.12", "dp/dx and dp/dy over a triangle":
        gradient["v0": [f64; 3], "v1": [f64; 3], "v2": [f64; 3]] -> Result<[f64; 2], String>;
};

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::models::eldridge::planes;

    proptest! {
        /// Documents 000 (with its signs corrected) and 001 describe the same plane.
        #[test]
        fn the_documents_agree_on_planes(c in prop::array::uniform9(-100i32..100)) {
            let v = [0, 3, 6].map(|i| [0, 1, 2].map(|k| f64::from(c[i + k])));
            let (a, b) = (gradient(v[0], v[1], v[2]), planes::plane(v[0], v[1], v[2]));
            prop_assert_eq!(a.is_ok(), b.is_ok());
            if let (Ok([dx, dy]), Ok([a, b, c])) = (a, b) {
                prop_assert!((dx - a).abs() < 1e-9 && (dy - b).abs() < 1e-9);
                let solved = coefficients(v[0], v[1], v[2]).unwrap();
                prop_assert!([a, b, c].iter().zip(solved).all(|(x, y)| (x - y).abs() < 1e-6));
                for p in v {
                    prop_assert!((linear([a, b, c], [p[0], p[1]]) - p[2]).abs() < 1e-6);
                    prop_assert!((interpolate(v[0], v[1], v[2], [p[0], p[1]]).unwrap() - p[2]).abs() < 1e-6);
                    prop_assert_eq!(plane_distance(v[0], v[1], v[2], p), 0.0);
                }
            }
        }

        /// Stepping gives the same as evaluating; the edge function is that of document 000 with the opposite sign.
        #[test]
        fn edges_step(c in prop::array::uniform4(-100i32..100), p in prop::array::uniform4(-50i32..50)) {
            let [v0, v1] = [0, 2].map(|i| [0, 1].map(|k| f64::from(c[i + k])));
            let [at, steps] = [0, 2].map(|i| [0, 1].map(|k| f64::from(p[i + k])));
            let stepped = edge_step(edge_function(v0, v1, at), v0, v1, steps);
            let there = [at[0] + steps[0], at[1] + steps[1]];
            prop_assert_eq!(stepped, edge_function(v0, v1, there));
            prop_assert_eq!(stepped, -planes::edge_function(v0, v1, there));
        }

        /// Adding in single precision rounds to the nearest fixed-point number.
        #[test]
        fn fixed_point_is_rounding(v in 0.0f64..2000.0) {
            let fixed = float_to_fixed(v, Count::new(12.0)).unwrap();
            // Two roundings, one to single precision and one by the addition: half a step each.
            prop_assert!((fixed / 4096.0 - v).abs() <= 1.0 / 4096.0);
        }
    }

    #[test]
    fn out_of_range_is_refused() {
        assert!(float_to_fixed(2048.0, Count::new(12.0)).is_err());
        assert!(float_to_fixed(-1.0, Count::new(12.0)).is_err());
        assert!(span_pixels(Count::new(4.0), Count::new(3.0)).is_err());
    }
}
