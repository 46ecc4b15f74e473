//! `tercio info` from the outside.

mod common;

use common::{OCTAHEDRON, Place};

#[test]
fn a_model_is_described_for_people() {
    let place = Place::new();
    let outcome = place.run("info model.off").ok_silently();
    for part in ["model.off", "OFF", "triangles", "vertices", "closed", "consistently wound", "times"] {
        assert!(outcome.text().contains(part), "{part} is not in {}", outcome.text());
    }
    // Values are aligned.
    let columns: Vec<_> = outcome
        .text()
        .lines()
        .map(|l| l.find("  ").map(|at| at + l[at..].len() - l[at..].trim_start().len()))
        .collect();
    assert!(columns.iter().all(|c| *c == columns[0]), "{}", outcome.text());
}

#[test]
fn a_model_is_described_for_programs() {
    let place = Place::new();
    for outcome in
        [place.run("info model.off --json"), place.run_with_input("info - --json", OCTAHEDRON.as_bytes())]
    {
        let outcome = outcome.ok_silently();
        let info: serde_json::Value = serde_json::from_str(outcome.text()).unwrap();
        assert_eq!((&info["triangles"], &info["vertices"]), (&8.into(), &6.into()));
        assert_eq!(info["bounds"]["max"], serde_json::json!([1.0, 1.0, 1.0]));
        assert_eq!((&info["topology"]["closed"], &info["topology"]["components"]), (&true.into(), &1.into()));
        assert_eq!((&info["normals"], &info["vertex_colors"]), (&"none".into(), &false.into()));
        for key in
            ["attributes", "materials", "warnings", "repaired", "memory_bytes", "milliseconds", "format"]
        {
            assert!(!info[key].is_null(), "{key}");
        }
    }
}

#[test]
fn a_missing_model_is_an_error() {
    Place::new().run("info missing.ply").failed(1, &["missing.ply: "]);
}

#[test]
fn counts_of_defects_have_the_right_singular_or_plural() {
    let place = Place::new();
    let warnings = |text: &str| {
        std::fs::write(place.path("odd.obj"), text).expect("a model");
        let outcome = place.run("info odd.obj");
        assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
        outcome.stderr
    };
    let square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n";
    assert_eq!(warnings(square), "");
    let too_large = "that are not finite or too large for 32-bit floats";
    let one = warnings(&square.replace("v 0 1 0", "v 0 1e39 0"));
    assert!(
        one.contains(&format!("1 vertex has coordinates {too_large}; 1 triangle there was left out")),
        "{one}"
    );
    let two = warnings(&square.replace("v 1 0 0\nv 1 1 0", "v 1 0 nan\nv 1 1e39 0"));
    assert!(
        two.contains(&format!("2 vertices have coordinates {too_large}; 2 triangles there were left out")),
        "{two}"
    );
    let normals = warnings("v 0 0 0\nv 1 0 0\nv 1 1 0\nvn 0 0 1\nvn 0 0 0\nf 1//1 2//1 3//2\n");
    assert!(normals.contains("1 of 3 normals is missing, zero or not finite"), "{normals}");
}

#[test]
fn lines_and_points_have_bounds_and_attributes() {
    let place = Place::new();
    std::fs::write(place.path("cloud.csv"), "x,y,z,red,green,blue,height\n1,2,3,255,0,0,-1\n5,6,8,0,9,0,4\n")
        .expect("a cloud");
    let outcome = place.run("info cloud.csv --json").ok_silently();
    let info: serde_json::Value = serde_json::from_str(outcome.text()).unwrap();
    let strokes = &info["lines_and_points"];
    assert_eq!(strokes["bounds"]["min"], serde_json::json!([1.0, 2.0, 3.0]));
    assert_eq!(strokes["bounds"]["size"], serde_json::json!([4.0, 4.0, 5.0]));
    assert_eq!(strokes["colors"], true);
    let height = &strokes["attributes"][0];
    assert_eq!(height["name"], "height");
    assert_eq!((&height["min"], &height["max"]), (&(-1.0).into(), &4.0.into()));
    let outcome = place.run("info cloud.csv").ok_silently();
    for part in ["2 points", "colours of lines and points", "height (lines and points): -1 to 4"] {
        assert!(outcome.text().contains(part), "{part} is not in {}", outcome.text());
    }
    assert!(!outcome.text().contains("none\n"), "{}", outcome.text());

    let outcome = place.run("info model.off --json").ok_silently();
    let info: serde_json::Value = serde_json::from_str(outcome.text()).unwrap();
    assert!(info["lines_and_points"].is_null());
}

/// Materials of lines and points are listed beside those of faces, and what of them is not opaque is counted.
/// Names of a file are one line each, without what a terminal obeys.
#[test]
fn names_have_no_control_characters() {
    let place = Place::new();
    let model = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\u{1b}[31mb\u{7}\nf 1 2 3\n";
    std::fs::write(place.path("m.obj"), model).expect("a model");
    std::fs::write(place.path("m.mtl"), "newmtl a\u{1b}[31mb\u{7}\nKd 1 0 0\n").expect("materials");
    let outcome = place.run("info m.obj").ok_silently();
    assert!(outcome.text().contains("a?[31mb?"), "{}", outcome.text());
    assert!(!outcome.text().contains(['\u{1b}', '\u{7}']));
}

#[test]
fn lines_and_points_have_materials() {
    let place = Place::new();
    let model =
        "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl solid\nf 1 2 3\nl 1 2\nusemtl glass\nl 2 3 1\np 1\n";
    std::fs::write(place.path("m.obj"), model).expect("a model");
    let library = "newmtl solid\nKd 1 0 0\nnewmtl glass\nKd 0 0 1\nd 0.25\n";
    std::fs::write(place.path("m.mtl"), library).expect("materials");
    let outcome = place.run("info m.obj --json").ok_silently();
    let info: serde_json::Value = serde_json::from_str(outcome.text()).unwrap();
    let names = |materials: &serde_json::Value| -> Vec<serde_json::Value> {
        materials.as_array().unwrap().iter().map(|material| material["name"].clone()).collect()
    };
    assert_eq!(names(&info["materials"]), ["solid"]);
    let materials = &info["lines_and_points"]["materials"];
    assert_eq!(names(materials), ["solid", "glass"]);
    assert_eq!(materials[1]["opacity"], 0.25);
    assert_eq!(materials[1]["diffuse"], serde_json::json!([0.0, 0.0, 1.0]));
    let counts = serde_json::json!({ "materials": 0, "vertices": 0, "faces": 0, "lines": 2, "points": 1 });
    assert_eq!(info["translucent"], counts);
    let outcome = place.run("info m.obj").ok_silently();
    let rows: Vec<Vec<&str>> =
        outcome.text().lines().map(|l| l.splitn(2, "  ").map(str::trim).collect()).collect();
    for row in [
        ["material", "solid"],
        ["material of lines and points", "solid"],
        ["material of lines and points", "glass"],
        ["not opaque", "2 lines, 1 point"],
    ] {
        assert!(rows.iter().any(|r| r == &row), "{row:?} is not in {}", outcome.text());
    }
}

/// A scene file is no model, which commands beside render say.
#[test]
fn a_scene_file_is_for_render() {
    let place = Place::new();
    std::fs::write(place.path("scene.toml"), "models = [\"model.off\"]\n").unwrap();
    for command in ["info scene.toml", "prepare scene.toml -o x.tercio", "bench scene.toml"] {
        place
            .run(command)
            .failed(2, &["scene.toml: a scene file", "tercio render draws it", "docs/scenes.md"]);
    }
}
