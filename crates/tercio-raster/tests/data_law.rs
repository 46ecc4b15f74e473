//! Pictures of surfaces that show data: every path draws the bytes of the reference.

mod common;

use std::sync::Arc;

use common::*;
use glam::DVec3;
use tercio_mesh::{Attribute, AttributeDomain, Mesh};
use tercio_raster::{
    Outputs, RenderError, Renderer, SamplePattern, SampleShading, Sampling, Settings, Shading, SimdLevel,
};
use tercio_scene::color_map::{Category, Isolines, Scale};
use tercio_scene::{Camera, ColorMap, DataColors, DataSource, Light, Scene, SurfaceData, SurfaceEdges};

const SPECIAL: [f32; 6] = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 3e38, -3e38, 1e-40];

/// A mesh with four attributes at vertices and three at triangles: numbers of -1 to 2, some of them special.
fn with_data(mut mesh: Mesh, special: f64, seed: u64) -> Mesh {
    let mut random = Random(seed);
    let mut value = || match random.next() {
        r if r < special => SPECIAL[(r / special * SPECIAL.len() as f64) as usize],
        _ => random.between(-1.0, 2.0) as f32,
    };
    for k in 0..7 {
        let (domain, count) = match k {
            4.. => (AttributeDomain::Triangle, mesh.triangles.len()),
            _ => (AttributeDomain::Vertex, mesh.positions.len()),
        };
        let values = (0..count).map(|_| value()).collect();
        mesh.attributes.push(Attribute {
            name: format!("v:{k}"),
            domain,
            values,
            offset: 0.0,
            component: None,
        });
    }
    let count = mesh.positions.len();
    let color = |n: usize| [(n * 37 % 256) as u8, (n * 11 % 256) as u8, (n % 256) as u8, 255];
    mesh.vertex_colors.get_or_insert_with(|| (0..count).map(color).collect());
    let of_faces = (0..mesh.triangles.len()).map(|n| color(n + 5)).collect();
    mesh.face_colors.get_or_insert(of_faces);
    mesh.texcoords.get_or_insert_with(|| (0..count).map(|v| [0.5, (v % 7) as f32 * 0.25]).collect());
    mesh
}

fn colors(map: &str) -> DataColors {
    DataColors::new("x", ColorMap::named(map).expect("a known map"), [-0.5, 1.5])
}

fn mapped(source: DataSource, colors: DataColors) -> SurfaceData {
    SurfaceData::Mapped { source, colors: Arc::new(colors) }
}

/// Every source with every kind of map.
fn kinds() -> Vec<(&'static str, SurfaceData)> {
    let lines = |width| Some(Isolines { values: vec![-0.2, 0.4, 1.0], color: [20, 10, 0, 200], width });
    let category = |value: f32| Category {
        value: value.into(),
        label: String::new(),
        color: [value as u8, 90, 20, 255],
    };
    let direct = |components: &[usize]| SurfaceData::Direct {
        components: components.iter().map(|&n| DataSource::Attribute(n)).collect(),
        scale: 0.5,
        offset: 0.1,
    };
    let attribute = DataSource::Attribute;
    let both_logs = DataColors {
        scale: Scale::SymmetricLog { threshold: 0.01 },
        below: Some([1, 2, 3, 255]),
        above: Some([250, 2, 3, 255]),
        ..colors("coolwarm")
    };
    vec![
        ("smooth", mapped(attribute(0), colors("viridis"))),
        ("cells", mapped(attribute(4), DataColors { bands: Some(7), ..colors("RdBu_r") })),
        (
            "log",
            mapped(attribute(1), DataColors { scale: Scale::Log, range: [1e-3, 2.0], ..colors("turbo") }),
        ),
        ("both logs", mapped(attribute(1), DataColors { isolines: lines(2.5), ..both_logs.clone() })),
        (
            "length",
            mapped(
                DataSource::Magnitude(vec![0, 1, 2]),
                DataColors { isolines: lines(1.0), ..colors("Set1") },
            ),
        ),
        (
            "height",
            mapped(
                DataSource::Along(DVec3::new(0.6, 0.8, 0.0)),
                DataColors { bands: Some(5), ..colors("jet") },
            ),
        ),
        ("normal", mapped(DataSource::Normal(DVec3::Z), colors("gray"))),
        ("coordinate", mapped(DataSource::Coordinate(1), colors("gray"))),
        ("texture coordinate", mapped(DataSource::Texcoord(1), colors("turbo"))),
        (
            "faces",
            mapped(
                DataSource::Face,
                DataColors {
                    categories: (0..200).step_by(3).map(|v| category(v as f32)).collect(),
                    ..colors("Set1")
                },
            ),
        ),
        (
            "few faces",
            mapped(
                DataSource::Face,
                DataColors {
                    categories: (0..60).step_by(2).map(|v| category(v as f32)).collect(),
                    ..colors("Set1")
                },
            ),
        ),
        (
            "opacity",
            mapped(
                attribute(2),
                DataColors { opacities: vec![0.0, 0.3, 1.0], isolines: lines(1.5), ..colors("plasma") },
            ),
        ),
        ("colours", direct(&[0, 1, 2])),
        ("colours with alpha", direct(&[0, 1, 2, 3])),
        // Without lines of equal value, so that the kernel of interpolated values draws them.
        ("both logs alone", mapped(attribute(1), both_logs)),
        (
            "both logs of cells",
            mapped(
                attribute(5),
                DataColors {
                    scale: Scale::SymmetricLog { threshold: 0.3 },
                    above: Some([250, 2, 3, 255]),
                    ..colors("RdBu_r")
                },
            ),
        ),
        ("length alone", mapped(DataSource::Magnitude(vec![0, 1, 2]), colors("plasma"))),
        (
            "length of cells",
            mapped(
                DataSource::Magnitude(vec![4, 5, 6]),
                DataColors {
                    range: [0.8, 1.9],
                    below: Some([3, 2, 100, 255]),
                    above: Some([250, 200, 3, 255]),
                    ..colors("viridis")
                },
            ),
        ),
        (
            "red",
            mapped(
                DataSource::Color(0, AttributeDomain::Vertex),
                DataColors { range: [20.0, 200.0], ..colors("magma") },
            ),
        ),
        (
            "green of cells",
            mapped(
                DataSource::Color(1, AttributeDomain::Triangle),
                DataColors { range: [0.0, 255.0], bands: Some(5), ..colors("turbo") },
            ),
        ),
        ("levels", mapped(attribute(0), DataColors { levels: vec![-0.2, 0.4, 1.0], ..colors("viridis") })),
        ("levels of cells", mapped(attribute(6), DataColors { levels: vec![0.0, 0.7], ..colors("Set1") })),
        (
            "levels and log",
            mapped(
                attribute(1),
                DataColors {
                    scale: Scale::Log,
                    range: [1e-3, 2.0],
                    levels: vec![0.01, 0.1, 0.5],
                    isolines: lines(1.5),
                    ..colors("cividis")
                },
            ),
        ),
    ]
}

fn showing(mesh: &Mesh, data: SurfaceData) -> Scene {
    let mut scene = scene(mesh);
    scene.instances[0].data = Some(Arc::new(data));
    scene
}

fn camera() -> Camera {
    perspective([0.5, 1.0, 3.0], [0.0; 3], 40.0)
}

fn check_all(mesh: &Mesh, scene: &Scene, camera: &Camera, settings: &Settings, what: &str) {
    let expected = draw_reference(mesh, scene, camera, settings);
    let check = |s: Settings, name: String| {
        assert_same(&expected, &draw(scene, camera, &s), &format!("{what}, {name}"));
    };
    for simd in SimdLevel::available() {
        check(Settings { simd: Some(simd), ..settings.clone() }, simd.to_string());
    }
    for tile_size in [8, 128] {
        check(Settings { tile_size: Some(tile_size), ..settings.clone() }, format!("tiles of {tile_size}"));
    }
    with_threads(3, || check(settings.clone(), "3 threads".into()));
}

#[test]
fn every_source_and_every_map() {
    let mesh = with_data(soup(2_000, 1), 0.02, 2);
    let smooth = Settings { outputs: Outputs::ALL, ..Settings::new(55, 40) };
    for (name, data) in kinds() {
        let scene = showing(&mesh, data);
        for settings in [everything(75, 58), smooth.clone()] {
            check_all(&mesh, &scene, &camera(), &settings, name);
        }
    }
}

#[test]
fn every_shading_and_sampling() {
    let mesh = with_data(soup(1_500, 3), 0.0, 4);
    let colored = |number: usize| showing(&mesh, kinds()[number].1.clone());
    for number in [3, 8, 9] {
        let mut scene = colored(number);
        // Every kind of light.
        scene.lights.push(Light::headlight([0.3, 0.2, 0.4]));
        let (position, space) = (DVec3::new(1.0, 2.0, 0.5), tercio_scene::LightSpace::World);
        scene.lights.push(Light::Point { position, space, color: [0.2, 0.5, 0.3] });
        for shading in [Shading::Flat, Shading::Gouraud, Shading::Unlit, Shading::Physical] {
            let settings = Settings { shading, ..everything(60, 44) };
            check_all(&mesh, &scene, &camera(), &settings, &format!("{number}, {shading:?}"));
        }
        for (pattern, shading) in
            [(SamplePattern::ALL[1], SampleShading::Pixel), (SamplePattern::ALL[2], SampleShading::Sample)]
        {
            let sampling = Sampling { shading, ..Sampling::of(pattern) };
            let settings = Settings { sampling, tile_size: Some(16), ..everything(50, 38) };
            check_all(&mesh, &scene, &camera(), &settings, &format!("{number}, {settings:?}"));
        }
    }
}

/// Values below and above the range are seen in the pictures that shall show them, in their own colours.
#[test]
fn colours_below_and_above_are_seen() {
    let mesh = with_data(tercio_mesh::builtin::make("builtin:sphere@3k").expect("a model"), 0.0, 11);
    for (name, data) in kinds() {
        let SurfaceData::Mapped { colors, .. } = &data else { continue };
        let own: Vec<_> = [colors.below, colors.above].into_iter().flatten().collect();
        let scene = showing(&mesh, data.clone());
        let settings = Settings { shading: Shading::Unlit, ..Settings::one_sample(75, 58) };
        let picture = draw(&scene, &camera(), &settings).planes.color;
        for color in own {
            let seen = picture.iter().filter(|&&pixel| pixel == color).count();
            assert!(seen > 20, "{name}: {seen} pixels of {color:?}");
        }
    }
}

/// Colours alone, of a surface with vertex normals that agree with its triangles: what kernels are specialized for, for triangles in
/// clusters and (seen from near by) for those that are binned one by one, with one sample and with several.
#[test]
fn surfaces_that_are_plain_but_for_data_and_edges() {
    let sphere = tercio_mesh::builtin::make("builtin:sphere@3k").expect("a model");
    let mesh = with_data(sphere, 0.005, 11);
    let near = perspective([0.1, 0.2, 1.1], [0.3, 0.0, 0.0], 70.0);
    for (name, data) in kinds() {
        for has_edges in [false, true] {
            let mut scene = showing(&mesh, data.clone());
            let edges = || Arc::new(SurfaceEdges::new([200, 30, 120], 1.3, None));
            scene.instances[0].edges = has_edges.then(edges);
            for settings in [Settings::one_sample(75, 58), Settings::new(55, 40)] {
                for camera in [&camera(), &near] {
                    check_all(&mesh, &scene, camera, &settings, &format!("{name}, edges {has_edges}"));
                }
            }
        }
    }
}

#[test]
fn what_is_clipped_and_other_instances() {
    let mesh = with_data(soup(1_500, 5), 0.01, 6);
    let inside = perspective([0.1, 0.2, 0.3], [1.0, 0.0, -1.0], 75.0);
    let flat = orthographic([0.5, 1.0, 3.0], [0.0; 3], 1.0);
    for number in [3, 5, 6, 8] {
        let mut scene = with_second_instance(showing(&mesh, kinds()[number].1.clone()));
        check_all(&mesh, &scene, &inside, &everything(71, 57), "inside");
        // The other instance has its own colours, and its own opacity.
        scene.instances[1].data = None;
        scene.instances[0].surface.opacity = 0.6;
        check_all(&mesh, &scene, &flat, &everything(60, 44), "two instances");
    }
}

#[test]
fn data_replace_colours_that_are_not_opaque() {
    let mut mesh = with_data(soup(800, 7), 0.0, 8);
    mesh.vertex_colors.iter_mut().flatten().for_each(|color| color[3] = 90);
    let scene = showing(&mesh, kinds()[0].1.clone());
    assert!(!scene.instances[0].is_translucent());
    check_all(&mesh, &scene, &camera(), &everything(60, 44), "opaque data");
    let opaque = Mesh { vertex_colors: None, ..mesh.clone() };
    let expected = draw(&showing(&opaque, kinds()[0].1.clone()), &camera(), &everything(60, 44));
    assert_same(&expected, &draw(&scene, &camera(), &everything(60, 44)), "without colours");
}

#[test]
fn data_that_are_not_there_are_refused() {
    let mesh = with_data(soup(10, 9), 0.0, 10);
    let none = Mesh { normals: None, ..mesh.clone() };
    let bad = |colors: DataColors| mapped(DataSource::Attribute(0), colors);
    let plain = || colors("gray");
    for (data, wrong) in [
        (mapped(DataSource::Attribute(7), plain()), "data of an instance"),
        (mapped(DataSource::Magnitude(vec![0, 4]), plain()), "data of an instance"),
        (mapped(DataSource::Magnitude(vec![]), plain()), "data of an instance"),
        (mapped(DataSource::Normal(DVec3::X), plain()), "data of an instance"),
        (bad(DataColors { range: [1.0, 1.0], ..plain() }), "range of data"),
        (bad(DataColors { range: [f64::NAN, 1.0], ..plain() }), "range of data"),
        (bad(DataColors { range: [-3e38, 3e38], ..plain() }), "range of data"),
        (bad(DataColors { scale: Scale::Log, ..plain() }), "range of data on a logarithmic scale"),
        (
            bad(DataColors { scale: Scale::SymmetricLog { threshold: 0.0 }, ..plain() }),
            "threshold of a symmetric logarithm",
        ),
        (bad(DataColors { bands: Some(0), ..plain() }), "number of bands"),
        (bad(DataColors { opacities: vec![2.0], ..plain() }), "opacity of data"),
        (
            bad(DataColors {
                isolines: Some(Isolines { values: vec![f64::NAN], color: [0; 4], width: 1.0 }),
                ..plain()
            }),
            "isolines",
        ),
    ] {
        let scene = showing(&none, data);
        let error = Renderer::new().render(&scene, &camera(), &everything(10, 10)).unwrap_err();
        assert!(matches!(error, RenderError::Setting { what, .. } if what == wrong), "{wrong}: {error}");
        assert_eq!(
            tercio_raster::reference::render(&[&none], &scene, &camera(), &everything(10, 10)).unwrap_err(),
            error
        );
    }
}
