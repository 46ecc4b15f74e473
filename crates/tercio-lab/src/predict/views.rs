//! The scenes and cameras of `tercio bench --look plain`: one light, views round the vertical axis.

use std::sync::Arc;

use tercio_mesh::{Aabb, ClusteredMesh};
use tercio_scene::{Camera, Light, Projection, Scene};

/// The mesh under one light, without highlights.
pub fn scene(mesh: Arc<ClusteredMesh>) -> Scene {
    let mut scene = Scene::from_mesh(mesh);
    scene.lights = vec![Light::Ambient { color: [0.1; 3] }, Light::headlight([0.9; 3])];
    scene.instances[0].surface.specular = 0.0;
    scene
}

/// View number `view` of `views` round a model that fills about 80 % of the picture, seen from above its centre by a
/// fifth of the distance.
pub fn camera(bounds: &Aabb, (width, height): (u32, u32), view: u32, views: u32) -> Camera {
    const DISTANCE: f64 = 2.2;
    const FILL: f64 = 0.8;
    let size = bounds.size().max_element();
    let angle = f64::from(view) / f64::from(views.max(1)) * std::f64::consts::TAU;
    let (sin, cos) = tercio_mesh::trig::sin_cos(angle);
    let target = bounds.center();
    let eye = target + glam::DVec3::new(sin, 0.2, cos) * (DISTANCE * size);
    let shorter = f64::from(width.min(height)) / f64::from(height);
    let fov_y = 2.0 * (0.5 / (FILL * shorter) / DISTANCE).atan();
    Camera {
        eye,
        target,
        up: glam::DVec3::Y,
        projection: Projection::Perspective { fov_y },
        near: None,
        shift: [0.0; 2],
    }
}
