//! `tercio prepare` from the outside: a prepared model is drawn like the model it was made from.

mod common;

use common::Place;

/// A model with everything that is drawn or reported: colours, a texture, an attribute.
const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
    property uchar red\nproperty uchar green\nproperty uchar blue\nproperty float quality\nelement face 2\n\
    property list uchar int vertex_indices\nend_header\n0 0 0 255 0 0 0.5\n1 0 0 0 255 0 nan\n1 1 0.5 0 0 255 2\n\
    0 1 0 9 9 9 inf\n4 0 1 2 3\n3 0 2 1\n";

fn json(text: &str) -> serde_json::Value {
    serde_json::from_str(text).expect("JSON")
}

#[test]
fn the_picture_and_all_arrays_are_those_of_the_model() {
    let place = Place::new();
    std::fs::write(place.path("model.ply"), PLY).unwrap();
    place.run("prepare model.ply -o model.tercio").ok_silently();
    let draw = |model: &str, name: &str| {
        let arrays = format!("--output-depth {name}.d --output-ids {name}.i --output-normals {name}.n");
        place.run(&format!("render {model} -o {name}.png {arrays} --size 64x48")).ok_silently();
        ["png", "d", "i", "n"].map(|end| place.read(&format!("{name}.{end}")))
    };
    let plain = draw("model.ply", "plain");
    assert!(draw("model.tercio", "prepared") == plain);
    // The same bytes from a pipe, which cannot be mapped, and compressed.
    let bytes = place.read("model.tercio");
    let piped = place.run_with_input("render - -o piped.png --size 64x48", &bytes);
    piped.ok_silently();
    assert!(place.read("piped.png") == plain[0]);
    // Preparing a prepared model changes nothing, not even the recorded origin.
    place.run("prepare model.tercio -o again.tercio").ok_silently();
    assert!(place.read("again.tercio") == bytes);
}

#[test]
fn info_describes_the_original_model() {
    let place = Place::new();
    std::fs::write(place.path("model.ply"), PLY).unwrap();
    place.run("prepare model.ply -o model.tercio").ok_silently();
    let [plain, prepared] = ["model.ply", "model.tercio"]
        .map(|m| json(place.run(&format!("info {m} --json")).ok_silently().text()));
    // Vertices are split at creases when normals are made.
    for key in ["attributes", "materials", "topology", "format", "faces", "triangles", "not_drawn", "bounds"]
    {
        assert_eq!(plain[key], prepared[key], "{key}");
    }
    assert_eq!(plain["attributes"][0]["nans"], 1);
    assert_eq!(prepared["prepared"]["from"], "model.ply");
    assert_eq!(prepared["prepared"]["file_bytes"], place.read("model.tercio").len());
    assert!(prepared["prepared"]["mapped_bytes"].as_u64() > Some(0));
    assert!(plain["prepared"].is_null());
    let text = place.run("info model.tercio").ok_silently();
    assert!(text.text().contains("from model.ply by tercio"), "{}", text.text());
}

#[test]
fn a_mapped_file_does_not_count_as_memory_in_use() {
    let place = Place::new();
    place.run("prepare builtin:gyroid@200k -o model.tercio").ok_silently();
    let bytes = place.read("model.tercio").len();
    assert!(bytes > 3_000_000, "{bytes}");
    place.run("render model.tercio -o a.png --size 64x64 --memory-limit 3M --threads 1").ok_silently();
    let copied =
        place.run_with_input("render - -o b.png --size 64x64 --memory-limit 3M", &place.read("model.tercio"));
    copied.failed(1, &["limit"]);
}

#[test]
fn damaged_and_foreign_files_are_refused_and_old_pictures_stay() {
    let place = Place::new();
    place.run("prepare model.off -o model.tercio").ok_silently();
    let good = place.read("model.tercio");
    std::fs::write(place.path("old.png"), "old").unwrap();
    let mut altered = good.clone();
    let last = altered.len() - 200;
    altered[last] ^= 4;
    let mut newer = good.clone();
    newer[12] = 200;
    for (bytes, reason) in [
        (&good[..good.len() / 2], "bytes in the file"),
        (&good[..20], "header"),
        (&altered[..], "as they were written"),
        (&newer[..], "version 200 of prepared models"),
        (&b"\x89TERCIO\n rest"[..], "expected"),
    ] {
        std::fs::write(place.path("bad.tercio"), bytes).unwrap();
        for command in ["render bad.tercio -o old.png", "info bad.tercio", "bench bad.tercio --frames 1"] {
            place.run(command).failed(1, &["bad.tercio: ", reason]);
        }
    }
    assert_eq!(place.read("old.png"), b"old");
}

#[test]
fn what_cannot_be_prepared_is_an_error() {
    let place = Place::new();
    place.run("prepare model.off -o model.off").failed(2, &["an output must not be an input"]);
    place.run("prepare model.off").failed(2, &["--output"]);
    place.run("prepare missing.off -o a.tercio").failed(1, &["missing.off: "]);
    std::fs::write(place.path("points.off"), "OFF\n1 0 0\n0 0 0\n").unwrap();
    place.run("prepare points.off -o a.tercio").failed(1, &["no triangles"]);
    assert!(!place.names().contains(&"a.tercio".to_owned()));
    place.run("prepare model.off -o model.tercio").ok_silently();
    let outcome = place.run("render model.tercio -o a.png --crease-angle 10 --size 32x32");
    assert!(
        outcome.code == Some(0) && outcome.stderr.contains("when the model was prepared"),
        "{}",
        outcome.stderr
    );
    place.run("prepare model.tercio -o model.tercio").failed(2, &["an output must not be an input"]);
}
