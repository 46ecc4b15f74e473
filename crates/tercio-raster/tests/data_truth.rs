//! Data on surfaces held against rays and formulas in `f64` that share no code with the renderer: values are interpolated along the
//! surface, then mapped by a formula of the colour map.

mod common;

use std::sync::Arc;

use common::*;
use glam::DVec3;
use tercio_mesh::{Attribute, AttributeDomain, Mesh};
use tercio_raster::{Frame, Outputs, Settings, Shading};
use tercio_scene::color_map::{Isolines, Scale};
use tercio_scene::{Camera, ColorMap, DataColors, DataSource, SurfaceData};
use tercio_testkit::ray_caster::RayCaster;

const SIZE: [u32; 2] = [160, 120];

fn cameras() -> [Camera; 3] {
    [
        perspective([0.4, 0.9, 2.6], [0.0; 3], 45.0),
        perspective([0.1, 0.2, 1.3], [0.2, 0.1, 0.0], 70.0),
        orthographic([1.0, -2.0, 0.7], [0.0; 3], 2.2),
    ]
}

/// What is visible at a point of the picture: the interpolated value; `None` beside the model and near edges of triangles.
fn seen(caster: &RayCaster, values: &[[f64; 3]], camera: &Camera, at: [f64; 2], rim: f64) -> Option<f64> {
    seen_in(caster, values, camera, at, rim).map(|(_, value)| value)
}

/// As [`seen`], with the triangle.
fn seen_in(
    caster: &RayCaster,
    values: &[[f64; 3]],
    camera: &Camera,
    at: [f64; 2],
    rim: f64,
) -> Option<(usize, f64)> {
    let (from, towards) = ray(camera, SIZE, at);
    let hit = caster.first_hit(from.to_array(), towards.to_array(), 0.0)?;
    let of = values[hit.triangle];
    let is_inside = hit.weight.iter().all(|&w| w > rim);
    is_inside.then(|| (hit.triangle, (0..3).map(|k| hit.weight[k] * of[k]).sum()))
}

struct Model {
    mesh: Mesh,
    caster: RayCaster,
    values: Vec<[f64; 3]>,
}

/// A sphere with a function of the position as data.
fn model(triangles: u32, value: impl Fn(DVec3) -> f64) -> Model {
    let mut mesh = sphere(triangles);
    let at = |v: u32| DVec3::from(mesh.positions[v as usize].map(f64::from));
    let corners = mesh.triangles.iter().map(|t| t.map(|v| at(v).to_array())).collect();
    let of_vertices: Vec<f32> = (0..mesh.positions.len() as u32).map(|v| value(at(v)) as f32).collect();
    let values = mesh.triangles.iter().map(|t| t.map(|v| f64::from(of_vertices[v as usize]))).collect();
    mesh.attributes.push(Attribute {
        name: "x".into(),
        domain: AttributeDomain::Vertex,
        values: of_vertices,
        offset: 0.0,
        component: None,
    });
    Model { mesh, caster: RayCaster::new(corners), values }
}

fn picture(model: &Model, camera: &Camera, colors: DataColors) -> Frame {
    let mut scene = scene(&model.mesh);
    let data = SurfaceData::Mapped { source: DataSource::Attribute(0), colors: Arc::new(colors) };
    scene.instances[0].data = Some(Arc::new(data));
    let outputs = Outputs { color: true, ..Outputs::NONE };
    let settings = Settings { shading: Shading::Unlit, outputs, ..Settings::one_sample(SIZE[0], SIZE[1]) };
    draw(&scene, camera, &settings)
}

fn gray(range: [f64; 2]) -> DataColors {
    DataColors::new("x", ColorMap::named("gray").expect("known"), range)
}

/// Compares every pixel inside a triangle with `expected`, the level of gray of a value, and how far it may be off there; returns
/// how many were compared.
fn compare(model: &Model, colors: &DataColors, expected: impl Fn(f64) -> Option<(f64, f64)>) -> usize {
    let mut compared = 0;
    for camera in cameras() {
        let frame = picture(model, &camera, colors.clone());
        for (x, y) in (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| (x, y))) {
            let at = [f64::from(x) + 0.5, f64::from(y) + 0.5];
            let Some(value) = seen(&model.caster, &model.values, &camera, at, 0.02) else { continue };
            let Some((level, tolerance)) = expected(value) else { continue };
            let found = frame.planes.color[(y * SIZE[0] + x) as usize];
            compared += 1;
            for k in 0..3 {
                let off = (f64::from(found[k]) - level).abs();
                assert!(off <= tolerance, "{x} {y}: value {value}, {found:?}, expected {level}");
            }
        }
    }
    compared
}

/// Corners are snapped to 1/256 pixel, which moves values by as much as they change over that distance.
const LEVELS: f64 = 1.6;

#[test]
fn smooth_maps_on_every_scale() {
    let model = model(12, |p| (3.0 * p.x + p.y * p.z).exp());
    let (low, high) = (0.1, 15.0);
    let share = |t: f64| Some((t.clamp(0.0, 1.0) * 255.0, LEVELS));
    let mut colors = gray([low, high]);
    assert!(compare(&model, &colors, |v| share((v - low) / (high - low))) > 15_000);
    colors.scale = Scale::Log;
    compare(&model, &colors, |v| share((v / low).ln() / (high / low).ln()));
    let (threshold, low) = (2.0, -8.0);
    (colors.scale, colors.range) = (Scale::SymmetricLog { threshold }, [low, high]);
    let symmetric = |v: f64| {
        let s = (v / threshold).abs();
        v.signum() * if s > 1.0 { s.log10() + 10.0 / 9.0 } else { s * 10.0 / 9.0 }
    };
    compare(&model, &colors, |v| share((symmetric(v) - symmetric(low)) / (symmetric(high) - symmetric(low))));
}

#[test]
fn bands_and_what_lies_beyond_are_sharp() {
    let model = model(10, |p| 4.0 * p.x + 2.0 * p.y * p.y);
    let mut colors = gray([-3.0, 3.0]);
    colors.bands = Some(6);
    (colors.below, colors.above) = (Some([7, 7, 7, 255]), Some([99, 99, 99, 255]));
    let count = compare(&model, &colors, |v| {
        // Not at the border of a band.
        let nearest = (v.round() - v).abs();
        (nearest > 0.03).then(|| match v {
            v if v < -3.0 => (7.0, 0.0),
            v if v > 3.0 => (99.0, 0.0),
            v => ((v + 3.0).floor() * 51.0, 0.0),
        })
    });
    assert!(count > 12_000, "{count}");
}

#[test]
fn isolines_lie_where_the_value_is_and_are_as_wide_everywhere() {
    let model = model(16, |p| p.y);
    let (line, width) = (0.25, 3.0);
    let mut colors = gray([-100.0, 100.0]);
    colors.isolines = Some(Isolines { values: vec![line, -0.5], color: [255, 0, 0, 255], width });
    let camera = &cameras()[0];
    let frame = picture(&model, camera, colors);
    // The distance of a pixel from the line, in pixels, by the change of the value to the sides.
    let mut seen_lines = 0;
    for (x, y) in (1..SIZE[1] - 1).flat_map(|y| (1..SIZE[0] - 1).map(move |x| (x, y))) {
        let value = |dx: f64, dy: f64| {
            let at = [f64::from(x) + 0.5 + dx, f64::from(y) + 0.5 + dy];
            seen_in(&model.caster, &model.values, camera, at, 0.05)
        };
        let [Some((triangle, v)), Some((in_right, right)), Some((in_down, down))] =
            [value(0.0, 0.0), value(0.05, 0.0), value(0.0, 0.05)]
        else {
            continue;
        };
        // At the rim of the sphere triangles are thinner than that, and the next one has another slope.
        if (in_right, in_down) != (triangle, triangle) {
            continue;
        }
        let slope = ((right - v) / 0.05).hypot((down - v) / 0.05);
        let distance = (v - line).abs().min((v + 0.5).abs()) / slope;
        let cover = (f64::from(width) / 2.0 + 0.5 - distance).clamp(0.0, 1.0);
        let [r, g, ..] = frame.planes.color[(y * SIZE[0] + x) as usize];
        // The surface is 127 or 128 in sRGB, 0.212 in linear light.
        let linear = |c: u8| {
            let c = f64::from(c) / 255.0;
            if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
        };
        let surface = linear(128);
        let found = (linear(r) - surface) / (1.0 - surface);
        let by_green = 1.0 - linear(g) / surface;
        assert!(
            (found - cover).abs() < 0.06 && (by_green - cover).abs() < 0.06,
            "{x} {y}: {found} {by_green}, {cover}"
        );
        seen_lines += usize::from(cover > 0.9);
    }
    assert!(seen_lines > 200, "{seen_lines}");
}

#[test]
fn elevation_is_the_height_of_the_point() {
    let model = model(8, |p| p.dot(DVec3::new(0.48, 0.6, 0.64)));
    for camera in cameras() {
        let by_attribute = picture(&model, &camera, gray([-1.0, 1.0]));
        let mut scene = scene(&model.mesh);
        let source = DataSource::Along(DVec3::new(0.48, 0.6, 0.64));
        let data = SurfaceData::Mapped { source, colors: Arc::new(gray([-1.0, 1.0])) };
        scene.instances[0].data = Some(Arc::new(data));
        let outputs = Outputs { color: true, ..Outputs::NONE };
        let settings =
            Settings { shading: Shading::Unlit, outputs, ..Settings::one_sample(SIZE[0], SIZE[1]) };
        let found = draw(&scene, &camera, &settings);
        let differ = |(a, b): (&[u8; 4], &[u8; 4])| a[0].abs_diff(b[0]) > 1;
        assert_eq!(
            by_attribute.planes.color.iter().zip(&found.planes.color).filter(|p| differ(*p)).count(),
            0
        );
    }
}
