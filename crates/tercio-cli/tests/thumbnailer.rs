//! What desktops need for thumbnails: the entry works as it is written, and its types are defined.

mod common;

use std::fs;

use common::{OCTAHEDRON, Place};
use tercio::image::Picture;

fn contrib(name: &str) -> String {
    fs::read_to_string(tercio_testkit::workspace_root().join("contrib").join(name)).unwrap()
}

/// The value of a key of the entry.
fn value(key: &str) -> String {
    let entry = contrib("tercio.thumbnailer");
    assert!(entry.lines().any(|line| line == "[Thumbnailer Entry]"));
    let value = entry.lines().find_map(|line| line.strip_prefix(key)?.strip_prefix('='));
    value.unwrap_or_else(|| panic!("{key} is missing")).to_owned()
}

/// The texts between `start` and the next quote.
fn quoted<'a>(text: &'a str, start: &'a str) -> Vec<&'a str> {
    text.split(start).skip(1).filter_map(|rest| rest.split('"').next()).collect()
}

#[test]
fn the_command_of_the_entry_makes_a_thumbnail() {
    let place = Place::new();
    // Thumbnailers make names without an ending, and models have names of all kinds.
    fs::rename(place.path("model.off"), place.path("a{b}%s.off")).unwrap();
    let command = value("Exec");
    assert_eq!(value("TryExec"), "tercio");
    let arguments = command.strip_prefix("tercio ").expect("the program is found by its name");
    let run = |input: &str, output: &str, size: &str| {
        let words: Vec<String> = arguments
            .split(' ')
            .map(|word| match word {
                "%i" => input.to_owned(),
                "%o" => output.to_owned(),
                word => word.replace("%s", size),
            })
            .collect();
        let mut command = place.command("");
        common::Outcome::from(command.args(words).output().unwrap())
    };
    let input = place.path("a{b}%s.off").display().to_string();
    for size in [64, 128, 256, 512] {
        let output = place.path("thumbnail.XYZ").display().to_string();
        run(&input, &output, &size.to_string()).ok_silently();
        let picture = Picture::from_bytes(&place.read("thumbnail.XYZ")).unwrap();
        assert_eq!((picture.width, picture.height), (size, size));
        assert!(!picture.is_opaque(), "the desktop is seen behind the model");
    }
    fs::write(place.path("bad.off"), "OFF\n3 1 0\n0 0 0\n").unwrap();
    let bad = run("bad.off", "bad.png", "128");
    assert_eq!(bad.code, Some(1), "{}", bad.stderr);
    assert!(!place.names().contains(&"bad.png".into()), "a file manager shows its own picture then");
}

#[test]
fn the_types_of_the_entry_are_those_of_the_formats() {
    let entry = value("MimeType");
    let of_entry: Vec<&str> = entry.split(';').filter(|name| !name.is_empty()).collect();
    let package = contrib("tercio-mime.xml");
    let (types, aliases) = (quoted(&package, "<mime-type type=\""), quoted(&package, "<alias type=\""));
    let defined: Vec<&str> = types.iter().chain(&aliases).copied().collect();
    // The others are in every desktop's own list.
    let known = ["model/stl", "model/x.stl-ascii", "model/x.stl-binary", "model/obj"];
    for name in &of_entry {
        assert!(defined.contains(name) || known.contains(name), "{name} is defined nowhere");
    }
    for name in &defined {
        assert!(of_entry.contains(name), "{name} is missing in the entry");
    }
    // Each ending is that of a format: a model of it, in whatever format, is at least looked at.
    let place = Place::new();
    for pattern in quoted(&package, "<glob pattern=\"") {
        let name = format!("model{}", pattern.strip_prefix('*').unwrap());
        fs::write(place.path(&name), OCTAHEDRON).unwrap();
        place.run(&format!("render {name} -o a.png --size 16x16 --quiet")).ok_silently();
    }
    assert!(package.contains("xmlns=\"http://www.freedesktop.org/standards/shared-mime-info\""));
}
