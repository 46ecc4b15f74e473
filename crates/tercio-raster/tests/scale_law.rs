//! The scale law: a model scaled by any power of two in the range of `f32` gives the same picture, byte for byte, and
//! distances scaled by that power.

mod common;

use common::*;
use glam::DVec3;
use tercio_mesh::mesh::power_of_two;
use tercio_mesh::{Mesh, clean, normals};
use tercio_raster::{Frame, Outputs, RenderError, Renderer, SamplePattern, Sampling, Settings, Shading};
use tercio_scene::{Camera, Framing, Light, LightSpace, Projection};

const SIZE: [u32; 2] = [160, 120];

/// Makes coordinates whole numbers below 2^12: even times 2^-149, the smallest number of `f32`, they are exact.
fn whole_numbers(mesh: &Mesh) -> Mesh {
    let positions = mesh.positions.iter().map(|p| p.map(|c| (c * 2000.0).round())).collect();
    Mesh { positions, normals: None, vertex_colors: None, ..mesh.clone() }
}

fn scaled(mesh: &Mesh, exponent: i32) -> Mesh {
    let mut scaled = mesh.clone();
    scaled.positions =
        mesh.positions.iter().map(|p| p.map(|c| (f64::from(c) * power_of_two(exponent)) as f32)).collect();
    let cleaned = clean::clean(&mut scaled);
    assert_eq!(cleaned.total(), 0, "times 2^{exponent}: {cleaned:?}");
    scaled
}

/// 8-bit and 16-bit colour, triangle, bits of the normal.
type Pixel = ([u8; 4], [u16; 4], u32, [u32; 3]);

fn pixels(frame: &Frame) -> Vec<Pixel> {
    (0..frame.planes.ids.len())
        .map(|p| {
            (
                frame.planes.color[p],
                frame.planes.color16[p],
                frame.planes.ids[p],
                frame.planes.normals[p].map(f32::to_bits),
            )
        })
        .collect()
}

/// How a model is drawn.
#[derive(Clone, Copy)]
struct Look {
    pattern: SamplePattern,
    opacity: f32,
}

#[track_caller]
fn check(mesh: &Mesh, exponents: &[i32], what: &str) {
    check_look(mesh, exponents, Look { pattern: SamplePattern::Center, opacity: 1.0 }, what);
}

#[track_caller]
fn check_look(mesh: &Mesh, exponents: &[i32], look: Look, what: &str) {
    let mut refused = 0;
    let mut picture = |exponent: i32, view: usize, shading: Shading| {
        let mut mesh = scaled(mesh, exponent);
        normals::make_normals(&mut mesh, Some(0.8));
        let mut scene = scene(&mesh);
        scene.instances[0].surface.opacity = look.opacity;
        scene.lights.push(Light::Point {
            position: DVec3::new(3000.0, 1000.0, 5000.0) * power_of_two(exponent),
            space: LightSpace::World,
            color: [0.2, 0.3, 0.1],
        });
        let framing = Framing::new(SIZE[0], SIZE[1]);
        let camera = match view {
            0 => framing.camera_for_scene(&scene),
            1 => Framing { fov_y: None, ..framing }.camera_for_scene(&scene),
            // From inside.
            _ => Camera {
                eye: DVec3::new(100.0, 50.0, 20.0) * power_of_two(exponent),
                target: DVec3::new(-500.0, 150.0, 900.0) * power_of_two(exponent),
                up: DVec3::Y,
                projection: Projection::Perspective { fov_y: 1.2 },
                near: None,
                shift: [0.0; 2],
            },
        };
        let mut outputs = Outputs { keys: false, ..everything(1, 1).outputs };
        let sampling = Sampling::of(look.pattern);
        let mut settings = Settings { outputs, shading, sampling, ..Settings::one_sample(SIZE[0], SIZE[1]) };
        if let Err(error) = Renderer::new().render(&scene, &camera, &settings) {
            let RenderError::Distances { farthest } = error else {
                panic!("{what} times 2^{exponent}: {error}")
            };
            assert!(!(farthest as f32).is_normal(), "{what} times 2^{exponent}: {error}");
            refused += 1;
            outputs.depth = false;
            settings.outputs = outputs;
        }
        let reference = draw_reference(&mesh, &scene, &camera, &settings);
        let frame = draw(&scene, &camera, &settings);
        assert_same(&reference, &frame, &format!("{what} times 2^{exponent}"));
        frame
    };
    for view in 0..3 {
        for shading in [Shading::Phong, Shading::Flat] {
            let plain = picture(0, view, shading);
            let shown = plain.planes.ids.iter().filter(|&&id| id != u32::MAX).count();
            assert!(shown * 8 > plain.planes.ids.len(), "{what}: only {shown} pixels show a triangle");
            for &exponent in exponents {
                let frame = picture(exponent, view, shading);
                let what = format!("{what} times 2^{exponent}, view {view}, {shading:?}");
                let (a, b) = (pixels(&plain), pixels(&frame));
                let different = a.iter().zip(&b).filter(|(a, b)| a != b).count();
                assert_eq!(different, 0, "{what}: pixels differ");
                for (a, b) in plain.planes.depth.iter().zip(&frame.planes.depth) {
                    // Small distances may be subnormal numbers.
                    let expected = (f64::from(*a) * power_of_two(exponent)) as f32;
                    assert!(*b == expected || !expected.is_normal(), "{what}: distances {b}, not {expected}");
                }
            }
        }
    }
    assert!(refused > 0, "{what}: no scale was refused, but some distances are outside the range of `f32`");
}

/// A mesh that was not processed by `clean` is refused if its coordinates are outside the valid range of `f32`; the
/// error message suggests a solution.
#[test]
fn coordinates_out_of_range_are_refused() {
    for exponent in [-120, -61, 61, 100] {
        let mut mesh = sphere(2);
        for p in &mut mesh.positions {
            *p = p.map(|c| (f64::from(c) * power_of_two(exponent)) as f32);
        }
        let scene = scene(&mesh);
        let camera = Framing::default().camera_for_scene(&scene);
        let error =
            Renderer::new().render(&scene, &camera, &Settings::one_sample(64, 64)).expect_err("out of range");
        assert!(error.to_string().contains("Mesh::bring_into_range"), "{error}");
        let largest = mesh.positions.iter().flatten().fold(0.0f32, |most, c| most.max(c.abs()));
        mesh.bring_into_range(largest);
        let scene = common::scene(&mesh);
        Renderer::new().render(&scene, &camera, &Settings::one_sample(64, 64)).expect("a picture");
    }
}

/// A vertex that no triangle uses, or only a dropped one, has no influence on the unit.
#[test]
fn unused_vertices_do_not_matter() {
    for (size, far) in
        [(1.0f32, 1e19f32), (1.0, 3e38), (1e-20, 1.0), (1e-30, 1e30), (1e30, 1e-30), (1.0, 1e-38)]
    {
        let positions = vec![[0.0; 3], [size, 0.0, 0.0], [0.0, size, 0.0], [far, 0.0, 0.0]];
        let mut mesh = Mesh { positions, triangles: vec![[0, 1, 2], [3, 3, 1]], ..Mesh::default() };
        assert_eq!(clean::clean(&mut mesh).total(), 1);
        assert!(mesh.positions.iter().flatten().all(|c| c.is_finite()), "{:?}", mesh.positions);
        let scene = scene(&mesh);
        let camera = Framing::default().camera_for_scene(&scene);
        let frame = draw(&scene, &camera, &ids_only(64, 64));
        let shown = frame.planes.ids.iter().filter(|&&id| id != u32::MAX).count();
        assert!(shown > 500, "triangle of {size}, vertex at {far}: {shown} pixels");
    }
}

#[test]
fn dense_meshes() {
    // 2^-149 to 2^116: the largest coordinate is 2^11.
    check(&whole_numbers(&sphere(40)), &[-149, -140, -120, -80, -41, -3, 5, 41, 80, 105, 116], "sphere");
}

#[test]
fn a_few_large_triangles() {
    check(&whole_numbers(&sphere(1)), &[-149, -125, -60, 60, 110, 116], "octahedron");
}

#[test]
fn soups() {
    check(&whole_numbers(&soup(900, 8)), &[-149, -100, 100, 114], "soup");
}

/// With several samples per pixel, and where surfaces are seen through each other.
#[test]
fn samples_and_layers() {
    let opaque = whole_numbers(&sphere(6));
    let mut random = Random(3);
    let alpha = opaque.positions.iter().map(|_| [200, 120, 90, (random.next() * 256.0) as u8]).collect();
    let with_alpha = Mesh { vertex_colors: Some(alpha), ..opaque.clone() };
    let exponents = [-149, 114];
    for (mesh, pattern, opacity, name) in [
        (&opaque, SamplePattern::default(), 1.0, "opaque"),
        (&opaque, SamplePattern::default(), 0.4, "opacity 0.4"),
        (&with_alpha, SamplePattern::Sparse16, 0.8, "alpha of vertices"),
    ] {
        check_look(mesh, &exponents, Look { pattern, opacity }, &format!("{name}, {pattern:?}"));
    }
    let layers = Look { pattern: SamplePattern::Center, opacity: 0.3 };
    check_look(&whole_numbers(&soup(300, 9)), &exponents, layers, "soup with an opacity of 0.3");
}
