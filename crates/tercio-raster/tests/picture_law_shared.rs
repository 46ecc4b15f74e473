//! Every path draws the same picture: with real-world models, which are in the folder `shared` of the checkout.

mod common;

use common::*;
use glam::DVec3;
use tercio_mesh::io::{self, ReadOptions};
use tercio_mesh::{Mesh, builtin, clean, normals};
use tercio_raster::{Cull, Settings, Shading};
use tercio_scene::Camera;
use tercio_testkit::require_shared;

/// A model from the shared folder, prepared as the program does.
fn read(test: &str, path: &str) -> Option<Mesh> {
    let path = require_shared(test)?.join("meshes").join(path);
    let mut mesh = io::read(&path, &ReadOptions::default()).expect("a model").mesh;
    clean::clean(&mut mesh);
    if mesh.normals.is_none() {
        normals::make_normals(&mut mesh, None);
    }
    Some(mesh)
}

/// A camera at a distance of `far` radii; at 0.3 the eye is inside the model.
fn camera(mesh: &Mesh, degrees: f64, far: f64) -> Camera {
    let bounds = mesh.bounds();
    let (center, radius) = (bounds.center(), bounds.radius());
    let away = DVec3::new(0.4, 0.3, 0.9).normalize();
    perspective((center + away * radius * far).to_array(), center.to_array(), degrees)
}

fn check(mesh: &Mesh, camera: &Camera, settings: &Settings, what: &str) {
    let seen = covered(&draw(&scene(mesh), camera, settings)).iter().filter(|c| **c).count();
    assert!(seen * 20 > 512 * 384, "{what}: the model covers only {seen} pixels");
    check_paths(mesh, camera, settings, &[(64, 17, Some(3)), (33, 128, Some(4))], what);
}

#[test]
fn the_bunny() {
    let Some(mesh) = read("the_bunny", "obj/stanford-bunny.obj") else { return };
    check(&mesh, &camera(&mesh, 40.0, 2.2), &everything(512, 384), "bunny");
    let flat = Settings { shading: Shading::Flat, ..everything(512, 384) };
    check(&mesh, &camera(&mesh, 90.0, 0.3), &flat, "bunny from inside");
}

#[test]
fn the_dragon() {
    let Some(mesh) = read("the_dragon", "ply/dragon_vrip.ply.gz") else { return };
    check(&mesh, &camera(&mesh, 40.0, 2.2), &everything(512, 384), "dragon");
}

#[test]
fn the_teapot() {
    let mesh = builtin::make("builtin:teapot@200k").expect("a teapot");
    let settings = everything(512, 384);
    check(&mesh, &camera(&mesh, 40.0, 2.2), &settings, "teapot");
    let back = Settings { cull: Cull::Back, shading: Shading::Gouraud, ..settings };
    check(&mesh, &camera(&mesh, 80.0, 0.3), &back, "teapot from inside, fronts only");
}
