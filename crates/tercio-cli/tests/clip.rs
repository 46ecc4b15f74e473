//! `--clip` and `--clip-cap`, as a user gives them.

mod common;

use common::Place;
use serde_json::Value;

const LOOK: &str = "--size 60x60 --shading unlit --background #fff -q";

fn json_of(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

/// The pixels of a PPM of 60x60.
fn pixels(picture: &[u8]) -> Vec<[u8; 3]> {
    picture[picture.len() - 60 * 60 * 3..].as_chunks::<3>().0.to_vec()
}

#[test]
fn planes_by_numbers_and_by_name_cut_the_same() {
    let place = Place::new();
    let draw = |name: &str, clip: &str| {
        place.run(&format!("render model.off -o {name}.ppm {LOOK} {clip}")).ok_silently();
        place.read(&format!("{name}.ppm"))
    };
    let whole = draw("whole", "");
    let right = draw("right", "--view front --clip 1,0,0,0");
    assert!(right == draw("named", "--view front --clip x:0.5"));
    assert!(right == draw("percent", "--view front --clip=x:50%"));
    assert!(right == draw("twice", "--view front --clip 3,0,0,0 --clip x:50%"));
    let left = draw("left", "--view front --clip -x:0.5");
    assert!(left == draw("minus", "--view front --clip -1,0,0,0"));
    // The camera stays: each half has the pixels of the whole on its side.
    let front = pixels(&draw("front", "--view front"));
    let (left, right) = (pixels(&left), pixels(&right));
    for (at, &pixel) in front.iter().enumerate() {
        let (here, there) = if at % 60 < 30 { (&left, &right) } else { (&right, &left) };
        assert_eq!((here[at], there[at]), (pixel, [255; 3]), "{at}");
    }
    // A plane that cuts nothing away changes no byte.
    assert!(whole == draw("all", "--clip x:0 --clip -x:100%"));
    assert!(whole == draw("far", "--clip-cap --clip 0,1,0,9"));
}

#[test]
fn caps_have_their_colour() {
    let place = Place::new();
    let middle = |clip: &str| {
        place.run(&format!("render model.off -o a.ppm --view left {LOOK} {clip}")).ok_silently();
        pixels(&place.read("a.ppm"))[60 * 30 + 30]
    };
    assert_eq!(middle("--clip x:0.5 --clip-cap=#12a4ff"), [0x12, 0xa4, 0xff]);
    assert_eq!(middle("--clip x:0.5 --clip-cap --color #0f0 --no-mesh-colors"), [0xc8, 0x55, 0x3d]);
    assert_eq!(middle("--clip x:0.5 --color #0f0"), [0, 255, 0], "the inside");
    // As any surface, a cap is lit, seen through and has a face number behind those of the model.
    for (clip, view) in [("x:0.5", "left"), ("-x:0.5", "right"), ("z:0.5", "back"), ("-z:0.5", "front")] {
        let options = format!("--output-ids ids.npy --view {view} --size 9x9 --clip={clip} --clip-cap -q");
        place.run(&format!("render model.off {options}")).ok_silently();
        let ids = place.read("ids.npy");
        let id = u32::from_le_bytes(ids[ids.len() - 41 * 4..ids.len() - 40 * 4].try_into().unwrap());
        assert_eq!(id, 8, "{clip}: the octahedron has faces 0 to 7, whichever are cut away");
    }
}

#[test]
fn statistics_and_notes_count_what_was_cut_away() {
    let place = Place::new();
    let run = place.run("render model.off -o a.png --clip x:0.75 --clip-cap --stats - --size 30x20 -v");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert!(
        run.stderr.contains("4 triangles cut away, 4 triangles cut; 1 outline capped with 2 triangles"),
        "{}",
        run.stderr
    );
    let stats = json_of(run.text());
    let clipped = stats.pointer("/load/clipped").expect("counts");
    for (key, value) in
        [("removed", 4), ("cut", 4), ("cap_triangles", 2), ("outlines", 1), ("open_outlines", 0)]
    {
        assert_eq!(clipped[key], value, "{key}");
    }
    assert_eq!(stats["load"]["triangles"], 4);
    let whole = place.run("render model.off -o a.png --stats - --size 30x20 -q").ok_silently();
    assert!(json_of(whole.text())["load"]["clipped"].is_null());
}

#[test]
fn open_outlines_are_reported() {
    let place = Place::new();
    let run = place.run("render builtin:terrain@2k -o a.png --size 30x20 --clip x:0.5 --clip-cap");
    assert_eq!(run.code, Some(0));
    assert!(
        run.stderr.contains("warning: builtin:terrain@2k: 1 outline of the cut is not closed"),
        "{}",
        run.stderr
    );
    place.run("render builtin:terrain@2k -o a.png --size 30x20 --clip x:0.5").ok_silently();
}

#[test]
fn a_model_that_is_cut_away_whole_is_an_error() {
    let place = Place::new();
    let run = place.run("render model.off -o a.png --clip 1,0,0,-5");
    run.failed(
        1,
        &["model.off: nothing was drawn: all 8 triangles are on the other side of a plane (--clip)"],
    );
    assert!(!place.path("a.png").exists());
    let run = place.run("render model.off -o a.png --clip 1,0,0,-5 --allow-empty");
    assert!(run.code == Some(0) && place.path("a.png").exists());
}

#[test]
fn bad_planes_are_usage_errors() {
    let place = Place::new();
    for (clip, parts) in [
        ("--clip 0,0,0,1", ["--clip", "not zero"]),
        ("--clip nan,0,0,1", ["--clip", "not zero"]),
        ("--clip 1,2,3", ["--clip", "X,Y,Z,D"]),
        ("--clip x:1.5", ["--clip", "0 to 1"]),
        ("--clip u:0.5", ["--clip", "x, y or z"]),
        ("--clip-cap", ["--clip", "required"]),
        ("--clip x:0.5 --clip-cap=reddish", ["--clip-cap", "a colour"]),
    ] {
        place.run(&format!("render model.off -o a.png {clip}")).failed(2, &parts);
    }
}

#[test]
fn prepared_models_name_what_is_to_be_clipped() {
    let place = Place::new();
    place.run("prepare model.off -o model.tercio -q").ok_silently();
    let run = place.run("render model.tercio -o a.png --clip x:0.5");
    run.failed(1, &["model.tercio", "prepared", "model.off"]);
}

#[test]
fn the_picture_does_not_depend_on_how_it_is_drawn() {
    let place = Place::new();
    let render = "render builtin:sphere@20k --size 150x110 --clip 1,0.2,0,0.1 --clip -z:60% --clip-cap -q";
    place.run(&format!("{render} -o a.png")).ok_silently();
    let options = [
        "--threads 1 --tile-size 8",
        "--ranks 3 --organisation sort-first",
        "--ranks 2 --organisation sort-last",
        "--sorting triangles --no-cluster-culling --simd scalar",
    ];
    for (i, options) in options.into_iter().enumerate() {
        place.run(&format!("{render} -o {i}.png {options}")).ok_silently();
        assert!(place.read("a.png") == place.read(&format!("{i}.png")), "{options}");
    }
}

/// Real models, cut and capped in the middle: something is left, and nothing but a warning is said.
#[test]
fn shared_models_are_clipped() {
    let Some(data) = tercio_testkit::require_shared("shared_models_are_clipped") else { return };
    let place = Place::new();
    let mut drawn = 0;
    let folders = ["off", "obj", "ply", "stl"].map(|format| data.join("meshes").join(format));
    let entries =
        folders.iter().flat_map(|folder| std::fs::read_dir(folder).expect("a folder of the shared data"));
    let mut paths: Vec<_> = entries.map(|e| e.expect("an entry").path()).collect();
    paths.sort();
    for path in paths {
        let small = path.metadata().is_ok_and(|m| m.is_file() && m.len() < 8 << 20);
        let name = path.to_string_lossy().into_owned();
        if !small || !["ply", "obj", "stl", "off"].iter().any(|e| name.ends_with(&format!(".{e}"))) {
            continue;
        }
        let mut command =
            place.command("render -o a.png --size 40x30 --clip-cap --clip z:0.4 --clip -x:60% --allow-empty");
        let run = common::Outcome::from(command.arg(&path).output().expect("the program starts"));
        assert_eq!(run.code, Some(0), "{name}: {}", run.stderr);
        drawn += 1;
    }
    assert!(drawn > 3, "{drawn} models");
}

/// A cloud, and a line: both are cut, and the camera stays that of the whole.
#[test]
fn points_and_lines_are_cut() {
    let place = Place::new();
    std::fs::write(place.path("cloud.xyz"), "0 0 0\n1 0 0\n2 0 0\n3 0 0\n4 0 0\n0 0 2\n4 0 2\n").unwrap();
    let line = "# vtk DataFile Version 3.0\nline\nASCII\nDATASET POLYDATA\nPOINTS 2 float\n0 0 0 4 0 2\nLINES 1 3 2 0 1\n";
    std::fs::write(place.path("line.vtk"), line).unwrap();
    for (model, options) in
        [("cloud.xyz", "--point-size 5 --point-shape square"), ("line.vtk", "--line-width 5")]
    {
        let draw = |clip: &str| {
            let look = "--view front --up-axis z --color #000 --aa 1";
            place.run(&format!("render {model} -o a.ppm {look} {options} {LOOK} {clip}")).ok_silently();
            pixels(&place.read("a.ppm"))
        };
        let (whole, cut) = (draw(""), draw("--clip x:0.6"));
        for (number, (whole, cut)) in whole.iter().zip(&cut).enumerate() {
            // The rightmost columns are as before, and the left half is empty.
            let column = number % 60;
            if column < 30 {
                assert_eq!(*cut, [255; 3], "{model}, column {column}");
            } else if column > 45 {
                assert_eq!(cut, whole, "{model}, column {column}");
            }
        }
        let count = |pixels: &[[u8; 3]]| pixels.iter().filter(|p| **p != [255; 3]).count();
        assert!(count(&cut) > 20 && count(&cut) < count(&whole), "{model}");
    }
}
