//! A closed mesh has no hole from any view, even far from the origin and with sliver triangles.

mod common;

use common::*;
use glam::{DQuat, DVec3};
use tercio_mesh::Mesh;
use tercio_mesh::mesh::localize;
use tercio_raster::{Cull, Frame, Settings};
use tercio_scene::{Camera, Projection, Scene};

const WIDTH: u32 = 72;
const HEIGHT: u32 = 56;

/// Checks that from outside every sample is covered as often by front faces as by back faces, so that both show the
/// same silhouette; returns its number of pixels.
fn check_outside(mesh: &Mesh, scene: &Scene, camera: &Camera, what: &str) -> usize {
    let turns = winding(mesh, scene, camera, WIDTH, HEIGHT);
    let wrong = turns.iter().filter(|&&n| n != 0).count();
    assert_eq!(wrong, 0, "{what}: samples with a winding number other than 0: {camera:?}");
    let by = |cull| covered(&draw(scene, camera, &Settings { cull, ..ids_only(WIDTH, HEIGHT) }));
    let (back, front, both) = (by(Cull::Back), by(Cull::Front), by(Cull::None));
    assert!(
        back == front && back == both,
        "{what}: fronts and backs differ in their silhouettes: {camera:?}"
    );
    both.iter().filter(|c| **c).count()
}

fn check_inside(mesh: &Mesh, scene: &Scene, camera: &Camera, what: &str) {
    let wrong = winding(mesh, scene, camera, WIDTH, HEIGHT).iter().filter(|&&n| n != 1).count();
    let frame = draw(scene, camera, &ids_only(WIDTH, HEIGHT));
    let holes = covered(&frame).iter().filter(|c| !**c).count();
    assert_eq!((wrong, holes), (0, 0), "{what}: {camera:?}");
}

/// A random camera outside of the sphere of `radius` around `center`, looking approximately at it; `narrowest` is the
/// smallest fraction of the sphere that the view shows.
fn outside(random: &mut Random, center: DVec3, radius: f64, narrowest: f64) -> Camera {
    let away = direction(random);
    let eye = center + away * radius * random.between(2.2, 6.0);
    let aside = if random.next() < 0.5 { 0.0 } else { random.between(0.0, 0.6) };
    let target = center + direction(random) * radius * aside;
    let share = narrowest.powf(random.next());
    let projection = if random.next() < 0.7 {
        Projection::Perspective { fov_y: 1.2 * share }
    } else {
        Projection::Orthographic { height: radius * 3.0 * share }
    };
    Camera { eye, target, up: direction(random).cross(away), projection, near: None, shift: [0.0; 2] }
}

fn scaled(mesh: &Mesh, scale: [f64; 3]) -> Mesh {
    let turn = DQuat::from_rotation_x(0.7) * DQuat::from_rotation_z(0.4);
    let moved =
        |p: &[f32; 3]| (turn * (DVec3::from(p.map(f64::from)) * DVec3::from(scale))).as_vec3().to_array();
    Mesh { positions: mesh.positions.iter().map(moved).collect(), normals: None, ..mesh.clone() }
}

/// Spheres from coarse to finer than the pixels, tiny and huge ones, and ones flattened into plates and needles.
fn shapes() -> Vec<(&'static str, Mesh)> {
    vec![
        ("octahedron", sphere(1)),
        ("sphere", sphere(10)),
        ("fine sphere", sphere(45)),
        ("tiny", scaled(&sphere(10), [1e-6; 3])),
        ("huge", scaled(&sphere(10), [1e7; 3])),
        ("plate", scaled(&sphere(24), [1.0, 1e-4, 1.0])),
        ("needle", scaled(&sphere(24), [1e-4, 1.0, 1e-4])),
        ("sheet of slivers", scaled(&sphere(24), [1.0, 1e-4, 1e-2])),
        // Flat except for rounding errors.
        ("flat", scaled(&sphere(16), [1.0, 0.0, 1.0])),
    ]
}

fn radius(mesh: &Mesh) -> f64 {
    mesh.positions.iter().map(|p| DVec3::from(p.map(f64::from)).length()).fold(0.0, f64::max)
}

#[test]
fn closed_meshes_have_no_hole_from_outside() {
    let mut random = Random(21);
    for (name, mesh) in shapes() {
        let scene = scene(&mesh);
        let mut pixels = 0;
        for _ in 0..25 {
            let camera = outside(&mut random, DVec3::ZERO, radius(&mesh), 1e-4);
            pixels += check_outside(&mesh, &scene, &camera, name);
        }
        assert!(pixels > 100, "{name} covers only {pixels} pixels");
    }
}

#[test]
fn closed_meshes_have_no_hole_from_inside() {
    let mut random = Random(22);
    for (name, mesh) in [("octahedron", sphere(1)), ("sphere", sphere(10)), ("fine sphere", sphere(45))] {
        for origin in [[0.0; 3], [500_000.0, 4_649_776.0, 300.0], [-1e7, 3e6, 1e7]] {
            let mesh = Mesh { origin: origin.into(), ..mesh.clone() };
            let scene = scene(&mesh);
            for _ in 0..12 {
                let eye = mesh.origin + direction(&mut random) * random.between(0.0, 0.5);
                let target = eye + direction(&mut random);
                let projection = Projection::Perspective { fov_y: random.between(0.01, 2.8) };
                let camera = Camera {
                    eye,
                    target,
                    up: direction(&mut random),
                    projection,
                    near: None,
                    shift: [0.0; 2],
                };
                check_inside(&mesh, &scene, &camera, name);
            }
        }
    }
}

#[test]
fn closed_meshes_far_from_the_origin_have_no_hole() {
    let mut random = Random(23);
    for (name, mesh) in shapes() {
        for origin in [[1e6, -2e6, 0.1], [500_000.0, 4_649_776.0, 300.0], [1e7, 1e7 / 3.0, -1e7]] {
            let mesh = Mesh { origin: origin.into(), ..mesh.clone() };
            let scene = scene(&mesh);
            for _ in 0..8 {
                // So far from the origin, the eye is not moved to within millionths of a unit of a tiny mesh: that
                // would be a different test.
                let camera = outside(&mut random, mesh.origin, radius(&mesh).max(1e-2), 1e-4);
                check_outside(&mesh, &scene, &camera, &format!("{name} at {origin:?}"));
            }
        }
    }
}

/// The same mesh from `f64` coordinates far from the origin, as they may be in a file.
fn from_file(mesh: &Mesh, shift: DVec3) -> Mesh {
    let points: Vec<[f64; 3]> =
        mesh.positions.iter().map(|p| (DVec3::from(p.map(f64::from)) + shift).to_array()).collect();
    let (origin, positions) = localize(&points);
    Mesh { origin, positions, ..mesh.clone() }
}

/// The number of pixels whose ids differ, and for the others the largest difference of distances, relative to `size`.
fn differences(near: &Frame, far: &Frame, size: f64) -> (usize, f64) {
    let mut pixels = 0;
    let mut largest = 0.0f64;
    for p in 0..near.planes.ids.len() {
        if near.planes.ids[p] != far.planes.ids[p] {
            pixels += 1;
        } else if near.planes.depth[p].is_finite() {
            largest = largest.max(f64::from((near.planes.depth[p] - far.planes.depth[p]).abs()) / size);
        }
    }
    (pixels, largest)
}

#[test]
fn far_from_the_origin_every_byte_is_the_same() {
    // Eye, target and origin are whole multiples of 1/64, so that moving them rounds no coordinate: then the renderer
    // must not round either.
    let near = sphere(20);
    let far = Mesh { origin: DVec3::new(500_000.0, 4_649_776.0, 300.0), ..near.clone() };
    let (near_scene, far_scene) = (scene(&near), scene(&far));
    let mut random = Random(24);
    for _ in 0..20 {
        let camera = outside(&mut random, DVec3::ZERO, 1.0, 0.1);
        let round = |p: DVec3| (p * 64.0).round() / 64.0;
        let camera = Camera { eye: round(camera.eye), target: round(camera.target), ..camera };
        let moved = Camera { eye: camera.eye + far.origin, target: camera.target + far.origin, ..camera };
        let settings = everything(WIDTH, HEIGHT);
        let (a, b) = (draw(&near_scene, &camera, &settings), draw(&far_scene, &moved, &settings));
        assert_same(&a, &b, "far from the origin");
    }
}

#[test]
fn far_from_the_origin_file_coordinates_draw_the_same() {
    // At 1e7 the precision of `f64` is 2e-9. With a model of one unit and pixels of about 1e-2 units, that changes the
    // snapping to 1/256 of a pixel (4e-5 units) of one in about ten thousand vertices, and even fewer pixels.
    let near = sphere(20);
    let near_scene = scene(&near);
    let mut random = Random(25);
    let (mut pixels, mut differing) = (0, 0);
    for shift in [[1e6, -2e6, 0.1], [500_000.3, 4_649_776.7, 300.1], [1e7, 1e7 / 3.0, -1e7]] {
        let shift = DVec3::from(shift);
        let far = from_file(&near, shift);
        assert_ne!(far.origin, DVec3::ZERO, "far away, positions are stored relative to an origin");
        let far_scene = scene(&far);
        for _ in 0..10 {
            let camera = outside(&mut random, DVec3::ZERO, 1.0, 0.1);
            let moved = Camera { eye: camera.eye + shift, target: camera.target + shift, ..camera };
            check_outside(&far, &far_scene, &moved, "file coordinates");
            let settings = everything(WIDTH, HEIGHT);
            let (a, b) = (draw(&near_scene, &camera, &settings), draw(&far_scene, &moved, &settings));
            let (wrong, depth) = differences(&a, &b, 1.0);
            pixels += covered(&a).iter().filter(|c| **c).count();
            differing += wrong;
            assert!(depth < 0.02, "distances differ by more than at grazing triangles: {depth}, {camera:?}");
        }
    }
    assert!(differing * 500 <= pixels, "{differing} of {pixels} pixels differ");
}
