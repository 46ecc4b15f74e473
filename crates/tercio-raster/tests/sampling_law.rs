//! Pictures with several samples per pixel: every path draws the bytes of the reference.

mod common;

use common::*;
use glam::DVec3;
use tercio_mesh::{Mesh, OctNormal};
use tercio_raster::{
    Cull, Filter, Frame, LastStage, Outputs, Renderer, SamplePattern, SampleShading, Sampling, Settings,
    Shading, SimdLevel, Sorting,
};
use tercio_scene::{Background, Camera, Projection};

/// Every pattern, shading and filter.
fn all_samplings() -> impl Iterator<Item = Sampling> {
    let shadings = [SampleShading::Pixel, SampleShading::Sample];
    let filters = [Filter::Box, Filter::Tent];
    SamplePattern::ALL.into_iter().flat_map(move |pattern| {
        shadings.into_iter().flat_map(move |shading| {
            filters.into_iter().map(move |filter| Sampling { pattern, shading, filter })
        })
    })
}

fn check_every_path(mesh: &Mesh, camera: &Camera, settings: &Settings, what: &str) {
    check_paths(mesh, camera, settings, &[(3, 1, None), (64, 128, Some(2))], what);
}

#[test]
fn a_soup_that_crosses_every_plane() {
    let mesh = soup(20_000, 1);
    let camera = perspective([0.1, 0.2, 0.3], [1.0, 0.0, -1.0], 75.0);
    for pattern in [SamplePattern::Sparse4, SamplePattern::Sparse16] {
        let settings = Settings { sampling: Sampling::of(pattern), ..everything(111, 87) };
        check_every_path(&mesh, &camera, &settings, &format!("inside, {pattern}"));
    }
}

#[test]
fn every_sampling() {
    let mesh = soup(4_000, 2);
    let plain = with_second_instance(scene(&mesh));
    let camera = perspective([0.5, 1.0, 3.0], [0.0; 3], 40.0);
    for sampling in all_samplings() {
        for tile_size in [8, 32] {
            let settings = Settings { sampling, tile_size: Some(tile_size), ..everything(75, 58) };
            let expected = draw_reference(&mesh, &plain, &camera, &settings);
            for sorting in [Sorting::Clusters, Sorting::Triangles] {
                let settings = Settings { sorting, ..settings.clone() };
                let what = format!("{sampling:?}, {sorting:?}, tiles of {tile_size}");
                assert_same(&expected, &draw(&plain, &camera, &settings), &what);
            }
        }
    }
}

/// Colours only, for which a kernel is specialized, with every look that leads to another kernel.
#[test]
fn colours_only() {
    let bare = Mesh { normals: None, ..sphere(12) };
    for (mesh, what) in [(&sphere(40), "small triangles"), (&sphere(5), "large triangles"), (&bare, "bare")] {
        for camera in [
            perspective([1.0, 2.0, 3.0], [0.0; 3], 35.0),
            perspective([0.2, 0.3, 0.1], [1.0; 3], 90.0),
            orthographic([1.0, 2.0, 3.0], [0.0; 3], 2.5),
        ] {
            for specular in [0.0, 0.2] {
                let mut plain = scene(mesh);
                plain.instances[0].surface.specular = specular;
                for shading in [Shading::Flat, Shading::Gouraud, Shading::Phong, Shading::Unlit] {
                    let settings = Settings { shading, ..Settings::new(150, 100) };
                    let expected = draw_reference(mesh, &plain, &camera, &settings);
                    for simd in SimdLevel::available() {
                        for sorting in [Sorting::Clusters, Sorting::Triangles] {
                            let s = Settings { simd: Some(simd), sorting, ..settings.clone() };
                            let what =
                                format!("{what}, specular {specular}, {shading:?}, {simd}, {sorting:?}");
                            assert_same(&expected, &draw(&plain, &camera, &s), &what);
                        }
                    }
                }
            }
        }
    }
}

/// Many layers, most of them drawn from back to front, so that hidden fragments are removed again and again.
#[test]
fn many_layers() {
    let mut mesh = Mesh { normals: Some(Vec::new()), ..Mesh::default() };
    let small = sphere(8);
    for layer in 0..300 {
        let first = mesh.positions.len() as u32;
        let far = 0.001 * layer as f32;
        mesh.positions.extend(small.positions.iter().map(|p| [p[0], p[1], 0.01 * p[2] + far]));
        mesh.normals.as_mut().expect("normals").extend(small.normals.iter().flatten());
        mesh.triangles.extend(small.triangles.iter().map(|t| t.map(|v| v + first)));
    }
    // Triangles so large that they are binned one by one, between the layers.
    let first = mesh.positions.len() as u32;
    for far in [0.05, 0.15, 0.2501] {
        let (corner, reach) = (mesh.positions.len() as u32, 4000.0);
        mesh.positions.extend([[-reach, -0.3, far], [reach, -0.9, far], [0.1, 0.2, far]]);
        mesh.triangles.push([corner, corner + 1, corner + 2]);
    }
    let upwards = OctNormal::encode([0.0, 0.0, 1.0]);
    mesh.normals.as_mut().expect("normals").resize(mesh.positions.len(), upwards);
    assert!(mesh.positions.len() as u32 > first);
    let plain = scene(&mesh);
    let camera = Camera { up: DVec3::Y, ..orthographic([0.0, 0.0, 5.0], [0.0; 3], 2.0) };
    for sampling in [
        Sampling::of(SamplePattern::Sparse2),
        Sampling { shading: SampleShading::Sample, ..Sampling::of(SamplePattern::Sparse4) },
        Sampling { filter: Filter::Tent, ..Sampling::of(SamplePattern::Sparse8) },
    ] {
        let settings = Settings { sampling, tile_size: Some(8), ..everything(24, 24) };
        let expected = draw_reference(&mesh, &plain, &camera, &settings);
        for sorting in [Sorting::Clusters, Sorting::Triangles] {
            for threads in [1, 3] {
                let s = Settings { sorting, ..settings.clone() };
                let found = with_threads(threads, || draw(&plain, &camera, &s));
                assert_same(&expected, &found, &format!("{sampling:?}, {sorting:?}, {threads} threads"));
            }
        }
    }
}

#[test]
fn a_tile_shared_by_threads() {
    let mesh = soup(20_000, 7);
    let plain = scene(&mesh);
    let camera = perspective([10.0, 20.0, 300.0], [0.0; 3], 20.0);
    for sampling in [
        Sampling::of(SamplePattern::Sparse4),
        Sampling { filter: Filter::Tent, ..Sampling::of(SamplePattern::Sparse8) },
    ] {
        let settings = Settings { sampling, ..everything(150, 150) };
        let expected = draw_reference(&mesh, &plain, &camera, &settings);
        for threads in [1, 2, 7] {
            let found = with_threads(threads, || draw(&plain, &camera, &settings));
            assert_same(&expected, &found, &format!("{threads} threads"));
        }
    }
}

#[test]
fn translucent_backgrounds_and_culling() {
    let mesh = sphere(12);
    let camera = perspective([1.0, 2.0, 3.0], [0.0; 3], 35.0);
    for background in [
        Background::Solid([0.0; 4]),
        Background::Solid([0.3, 0.6, 0.9, 0.5]),
        Background::Gradient { top: [1.0, 0.5, 0.2, 0.0], bottom: [0.1, 0.5, 0.2, 1.0] },
    ] {
        let mut plain = scene(&mesh);
        plain.background = background;
        for filter in [Filter::Box, Filter::Tent] {
            for cull in [Cull::Auto, Cull::Back, Cull::Front] {
                let sampling = Sampling { filter, ..Sampling::default() };
                for outputs in [Outputs::ALL, Outputs::default()] {
                    let settings = Settings { sampling, cull, outputs, ..Settings::new(90, 70) };
                    let expected = draw_reference(&mesh, &plain, &camera, &settings);
                    let found = draw(&plain, &camera, &settings);
                    assert_same(&expected, &found, &format!("{background:?}, {filter:?}, {cull:?}"));
                }
            }
        }
    }
}

/// A frame of samples is that of the reference.
#[test]
fn frames_of_samples() {
    let mesh = soup(3_000, 8);
    let plain = scene(&mesh);
    let camera = perspective([0.5, 1.0, 3.0], [0.0; 3], 40.0);
    for sampling in all_samplings() {
        let settings = Settings { sampling, ..everything(61, 47) };
        let unresolved = Settings { unresolved: true, ..settings.clone() };
        let samples = draw(&plain, &camera, &unresolved);
        assert_eq!(samples.width, 61 * sampling.pattern.count() as u32);
        assert_same(&draw_reference(&mesh, &plain, &camera, &unresolved), &samples, &format!("{sampling:?}"));
    }
}

/// The area of a polygon inside a pixel, by clipping it in `f64`.
fn area_in_pixel(polygon: &[[f64; 2]], pixel: [f64; 2]) -> f64 {
    let mut polygon = polygon.to_vec();
    for (axis, sign) in [(0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0)] {
        let border = if sign > 0.0 { pixel[axis] } else { pixel[axis] + 1.0 };
        let inside = |p: &[f64; 2]| (p[axis] - border) * sign;
        let mut clipped = Vec::new();
        for (i, a) in polygon.iter().enumerate() {
            let b = &polygon[(i + 1) % polygon.len()];
            let (da, db) = (inside(a), inside(b));
            if da >= 0.0 {
                clipped.push(*a);
            }
            if (da >= 0.0) != (db >= 0.0) {
                let t = da / (da - db);
                clipped.push([a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t]);
            }
        }
        polygon = clipped;
        if polygon.is_empty() {
            return 0.0;
        }
    }
    let cross = |i: usize| {
        let (a, b) = (polygon[i], polygon[(i + 1) % polygon.len()]);
        a[0] * b[1] - a[1] * b[0]
    };
    (0..polygon.len()).map(cross).sum::<f64>().abs() * 0.5
}

/// The largest difference between the share of a pattern's samples in a half-plane and the half-plane's area in the
/// pixel, over many half-planes.
fn discrepancy(pattern: SamplePattern) -> f64 {
    let cells = pattern.cells();
    let mut most: f64 = 0.0;
    for angle in 0..180 {
        let (sin, cos) = (f64::from(angle) * std::f64::consts::PI / 90.0).sin_cos();
        for step in 0..400 {
            let along = f64::from(step) / 400.0 * 1.5 - 0.75;
            // The half-plane of points whose distance along the direction is below this.
            let corner = |a: f64, b: f64| [0.5 + cos * a - sin * b, 0.5 + sin * a + cos * b];
            let half = [corner(-9.0, -9.0), corner(along, -9.0), corner(along, 9.0), corner(-9.0, 9.0)];
            let is_inside = |s: &usize| {
                let [x, y] = cells.offset(*s).map(|o| f64::from(o) / 256.0 - 0.5);
                x * cos + y * sin < along
            };
            let share = (0..cells.count).filter(is_inside).count() as f64 / cells.count as f64;
            most = most.max((share - area_in_pixel(&half, [0.0; 2])).abs());
        }
    }
    most
}

/// The covered share of every pixel of random triangles is their area in it, within what the pattern allows: a triangle
/// is the intersection of three half-planes.
#[test]
fn coverage_converges_to_the_area() {
    let mut before = f64::INFINITY;
    for pattern in [
        SamplePattern::Center,
        SamplePattern::Sparse2,
        SamplePattern::Sparse4,
        SamplePattern::Sparse8,
        SamplePattern::Sparse16,
    ] {
        let bound = discrepancy(pattern);
        let mut random = Random(11);
        let (mut errors, mut pixels) = (0.0, 0);
        for _ in 0..60 {
            // In pixels; snapped to sub-pixels as the renderer does, so that both draw the same triangle.
            let size = 32.0;
            let corners =
                [0; 3].map(|_| [0; 2].map(|_| (random.between(1.0, size - 1.0) * 256.0).round() / 256.0));
            let positions = corners.map(|[x, y]| [x as f32, -y as f32, 0.0]);
            let mut mesh = Mesh { positions: positions.to_vec(), ..Mesh::default() };
            mesh.triangles.push([0, 1, 2]);
            let mut plain = scene(&mesh);
            plain.background = Background::Solid([0.0, 0.0, 0.0, 1.0]);
            plain.instances[0].surface.base_color = [1.0; 3];
            let camera = Camera {
                eye: DVec3::new(size / 2.0, -size / 2.0, 10.0),
                target: DVec3::new(size / 2.0, -size / 2.0, 0.0),
                up: DVec3::Y,
                projection: Projection::Orthographic { height: size },
                near: None,
                shift: [0.0; 2],
            };
            let settings = Settings {
                sampling: Sampling::of(pattern),
                shading: Shading::Unlit,
                outputs: Outputs { linear: true, ..Outputs::NONE },
                ..Settings::new(32, 32)
            };
            let frame = draw(&plain, &camera, &settings);
            for (index, linear) in frame.planes.linear.iter().enumerate() {
                let pixel = [(index % 32) as f64, (index / 32) as f64];
                let area = area_in_pixel(&corners, pixel);
                let error = (f64::from(linear[0]) - area).abs();
                // Three times the bound of one or two samples is more than a pixel.
                let is_close = 3.0 * bound >= 1.0 || error <= 3.0 * bound + 1e-6;
                assert!(is_close, "{pattern}: {} of {area}, {bound}", linear[0]);
                if area > 1e-9 && area < 1.0 - 1e-9 {
                    errors += error;
                    pixels += 1;
                }
            }
        }
        assert!(pixels > 1000, "{pixels} pixels at edges");
        let mean = errors / f64::from(pixels);
        assert!(mean < 0.72 * before, "{pattern}: a mean error of {mean} after {before}");
        before = mean;
    }
    assert!(before < 0.03, "16 samples: a mean error of {before}");
}

/// Bands below each other are the picture, whatever the filter needs of the neighbours.
#[test]
fn bands_make_up_the_picture() {
    let mesh = soup(3_000, 9);
    let plain = with_second_instance(scene(&mesh));
    let camera = perspective([0.1, 0.2, 0.3], [1.0, 0.0, -1.0], 75.0);
    for sampling in
        [Sampling::NONE, Sampling::default(), Sampling { filter: Filter::Tent, ..Sampling::default() }]
    {
        for sorting in [Sorting::Clusters, Sorting::Triangles] {
            let whole = Settings { sampling, sorting, tile_size: Some(16), ..everything(99, 83) };
            let expected = draw(&plain, &camera, &whole);
            for rows in [16, 48] {
                let mut first = 0;
                while first < 83 {
                    let band = first..(first + rows).min(83);
                    let settings = Settings { band: Some(band.clone()), ..whole.clone() };
                    let found = draw(&plain, &camera, &settings);
                    let what = format!("{sampling:?}, {sorting:?}, {band:?}");
                    assert_same(&draw_reference(&mesh, &plain, &camera, &settings), &found, &what);
                    let pixels = 99 * band.start as usize..99 * band.end as usize;
                    assert!(found.planes.color == expected.planes.color[pixels], "{what}");
                    first += rows;
                }
            }
        }
    }
    let wrong =
        |band| Settings { band: Some(band), tile_size: Some(16), ..everything(99, 83) }.check().is_err();
    assert!(wrong(8..32) && wrong(0..20) && wrong(16..16) && wrong(64..96) && !wrong(80..83));
}

/// Colours only, for which the averages have code of their own, with every sampling.
#[test]
fn colours_only_with_every_sampling() {
    let mesh = sphere(20);
    let plain = scene(&mesh);
    let camera = perspective([1.0, 2.0, 3.0], [0.0; 3], 35.0);
    for sampling in all_samplings() {
        let settings = Settings { sampling, ..Settings::new(70, 50) };
        let expected = draw_reference(&mesh, &plain, &camera, &settings);
        assert_same(&expected, &draw(&plain, &camera, &settings), &format!("{sampling:?}"));
    }
}

/// The largest tiles, with neighbours on all sides.
#[test]
fn large_tiles() {
    let mesh = soup(3_000, 12);
    let plain = scene(&mesh);
    let camera = perspective([0.1, 0.2, 0.3], [1.0, 0.0, -1.0], 75.0);
    for pattern in [SamplePattern::Sparse2, SamplePattern::Sparse16] {
        let sampling = Sampling { filter: Filter::Tent, ..Sampling::of(pattern) };
        let settings = Settings { sampling, tile_size: Some(128), ..everything(390, 270) };
        let expected = draw_reference(&mesh, &plain, &camera, &settings);
        for sorting in [Sorting::Clusters, Sorting::Triangles] {
            let s = Settings { sorting, ..settings.clone() };
            assert_same(&expected, &draw(&plain, &camera, &s), &format!("{pattern}, {sorting:?}"));
        }
    }
}

/// Pictures as wide, and as high, as they may be: the guard band is their border.
#[test]
fn the_largest_sizes() {
    let mesh = soup(400, 13);
    let plain = scene(&mesh);
    for (width, height, camera) in [
        (65536, 3, orthographic([0.2, 0.3, 0.5], [0.0; 3], 1e-4)),
        (3, 65536, orthographic([0.2, 0.3, 0.5], [0.0; 3], 2.0)),
        (65536, 3, perspective([0.1, 0.2, 0.3], [1.0, 0.0, -1.0], 0.01)),
        (3, 65536, perspective([0.1, 0.2, 0.3], [1.0, 0.0, -1.0], 110.0)),
    ] {
        for sampling in [Sampling::NONE, Sampling::default(), Sampling::of(SamplePattern::Sparse16)] {
            let settings = Settings { sampling, ..everything(width, height) };
            let expected = draw_reference(&mesh, &plain, &camera, &settings);
            let found = draw(&plain, &camera, &settings);
            assert!(found.stats.backend.pixels_visible > 5_000, "{}", found.stats.backend.pixels_visible);
            assert_same(&expected, &found, &format!("{width}x{height}, {sampling:?}"));
        }
    }
    assert!(everything(65537, 1).check().is_err() && everything(1, 65537).check().is_err());
}

/// The memory of a renderer is reused for other patterns, filters, planes, sizes and bands.
#[test]
fn frames_do_not_affect_later_frames() {
    let mesh = soup(2_000, 14);
    let plain = scene(&mesh);
    let camera = perspective([0.5, 1.0, 3.0], [0.0; 3], 40.0);
    let (mut renderer, mut frame, mut random) = (Renderer::new(), Frame::default(), Random(15));
    let samplings: Vec<Sampling> = all_samplings().collect();
    for turn in 0..60 {
        let mut pick = |count: usize| (random.next() * count as f64) as usize;
        let edge = [8, 16, 64][pick(3)];
        let settings = Settings {
            sampling: samplings[pick(samplings.len())],
            outputs: [Outputs::ALL, Outputs::default(), Outputs { depth: true, ..Outputs::NONE }][pick(3)],
            tile_size: Some(edge),
            sorting: [Sorting::Clusters, Sorting::Triangles][pick(2)],
            band: [None, Some(0..64)][pick(2)].clone(),
            ..Settings::new(30 + pick(60) as u32, 65 + pick(40) as u32)
        };
        renderer.render_into(&plain, &camera, &settings, &mut frame).expect("a picture");
        assert_same(&draw(&plain, &camera, &settings), &frame, &format!("turn {turn}: {settings:?}"));
    }
}

/// Measurements stop after any stage.
#[test]
fn every_last_stage() {
    let mesh = soup(2_000, 16);
    let plain = scene(&mesh);
    let camera = perspective([0.5, 1.0, 3.0], [0.0; 3], 40.0);
    let whole = draw(&plain, &camera, &Settings::new(200, 150)).stats.backend;
    use LastStage as L;
    for last_stage in [L::Cull, L::Bin, L::Sieve, L::Visibility, L::Output] {
        let settings = Settings { last_stage, ..Settings::new(200, 150) };
        let counts = draw(&plain, &camera, &settings).stats.backend;
        assert_eq!(counts.triangles_drawn > 0, last_stage >= L::Sieve);
        assert_eq!(counts.pixels_visible, if last_stage >= L::Visibility { whole.pixels_visible } else { 0 });
        assert_eq!(counts.pixels_shaded > 0, last_stage == L::Output);
    }
}
