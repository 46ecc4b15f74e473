//! Every path draws the same picture: the same bytes as the reference.

mod common;

use common::*;
use glam::DVec3;
use tercio_mesh::{Mesh, OctNormal};
use tercio_raster::frame::Pixel;
use tercio_raster::tally;
use tercio_raster::{Cull, Frame, Part, Renderer, Settings, Shading, SimdLevel, Sorting, TileSet, reference};
use tercio_scene::{Camera, Light, Scene};

fn check_every_path(mesh: &Mesh, camera: &Camera, settings: &Settings, what: &str) {
    check_paths(mesh, camera, settings, &[(3, 1, None), (10, 17, Some(1)), (64, 128, Some(2))], what);
}

#[test]
fn a_soup_that_crosses_every_plane() {
    let mesh = soup(100_000, 1);
    check_every_path(
        &mesh,
        &perspective([0.1, 0.2, 0.3], [1.0, 0.0, -1.0], 75.0),
        &everything(211, 157),
        "inside",
    );
}

#[test]
fn a_soup_seen_by_an_orthographic_camera() {
    let mesh = soup(20_000, 2);
    check_every_path(
        &mesh,
        &orthographic([0.2, 0.3, 0.5], [0.0, 0.0, 0.0], 1.5),
        &everything(160, 200),
        "ortho",
    );
}

#[test]
fn a_sphere_from_outside_and_inside() {
    let mesh = sphere(40);
    check_every_path(&mesh, &perspective([1.0, 2.0, 3.0], [0.0; 3], 35.0), &everything(300, 200), "outside");
    check_every_path(
        &mesh,
        &perspective([0.1, 0.2, 0.3], [1.0, 0.0, 0.0], 90.0),
        &everything(300, 200),
        "inside",
    );
}

#[test]
fn tiny_pictures() {
    let mesh = soup(3_000, 3);
    let camera = perspective([0.5, 1.0, 3.0], [0.0; 3], 40.0);
    for (w, h) in [(1, 1), (3, 5), (31, 33)] {
        check_every_path(&mesh, &camera, &everything(w, h), &format!("{w}x{h}"));
    }
}

#[test]
fn every_shading_and_every_culling() {
    let mesh = soup(2_000, 4);
    let bare = Mesh { normals: None, vertex_colors: None, ..sphere(12) };
    let camera = perspective([0.5, 1.0, 3.0], [0.0; 3], 40.0);
    for (mesh, name) in [(&mesh, "soup"), (&bare, "bare sphere")] {
        let plain = scene(mesh);
        for shading in [Shading::Flat, Shading::Gouraud, Shading::Phong, Shading::Unlit] {
            for cull in [Cull::Auto, Cull::None, Cull::Back, Cull::Front] {
                let settings = Settings { shading, cull, ..everything(120, 90) };
                let expected = draw_reference(mesh, &plain, &camera, &settings);
                for simd in SimdLevel::available() {
                    let s = Settings { simd: Some(simd), ..settings.clone() };
                    let what = format!("{name}, {shading:?}, {cull:?}, {simd}");
                    assert_same(&expected, &draw(&plain, &camera, &s), &what);
                }
            }
        }
    }
}

/// Draws pictures that need 8-bit colours only, for which kernels are specialized, with and without highlights, binned by
/// clusters and by triangles, at every SIMD level, and expects the reference's bytes.
fn check_colours(mesh: &Mesh, mut scene: Scene, camera: &Camera, settings: &Settings, what: &str) {
    for (specular, shininess_log2) in [(0.0, 5), (0.2, 5), (0.2, 4)] {
        let surface = &mut scene.instances[0].surface;
        (surface.specular, surface.shininess_log2) = (specular, shininess_log2);
        let expected = draw_reference(mesh, &scene, camera, settings);
        for simd in SimdLevel::available() {
            for sorting in [Sorting::Clusters, Sorting::Triangles] {
                let s = Settings { simd: Some(simd), sorting, ..settings.clone() };
                let what = format!("{what}, specular {specular}, {simd}, {sorting:?}");
                assert_same(&expected, &draw(&scene, camera, &s), &what);
            }
        }
    }
}

/// A square sheet of `n` times `n` quads of two triangles, with these normals on the side that faces z or away from it.
fn sheet(n: u32, is_front: bool, mut normal: impl FnMut() -> DVec3) -> Mesh {
    let mut mesh = Mesh::default();
    let mut normals = Vec::new();
    let front = if is_front { 1.0 } else { -1.0 };
    for (i, j) in (0..=n).flat_map(|i| (0..=n).map(move |j| (i, j))) {
        let [x, y] = [i, j].map(|k| k as f32 / n as f32 - 0.5);
        mesh.positions.push([x, y, 0.05 * (x * y)]);
        let normal = normal();
        normals
            .push(OctNormal::encode((normal.with_z(normal.z.abs().max(0.1)) * front).as_vec3().to_array()));
    }
    let at = |i: u32, j: u32| i * (n + 1) + j;
    for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
        let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        let two = [[a, b, c], [a, c, d]];
        mesh.triangles.extend(two.map(|[a, b, c]| if is_front { [a, b, c] } else { [a, c, b] }));
    }
    mesh.normals = Some(normals);
    mesh
}

/// Sheets with slanted normals, seen from all sides and at grazing angles: where normals point away from the viewer or
/// triangles show their backs, the specialized kernel for colours only must bend normals as the reference does.
#[test]
fn slanted_normals_with_colours_only() {
    let mut random = Random(21);
    for sheet in 0..24 {
        let lean = random.point(1.0);
        let spread = random.between(0.0, 0.6);
        let normal = || DVec3::new(lean.x, lean.y, 0.15) * 1.2 + random.point(1.0) * spread;
        let mesh = self::sheet(12, sheet % 2 == 0, normal);
        let mut plain = scene(&mesh);
        if sheet % 3 == 0 {
            plain.instances[0].world_from_object = glam::DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0));
        }
        for view in 0..6 {
            // Mostly at grazing angles, from above and below.
            let away = random.point(1.0).with_z(random.between(-0.25, 0.25));
            let far = random.between(0.7, 2.0);
            let eye = away.normalize() * far;
            let degrees = random.between(30.0, 120.0);
            let camera = perspective(eye.to_array(), [0.0; 3], degrees);
            let settings = Settings::one_sample(160, 120);
            check_colours(&mesh, plain.clone(), &camera, &settings, &format!("sheet {sheet}, view {view}"));
        }
    }
}

/// Concentric spheres: all but the outermost are hidden from outside.
fn onion(layers: u32) -> Mesh {
    let sphere = sphere(24);
    let mut mesh = Mesh { normals: Some(Vec::new()), ..Mesh::default() };
    for layer in 0..layers {
        let radius = 1.0 - 0.05 * layer as f32;
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(sphere.positions.iter().map(|p| p.map(|c| c * radius)));
        mesh.normals.as_mut().expect("normals").extend(sphere.normals.iter().flatten());
        mesh.triangles.extend(sphere.triangles.iter().map(|t| t.map(|v| v + first)));
    }
    mesh
}

#[test]
fn hidden_clusters_change_nothing() {
    let mesh = onion(8);
    let plain = scene(&mesh);
    let mut hidden = 0;
    for camera in [
        perspective([1.0, 2.0, 3.0], [0.0; 3], 35.0),
        perspective([0.2, 0.1, 0.3], [1.0, 0.0, 0.0], 80.0),
        orthographic([1.0, 2.0, 3.0], [0.0; 3], 2.5),
    ] {
        let settings = everything(400, 300);
        let expected = draw_reference(&mesh, &plain, &camera, &settings);
        let found = draw(&plain, &camera, &settings);
        assert_same(&expected, &found, "onion");
        hidden += found.stats.backend.clusters_hidden;
    }
    assert!(hidden > 100, "only {hidden} clusters are hidden");
}

#[test]
fn a_tile_shared_by_threads() {
    let mesh = onion(12);
    let plain = scene(&mesh);
    let camera = perspective([10.0, 20.0, 300.0], [0.0; 3], 20.0);
    let settings = everything(150, 150);
    let expected = draw_reference(&mesh, &plain, &camera, &settings);
    for threads in [1, 2, 3, 7] {
        let found = with_threads(threads, || draw(&plain, &camera, &settings));
        assert_same(&expected, &found, &format!("{threads} threads"));
    }
}

#[test]
fn two_instances() {
    let mesh = soup(2_000, 5);
    let both = with_second_instance(scene(&mesh));
    let camera = perspective([0.5, 1.0, 3.0], [0.0; 3], 40.0);
    for cull in [Cull::Auto, Cull::Back] {
        let settings = Settings { cull, ..everything(200, 150) };
        let expected = draw_reference(&mesh, &both, &camera, &settings);
        for simd in SimdLevel::available() {
            let s = Settings { simd: Some(simd), ..settings.clone() };
            assert_same(&expected, &draw(&both, &camera, &s), &format!("{cull:?}, {simd}"));
        }
    }
}

#[test]
fn clusters_culled_by_their_cone_change_nothing() {
    let mesh = sphere(60);
    let plain = scene(&mesh);
    let cameras = [
        perspective([1.0, 2.0, 3.0], [0.0; 3], 35.0),
        perspective([0.0, 0.0, 1.3], [0.0, 0.0, 0.0], 60.0),
        orthographic([1.0, 2.0, 3.0], [0.0; 3], 2.5),
    ];
    let mut culled = 0;
    for camera in &cameras {
        for cull in [Cull::Back, Cull::Front] {
            for (width, height) in [(900, 700), (90, 70)] {
                let settings = Settings { cull, ..everything(width, height) };
                let expected = draw_reference(&mesh, &plain, camera, &settings);
                let found = draw(&plain, camera, &settings);
                culled += found.stats.frontend.clusters_facing;
                assert_same(&expected, &found, &format!("{cull:?}, {width}x{height}"));
            }
        }
    }
    assert!(culled > 100, "only {culled} clusters are culled by their cone");
}

/// The look of a specialized kernel: colours only, vertex normals, directional lights, no highlights.
#[test]
fn plain_pictures() {
    let mut bumpy = sphere(30);
    let mut random = Random(7);
    for (p, normal) in bumpy.positions.iter_mut().zip(bumpy.normals.iter_mut().flatten()) {
        *p = p.map(|c| c * random.between(0.9, 1.1) as f32);
        if random.next() < 0.1 {
            *normal = OctNormal::encode(random.point(1.0).as_vec3().to_array());
        }
    }
    for (mesh, what) in [(sphere(40), "smooth"), (bumpy, "bumpy"), (sphere(6), "large triangles")] {
        for camera in [
            perspective([1.0, 2.0, 3.0], [0.0; 3], 35.0),
            perspective([0.2, 0.3, 0.1], [1.0; 3], 90.0),
            orthographic([1.0, 2.0, 3.0], [0.0; 3], 2.5),
        ] {
            check_colours(&mesh, scene(&mesh), &camera, &Settings::one_sample(300, 200), what);
        }
    }
}

/// Clusters of about the maximum size of a small cluster; many of their triangles are too large for edge functions of
/// 32 bits.
#[test]
fn wide_clusters() {
    let mut random = Random(9);
    let mut mesh = Mesh::default();
    for t in 0..60 {
        mesh.positions.extend((0..3).map(|_| random.point(1.0).as_vec3().to_array()));
        mesh.triangles.push([3 * t, 3 * t + 1, 3 * t + 2]);
    }
    for height in [2.1, 2.5, 4.0] {
        let camera = Camera { up: DVec3::Y, ..orthographic([0.0, 0.0, 3.0], [0.0; 3], height) };
        let settings = Settings { tile_size: Some(128), ..everything(280, 256) };
        let stats = draw(&scene(&mesh), &camera, &settings).stats;
        assert_eq!(stats.frontend.clusters_out, stats.frontend.clusters_in);
        for cull in [Cull::None, Cull::Back, Cull::Front] {
            check_every_path(&mesh, &camera, &Settings { cull, ..settings.clone() }, &format!("{cull:?}"));
        }
    }
}

/// Clusters of about the maximum size of a small cluster with smaller triangles, and with triangles of just the size from which
/// the specialized kernels cannot shade them, 128 pixels.
#[test]
fn wide_clusters_with_colours_only() {
    let mut random = Random(33);
    // The edge of a quad is 249 / n pixels long, or 128 pixels, and 1.6 sub-pixels more or less.
    let exact = [2.0 - 1e-4, 2.0, 2.0 + 1e-4].map(|height| (1, height));
    let smaller = [1, 2, 3, 6].map(|n| (n, 256.0 / 249.0));
    for (n, height) in exact.into_iter().chain(smaller) {
        let camera = Camera { up: DVec3::Y, ..orthographic([0.0, 0.0, 3.0], [0.0; 3], height) };
        for is_front in [true, false] {
            let mesh = sheet(n, is_front, || random.point(0.4) + DVec3::Z);
            let settings = Settings { tile_size: Some(128), ..Settings::one_sample(280, 256) };
            let what = format!("{n} quads, height {height}, front {is_front}");
            let scene = scene(&mesh);
            let work = tally::count(&scene, &camera, &settings, 1).expect("a picture");
            assert_eq!(work.stats.frontend.clusters_out, 1, "{what}");
            let details = work.details;
            assert!(details.shadings > 1_000, "{what}: {details:?}");
            let expected = if n == 1 && height <= 2.0 { details.shadings } else { 0 };
            assert_eq!(details.shadings_wide, expected, "{what}");
            check_colours(&mesh, scene.clone(), &camera, &settings, &what);
            let samples = Settings { tile_size: Some(128), ..Settings::new(280, 256) };
            check_colours(&mesh, scene, &camera, &samples, &format!("{what}, several samples"));
        }
    }
}

#[test]
fn parts_of_the_clusters_make_up_the_picture() {
    let mesh = soup(6_000, 6);
    let both = with_second_instance(scene(&mesh));
    let camera = perspective([0.1, 0.2, 0.3], [1.0, 0.0, -1.0], 75.0);
    let settings = everything(211, 157);
    let expected = draw(&both, &camera, &settings);
    let mut composed = expected.clone();
    for y in 0..157 {
        let row = y as usize * 211..(y as usize + 1) * 211;
        composed.planes.fill(row, &Pixel::of_background(&both.background, y, 157));
    }
    for number in 0..5 {
        let clusters = Part { number, of: 5 }.range(both.cluster_count() as u32).into();
        let part = draw(&both, &camera, &Settings { clusters, ..settings.clone() });
        for pixel in 0..part.planes.keys.len() {
            if part.planes.keys[pixel] > composed.planes.keys[pixel] {
                let mut bytes = Vec::new();
                part.planes.write_bytes(&settings.outputs, pixel..pixel + 1, &mut bytes);
                composed.planes.read_bytes(&settings.outputs, &bytes, pixel..pixel + 1);
            }
        }
    }
    assert_same(&expected, &composed, "5 parts");
}

#[test]
fn parts_of_the_tiles_make_up_the_picture() {
    let mesh = soup(6_000, 7);
    let both = with_second_instance(scene(&mesh));
    for camera in
        [perspective([0.1, 0.2, 0.3], [1.0, 0.0, -1.0], 75.0), perspective([1.0, 2.0, 9.0], [0.0; 3], 35.0)]
    {
        for tile_size in [8, 64] {
            let settings = Settings { tile_size: Some(tile_size), ..everything(211, 157) };
            let expected = draw(&both, &camera, &settings);
            let tiles = 211u32.div_ceil(tile_size) as usize * 157u32.div_ceil(tile_size) as usize;
            let (mut frame, mut renderer) = (Frame::default(), Renderer::new());
            let mut elsewhere = 0;
            for number in 0..5 {
                let settings = Settings { tiles: TileSet::every(5, number, tiles), ..settings.clone() };
                renderer.render_into(&both, &camera, &settings, &mut frame).expect("a picture");
                elsewhere += frame.stats.frontend.clusters_elsewhere;
            }
            assert_same(&expected, &frame, "5 parts");
            assert!(elsewhere > 0, "no cluster was skipped in any part");
        }
    }
}

/// Infinite light times a cosine of zero would be no colour. The largest numbers are drawn as the reference draws them.
#[test]
fn light_is_finite() {
    let mesh = sphere(12);
    let camera = perspective([1.0, 2.0, 3.0], [0.0; 3], 35.0);
    let settings = Settings::one_sample(64, 64);
    let changes: [fn(&mut Scene, f32); 3] = [
        |scene, v| scene.lights = vec![Light::headlight([v; 3]), Light::headlight([0.5; 3])],
        |scene, v| scene.instances[0].surface.specular = v,
        |scene, v| scene.instances[0].surface.base_color = [v, 0.0, v],
    ];
    for (change, name) in changes.into_iter().zip(["colour of a light", "specular", "colour of a surface"]) {
        let mut bright = scene(&mesh);
        change(&mut bright, f32::MAX);
        let expected = draw_reference(&mesh, &bright, &camera, &settings);
        for simd in SimdLevel::available() {
            let s = Settings { simd: Some(simd), ..settings.clone() };
            assert_same(&expected, &draw(&bright, &camera, &s), &format!("{name}, {simd}"));
        }
        for value in [f32::INFINITY, f32::NAN] {
            let mut broken = scene(&mesh);
            change(&mut broken, value);
            let errors = [
                Renderer::new().render(&broken, &camera, &settings).err(),
                reference::render(&[&mesh], &broken, &camera, &settings).err(),
            ];
            for error in errors {
                let message = error.expect("an error").to_string();
                assert!(message.contains(name), "{message}");
            }
        }
    }
}
