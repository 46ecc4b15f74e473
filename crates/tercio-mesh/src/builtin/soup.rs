//! Unordered random triangles: the worst case of every renderer.

use crate::loops::prelude::*;

use super::noise::{hash, unit};
use crate::Mesh;

/// Exactly `count` random triangles in a cube, intersecting each other, from tiny to large, each with its own colour.
/// No two share a vertex.
pub fn soup(count: u64, seed: u64) -> Mesh {
    // With edges of this length, a line of sight crosses about count^(1/3) triangles.
    let typical = 2.0 / cube_root(count as f64);
    let triangle = |i: u64| -> ([[f32; 3]; 3], [u8; 4]) {
        let first = hash(seed).wrapping_add(i << 4);
        let random = |k: u64| unit(hash(first + k));
        let u = random(0);
        // Most are about the typical size, a few are twelve times as large.
        let size = (typical * (0.2 + u * u * u * u * u * u * 12.0)).min(0.9);
        let center: [f64; 3] = std::array::from_fn(|k| (random(1 + k as u64) * 2.0 - 1.0) * (1.0 - size));
        let corners = std::array::from_fn(|c| {
            std::array::from_fn(|k| {
                (center[k] + size * (random(4 + 3 * c as u64 + k as u64) * 2.0 - 1.0)) as f32
            })
        });
        let color = hash(first + 13).to_le_bytes();
        (corners, [color[0] | 64, color[1] | 64, color[2] | 64, 255])
    };
    Mesh {
        positions: (0..count).into_par_iter().flat_map_iter(|i| triangle(i).0).collect(),
        triangles: (0..count as u32).into_par_iter().map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
        face_colors: Some((0..count).into_par_iter().map(|i| triangle(i).1).collect()),
        ..Mesh::default()
    }
}

/// The cube root of a number of at least 1, by Newton's method.
pub(super) fn cube_root(x: f64) -> f64 {
    let mut r = x;
    for _ in 0..100 {
        r = (2.0 * r + x / (r * r)) / 3.0;
    }
    r
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_soup_has_its_count_and_stays_in_the_cube() {
        for count in [1, 7, 10_000] {
            let m = soup(count, 5);
            assert_eq!(m.triangles.len() as u64, count);
            assert!(crate::weld::is_soup(&m));
            assert!(m.positions.as_flattened().iter().all(|x| x.abs() <= 1.0));
        }
        assert!((cube_root(1e9) - 1000.0).abs() < 1e-9);
    }
}
