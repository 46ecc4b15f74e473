//! Models that are not opaque, as a user draws them.

mod common;

use std::fs;

use common::Place;
use serde_json::Value;

/// A square with a colour at its corners, each with this alpha, in front of a smaller opaque red one.
fn square(alphas: [u8; 4]) -> String {
    let mut text =
        "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n\
        property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\nelement face 2\n\
        property list uchar int vertex_indices\nend_header\n"
            .to_owned();
    let corners = [[-1, -1], [1, -1], [1, 1], [-1, 1]];
    for ([x, y], alpha) in corners.into_iter().zip(alphas) {
        text += &format!("{x} {y} 1 0 0 255 {alpha}\n");
    }
    for [x, y] in corners {
        text += &format!("{} {} 0 255 0 0 {}\n", 0.5 * f64::from(x), 0.5 * f64::from(y), alphas[0].max(1));
    }
    text + "4 0 1 2 3\n4 4 5 6 7\n"
}

fn json_of(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

const VIEW: &str = "--view front --shading unlit --background #fff --size 33x33 -q";

#[test]
fn opacity_and_alpha_are_blended_in_linear_light() {
    let place = Place::new();
    fs::write(place.path("a.ply"), square([255; 4])).unwrap();
    fs::write(place.path("half.ply"), square([128; 4])).unwrap();
    let pixel = |name: &str, at: usize| {
        let picture = place.read(&format!("{name}.ppm"));
        let pixels = &picture[picture.len() - 33 * 33 * 3..];
        [pixels[3 * at], pixels[3 * at + 1], pixels[3 * at + 2]]
    };
    place.run(&format!("render a.ply -o a.ppm {VIEW}")).ok_silently();
    assert_eq!(pixel("a", 33 * 16 + 16), [0, 0, 255]);
    // 0.5 blue, 0.25 red, 0.25 white: red and green of the picture are 0.5 and 0.25 in linear light.
    place.run(&format!("render a.ply -o b.ppm --opacity 0.5 {VIEW}")).ok_silently();
    assert_eq!(pixel("b", 33 * 16 + 16), [188, 137, 225]);
    // 128 / 255 times 0.996 is about one half, too.
    place.run(&format!("render half.ply -o c.ppm --opacity 0.99609375 {VIEW}")).ok_silently();
    assert_eq!(pixel("c", 33 * 16 + 16), [188, 137, 225]);
    place.run(&format!("render half.ply -o d.ppm --no-mesh-colors {VIEW}")).ok_silently();
    place.run(&format!("render a.ply -o e.ppm --no-mesh-colors {VIEW}")).ok_silently();
    assert!(place.read("d.ppm") == place.read("e.ppm"), "the alpha of colours that are not used is not used");
}

#[test]
fn the_picture_does_not_depend_on_how_it_is_drawn() {
    let place = Place::new();
    let model = "render builtin:soup@2k --opacity 0.4 --size 120x90 -q";
    place.run(&format!("{model} -o a.png")).ok_silently();
    for (i, options) in [
        "--threads 1 --tile-size 8",
        "--ranks 3",
        "--ranks 2 --organisation sort-first",
        "--ranks 2 --organisation sort-last",
        "--ranks 5 --organisation sort-last --memory-limit 100M",
        "--memory-limit 60M --tile-size 128",
        "--sorting triangles",
    ]
    .into_iter()
    .enumerate()
    {
        place.run(&format!("{model} -o {i}.png {options}")).ok_silently();
        assert!(place.read("a.png") == place.read(&format!("{i}.png")), "{options}");
    }
    place.run("prepare builtin:soup@2k -o soup.tercio -q").ok_silently();
    place.run("render soup.tercio --opacity 0.4 --size 120x90 -o p.png -q").ok_silently();
    assert!(place.read("a.png") == place.read("p.png"), "prepared");
}

#[test]
fn models_say_what_is_not_opaque() {
    let place = Place::new();
    fs::write(place.path("half.ply"), square([128, 255, 255, 0])).unwrap();
    let info = place.run("info half.ply").ok_silently();
    assert!(
        info.text().lines().any(|l| l.starts_with("not opaque") && l.ends_with("6 vertices")),
        "{}",
        info.text()
    );
    let json = json_of(place.run("info half.ply --json -q").ok_silently().text());
    assert_eq!(json["translucent"]["vertices"], 6);

    let cloud = square([0; 4]).replace(" 1\n", " 0\n");
    fs::write(place.path("zero.ply"), cloud).unwrap();
    fs::write(place.path("full.ply"), square([255; 4])).unwrap();
    let outcome = place.run(&format!("render zero.ply -o zero.png {}", VIEW.trim_end_matches(" -q")));
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    assert!(
        outcome.stderr.contains("warning: zero.ply: everything is fully transparent"),
        "{}",
        outcome.stderr
    );
    place.run(&format!("render full.ply -o full.png {VIEW}")).ok_silently();
    assert!(place.read("zero.png") == place.read("full.png"), "an alpha of 0 everywhere is not meant");
}

#[test]
fn opacities_that_are_none_are_refused() {
    let place = Place::new();
    for bad in ["-0.1", "1.5", "nan", "half", ""] {
        let command = format!("render builtin:sphere@100 -o a.png --opacity={bad}");
        place.run(&command).failed(2, &["0 (invisible) to 1 (opaque)"]);
    }
    // Nothing is visible: an error, as for every other empty picture.
    place
        .run("render builtin:sphere@100 -o a.png --opacity 0")
        .failed(1, &["fully transparent", "--allow-empty"]);
    assert!(!place.path("a.png").exists());
}
