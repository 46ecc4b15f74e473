//! Scenes that are hard to draw fast, the same on every run. Planar scenes are in planes of constant z, in a square of
//! edge [`EDGE`] round the origin, and face +z.

use anyhow::Result;
use tercio_mesh::{Mesh, OctNormal};

/// The edge of the square that the picture of a planar scene shows, at z = 0.
pub const EDGE: f32 = 32.0;
/// Layers of [`layers`].
const LAYERS: u32 = 100;
/// Triangles of [`slivers`].
const SLIVERS: u32 = 10_000;
/// Cells of [`one_a_cell`] along an edge.
const CELLS: u32 = 32;

/// A built-in model of tercio.
pub fn builtin(spec: &str) -> Result<Option<Mesh>> {
    Ok(Some(tercio_mesh::builtin::make(spec)?))
}

/// Triangles one behind the other, each of which covers the whole picture; in the file the farthest comes first, or the
/// nearest.
pub fn layers(front_to_back: bool) -> Mesh {
    let mut mesh = plane();
    for i in 0..LAYERS {
        let z = if front_to_back { LAYERS - 1 - i } else { i } as f32 * 0.01;
        add(
            &mut mesh,
            [[-2.0, -1.0, z], [2.0, -1.0, z], [0.0, 3.0, z]].map(|[x, y, z]| [x * EDGE, y * EDGE, z]),
        );
    }
    mesh
}

/// Thin triangles from the left border of the picture to the right one, at any height, slope and depth: at most half
/// a pixel thick in a picture of 1024 pixels.
pub fn slivers() -> Mesh {
    let mut random = fastrand::Rng::with_seed(1);
    let mut height = || (random.f32() - 0.5) * EDGE;
    let mut mesh = plane();
    for _ in 0..SLIVERS {
        let (left, right, z) = (height(), height(), height() * 0.01);
        let thickness = EDGE / 2048.0;
        add(
            &mut mesh,
            [[-0.51 * EDGE, left, z], [0.51 * EDGE, right, z], [0.51 * EDGE, right + thickness, z]],
        );
    }
    mesh
}

/// One triangle in each cell of a grid over the picture, not touching the cell's borders.
pub fn one_a_cell() -> Mesh {
    let mut mesh = plane();
    let cell = EDGE / CELLS as f32;
    for (row, column) in (0..CELLS).flat_map(|row| (0..CELLS).map(move |column| (row, column))) {
        let at = |x: f32, y: f32| {
            [(column as f32 + x) * cell - EDGE * 0.5, (row as f32 + y) * cell - EDGE * 0.5, 0.0]
        };
        add(&mut mesh, [at(0.1, 0.1), at(0.9, 0.1), at(0.1, 0.9)]);
    }
    mesh
}

/// The mesh with its triangles in random order.
pub fn shuffled(mut mesh: Mesh) -> Mesh {
    fastrand::Rng::with_seed(1).shuffle(&mut mesh.triangles);
    mesh
}

/// A mesh without triangles, to be filled by [`add`].
fn plane() -> Mesh {
    Mesh { normals: Some(Vec::new()), ..Mesh::default() }
}

fn add(mesh: &mut Mesh, corners: [[f32; 3]; 3]) {
    let first = u32::try_from(mesh.positions.len()).expect("few vertices");
    mesh.positions.extend(corners);
    mesh.normals.get_or_insert_default().extend([OctNormal::encode([0.0, 0.0, 1.0]); 3]);
    mesh.triangles.push([first, first + 1, first + 2]);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plane_scenes_face_the_viewer() {
        for mesh in [layers(true), layers(false), slivers(), one_a_cell()] {
            for &[a, b, c] in &mesh.triangles {
                let [a, b, c] = [a, b, c].map(|v| glam::Vec3::from(mesh.positions[v as usize]));
                assert!((b - a).cross(c - a).z > 0.0);
            }
        }
    }

    #[test]
    fn every_layer_covers_the_picture() {
        for t in layers(true).triangles {
            let mesh = layers(true);
            let [a, b, c] = t.map(|v| glam::Vec3::from(mesh.positions[v as usize]).truncate());
            for corner in [[-0.5, -0.5], [0.5, -0.5], [-0.5, 0.5], [0.5, 0.5]] {
                let p = glam::Vec2::from(corner) * EDGE;
                assert!([(a, b), (b, c), (c, a)].iter().all(|(a, b)| (b - a).perp_dot(p - a) > 0.0));
            }
        }
    }
}
