//! Ambient occlusion, compared with rays in `f64`.

mod common;

use common::*;
use glam::DVec3;
use tercio_effects::AmbientOcclusion;
use tercio_mesh::Mesh;
use tercio_raster::{Frame, RenderError, Settings, SimdLevel};
use tercio_scene::{Background, Camera, Scene};
use tercio_testkit::ray_caster::RayCaster;

/// The share of light that ambient occlusion leaves in each pixel: that of a white unlit surface.
fn left(scene: &Scene, camera: &Camera, settings: &Settings, occlusion: AmbientOcclusion) -> Frame {
    let (mut frame, settings) = draw(scene, camera, settings);
    occlusion.apply(&mut frame, scene, camera, &settings).expect("valid settings");
    frame
}

/// The same from rays: of those that leave the surface with the cosine as density, the ones that hit nothing within the
/// radius; a hit at the share s of it takes 1 - s^2.
fn by_rays(caster: &RayCaster, at: DVec3, normal: DVec3, radius: f64) -> f64 {
    const RINGS: usize = 12;
    const ROUND: usize = 24;
    let side = if normal.x.abs() < 0.8 { DVec3::X } else { DVec3::Y };
    let tangent = normal.cross(side).normalize();
    let bitangent = normal.cross(tangent);
    let mut hidden = 0.0;
    for ring in 0..RINGS {
        let sine = ((ring as f64 + 0.5) / RINGS as f64).sqrt();
        for round in 0..ROUND {
            let (s, c) = ((round as f64 + 0.5) / ROUND as f64 * std::f64::consts::TAU).sin_cos();
            let direction = (tangent * c + bitangent * s) * sine + normal * (1.0 - sine * sine).sqrt();
            // Depths have 24 bits: the surface itself is not hit.
            let origin = at + normal * (1e-4 * radius);
            let hit = caster.first_hit(origin.to_array(), direction.to_array(), 1e-4 * radius);
            let share = hit.map_or(1.0, |hit| (hit.distance / radius).min(1.0));
            hidden += 1.0 - share * share;
        }
    }
    1.0 - hidden / (RINGS * ROUND) as f64
}

#[test]
fn it_is_close_to_that_of_rays() {
    let ball = ball();
    let mesh = room();
    for (mesh, what) in [(&mesh, "room"), (&ball, "ball")] {
        let plain = scene(mesh);
        let camera = perspective([0.4, 0.7, 3.2], [0.0, -0.1, -0.5], 42.0);
        let occlusion = AmbientOcclusion { radius: 0.3, strength: 1.0 };
        let (width, height) = (120, 90);
        let frame = left(&plain, &camera, &Settings::one_sample(width, height), occlusion);
        let corners = mesh.triangles.iter().map(|t| t.map(|v| mesh.positions[v as usize].map(f64::from)));
        let caster = RayCaster::new(corners.collect());
        let radius = occlusion.radius * plain.bounds().radius();
        let basis = camera.basis().expect("a camera");
        let scale = 0.5 * f64::from(height) / (42f64.to_radians() * 0.5).tan();
        let (mut sum, mut signed, mut off, mut count, mut darkest) = (0.0, 0.0, 0, 0, 1.0f64);
        for (index, depth) in frame.planes.depth.iter().enumerate().filter(|(_, d)| d.is_finite()) {
            let [x, y] = [index % width as usize, index / width as usize].map(|c| c as f64 + 0.5);
            let along = basis.forward + basis.right * ((x - 0.5 * f64::from(width)) / scale)
                - basis.up * ((y - 0.5 * f64::from(height)) / scale);
            let at = camera.eye + along * f64::from(*depth);
            let normal = DVec3::from(frame.planes.normals[index].map(f64::from));
            let expected = by_rays(&caster, at, normal, radius);
            let difference = (f64::from(frame.planes.linear[index][0]) - expected).abs();
            (sum, count) = (sum + difference, count + 1);
            signed += f64::from(frame.planes.linear[index][0]) - expected;
            off += usize::from(difference > 0.1);
            darkest = darkest.min(expected);
        }
        let (mean, off) = (sum / f64::from(count), off as f64 / f64::from(count));
        println!(
            "{what}: {count} pixels, mean difference {mean:.4}, {off:.4} of them off by 0.1, darkest {darkest:.2}, too bright by {:.4}",
            signed / f64::from(count)
        );
        // What is hidden from the camera is not known, and there are few points.
        assert!(count > 2000 && mean < 0.06 && off < 0.2, "{what}: {mean} {off}");
        assert!((what == "ball") == (darkest > 0.9), "{what}: {darkest}");
    }
}

#[test]
fn all_planes_are_darkened_alike_and_the_background_is_not() {
    let mut plain = scene(&room());
    plain.background = Background::Solid([0.3, 0.5, 0.7, 0.5]);
    let camera = into_room();
    let settings = Settings::new(120, 90);
    let with = |strength| left(&plain, &camera, &settings, AmbientOcclusion { radius: 0.3, strength }).planes;
    let (whole, half, none) = (with(1.0), with(0.5), with(0.0));
    let mut darkened = 0;
    for index in 0..whole.depth.len() {
        let [whole_light, half_light, light] = [&whole, &half, &none].map(|p| p.linear[index]);
        if whole.depth[index].is_infinite() {
            assert_eq!((whole.color[index], whole.linear[index]), (none.color[index], none.linear[index]));
            continue;
        }
        darkened += usize::from(whole_light[0] < 0.9 * light[0]);
        for k in 0..3 {
            assert!((0.5 * (whole_light[k] + light[k]) - half_light[k]).abs() < 1e-6, "{index}");
            assert!((i32::from(whole.color16[index][k] / 257) - i32::from(whole.color[index][k])).abs() <= 1);
        }
        assert_eq!(whole_light[3], light[3]);
    }
    assert!(darkened > 300, "{darkened}");
}

/// The picture of a scene of another size is the same.
#[test]
fn it_does_not_depend_on_units() {
    let mesh = room();
    let camera =
        |scale: f64| perspective([0.4 * scale, 0.7 * scale, 4.2 * scale], [0.0, 0.0, -0.5 * scale], 42.0);
    let scaled = |scale: f32| {
        let positions = mesh.positions.iter().map(|p| p.map(|c| c * scale)).collect();
        scene(&Mesh { positions, ..mesh.clone() })
    };
    let color = |scale: f32| {
        let frame =
            left(&scaled(scale), &camera(scale.into()), &Settings::new(60, 45), AmbientOcclusion::default());
        frame.planes.color
    };
    let expected = color(1.0);
    for scale in [0.0625, 1024.0, 1.0 / (1u64 << 40) as f32] {
        assert!(color(scale) == expected, "{scale}");
    }
}

#[test]
fn settings_that_are_none_are_errors() {
    let plain = scene(&ball());
    let camera = perspective([0.0, 0.0, 4.0], [0.0; 3], 42.0);
    let (mut frame, settings) = draw(&plain, &camera, &Settings::new(8, 8));
    for (radius, strength) in
        [(0.0, 1.0), (-1.0, 1.0), (2.1, 1.0), (f64::NAN, 1.0), (1.0, -0.1), (1.0, 1.1), (1.0, f32::NAN)]
    {
        let occlusion = AmbientOcclusion { radius, strength };
        let error = occlusion.apply(&mut frame, &plain, &camera, &settings).expect_err("no picture");
        assert!(matches!(error, RenderError::Setting { .. }), "{error}");
    }
}

/// Every level, and any number of threads, gives the same bytes.
#[test]
fn every_simd_level_gives_the_same_picture() {
    let plain = scene(&room());
    for (camera, what) in
        [(into_room(), "perspective"), (orthographic([0.5, 0.4, 4.0], [0.0; 3], 2.4), "orthographic")]
    {
        // Sizes that are no multiples of 16, or odd.
        for (width, height) in [(101, 67), (33, 48), (1, 1), (16, 2)] {
            let of = |simd| {
                left(
                    &plain,
                    &camera,
                    &Settings { simd, ..Settings::new(width, height) },
                    AmbientOcclusion::default(),
                )
            };
            let expected = of(None);
            for level in SimdLevel::available() {
                let difference = of(Some(level)).difference(&expected);
                assert_eq!(difference, None, "{what}, {width} x {height}, {level}");
            }
        }
    }
}

/// A part of a picture that is drawn by itself differs only where what occludes it is outside.
#[test]
fn there_are_no_seams() {
    let plain = scene(&room());
    let draw = |width, height, projected: f64| {
        let camera = orthographic([1.6, 1.4, 3.2], [0.1, -0.6, -0.8], projected);
        left(
            &plain,
            &camera,
            &Settings::one_sample(width, height),
            AmbientOcclusion { radius: 0.1, strength: 1.0 },
        )
    };
    // 4 pixels of the pattern are left out on each side, 40 pixels in all, with pixels of the same size.
    let (whole, part) = (draw(160, 160, 2.0), draw(80, 80, 1.0));
    let (mut count, mut darkened) = (0, 0);
    // The radius is 13 pixels, and the pattern reaches 4 more.
    for y in 18..62 {
        for x in 18..62 {
            let (own, of_whole) =
                (part.planes.linear[y * 80 + x][0], whole.planes.linear[(y + 40) * 160 + x + 40][0]);
            assert!((own - of_whole).abs() < 1e-4, "({x}, {y}): {own} {of_whole}");
            count += 1;
            darkened += usize::from(own < 0.9);
        }
    }
    assert!(darkened > count / 50, "{darkened} of {count}");
}

/// The left part of a picture, drawn by a camera with a shift, differs only where what occludes it is outside.
#[test]
fn it_follows_the_shift_of_a_camera() {
    let plain = scene(&room());
    let occlusion = AmbientOcclusion { radius: 0.05, strength: 1.0 };
    let camera = into_room();
    let wide = left(&plain, &camera, &Settings::one_sample(220, 90), occlusion);
    let shifted = Camera { shift: [50.0 / 90.0, 0.0], ..camera };
    let part = left(&plain, &shifted, &Settings::one_sample(120, 90), occlusion);
    let mut darkened = 0;
    for y in 0..90 {
        for x in 0..105 {
            let (own, of_wide) = (part.planes.linear[y * 120 + x][0], wide.planes.linear[y * 220 + x][0]);
            assert!((own - of_wide).abs() < 1e-3, "({x}, {y}): {own} {of_wide}");
            darkened += usize::from(own < 0.9);
        }
    }
    assert!(darkened > 100, "{darkened}");
}
