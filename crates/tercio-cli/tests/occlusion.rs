//! Ambient occlusion, as a user asks for it.

mod common;

use common::Place;

const MODEL: &str = "render builtin:teapot@2k --size 120x90 -q";

#[test]
fn it_is_off_unless_requested_and_does_not_depend_on_how_the_picture_is_drawn() {
    let place = Place::new();
    place.run(&format!("{MODEL} -o plain.png")).ok_silently();
    place.run(&format!("{MODEL} -o none.png --ao=0")).ok_silently();
    assert!(place.read("plain.png") == place.read("none.png"));
    place.run(&format!("{MODEL} -o a.png --ao")).ok_silently();
    assert!(place.read("plain.png") != place.read("a.png"));
    for (i, options) in [
        "--ao=1 --ao-radius 0.2",
        "--ao --threads 1 --tile-size 8",
        "--ao --ranks 3",
        "--ao --ranks 2 --organisation sort-first",
        "--ao --output-depth d.npy --output-ids i.npy",
    ]
    .into_iter()
    .enumerate()
    {
        place.run(&format!("{MODEL} -o {i}.png {options}")).ok_silently();
        assert!(place.read("a.png") == place.read(&format!("{i}.png")), "{options}");
    }
    for (name, options) in [("half.png", "--ao=0.5"), ("wide.png", "--ao --ao-radius 0.4")] {
        place.run(&format!("{MODEL} -o {name} {options}")).ok_silently();
        assert!(place.read("a.png") != place.read(name), "{options}");
    }
}

#[test]
fn wrong_values_are_refused() {
    let place = Place::new();
    for bad in
        ["--ao=2", "--ao=-1", "--ao=nan", "--ao --ao-radius 0", "--ao --ao-radius=-1", "--ao-radius 0.1"]
    {
        place.run(&format!("{MODEL} -o a.png {bad}")).failed(2, &["--ao"]);
    }
    assert!(!place.path("a.png").exists());
}
