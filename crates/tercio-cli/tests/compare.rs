//! `tercio compare` from the outside.

mod common;

use common::Place;
use tercio::image::{Picture, Pixels};

fn place() -> Place {
    let place = Place::new();
    let save = |name: &str, pixels: [[u8; 4]; 2]| {
        let pixels = Pixels::Eight(pixels.to_vec().into());
        Picture { width: 2, height: 1, pixels }.save(place.path(name)).unwrap();
    };
    save("a.png", [[10, 20, 30, 255], [40, 50, 60, 255]]);
    save("a.ppm", [[10, 20, 30, 255], [40, 50, 60, 255]]);
    save("a.webp", [[10, 20, 30, 255], [40, 50, 60, 255]]);
    save("b.png", [[10, 20, 30, 255], [43, 50, 59, 255]]);
    Picture { width: 1, height: 1, pixels: Pixels::Eight(vec![[0; 4]].into()) }
        .save(place.path("small.png"))
        .unwrap();
    place
}

#[test]
fn equal_pictures_in_different_formats_are_equal() {
    let place = place();
    for other in ["a.png", "a.ppm", "a.webp"] {
        let outcome = place.run(&format!("compare a.png {other}")).ok_silently();
        assert!(outcome.text().contains("0 of 2 (0 %)"), "{}", outcome.text());
    }
}

#[test]
fn a_picture_may_come_from_standard_input() {
    let place = place();
    let outcome = place.run_with_input("compare - b.png", &place.read("b.png")).ok_silently();
    assert!(outcome.text().contains("0 of 2 (0 %)"), "{}", outcome.text());
    place.run_with_input("compare b.png -", b"no picture").failed(2, &["standard input: not a picture"]);
    place.run("compare - -").failed(2, &["one picture only"]);
}

#[test]
fn exit_codes_for_equal_different_and_wrong_pictures() {
    let place = place();
    let code = |arguments: &str| place.run(&format!("compare {arguments}")).code;
    assert_eq!(code("a.png b.png"), Some(1));
    assert_eq!(code("a.png b.png --threshold 2.5"), Some(1));
    assert_eq!(code("a.png b.png --threshold 3"), Some(0));
    assert_eq!(code("a.png b.png --threshold 255"), Some(0));
    place.run("compare a.png missing.png").failed(2, &["missing.png: "]);
    place.run("compare a.png model.off").failed(2, &["model.off: not a picture"]);
    place.run("compare a.png small.png").failed(2, &["differ in size: 2x1 and 1x1"]);
    place.run("compare a.png b.png --diff no/d.png").failed(2, &["no/d.png"]);
    let outcome = place.run("compare a.png b.png");
    assert!(
        outcome.text().contains("1 of 2 (50 %)") && outcome.text().contains("red 3"),
        "{}",
        outcome.text()
    );
    assert!(place.run("compare a.png b.png --quiet").stdout.is_empty());
}

#[test]
fn the_difference_is_a_picture() {
    let place = place();
    assert_eq!(place.run("compare a.png b.png --diff d.png").code, Some(1));
    let expected = vec![[0, 0, 0, 255], [255, 0, 85, 255]];
    assert_eq!(Picture::from_bytes(&place.read("d.png")).unwrap().pixels, Pixels::Eight(expected.into()));
}
