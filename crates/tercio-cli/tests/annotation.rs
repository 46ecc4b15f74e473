//! What explains a picture, as a user asks for it.

mod common;

use common::Place;
use tercio::Picture;
use tercio::image::Pixels;

const MODEL: &str = "render builtin:teapot@2k --size 320x240 -q --color-by @elevation";
const ALL: &str = "--title Teapot --text bottom:below --axes --scale-bar=mm --bounds --grid --bar-unit m";

/// Width, and 8-bit pixels.
fn picture(place: &Place, name: &str) -> (usize, Vec<[u8; 4]>) {
    let picture = Picture::from_file(place.path(name)).expect("a picture");
    let Pixels::Eight(pixels) = picture.pixels else { panic!("8 bits") };
    (picture.width as usize, pixels.into_owned())
}

#[test]
fn it_does_not_depend_on_how_the_picture_is_drawn() {
    let place = Place::new();
    place.run(&format!("{MODEL} -o plain.png --no-bar")).ok_silently();
    place.run(&format!("{MODEL} -o bar.png")).ok_silently();
    assert!(place.read("plain.png") != place.read("bar.png"), "a bar by default");
    place.run(&format!("{MODEL} -o a.png {ALL} --stats s.json")).ok_silently();
    assert!(place.read("bar.png") != place.read("a.png"));
    for (i, options) in [
        "--threads 1 --tile-size 8",
        "--ranks 3",
        "--ranks 2 --organisation sort-first",
        "--output-depth d.npy",
    ]
    .into_iter()
    .enumerate()
    {
        place.run(&format!("{MODEL} -o {i}.png {ALL} {options}")).ok_silently();
        assert!(place.read("a.png") == place.read(&format!("{i}.png")), "{options}");
    }
    let stats: serde_json::Value = serde_json::from_slice(&place.read("s.json")).expect("JSON");
    let drawn = stats.pointer("/look/annotation/drawn").and_then(|drawn| drawn.as_array()).expect("a list");
    for what in ["bar", "axes", "scale bar", "text \"Teapot\"", "text \"below\""] {
        assert!(drawn.iter().any(|one| one["what"] == what), "{what}: {drawn:?}");
    }
    // Each eye has its own, and so have effects and 16 bits.
    for options in [
        "--stereo anaglyph",
        "--depth 16",
        "--ao",
        "--ao --depth 16",
        "--orthographic",
        "--background transparent",
    ] {
        place.run(&format!("{MODEL} -o b.png {ALL} {options}")).ok_silently();
        assert!(place.read("a.png") != place.read("b.png"), "{options}");
    }
}

#[test]
fn pictures_in_bands_are_those_of_the_whole_picture() {
    let place = Place::new();
    let options = "--size 65536x1025 --aa 1 --threads 2 --title x --text bottom-left:y --axes --scale-bar";
    place.run(&format!("render model.off -o a.png {options}")).ok_silently();
    place.run(&format!("render model.off -o a.ppm {options}")).ok_silently();
    place.run("compare a.png a.ppm --threshold 0").ok_silently();
}

/// Pixels of a model of known width against the length and the pixels of the scale bar.
#[test]
fn the_scale_bar_is_true() {
    let place = Place::new();
    let square = "OFF\n4 1 0\n-3 -3 0\n3 -3 0\n3 3 0\n-3 3 0\n4 0 1 2 3\n";
    std::fs::write(place.path("square.off"), square).expect("a file");
    for projection in ["--orthographic", "--fov 40"] {
        let arguments = format!("render square.off -o a.png --output-ids i.npy --view front {projection}");
        place.run(&format!("{arguments} --size 600x400 -q --scale-bar=cm --stats s.json")).ok_silently();
        let ids = place.read("i.npy");
        let row = &ids[ids.len() - 600 * 4 * 200..][..600 * 4];
        let seen = row.as_chunks::<4>().0.iter().filter(|id| u32::from_le_bytes(**id) != u32::MAX).count();
        let stats: serde_json::Value = serde_json::from_slice(&place.read("s.json")).expect("JSON");
        let scale = &stats["look"]["annotation"]["scale_bar"];
        let pixels = scale["pixels"].as_f64().expect("a number");
        let length = scale["length"].as_f64().expect("a number");
        assert!((seen as f64 / 6.0 - pixels / length).abs() < 0.4, "{seen} pixels for 6, {scale}");
        // And its ink: the longest dark run in the lower part of the picture.
        let (width, colors) = picture(&place, "a.png");
        let is_dark = |pixel: &&[u8; 4]| pixel[..3].iter().all(|v| *v < 100);
        let rows = colors[width * 360..].chunks(width);
        let longest = rows.map(|row| row.iter().filter(is_dark).count()).max().expect("rows");
        assert!((longest as f64 - pixels).abs() <= 1.5, "{longest} pixels of ink, {scale}");
    }
}

/// Where the model is opaque, nothing is seen of floor and box; beside it, there is something.
#[test]
fn the_model_hides_floor_and_box() {
    let place = Place::new();
    // The camera is placed, so that it does not depend on what is drawn.
    let model = "render builtin:teapot@2k --size 200x150 -q --aa 1 --eye 6,5,9";
    place.run(&format!("{model} -o plain.png --output-ids i.npy")).ok_silently();
    place.run(&format!("{model} -o all.png --grid --bounds")).ok_silently();
    let ids = place.read("i.npy");
    let ids = ids[ids.len() - 200 * 150 * 4..].as_chunks::<4>().0;
    let ((_, plain), (_, all)) = (picture(&place, "plain.png"), picture(&place, "all.png"));
    let mut beside = 0;
    for (i, id) in ids.iter().enumerate() {
        let is_same = plain[i] == all[i];
        if u32::from_le_bytes(*id) == u32::MAX {
            beside += u32::from(!is_same);
        } else {
            assert!(is_same, "the model's pixel {i}");
        }
    }
    assert!(beside > 300, "{beside} pixels of lines");
}

#[test]
fn wrong_values_are_refused() {
    let place = Place::new();
    for (bad, expected) in [
        ("--bar middle", "top-left"),
        ("--bar 0.5,1.5", "shares of 0 to 1"),
        ("--bar right --no-bar", "--no-bar"),
        ("--bar-format %d", ".3g"),
        ("--text-scale 0", "0.25 to 8"),
        ("--text-color reddish", "colour"),
        ("--title 漢", "the font has no"),
        ("--axes=nowhere", "bottom-left"),
    ] {
        place.run(&format!("{MODEL} -o a.png {bad}")).failed(2, &[expected]);
    }
    let plain = "render builtin:teapot@2k --size 200x150";
    for bad in ["--bar right", "--bar-title x", "--bar-format .3g"] {
        place.run(&format!("{plain} -o a.png {bad}")).failed(2, &["--color-by"]);
    }
    place.run(&format!("{plain} --output-ids i.npy --axes")).failed(2, &["add -o"]);
    assert!(!place.path("a.png").exists());
}

#[test]
fn braces_in_texts_are_placeholders_or_doubled() {
    let place = Place::new();
    for text in ["--title {foo}", "--text top-right:{foo}"] {
        let outcome = place.run(&format!("render model.off -o x.png {text}"));
        outcome.failed(2, &["there is no {foo}", "{frame}", "{name}", "{time}", "{{"]);
    }
    let draw = |title: &str| {
        place.run(&format!("render model.off -o x.png --size 160x120 --title {title}")).ok_silently();
        place.read("x.png")
    };
    // One brace is drawn where two are written; a placeholder beside it changes nothing about that.
    let doubled = draw("{{a}}");
    assert!(doubled != draw("a") && doubled != draw("{{{{a}}}}"));
    assert!(draw("{{model}}") == draw("{{{name}}}"));
}
