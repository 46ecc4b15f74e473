//! Is the order of a mesh's triangles good enough to be kept?

use glam::Vec3;

use super::Numbering;
use crate::Mesh;
use crate::cluster::{MAX_TRIANGLES, MAX_VERTICES};

/// Number of consecutive triangles in a sample.
const SAMPLE: usize = 2048;
/// Number of samples, taken evenly over the mesh, unless fewer are all of it.
const SAMPLES: usize = 16;

/// True if consecutive triangles of the mesh make full and compact clusters, judged by a few samples.
pub(super) fn is_coherent(mesh: &Mesh) -> bool {
    let n = mesh.triangles.len();
    let length = SAMPLE.min(n);
    let samples = n.div_ceil(SAMPLE).clamp(1, SAMPLES);
    let starts = (0..samples).map(|i| (n - length) / (samples - 1).max(1) * i);
    let (mut clusters, mut vertices, mut spread, mut area) = (0, 0, 0.0, 0.0);
    let mut numbering = Numbering::default();
    let mut corners = [[0; 3]; SAMPLE];
    for triangles in starts.map(|s| &mesh.triangles[s..s + length]) {
        let corners = &mut corners[..length];
        numbering.number(triangles.iter().copied(), corners);
        let mut rest = triangles;
        for (triangles_of_run, vertices_of_run) in runs(corners) {
            let (run, after) = rest.split_at(triangles_of_run);
            rest = after;
            let (diagonal, surface) = extent(mesh, run);
            clusters += 1;
            vertices += vertices_of_run;
            spread += diagonal;
            area += surface;
        }
    }
    // The square of the diagonal is 2.5 times the area for a round flat patch, and 7 times for tiles of 7 x 7 squares
    // when a sample begins inside a tile.
    let full = vertices as f32 <= 0.75 * (length * samples) as f32;
    full && clusters > 0 && spread <= 8.0 * area
}

/// Numbers of triangles and vertices of the clusters that the given order makes.
fn runs(corners: &[[u16; 3]]) -> Vec<(usize, usize)> {
    let mut runs: Vec<(usize, usize)> = Vec::new();
    // The run that last used a vertex.
    let mut last_use = [0; 3 * SAMPLE];
    for triangle in corners {
        let number = runs.len();
        let missing = triangle.iter().filter(|&&v| last_use[usize::from(v)] != number).count();
        let open = runs.last_mut().filter(|r| r.0 < MAX_TRIANGLES && r.1 + missing <= MAX_VERTICES);
        match open {
            Some(run) => *run = (run.0 + 1, run.1 + missing),
            None => runs.push((1, 3)),
        }
        triangle.iter().for_each(|&v| last_use[usize::from(v)] = runs.len());
    }
    runs
}

/// Square of the diagonal of the triangles' bounding box, and their surface area.
fn extent(mesh: &Mesh, triangles: &[[u32; 3]]) -> (f32, f32) {
    let (mut min, mut max, mut area) = (Vec3::INFINITY, Vec3::NEG_INFINITY, 0.0);
    for t in triangles {
        let [a, b, c] = t.map(|v| Vec3::from(mesh.positions[v as usize]));
        (min, max) = (min.min(a).min(b).min(c), max.max(a).max(b).max(c));
        area += (b - a).cross(c - a).length() * 0.5;
    }
    (min.distance_squared(max), area)
}
