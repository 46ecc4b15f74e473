//! The triangles of a scene as boxes of samples, in the order of the clusters: the input of simulated organisations of
//! ranks.

use tercio_mesh::ClusteredMesh;
use tercio_mesh::loops::prelude::*;
use tercio_raster::projection::clip::clip_triangle;
use tercio_raster::screen::ScreenTriangle;
use tercio_raster::view::{ObjectView, ScreenVertex, View};
use tercio_scene::{Camera, Scene};

use super::PredictError;
use crate::workloads::{BoundingBox, BoxScene, PixelBox};

/// The boxes of all triangles, or of their pieces after clipping.
///
/// # Errors
/// A camera that makes no view.
pub fn boxes(scene: &Scene, camera: &Camera, (width, height): (u32, u32)) -> Result<BoxScene, PredictError> {
    let view = View::new(camera, &scene.bounds(), width, height)?;
    let mut boxes = Vec::new();
    for instance in &scene.instances {
        let (object, mesh) = (view.object(instance), &*instance.mesh);
        let of_clusters = (0..mesh.clusters().len()).into_par_iter();
        let of_cluster = |cluster| of_cluster(mesh, cluster, &object, (width, height));
        boxes.par_extend(of_clusters.flat_map_iter(of_cluster));
    }
    Ok(BoxScene { boxes })
}

fn of_cluster(mesh: &ClusteredMesh, number: usize, view: &ObjectView, size: (u32, u32)) -> Vec<BoundingBox> {
    let cluster = mesh.cluster(number);
    let at = |n: usize| cluster.position(n);
    let vertices: Vec<ScreenVertex> = (0..cluster.vertices()).map(|n| view.project(at(n))).collect();
    let mut boxes = Vec::new();
    for t in 0..cluster.triangles() {
        let numbers = cluster.corners_of(t).map(usize::from);
        let corners = numbers.map(|n| vertices[n]);
        if corners.iter().all(|c| c.inside) {
            boxes.push(of_triangle(corners, size));
        } else {
            clip_triangle(view, numbers.map(at), corners, |piece| boxes.push(of_triangle(piece, size)));
        }
    }
    boxes
}

fn of_triangle(corners: [ScreenVertex; 3], (width, height): (u32, u32)) -> BoundingBox {
    let triangle = ScreenTriangle::new(corners, 0);
    let samples = triangle.samples(width, height).filter(|_| triangle.area() != 0);
    let pixels = samples.map_or(PixelBox { x0: 0, y0: 0, x1: 0, y1: 0 }, |s| PixelBox {
        x0: s.x0,
        y0: s.y0,
        x1: s.x1,
        y1: s.y1,
    });
    BoundingBox { visible: samples.is_some(), pixels }
}
