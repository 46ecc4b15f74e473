//! Golden pictures of what is drawn besides surfaces: lines, points, glyphs, data.

mod common;

use common::Place;
use tercio_testkit::golden;

/// Draws small pictures with these options and compares them with `tests/golden/primitives/NAME.png`.
fn check(model: &str, pictures: &[(&str, &str)]) {
    check_at(&Place::new(), model, pictures);
}

/// The same of a model in this folder.
fn check_at(place: &Place, model: &str, pictures: &[(&str, &str)]) {
    for (name, options) in pictures {
        let command = format!("render {model} {options} --size 144x108 --no-bar -o picture.ppm");
        place.run(&command).ok_silently();
        let file = place.read("picture.ppm");
        let rgb = file.strip_prefix(b"P6\n144 108\n255\n").expect("a PPM file of this size");
        let rgba: Vec<u8> = rgb.chunks_exact(3).flat_map(|p| [p[0], p[1], p[2], 255]).collect();
        golden::check("primitives", name, 144, 108, &rgba);
    }
}

#[test]
fn golden_edges_and_lines() {
    let pictures = [
        ("edges", "--edges"),
        ("edges_wide_translucent", "--edges --line-width 4 --edge-color #c0203080"),
        ("edges_feature_silhouette", "--edges=feature,silhouette --line-width 2"),
        ("wireframe", "--mode wireframe"),
        ("tubes", "--mode wireframe --line-shape tube --line-width 5"),
        ("hidden_line", "--mode hidden-line"),
        ("feature_edges", "--mode edges"),
        ("boundary", "--mode edges --edges=boundary --line-width 3"),
        ("silhouette", "--mode edges --edges=silhouette --line-width 3"),
    ];
    check("builtin:teapot@600", &pictures);
}

/// A wave of bent quadrilaterals and hexagons, and quadrilaterals with a reflex angle, or nearly.
fn polygons() -> String {
    use std::fmt::Write as _;
    let mut obj = String::new();
    let (mut corners, mut faces) = (0, String::new());
    let mut polygon = |obj: &mut String, points: &[[f64; 2]]| {
        for [x, z] in points {
            let y = 0.35 * (2.5 * x).sin() * (2.0 * z).cos();
            writeln!(obj, "v {x} {y} {z}").expect("a string");
        }
        faces += "f";
        for k in 1..=points.len() {
            write!(faces, " {}", corners + k).expect("a string");
        }
        faces += "\n";
        corners += points.len();
    };
    for (i, j) in (0..20).map(|k| (f64::from(k / 5) - 2.0, f64::from(k % 5) - 2.5)) {
        let at = |x: f64, z: f64| [0.5 * (i + x), 0.5 * (j + z)];
        match (i as i32 + j as i32).rem_euclid(3) {
            0 => polygon(&mut obj, &[at(0.0, 0.0), at(0.0, 1.0), at(1.0, 1.0), at(1.0, 0.0)]),
            1 => polygon(
                &mut obj,
                &[at(0.0, 0.0), at(0.0, 0.6), at(0.3, 1.0), at(1.0, 1.0), at(1.0, 0.4), at(0.7, 0.0)],
            ),
            _ => polygon(&mut obj, &[at(0.0, 0.0), at(0.4, 0.6), at(1.0, 1.0), at(1.0, 0.0)]),
        }
    }
    obj + &faces
}

#[test]
fn golden_edges_of_polygons_and_of_more_than_two_triangles() {
    let place = Place::new();
    std::fs::write(place.path("polygons.obj"), polygons()).expect("a file");
    let pictures = [
        ("edges_of_polygons", "--edges --line-width 2 --azimuth 30 --elevation 25"),
        ("hidden_line_of_polygons", "--mode hidden-line --azimuth 30 --elevation 8"),
    ];
    check_at(&place, "polygons.obj", &pictures);
    // Four sheets at one edge.
    let sheets = "v 0 -1 0\nv 0 1 0\nv 1 -1 0\nv 1 1 0\nv -1 -1 0\nv -1 1 0\nv 0 -1 1\nv 0 1 1\nv 0 -1 -1\nv 0 1 -1\n\
                  f 1 2 4 3\nf 1 2 6 5\nf 1 2 8 7\nf 1 2 10 9\n";
    std::fs::write(place.path("sheets.obj"), sheets).expect("a file");
    check_at(&place, "sheets.obj", &[("non_manifold", "--edges=non-manifold --line-width 4 --azimuth 25")]);
}

/// Lines and points of a file.
#[test]
fn golden_lines_and_points_of_files() {
    let place = Place::new();
    let points: Vec<String> = (0..40)
        .map(|k| {
            let (sin, cos) = (f64::from(k) * 0.5).sin_cos();
            format!("{cos} {} {sin}", f64::from(k) * 0.05)
        })
        .collect();
    let numbers = |range: std::ops::Range<usize>| range.map(|k| k.to_string()).collect::<Vec<_>>().join(" ");
    let heights: Vec<String> = (0..40).map(|k| k.to_string()).collect();
    let vtk = format!(
        "# vtk DataFile Version 3.0\nspiral\nASCII\nDATASET POLYDATA\nPOINTS 40 float\n{}\n\
         VERTICES 1 11\n10 {}\nLINES 1 31\n30 {}\nPOINT_DATA 40\nSCALARS height float\nLOOKUP_TABLE default\n{}\n",
        points.join("\n"),
        numbers(0..10),
        numbers(10..40),
        heights.join(" ")
    );
    std::fs::write(place.path("spiral.vtk"), vtk).expect("a file");
    let pictures = [
        ("file_lines_points", "--point-size 6 --line-width 3"),
        ("file_lines_points_data", "--color-by height --line-shape tube --point-shape sphere --point-size 9"),
    ];
    check_at(&place, "spiral.vtk", &pictures);
}

#[test]
fn golden_points_and_glyphs() {
    let pictures = [
        ("points_round", "--mode points --point-size 6"),
        ("points_square", "--mode points --point-shape square --point-size 5"),
        ("points_sphere", "--mode points --point-shape sphere --point-size 9"),
        ("points_in_units", "--mode points --point-shape sphere --point-size 0.1u"),
        ("points_one_sample", "--mode points --point-size 4 --aa 1"),
        ("arrows", "--glyphs @normal --glyph-every 3"),
        ("cones", "--glyphs @normal --glyph cone --glyph-every 3 --color-by @elevation"),
        ("glyph_lines", "--glyphs @normal --glyph line --glyph-every 2"),
        ("glyph_spheres", "--glyphs @normal --glyph sphere --glyph-every 3"),
    ];
    check("builtin:sphere@300", &pictures);
}

#[test]
fn golden_data() {
    let pictures = [
        ("data_vertices", "--color-by @elevation"),
        ("data_triangles", "--color-by @face --colormap turbo"),
        ("data_bands", "--color-by @elevation --bands 6 --colormap coolwarm"),
        ("data_isolines", "--color-by @elevation --isolines 7"),
        ("data_out_of_range", "--color-by @elevation --range 0.15,0.3 --below-color blue --above-color red"),
        ("data_opacity", "--color-by @elevation --opacity-map 0.1,1"),
        ("data_contours", "--color-by @elevation --mode contours"),
        ("data_and_edges", "--color-by @elevation --edges"),
        ("data_wireframe", "--color-by @elevation --mode wireframe"),
        ("data_tubes", "--color-by @face --mode wireframe --line-shape tube --colormap turbo"),
        ("data_feature_edges", "--color-by @elevation --mode edges --feature-angle 10 --line-width 2"),
        ("data_categories", "--color-by @face --categories --colormap turbo"),
        ("data_log", "--color-by @elevation --range 0.02,0.4 --log --bands 6"),
        ("data_symlog", "--color-by @normal:x --symlog=0.05 --colormap coolwarm"),
        ("data_colors", "--color-by @normal:rgb"),
    ];
    check("builtin:terrain@800", &pictures);
}
