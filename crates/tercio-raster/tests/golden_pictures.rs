//! Golden pictures, which were inspected by eye. Lights and surface are defined here, so that the pictures do not
//! depend on the defaults.

mod common;

use std::sync::Arc;

use common::{orthographic, perspective};
use glam::DVec3;
use tercio_mesh::cluster::{PartitionOptions, partition};
use tercio_mesh::{Mesh, builtin};
use tercio_raster::{Cull, Filter, Renderer, SamplePattern, Sampling, Settings, Shading};
use tercio_scene::{Background, Camera, Instance, Light, LightSpace, Scene, Surface};
use tercio_testkit::golden;

const WHITE: Background = Background::Solid([1.0; 4]);
const GREY: Background = Background::Solid([0.5, 0.52, 0.55, 1.0]);

fn make(name: &str) -> Mesh {
    builtin::make(&format!("builtin:{name}")).expect("a built-in model")
}

/// A clay surface under a warm key light from the upper left, a cool fill light from the right, and some ambient light.
fn lit(mesh: Mesh, background: Background) -> Scene {
    let from = |x, y, z, color| Light::Directional {
        to_light: DVec3::new(x, y, z),
        space: LightSpace::Camera,
        color,
    };
    let lights = vec![
        Light::Ambient { color: [0.08, 0.08, 0.10] },
        from(-0.5, 0.7, 0.6, [0.85, 0.80, 0.72]),
        from(0.9, 0.0, 0.4, [0.12, 0.15, 0.20]),
    ];
    let surface = Surface { base_color: [0.60, 0.50, 0.42], specular: 0.25, ..Surface::default() };
    let mesh = Arc::new(partition(mesh, &PartitionOptions::default()));
    Scene {
        instances: vec![Instance { surface, ..Instance::new(mesh) }],
        lights,
        background,
        ..Scene::default()
    }
}

/// A camera that looks at the middle of the scene's box from this direction, this many radii away.
fn at_box(scene: &Scene, from: [f64; 3], radii: f64, degrees: f64) -> Camera {
    let bounds = scene.bounds();
    let (center, away) = (bounds.center(), DVec3::from(from).normalize() * bounds.radius() * radii);
    Camera { up: DVec3::Y, ..perspective((center + away).to_array(), center.to_array(), degrees) }
}

#[track_caller]
fn check(topic: &str, name: &str, scene: &Scene, camera: &Camera, settings: &Settings) {
    let frame = Renderer::new().render(scene, camera, settings).expect("a picture");
    golden::check(topic, name, frame.width, frame.height, frame.planes.color.as_flattened());
}

#[test]
fn golden_shading() {
    let scene = lit(make("teapot@2k"), GREY);
    let camera = at_box(&scene, [0.3, 0.5, 1.0], 3.0, 36.0);
    let kinds = [
        ("flat", Shading::Flat),
        ("gouraud", Shading::Gouraud),
        ("phong", Shading::Phong),
        ("unlit", Shading::Unlit),
    ];
    for (name, shading) in kinds {
        check("shading", name, &scene, &camera, &Settings { shading, ..Settings::one_sample(192, 128) });
    }
}

#[test]
fn golden_shading_point_light() {
    let mut scene = lit(make("sphere@20k"), GREY);
    let position = DVec3::new(1.5, 1.5, 1.5);
    scene.lights = vec![Light::Point { position, space: LightSpace::World, color: [0.9, 0.9, 0.9] }];
    let camera = at_box(&scene, [0.0, 0.0, 1.0], 3.0, 40.0);
    check("shading", "point_light", &scene, &camera, &Settings::one_sample(160, 120));
}

/// Spokes thinner than a pixel, and a coarse sphere.
#[test]
fn golden_samples() {
    let mut spokes = Mesh::default();
    for spoke in 0..29u32 {
        let (sin, cos) = (f64::from(spoke) * std::f64::consts::TAU / 29.0).sin_cos();
        let at = |along: f64, across: f64| {
            [(cos * along - sin * across) as f32, (sin * along + cos * across) as f32, 0.0]
        };
        spokes.positions.extend([at(0.12, -0.004), at(1.0, -0.012), at(1.0, 0.012)]);
        spokes.triangles.push([3 * spoke, 3 * spoke + 1, 3 * spoke + 2]);
    }
    let sphere = lit(make("sphere@200"), GREY);
    let mut scene = lit(spokes, Background::Gradient { top: [1.0; 4], bottom: [0.4, 0.5, 0.7, 1.0] });
    scene.instances.push(Instance {
        world_from_object: glam::DAffine3::from_scale(DVec3::splat(0.3)),
        ..sphere.instances[0].clone()
    });
    let camera = Camera { up: DVec3::Y, ..orthographic([0.0, 0.0, 3.0], [0.0; 3], 2.1) };
    let tent = Sampling { filter: Filter::Tent, ..Sampling::of(SamplePattern::Sparse4) };
    let patterns = SamplePattern::ALL.into_iter().map(|p| (p.name().to_owned(), Sampling::of(p)));
    for (name, sampling) in patterns.chain([("4_tent".to_owned(), tent)]) {
        check("samples", &name, &scene, &camera, &Settings { sampling, ..Settings::new(96, 96) });
    }
}

/// A ball of glass around an opaque teapot; a sheet whose alpha falls from corner to corner, through a coarse sphere.
#[test]
fn golden_layers() {
    let background = Background::Gradient { top: [1.0; 4], bottom: [0.4, 0.5, 0.7, 1.0] };
    let mut scene = lit(make("teapot@2k"), background);
    let camera = at_box(&scene, [0.3, 0.5, 1.0], 3.6, 36.0);
    let (center, radius) = (scene.bounds().center(), scene.bounds().radius());
    let mut ball = lit(make("sphere@2k"), background).instances.remove(0);
    ball.world_from_object =
        glam::DAffine3::from_scale_rotation_translation(DVec3::splat(radius), glam::DQuat::IDENTITY, center);
    ball.surface.opacity = 0.3;
    scene.instances.push(ball);
    check("layers", "glass", &scene, &camera, &Settings::new(160, 120));

    let sheet = Mesh {
        positions: vec![[-1.2, -1.0, 0.0], [1.2, -1.0, 0.0], [1.2, 1.0, 0.0], [-1.2, 1.0, 0.0]],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        vertex_colors: Some(vec![
            [200, 30, 30, 255],
            [30, 200, 30, 170],
            [30, 30, 200, 0],
            [200, 200, 30, 85],
        ]),
        ..Mesh::default()
    };
    let mut scene = lit(sheet, background);
    let mut sphere = lit(make("sphere@200"), background).instances.remove(0);
    sphere.world_from_object = glam::DAffine3::from_scale(DVec3::splat(0.6));
    sphere.surface.opacity = 0.6;
    scene.instances.push(sphere);
    let camera = at_box(&scene, [0.6, 0.3, 1.0], 3.0, 36.0);
    check("layers", "through_each_other", &scene, &camera, &Settings::new(160, 120));
}

#[test]
fn golden_camera() {
    let scene = lit(make("teapot@20k"), GREY);
    let settings = Settings::one_sample(192, 128);
    check("camera", "iso", &scene, &at_box(&scene, [1.0, 0.8, 1.0], 3.0, 36.0), &settings);
    let center = scene.bounds().center();
    let eye = center + DVec3::new(0.0, 10.0, 0.0);
    let top = orthographic(eye.to_array(), center.to_array(), scene.bounds().radius() * 1.6);
    check("camera", "top_orthographic", &scene, &Camera { up: DVec3::NEG_Z, ..top }, &settings);
    // From inside out through the opening, past the rim.
    let inside = perspective((center - DVec3::Y * 0.3).to_array(), (center + DVec3::ONE).to_array(), 100.0);
    check("camera", "inside", &scene, &Camera { up: DVec3::Y, ..inside }, &settings);
}

#[test]
fn golden_camera_above_terrain() {
    let scene = lit(make("terrain@20k"), Background::Solid([0.6, 0.75, 0.95, 1.0]));
    let low = perspective([0.0, 0.45, 0.6], [0.0, 0.1, -0.6], 60.0);
    check(
        "camera",
        "above_terrain",
        &scene,
        &Camera { up: DVec3::Y, ..low },
        &Settings::one_sample(256, 160),
    );
}

#[test]
fn golden_culling() {
    let scene = lit(make("teapot@20k"), GREY);
    let camera = at_box(&scene, [0.3, 0.9, 1.0], 3.0, 36.0);
    for (name, cull) in [("back", Cull::Back), ("front", Cull::Front)] {
        check("culling", name, &scene, &camera, &Settings { cull, ..Settings::one_sample(192, 128) });
    }
}

#[test]
fn golden_colors() {
    let terrain = lit(make("terrain@20k"), WHITE);
    let camera = at_box(&terrain, [0.5, 0.8, 1.0], 2.6, 40.0);
    check("colors", "of_vertices", &terrain, &camera, &Settings::one_sample(192, 144));
    let mut soup = lit(make("soup@500"), WHITE);
    let camera = at_box(&soup, [0.2, 0.3, 1.0], 2.8, 40.0);
    check("colors", "of_faces", &soup, &camera, &Settings::one_sample(192, 144));
    soup.instances[0].surface.use_mesh_colors = false;
    check("colors", "base", &soup, &camera, &Settings::one_sample(192, 144));
}

#[test]
fn golden_background() {
    let kinds = [
        ("solid", Background::Solid([0.1, 0.2, 0.5, 1.0])),
        ("gradient", Background::Gradient { top: [0.9, 0.6, 0.3, 1.0], bottom: [0.1, 0.1, 0.4, 1.0] }),
        ("transparent", Background::Solid([0.0; 4])),
        ("fading", Background::Gradient { top: [0.0, 0.5, 0.0, 0.0], bottom: [0.0, 0.5, 0.0, 1.0] }),
    ];
    for (name, background) in kinds {
        let scene = lit(make("gyroid@10k"), background);
        let camera = at_box(&scene, [0.6, 0.5, 1.0], 3.2, 40.0);
        check("background", name, &scene, &camera, &Settings::one_sample(160, 120));
    }
}

#[test]
fn golden_tiny() {
    let scene = lit(make("teapot@20k"), WHITE);
    let camera = at_box(&scene, [0.3, 0.5, 1.0], 3.0, 36.0);
    for (w, h) in [(16, 12), (5, 3)] {
        check("tiny", &format!("{w}x{h}"), &scene, &camera, &Settings::one_sample(w, h));
    }
}
