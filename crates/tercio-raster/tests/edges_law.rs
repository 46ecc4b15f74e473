//! Pictures of surfaces with lines along the sides of their triangles: every path draws the bytes of the reference.

mod common;

use std::sync::Arc;

use common::*;
use tercio_mesh::edges::{Beyond, Edge, FarEnds, FourthCorners};
use tercio_mesh::{Attribute, AttributeDomain, Mesh};
use tercio_raster::{
    Outputs, RenderError, Renderer, SamplePattern, SampleShading, Sampling, Settings, Shading, reference,
};
use tercio_scene::{Camera, ColorMap, DataColors, DataSource, Light, Scene, SurfaceData, SurfaceEdges};

fn edged(mesh: &Mesh, width: f32, sides: Option<Vec<u8>>) -> Scene {
    let mut scene = scene(mesh);
    scene.instances[0].edges = Some(Arc::new(SurfaceEdges::new([200, 30, 120], width, sides)));
    scene
}

/// Some sides of each triangle.
fn some_sides(mesh: &Mesh, seed: u64) -> Option<Vec<u8>> {
    let mut random = Random(seed);
    Some(mesh.triangles.iter().map(|_| random.between(0.0, 8.0) as u8).collect())
}

/// Kinds of edges beyond the sides of triangles.
#[derive(Clone, Copy, Debug)]
enum Kind {
    Quadrilaterals,
    Polygons,
    Ends,
}

const KINDS: [Kind; 3] = [Kind::Quadrilaterals, Kind::Polygons, Kind::Ends];

/// Any edges beyond the sides of the triangles of a mesh.
fn some_beyond(mesh: &Mesh, seed: u64, kind: Kind) -> Beyond {
    let mut random = Random(seed);
    let count = mesh.positions.len() as f64;
    let positions = Arc::new(mesh.positions.clone());
    match kind {
        Kind::Quadrilaterals => {
            let mut vertex =
                || if random.next() < 0.3 { Edge::NONE } else { random.between(0.0, count) as u32 };
            Beyond::Quadrilaterals(FourthCorners::new(
                mesh.triangles.iter().map(|_| vertex()).collect(),
                positions,
            ))
        }
        Kind::Polygons => {
            let mut value = || if random.next() < 0.3 { 0.0 } else { random.between(0.01, 4.0) as f32 };
            let mut pair = || [value(), value()];
            Beyond::Polygons(mesh.triangles.iter().map(|_| [pair(), pair(), pair()]).collect())
        }
        Kind::Ends => {
            let mut of_triangle = || {
                let ends = (0..6).filter(|_| random.next() < 0.5).collect::<Vec<u8>>();
                let end = |code: u8| (code / 2, code % 2, random.between(0.0, count) as u32);
                ends.into_iter().map(end).collect()
            };
            let all: Vec<_> = mesh.triangles.iter().map(|_| of_triangle()).collect();
            Beyond::Ends(FarEnds::new(&all, positions))
        }
    }
}

fn with_beyond(mut scene: Scene, beyond: Beyond, opacity: f32) -> Scene {
    let edges = scene.instances[0].edges.as_ref().expect("edges");
    scene.instances[0].edges = Some(Arc::new(SurfaceEdges { beyond, opacity, ..(**edges).clone() }));
    scene
}

fn camera() -> Camera {
    perspective([0.5, 1.0, 3.0], [0.0; 3], 40.0)
}

/// 8-bit colours alone, with four samples a pixel: the fastest kernels draw them.
fn colors_only(width: u32, height: u32) -> Settings {
    let sampling = Sampling::of(SamplePattern::ALL[2]);
    Settings { sampling, outputs: Outputs { color: true, ..Outputs::NONE }, ..Settings::new(width, height) }
}

#[test]
fn every_shading_and_sampling() {
    let mesh = soup(1_500, 1);
    for (sides, beyond, opacity, width) in [
        (None, Beyond::Nothing, 1.0, 1.0),
        (some_sides(&mesh, 2), Beyond::Nothing, 0.4, 2.5),
        (None, Beyond::Nothing, 1.0, 0.4),
        (some_sides(&mesh, 2), some_beyond(&mesh, 8, Kind::Quadrilaterals), 1.0, 1.5),
        (some_sides(&mesh, 2), some_beyond(&mesh, 9, Kind::Polygons), 0.7, 1.5),
        (some_sides(&mesh, 2), some_beyond(&mesh, 10, Kind::Ends), 1.0, 1.5),
    ] {
        let mut scene = with_beyond(edged(&mesh, width, sides), beyond, opacity);
        scene.lights.push(Light::headlight([3.0, 0.2, 0.4]));
        for shading in [Shading::Phong, Shading::Flat, Shading::Gouraud, Shading::Unlit, Shading::Physical] {
            let settings = Settings { shading, ..everything(60, 44) };
            check_all(&mesh, &scene, &camera(), &settings, &format!("{width}, {shading:?}"));
        }
        for pattern in SamplePattern::ALL {
            for shading in [SampleShading::Pixel, SampleShading::Sample] {
                let sampling = Sampling { shading, ..Sampling::of(pattern) };
                let settings = Settings { sampling, ..everything(40, 30) };
                check_all(&mesh, &scene, &camera(), &settings, &format!("{width}, {sampling:?}"));
            }
        }
    }
}

#[test]
fn the_fastest_kernels() {
    let mut mesh = sphere(24);
    let values = mesh.positions.iter().map(|p| p[0] * 3.0 + p[1] * p[2]).collect();
    mesh.attributes.push(Attribute {
        name: "x".into(),
        domain: AttributeDomain::Vertex,
        values,
        offset: 0.0,
        component: None,
    });
    let values = (0..mesh.triangles.len()).map(|t| (t % 7) as f32).collect();
    mesh.attributes.push(Attribute {
        name: "y".into(),
        domain: AttributeDomain::Triangle,
        values,
        offset: 0.0,
        component: None,
    });
    let showing = |source: DataSource| {
        let colors = DataColors::new("x", ColorMap::named("turbo").expect("known"), [-2.0, 2.5]);
        Some(Arc::new(SurfaceData::Mapped { source, colors: Arc::new(colors) }))
    };
    let plain = draw(&scene(&mesh), &camera(), &colors_only(90, 70));
    let data = [None, showing(DataSource::Attribute(0)), showing(DataSource::Attribute(1))];
    for (number, data) in data.into_iter().enumerate() {
        let mut scene = scene(&mesh);
        scene.instances[0].data = data;
        for (edges, beyond) in [
            (None, Beyond::Nothing),
            (Some(None), Beyond::Nothing),
            (Some(some_sides(&mesh, 3)), Beyond::Nothing),
            (Some(some_sides(&mesh, 3)), some_beyond(&mesh, 4, Kind::Quadrilaterals)),
            (Some(None), some_beyond(&mesh, 5, Kind::Quadrilaterals)),
            (Some(some_sides(&mesh, 3)), some_beyond(&mesh, 6, Kind::Polygons)),
            (Some(None), some_beyond(&mesh, 7, Kind::Polygons)),
            (Some(some_sides(&mesh, 3)), some_beyond(&mesh, 8, Kind::Ends)),
            (Some(None), some_beyond(&mesh, 9, Kind::Ends)),
        ] {
            let what = format!("data {number}, edges {:?}", edges.as_ref().map(Option::is_some));
            let black = |sides| SurfaceEdges { beyond, ..SurfaceEdges::new([0, 0, 0], 1.0, sides) };
            scene.instances[0].edges = edges.map(|sides| Arc::new(black(sides)));
            check_all(&mesh, &scene, &camera(), &colors_only(90, 70), &what);
            let is_plain = number == 0 && scene.instances[0].edges.is_none();
            let found = draw(&scene, &camera(), &colors_only(90, 70));
            assert_eq!(found.difference(&plain).is_none(), is_plain, "{what}");
        }
    }
}

#[test]
fn what_is_clipped_and_translucent_and_other_instances() {
    let mesh = soup(1_200, 5);
    let inside = perspective([0.1, 0.2, 0.3], [1.0, 0.0, -1.0], 75.0);
    let flat = orthographic([0.5, 1.0, 3.0], [0.0; 3], 1.0);
    let mut scene = with_second_instance(edged(&mesh, 1.5, some_sides(&mesh, 6)));
    check_all(&mesh, &scene, &inside, &everything(71, 57), "inside");
    check_all(&mesh, &scene, &inside, &colors_only(50, 40), "inside, samples");
    for kind in KINDS {
        let other = with_beyond(scene.clone(), some_beyond(&mesh, 7, kind), 0.5);
        check_all(&mesh, &other, &inside, &everything(71, 57), &format!("inside, {kind:?}"));
        check_all(&mesh, &other, &flat, &colors_only(50, 40), &format!("flat, {kind:?}"));
    }
    scene.instances[1].edges = None;
    scene.instances[0].surface.opacity = 0.6;
    check_all(&mesh, &scene, &flat, &everything(60, 44), "two instances");
}

/// Lines change the colours of a picture, and nothing else.
#[test]
fn other_planes_are_those_without_edges() {
    let mesh = sphere(10);
    let (with, without) = [edged(&mesh, 2.0, None), scene(&mesh)]
        .map(|scene| draw(&scene, &camera(), &everything(80, 60)))
        .into();
    let (with, without) = (&with, &without);
    assert_ne!(with.planes.color, without.planes.color);
    assert_eq!(with.planes.depth, without.planes.depth);
    assert_eq!(with.planes.ids, without.planes.ids);
    assert_eq!(with.planes.normals, without.planes.normals);
}

#[test]
fn edges_that_cannot_be_are_refused() {
    let mesh = soup(10, 9);
    let black = || SurfaceEdges::new([0; 3], 1.0, None);
    let last_place = |place: f32| {
        let mut places = vec![[[0.0; 2], [1.0; 2], [1e6, -0.0]]; 10];
        places[9][2][1] = place;
        SurfaceEdges { beyond: Beyond::Polygons(places), ..black() }
    };
    let wrong_places =
        [-f32::MIN_POSITIVE, 1.01e6, f32::MAX, f32::INFINITY, f32::NEG_INFINITY, f32::NAN, -f32::NAN]
            .into_iter()
            .map(|place| (last_place(place), "place of an edge beyond a side"));
    for place in [0.0, -0.0, 1e6] {
        let mut scene = scene(&mesh);
        scene.instances[0].edges = Some(Arc::new(last_place(place)));
        Renderer::new().render(&scene, &camera(), &everything(10, 10)).expect("right places");
    }
    for (edges, wrong) in [
        (SurfaceEdges { width: 0.0, ..black() }, "width of edges"),
        (SurfaceEdges { width: f32::NAN, ..black() }, "width of edges"),
        (SurfaceEdges { width: f32::INFINITY, ..black() }, "width of edges"),
        (SurfaceEdges { color: [0.0, 1.5, 0.0], ..black() }, "colour of edges"),
        (SurfaceEdges { color: [f32::NAN, 0.0, 0.0], ..black() }, "colour of edges"),
        (SurfaceEdges { sides: Some(vec![7; 9]), ..black() }, "number of triangles with edges"),
        (SurfaceEdges { opacity: 1.5, ..black() }, "opacity of edges"),
        (SurfaceEdges { opacity: f32::NAN, ..black() }, "opacity of edges"),
        (
            SurfaceEdges {
                beyond: Beyond::Quadrilaterals(FourthCorners::new(vec![0; 9], Arc::default())),
                ..black()
            },
            "number of triangles with edges",
        ),
        (
            SurfaceEdges {
                beyond: Beyond::Ends(FarEnds::new(&vec![Vec::new(); 11], Arc::default())),
                ..black()
            },
            "number of triangles with edges",
        ),
        (
            SurfaceEdges { beyond: Beyond::Polygons(vec![[[1.0; 2]; 3]; 11]), ..black() },
            "number of triangles with edges",
        ),
    ]
    .into_iter()
    .chain(wrong_places)
    {
        let mut scene = scene(&mesh);
        scene.instances[0].edges = Some(Arc::new(edges));
        let error = Renderer::new().render(&scene, &camera(), &everything(10, 10)).unwrap_err();
        assert!(matches!(error, RenderError::Setting { what, .. } if what == wrong), "{wrong}: {error}");
        assert_eq!(reference::render(&[&mesh], &scene, &camera(), &everything(10, 10)).unwrap_err(), error);
    }
}
