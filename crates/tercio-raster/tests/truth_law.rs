//! The truth law: triangles, depths, normals and colours agree with those of a ray caster in `f64` that shares no code
//! with the renderer.

mod common;
mod truth;

use common::*;
use glam::{DAffine3, DMat3, DQuat, DVec3};
use tercio_mesh::{Mesh, OctNormal, builtin, normals};
use tercio_raster::{Cull, Outputs, SamplePattern, SampleShading, Sampling, Settings, Shading};
use tercio_scene::{Camera, Light, LightSpace, Projection, Scene};
use tercio_testkit::require_shared;
use truth::{Found, Truth, real_model};

const SIZE: [u32; 2] = [96, 72];

fn settings(shading: Shading) -> Settings {
    let outputs = Outputs { color: true, depth: true, ids: true, normals: true, ..Outputs::default() };
    Settings { outputs, shading, cull: Cull::None, ..Settings::one_sample(SIZE[0], SIZE[1]) }
}

/// Draws a scene and compares it with the ray caster; a minimum number of pixels must be decided, and show a triangle.
#[track_caller]
fn check(meshes: &[&Mesh], scene: &Scene, camera: &Camera, shading: Shading, what: &str) -> Found {
    let frame = draw(scene, camera, &settings(shading));
    let what = format!("{what}, {shading:?}");
    let found = Truth::new(meshes, scene, camera, shading, SIZE).check(&frame, &what);
    // Frames with colours only use specialized kernels, with and without highlights.
    for specular in [scene.instances[0].surface.specular, 0.0] {
        let mut scene = scene.clone();
        scene.instances.iter_mut().for_each(|instance| instance.surface.specular = specular);
        let colors = Settings { outputs: Outputs::default(), ..settings(shading) };
        let [all_planes, colors_only] =
            [settings(shading), colors].map(|settings| draw(&scene, camera, &settings).planes.color);
        assert!(all_planes == colors_only, "{what}, specular {specular}: colours differ if drawn alone");
    }
    found
}

/// Lights of all kinds.
fn all_lights(reach: f64) -> Vec<Light> {
    let point = |position, space, color| Light::Point { position, space, color };
    vec![
        Light::Ambient { color: [0.05, 0.06, 0.07] },
        Light::Directional {
            to_light: DVec3::new(0.3, 1.0, 0.4),
            space: LightSpace::World,
            color: [0.3, 0.2, 0.1],
        },
        Light::headlight([0.1, 0.2, 0.1]),
        point(DVec3::new(1.0, 2.0, 1.5) * reach, LightSpace::World, [0.3, 0.3, 0.2]),
        point(DVec3::new(-1.0, 0.5, -0.2) * reach, LightSpace::Camera, [0.1, 0.1, 0.3]),
    ]
}

/// Every sample of a pixel shows what the ray through its own position hits.
#[test]
fn every_sample() {
    let mesh = soup(200, 90);
    let mut scene = scene(&mesh);
    scene.lights = all_lights(1.0);
    let cameras = [
        perspective([0.5, 1.0, 3.0], [0.0; 3], 40.0),
        perspective([0.1, 0.2, 0.3], [0.7, -0.4, 0.1], 80.0),
        orthographic([0.5, 1.0, 3.0], [0.0; 3], 2.5),
    ];
    let size = [48, 36];
    for pattern in SamplePattern::ALL {
        for camera in &cameras {
            let sampling = Sampling { shading: SampleShading::Sample, ..Sampling::of(pattern) };
            let [width, height] = size;
            let samples = Settings { width, height, sampling, unresolved: true, ..settings(Shading::Phong) };
            let frame = draw(&scene, camera, &samples);
            let truth = Truth::new(&[&mesh], &scene, camera, Shading::Phong, size).at_samples(pattern);
            truth.check(&frame, &format!("{pattern} samples"));
        }
    }
}

#[test]
fn random_triangles() {
    for seed in 0..3 {
        let mesh = soup(200, 70 + seed);
        let mut scene = scene(&mesh);
        scene.lights = all_lights(1.0);
        for shading in [Shading::Flat, Shading::Gouraud, Shading::Phong, Shading::Unlit] {
            let outside = perspective([0.5, 1.0, 3.0], [0.0; 3], 40.0);
            check(&[&mesh], &scene, &outside, shading, &format!("soup {seed}"));
            let inside = perspective([0.1, 0.2, 0.3], [0.7, -0.4, 0.1], 80.0);
            check(&[&mesh], &scene, &inside, shading, &format!("soup {seed} from inside"));
            let parallel = orthographic([0.5, 1.0, 3.0], [0.0; 3], 2.5);
            check(&[&mesh], &scene, &parallel, shading, &format!("soup {seed}, parallel"));
        }
    }
}

/// Very different normals show whether unit vectors are interpolated, or vectors of other lengths.
#[test]
fn one_triangle_with_very_different_normals() {
    let mut random = Random(5);
    for n in 0..20 {
        let positions = vec![[-1.0, -1.0, 0.0], [1.0, -0.9, 0.3], [-0.1, 1.0, -0.2]];
        let outwards =
            |random: &mut Random| (random.point(1.0).normalize() + DVec3::Z * 1.1).as_vec3().to_array();
        let normals = (0..3).map(|_| OctNormal::encode(outwards(&mut random))).collect();
        let mesh = Mesh { positions, triangles: vec![[0, 1, 2]], normals: Some(normals), ..Mesh::default() };
        let camera = perspective([0.2, 0.1, 3.0], [0.0; 3], 40.0);
        check(&[&mesh], &scene(&mesh), &camera, Shading::Phong, &format!("triangle {n}"));
    }
}

/// Stretched, turned and mirrored instances.
#[test]
fn instances() {
    let mesh = sphere(8);
    let mut scene = scene(&mesh);
    let stretched = DMat3::from_diagonal(DVec3::new(1.0, 0.4, -0.7)) * DMat3::from_rotation_x(0.6);
    scene.instances[0].world_from_object =
        DAffine3 { matrix3: stretched, translation: DVec3::new(-0.5, 0.2, 0.0) };
    let mut second = scene.instances[0].clone();
    second.world_from_object = DAffine3::from_scale_rotation_translation(
        DVec3::splat(0.6),
        DQuat::from_rotation_y(1.0),
        DVec3::new(0.6, -0.1, 0.3),
    );
    scene.instances.push(second);
    for shading in [Shading::Flat, Shading::Gouraud, Shading::Phong] {
        let camera = perspective([0.5, 1.0, 3.0], [0.0; 3], 45.0);
        check(&[&mesh, &mesh], &scene, &camera, shading, "two instances");
    }
}

/// At the silhouette of coarse meshes, interpolated normals point away from the viewer, and must be bent.
#[test]
fn no_normal_points_away_from_the_viewer() {
    for n in [1, 2, 4] {
        let mesh = sphere(n);
        for camera in
            [perspective([0.5, 1.0, 3.0], [0.0; 3], 45.0), orthographic([1.0, 0.3, 2.0], [0.0; 3], 2.4)]
        {
            check(&[&mesh], &scene(&mesh), &camera, Shading::Phong, &format!("sphere of {n}"));
        }
    }
    // Arbitrarily wrong normals, as a file may have.
    let mut random = Random(9);
    let mut mesh = sphere(4);
    let wrong = |random: &mut Random| OctNormal::encode(random.point(1.0).as_vec3().to_array());
    mesh.normals = Some(mesh.positions.iter().map(|_| wrong(&mut random)).collect());
    let camera = perspective([0.5, 1.0, 3.0], [0.0; 3], 45.0);
    check(&[&mesh], &scene(&mesh), &camera, Shading::Phong, "random normals");
}

#[test]
fn built_in_models() {
    for (spec, eye) in [("builtin:teapot@6k", [0.3, 0.5, 0.9]), ("builtin:gyroid@5k", [0.6, 0.3, 0.7])] {
        let mut mesh = builtin::make(spec).expect("a model");
        if mesh.normals.is_none() {
            normals::make_normals(&mut mesh, None);
        }
        let (center, radius) = (mesh.bounds().center(), mesh.bounds().radius());
        let at = |far: f64| (center + DVec3::from(eye).normalize() * radius * far).to_array();
        for shading in [Shading::Flat, Shading::Phong] {
            let outside = perspective(at(2.5), center.to_array(), 45.0);
            check(&[&mesh], &scene(&mesh), &outside, shading, spec);
        }
        let inside = perspective(at(0.3), center.to_array(), 90.0);
        check(&[&mesh], &scene(&mesh), &inside, Shading::Phong, &format!("{spec} from inside"));
    }
}

/// Objects at a distance of a ten-millionth of the scene's size and less are visible, and as precise as distant ones:
/// the scene is 20 km wide, with the eye in its middle or near its border.
#[test]
fn near_objects_in_a_large_scene() {
    for (place, eye) in [("middle", DVec3::ZERO), ("border", DVec3::new(9_000.0, -3_000.0, 5_000.0))] {
        let mut random = Random(3);
        let mut mesh = Mesh::default();
        let add = |corners: [DVec3; 3], mesh: &mut Mesh| {
            let first = mesh.positions.len() as u32;
            mesh.positions.extend(corners.map(|p| p.as_vec3().to_array()));
            mesh.triangles.push([first, first + 1, first + 2]);
        };
        // A floor and a back wall as large as the scene, of two triangles each.
        let [low, high] = [-10_000.0, 10_000.0];
        let floor =
            [[low, low], [high, low], [high, high], [low, high]].map(|[x, z]| DVec3::new(x, eye.y - 1.7, z));
        let wall = [[low, low], [high, low], [high, high], [low, high]].map(|[x, y]| DVec3::new(x, y, low));
        for [a, b, c, d] in [floor, wall] {
            add([a, b, c], &mut mesh);
            add([a, c, d], &mut mesh);
        }
        // Small triangles at distances from a hundredth of a millimetre (near the border from 5 cm, because of the
        // precision of `f32` there) to 5 km.
        let nearest: f64 = if place == "middle" { 1e-5 } else { 0.05 };
        for n in 0..80 {
            let distance = nearest * (5_000.0 / nearest).powf(f64::from(n) / 80.0);
            let direction = DVec3::new(random.between(-0.7, 0.7), random.between(-0.5, 0.5), -1.0);
            let center = eye + direction * distance;
            let corners = [0; 3].map(|_| center + random.point(1.0) * distance * 0.15);
            add(corners, &mut mesh);
        }
        let camera = Camera {
            eye,
            target: eye - DVec3::Z,
            up: DVec3::Y,
            projection: Projection::Perspective { fov_y: 1.0 },
            near: None,
            shift: [0.0; 2],
        };
        // The normals of a triangle's corners are on the same side of its plane, and differ.
        let smooth = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| DVec3::from(mesh.positions[v as usize].map(f64::from)));
            let plane = (b - a).cross(c - a).normalize();
            [a, b, c].map(|p| OctNormal::encode((plane + (p - eye).normalize() * 0.3).as_vec3().to_array()))
        };
        mesh.normals = Some(mesh.triangles.iter().flat_map(smooth).collect());
        for shading in [Shading::Flat, Shading::Unlit, Shading::Phong, Shading::Gouraud] {
            let found =
                check(&[&mesh], &scene(&mesh), &camera, shading, &format!("large scene from its {place}"));
            assert!(found.shown * 2 > found.pixels, "{found:?}");
        }
    }
}

/// A wall right in front of the eye, large compared to its distance: areas on the screen and weights of corners reach
/// their maximum.
#[test]
fn normals_of_a_large_wall_in_front_of_the_eye() {
    for distance in [1e-8f32, 1e-7, 1e-6, 1e-4, 1e-2] {
        for width in [1.0, 3.0, 30.0, 1000.0] {
            let half = (distance * width).min(0.5);
            let mut positions =
                vec![[-half, -half, 0.0], [half, -half, 0.0], [half, half, 0.0], [-half, half, 0.0]];
            // A triangle behind the wall makes the scene large.
            positions.extend([[-1.0, -1.0, -1.0], [1.0, -1.0, -1.0], [0.0, 1.0, -1.0]]);
            let slanted = |x: f32, y: f32| OctNormal::encode([x, y, 1.0]);
            let normals = [slanted(-0.5, -0.5), slanted(0.5, -0.5), slanted(0.5, 0.5), slanted(-0.5, 0.5)];
            let mesh = Mesh {
                triangles: vec![[0, 1, 2], [0, 2, 3], [4, 5, 6]],
                normals: Some([&normals[..], &[slanted(0.0, 0.0); 3]].concat()),
                positions,
                ..Mesh::default()
            };
            for near in [None, Some(1e-3 * f64::from(distance)), Some(1e-30)] {
                let camera = Camera {
                    eye: DVec3::new(0.0, 0.0, distance.into()),
                    target: DVec3::ZERO,
                    up: DVec3::new(0.1, 1.0, 0.0),
                    projection: Projection::Perspective { fov_y: 1.0 },
                    near,
                    shift: [0.0; 2],
                };
                for shading in [Shading::Phong, Shading::Gouraud, Shading::Flat] {
                    let what =
                        format!("wall {distance} in front of the eye, {width} times as wide, near {near:?}");
                    check(&[&mesh], &scene(&mesh), &camera, shading, &what);
                }
            }
        }
    }
}

/// A floor as large as the scene, seen from as little as a ten-billionth of its size above: the depths of its two
/// triangles range from the eye to the horizon.
#[test]
fn depths_from_the_eye_to_the_horizon() {
    let mut random = Random(4);
    for height in [2e-6, 0.002, 0.02, 0.2, 2.0, 20.0] {
        let corners =
            [[-10_000.0f32, -9_000.0], [10_000.0, -10_000.0], [9_000.0, 10_000.0], [-10_000.0, 8_000.0]];
        let positions = corners.map(|[x, z]| [x, 0.0, z]).to_vec();
        let mesh = Mesh { positions, triangles: vec![[0, 1, 2], [0, 2, 3]], ..Mesh::default() };
        for _ in 0..4 {
            let eye = DVec3::new(random.between(-1.0, 1.0), height, random.between(-1.0, 1.0));
            let target = eye + DVec3::new(random.between(-0.2, 0.2), random.between(-0.4, 0.2), -1.0);
            let up = DVec3::new(random.between(-1.0, 1.0), 1.0, 0.0);
            let projection = Projection::Perspective { fov_y: 1.0 };
            let camera = Camera { eye, target, up, projection, near: None, shift: [0.0; 2] };
            check(&[&mesh], &scene(&mesh), &camera, Shading::Flat, &format!("floor {height} below"));
        }
    }
}

#[test]
fn real_models() {
    for path in ["obj/stanford-bunny.obj", "stl/featuretype.STL", "obj/cow.obj", "ply/stratocaster.ply"] {
        let Some(data) = require_shared("real_models") else { return };
        let mesh = real_model(&data, path);
        let (center, radius) = (mesh.bounds().center(), mesh.bounds().radius());
        let eye = center + DVec3::new(0.4, 0.3, 0.9).normalize() * radius * 1.6;
        let camera = perspective(eye.to_array(), center.to_array(), 45.0);
        let mut scene = scene(&mesh);
        scene.instances[0].surface.use_mesh_colors = false;
        let frame = draw(&scene, &camera, &settings(Shading::Phong));
        Truth::new(&[&mesh], &scene, &camera, Shading::Phong, SIZE).check(&frame, path);
    }
}
