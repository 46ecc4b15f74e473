//! Scenes that the tests of all effects share.
#![allow(dead_code, reason = "each test binary uses a part of it")]

use tercio_mesh::cluster::{PartitionOptions, partition};
use tercio_mesh::{Mesh, builtin};
use tercio_raster::{Frame, Outputs, Renderer, Settings, Shading};
use tercio_scene::{Background, Camera, Projection, Scene};

/// A box seen from inside, without its front: corners of -1 to 1 in x and y, -1 to 0 in z; with a block on its floor.
pub fn room() -> Mesh {
    let mut mesh = Mesh::default();
    let mut quad = |a: [f32; 3], b: [f32; 3], c: [f32; 3]| {
        let first = mesh.positions.len() as u32;
        let d = std::array::from_fn(|k| a[k] + c[k] - b[k]);
        mesh.positions.extend([a, b, c, d]);
        mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    };
    let mut block = |min: [f32; 3], max: [f32; 3]| {
        let [[x, y, z], [u, v, w]] = [min, max];
        quad([x, y, z], [u, y, z], [u, v, z]);
        quad([x, y, z], [x, y, w], [x, v, w]);
        quad([u, y, z], [u, y, w], [u, v, w]);
        quad([x, y, z], [x, y, w], [u, y, w]);
        quad([x, v, z], [x, v, w], [u, v, w]);
        if z > -1.0 {
            quad([x, y, w], [u, y, w], [u, v, w]);
        }
    };
    block([-1.0, -1.0, -1.0], [1.0, 1.0, 0.0]);
    block([-0.3, -1.0, -0.8], [0.2, -0.5, -0.3]);
    mesh
}

/// A sphere of radius 1.
pub fn ball() -> Mesh {
    let mesh = builtin::make("builtin:sphere@4k").expect("a model");
    let (center, radius) = (mesh.bounds().center(), mesh.bounds().size().max_element() * 0.5);
    let unit = |p: &[f32; 3]| [0, 1, 2].map(|k| (f64::from(p[k]) - center[k]) / radius).map(|c| c as f32);
    Mesh { positions: mesh.positions.iter().map(unit).collect(), ..mesh }
}

/// A mesh in white on black.
pub fn scene(mesh: &Mesh) -> Scene {
    let mut scene = Scene::from_mesh(partition(mesh.clone(), &PartitionOptions::default()));
    scene.instances[0].surface.base_color = [1.0; 3];
    scene.background = Background::Solid([0.0, 0.0, 0.0, 1.0]);
    scene
}

/// A perspective camera that looks from one point to another; `degrees` is its vertical angle of view.
pub fn perspective(eye: [f64; 3], target: [f64; 3], degrees: f64) -> Camera {
    let projection = Projection::Perspective { fov_y: degrees.to_radians() };
    Camera { projection, ..orthographic(eye, target, 1.0) }
}

/// An orthographic camera that looks from one point to another and sees this height.
pub fn orthographic(eye: [f64; 3], target: [f64; 3], height: f64) -> Camera {
    let projection = Projection::Orthographic { height };
    let (eye, target, up) = (eye.into(), target.into(), [0.0, 1.0, 0.0].into());
    Camera { eye, target, up, projection, near: None, shift: [0.0; 2] }
}

/// The camera on the room that most tests use.
pub fn into_room() -> Camera {
    perspective([0.4, 0.7, 4.2], [0.0, -0.1, -0.5], 42.0)
}

/// An unlit picture with all planes that effects need, and all colours.
pub fn draw(scene: &Scene, camera: &Camera, settings: &Settings) -> (Frame, Settings) {
    let outputs =
        Outputs { linear: true, depth: true, normals: true, color: true, color16: true, ..Outputs::NONE };
    let settings = Settings { outputs, shading: Shading::Unlit, ..settings.clone() };
    (Renderer::new().render(scene, camera, &settings).expect("valid settings"), settings)
}
