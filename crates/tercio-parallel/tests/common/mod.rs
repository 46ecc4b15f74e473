//! Scenes that ranks draw, and the comparison with the picture of one renderer.

#![allow(dead_code, reason = "each test file uses its own part")]

use std::sync::Arc;

use glam::{DAffine3, DQuat, DVec3};
use tercio_mesh::builtin;
use tercio_mesh::cluster::{PartitionOptions, partition};
use tercio_parallel::in_process::draw;
use tercio_parallel::{FrameReport, Organisation, Ranks};
use tercio_raster::{Frame, Outputs, Renderer, Settings};
use tercio_scene::{Camera, Instance, Projection, Scene};

pub const EVERYTHING: Outputs = Outputs::ALL;
/// With groups that leave a smaller one.
pub const ALL: [Organisation; 5] = [
    Organisation::SortFirst,
    Organisation::SortMiddle,
    Organisation::SortLast,
    Organisation::SortTwice { group: 2 },
    Organisation::SortTwice { group: 3 },
];

pub fn scene(model: &str, most_triangles: usize) -> Scene {
    let mesh = builtin::make(model).expect("a model");
    let options = PartitionOptions { max_triangles: most_triangles, ..PartitionOptions::default() };
    Scene::from_mesh(Arc::new(partition(mesh, &options)))
}

/// The same scene with a second instance, rotated, mirrored, smaller, in the middle of the first.
pub fn with_second_instance(mut scene: Scene) -> Scene {
    let place = scene.bounds().center();
    let (scale, turn) = (DVec3::new(0.5, -0.4, 0.6), DQuat::from_rotation_y(1.0));
    let turned = DAffine3::from_scale_rotation_translation(scale, turn, place * 0.7);
    let second = Instance { world_from_object: turned, ..scene.instances[0].clone() };
    scene.instances.push(second);
    scene
}

/// A camera at this many radii from the centre; below 1 the near plane cuts the model.
pub fn camera(scene: &Scene, radii: f64, orthographic: bool) -> Camera {
    let bounds = scene.bounds();
    let eye = bounds.center() + DVec3::new(0.3, 0.4, 0.9).normalize() * bounds.radius() * radii;
    let projection = if orthographic {
        Projection::Orthographic { height: bounds.radius() * 1.4 }
    } else {
        Projection::Perspective { fov_y: 0.8 }
    };
    Camera {
        eye,
        target: bounds.center() + DVec3::X * 1e-3,
        up: DVec3::Y,
        projection,
        near: None,
        shift: [0.0; 2],
    }
}

#[track_caller]
pub fn assert_same(expected: &Frame, found: &Frame, what: &str) {
    if let Some(difference) = found.difference(expected) {
        panic!("{what}: {difference}");
    }
}

/// Draws with ranks and expects one renderer's bytes.
pub fn check(scene: &Scene, camera: &Camera, settings: &Settings, ranks: Ranks, what: &str) -> FrameReport {
    let expected = Renderer::new().render(scene, camera, settings).expect("a picture");
    check_against(&expected, scene, camera, settings, ranks, what)
}

/// Draws with ranks and expects these bytes.
pub fn check_against(
    expected: &Frame,
    scene: &Scene,
    camera: &Camera,
    settings: &Settings,
    ranks: Ranks,
    what: &str,
) -> FrameReport {
    let (found, report) = draw(ranks, scene, camera, settings).expect("a picture");
    let what = format!("{what}, {ranks:?}, {}x{}", settings.width, settings.height);
    assert_same(expected, &found, &what);
    assert_eq!(report.pixels_visible(), expected.stats.backend.pixels_visible, "{what}");
    assert_eq!(found.stats.backend.pixels_visible, report.pixels_visible());
    let taken = |of: fn(&tercio_parallel::comm::Traffic) -> u64| -> u64 {
        report.ranks.iter().map(|r| of(&r.traffic)).sum()
    };
    assert_eq!((taken(|t| t.taken_messages), taken(|t| t.taken_bytes)), (report.messages, report.bytes));
    assert!(ranks.count > 1 || report.messages == 0, "{what}: one rank sends messages to itself");
    report
}
