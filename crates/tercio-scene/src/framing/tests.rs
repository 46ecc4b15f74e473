//! Every model is inside the picture and centred in it.

use std::sync::Arc;

use glam::DVec3;
use proptest::prelude::*;
use tercio_mesh::cluster::{PartitionOptions, partition};
use tercio_mesh::{Aabb, Mesh};

use super::{Framing, UpAxis, View};
use crate::{Camera, Projection, Scene};

/// Position of a world point in the picture: -1 to 1 across and upwards.
fn project(camera: &Camera, aspect: f64, p: DVec3) -> (f64, f64) {
    let b = camera.basis().unwrap();
    let d = p - camera.eye;
    let half = match camera.projection {
        Projection::Perspective { fov_y } => (fov_y * 0.5).tan() * d.dot(b.forward),
        Projection::Orthographic { height } => height * 0.5,
    };
    (d.dot(b.right) / (half * aspect), d.dot(b.up) / half)
}

/// Lowest and highest coordinate across, lowest and highest upwards.
fn spread(camera: &Camera, aspect: f64, bounds: &Aabb) -> [f64; 4] {
    let start = [f64::INFINITY, f64::NEG_INFINITY, f64::INFINITY, f64::NEG_INFINITY];
    bounds.corners().into_iter().fold(start, |s, c| {
        let (x, y) = project(camera, aspect, c);
        [s[0].min(x), s[1].max(x), s[2].min(y), s[3].max(y)]
    })
}

fn up_axis() -> impl Strategy<Value = UpAxis> {
    prop_oneof![
        Just(UpAxis::X),
        Just(UpAxis::Y),
        Just(UpAxis::Z),
        Just(UpAxis::NegX),
        Just(UpAxis::NegY),
        Just(UpAxis::NegZ)
    ]
}

prop_compose! {
    fn any_framing()(
        up_axis in up_axis(),
        azimuth in -400.0..400.0,
        elevation in prop_oneof![-100.0..100.0, Just(90.0), Just(-90.0)],
        roll in prop_oneof![Just(0.0), -180.0..180.0],
        aspect in (-4.0f64..4.0).prop_map(f64::exp2),
        fov_y in proptest::option::of(1.0..120.0),
    ) -> Framing {
        Framing { up_axis, azimuth, elevation, roll, zoom: 1.0, aspect, fov_y, fill: 0.9, all_round: false }
    }
}

prop_compose! {
    fn any_bounds()(
        center in prop::array::uniform3(-1.0..1.0),
        far in (-3.0f64..6.0).prop_map(|e| 10f64.powf(e)),
        size in prop::array::uniform3((-4.0f64..0.0).prop_map(|e| 10f64.powf(e))),
        scale in (-3.0f64..3.0).prop_map(|e| 10f64.powf(e)),
    ) -> Aabb {
        let (center, half) = (DVec3::from(center) * far, DVec3::from(size) * scale * 0.5);
        Aabb { min: center - half, max: center + half }
    }
}

proptest! {
    #[test]
    fn the_box_fills_the_picture_to_its_limit(framing in any_framing(), bounds in any_bounds()) {
        let camera = framing.camera(&bounds);
        let [left, right, bottom, top] = spread(&camera, framing.aspect, &bounds);
        let largest = right.max(-left).max(top).max(-bottom);
        // Offsets of 10^9 times the size leave few digits.
        prop_assert!(largest <= 0.9 + 1e-3, "{largest} {camera:?}");
        let at_eye = camera.eye.distance(camera.target);
        let b = camera.basis().unwrap();
        let nearest = bounds.corners().map(|c| (c - camera.eye).dot(b.forward)).into_iter().fold(f64::INFINITY, f64::min);
        prop_assert!(nearest > 0.0, "{nearest}");
        prop_assert!(largest >= 0.9 - 1e-3 || nearest < 2e-3 * at_eye.max(bounds.radius()), "{largest} {camera:?}");
    }

    #[test]
    fn the_box_is_centred(framing in any_framing(), bounds in any_bounds()) {
        let camera = framing.camera(&bounds);
        let [left, right, bottom, top] = spread(&camera, framing.aspect, &bounds);
        prop_assert!((left + right).abs() < 0.02, "{left} {right}");
        prop_assert!((bottom + top).abs() < 0.02, "{bottom} {top}");
    }

    #[test]
    fn zoom_makes_the_picture_larger_by_its_factor(
        framing in any_framing(), bounds in any_bounds(), zoom in 0.1..50.0,
    ) {
        let near = framing.camera(&bounds);
        let zoomed = Framing { zoom, ..framing }.camera(&bounds);
        prop_assert_eq!(near.eye, zoomed.eye);
        let a = spread(&near, framing.aspect, &bounds);
        let b = spread(&zoomed, framing.aspect, &bounds);
        for (a, b) in a.into_iter().zip(b) {
            prop_assert!((a * zoom - b).abs() < 1e-6 * zoom.max(1.0), "{a} {b}");
        }
    }
}

#[test]
fn named_views_look_along_the_axes() {
    let forward = |up_axis, view| Framing { up_axis, ..Framing::default() }.with_view(view).basis();
    let y = |view| forward(UpAxis::Y, view);
    assert_eq!((y(View::Front).forward, y(View::Front).right), (DVec3::NEG_Z, DVec3::X));
    assert_eq!((y(View::Back).forward, y(View::Back).right), (DVec3::Z, DVec3::NEG_X));
    assert_eq!(y(View::Left).forward, DVec3::X);
    assert_eq!(y(View::Right).forward, DVec3::NEG_X);
    assert_eq!((y(View::Top).forward, y(View::Top).up), (DVec3::NEG_Y, DVec3::NEG_Z));
    assert_eq!((y(View::Bottom).forward, y(View::Bottom).up), (DVec3::Y, DVec3::Z));
    let z = |view| forward(UpAxis::Z, view);
    assert_eq!((z(View::Front).forward, z(View::Front).right), (DVec3::Y, DVec3::X));
    assert_eq!((z(View::Top).forward, z(View::Top).up), (DVec3::NEG_Z, DVec3::Y));
    let x = forward(UpAxis::X, View::Front);
    assert_eq!((x.forward, x.up, x.right), (DVec3::NEG_Z, DVec3::X, DVec3::NEG_Y));
    let iso = z(View::Iso).forward;
    assert!((iso - DVec3::new(-1.0, 1.0, -1.0).normalize()).length() < 1e-12, "{iso}");
}

#[test]
fn a_positive_roll_turns_the_picture_clockwise() {
    let upright = Framing::default().with_view(View::Front);
    let rolled = Framing { roll: 90.0, ..upright }.basis();
    assert_eq!((rolled.up, rolled.right), (DVec3::NEG_X, DVec3::Y));
}

#[test]
fn bounds_without_extent_give_a_camera() {
    let point = |p| Aabb { min: p, max: p };
    let nothing = [
        Aabb::EMPTY,
        point(DVec3::ZERO),
        point(DVec3::splat(1e12)),
        Aabb { min: DVec3::NEG_INFINITY, max: DVec3::INFINITY },
        Aabb { min: DVec3::ZERO, max: DVec3::splat(1e-40) },
        Aabb { min: DVec3::ZERO, max: DVec3::Z },
        Aabb { min: DVec3::splat(-3e38), max: DVec3::splat(3e38) },
    ];
    for bounds in nothing {
        for fov_y in [Some(30.0), None] {
            for view in [View::Front, View::Top, View::Iso] {
                let camera = Framing { fov_y, ..Framing::default() }.with_view(view).camera(&bounds);
                assert!(camera.basis().is_ok(), "{bounds:?} {camera:?}");
                assert!(camera.eye.is_finite());
            }
        }
    }
}

#[test]
fn an_explicit_camera_finds_an_up_vector() {
    let framing = Framing::default();
    let down = framing.camera_at(DVec3::Y * 5.0, DVec3::ZERO, None);
    assert_eq!(down.basis().unwrap().up, DVec3::NEG_Z);
    let level = framing.camera_at(DVec3::Z * 5.0, DVec3::ZERO, None);
    assert_eq!(level.up, DVec3::Y);
    let rolled = Framing { roll: 90.0, ..framing }.camera_at(DVec3::Z * 5.0, DVec3::ZERO, None);
    assert_eq!(rolled.up, DVec3::NEG_X);
    assert!(framing.camera_at(DVec3::ONE, DVec3::ONE, None).basis().is_err());
}

#[test]
fn a_scene_is_framed_by_its_vertices_not_its_box() {
    // One triangle: its box has corners that are not vertices. Its unit is 2.
    let mesh = Mesh {
        origin: DVec3::X * 1e6,
        exponent: 1,
        positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.5], [0.0, 0.5, 0.0]],
        triangles: vec![[0, 1, 2]],
        ..Mesh::default()
    };
    let mesh = partition(mesh, &PartitionOptions::default());
    assert_eq!(mesh.bounds, Aabb { min: DVec3::X * 1e6, max: DVec3::new(1e6 + 2.0, 1.0, 1.0) });
    let vertices = [DVec3::ZERO, DVec3::new(2.0, 0.0, 1.0), DVec3::Y].map(|v| v + mesh.origin);
    let scene = Scene::from_mesh(Arc::new(mesh));
    for fov_y in [Some(30.0), None] {
        let framing = Framing { fov_y, ..Framing::default() };
        let camera = framing.camera_for_scene(&scene);
        let seen = vertices.map(|v| project(&camera, framing.aspect, v));
        let largest = seen.iter().fold(0f64, |m, (x, y)| m.max(x.abs()).max(y.abs()));
        assert!((largest - 0.9).abs() < 1e-6, "{largest}");
        let across = seen.map(|s| s.0);
        let middle =
            across.into_iter().fold(f64::INFINITY, f64::min) + across.into_iter().fold(-9.0, f64::max);
        assert!(middle.abs() < 0.01, "{middle}");
    }
    let nothing = Scene::default();
    assert!(Framing::default().camera_for_scene(&nothing).basis().is_ok());
}

#[test]
fn a_model_stays_in_the_picture_while_the_camera_turns_round_it() {
    // Long, thin, and not in the middle of the world.
    let bounds = Aabb { min: DVec3::new(10.0, -2.0, 3.0), max: DVec3::new(18.0, 1.0, 3.5) };
    for (fov_y, up_axis) in [(Some(30.0), UpAxis::Y), (None, UpAxis::Z), (Some(90.0), UpAxis::X)] {
        for elevation in [0.0, 18.0, -60.0, 90.0] {
            let framing = Framing { fov_y, up_axis, elevation, all_round: true, ..Framing::new(160, 90) };
            let camera = framing.camera(&bounds);
            let up = up_axis.front().up;
            let off = camera.target - bounds.center();
            assert!((off - up * off.dot(up)).length() < 1e-9, "the axis goes through the middle: {off}");
            let mut largest = 0f64;
            for step in 0..180 {
                let turned = camera.turned(up, f64::from(step) * 2.0);
                for corner in bounds.corners() {
                    let (x, y) = project(&turned, framing.aspect, corner);
                    largest = largest.max(x.abs()).max(y.abs());
                }
            }
            assert!((0.895..0.906).contains(&largest), "{largest} {fov_y:?} {up_axis:?} {elevation}");
        }
    }
}
