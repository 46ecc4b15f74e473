//! Vertices on their way to the screen, and textures on their way back (sections 3.1.1 and 7.5.2).

use crate::models;
use crate::models::common::linear;
use crate::models::registry::Model;

/// Equation 3.1: a point transformed by the rows a b c t_x, d e f t_y, g h i t_z; the fourth row of the document's
/// matrix is 0 0 0 1.
pub fn transform(matrix: [[f64; 4]; 3], v: [f64; 3]) -> [f64; 3] {
    matrix.map(|[a, b, c, t]| a * v[0] + b * v[1] + c * v[2] + t)
}

/// Equations 3.2 and 3.3: the projection of a point in eye coordinates onto a screen at the distance `d`, with the eye
/// at the origin and looking along z.
///
/// # Errors
/// A point that is not in front of the eye: such polygons are clipped before.
pub fn project(d: f64, v: [f64; 3]) -> Result<[f64; 2], String> {
    if v[2] > 0.0 {
        Ok([d * v[0] / v[2], d * v[1] / v[2]])
    } else {
        Err(format!("v: expected a point in front of the eye, z' above zero, found {}", v[2]))
    }
}

/// Equation 3.4 and the sentence after it: a normal (n_x, n_y, n_z, 0) transformed by the inverse transpose of the
/// matrix of [`transform`]. Its length changes if the matrix scales.
///
/// # Errors
/// A singular matrix.
pub fn transform_normal(matrix: [[f64; 4]; 3], n: [f64; 3]) -> Result<[f64; 3], String> {
    let [r0, r1, r2] = matrix.map(|[a, b, c, _]| [a, b, c]);
    // The inverse transpose is the matrix of cofactors over the determinant.
    let cofactors = [cross(r1, r2), cross(r2, r0), cross(r0, r1)];
    let determinant = dot(r0, cofactors[0]);
    if determinant == 0.0 {
        return Err("M: expected a matrix with an inverse, found one that flattens space".into());
    }
    Ok(cofactors.map(|row| dot(row, n) / determinant))
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Equations 7.3 and 7.4: a texture coordinate where the depth is `z`, at a point of the screen at distance 1. The
/// coefficients are those of u/z, which is linear on the screen. The document reuses the letters of equation 7.1, but x
/// = z s_x in 7.1 leaves the constant without the factor z, so they are not the same numbers.
pub fn texture(coefficients: [f64; 3], z: f64, at: [f64; 2]) -> f64 {
    z * linear(coefficients, at)
}

/// Equations 7.5 and 7.6: a texture coordinate from u/z and 1/z, both linear on the screen.
///
/// # Errors
/// 1/z of zero: a point infinitely far away.
pub fn texture_by_inverse_depth(u_over_z: f64, inverse_z: f64) -> Result<f64, String> {
    if inverse_z == 0.0 {
        return Err("inverse_z: expected a number other than zero, found 0".into());
    }
    Ok(u_over_z / inverse_z)
}

pub(crate) const MODELS: &[Model] = models! {
    "eldridge.3.1", "eq 3.1", "a point in the eye's coordinates":
        transform["M": [[f64; 4]; 3], "v": [f64; 3]] -> [f64; 3];
    "eldridge.3.2", "eq 3.2, 3.3", "the point's position on the screen":
        project["d": f64 = 1.0, "v": [f64; 3]] -> Result<[f64; 2], String>;
    "eldridge.3.4", "eq 3.4", "a normal in the eye's coordinates":
        transform_normal["M": [[f64; 4]; 3], "normal": [f64; 3]] -> Result<[f64; 3], String>;
    "eldridge.7.1", "eq 7.1, 7.2", "texture coordinate as a linear function in object space":
        linear["coefficients": [f64; 3], "at": [f64; 2]] -> f64;
    "eldridge.7.3", "eq 7.3, 7.4", "texture coordinate from the screen, with coefficients of u/z":
        texture["coefficients": [f64; 3], "z": f64, "at": [f64; 2]] -> f64;
    "eldridge.7.5", "eq 7.5, 7.6", "texture coordinate from u/z and 1/z":
        texture_by_inverse_depth["u_over_z": f64, "inverse_z": f64] -> Result<f64, String>;
};

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::planes::plane;
    use super::*;

    const TURN_AND_MOVE: [[f64; 4]; 3] = [[0.0, -2.0, 0.0, 3.0], [2.0, 0.0, 0.0, -1.0], [0.0, 0.0, 2.0, 5.0]];

    #[test]
    fn points_turn_and_move() {
        assert_eq!(transform(TURN_AND_MOVE, [1.0, 2.0, 3.0]), [-1.0, 1.0, 11.0]);
        assert_eq!(project(2.0, [1.0, -3.0, 4.0]), Ok([0.5, -1.5]));
        assert!(project(1.0, [0.0, 0.0, 0.0]).is_err() && project(1.0, [1.0, 1.0, -1.0]).is_err());
        assert!(transform_normal([[0.0; 4]; 3], [1.0, 0.0, 0.0]).is_err());
    }

    proptest! {
        /// A normal stays perpendicular to its plane, whatever the matrix.
        #[test]
        fn normals_stay_normal(m in prop::array::uniform9(-5i32..6), c in prop::array::uniform9(-9i32..10)) {
            let matrix = [0, 3, 6].map(|i| [f64::from(m[i]), f64::from(m[i + 1]), f64::from(m[i + 2]), 4.0]);
            let [a, b, p] = [0, 3, 6].map(|i| [0, 1, 2].map(|k| f64::from(c[i + k])));
            let Ok(normal) = transform_normal(matrix, cross(a, b)) else { return Ok(()) };
            let moved = |v: [f64; 3]| {
                let (from, to) = (transform(matrix, p), transform(matrix, [0, 1, 2].map(|k| p[k] + v[k])));
                [0, 1, 2].map(|k| to[k] - from[k])
            };
            prop_assert!(dot(normal, moved(a)).abs() < 1e-6 && dot(normal, moved(b)).abs() < 1e-6);
        }

        /// A function that is linear on a polygon in space is recovered from functions that are linear on the screen.
        #[test]
        fn textures_in_perspective(
            c in prop::array::uniform9(-50i32..51), weights in prop::array::uniform2(0.1f64..1.0),
            u in prop::array::uniform3(0.0f64..1.0),
        ) {
            let v = [0, 3, 6].map(|i| [f64::from(c[i]), f64::from(c[i + 1]), 60.0 + f64::from(c[i + 2])]);
            let on = v.map(|v| project(1.0, v).unwrap());
            let of = |value: [f64; 3]| plane(
                [on[0][0], on[0][1], value[0]], [on[1][0], on[1][1], value[1]], [on[2][0], on[2][1], value[2]]
            );
            let (Ok(inverse), Ok(over)) = (of(v.map(|v| 1.0 / v[2])), of([0, 1, 2].map(|i| u[i] / v[i][2]))) else {
                return Ok(());
            };
            let area = super::super::planes::plane_divisor(
                [on[0][0], on[0][1], 0.0], [on[1][0], on[1][1], 0.0], [on[2][0], on[2][1], 0.0]
            );
            prop_assume!(area.abs() > 1e-3);
            let sum = 1.0 + weights[0] + weights[1];
            let w = [1.0 / sum, weights[0] / sum, weights[1] / sum];
            let inside = [0, 1, 2].map(|k| (0..3).map(|i| w[i] * v[i][k]).sum::<f64>());
            let expected: f64 = (0..3).map(|i| w[i] * u[i]).sum();
            let at = project(1.0, inside).unwrap();
            let by_depth = texture_by_inverse_depth(linear(over, at), linear(inverse, at)).unwrap();
            prop_assert!((by_depth - expected).abs() < 1e-6, "{} {}", by_depth, expected);
            prop_assert!((texture(over, inside[2], at) - expected).abs() < 1e-6);
        }
    }
}
