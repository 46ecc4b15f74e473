//! Points are where the renderer draws them.

use glam::DVec3;
use tercio_annotate::Projector;
use tercio_mesh::Aabb;
use tercio_raster::conventions::SUBPIXELS;
use tercio_raster::view::View;
use tercio_scene::{Camera, Projection};

#[test]
fn the_projection_is_that_of_the_renderer() {
    let bounds = Aabb { min: DVec3::splat(-2.0), max: DVec3::splat(2.0) };
    for projection in [Projection::Perspective { fov_y: 0.7 }, Projection::Orthographic { height: 5.0 }] {
        for shift in [[0.0, 0.0], [0.13, -0.07]] {
            let eye = DVec3::new(3.0, -2.0, 9.0);
            let camera = Camera { eye, target: DVec3::ONE, up: DVec3::Y, projection, near: None, shift };
            let view = View::new(&camera, &bounds, 640, 480).expect("a camera");
            let projector = Projector::new(&camera, [640.0, 480.0]).expect("a camera");
            for p in bounds.corners() {
                let v = p - view.eye;
                let w = if view.perspective { v.dot(view.basis.forward) } else { 1.0 };
                let across = [v.dot(view.basis.right), -v.dot(view.basis.up)];
                let expected = [0, 1]
                    .map(|k| (f64::from(view.middle[k]) + across[k] * view.scale / w) / f64::from(SUBPIXELS));
                let found = projector.point(p).expect("seen");
                assert!((0..2).all(|k| (found[k] - expected[k]).abs() < 1e-9), "{found:?} {expected:?}");
            }
        }
    }
}
