use tercio_mesh::cluster::{PartitionOptions, partition};
use tercio_mesh::edges::{Edges, Selection};
use tercio_mesh::{Attribute, AttributeDomain, Mesh, builtin};

use super::*;

/// The name of an attribute, where its values are, and the value of each element.
type Made<'a> = (&'a str, AttributeDomain, &'a dyn Fn(usize) -> f32);

fn model(attributes: &[Made]) -> Instance {
    let mut mesh = builtin::make("builtin:sphere@500").expect("a model");
    for (name, domain, value) in attributes {
        let count = match domain {
            AttributeDomain::Vertex => mesh.positions.len(),
            AttributeDomain::Triangle => mesh.triangles.len(),
        };
        let values = (0..count).map(value).collect();
        mesh.attributes.push(Attribute {
            name: (*name).into(),
            domain: *domain,
            values,
            offset: 0.0,
            component: None,
        });
    }
    Instance::new(partition(mesh, &PartitionOptions::default()))
}

fn colors(options: &DataOptions, instance: &Instance) -> Result<DataColors, DataError> {
    options.data(instance).map(|data| match &*data {
        SurfaceData::Mapped { colors, .. } => (**colors).clone(),
        SurfaceData::Direct { .. } => panic!("not values"),
    })
}

const V: AttributeDomain = AttributeDomain::Vertex;
const T: AttributeDomain = AttributeDomain::Triangle;

#[test]
fn values_with_an_offset_are_full_ones() {
    let values = (0..4).map(|i| i as f32 * 0.25).collect();
    let attribute = Attribute { name: "q".into(), domain: V, values, offset: 1e9, component: None };
    let mesh = Mesh {
        positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]],
        triangles: vec![[0, 1, 2], [2, 1, 3]],
        attributes: vec![attribute],
        ..Mesh::default()
    };
    let instance = Instance::new(partition(mesh, &PartitionOptions::default()));
    let mut options = DataOptions::new("q");
    let found = colors(&options, &instance).expect("a range");
    assert_eq!((found.range, found.offset), ([1e9, 1e9 + 0.75], 1e9));
    // Logarithms of numbers so close are even.
    options.scale = ScaleOption::Log;
    assert_eq!(colors(&options, &instance).expect("a range").offset, 1e9);
    // In a wide range nothing is seen of the differences.
    options.range = Ends { low: RangeEnd::At(1.0), high: RangeEnd::OfData };
    assert_eq!(colors(&options, &instance).expect("a range").offset, 0.0);
    options.range = Ends { low: RangeEnd::Percentile(0.5), high: RangeEnd::OfData };
    assert!((1e9 + 0.25..1e9 + 0.75).contains(&colors(&options, &instance).expect("a range").range[0]));
    let mut options = DataOptions::new("q");
    options.categories = Some(vec![(1e9 + 0.5, "half".into())]);
    let found = colors(&options, &instance).expect("categories");
    let labels: Vec<&str> = found.categories.iter().map(|c| &*c.label).collect();
    assert_eq!(labels, ["1000000000", "1000000000.25", "half", "1000000000.75"]);
    assert_eq!([printed(-0.0, 0.0), printed(0.00019, 1013.25)], ["0", "1013.25019"]);
}

#[test]
fn edges_have_the_values_of_their_first_triangle() {
    let mesh = {
        let mut mesh = builtin::make("builtin:teapot@600").expect("a model");
        let at = |v: usize| mesh.positions[v].iter().sum::<f32>();
        // Where vertices have the same position they have the same value, so that the ends of edges have one each.
        let values = (0..mesh.positions.len()).map(at).collect();
        mesh.attributes.push(Attribute {
            name: "sum".into(),
            domain: V,
            values,
            offset: 0.0,
            component: None,
        });
        let values = (0..mesh.triangles.len()).map(|t| t as f32).collect();
        mesh.attributes.push(Attribute {
            name: "number".into(),
            domain: T,
            values,
            offset: 0.0,
            component: None,
        });
        mesh
    };
    let of = |name: &str, max_triangles: usize| {
        let options = PartitionOptions { max_triangles, ..PartitionOptions::default() };
        let mut instance = Instance::new(partition(mesh.clone(), &options));
        instance.data = Some(DataOptions::new(name).data(&instance).expect("data"));
        let edges = Edges::of_clusters(&instance.mesh, Selection::All);
        let Some(StrokeData::Mapped { values, .. }) = of_edges(&instance, &edges) else { panic!("values") };
        assert_eq!(values.len(), 2 * edges.list.len());
        (edges, values)
    };
    let (edges, values) = of("sum", 128);
    for (edge, values) in edges.list.iter().zip(values.chunks_exact(2)) {
        let expected = edge.ends.map(|v| edges.positions[v as usize].iter().sum::<f32>());
        assert_eq!(values, expected);
    }
    let (edges, values) = of("number", 128);
    for (edge, values) in edges.list.iter().zip(values.chunks_exact(2)) {
        assert_eq!(values, [edge.triangle as f32; 2]);
        // That triangle has the edge.
        let corners = mesh.triangles[edge.triangle as usize].map(|v| mesh.positions[v as usize]);
        assert!(edge.ends.iter().all(|&v| corners.contains(&edges.positions[v as usize])));
    }
    for name in ["sum", "number", "@elevation", "@normal:x", "@face"] {
        assert_eq!(of(name, 128).1, of(name, 7).1, "{name}: clusters of another size");
    }
    // At each place, the coordinates there.
    let mut instance = Instance::new(partition(mesh.clone(), &PartitionOptions::default()));
    instance.data = Some(DataOptions::new("@elevation").data(&instance).expect("data"));
    let places = [0.0, 5.0].map(|up| glam::DAffine3::from_translation(DVec3::Y * up));
    let [Some(low), Some(high)] = [0, 1].map(|n| of_edges_at(&instance, &edges, &places).get(n).cloned())
    else {
        panic!("two places")
    };
    let (StrokeData::Mapped { values: low, .. }, StrokeData::Mapped { values: high, .. }) = (low, high)
    else {
        panic!("values")
    };
    assert!(low.iter().zip(&high).all(|(low, high)| (high - low - 5.0).abs() < 1e-5));
    // Nothing is shown.
    let instance = Instance::new(partition(mesh.clone(), &PartitionOptions::default()));
    assert!(of_edges(&instance, &edges).is_none());
}

#[test]
fn names_find_attributes_components_and_colors() {
    let zero = |_: usize| 0.0f32;
    let names = [
        ("p", V),
        ("v:0", V),
        ("v:1", V),
        ("v:2", V),
        ("w_x", T),
        ("w_y", T),
        ("a:b", T),
        (Attribute::POLYGON, T),
    ];
    let instance = model(&names.map(|(name, domain)| (name, domain, &zero as &dyn Fn(usize) -> f32)));
    let layout = instance.mesh.layout();
    let find = |name: &str| name::find(name, layout, DVec3::Z);
    let values = |source| Ok(name::Found::Values(source));
    assert_eq!(find("p"), values(DataSource::Attribute(0)));
    assert_eq!(find("p:magnitude"), find("p"));
    assert_eq!(find("v"), values(DataSource::Magnitude(vec![1, 2, 3])));
    assert_eq!(find("v:magnitude"), find("v"));
    for (name, number) in [("v:1", 2), ("v:z", 3), ("w:y", 5), ("w_x", 4), ("a:b", 6)] {
        assert_eq!(find(name), values(DataSource::Attribute(number)), "{name}");
    }
    let is_colors =
        |found| matches!(found, Ok(name::Found::Colors { components, .. }) if components.len() == 3);
    assert!(is_colors(find("v:rgb")) && is_colors(find("@normal")));
    assert_eq!(find("@elevation"), values(DataSource::Along(DVec3::Z)));
    let error = |name: &str| find(name).expect_err(name).to_string();
    let all = "p (vertices), v (vertices, 3 components), w_x (triangles), w_y (triangles), a:b (triangles)";
    let all = format!("{all}, @elevation, @x, @y, @z, @normal, @face, @curvature, @component");
    assert_eq!(error("q"), format!("there is no attribute \"q\"; there are {all}"));
    for polygon in [Attribute::POLYGON, "@polygon@cell"] {
        assert!(error(polygon).contains(&all), "{polygon}");
    }
    // What is made of the mesh is in one place.
    assert_eq!((find("@x@point"), find("@face@cell")), (find("@x"), find("@face")));
    assert_eq!((find("z@point"), find("@normal:z@point")), (find("z"), find("@normal:z")));
    assert_eq!(find("@normal@point:z"), find("@normal:z"));
    for elsewhere in
        ["x@cell", "@x@cell", "@elevation@cell", "@normal@cell", "@face@point", "@component@cell"]
    {
        assert!(
            error(elsewhere).contains(&format!("no attribute \"{elsewhere}\"; there are {all}")),
            "{elsewhere}"
        );
    }
    for unknown in ["p@foo", "x@foo", "@x@foo", "p@", "@elevation@vertex"] {
        assert!(error(unknown).contains(&all), "{unknown}");
    }
    assert!(error("@q").contains(&all) && error("q:1").contains(&all));
    assert_eq!(error("v:3"), "\"v\" has no component \"3\"; it has 0, 1, 2, x, y, z, magnitude, rgb");
    assert_eq!(error("p:1"), "\"p\" has no component \"1\"; it has 0, magnitude");
    assert!(error("@curvature").contains("prepared"));
    assert!(error("@normal:w").contains("x, y, z, rgb"));
}

#[test]
fn components_have_the_names_of_the_file() {
    let mut mesh = builtin::make("builtin:sphere@500").expect("a model");
    // The second one is called as the third axis.
    for (k, component) in [Some("sxx"), Some("z"), None].into_iter().enumerate() {
        let (values, component) = (vec![k as f32; mesh.positions.len()], component.map(String::from));
        mesh.attributes.push(Attribute { name: format!("s:{k}"), domain: V, values, offset: 0.0, component });
    }
    let instance = Instance::new(partition(mesh, &PartitionOptions::default()));
    let find = |name: &str| name::find(name, instance.mesh.layout(), DVec3::Z);
    for (name, number) in [
        ("s:sxx", 0),
        ("s:x", 0),
        ("s:z", 1),
        ("s:2", 2),
        ("s:sxx@point", 0),
        ("s@point:sxx", 0),
        ("s@point:2", 2),
    ] {
        assert_eq!(find(name), Ok(name::Found::Values(DataSource::Attribute(number))), "{name}");
    }
    let error = |name: &str| find(name).expect_err(name).to_string();
    assert!(error("s:syy").contains("it has sxx, z, 0, 1, 2, x, y, z, magnitude, rgb"));
    assert!(error("q").contains("s (vertices, 3 components: sxx, z)"));
}

#[test]
fn what_a_mesh_holds_itself_has_names() {
    let mut mesh = Mesh {
        origin: DVec3::new(4e6, 0.0, 0.0),
        positions: vec![[0.25, 0.0, 7.0], [1.5, 0.0, 8.0], [0.0, 1.0, 9.0]],
        triangles: vec![[0, 1, 2]],
        vertex_colors: Some(vec![[1, 2, 3, 4], [11, 12, 13, 14], [21, 22, 23, 24]]),
        texcoords: Some(vec![[0.25, 0.5], [0.75, 0.0], [0.0, 1.0]]),
        ..Mesh::default()
    };
    let of = |mesh: &Mesh| {
        let mut instance = Instance::new(partition(mesh.clone(), &PartitionOptions::default()));
        // The place of the instance does not count.
        instance.world_from_object = glam::DAffine3::from_translation(DVec3::splat(1e3));
        instance
    };
    let instance = of(&mesh);
    let range = |name: &str| colors(&DataOptions::new(name), &instance).map(|colors| colors.range);
    for (name, meaning, expected) in [
        ("x", "@x", [4e6, 4e6 + 1.5]),
        ("z", "@z", [7.0, 9.0]),
        ("red", "@color:r", [1.0, 21.0]),
        ("Blue", "@color:blue", [3.0, 23.0]),
        ("alpha@point", "@color:3", [4.0, 24.0]),
        ("s", "@texcoord:u", [0.0, 0.75]),
        ("texture_v", "@texcoord:1", [0.0, 1.0]),
    ] {
        assert_eq!(range(name), Ok(expected), "{name}");
        assert_eq!(range(meaning), Ok(expected), "{meaning}");
    }
    let direct = DataOptions::new("rgb").data(&instance).expect("colours");
    let SurfaceData::Direct { components, scale, offset } = &*direct else { panic!("values") };
    assert_eq!((components.len(), *scale, *offset), (3, 1.0 / 255.0, 0.0));
    let error = |name: &str| range(name).expect_err(name).to_string();
    assert!(error("q").contains("@x, @y, @z, @color (red, green, blue, alpha), @texcoord (u, v)"));
    assert!(error("@texcoord").contains("@texcoord:u, @texcoord:v"));
    assert!(error("@color:cyan").contains("red, green, blue"));
    assert!(error("nx").contains("no attribute \"nx\"") && error("red@cell").contains("no attribute"));

    // An attribute of the file goes first; without colours there are none.
    mesh.attributes.push(Attribute {
        name: "red".into(),
        domain: V,
        values: vec![5.0, 6.0, 7.0],
        offset: 0.0,
        component: None,
    });
    (mesh.vertex_colors, mesh.face_colors) = (None, Some(vec![[9, 8, 7, 6]]));
    let instance = of(&mesh);
    let found = |name: &str| name::find(name, instance.mesh.layout(), DVec3::Z);
    let values = |source| Ok(name::Found::Values(source));
    assert_eq!(found("red"), values(DataSource::Attribute(0)));
    assert_eq!(found("green"), values(DataSource::Color(1, T)));
}

#[test]
fn ranges_follow_from_finite_values() {
    let odd = |i: usize| match i % 7 {
        0 => f32::NAN,
        1 => f32::INFINITY,
        2 => -3.0,
        _ => (i % 100) as f32,
    };
    let instance = model(&[("odd", V, &odd), ("nan", V, &|_| f32::NAN), ("same", T, &|_| 4.0)]);
    let mut options = DataOptions::new("odd");
    assert_eq!(colors(&options, &instance).map(|c| c.range), Ok([-3.0, 99.0]));
    options.scale = ScaleOption::Log;
    assert_eq!(colors(&options, &instance).map(|c| c.range), Ok([1.0, 99.0]));
    options.range.low = RangeEnd::At(-1.0);
    assert!(matches!(colors(&options, &instance), Err(DataError::NotPositive { .. })));
    options.scale = ScaleOption::SymmetricLog(None);
    let symmetric = colors(&options, &instance).expect("a range");
    assert_eq!((symmetric.range, symmetric.scale), ([-1.0, 99.0], Scale::SymmetricLog { threshold: 0.099 }));
    options.range.low = RangeEnd::At(100.0);
    assert!(matches!(colors(&options, &instance), Err(DataError::Range { .. })));
    assert!(matches!(colors(&DataOptions::new("nan"), &instance), Err(DataError::NoNumbers(_))));
    assert_eq!(colors(&DataOptions::new("same"), &instance).map(|c| c.range), Ok([3.96, 4.04]));
}

#[test]
fn percentiles_are_those_of_sorted_values() {
    let values = |i: usize| ((i * 7919) % 1009) as f32 - 300.0;
    let instance = model(&[("triangle", T, &values), ("vertex", V, &values)]);
    assert!(instance.mesh.clusters().len() > 1, "some vertices are in several clusters");
    let vertices = builtin::make("builtin:sphere@500").expect("a model").positions.len();
    for (name, count) in [("triangle", instance.mesh.triangle_count()), ("vertex", vertices)] {
        let mut sorted: Vec<f32> = (0..count).map(values).collect();
        sorted.sort_by(f32::total_cmp);
        for share in [0.0, 0.02, 0.25, 0.5, 0.98, 1.0] {
            let mut options = DataOptions::new(name);
            options.range = Ends { low: RangeEnd::Percentile(share), high: RangeEnd::At(2000.0) };
            let expected = sorted[(share * (sorted.len() - 1) as f64 + 0.5) as usize];
            let found = colors(&options, &instance).map(|c| c.range[0]);
            assert_eq!(found, Ok(f64::from(expected)), "{name}, {share}");
        }
    }
}

#[test]
fn a_polygon_counts_once_in_percentiles() {
    let mut mesh = Mesh {
        positions: (0..7).map(|i| [i as f32, (i * i) as f32, 0.0]).collect(),
        triangles: vec![[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5], [0, 5, 6], [0, 1, 3], [0, 1, 4]],
        face_of_triangle: Some(vec![0, 0, 0, 0, 0, 1, 2]),
        ..Mesh::default()
    };
    let values = [9.0, 9.0, 9.0, 9.0, 9.0, 1.0, 2.0].to_vec();
    mesh.attributes.push(Attribute { name: "c".into(), domain: T, values, offset: 0.0, component: None });
    let instance = Instance::new(partition(mesh, &PartitionOptions::default()));
    let mut options = DataOptions::new("c");
    options.range.high = RangeEnd::Percentile(0.5);
    assert_eq!(colors(&options, &instance).map(|c| c.range), Ok([1.0, 2.0]));
}

#[test]
fn categories_are_the_values_that_there_are() {
    let instance = model(&[("material", T, &|i| [3.0, 1.0, -0.0, 0.0][i % 4]), ("many", V, &|i| i as f32)]);
    let mut options = DataOptions::new("material");
    options.categories = Some(vec![(1.0, "bone".into()), (7.0, "skin".into())]);
    let found = colors(&options, &instance).expect("categories");
    let labels: Vec<&str> = found.categories.iter().map(|c| &*c.label).collect();
    assert_eq!(labels, ["0", "bone", "3", "skin"]);
    assert_eq!(found.color(1.0), [55, 126, 184, 255], "the second colour of Set1");
    // A map of ParaView says which colours are for which values; those that it does not name have the colour of NaN.
    let text = r#"{"IndexedColors": [1,0,0, 0,1,0, 0,0,1, 1,1,0], "Annotations": ["3","skin","1",""]}"#;
    options.map = Some(ColorMap::parse("m", text.as_bytes()).expect("a map"));
    options.categories = Some(vec![(7.0, "none".into())]);
    let found = colors(&options, &instance).expect("categories");
    let all: Vec<_> =
        found.categories.iter().map(|c| (c.value, &*c.label, [c.color[0], c.color[1], c.color[2]])).collect();
    let expected = [(1.0, "1", [0, 255, 0]), (3.0, "skin", [255, 0, 0]), (7.0, "none", [0, 0, 255])];
    assert_eq!(all, expected);
    assert_eq!(found.color(0.0), found.nan);
    // If it names none of the values, all that it names are there to be told.
    let text = r#"{"IndexedColors": [1,0,0, 0,1,0], "Annotations": ["30","skin","10","bone"]}"#;
    options.map = Some(ColorMap::parse("m", text.as_bytes()).expect("a map"));
    options.categories = Some(Vec::new());
    let found = colors(&options, &instance).expect("categories");
    assert_eq!(found.categories.iter().map(|c| &*c.label).collect::<Vec<_>>(), ["bone", "skin"]);
    let mesh = builtin::make("builtin:sphere@20k").expect("a model");
    let values = (0..mesh.positions.len()).map(|i| i as f32).collect();
    let many = Attribute { name: "many".into(), domain: V, values, offset: 0.0, component: None };
    let mesh = Mesh { attributes: vec![many], ..mesh };
    options.by = "many".into();
    let instance = Instance::new(partition(mesh, &PartitionOptions::default()));
    // A few of them may be named.
    let found = colors(&options, &instance).expect("categories");
    assert_eq!(found.categories.iter().map(|c| c.value).collect::<Vec<_>>(), [10.0, 30.0]);
    options.map = None;
    assert!(matches!(colors(&options, &instance), Err(DataError::TooManyCategories(_))));
}

#[test]
fn isolines_are_even_on_the_scale() {
    let instance = model(&[("x", V, &|i| 1.0 + i as f32)]);
    let mut options = DataOptions::new("x");
    options.range = Ends { low: RangeEnd::At(1.0), high: RangeEnd::At(10_000.0) };
    options.scale = ScaleOption::Log;
    options.isolines = Some(IsolineOptions { at: Err(3), color: [0, 0, 0, 255], width: 1.0 });
    let lines = colors(&options, &instance).map(|c| c.isolines.expect("lines").values).expect("a range");
    for (line, expected) in lines.iter().zip([10.0, 100.0, 1000.0]) {
        assert!((line / expected - 1.0).abs() < 1e-12, "{lines:?}");
    }
    options.by = "@face".into();
    assert!(matches!(colors(&options, &instance), Err(DataError::ConstantIsolines(_))));
}

#[test]
fn elevations_of_lines_and_points_are_those_of_their_place() {
    let mut instance = model(&[]);
    let turn = glam::DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2);
    instance.world_from_object = glam::DAffine3::from_rotation_translation(turn, DVec3::new(1.0, 2.0, 3.0));
    let positions = vec![[0.0, 1.0, 0.0], [2.0, 0.0, -1.0]];
    let strokes = Strokes { origin: DVec3::X, positions, points: vec![0, 1], ..Strokes::default() };
    let options = DataOptions { up: DVec3::Y, ..DataOptions::new("@elevation") };
    let data = options.data_of_model::<DataError>(&instance, &strokes, Ok).expect("elevations");
    let Some(StrokeData::Mapped { values, .. }) = data.strokes else { panic!("no data of points") };
    // A quarter turn takes z to -y.
    let expected = [2.0f32, 3.0];
    assert!(
        values.iter().zip(expected).all(|(value, expected)| (value - expected).abs() < 1e-6),
        "{values:?}"
    );
}
