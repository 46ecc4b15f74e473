//! Tone mapping and light from an environment: every path draws the bytes of the reference, and the light is that of the
//! formulas.

mod common;

use std::sync::Arc;

use common::*;
use glam::{DMat3, DVec3};
use tercio_raster::{Outputs, RenderError, SamplePattern, Sampling, Settings, Shading, Tone, ToneCurve};
use tercio_scene::{Environment, Light, LightSpace, Panorama, Scene};

const CURVES: [ToneCurve; 4] = [ToneCurve::Clip, ToneCurve::Reinhard, ToneCurve::Filmic, ToneCurve::Neutral];

/// Bright from above and from the right, coloured.
fn environment(axes: DMat3) -> Arc<Environment> {
    let pixels = (0..32 * 64).map(|i| {
        let [right, down] = [i % 64, i / 64].map(|c| c as f32);
        [3.0 - 0.09 * down, 0.02 * right, if down < 4.0 { 5.0 } else { 0.1 }]
    });
    let panorama = Panorama::new(64, 32, pixels.collect()).expect("a panorama");
    Arc::new(Environment::new(&panorama, axes, 1.0).expect("light in range"))
}

fn bright(scene: &mut Scene) {
    let (space, color) = (LightSpace::World, [2.0, 3.0, 1.0]);
    scene.lights.push(Light::Directional { to_light: DVec3::new(0.3, 1.0, 0.2), space, color });
}

#[test]
fn every_path_draws_the_tones_of_the_reference() {
    let mesh = soup(1_500, 3);
    let camera = perspective([0.5, 1.0, 3.0], [0.0; 3], 40.0);
    let mut scene = with_second_instance(scene(&mesh));
    bright(&mut scene);
    for (number, curve) in CURVES.into_iter().enumerate() {
        let tone = Tone { exposure: 1.3, curve };
        let shading = [Shading::Phong, Shading::Flat, Shading::Gouraud, Shading::Physical][number];
        let four = Sampling::of(SamplePattern::Sparse4);
        for settings in [everything(70, 50), Settings { sampling: four, ..everything(51, 38) }] {
            let settings = Settings { shading, tone, ..settings };
            check_all(&mesh, &scene, &camera, &settings, &format!("{curve:?}, {shading:?}"));
        }
    }
    // The look of most pictures: its kernel does not map tones.
    let tone = Tone { exposure: 0.5, curve: ToneCurve::Neutral };
    let plain = Settings { tone, ..Settings::new(60, 40) };
    check_all(&mesh, &scene, &camera, &plain, "default look");
    scene.instances[0].surface.opacity = 0.4;
    check_all(&mesh, &scene, &camera, &Settings { tone, ..everything(60, 40) }, "not opaque");
}

#[test]
fn every_path_draws_the_environment_of_the_reference() {
    let mesh = soup(1_500, 4);
    let camera = perspective([0.5, 1.0, 3.0], [0.0; 3], 40.0);
    let mut scene = with_second_instance(scene(&mesh));
    scene.lights.clear();
    scene.environment = Some(environment(DMat3::from_rotation_y(0.4)));
    for shading in [Shading::Phong, Shading::Gouraud, Shading::Physical] {
        for roughness in [0.0, 0.2, 0.9] {
            for instance in &mut scene.instances {
                instance.surface.roughness = roughness;
                instance.surface.metallic = roughness;
            }
            let settings = Settings { shading, ..everything(70, 50) };
            check_all(&mesh, &scene, &camera, &settings, &format!("{shading:?}, {roughness}"));
        }
    }
    bright(&mut scene);
    check_all(&mesh, &scene, &camera, &Settings::new(60, 40), "with a light");
}

/// What a mapped picture shows is the curve of what the same picture shows without, as far as that is not clipped.
#[test]
fn tones_are_those_of_the_curve() {
    let mesh = sphere(16);
    let mut scene = scene(&mesh);
    scene.background = tercio_scene::Background::Solid([0.2, 0.4, 0.6, 1.0]);
    let camera = perspective([0.5, 1.0, 3.0], [0.0; 3], 40.0);
    let outputs = Outputs { linear: true, ids: true, ..Outputs::NONE };
    let plain = Settings { outputs, ..Settings::one_sample(64, 48) };
    let before = draw(&scene, &camera, &plain);
    for curve in CURVES {
        let tone = Tone { exposure: 0.7, curve };
        let after = draw(&scene, &camera, &Settings { tone, ..plain.clone() });
        let mut count = 0;
        for (index, (before_tone, found)) in before.planes.linear.iter().zip(&after.planes.linear).enumerate()
        {
            let &[r, g, b, _] = before_tone;
            if before.planes.ids[index] == tercio_raster::frame::NO_PRIMITIVE {
                assert_eq!(before_tone, found, "the background is not mapped");
            } else if r.max(g).max(b) < 1.0 {
                let expected = tone.map([r, g, b]);
                let is_near = (0..3).all(|k| (found[k] - expected[k].min(1.0)).abs() < 1e-6);
                assert!(is_near, "{curve:?}, pixel {index}: {found:?}, not {expected:?}");
                count += 1;
            }
        }
        assert!(count > 400, "{count}");
        let unlit =
            |tone| draw(&scene, &camera, &Settings { tone, shading: Shading::Unlit, ..plain.clone() });
        assert_eq!(unlit(tone).difference(&unlit(Tone::NONE)), None, "unlit colours are not mapped");
    }
    let tone = Tone { exposure: 0.0, curve: ToneCurve::Clip };
    let error = Settings { tone, ..plain }.check().expect_err("no light");
    assert!(matches!(error, RenderError::Setting { what: "exposure", .. }), "{error}");
}

/// A white diffuse sphere shows the integral of the panorama over the hemisphere around its normals; a mirror shows the
/// panorama in the direction of the mirrored line of sight.
#[test]
fn spheres_show_what_is_around_them() {
    let mesh = sphere(40);
    let mut scene = scene(&mesh);
    scene.lights.clear();
    let environment = environment(DMat3::IDENTITY);
    scene.environment = Some(environment.clone());
    let surface = &mut scene.instances[0].surface;
    surface.base_color = [0.3; 3];
    surface.specular = 0.0;
    let camera = perspective([0.5, 1.0, 3.0], [0.0; 3], 40.0);
    let outputs = Outputs { linear: true, normals: true, ..Outputs::NONE };
    let settings = Settings { outputs, ..Settings::one_sample(64, 48) };
    let diffuse = draw(&scene, &camera, &settings);
    let surface = &mut scene.instances[0].surface;
    (surface.base_color, surface.metallic, surface.roughness) = ([0.15; 3], 1.0, 0.0);
    let mirror = draw(&scene, &camera, &Settings { shading: Shading::Physical, ..settings });
    let basis = camera.basis().expect("axes");
    let scale = 24.0 / 20f64.to_radians().tan();
    let mut count = 0;
    for (index, normal) in diffuse.planes.normals.iter().enumerate().filter(|(_, n)| **n != [0.0; 3]) {
        let normal = DVec3::from(normal.map(f64::from));
        let [x, y] = [index % 64, index / 64].map(|c| c as f64 + 0.5);
        let sight = basis.forward + basis.right * ((x - 32.0) / scale) - basis.up * ((y - 24.0) / scale);
        let sight = sight.normalize();
        let mirrored = sight - normal * (2.0 * sight.dot(normal));
        let around = environment.mirrored(mirrored.as_vec3().to_array(), 0.05);
        // Fresnel's term makes the rim brighter.
        let fresnel = 0.15 + (0.95 - 0.15) * (1.0 + sight.dot(normal)).max(0.0).powi(5);
        for k in 0..3 {
            let light = 0.3 * environment.diffuse()[k].at(normal);
            let shown = f64::from(diffuse.planes.linear[index][k]);
            assert!((shown - light.clamp(0.0, 1.0)).abs() < 1e-4, "{index}: {shown}, not {light}");
            let light = (fresnel * f64::from(around[k])).clamp(0.0, 1.0);
            let shown = f64::from(mirror.planes.linear[index][k]);
            assert!((shown - light).abs() < 0.01, "mirror, {index}, {k}: {shown}, not {light}");
        }
        count += 1;
    }
    assert!(count > 500, "{count}");
}
