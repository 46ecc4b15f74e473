//! The turning law: model, camera and lights that are rotated, moved or scaled together give the same picture within
//! one colour level, and normals that rotate with them within 0.05 degrees.
//!
//! Rotated positions are rounded to `f32` again, so that a corner may snap to the next sub-pixel and a sample at an
//! edge may belong to another triangle: the test allows few such pixels. Where triangles are only a few sub-pixels
//! high, as at the silhouette of a model, a difference of one sub-pixel also changes the normals. So pictures of
//! rotated models are rotated back, and compared with a ray caster's picture of the original model.

mod common;
mod truth;

use common::*;
use glam::{DAffine3, DMat3, DQuat, DVec3};
use tercio_mesh::{Mesh, OctNormal, builtin, normals};
use tercio_raster::{Cull, Outputs, SamplePattern, Sampling, Settings, Shading};
use tercio_scene::{Camera, Light, LightSpace, Scene};
use tercio_testkit::require_shared;
use truth::{Truth, real_model};

/// Maximum error of a rotated normal, in degrees.
const DEGREES: f64 = 0.05;

fn turn(random: &mut Random) -> DQuat {
    let axis = loop {
        let p = random.point(1.0);
        if (0.1..=1.0).contains(&p.length()) {
            break p.normalize();
        }
    };
    DQuat::from_axis_angle(axis, random.between(0.1, 6.2))
}

fn turned_mesh(mesh: &Mesh, by: DQuat) -> Mesh {
    let vector = |v: [f32; 3]| (by * DVec3::from(v.map(f64::from))).as_vec3().to_array();
    let mut turned = mesh.clone();
    turned.positions = mesh.positions.iter().map(|&p| vector(p)).collect();
    turned.normals =
        mesh.normals.as_ref().map(|n| n.iter().map(|n| OctNormal::encode(vector(n.decode()))).collect());
    turned
}

fn turned_camera(camera: &Camera, by: DQuat) -> Camera {
    Camera { eye: by * camera.eye, target: by * camera.target, up: by * camera.up, ..*camera }
}

fn turned_lights(lights: &[Light], by: DQuat) -> Vec<Light> {
    let turn = |v: DVec3, space: LightSpace| if space == LightSpace::World { by * v } else { v };
    lights
        .iter()
        .map(|light| match *light {
            Light::Ambient { .. } => *light,
            Light::Directional { to_light, space, color } => {
                Light::Directional { to_light: turn(to_light, space), space, color }
            }
            Light::Wide { to_light, space, color, highlight } => {
                Light::Wide { to_light: turn(to_light, space), space, color, highlight }
            }
            Light::Point { position, space, color } => {
                Light::Point { position: turn(position, space), space, color }
            }
            Light::Spot { position, direction, space, angle, color } => {
                let (position, direction) = (turn(position, space), turn(direction, space));
                Light::Spot { position, direction, space, angle, color }
            }
        })
        .collect()
}

fn settings(shading: Shading) -> Settings {
    let outputs = Outputs { color: true, depth: true, ids: true, normals: true, ..Outputs::default() };
    Settings { outputs, shading, cull: Cull::None, ..Settings::one_sample(240, 180) }
}

/// Compares the pictures of two scenes, the second of which is the first one rotated. At most one pixel in `others` may
/// show another triangle.
#[track_caller]
fn check(
    first: (&Scene, &Camera),
    second: (&Scene, &Camera),
    by: DQuat,
    shading: Shading,
    others: usize,
    what: &str,
) {
    check_with(first, second, by, &settings(shading), others, what);
}

/// [`check`] with these settings. Where a pixel has several samples or layers, one of them may show another triangle
/// although the nearest one is the same.
#[track_caller]
fn check_with(
    first: (&Scene, &Camera),
    second: (&Scene, &Camera),
    by: DQuat,
    settings: &Settings,
    others: usize,
    what: &str,
) {
    let shading = settings.shading;
    let has_opacity = |scene: &Scene| {
        let instance = &scene.instances[0];
        instance.surface.opacity < 1.0 || instance.mesh.layout().vertex_colors
    };
    let is_mixed = settings.sampling.pattern != SamplePattern::Center || has_opacity(first.0);
    let (a, b) = (draw(first.0, first.1, settings), draw(second.0, second.1, settings));
    let (mut shown, mut other) = (0, 0);
    for p in 0..a.planes.ids.len() {
        shown += usize::from(a.planes.ids[p] != u32::MAX);
        if a.planes.ids[p] != b.planes.ids[p] {
            other += 1;
            continue;
        }
        let at =
            format!("{what}, {shading:?}, pixel ({}, {}), triangle {}", p % 240, p / 240, a.planes.ids[p]);
        let step = (0..4).map(|k| a.planes.color[p][k].abs_diff(b.planes.color[p][k])).max();
        if is_mixed && step > Some(1) {
            other += 1;
            continue;
        }
        assert!(step <= Some(1), "{at}: {:?} and {:?}", a.planes.color[p], b.planes.color[p]);
        let (m, n) = (
            by * DVec3::from(a.planes.normals[p].map(f64::from)),
            DVec3::from(b.planes.normals[p].map(f64::from)),
        );
        let degrees = m.cross(n).length().atan2(m.dot(n)).to_degrees();
        assert!(m == n || degrees <= DEGREES, "{at}: normals {m} and {n}, {degrees} degrees");
    }
    assert!(shown * 10 >= a.planes.ids.len(), "{what}: only {shown} pixels show a triangle");
    assert!(other * others <= shown, "{what}: {other} of {shown} pixels show another triangle");
}

fn lights() -> Vec<Light> {
    let mut lights = Light::studio();
    lights.push(Light::Directional {
        to_light: DVec3::new(0.3, 1.0, 0.4),
        space: LightSpace::World,
        color: [0.3, 0.2, 0.1],
    });
    lights.push(Light::Point {
        position: DVec3::new(1.0, 2.0, 1.5),
        space: LightSpace::World,
        color: [0.3, 0.3, 0.2],
    });
    lights
}

#[test]
fn one_triangle() {
    let mut random = Random(1);
    let positions = vec![[-1.0, -1.0, 0.0], [1.0, -0.9, 0.3], [-0.1, 1.0, -0.2]];
    let camera = perspective([0.2, 0.1, 3.0], [0.0; 3], 40.0);
    for n in 0..40 {
        let outwards =
            |random: &mut Random| (random.point(1.0).normalize() + DVec3::Z * 1.1).as_vec3().to_array();
        let normals = (0..3).map(|_| OctNormal::encode(outwards(&mut random))).collect();
        let mesh = Mesh {
            positions: positions.clone(),
            triangles: vec![[0, 1, 2]],
            normals: Some(normals),
            ..Mesh::default()
        };
        let by = turn(&mut random);
        let (mut plain, mut turned) = (scene(&mesh), scene(&turned_mesh(&mesh, by)));
        (plain.lights, turned.lights) = (lights(), turned_lights(&lights(), by));
        for shading in [Shading::Phong, Shading::Gouraud, Shading::Flat] {
            let turned_camera = turned_camera(&camera, by);
            check((&plain, &camera), (&turned, &turned_camera), by, shading, 100, &format!("turn {n}"));
        }
    }
}

/// Rotates a model in several ways, and compares the pictures, rotated back, with a ray caster.
#[track_caller]
fn check_model(mesh: &Mesh, turns: usize, random: &mut Random, name: &str) {
    let (center, radius) = (mesh.bounds().center(), mesh.bounds().radius());
    let eye = center + DVec3::new(0.3, 0.5, 0.9).normalize() * radius * 2.5;
    let camera = perspective(eye.to_array(), center.to_array(), 45.0);
    for n in 0..turns {
        let by = turn(random);
        let (mut plain, mut turned) = (scene(mesh), scene(&turned_mesh(mesh, by)));
        (plain.lights, turned.lights) = (lights(), turned_lights(&lights(), by));
        let turned_camera = turned_camera(&camera, by);
        for shading in [Shading::Phong, Shading::Flat] {
            let settings = settings(shading);
            let mut frame = draw(&turned, &turned_camera, &settings);
            for n in &mut frame.planes.normals {
                *n = (by.inverse() * DVec3::from(n.map(f64::from))).as_vec3().to_array();
            }
            let size = [settings.width, settings.height];
            let what = format!("{name}, turn {n}, {shading:?}");
            let found = Truth::new(&[mesh], &plain, &camera, shading, size).check(&frame, &what);
            assert!(found.shown * 10 >= found.pixels, "{what}: {found:?}");
        }
    }
}

#[test]
fn models() {
    let mut random = Random(2);
    let teapot = builtin::make("builtin:teapot@2k").expect("a teapot");
    let mut gyroid = builtin::make("builtin:gyroid@5k").expect("a gyroid");
    normals::make_normals(&mut gyroid, None);
    for (mesh, name) in [(sphere(12), "sphere"), (teapot, "teapot"), (gyroid, "gyroid")] {
        check_model(&mesh, 4, &mut random, name);
    }
}

#[test]
fn real_models() {
    let Some(data) = require_shared("real_models") else { return };
    let mut random = Random(4);
    for name in ["obj/cow.obj", "obj/stanford-bunny.obj"] {
        check_model(&real_model(&data, name), 2, &mut random, name);
    }
}

/// An instance that is rotated, moved and scaled together with the camera gives the same picture as the mesh itself.
#[test]
fn instances() {
    let mut random = Random(3);
    let mesh = sphere(12);
    let plain = scene(&mesh);
    let camera = perspective([0.5, 1.0, 3.0], [0.0; 3], 45.0);
    for n in 0..10 {
        let by = turn(&mut random);
        let (scale, shift) = (10f64.powf(random.between(-6.0, 6.0)), random.point(1e3));
        let mut moved = scene(&mesh);
        moved.instances[0].world_from_object =
            DAffine3 { matrix3: DMat3::from_quat(by) * scale, translation: shift };
        let transform = |p: DVec3| by * p * scale + shift;
        let moved_camera = Camera {
            eye: transform(camera.eye),
            target: transform(camera.target),
            up: by * camera.up,
            ..camera
        };
        for shading in [Shading::Phong, Shading::Gouraud, Shading::Flat] {
            check(
                (&plain, &camera),
                (&moved, &moved_camera),
                by,
                shading,
                50,
                &format!("instance {n}, scale {scale}"),
            );
        }
    }
}

/// The sphere, opaque, with an opacity, and with an alpha at every vertex.
fn translucent() -> Vec<(Mesh, f32, &'static str)> {
    let mut random = Random(5);
    let plain = sphere(9);
    let alpha = plain.positions.iter().map(|_| [200, 120, 90, (random.next() * 256.0) as u8]).collect();
    let with_alpha = Mesh { vertex_colors: Some(alpha), ..plain.clone() };
    vec![(plain.clone(), 1.0, "opaque"), (plain, 0.4, "opacity 0.4"), (with_alpha, 0.8, "alpha of vertices")]
}

/// With several samples per pixel, and where surfaces are seen through each other.
#[test]
fn samples_and_layers() {
    let mut random = Random(6);
    let camera = perspective([0.5, 1.0, 3.0], [0.0; 3], 45.0);
    for (mesh, opacity, look) in translucent() {
        let dressed = |mesh: &Mesh| {
            let mut scene = with_second_instance(scene(mesh));
            scene.instances.iter_mut().for_each(|i| i.surface.opacity = opacity);
            scene
        };
        for pattern in [SamplePattern::Center, SamplePattern::default(), SamplePattern::Sparse16] {
            for shading in [Shading::Phong, Shading::Flat] {
                let settings = Settings { sampling: Sampling::of(pattern), ..settings(shading) };
                let by = turn(&mut random);
                let (mut plain, mut turned) = (dressed(&mesh), dressed(&mesh));
                let (scale, shift) = (10f64.powf(random.between(-6.0, 6.0)), random.point(1e3));
                let place = DAffine3 { matrix3: DMat3::from_quat(by) * scale, translation: shift };
                for instance in &mut turned.instances {
                    instance.world_from_object = place * instance.world_from_object;
                }
                plain.lights = lights();
                turned.lights = turned_lights(&lights(), by);
                for light in &mut turned.lights {
                    if let Light::Point { position, .. } = light {
                        *position = *position * scale + shift;
                    }
                }
                let moved = |p: DVec3| place.transform_point3(p);
                let (eye, target) = (moved(camera.eye), moved(camera.target));
                let turned_camera = Camera { eye, target, up: by * camera.up, ..camera };
                let what = format!("{look}, {pattern:?}");
                check_with((&plain, &camera), (&turned, &turned_camera), by, &settings, 50, &what);
            }
        }
    }
}
