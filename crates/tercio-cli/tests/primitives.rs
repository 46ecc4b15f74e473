//! Golden pictures of what is drawn besides surfaces: lines, points, glyphs, data.

mod common;

use common::Place;
use tercio_testkit::golden;

/// Draws small pictures with these options and compares them with `tests/golden/primitives/NAME.png`.
fn check(model: &str, pictures: &[(&str, &str)]) {
    let place = Place::new();
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
    ];
    check("builtin:teapot@600", &pictures);
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
    ];
    check("builtin:terrain@800", &pictures);
}
