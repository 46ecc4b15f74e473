//! Clipping neither misses a sample nor covers it twice: from inside a closed mesh every pixel shows the mesh, and the
//! winding number at every sample is exactly 1, however much of the mesh is clipped.

mod common;

use common::*;
use glam::DVec3;
use tercio_mesh::Mesh;
use tercio_raster::view::View;
use tercio_raster::{Cull, Settings, SimdLevel};
use tercio_scene::{Camera, Projection, Scene};

const WIDTH: u32 = 56;
const HEIGHT: u32 = 40;

/// The cube from -1 to 1, each side subdivided into n * n squares.
fn cube(n: u32) -> Mesh {
    let mut mesh = Mesh::default();
    let mut numbers = std::collections::HashMap::new();
    for (axis, sign) in [(0, 1), (0, -1), (1, 1), (1, -1), (2, 1), (2, -1i32)] {
        let mut vertex = |i: u32, j: u32| {
            let mut p = [0; 3];
            p[axis] = sign * n as i32;
            p[(axis + 1) % 3] = 2 * i as i32 - n as i32;
            p[(axis + 2) % 3] = (2 * j as i32 - n as i32) * sign;
            *numbers.entry(p).or_insert_with(|| {
                mesh.positions.push(p.map(|c| c as f32 / n as f32));
                mesh.positions.len() as u32 - 1
            })
        };
        for i in 0..n {
            for j in 0..n {
                let [a, b, c, d] = [vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)];
                mesh.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
    }
    mesh
}

/// Checks coverage and winding number from inside a closed mesh; returns the number of triangles that need clipping at
/// the guard band or the near plane.
fn check_inside(mesh: &Mesh, scene: &Scene, camera: &Camera, what: &str) -> usize {
    let turns = winding(mesh, scene, camera, WIDTH, HEIGHT);
    if let Some(p) = turns.iter().position(|&n| n != 1) {
        let wrong = turns.iter().filter(|&&n| n != 1).count();
        let pixel = [p % WIDTH as usize, p / WIDTH as usize];
        panic!("{what}: winding number {} at {pixel:?}, {wrong} pixels wrong: {camera:?}", turns[p]);
    }
    for cull in [Cull::None, Cull::Front] {
        let settings = Settings { cull, ..ids_only(WIDTH, HEIGHT) };
        let holes = covered(&draw(scene, camera, &settings)).iter().filter(|c| !**c).count();
        assert_eq!(holes, 0, "{what}, {cull:?}: {camera:?}");
    }
    let view = View::new(camera, &scene.bounds(), WIDTH, HEIGHT).expect("a camera");
    let object = view.object(&scene.instances[0]);
    let needs_clipping =
        |t: &&[u32; 3]| t.iter().any(|&v| !object.project(mesh.positions[v as usize]).inside);
    mesh.triangles.iter().filter(needs_clipping).count()
}

fn towards(eye: DVec3, forward: DVec3, projection: Projection) -> Camera {
    let up = if forward.y.abs() < 0.9 { DVec3::Y } else { DVec3::X };
    Camera { eye, target: eye + forward, up, projection, near: None, shift: [0.0; 2] }
}

/// Closed meshes, each with a distance from the origin up to which an eye is certain to be inside.
fn rooms() -> Vec<(&'static str, Mesh, f64)> {
    vec![
        ("cube of 12", cube(1), 0.97),
        ("cube", cube(9), 0.97),
        ("coarse sphere", sphere(2), 0.65),
        ("sphere", sphere(17), 0.98),
    ]
}

#[test]
fn no_hole_for_a_perspective_camera_inside() {
    let mut random = Random(11);
    for (name, mesh, reach) in rooms() {
        let scene = scene(&mesh);
        let mut clipped = 0;
        for fov_y in [170.0, 150.0, 90.0, 20.0, 1.0, 0.05, 0.001f64] {
            for round in 0..16 {
                // Half of the eyes are right in front of the wall.
                let far = if round % 2 == 0 { reach } else { random.between(0.0, reach) };
                let eye = direction(&mut random) * far;
                let projection = Projection::Perspective { fov_y: fov_y.to_radians() };
                let camera = towards(eye, direction(&mut random), projection);
                clipped += check_inside(&mesh, &scene, &camera, &format!("{name}, {fov_y} degrees"));
            }
        }
        assert!(clipped > 1000, "{name}: too few triangles are clipped: {clipped}");
    }
}

#[test]
fn no_hole_for_an_orthographic_camera_inside() {
    let mut random = Random(12);
    for (name, mesh, _) in rooms() {
        let scene = scene(&mesh);
        let mut clipped = 0;
        for height in [0.3, 0.01, 1e-4, 1e-6] {
            for _ in 0..16 {
                let eye = direction(&mut random) * random.between(0.0, 0.3);
                let camera = towards(eye, direction(&mut random), Projection::Orthographic { height });
                clipped += check_inside(&mesh, &scene, &camera, &format!("{name}, height {height}"));
            }
        }
        assert!(clipped > 100, "{name}: too few triangles are clipped: {clipped}");
    }
}

#[test]
fn no_hole_behind_a_near_plane_of_any_distance() {
    // The near plane cuts through the mesh; the rest of the mesh still fills the picture.
    let mut random = Random(13);
    for (name, mesh, _) in rooms() {
        let scene = scene(&mesh);
        for near in [1e-6, 1e-3, 0.1, 0.25] {
            for _ in 0..12 {
                let eye = direction(&mut random) * 0.2;
                let projection = Projection::Perspective { fov_y: 40f64.to_radians() };
                let camera = Camera { near: Some(near), ..towards(eye, direction(&mut random), projection) };
                check_inside(&mesh, &scene, &camera, &format!("{name}, near {near}"));
            }
        }
    }
}

/// A ground plane from -100 to 100 in x and z at y = 0, facing upwards.
fn ground(n: u32) -> Mesh {
    let mut mesh = Mesh::default();
    for i in 0..=n {
        for j in 0..=n {
            let at = |i: u32| (200.0 * f64::from(i) / f64::from(n) - 100.0) as f32;
            mesh.positions.push([at(i), 0.0, at(j)]);
        }
    }
    let number = |i: u32, j: u32| i * (n + 1) + j;
    for i in 0..n {
        for j in 0..n {
            let [a, b, c, d] = [number(i, j), number(i, j + 1), number(i + 1, j + 1), number(i + 1, j)];
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh
}

#[test]
fn the_ground_has_no_hole_below_the_horizon() {
    let mut random = Random(14);
    for n in [1, 3, 40] {
        let mesh = ground(n);
        let scene = scene(&mesh);
        for round in 0..40 {
            let eye =
                DVec3::new(random.between(-20.0, 20.0), 10f64.powf(random.between(-0.9, 0.7)), random.next());
            let turn = random.between(0.0, std::f64::consts::TAU);
            let down = random.between(-0.35, 0.6);
            let projection = Projection::Perspective { fov_y: [0.9, 1.4, 2.2][round % 3] };
            let camera = towards(eye, DVec3::new(turn.cos(), -down, turn.sin()), projection);
            let settings = Settings { cull: Cull::Back, ..everything(WIDTH, HEIGHT) };
            let frame = draw(&scene, &camera, &settings);
            let seen = covered(&frame);
            for x in 0..WIDTH as usize {
                let column: Vec<usize> = (0..HEIGHT as usize).map(|y| y * WIDTH as usize + x).collect();
                let horizon = column.iter().position(|&p| seen[p]).unwrap_or(column.len());
                let (sky, earth) = column.split_at(horizon);
                let what = format!("ground of {n}, column {x}, {camera:?}");
                assert!(sky.iter().all(|&p| !seen[p]) && earth.iter().all(|&p| seen[p]), "hole: {what}");
                for pair in earth.windows(2) {
                    let (upper, lower) = (frame.planes.depth[pair[0]], frame.planes.depth[pair[1]]);
                    // Snapping shifts samples by up to half a sub-pixel, which changes the distances of far rows.
                    assert!(lower <= upper * 1.001, "{upper} above {lower}: {what}");
                }
            }
            let ground_seen = seen.iter().filter(|s| **s).count();
            assert!(ground_seen > 0, "no ground is visible below the horizon: {camera:?}");
        }
    }
}

#[test]
fn clipped_pictures_equal_the_reference() {
    let mut random = Random(15);
    let camera_inside = |random: &mut Random, projection| {
        let eye = direction(random) * 0.6;
        towards(eye, direction(random), projection)
    };
    for (name, mesh) in [("cube", cube(3)), ("sphere", sphere(9)), ("soup", soup(300, 9))] {
        let plain = scene(&mesh);
        for fov_y in [2.9, 1.0, 1e-3, 1e-5] {
            let perspective = Projection::Perspective { fov_y };
            for projection in [perspective, Projection::Orthographic { height: 0.1 * fov_y }] {
                let camera = camera_inside(&mut random, projection);
                let settings = everything(WIDTH, HEIGHT);
                let expected = draw_reference(&mesh, &plain, &camera, &settings);
                for simd in SimdLevel::available() {
                    let s = Settings { simd: Some(simd), ..settings.clone() };
                    assert_same(
                        &expected,
                        &draw(&plain, &camera, &s),
                        &format!("{name}, {simd}, {camera:?}"),
                    );
                }
            }
        }
    }
}
