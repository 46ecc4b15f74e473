//! Which pictures have a kernel of their own.

use std::sync::Arc;

use glam::DVec3;
use tercio_mesh::cluster::{PartitionOptions, partition};
use tercio_mesh::{Attribute, AttributeDomain};
use tercio_scene::color_map::{Category, Isolines, Scale};
use tercio_scene::{Camera, ColorMap, DataColors, DataSource, Projection, Scene, SurfaceData, SurfaceEdges};

use super::*;
use crate::settings::Settings;

/// A sphere with four attributes at vertices and three at triangles, as in the tests of the picture law.
fn sphere() -> Scene {
    let mut mesh = tercio_mesh::builtin::make("builtin:sphere@3k").unwrap();
    for k in 0..7 {
        let (domain, count) = match k {
            4.. => (AttributeDomain::Triangle, mesh.triangles.len()),
            _ => (AttributeDomain::Vertex, mesh.positions.len()),
        };
        let values = (0..count).map(|i| (i % 5) as f32).collect();
        mesh.attributes.push(Attribute {
            name: format!("v:{k}"),
            domain,
            values,
            offset: 0.0,
            component: None,
        });
    }
    Scene::from_mesh(Arc::new(partition(mesh, &PartitionOptions::default())))
}

fn camera() -> Camera {
    Camera {
        eye: DVec3::new(0.5, 1.0, 3.0),
        target: DVec3::ZERO,
        up: DVec3::Y,
        projection: Projection::Perspective { fov_y: 0.7 },
        near: None,
        shift: [0.0; 2],
    }
}

fn smooth() -> DataColors {
    DataColors::new("x", ColorMap::named("viridis").unwrap(), [-0.5, 1.5])
}

fn categories(count: u8) -> Vec<Category> {
    let category = |k: u8| Category { value: k.into(), color: [k, 10, 200, 255], label: k.to_string() };
    (0..count).map(category).collect()
}

/// The features that the kernel has for a picture of a sphere with these data and edges.
fn chosen(data: Option<SurfaceData>, edges: bool, settings: &Settings) -> Option<Explained> {
    let mut scene = sphere();
    scene.instances[0].data = data.map(Arc::new);
    scene.instances[0].edges = edges.then(|| Arc::new(SurfaceEdges::new([200, 30, 120], 1.3, None)));
    let context = FrameContext::new(&scene, &camera(), settings, 1).unwrap();
    let look = Look::new(&context, 0, true, &settings.outputs);
    Explained::of(look, &context, 0)
}

#[test]
fn interpolated_values_and_edges_have_a_kernel_of_their_own() {
    let attribute = DataSource::Attribute;
    let lengths = |of: &[usize]| DataSource::Magnitude(of.to_vec());
    let symmetric = Scale::SymmetricLog { threshold: 0.01 };
    let ends = DataColors { below: Some([1, 2, 3, 255]), above: Some([250, 2, 3, 255]), ..smooth() };
    for settings in [Settings::one_sample(75, 58), Settings::new(55, 40)] {
        for edges in [false, true] {
            for (source, colors) in [
                (attribute(0), smooth()),
                (attribute(1), DataColors { scale: symmetric, ..ends.clone() }),
                (attribute(5), DataColors { scale: symmetric, ..ends.clone() }),
                (attribute(4), DataColors { bands: Some(7), ..smooth() }),
                (lengths(&[0, 1, 2]), smooth()),
                (lengths(&[4, 5, 6]), ends.clone()),
                (attribute(0), DataColors { categories: categories(3), ..smooth() }),
                (attribute(0), DataColors { categories: categories(90), ..smooth() }),
            ] {
                let said = format!("{source:?}, {colors:?}, edges {edges}");
                let data = SurfaceData::Mapped { source, colors: Arc::new(colors) };
                let features = chosen(Some(data), edges, &settings);
                assert!(features.is_some_and(|f| f.data && f.edges == edges), "{said}: {features:?}");
            }
        }
        assert!(chosen(None, true, &settings).is_some_and(|f| !f.data && f.edges));
    }
}

#[test]
fn lines_of_equal_value_direct_colours_and_other_planes_have_the_general_kernel() {
    let source = DataSource::Attribute(0);
    let isolines = Some(Isolines { values: vec![0.4], color: [20, 10, 0, 200], width: 1.0 });
    let colors = Arc::new(DataColors { isolines, ..smooth() });
    let lines = SurfaceData::Mapped { source: source.clone(), colors };
    let direct = SurfaceData::Direct { components: vec![source.clone(); 3], scale: 0.5, offset: 0.1 };
    let settings = Settings::one_sample(75, 58);
    for data in [lines, direct] {
        assert!(chosen(Some(data.clone()), false, &settings).is_none(), "{data:?}");
    }
    let plain = || Some(SurfaceData::Mapped { source: source.clone(), colors: Arc::new(smooth()) });
    for settings in [
        Settings { outputs: Outputs::ALL, ..settings.clone() },
        Settings { shading: Shading::Flat, ..settings.clone() },
    ] {
        assert!(chosen(plain(), true, &settings).is_none(), "{settings:?}");
    }
    assert!(chosen(plain(), true, &settings).is_some());
}
