//! Colours by data, as a user draws them.

mod common;

use std::fs;

use common::Place;

/// Two squares side by side, of two triangles each: quality 0 at the left border to 8 at the right one, a number for each face,
/// and one that is not a number.
const MODEL: &str = "ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\nproperty float z\n\
    property float quality\nproperty float red_v\nproperty float odd\nelement face 2\n\
    property list uchar int vertex_indices\nproperty int part\nend_header\n\
    0 0 0 0 1 1\n2 0 0 4 1 1\n4 0 0 8 1 nan\n0 2 0 0 1 1\n2 2 0 4 1 1\n4 2 0 8 1 2\n\
    4 0 1 4 3 7\n4 1 2 5 4 9\n";

const VIEW: &str =
    "--view front --orthographic --no-bar --shading unlit --background #fff --size 64x32 --aa 1";

#[test]
fn values_become_colors() {
    let place = Place::new();
    fs::write(place.path("a.ply"), MODEL).unwrap();
    let render = |options: &str| {
        place.run(&format!("render a.ply -o a.ppm -q {VIEW} {options}")).ok_silently();
        let picture = place.read("a.ppm");
        let pixels = &picture[picture.len() - 64 * 32 * 3..];
        let row: Vec<[u8; 3]> = (0..64).map(|x| [0, 1, 2].map(|k| pixels[3 * (64 * 16 + x) + k])).collect();
        let on_model = row.iter().position(|c| *c != [255; 3]).unwrap()
            ..64 - row.iter().rev().position(|c| *c != [255; 3]).unwrap();
        row[on_model].to_vec()
    };
    let different = |row: &[[u8; 3]]| {
        let mut row = row.to_vec();
        row.dedup();
        row
    };
    let smooth = render("--color-by quality --colormap gray --range 0,9");
    let is_even = |(i, c): (usize, &[u8; 3])| {
        (f64::from(c[0]) - (i as f64 + 0.5) * 8.0 / 9.0 * 255.0 / smooth.len() as f64).abs() < 3.5
    };
    assert!(smooth.iter().enumerate().all(is_even), "{smooth:?}");
    assert_eq!(different(&render("--color-by quality --bands 2 --colormap bwr")), [[0, 0, 255], [255, 0, 0]]);
    assert_eq!(different(&render("--scalars part --cmap bwr --clim 7,9")), [[0, 0, 255], [255, 0, 0]]);
    assert_eq!(different(&render("--color-by part --categories=7=bone")), [[228, 26, 28], [55, 126, 184]]);
    assert_eq!(different(&render("--color-by @face --colormap bwr")), [[0, 0, 255], [255, 0, 0]]);
    let beyond = "--range 2,6 --bands 2 --below-color #010203 --above-color #040506 --colormap bwr";
    let beyond = render(&format!("--color-by quality {beyond}"));
    assert_eq!(different(&beyond), [[1, 2, 3], [0, 0, 255], [255, 0, 0], [4, 5, 6]]);
    assert!(render("--color-by odd --nan-color #0a0b0c").contains(&[10, 11, 12]));
    // The file of a colour map may have one, which the option replaces; likewise the colours beyond the range.
    let map = "[{\"RGBPoints\":[0,0,0,1,1,0,0,1],\"NanColor\":[1,1,0],\"UseBelowRangeColor\":1,\"BelowRangeColor\":[0,1,0],\
        \"UseAboveRangeColor\":0,\"AboveRangeColor\":[1,0,0]}]";
    fs::write(place.path("map.json"), map).unwrap();
    assert!(render("--color-by odd --colormap map.json").contains(&[255, 255, 0]));
    let given = render("--color-by odd --colormap map.json --nan-color #0a0b0c");
    assert!(given.contains(&[10, 11, 12]) && !given.contains(&[255, 255, 0]));
    let beyond = render("--color-by quality --colormap map.json --bands 1 --range 2,6");
    assert_eq!(different(&beyond), [[0, 255, 0], [0, 0, 255]]);
    // Contours at values that are not spread evenly: 0 to 1 has the colour of 0.5, 1 to 6 that of 3.5, 6 to 8 that of 7.
    let contours = "--color-by quality --colormap gray --mode contours --isolines 1,6 --isoline-width 0";
    assert_eq!(different(&render(contours)), [[16; 3], [112; 3], [223; 3]]);
    fs::write(place.path("map.txt"), "# mine\n10 20 30\n200 20 30\n").unwrap();
    assert_eq!(
        different(&render("--color-by quality --bands 2 --colormap map.txt")),
        [[10, 20, 30], [200, 20, 30]]
    );
    // Half of black and half of white in linear light.
    assert_eq!(
        different(&render("--color-by quality --range 100,200 --colormap gray --opacity-map 0.5,1")),
        [[188; 3]]
    );
}

/// A colour map that names values is one of categories: a warning says that the data have other values.
#[test]
fn colors_that_name_values_are_those_of_categories() {
    let place = Place::new();
    fs::write(place.path("a.ply"), MODEL).unwrap();
    let map = |annotations: &str| {
        format!(
            "[{{\"IndexedColors\":[1,0,0,0,1,0,0,0,1],\"Annotations\":[{annotations}],\"NanColor\":[1,1,0]}}]"
        )
    };
    fs::write(place.path("all.json"), map("\"9\",\"skin\",\"7\",\"bone\"")).unwrap();
    fs::write(place.path("one.json"), map("\"9\",\"skin\"")).unwrap();
    let view = "--view front --orthographic --shading unlit --background #fff --size 400x300 --aa 1";
    let has =
        |picture: &[u8], color: [u8; 3]| picture.chunks_exact(3).filter(|pixel| *pixel == color).count();
    let draw = |map: &str, more: &str| {
        let run = place.run(&format!("render a.ply -o a.ppm --color-by part --colormap {map} {view} {more}"));
        assert_eq!(run.code, Some(0), "{}", run.stderr);
        let picture = place.read("a.ppm");
        (picture[picture.len() - 400 * 300 * 3..].to_vec(), run.stderr.clone())
    };
    let (all, told) = draw("all.json", "");
    assert!(has(&all, [255, 0, 0]) > 1000 && has(&all, [0, 255, 0]) > 1000, "the colours of 9 and 7");
    assert_eq!(has(&all, [255, 255, 0]), 0, "nothing is explained that is not there");
    assert!(told.is_empty(), "{told}");
    assert!(all == draw("all.json", "--categories").0);
    let (one, told) = draw("one.json", "");
    assert!(has(&one, [255, 0, 0]) > 1000 && has(&one, [255, 255, 0]) > 1000, "7 has the colour of NaN");
    assert!(told.contains("one.json does not name"), "{told}");
    let idle = "\"9\",\"skin\",\"x\",\"no number\",\"7\",\"bone\",\"9\",\"again\"";
    fs::write(place.path("idle.json"), map(idle)).unwrap();
    let (_, told) = draw("idle.json", "");
    assert!(told.contains("2 of the annotations of idle.json") && told.contains("\"no number\""), "{told}");
    let (_, told) = draw("all.json", "--range 7,9");
    assert!(told.contains("labels are left out"), "{told}");
    // The models of a sheet are alike.
    place.run("sheet a.ply a.ply -o s.png --color-by part --colormap all.json --size 99x99 -q").ok_silently();
}

/// A colour of a map for what is no number is explained where something has it.
#[test]
fn the_color_of_no_number_is_explained_where_it_is() {
    let place = Place::new();
    fs::write(place.path("a.ply"), MODEL).unwrap();
    let map = "[{\"RGBPoints\":[0,0,0,1,1,0,0,1],\"NanColor\":[1,1,0]}]";
    fs::write(place.path("map.json"), map).unwrap();
    let yellow = |options: &str| {
        let view = "--view front --shading unlit --background #fff --size 400x300 --aa 1";
        place.run(&format!("render a.ply -o a.ppm -q {view} {options}")).ok_silently();
        let picture = place.read("a.ppm");
        picture[picture.len() - 400 * 300 * 3..]
            .chunks_exact(3)
            .filter(|pixel| *pixel == [255, 255, 0])
            .count()
    };
    assert_eq!(yellow("--color-by quality --colormap map.json"), 0);
    let (with, without) =
        (yellow("--color-by odd --colormap map.json"), yellow("--color-by odd --colormap map.json --no-bar"));
    assert!(with > 0 && without > 0, "{with} {without}");
    assert!(yellow("--color-by quality --nan-color #ffff00") > 50, "asked for");
}

/// An isoline at the end of the data, which is rounded to `f32`, gives no warning; lines beyond the data do.
#[test]
fn isolines_beside_the_data_are_told() {
    let place = Place::new();
    fs::write(
        place.path("a.ply"),
        MODEL.replace("2 0 0 4 1 1\n4 0 0 8", "2 0 0 4 1 1\n4 0 0 8.7").replace("4 2 0 8 ", "4 2 0 8.7 "),
    )
    .unwrap();
    let run = |line: &str| {
        let text = format!("render a.ply -o a.png --color-by quality --isolines={line}, --size 64x48");
        place.run(&text).stderr
    };
    assert_eq!(run("8.7"), "");
    assert_eq!(run("0"), "");
    let told = run("8.8");
    assert!(told.contains("no isoline is drawn") && told.contains("0 to 8.7"), "{told}");
}

#[test]
fn what_is_wrong_is_told_with_what_there_is() {
    let place = Place::new();
    fs::write(place.path("a.ply"), MODEL).unwrap();
    let run = |options: &str| place.run(&format!("render a.ply -o a.png --size 20x20 {options}"));
    run("--color-by q").failed(
        1,
        &["a.ply: there is no attribute \"q\"", "quality (vertices)", "part (triangles)", "@elevation"],
    );
    run("--color-by quality:3").failed(1, &["a.ply: \"quality\" has no component \"3\"", "magnitude"]);
    run("--color-by quality --log --range 0,1").failed(1, &["range above 0"]);
    run("--color-by @normal --bands 3").failed(1, &["are colours"]);
    run("--color-by part --isolines 3").failed(1, &["isolines need values at vertices"]);
    run("--colormap viridis").failed(2, &["--color-by"]);
    run("--color-by quality --colormap 0,black,1,whyte")
        .failed(2, &["0,black,1,whyte", "\"whyte\" is no colour"]);
    run("--color-by quality --colormap 0.0,black,0.5").failed(2, &["the value 0.5 has no colour"]);
    run("--color-by quality --colormap virridis")
        .failed(2, &["no colour map \"virridis\"", "viridis, magma", "Set1"]);
    run("--color-by quality --range 3,1").failed(2, &["MIN below MAX"]);
    run("--color-by quality --categories --log").failed(2, &["--log"]);
    fs::write(place.path("map.txt"), "10 20 30\nred\n").unwrap();
    run("--color-by quality --colormap map.txt").failed(1, &["map.txt as a colour map", "line 2", "`red`"]);
    // Of points alone, too.
    let points = "# vtk DataFile Version 3.0\n\nASCII\nDATASET POLYDATA\nPOINTS 2 float\n0 0 0 1 1 1\nVERTICES 1 3\n2 0 1\nPOINT_DATA 2\nVECTORS vec float\n1 2 3 4 5 6\n";
    fs::write(place.path("points.vtk"), points).unwrap();
    place
        .run("render points.vtk -o p.png --size 20x20 --color-by vec:3")
        .failed(1, &["points.vtk: \"vec\" has no component \"3\"", "magnitude"]);
    fs::write(place.path("map.txt"), "0 0 0\n1 1 1\n").unwrap();
    place
        .run("render a.ply -o map.txt --format ppm --color-by quality --colormap map.txt")
        .failed(2, &["map.txt"]);
    assert!(!place.names().contains(&"a.png".into()));
}

#[test]
fn what_every_format_has_can_be_named() {
    let place = Place::new();
    let header: String =
        ["x", "y", "z", "nx", "ny", "nz", "s", "t"].map(|p| format!("property float {p}\n")).concat();
    let ply = format!(
        "ply\nformat ascii 1.0\nelement vertex 3\n{header}property uchar red\nproperty uchar green\nproperty uchar blue\n\
         element face 1\nproperty list uchar int vertex_indices\nend_header\n\
         0 0 0 0 0 1 0 0.5 10 20 30\n1 0 0 0 0.6 0.8 1 0 50 20 30\n0 1 0 0 0 1 0.25 0 90 20 30\n3 0 1 2\n"
    );
    fs::write(place.path("a.ply"), ply).unwrap();
    fs::write(
        place.path("a.xyz"),
        "4500000.1 0 3 10 20 30\n4500000.2 1 5 10 200 30\n4500000.3 2 5 10 20 30\n",
    )
    .unwrap();
    let vtk = "# vtk DataFile Version 3.0\n\nASCII\nDATASET POLYDATA\nPOINTS 3 float\n0 0 0 1 0 0 0 1 0\nPOLYGONS 1 4\n3 0 1 2\n\
        POINT_DATA 3\nNORMALS n float\n0 0 1 0 0.6 0.8 0 0 1\nTEXTURE_COORDINATES tc 2 float\n0 0 1 0 0 0.5\n";
    fs::write(place.path("a.vtk"), vtk).unwrap();
    let range = |file: &str, name: &str| {
        place
            .run(&format!("render {file} -o a.png -q --size 20x20 --stats r.json --color-by {name}"))
            .ok_silently();
        let stats: serde_json::Value = serde_json::from_slice(&place.read("r.json")).unwrap();
        let range = &stats["look"]["data"]["range"];
        [0, 1].map(|k| range[k].as_f64().unwrap_or_else(|| panic!("{file} {name}: {stats}")))
    };
    for (file, name, [low, high]) in [
        ("a.ply", "x", [0.0, 1.0]),
        ("a.ply", "red", [10.0, 90.0]),
        ("a.ply", "t", [0.0, 0.5]),
        ("a.ply", "ny", [0.0, 0.6]),
        ("a.xyz", "green", [20.0, 200.0]),
        ("a.xyz", "x", [4500000.1, 4500000.3]),
        ("a.xyz", "@z", [3.0, 5.0]),
        ("a.vtk", "n:y", [0.0, 0.6]),
        ("a.vtk", "tc:0", [0.0, 1.0]),
    ] {
        let found = range(file, name);
        assert!((found[0] - low).abs() < 1e-3 && (found[1] - high).abs() < 1e-3, "{file} {name}: {found:?}");
    }
    let info = place.run("info a.vtk").ok_silently();
    assert!(info.text().contains("n:0") && info.text().contains("tc:1"), "{}", info.text());
    // Points have no surface.
    for name in ["@normal", "@normal:x", "@face", "@component", "@curvature", "nx", "u"] {
        place.run(&format!("render a.xyz -o b.png --color-by {name}")).failed(
            1,
            &[&format!(
                "a.xyz: there is no attribute \"{name}\"; there are @elevation, @x, @y, @z, @color (red"
            )],
        );
    }
}

#[test]
fn what_does_not_fit_the_data_is_told() {
    let place = Place::new();
    fs::write(place.path("a.ply"), MODEL).unwrap();
    let stderr = |options: &str| {
        let outcome = place.run(&format!("render a.ply -o a.png --size 20x20 --color-by {options}"));
        assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
        outcome.stderr
    };
    for (options, parts) in [
        ("quality --range 100,200", &["no value is in the range 100 to 200: \"quality\" has 0 to 8"][..]),
        ("quality --isolines 9,10", &["no isoline is drawn", "0 to 8"]),
        ("quality --log", &["at or below 0", "--symlog"]),
        ("quality --log --range 1,", &[]),
        ("quality --categories --colormap bwr", &[]),
        ("quality --isolines 4,10", &[]),
    ] {
        let text = stderr(options);
        assert_eq!(text.matches("warning").count(), usize::from(!parts.is_empty()), "{options}: {text}");
        parts.iter().for_each(|part| assert!(text.contains(part), "{options}: {text}"));
    }
    let header = "ply\nformat ascii 1.0\nelement vertex 50\nproperty float x\nproperty float y\nproperty float z\n\
        property float q\nelement face 24\nproperty list uchar int vertex_indices\nend_header\n";
    let vertices = (0..50).map(|v| format!("{} {} 0 {}\n", v / 2, v % 2, v / 2));
    let triangles = (0..24).map(|i| format!("3 {} {} {}\n", 2 * i, 2 * i + 2, 2 * i + 1));
    let many = header.to_owned() + &vertices.chain(triangles).collect::<String>();
    fs::write(place.path("many.ply"), many).unwrap();
    let outcome = place.run("render many.ply -o a.png --size 20x20 --color-by q --categories");
    assert!(
        outcome.stderr.contains("25 categories of \"q\" share the 20 colours of tab20"),
        "{}",
        outcome.stderr
    );
}

/// Ids that 32 bits round, and numbers that differ by less than these tell.
const DOUBLES: &str = "ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\nproperty float z\n\
    property double id\nproperty double q\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n\
    0 0 0 16777217 1000000000.000\n2 0 0 16777218 1000000000.004\n4 0 0 16777219 1000000000.008\n\
    0 2 0 16777217 1000000000.000\n2 2 0 16777218 1000000000.004\n4 2 0 16777219 1000000000.008\n\
    4 0 1 4 3\n4 1 2 5 4\n";

#[test]
fn numbers_of_64_bits_keep_their_differences() {
    let place = Place::new();
    fs::write(place.path("a.ply"), MODEL).unwrap();
    fs::write(place.path("d.ply"), DOUBLES).unwrap();
    let info = place.run("info d.ply").ok_silently();
    assert!(info.text().contains("id (vertex): 16777217 to 16777219"), "{}", info.text());
    assert!(info.text().contains("q (vertex): 1000000000 to 1000000000.008"), "{}", info.text());
    let draw = |model: &str, options: &str| {
        place.run(&format!("render {model} -o a.ppm -q {VIEW} --color-by {options}")).ok_silently();
        place.read("a.ppm")
    };
    // 0 to 8 of the other model are the same differences.
    let plain = draw("a.ply", "quality");
    let close = |a: &[u8], b: &[u8]| a.iter().zip(b).all(|(a, b)| a.abs_diff(*b) <= 1);
    assert!(close(&plain, &draw("d.ply", "q")) && close(&plain, &draw("d.ply", "id")));
    assert!(close(
        &draw("a.ply", "quality --range 2,6"),
        &draw("d.ply", "q --range 1000000000.002,1000000000.006")
    ));
    assert!(draw("d.ply", "id --categories=16777218=b") == draw("a.ply", "quality --categories=4=b"));
    place.run("prepare d.ply -o d.tercio -q").ok_silently();
    assert!(draw("d.ply", "q") == draw("d.tercio", "q"));
}

/// A colour means the same on all models of a picture that are coloured alike, and one bar says what.
#[test]
fn models_of_one_picture_have_one_scale() {
    let place = Place::new();
    for (name, shift, values) in [("a.ply", 0.0, [1.0, 2.0, 3.0]), ("b.ply", 2.0, [7.0, 10.0, 11.0])] {
        let points = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].iter().zip(values);
        let points: String = points.map(|([x, y], v)| format!("{} {y} 0 {v}\n", x + shift)).collect();
        let head = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                    property float p\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
        fs::write(place.path(name), format!("{head}{points}3 0 1 2\n")).unwrap();
    }
    let draw = |options: &str| {
        let command = format!(
            "render a.ply b.ply --together -o p.png --size 300x200 --stats s.json -q --color-by p {options}"
        );
        place.run(&command).ok_silently();
        let stats: serde_json::Value = serde_json::from_slice(&place.read("s.json")).unwrap();
        let drawn = stats["look"]["annotation"]["drawn"].as_array().unwrap().clone();
        (place.read("p.png"), drawn.iter().filter(|what| what.to_string().contains("bar")).count())
    };
    assert!(draw("") == draw("--range 1,11") && draw("").1 == 1);
    assert!(draw("--range-over first") == draw("--range 1,3"));
    let of_categories = draw("--categories");
    assert_eq!(of_categories.1, 1);
    let each = draw("--range-over each");
    assert_eq!(each.1, 2);
    assert!(each.0 != draw("").0 && of_categories.0 != draw("").0);
}

#[test]
fn the_first_step_of_a_series_may_be_constant() {
    let place = Place::new();
    let model = |values: [&str; 3]| {
        let points = ["0 0 0", "1 0 0", "0 1 0"].iter().zip(values).map(|(p, v)| format!("{p} {v}\n"));
        format!(
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nproperty double p\n\
             element face 1\nproperty list uchar int vertex_indices\nend_header\n{}3 0 1 2\n",
            points.collect::<String>()
        )
    };
    for [constant, more] in [["1000000000", "1000000003"], ["1013.25", "1013.25002"]] {
        fs::write(place.path("s0.ply"), model([constant; 3])).unwrap();
        fs::write(place.path("s1.ply"), model([constant, more, more])).unwrap();
        let run = format!("render s0.ply s1.ply -o s{{step}}.png --color-by p -q {VIEW}");
        place.run(&run).ok_silently();
        // The first has the lowest colour in the range of both.
        let alone = format!("render s0.ply -o alone.png --color-by p --range {constant},{more} -q {VIEW}");
        place.run(&alone).ok_silently();
        assert!(place.read("s0.png") == place.read("alone.png"), "{constant}");
        let with_colors = place.read("s0.png");
        place.run(&format!("render s0.ply -o alone.png -q {VIEW}")).ok_silently();
        assert!(with_colors != place.read("alone.png"));
    }
    // A value has one category in all steps.
    fs::write(place.path("s0.ply"), model(["0.1"; 3])).unwrap();
    fs::write(place.path("s1.ply"), model(["0.1", "0.2", "0.2"])).unwrap();
    place
        .run(&format!(
            "render s0.ply s1.ply -o s{{step}}.png --color-by p --categories --stats s.json -q {VIEW}"
        ))
        .ok_silently();
    let stats = String::from_utf8(place.read("s.json")).unwrap();
    let count = |label: &str| stats.matches(&format!("\"label\": \"{label}")).count();
    assert!(count("0.1") > 0 && count("0.1") == count("0.2"), "{stats}");
}

#[test]
fn the_picture_does_not_depend_on_how_it_is_drawn() {
    let place = Place::new();
    let model = "render builtin:terrain@2k --color-by @elevation --isolines 7 --bands 12 --size 120x90 -q";
    place.run(&format!("{model} -o a.png")).ok_silently();
    for how in [
        "--ranks 3 --organisation sort-last",
        "--ranks 2 --organisation sort-first",
        "--threads 1 --tile-size 8",
    ] {
        place.run(&format!("{model} -o b.png {how}")).ok_silently();
        assert!(place.read("a.png") == place.read("b.png"), "{how}");
    }
    place.run("prepare builtin:terrain@2k -o a.tercio -q").ok_silently();
    place.run(&format!("{} -o b.png", model.replace("builtin:terrain@2k", "a.tercio"))).ok_silently();
    assert!(place.read("a.png") == place.read("b.png"), "prepared");
    place.run("render a.tercio -o b.png --color-by @curvature").failed(1, &["not of a prepared one"]);
    place.run("render builtin:sphere@2k -o b.png -q --size 20x20 --color-by @curvature").ok_silently();
    place.run("render builtin:soup@2k -o b.png -q --size 20x20 --color-by @component").ok_silently();
}
