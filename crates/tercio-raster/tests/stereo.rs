//! Shifted cameras, and the stereo pairs made of them: every path draws the bytes of the reference, the picture is the
//! right one, and parallax is what the formula says.

mod common;
mod truth;

use std::sync::Arc;

use common::*;
use glam::DVec3;
use tercio_mesh::{Aabb, Mesh};
use tercio_raster::frame::{NO_PRIMITIVE, Planes};
use tercio_raster::view::View;
use tercio_raster::{Cull, Frame, Outputs, RenderError, Renderer, Settings, Shading, ShadowArea, ShadowMaps};
use tercio_scene::camera::CameraError;
use tercio_scene::{Background, Camera, Light, LightSpace, Scene, Stereo};
use truth::Truth;

/// Shifts by fractions of a sub-pixel, and one that has the line of sight outside of the picture.
const SHIFTS: [[f64; 2]; 4] = [[0.031, 0.0], [-0.217, 0.113], [0.5, -0.5], [-1.3, 0.9]];

/// Outside and inside of a soup, and parallel.
fn cameras() -> [Camera; 3] {
    [
        perspective([0.5, 1.0, 3.0], [0.0; 3], 40.0),
        perspective([0.1, 0.2, 0.3], [1.0, 0.0, -1.0], 75.0),
        orthographic([0.5, 1.0, 3.0], [0.0; 3], 2.5),
    ]
}

#[test]
fn every_path_draws_the_same_with_a_shifted_camera() {
    let mesh = soup(2_000, 30);
    for camera in cameras() {
        for shift in SHIFTS {
            let camera = Camera { shift, ..camera };
            let what = format!("{:?} shifted by {shift:?}", camera.projection);
            let partitions = [(3, 1, None), (64, 128, Some(2))];
            check_paths(&mesh, &camera, &everything(90, 67), &partitions, &what);
            let all = Settings { outputs: Outputs::ALL, ..Settings::new(50, 38) };
            check_paths(&mesh, &camera, &all, &[], &format!("{what}, 4 samples"));
        }
    }
}

#[test]
fn layers_lights_and_shadows_with_a_shifted_camera() {
    let mesh = soup(1_500, 31);
    let mut plain = scene(&mesh);
    plain.instances[0].surface.opacity = 0.4;
    let (position, color) = (DVec3::new(0.3, 0.5, 0.2), [0.4, 0.3, 0.2]);
    plain.lights.push(Light::Point { position, space: LightSpace::Camera, color });
    let to_light = DVec3::new(0.2, 1.0, 0.5);
    plain.lights.push(Light::Directional { to_light, space: LightSpace::World, color });
    for camera in &cameras()[..2] {
        let camera = Camera { shift: SHIFTS[1], ..*camera };
        for shading in [Shading::Phong, Shading::Physical] {
            let mut settings = Settings { outputs: Outputs::ALL, shading, ..Settings::new(50, 38) };
            check_all(&mesh, &plain, &camera, &settings, &format!("{shading:?}"));
            let maps =
                ShadowMaps::draw(&plain, &camera, &settings, (64, ShadowArea::Picture)).expect("shadow maps");
            settings.shadows = Some(Arc::new(maps));
            check_all(&mesh, &plain, &camera, &settings, &format!("{shading:?}, shadows"));
        }
    }
}

/// A ray caster in `f64` sees the same.
#[test]
fn a_shifted_picture_is_the_right_one() {
    let size = [96, 72];
    let outputs = Outputs { color: true, depth: true, ids: true, normals: true, ..Outputs::default() };
    for seed in 0..2 {
        let mesh = soup(200, 70 + seed);
        let mut scene = scene(&mesh);
        let (position, space) = (DVec3::new(-1.0, 0.5, -0.2), LightSpace::Camera);
        scene.lights.push(Light::Point { position, space, color: [0.2, 0.1, 0.3] });
        for camera in cameras() {
            // Whole sub-pixels, because the renderer rounds to them.
            for shift in [[17.0, -5.0], [-3000.0, 2001.0]] {
                let shift = shift.map(|subpixels: f64| subpixels / (72.0 * 256.0));
                let camera = Camera { shift, ..camera };
                for shading in [Shading::Phong, Shading::Flat] {
                    let one = Settings::one_sample(size[0], size[1]);
                    let settings = Settings { outputs, shading, cull: Cull::None, ..one };
                    let frame = draw(&scene, &camera, &settings);
                    let truth = Truth::new(&[&mesh], &scene, &camera, shading, size);
                    truth.check(&frame, &format!("soup {seed}, {shift:?}, {shading:?}"));
                }
            }
        }
    }
}

/// A part of a frame.
fn part(frame: &Frame, [x, y]: [usize; 2], [width, height]: [usize; 2]) -> Frame {
    fn rows<T: Copy>(plane: &[T], stride: usize, [x, y]: [usize; 2], [width, height]: [usize; 2]) -> Vec<T> {
        let rows = plane.chunks(stride).skip(y).take(height);
        rows.flat_map(|row| row[x..x + width].iter().copied()).collect()
    }
    let (stride, at, size) = (frame.width as usize, [x, y], [width, height]);
    let all = &frame.planes;
    let planes = Planes {
        keys: rows(&all.keys, stride, at, size),
        ties: rows(&all.ties, stride, at, size),
        color: rows(&all.color, stride, at, size),
        color16: rows(&all.color16, stride, at, size),
        depth: rows(&all.depth, stride, at, size),
        linear: rows(&all.linear, stride, at, size),
        ids: rows(&all.ids, stride, at, size),
        normals: rows(&all.normals, stride, at, size),
    };
    Frame { width: width as u32, height: height as u32, planes, ..Frame::default() }
}

/// A scene before a plain background: a gradient depends on the height of the picture.
fn before_one_color(mesh: &Mesh) -> Scene {
    let mut scene = scene(mesh);
    scene.background = Background::Solid([0.1, 0.2, 0.3, 1.0]);
    scene
}

#[test]
fn a_shift_by_whole_pixels_shows_a_part_of_a_larger_picture() {
    let mesh = soup(4_000, 32);
    let scene = before_one_color(&mesh);
    for camera in cameras() {
        let wide = draw(&scene, &camera, &everything(200, 64));
        for first in [0, 33, 80] {
            // The middle of the wide picture is at column 100, that of a part at column 60 of the part.
            let shift = [(40.0 - first as f64) / 64.0, 0.0];
            let shifted = draw(&scene, &Camera { shift, ..camera }, &everything(120, 64));
            let expected = part(&wide, [first, 0], [120, 64]);
            assert_same(&expected, &shifted, &format!("{:?}, from column {first}", camera.projection));
        }
    }
    // Upwards: twice the height of an orthographic picture has the same scale to the last bit.
    let tall = draw(&scene, &orthographic([0.5, 1.0, 3.0], [0.0; 3], 4.0), &everything(80, 128));
    for first in [0, 10, 64] {
        let shift = [0.0, (first as f64 - 32.0) / 64.0];
        let camera = Camera { shift, ..orthographic([0.5, 1.0, 3.0], [0.0; 3], 2.0) };
        let expected = part(&tall, [0, first], [80, 64]);
        assert_same(&expected, &draw(&scene, &camera, &everything(80, 64)), &format!("from row {first}"));
    }
}

/// Where a vertex appears in the pictures of both eyes, in sub-pixels, and the scale.
fn eyes_see(stereo: &Stereo, camera: &Camera, scene: &Scene, point: [f32; 3]) -> ([[i32; 2]; 2], f64) {
    let views = stereo.cameras(camera).expect("two cameras").map(|eye| {
        let view = View::new(&eye, &scene.bounds(), 640, 480).expect("a view");
        let vertex = view.object(&scene.instances[0]).project(point);
        assert!(vertex.inside, "{point:?}");
        ([vertex.x, vertex.y], view.scale)
    });
    (views.map(|(at, _)| at), views[0].1)
}

/// A triangle of about 20 pixels around a point, in the plane that faces a camera that looks along -z.
fn target_at([x, y, z]: [f32; 3], reach: f32) -> Mesh {
    let corners = [[-0.9, -1.0], [1.0, -0.8], [0.1, 1.1]];
    let positions = corners.map(|[right, up]| [x + right * reach, y + up * reach, z]).to_vec();
    Mesh { positions, triangles: vec![[0, 1, 2]], ..Mesh::default() }
}

#[test]
fn parallax_is_what_the_formula_says() {
    let camera = Camera { up: DVec3::Y, ..perspective([0.0, 0.0, 10.0], [0.0; 3], 40.0) };
    for (eye_distance, convergence) in [(1.0 / 3.0, 10.0), (0.7, 6.5), (0.4, 25.0)] {
        let stereo = Stereo { eye_distance, convergence };
        for distance in [4.0f32, 6.5, 10.0, 17.0, 60.0] {
            let mesh = target_at([0.11 * distance, -0.07 * distance, 10.0 - distance], 0.015 * distance);
            let scene = scene(&mesh);
            let what = format!("{stereo:?}, distance {distance}");
            let (at, scale) = eyes_see(&stereo, &camera, &scene, mesh.positions[2]);
            let expected = scale * eye_distance * (1.0 / f64::from(distance) - 1.0 / convergence);
            let [left, right] = at;
            // Both corners and both middles are rounded to sub-pixels.
            let found = f64::from(left[0] - right[0]);
            assert!((found - expected).abs() < 2.2, "{what}: {found}, not {expected} sub-pixels");
            assert_eq!(left[1], right[1], "{what}: the same height");
            // The same in the pictures, by their centres of gravity.
            let [left, right] = stereo.cameras(&camera).expect("two cameras").map(|eye| {
                let frame = draw(&scene, &eye, &ids_only(640, 480));
                let shown = (0..640 * 480).filter(|&i| frame.planes.ids[i] != NO_PRIMITIVE);
                let columns: Vec<f64> = shown.map(|i| (i % 640) as f64).collect();
                assert!(columns.len() > 60, "{what}: {} pixels", columns.len());
                columns.iter().sum::<f64>() / columns.len() as f64
            });
            let found = left - right;
            assert!(
                (found - expected / 256.0).abs() < 0.3,
                "{what}: {found}, not {} pixels",
                expected / 256.0
            );
        }
    }
}

#[test]
fn both_eyes_see_the_plane_of_zero_parallax_in_the_same_pixels() {
    let camera = Camera { up: DVec3::Y, ..perspective([0.0, 0.0, 8.0], [0.0; 3], 50.0) };
    let scale = 120.0 * 128.0 / (25f64.to_radians()).tan();
    // Vertices a quarter of a sub-pixel from whole ones, so that no rounding decides where they snap to.
    let mut random = Random(34);
    let mut mesh = Mesh::default();
    for t in 0..300 {
        let middle = [random.between(-90.0, 90.0), random.between(-60.0, 60.0)].map(|c| c * 256.0);
        for _ in 0..3 {
            let at = middle.map(|c| ((c + random.between(-3000.0, 3000.0)).round() + 0.25) * 8.0 / scale);
            mesh.positions.push([at[0] as f32, at[1] as f32, 0.0]);
        }
        mesh.triangles.push([3 * t, 3 * t + 1, 3 * t + 2]);
    }
    let scene = scene(&mesh);
    let alone = draw(&scene, &camera, &ids_only(160, 120));
    for shift_in_subpixels in [1.0, 777.0, 5000.0] {
        let stereo = Stereo { eye_distance: 2.0 * 8.0 * shift_in_subpixels / scale, convergence: 8.0 };
        for eye in stereo.cameras(&camera).expect("two cameras") {
            let frame = draw(&scene, &eye, &ids_only(160, 120));
            assert_same(&alone, &frame, &format!("shifted by {shift_in_subpixels} sub-pixels"));
        }
    }
}

#[test]
fn without_a_distance_both_eyes_see_the_ordinary_picture() {
    let mesh = soup(3_000, 35);
    let scene = scene(&mesh);
    for camera in &cameras()[..2] {
        for settings in [everything(80, 60), Settings { outputs: Outputs::ALL, ..Settings::new(80, 60) }] {
            let alone = draw(&scene, camera, &settings);
            let stereo = Stereo { eye_distance: 0.0, convergence: 2.0 };
            for eye in stereo.cameras(camera).expect("two cameras") {
                assert_same(&alone, &draw(&scene, &eye, &settings), "no distance");
            }
        }
    }
}

#[test]
fn shifts_that_cannot_be_drawn_are_refused() {
    let bounds = Aabb { min: DVec3::splat(-1.0), max: DVec3::splat(1.0) };
    let camera = perspective([0.5, 1.0, 3.0], [0.0; 3], 40.0);
    let view = |shift, width, height| View::new(&Camera { shift, ..camera }, &bounds, width, height);
    let middle = |shift, width, height| view(shift, width, height).map(|view| view.middle);
    assert_eq!(middle([0.0; 2], 65536, 65536), Ok([1 << 23; 2]));
    assert_eq!(middle([0.25, 0.5], 200, 100), Ok([125 * 256, 0]));
    // 32768 pixels are the limit.
    assert!(view([327.0, -327.0], 100, 100).is_ok() && view([-327.0, 327.0], 100, 100).is_ok());
    for shift in [[328.0, 0.0], [-328.0, 0.0], [0.0, 328.0], [0.0, -328.0], [f64::NAN, 0.0], [1e300, 0.0]] {
        let error = view(shift, 100, 100).expect_err("too far");
        assert!(matches!(error, CameraError::OutOfRange { what: "shift", .. }), "{shift:?}: {error}");
    }
    assert!(view([0.01, 0.0], 65536, 100).is_err(), "a picture of the largest width has no room for a shift");
    let scene = scene(&soup(10, 36));
    let error =
        Renderer::new().render(&scene, &Camera { shift: [400.0, 0.0], ..camera }, &everything(99, 99));
    assert!(matches!(error, Err(RenderError::Camera(CameraError::OutOfRange { .. }))));
}
