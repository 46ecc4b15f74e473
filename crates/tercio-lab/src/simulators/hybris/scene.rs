//! A model under a camera, in partitions.

use std::sync::Arc;

use tercio_mesh::Mesh;
use tercio_mesh::cluster::{PartitionOptions, partition};
use tercio_raster::projection::clip::clip_triangle;
use tercio_raster::view::View;
use tercio_scene::camera::CameraError;
use tercio_scene::{Camera, Instance};

use super::partition::{PARTITION, partitions, vertices};
use super::{Partition, Scene, Triangle};

/// Projects a model with the renderer's own projection, to 1/256 of a pixel. Triangles that reach behind the eye are
/// clipped; one of which nothing is left counts as outside.
///
/// # Errors
/// The camera gives no valid view.
pub fn project(mesh: &Mesh, camera: &Camera, (width, height): (u32, u32)) -> Result<Scene, CameraError> {
    let plain = Mesh {
        origin: mesh.origin,
        exponent: mesh.exponent,
        positions: mesh.positions.clone(),
        triangles: mesh.triangles.clone(),
        ..Mesh::default()
    };
    // The renderer's view of an object needs its clusters.
    let instance = Instance::new(Arc::new(partition(plain, &PartitionOptions::default())));
    let view = View::new(camera, &instance.bounds(), width, height)?.object(&instance);
    let of = |numbers: Vec<u32>| {
        let mut out = Partition { vertices: vertices(mesh, &numbers), outside: 0, triangles: Vec::new() };
        for number in numbers {
            let corners =
                Mesh::canonical(mesh.triangles[number as usize]).map(|v| mesh.positions[v as usize]);
            let projected = corners.map(|p| view.project(p));
            let before = out.triangles.len();
            let mut keep = |piece: [tercio_raster::view::ScreenVertex; 3]| {
                out.triangles.push(Triangle::new(piece.map(|v| (v.x, v.y))));
            };
            if projected.iter().all(|v| v.inside) {
                keep(projected);
            } else {
                clip_triangle(&view, corners, projected, &mut keep);
            }
            out.outside += u32::from(out.triangles.len() == before);
        }
        out
    };
    Ok(Scene { width, height, partitions: partitions(mesh, PARTITION).into_iter().map(of).collect() })
}
