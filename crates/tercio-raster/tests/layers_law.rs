//! Pictures of surfaces that are not opaque: every path draws the bytes of the reference, and the reference draws what a
//! sort of all layers in `f64` gives.

mod common;

use common::*;
use glam::DVec3;
use tercio_mesh::{FileMaterial, Mesh};
use tercio_raster::{
    Filter, Outputs, RenderError, Renderer, SamplePattern, SampleShading, Sampling, Settings, Shading,
};
use tercio_scene::{Background, Camera, Instance, Scene};

/// Settings for all planes.
fn sampled(pattern: SamplePattern, width: u32, height: u32) -> Settings {
    Settings { sampling: Sampling::of(pattern), ..everything(width, height) }
}

/// Gives the colours of a mesh an alpha: of every third vertex none, of every third one half, of the others all.
fn with_alpha(mut mesh: Mesh) -> Mesh {
    for (v, color) in mesh.vertex_colors.as_mut().expect("colours").iter_mut().enumerate() {
        color[3] = [0, 128, 255][v * 7 / 3 % 3];
    }
    mesh
}

/// Triangles of several colours: by face, or by material.
fn with_triangle_alpha(mesh: Mesh, by_material: bool) -> Mesh {
    let (mut random, n) = (Random(5), mesh.triangles.len());
    if !by_material {
        let colors = (0..n).map(|t| [200, 100, 50, [255, 0, 90, 254][t * 5 / 2 % 4]]).collect();
        return Mesh { face_colors: Some(colors), ..mesh };
    }
    let material = |opacity| FileMaterial { diffuse: [0.9, 0.4, 0.2], opacity, ..FileMaterial::default() };
    let materials = vec![material(1.0), material(0.4), material(0.0), material(f32::NAN)];
    let of_triangle = (0..n).map(|_| (random.next() * 4.5) as u32);
    let of_triangle = of_triangle.map(|m| if m == 4 { Mesh::NO_MATERIAL } else { m }).collect();
    Mesh { vertex_colors: None, materials, triangle_materials: Some(of_triangle), ..mesh }
}

fn with_opacity(mut scene: Scene, opacity: f32) -> Scene {
    scene.instances[0].surface.opacity = opacity;
    scene
}

#[test]
fn a_soup_that_crosses_every_plane() {
    let mesh = soup(6_000, 1);
    let camera = perspective([0.1, 0.2, 0.3], [1.0, 0.0, -1.0], 75.0);
    for pattern in [SamplePattern::Center, SamplePattern::Sparse4, SamplePattern::Sparse16] {
        let plain = with_opacity(scene(&mesh), 0.3);
        check_all(&mesh, &plain, &camera, &sampled(pattern, 71, 57), &format!("inside, {pattern}"));
    }
}

#[test]
fn every_source_of_alpha() {
    let camera = perspective([0.5, 1.0, 3.0], [0.0; 3], 40.0);
    let mesh = soup(3_000, 2);
    for (mesh, what) in [
        (with_alpha(mesh.clone()), "vertices"),
        (with_triangle_alpha(mesh.clone(), false), "faces"),
        (with_triangle_alpha(mesh, true), "materials"),
    ] {
        for (opacity, uses_colors) in [(1.0, true), (0.6, true), (0.6, false)] {
            let mut plain = with_opacity(scene(&mesh), opacity);
            plain.instances[0].surface.use_mesh_colors = uses_colors;
            let what = format!("{what}, opacity {opacity}, {uses_colors}");
            check_all(&mesh, &plain, &camera, &sampled(SamplePattern::Sparse4, 75, 58), &what);
        }
    }
}

#[test]
fn every_sampling_shading_and_plane() {
    let mesh = with_alpha(soup(2_000, 3));
    // An opaque instance among those that are not.
    let mut plain = with_second_instance(scene(&mesh));
    plain.instances[0].surface.use_mesh_colors = false;
    plain.background = Background::Gradient { top: [0.1, 0.9, 0.3, 0.5], bottom: [1.0, 0.0, 0.2, 1.0] };
    let camera = perspective([0.5, 1.0, 3.0], [0.0; 3], 40.0);
    for pattern in SamplePattern::ALL {
        for shading in [SampleShading::Pixel, SampleShading::Sample] {
            for filter in [Filter::Box, Filter::Tent] {
                let sampling = Sampling { pattern, shading, filter };
                let settings = Settings { sampling, tile_size: Some(16), ..everything(55, 38) };
                let expected = draw_reference(&mesh, &plain, &camera, &settings);
                assert_same(&expected, &draw(&plain, &camera, &settings), &format!("{sampling:?}"));
                let s = Settings { layer_memory: 0, ..settings.clone() };
                assert_same(&expected, &draw(&plain, &camera, &s), &format!("{sampling:?}, slices"));
            }
        }
    }
    for shading in [Shading::Flat, Shading::Gouraud, Shading::Phong, Shading::Unlit] {
        let only_color = Outputs { color: true, ..Outputs::NONE };
        let only_ids = Outputs { ids: true, ..Outputs::NONE };
        for outputs in [only_color, only_ids, Outputs { color16: true, normals: true, ..Outputs::NONE }] {
            for settings in [Settings::one_sample(60, 44), Settings::new(60, 44)] {
                let settings = Settings { shading, outputs, ..settings };
                check_all(&mesh, &plain, &camera, &settings, &format!("{shading:?}, {outputs:?}"));
            }
        }
    }
}

/// Fragments of unlit surfaces of one colour are not shaded, but filled: opaque ones and others, also beside those that are lit.
#[test]
fn unlit_surfaces_of_one_colour() {
    let mesh = soup(1_500, 6);
    let camera = perspective([0.5, 1.0, 3.0], [0.0; 3], 40.0);
    for (base_color, opacity) in
        [([0.8, 0.1, 0.3], 1.0), ([0.8, 0.1, 0.3], 0.35), ([1e-9, -1.0, 7.5], 1.0), ([1e-9, 2.0, 0.5], 0.0)]
    {
        let mut scene = with_second_instance(scene(&mesh));
        let surface = &mut scene.instances[0].surface;
        (surface.base_color, surface.use_mesh_colors, surface.unlit) = (base_color, false, true);
        surface.opacity = opacity;
        for pattern in SamplePattern::ALL {
            let outputs = Outputs { color: true, linear: true, ..Outputs::NONE };
            let colors = Settings { outputs, ..sampled(pattern, 60, 44) };
            check_all(&mesh, &scene, &camera, &colors, &format!("{base_color:?}, {opacity}, {pattern}"));
        }
        let all = sampled(SamplePattern::Sparse4, 60, 44);
        check_all(&mesh, &scene, &camera, &all, &format!("{base_color:?}, {opacity}, all planes"));
    }
}

/// Squares across the picture, one behind the other, some of them at the same depth, some beyond the guard band, some
/// through each other.
fn stack(layers: usize) -> Mesh {
    let mut mesh = Mesh { vertex_colors: Some(Vec::new()), ..Mesh::default() };
    let mut random = Random(11);
    for layer in 0..layers {
        let far = ((layer * 37) % layers / 2) as f32 * 0.01;
        let reach = [1.0, 2.0, 4000.0][layer % 3];
        let slant = if layer % 5 == 0 { 0.2 / reach } else { 0.0 };
        let first = mesh.positions.len() as u32;
        for [x, y] in [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]] {
            let [x, y] = [x * reach, y * reach];
            mesh.positions.push([x, y, slant * x - far]);
        }
        let mut color = [random.next(), random.next(), random.next()].map(|c| (c * 256.0) as u8).to_vec();
        color.push(if layer % 7 == 3 { 0 } else { 20 + (random.next() * 200.0) as u8 });
        let color: [u8; 4] = color.try_into().expect("four");
        mesh.vertex_colors.as_mut().expect("colours").extend([color; 4]);
        mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    }
    mesh
}

#[test]
fn hundreds_of_layers() {
    let mesh = stack(300);
    let plain = scene(&mesh);
    for camera in [
        Camera { up: DVec3::Y, ..orthographic([0.0, 0.0, 9.0], [0.0; 3], 1.9) },
        perspective([0.1, 0.2, 3.0], [0.0; 3], 20.0),
        perspective([0.1, 0.2, -1.0], [0.0, 0.5, -4.0], 80.0),
    ] {
        let settings = sampled(SamplePattern::Sparse4, 20, 14);
        check_all(&mesh, &plain, &camera, &settings, "hundreds of layers");
        let by_sample = Sampling { shading: SampleShading::Sample, ..settings.sampling };
        let settings = Settings { sampling: by_sample, ..settings };
        check_all(&mesh, &plain, &camera, &settings, "hundreds of layers, by sample");
    }
}

/// The corners of a triangle as `f64`.
fn corners(mesh: &Mesh, triangle: usize) -> [DVec3; 3] {
    mesh.triangles[triangle].map(|v| DVec3::from(mesh.positions[v as usize].map(f64::from)))
}

/// Every sample of a picture without lighting equals a sort of all triangles by depth, each of which is hit or not by the
/// formulas of `f64`, and a sum of what shines through.
#[test]
fn blending_equals_a_sort_of_all_layers_by_hand() {
    let mut random = Random(21);
    let mut mesh = Mesh { vertex_colors: Some(Vec::new()), ..Mesh::default() };
    for t in 0..120u32 {
        let color = [0; 3].map(|_| (random.next() * 256.0) as u8);
        let alpha = if t % 10 == 0 { 255 } else { (random.next() * 256.0) as u8 };
        for _ in 0..3 {
            let p = random.point(1.0);
            // Corners at middles of sub-pixels of an orthographic picture of 64x64 would be snapped by nothing.
            mesh.positions.push([p.x, p.y, p.z].map(|c| (c * 4096.0).round() as f32 / 4096.0));
            mesh.vertex_colors.as_mut().expect("colours").push([color[0], color[1], color[2], alpha]);
        }
        mesh.triangles.push([3 * t, 3 * t + 1, 3 * t + 2]);
    }
    let mut plain = scene(&mesh);
    let behind = [0.25, 0.5, 0.75, 1.0];
    plain.background = Background::Solid(behind);
    // 2 units are 64 pixels of 256 sub-pixels: corners are at multiples of 2 sub-pixels.
    let camera = Camera { up: DVec3::Y, ..orthographic([0.0, 0.0, 5.0], [0.0; 3], 2.0) };
    let linear = Outputs { linear: true, ..Outputs::NONE };
    let settings = Settings { outputs: linear, shading: Shading::Unlit, ..Settings::one_sample(64, 64) };
    let frame = draw(&plain, &camera, &settings);
    let decode =
        |level: f64| if level <= 0.04045 { level / 12.92 } else { ((level + 0.055) / 1.055).powf(2.4) };
    let (mut layers, mut most) = (0, 0);
    for (index, found) in frame.planes.linear.iter().enumerate() {
        let at = [index % 64, index / 64].map(|c| (c as f64 + 0.5) / 32.0 - 1.0);
        let at = [at[0], -at[1]];
        let mut hits = Vec::new();
        let mut is_near_an_edge = false;
        for t in 0..mesh.triangles.len() {
            let p = corners(&mesh, t);
            let area = |a: DVec3, b: DVec3| (b.x - a.x) * (at[1] - a.y) - (b.y - a.y) * (at[0] - a.x);
            let weights = [area(p[1], p[2]), area(p[2], p[0]), area(p[0], p[1])];
            let sum: f64 = weights.iter().sum();
            is_near_an_edge |= weights.iter().any(|w| w / sum == 0.0);
            if weights.iter().all(|w| w / sum > 0.0) {
                let z: f64 = (0..3).map(|k| weights[k] / sum * p[k].z).sum();
                hits.push((z, mesh.vertex_colors.as_ref().expect("colours")[3 * t]));
            }
        }
        hits.sort_by(|a, b| b.0.total_cmp(&a.0));
        let is_tied = hits.windows(2).any(|pair| pair[0].0 - pair[1].0 < 1e-5);
        if is_near_an_edge || is_tied {
            continue;
        }
        let (mut expected, mut passing) = ([0.0; 4], 1.0);
        for (_, color) in &hits {
            let alpha = f64::from(color[3]) / 255.0;
            for k in 0..3 {
                expected[k] += passing * alpha * decode(f64::from(color[k]) / 255.0);
            }
            expected[3] += passing * alpha;
            passing *= 1.0 - alpha;
        }
        for k in 0..4 {
            let of_background = if k < 3 { decode(f64::from(behind[k])) } else { 1.0 };
            expected[k] += passing * of_background;
            assert!(
                (f64::from(found[k]) - expected[k]).abs() < 2e-6,
                "pixel {index}: {found:?}, not {expected:?}"
            );
        }
        layers += hits.len();
        most = most.max(hits.len());
    }
    assert!(layers > 4096 * 4 && most > 15, "{layers} layers, at most {most}");
}

/// `n` layers of opacity a show the share (1 - a)^n of the background.
#[test]
fn equal_layers_follow_the_closed_formula() {
    for (n, opacity) in [(1, 0.3), (2, 0.3), (10, 0.1), (100, 0.02), (1000, 0.001)] {
        let mut mesh = stack(n);
        mesh.vertex_colors = None;
        let mut plain = with_opacity(scene(&mesh), opacity);
        plain.instances[0].surface.base_color = [1.0, 0.0, 0.5];
        plain.background = Background::Solid([0.0, 1.0, 0.0, 1.0]);
        let camera = Camera { up: DVec3::Y, ..orthographic([0.0, 0.0, 9.0], [0.0; 3], 1.2) };
        let linear = Outputs { linear: true, ..Outputs::NONE };
        let settings = Settings { outputs: linear, shading: Shading::Unlit, ..Settings::new(16, 16) };
        let passing = (1.0 - f64::from(opacity)).powi(n as i32);
        for found in draw(&plain, &camera, &settings).planes.linear {
            let expected = [1.0 - passing, passing, 0.5 * (1.0 - passing), 1.0];
            for k in 0..4 {
                assert!((f64::from(found[k]) - expected[k]).abs() < 1e-4, "{n}: {found:?}, not {expected:?}");
            }
        }
    }
}

/// Both walls of a closed solid are seen, and what is opaque hides everything behind it.
#[test]
fn closed_solids_and_what_is_inside() {
    let ball = sphere(16);
    let mut plain = with_opacity(scene(&ball), 0.3);
    let camera = perspective([0.0, 0.0, 5.0], [0.0; 3], 30.0);
    let linear = Outputs { linear: true, ids: true, ..Outputs::NONE };
    let settings = Settings { outputs: linear, shading: Shading::Unlit, ..Settings::one_sample(63, 63) };
    plain.background = Background::Solid([0.0, 0.0, 0.0, 0.0]);
    let alpha = |plain: &Scene| draw(plain, &camera, &settings).planes.linear[63 * 31 + 31][3];
    assert!((alpha(&plain) - (1.0 - 0.7 * 0.7)).abs() < 1e-6);
    let core = Instance {
        world_from_object: glam::DAffine3::from_scale(DVec3::splat(0.5)),
        surface: Instance::new(plain.instances[0].mesh.clone()).surface,
        ..plain.instances[0].clone()
    };
    plain.instances.push(core);
    let frame = draw(&plain, &camera, &settings);
    let base = plain.instances[1].surface.base_color[0];
    let [red, .., alpha] = frame.planes.linear[63 * 31 + 31];
    assert!((alpha, (red - base).abs() < 1e-6) == (1.0, true), "one wall over the core: {red}, {alpha}");
    // The outer ball is the nearest.
    assert!(frame.planes.ids[63 * 31 + 31] < ball.triangles.len() as u32);
}

/// An opacity of 1 draws the bytes of the opaque picture, also if it is known only when shading.
#[test]
fn full_opacity_is_opaque() {
    let mesh = soup(3_000, 9);
    let camera = perspective([0.5, 1.0, 3.0], [0.0; 3], 40.0);
    let mut marked = mesh.clone();
    // A triangle outside the picture whose alpha makes the others of its cluster layers, too.
    let first = marked.positions.len() as u32;
    marked.positions.extend([[50.0, 0.0, 0.0], [50.0, 1.0, 0.0], [50.0, 0.0, 1.0]]);
    marked.vertex_colors.as_mut().expect("colours").extend([[0, 0, 0, 9]; 3]);
    marked.normals.as_mut().expect("normals").extend_from_within(..3);
    marked.triangles.push([first, first + 1, first + 2]);
    for settings in [everything(80, 60), sampled(SamplePattern::Sparse8, 80, 60)] {
        let expected = draw(&scene(&mesh), &camera, &settings);
        let mut plain = scene(&marked);
        // Lights follow the view volume: only the mesh differs.
        plain.lights = scene(&mesh).lights;
        let found = draw(&plain, &camera, &settings);
        assert_eq!(found.planes.color, expected.planes.color);
        assert_eq!(found.planes.ids, expected.planes.ids);
    }
}

#[test]
fn frames_do_not_affect_later_frames() {
    let mesh = soup(2_000, 4);
    let camera = perspective([0.5, 1.0, 3.0], [0.0; 3], 40.0);
    let mut renderer = Renderer::new();
    let mut frame =
        |plain: &Scene, settings: &Settings| renderer.render(plain, &camera, settings).expect("a picture");
    let clear = with_opacity(scene(&mesh), 0.4);
    // One thread has the memory of all tiles.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    let sixteen = Settings { sampling: Sampling::of(SamplePattern::Sparse16), ..Settings::new(40, 40) };
    let one = Settings::one_sample(90, 30);
    for settings in [Settings::new(60, 40), one.clone(), Settings::new(20, 70), one, sixteen] {
        for plain in [&clear, &scene(&mesh), &clear] {
            let found = pool.install(|| frame(plain, &settings));
            assert_same(&draw(plain, &camera, &settings), &found, "later frames");
        }
    }
}

#[test]
fn opacities_beyond_0_to_1_are_errors() {
    let mesh = soup(10, 1);
    let camera = perspective([0.5, 1.0, 3.0], [0.0; 3], 40.0);
    for opacity in [-0.1, 1.1, f32::NAN, f32::INFINITY] {
        let plain = with_opacity(scene(&mesh), opacity);
        let error = Renderer::new().render(&plain, &camera, &Settings::new(8, 8)).expect_err("no picture");
        assert!(matches!(error, RenderError::Setting { what: "opacity of a surface", .. }), "{error}");
    }
}
