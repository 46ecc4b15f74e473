//! Drawings of lines as SVG and PDF, and contours.

mod common;

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::fs;

use common::Place;

/// A unit cube of six squares.
const CUBE: &str = "OFF\n8 6 12\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 0 1\n1 0 1\n0 1 1\n1 1 1\n\
    4 0 2 3 1\n4 4 5 7 6\n4 0 1 5 4\n4 2 6 7 3\n4 0 4 6 2\n4 1 3 7 5\n";

/// The pieces of all lines of an SVG, in pixels. Coordinates are relative to the point before.
fn pieces(svg: &str) -> Vec<[[f64; 2]; 2]> {
    let mut pieces = Vec::new();
    for path in svg.lines().filter(|line| line.starts_with("<path fill=\"none\"")) {
        let data = path.split(" d=\"").nth(1).and_then(|rest| rest.split('"').next()).expect("a path");
        for line in data.split('M').filter(|line| !line.is_empty()) {
            let is_closed = line.ends_with('z');
            let numbers = line.trim_end_matches('z').replace(['l', 'h'], " ");
            let numbers: Vec<f64> =
                numbers.split_whitespace().map(|n| n.parse().expect("a number")).collect();
            let mut points = Vec::new();
            let mut at = [0.0; 2];
            for step in numbers.chunks_exact(2) {
                at = [at[0] + step[0], at[1] + step[1]];
                points.push(at);
            }
            points.extend(is_closed.then(|| points[0]));
            pieces.extend(points.windows(2).map(|pair| [pair[0], pair[1]]));
        }
    }
    pieces
}

fn length(pieces: &[[[f64; 2]; 2]]) -> f64 {
    pieces.iter().map(|[a, b]| (a[0] - b[0]).hypot(a[1] - b[1])).sum()
}

#[test]
fn of_a_cube_nine_edges_are_drawn() {
    let place = Place::new();
    fs::write(place.path("cube.off"), CUBE).unwrap();
    let camera = "--eye 3,2.5,4 --target 0.5,0.5,0.5 --size 300x200";
    place.run(&format!("render cube.off -o a.svg --mode hidden-line {camera}")).ok_silently();
    let svg = String::from_utf8(place.read("a.svg")).unwrap();
    let hidden = pieces(&svg);
    assert_eq!(hidden.len(), 9, "{svg}");
    place.run(&format!("render cube.off -o b.svg --mode wireframe {camera}")).ok_silently();
    let all = pieces(&String::from_utf8(place.read("b.svg")).unwrap());
    assert_eq!(all.len(), 12);
    // Seven of eight corners are seen, and the outline is a hexagon.
    let corners = |pieces: &[[[f64; 2]; 2]]| {
        pieces.iter().flatten().map(|p| p.map(|c| (c * 100.0).round() as i64)).collect::<BTreeSet<_>>().len()
    };
    assert_eq!((corners(&hidden), corners(&all)), (7, 8));
    place
        .run(&format!("render cube.off -o c.svg --mode hidden-line --edges=silhouette {camera}"))
        .ok_silently();
    assert_eq!(pieces(&String::from_utf8(place.read("c.svg")).unwrap()).len(), 6);
    // Sets of edges, none twice.
    for (which, count) in [("feature,silhouette", 9), ("silhouette,boundary", 6), ("all,silhouette", 9)] {
        place
            .run(&format!("render cube.off -o c.svg --mode hidden-line --edges={which} {camera}"))
            .ok_silently();
        assert_eq!(pieces(&String::from_utf8(place.read("c.svg")).unwrap()).len(), count, "{which}");
    }
    // White paper, or the colour that is asked for.
    assert!(svg.contains("<rect width=\"300\" height=\"200\" fill=\"#ffffff\"/>"));
    place
        .run(&format!("render cube.off -o - --format svg --mode edges --background transparent {camera}"))
        .ok_silently();
    let clear = place
        .run(&format!("render cube.off -o - --format svg --mode edges --background transparent {camera}"));
    assert!(!clear.text().contains("<rect"));
    let line = "--edge-color #ff000080 --line-width 3";
    place.run(&format!("render cube.off -o d.svg --mode hidden-line {line} {camera}")).ok_silently();
    let svg = String::from_utf8(place.read("d.svg")).unwrap();
    assert!(svg.contains("stroke=\"#ff0000\" stroke-opacity=\"0.502\" stroke-width=\"3\""), "{svg}");
}

#[test]
fn files_are_the_same_for_all_threads_and_series_are_resumed() {
    let place = Place::new();
    let model = "render builtin:teapot@5k --size 200x150 --mode hidden-line --title Teapot --axes";
    for format in ["svg", "pdf"] {
        for threads in [1, 3] {
            place.run(&format!("{model} -o {threads}.{format} --threads {threads}")).ok_silently();
        }
        assert!(place.read(&format!("1.{format}")) == place.read(&format!("3.{format}")), "{format}");
    }
    assert!(place.read("1.pdf").starts_with(b"%PDF-1.4") && place.read("1.pdf").ends_with(b"%%EOF\n"));
    // Text is outlines.
    assert!(
        String::from_utf8(place.read("1.svg"))
            .unwrap()
            .lines()
            .filter(|l| l.starts_with("<path fill=\"#"))
            .count()
            > 3
    );
    let series = "render builtin:sphere@200 --size 100x80 --mode hidden-line --turntable 4 -o t_{:02}.svg";
    place.run(series).ok_silently();
    let (kept, cut) = (place.read("t_01.svg"), place.read("t_02.svg"));
    fs::write(place.path("t_02.svg"), &cut[..cut.len() / 2]).unwrap();
    fs::remove_file(place.path("t_03.svg")).unwrap();
    let outcome = place.run(&format!("{series} --resume -v"));
    assert!(outcome.stderr.contains("2 pictures drawn, 2 found"), "{}", outcome.stderr);
    assert!(place.read("t_02.svg") == cut && place.read("t_01.svg") == kept);
    assert_eq!(place.names().iter().filter(|name| name.starts_with("t_")).count(), 4);
}

#[test]
fn what_is_not_possible_is_said() {
    let place = Place::new();
    place.run("render model.off -o a.svg").failed(2, &["SVG holds lines", "hidden-line"]);
    place.run("render model.off -o a.pdf --mode points").failed(2, &["PDF holds lines"]);
    let lines = "render model.off -o a.svg --mode hidden-line";
    place.run(&format!("{lines} --output-depth d.npy")).failed(2, &["--output-depth", "SVG"]);
    place.run(&format!("{lines} --stereo pair")).failed(2, &["--stereo", "one camera"]);
    place.run(&format!("{lines} --ranks 2")).failed(2, &["one process"]);
    place.run(&format!("{lines} --depth 16")).failed(2, &["--depth 16"]);
    place.run(&format!("{lines} --grid")).failed(2, &["--grid", "behind"]);
    place.run(&format!("{lines} --edges=non-manifold")).failed(1, &["no line is visible", "--allow-empty"]);
    place.run("render model.off -o a.png --mode contours").failed(2, &["--color-by"]);
    place
        .run("render model.off -o a.png --color-by @elevation --isoline-width 2")
        .failed(2, &["--isoline-width", "--mode contours"]);
    assert_eq!(place.names(), ["model.off"]);
    // A model that is only lines has no surface to refuse.
    fs::write(place.path("line.obj"), "v 0 0 0\nv 1 0 0\nv 1 1 0\nl 1 2 3\n").unwrap();
    place.run("render line.obj -o line.svg").ok_silently();
    assert!(String::from_utf8(place.read("line.svg")).unwrap().contains("stroke"));
    place.run(&format!("{lines} --edges=non-manifold --allow-empty -q")).ok_silently();
}

/// Three rectangles that meet in one edge.
#[test]
fn non_manifold_edges_are_told_apart_from_boundary() {
    let place = Place::new();
    let wings = "OFF\n8 3 0\n0 0 0\n0 1 0\n1 0 0\n1 1 0\n-1 0 1\n-1 1 1\n-1 0 -1\n-1 1 -1\n4 0 2 3 1\n4 0 1 5 4\n4 0 1 7 6\n";
    fs::write(place.path("wings.off"), wings).unwrap();
    let command = |which: &str| {
        format!("render wings.off -o a.svg --mode edges --edges={which} --eye 1,2,5 --target 0,0.5,0")
    };
    let outcome = place.run(&format!("{} -v", command("non-manifold")));
    assert!(
        outcome.stderr.contains("0 of two triangles, 0 of one (boundary), 1 of more (non-manifold)"),
        "{}",
        outcome.stderr
    );
    let count = |which: &str| {
        place.run(&command(which)).ok_silently();
        let svg = String::from_utf8(place.read("a.svg")).unwrap();
        let pieces = pieces(&svg);
        let key = |p: [f64; 2]| p.map(|c| (c * 100.0).round() as i64);
        let pieces: BTreeSet<_> = pieces
            .iter()
            .map(|[a, b]| if key(*a) < key(*b) { [key(*a), key(*b)] } else { [key(*b), key(*a)] })
            .collect();
        pieces.len()
    };
    assert_eq!((count("non-manifold"), count("boundary")), (1, 10));
}

/// A square of 8 x 8 cells, with x as data.
fn sheet() -> String {
    let mut obj =
        String::from("# vtk DataFile Version 3.0\nsheet\nASCII\nDATASET POLYDATA\nPOINTS 81 float\n");
    for i in 0..81 {
        let _ = writeln!(obj, "{} {} 0", i % 9, i / 9);
    }
    let _ = writeln!(obj, "POLYGONS 64 320");
    for i in 0..64 {
        let v = i % 8 + i / 8 * 9;
        let _ = writeln!(obj, "4 {} {} {} {}", v, v + 1, v + 10, v + 9);
    }
    let _ = writeln!(obj, "POINT_DATA 81\nSCALARS x float 1\nLOOKUP_TABLE default");
    for i in 0..81 {
        let _ = writeln!(obj, "{}", i % 9);
    }
    obj
}

#[test]
fn contours_are_bands_with_lines_between() {
    let place = Place::new();
    fs::write(place.path("sheet.vtk"), sheet()).unwrap();
    // All of it is in the picture.
    let camera = "--orthographic --eye 4,4,20 --target 4,4,0 --size 200x180 --no-bar";
    let options = "--mode contours --color-by x --bands 4 --edges=boundary";
    let drawn = place.run(&format!("render sheet.vtk -o a.svg {options} {camera}"));
    assert!(drawn.code == Some(0) && drawn.stderr.contains("leaves out the bands"), "{}", drawn.stderr);
    let svg = String::from_utf8(place.read("a.svg")).unwrap();
    let all = pieces(&svg);
    // Three lines from side to side, at 2, 4 and 6, and the boundary.
    let box_ = all.iter().flatten().fold([f64::MAX, f64::MIN, f64::MAX, f64::MIN], |b, p| {
        [b[0].min(p[0]), b[1].max(p[0]), b[2].min(p[1]), b[3].max(p[1])]
    });
    let side = box_[1] - box_[0];
    assert!((box_[3] - box_[2] - side).abs() < 1e-3, "{box_:?}");
    assert!((length(&all) / side - 7.0).abs() < 1e-4, "{}", length(&all) / side);
    assert_eq!(all.len(), 7, "{svg}");
    for share in [0.25, 0.5, 0.75] {
        let x = box_[0] + share * side;
        assert!(all.iter().any(|piece| piece.iter().all(|p| (p[0] - x).abs() < 1e-3)), "{share}: {svg}");
    }
    // As pixels: four colours of the map, unlit, and black lines.
    place.run(&format!("render sheet.vtk -o a.ppm --mode contours --color-by x --bands 4 --isoline-width 0 --background white {camera}")).ok_silently();
    let bytes = place.read("a.ppm");
    let colors: BTreeSet<[u8; 3]> =
        bytes[bytes.len() - 3 * 200 * 180..].as_chunks().0.iter().copied().collect();
    let inner: Vec<_> = colors.iter().filter(|c| **c != [255; 3]).collect();
    assert!(inner.len() >= 4, "{colors:?}");
    let middle = |x: f64| {
        let at = 3 * (90 * 200 + x as usize) + bytes.len() - 3 * 200 * 180;
        [bytes[at], bytes[at + 1], bytes[at + 2]]
    };
    let of_band = |band: f64| middle(box_[0] + (band + 0.5) / 4.0 * side);
    // The ends of viridis.
    assert_eq!((of_band(0.0), of_band(3.0)), ([0x44, 0x01, 0x54], [0xfd, 0xe7, 0x25]));
    assert_eq!((0..4).map(|band| of_band(f64::from(band))).collect::<BTreeSet<_>>().len(), 4);
    // Evenly spread lines make as many bands; ten without any number.
    let data = |options: &str| {
        let outcome = place.run(&format!(
            "render sheet.vtk -o a.png --mode contours --color-by x {options} --stats - -q {camera}"
        ));
        let stats = outcome.text().to_owned();
        let number = |key: &str| {
            stats
                .split(&format!("\"{key}\":"))
                .nth(1)
                .map(|rest| rest.trim_start().split([',', '\n']).next().unwrap_or_default().to_owned())
        };
        number("bands").unwrap_or_default()
    };
    assert_eq!([data(""), data("--isolines 3"), data("--isolines 1.5,7")], ["10", "4", "null"]);
}

/// The triangles of a strip are polygons of one cell: all of their sides are edges. Those of a quad are not divided.
#[test]
fn strips_have_the_sides_of_all_their_triangles() {
    let place = Place::new();
    let points = "POINTS 8 float\n0 0 0 0 1 0 1 0 .2 1 1 .3 2 0 0 2 1 0 3 0 .2 3 1 .1\n";
    let head = "# vtk DataFile Version 3.0\nstrip\nASCII\nDATASET POLYDATA\n";
    for (cells, edges) in [
        ("TRIANGLE_STRIPS 1 9\n8 0 1 2 3 4 5 6 7\n", 13),
        ("POLYGONS 3 15\n4 0 1 3 2\n4 2 3 5 4\n4 4 5 7 6\n", 10),
    ] {
        fs::write(place.path("a.vtk"), format!("{head}{points}{cells}")).unwrap();
        let camera = "--eye 1.5,0.4,6 --target 1.5,0.5,0 --size 300x200";
        place.run(&format!("render a.vtk -o a.svg --mode wireframe {camera}")).ok_silently();
        let found = pieces(&String::from_utf8(place.read("a.svg")).unwrap());
        assert_eq!(found.len(), edges, "{cells}");
    }
}

#[test]
fn samples_of_drawings_are_said_to_have_no_effect() {
    let place = Place::new();
    let ran = place.run("render builtin:teapot@200 --mode wireframe -o a.svg --aa 16");
    let said = ran.stderr.contains("--aa, --aa-shading and --aa-filter have no effect on SVG");
    assert!(ran.code == Some(0) && said, "{}", ran.stderr);
    place.run("render builtin:teapot@200 --mode wireframe -o b.svg").ok_silently();
    assert_eq!(place.read("a.svg"), place.read("b.svg"));
}
