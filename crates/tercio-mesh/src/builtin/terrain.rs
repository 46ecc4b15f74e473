//! A landscape: ridged fractal noise over a square, coloured by height and slope.
//!
//! Source: Musgrave, "Procedural Fractal Terrains", in Ebert et al., "Texturing and Modeling" (1994): ridges
//! where the noise changes sign, each octave weighted by the height of the one before, so that valleys are
//! smooth and summits rough.

use crate::loops::prelude::*;

use super::grid_cell;
use super::noise::{gradient_noise, hash};
use crate::{Mesh, OctNormal};

const OCTAVES: u64 = 11;
/// Height of the highest summits above the plain; the square is 2 by 2.
const HEIGHT: f64 = 0.55;

/// A square landscape of about `count` triangles, at least 2, with a vertex at each grid point.
pub fn terrain(count: u64, seed: u64) -> Mesh {
    let a = ((count as f64 / 2.0).sqrt() as u64).max(1);
    let b = (count as f64 / (2 * a) as f64).round().max(1.0) as u64;
    let seed = hash(seed ^ 0x7E44_A1B5);
    // +Y is up; seen from above with x to the right, rows run towards -z.
    let place = |n: u64| {
        let (i, j) = (n % (a + 1), n / (a + 1));
        ((2 * i) as f64 / a as f64 - 1.0, 1.0 - (2 * j) as f64 / b as f64)
    };
    let vertices = (a + 1) * (b + 1);
    let positions: Vec<[f32; 3]> = (0..vertices)
        .into_par_iter()
        .map(|n| {
            let (x, z) = place(n);
            [x as f32, (height(x, z, seed) * HEIGHT) as f32, z as f32]
        })
        .collect();

    let normal = |n: u64| {
        let (i, j) = (n % (a + 1), n / (a + 1));
        let at = |i: u64, j: u64| positions[(j * (a + 1) + i) as usize];
        let (l, r) = (at(i.saturating_sub(1), j), at((i + 1).min(a), j));
        let (f, k) = (at(i, j.saturating_sub(1)), at(i, (j + 1).min(b)));
        let slope_x = (r[1] - l[1]) / (r[0] - l[0]);
        let slope_z = (k[1] - f[1]) / (k[2] - f[2]);
        [-slope_x, 1.0, -slope_z]
    };
    let shade = |n: u64| {
        let normal = normal(n);
        let steep = 1.0 - 1.0 / normal.iter().map(|x| x * x).sum::<f32>().sqrt();
        (OctNormal::encode(normal), color(positions[n as usize][1] / HEIGHT as f32, steep))
    };
    let (normals, colors): (Vec<_>, Vec<_>) = (0..vertices).into_par_iter().map(shade).unzip();
    let triangles = (0..a * b).into_par_iter().flat_map_iter(|n| grid_cell(0, a, n % a, n / a)).collect();
    Mesh { positions, triangles, normals: Some(normals), vertex_colors: Some(colors), ..Mesh::default() }
}

/// About 0 to 1.
fn height(x: f64, z: f64, seed: u64) -> f64 {
    // Distort the plane a little, so that ridges do not follow the lattice of the noise.
    let bend = |s: u64| 0.35 * gradient_noise(x * 1.3 + 7.0, z * 1.3 - 3.0, seed ^ s);
    let (x, z) = (x + bend(1), z + bend(2));
    let (mut sum, mut weight, mut amplitude, mut frequency) = (0.0, 1.0, 0.5, 1.1);
    for octave in 0..OCTAVES {
        let n = gradient_noise(x * frequency, z * frequency, seed ^ hash(octave + 3));
        let ridge = (1.0 - n.abs()).max(0.0);
        let ridge = ridge * ridge * weight;
        sum += ridge * amplitude;
        weight = (ridge * 1.6).clamp(0.0, 1.0);
        amplitude *= 0.47;
        frequency *= 2.07;
    }
    let land = 0.5 + 0.5 * gradient_noise(x * 0.7 - 11.0, z * 0.7 + 5.0, seed ^ 0x1A4D);
    (sum * (0.35 + 0.75 * land)).clamp(0.0, 1.5)
}

/// sRGB: meadow, forest, rock and snow by height; rock wherever it is steep.
fn color(height: f32, steep: f32) -> [u8; 4] {
    const BY_HEIGHT: [(f32, [f32; 3]); 5] = [
        (0.10, [112., 128., 74.]),
        (0.28, [78., 104., 58.]),
        (0.50, [116., 106., 88.]),
        (0.66, [136., 130., 124.]),
        (0.76, [238., 241., 245.]),
    ];
    const ROCK: [f32; 3] = [104., 96., 88.];
    let above = BY_HEIGHT.iter().position(|e| e.0 > height).unwrap_or(BY_HEIGHT.len() - 1).max(1);
    let ((h0, c0), (h1, c1)) = (BY_HEIGHT[above - 1], BY_HEIGHT[above]);
    let t = ((height - h0) / (h1 - h0)).clamp(0.0, 1.0);
    let bare = ((steep - 0.18) * 5.0).clamp(0.0, 0.85);
    let channel = |k: usize| {
        let ground = c0[k] + (c1[k] - c0[k]) * t;
        (ground + (ROCK[k] - ground) * bare).round() as u8
    };
    [channel(0), channel(1), channel(2), 255]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::topology::analyze;

    #[test]
    fn a_terrain_is_one_sheet_that_faces_up() {
        let mesh = terrain(50_000, 1);
        let found = analyze(&mesh);
        assert!(found.consistently_wound && found.non_manifold_edges == 0);
        assert_eq!((found.components, found.euler_characteristic()), (1, 1));
        for &[a, b, c] in &mesh.triangles {
            let [a, b, c] = [a, b, c].map(|v| glam::Vec3::from(mesh.positions[v as usize]));
            assert!((b - a).cross(c - a).y > 0.0);
        }
        assert_ne!(mesh.positions, terrain(50_000, 2).positions);
        let heights = mesh.positions.iter().map(|p| p[1]);
        let (lo, hi) = heights.fold((1f32, 0f32), |(l, h), y| (l.min(y), h.max(y)));
        assert!(lo >= 0.0 && hi - lo > 0.2 && hi < 0.9, "{lo} {hi}");
    }
}
