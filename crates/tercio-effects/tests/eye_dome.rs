//! Eye-dome lighting, compared with its formula.

mod common;

use common::*;
use tercio_effects::EyeDome;
use tercio_mesh::Mesh;
use tercio_raster::{Frame, RenderError, Settings, SimdLevel};
use tercio_scene::{Camera, Scene};

/// The share of light that is left in each pixel of a white surface.
fn left(scene: &Scene, camera: &Camera, settings: &Settings, eye_dome: EyeDome) -> Frame {
    let (mut frame, settings) = draw(scene, camera, settings);
    eye_dome.apply(&mut frame, scene, camera, &settings).expect("valid settings");
    frame
}

/// A square of side 4, with slope `slope` to the right: farther away on the left side.
fn slanted(slope: f32) -> Mesh {
    let corner = |x: f32, y: f32| [x, y, slope * x];
    let positions = vec![corner(-2.0, -2.0), corner(2.0, -2.0), corner(2.0, 2.0), corner(-2.0, 2.0)];
    Mesh { positions, triangles: vec![[0, 1, 2], [0, 2, 3]], ..Mesh::default() }
}

/// On a plane of an orthographic picture, three of eight neighbours are nearer: by the slope, or its share along a diagonal.
#[test]
fn a_plane_is_darkened_by_its_slope() {
    for slope in [0.0, 0.5, 2.0] {
        for strength in [1.0, 2.5] {
            let camera = orthographic([0.0, 0.0, 9.0], [0.0; 3], 1.0);
            let eye_dome = EyeDome { strength, radius: Some(1) };
            let frame = left(&scene(&slanted(slope)), &camera, &Settings::one_sample(64, 64), eye_dome);
            let mean = f64::from(slope) * (1.0 + 2f64.sqrt()) / 8.0;
            let expected = (-0.5 * f64::from(strength) * mean).exp();
            for (index, color) in frame.planes.linear.iter().enumerate() {
                let (x, y) = (index % 64, index / 64);
                // The neighbours of the others are outside the picture, where nothing darkens.
                if (4..60).contains(&x) && (4..60).contains(&y) {
                    let found = f64::from(color[0]);
                    assert!((found - expected).abs() < 0.01, "{slope} {strength}: {found} {expected}");
                }
            }
        }
    }
}

#[test]
fn what_is_behind_a_step_is_dark_and_what_is_before_it_is_not() {
    // A square before another.
    let mut mesh = slanted(0.0);
    mesh.positions.extend([[-0.2, -0.2, 1.0], [0.2, -0.2, 1.0], [0.2, 0.2, 1.0], [-0.2, 0.2, 1.0]]);
    mesh.triangles.extend([[4, 5, 6], [4, 6, 7]]);
    let camera = orthographic([0.0, 0.0, 9.0], [0.0; 3], 1.0);
    let frame = left(&scene(&mesh), &camera, &Settings::one_sample(100, 100), EyeDome::default());
    let light = |x: usize, y: usize| frame.planes.linear[y * 100 + x][0];
    // The square has pixels 30 to 69.
    for y in 35..65 {
        assert!(light(29, y) < 0.6, "{}", light(29, y));
        assert_eq!([light(30, y), light(50, y), light(20, y)], [1.0; 3]);
    }
}

#[test]
fn the_background_keeps_its_bytes_and_the_look_does_not_depend_on_units_or_levels() {
    let mesh = room();
    let of = |scale: f64, simd| {
        let positions = mesh.positions.iter().map(|p| p.map(|c| c * scale as f32)).collect();
        let camera = perspective([0.4 * scale, 0.7 * scale, 4.2 * scale], [0.0, 0.0, -0.5 * scale], 42.0);
        let scene = scene(&Mesh { positions, ..mesh.clone() });
        let settings = Settings { simd, ..Settings::new(75, 50) };
        (left(&scene, &camera, &settings, EyeDome::default()), draw(&scene, &camera, &settings).0)
    };
    let (expected, plain) = of(1.0, None);
    let mut darkened = 0;
    for index in 0..plain.planes.depth.len() {
        let (own, before) = (expected.planes.linear[index], plain.planes.linear[index]);
        if plain.planes.depth[index].is_infinite() {
            assert_eq!((own, expected.planes.color[index]), (before, plain.planes.color[index]));
        }
        darkened += usize::from(own[0] < 0.9 * before[0]);
    }
    assert!(darkened > 200, "{darkened}");
    for scale in [1.0 / 1024.0, 64.0] {
        assert!(of(scale, None).0.planes.color == expected.planes.color, "{scale}");
    }
    for level in SimdLevel::available() {
        assert_eq!(of(1.0, Some(level)).0.difference(&expected), None, "{level}");
    }
}

#[test]
fn settings_that_are_none_are_errors() {
    let plain = scene(&ball());
    let camera = perspective([0.0, 0.0, 4.0], [0.0; 3], 42.0);
    let (mut frame, settings) = draw(&plain, &camera, &Settings::new(8, 8));
    for (strength, radius) in
        [(-1.0, None), (f32::NAN, None), (f32::INFINITY, None), (1.0, Some(0)), (1.0, Some(65))]
    {
        let error = EyeDome { strength, radius }
            .apply(&mut frame, &plain, &camera, &settings)
            .expect_err("no picture");
        assert!(matches!(error, RenderError::Setting { .. }), "{error}");
    }
}
