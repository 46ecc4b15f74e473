//! Normals in tangent space from heights.

use tercio_mesh::loops::prelude::*;

/// Height of white above black, in texels. The manual of MTL names no unit. With 4, the edges of stones and letters in
/// common bump maps, which are a few texels wide, have slopes of 30 to 45 degrees.
const DEPTH: f32 = 4.0;

/// Texture of normals, as shares of 65535, of a picture that is repeated. `height` returns the height, 0 to 1, in a row and a
/// column.
///
/// The slope is the central difference of the two neighbours; the upper row has the larger v.
pub fn normals(width: u32, height: u32, at: impl Fn(u32, u32) -> f32 + Sync) -> Vec<[u16; 4]> {
    let mut normals = vec![[0; 4]; width as usize * height as usize];
    normals.par_chunks_mut(width as usize).zip(0..height).for_each(|(row, y)| {
        let (above, below) = (before(y, height), after(y, height));
        for (normal, x) in row.iter_mut().zip(0..) {
            let along_u = at(y, after(x, width)) - at(y, before(x, width));
            let along_v = at(above, x) - at(below, x);
            *normal = encoded([-0.5 * DEPTH * along_u, -0.5 * DEPTH * along_v]);
        }
    });
    normals
}

fn before(i: u32, count: u32) -> u32 {
    if i == 0 { count - 1 } else { i - 1 }
}

fn after(i: u32, count: u32) -> u32 {
    if i + 1 == count { 0 } else { i + 1 }
}

/// The unit vector of (x, y, 1), from -1 to 1 as 0 to 65535.
fn encoded([x, y]: [f32; 2]) -> [u16; 4] {
    let length = (x * x + y * y + 1.0).sqrt();
    let level = |c: f32| ((c / length + 1.0) * 32767.5 + 0.5) as u16;
    [level(x), level(y), level(1.0), u16::MAX]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decoded(texel: [u16; 4]) -> [f32; 3] {
        [0, 1, 2].map(|k| f32::from(texel[k]) / 32767.5 - 1.0)
    }

    #[test]
    fn flat_pictures_have_normals_away_from_the_surface() {
        for texel in normals(3, 2, |_, _| 0.7) {
            let [x, y, z] = decoded(texel);
            assert!(x.abs() < 1e-4 && y.abs() < 1e-4 && z > 0.9999, "{x} {y} {z}");
        }
    }

    #[test]
    fn normals_lean_away_from_higher_neighbours() {
        // A slope of 1/4 a texel: with DEPTH, 45 degrees.
        let [x, y, z] = decoded(normals(9, 9, |_, x| x as f32 / 4.0)[4]);
        assert!((x + z).abs() < 1e-3 && y.abs() < 1e-4 && (z - 0.5f32.sqrt()).abs() < 1e-3, "{x} {y} {z}");
        // The upper row is the higher one, so the slope falls towards smaller v.
        let [x, y, z] = decoded(normals(9, 9, |y, _| -(y as f32) / 4.0)[9 * 4]);
        assert!((y + z).abs() < 1e-3 && x.abs() < 1e-4, "{x} {y} {z}");
    }

    #[test]
    fn the_picture_is_repeated() {
        let row = normals(4, 1, |_, x| f32::from(x == 0));
        let leans: Vec<f32> =
            row.into_iter().map(|t| decoded(t)[0].signum() * f32::from(t[0] != 32768)).collect();
        assert_eq!(leans, [0.0, 1.0, 0.0, -1.0]);
        assert_eq!(normals(1, 1, |_, _| 1.0).len(), 1);
    }
}
