//! Stereo pictures, as a user asks for them.

mod common;

use common::{Outcome, Place};
use tercio::image::{Picture, Pixels};
use tercio::raster::Frame;
use tercio::raster::frame::Planes;
use tercio::stereo;

const MODEL: &str = "render builtin:teapot@2k --size 60x45 -q";

/// The colours of an opaque 8-bit picture.
fn frame(place: &Place, name: &str) -> Frame {
    let picture = Picture::from_bytes(&place.read(name)).expect("a picture");
    let Pixels::Eight(color) = picture.pixels else { panic!("{name}: 8 bits") };
    let planes = Planes { color: color.into_owned(), ..Planes::default() };
    Frame { width: picture.width, height: picture.height, planes, ..Frame::default() }
}

/// The data of an array file.
fn array(place: &Place, name: &str) -> Vec<u8> {
    let bytes = place.read(name);
    let header = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    bytes[10 + header..].to_vec()
}

fn stats(outcome: &Outcome) -> serde_json::Value {
    serde_json::from_str(outcome.text()).expect("JSON")
}

#[test]
fn every_layout_is_made_of_the_pictures_of_a_pair() {
    let place = Place::new();
    place.run(&format!("{MODEL} -o eye.png --stereo pair")).ok_silently();
    assert_eq!(place.names(), ["eye.left.png", "eye.right.png", "model.off"]);
    let [left, right] = ["eye.left.png", "eye.right.png"].map(|name| frame(&place, name));
    assert_eq!((left.width, left.height), (60, 45));
    assert!(left != right, "both eyes see the same");
    for (layout, expected, size) in [
        ("side-by-side", stereo::side_by_side(&left, &right), (120, 45)),
        ("over-under", stereo::over_under(&left, &right), (60, 90)),
        ("anaglyph", stereo::anaglyph(&left, &right), (60, 45)),
    ] {
        place.run(&format!("{MODEL} -o {layout}.png --stereo {layout}")).ok_silently();
        let found = frame(&place, &format!("{layout}.png"));
        assert_eq!((found.width, found.height), size, "{layout}");
        assert!(found.planes.color == expected.expect("a frame").planes.color, "{layout}");
        // The format does not matter, nor who draws.
        for (number, options) in
            ["", "--threads 1 --tile-size 8", "--ranks 3", "--ranks 2 --organisation sort-first"]
                .into_iter()
                .enumerate()
        {
            let name = format!("{number}.webp");
            place.run(&format!("{MODEL} -o {name} --stereo {layout} {options}")).ok_silently();
            assert!(frame(&place, &name) == found, "{layout} {options}");
        }
    }
}

#[test]
fn names_of_a_pair() {
    let place = Place::new();
    std::fs::create_dir(place.path("some.folder")).expect("a folder");
    let outputs = "-o some.folder/my.scan.ppm --output-depth d.npy --output-ids i --output-normals n.npy";
    place.run(&format!("{MODEL} {outputs} --stereo pair --stats s.json")).ok_silently();
    let written =
        ["d.left.npy", "d.right.npy", "i.left", "i.right", "model.off", "n.left.npy", "n.right.npy"];
    assert_eq!(place.names(), [&written[..], &["s.json", "some.folder"]].concat());
    for eye in ["left", "right"] {
        assert!(place.read(&format!("some.folder/my.scan.{eye}.ppm")).starts_with(b"P6\n60 45\n"));
    }
    place.run(&format!("{MODEL} -o plain --format png --stereo pair")).ok_silently();
    assert!(place.path("plain.left").exists() && place.path("plain.right").exists());
}

#[test]
fn arrays_have_the_layout_of_the_picture() {
    let place = Place::new();
    let outputs = |name: &str| format!("--output-depth {name}.d.npy --output-ids {name}.i.npy");
    place.run(&format!("{MODEL} {} --stereo pair", outputs("pair"))).ok_silently();
    place.run(&format!("{MODEL} {} --stereo side-by-side", outputs("beside"))).ok_silently();
    place.run(&format!("{MODEL} {} --stereo over-under", outputs("above"))).ok_silently();
    for kind in ["d", "i"] {
        let [left, right] = ["left", "right"].map(|eye| array(&place, &format!("pair.{kind}.{eye}.npy")));
        assert!(left.len() == 60 * 45 * 4 && left != right);
        assert!(array(&place, &format!("above.{kind}.npy")) == [&left[..], &right].concat());
        let rows = left.chunks(240).zip(right.chunks(240));
        let beside: Vec<u8> = rows.flat_map(|(left, right)| [left, right].concat()).collect();
        assert!(array(&place, &format!("beside.{kind}.npy")) == beside);
    }
}

#[test]
fn without_a_distance_both_eyes_see_the_ordinary_picture() {
    let place = Place::new();
    for options in ["", "--depth 16 --background transparent", "--opacity 0.3 --aa 8", "--ao --shadows"] {
        place.run(&format!("{MODEL} -o plain.png {options}")).ok_silently();
        place.run(&format!("{MODEL} -o eye.png --stereo pair --eye-distance 0 {options}")).ok_silently();
        for eye in ["left", "right"] {
            assert!(place.read("plain.png") == place.read(&format!("eye.{eye}.png")), "{eye}, {options}");
        }
    }
}

/// Options of the look have their effect on both eyes.
#[test]
fn looks_of_both_eyes() {
    let place = Place::new();
    place.run(&format!("{MODEL} -o plain.png --stereo pair")).ok_silently();
    for options in
        ["--ao", "--shadows", "--opacity 0.3", "--shading pbr", "--light camera-point:1,1,0", "--clip x:0.5"]
    {
        place.run(&format!("{MODEL} -o a.png --stereo pair {options}")).ok_silently();
        for eye in ["left", "right"] {
            assert!(
                place.read(&format!("plain.{eye}.png")) != place.read(&format!("a.{eye}.png")),
                "{options}"
            );
        }
        place.run(&format!("{MODEL} -o b.png --stereo side-by-side {options}")).ok_silently();
        let [left, right] = ["a.left.png", "a.right.png"].map(|name| frame(&place, name));
        let expected = stereo::side_by_side(&left, &right).expect("a frame");
        assert!(frame(&place, "b.png").planes.color == expected.planes.color, "{options}");
    }
}

/// The mean column of what is not background.
fn column(frame: &Frame) -> f64 {
    let width = frame.width as usize;
    let row = |index: usize| index / width * width;
    let shown =
        (0..frame.planes.color.len()).filter(|&i| frame.planes.color[i] != frame.planes.color[row(i)]);
    let columns: Vec<f64> = shown.map(|index| (index % width) as f64).collect();
    columns.iter().sum::<f64>() / columns.len() as f64
}

#[test]
fn convergence_and_eye_distance_make_the_parallax() {
    let place = Place::new();
    // 200 pixels a side and 90 degrees: 100 pixels per unit of tangent. The model is 8 units away.
    let model = "render builtin:sphere@20k --size 200x200 --eye 0,0,8 --target 0,0,0 --fov 90 -q";
    let parallax = |options: &str| {
        place.run(&format!("{model} -o a.png --stereo pair {options}")).ok_silently();
        column(&frame(&place, "a.left.png")) - column(&frame(&place, "a.right.png"))
    };
    for (eye_distance, convergence) in [(1.0, 8.0), (1.0, 4.0), (0.5, 20.0), (2.0, 10.0)] {
        let found = parallax(&format!("--eye-distance {eye_distance} --convergence {convergence}"));
        // The middle of the outline of a sphere of radius 1 is where a point appears that is 1 / 8 nearer than its centre.
        let expected = 100.0 * eye_distance * (1.0 / (8.0 - 1.0 / 8.0) - 1.0 / convergence);
        // The pixels of its rim are whole ones.
        assert!((found - expected).abs() < 0.3, "{eye_distance} {convergence}: {found}, not {expected}");
    }
    // By default the target is in the plane of the picture.
    assert!(parallax("").abs() < 0.5);
    let outcome = place.run(&format!("{model} -o a.png --stereo anaglyph --stats -")).ok_silently();
    let stats = stats(&outcome);
    assert_eq!(stats["stereo"]["convergence"].as_f64(), Some(8.0));
    assert_eq!(stats["stereo"]["eye_distance"].as_f64(), Some(8.0 / 30.0));
    let outcome = place.run(&format!("{model} -o a.png --stereo anaglyph --zoom 4 --stats -")).ok_silently();
    let zoomed: serde_json::Value = serde_json::from_str(outcome.text()).expect("JSON");
    assert_eq!(zoomed["stereo"]["eye_distance"].as_f64(), Some(8.0 / 30.0 / 4.0));
}

#[test]
fn stats_tell_of_both_eyes() {
    let place = Place::new();
    let outcome =
        place.run(&format!("{MODEL} -o a.png --stereo side-by-side --ranks 2 --stats -")).ok_silently();
    let stats = stats(&outcome);
    assert_eq!(stats["picture"]["width"], 120);
    assert_eq!(
        (&stats["stereo"]["layout"], &stats["parallel"]),
        (&"side-by-side".into(), &serde_json::Value::Null)
    );
    let eyes = stats["stereo"]["eyes"].as_array().expect("two eyes");
    let names: Vec<_> = eyes.iter().map(|eye| eye["eye"].as_str()).collect();
    assert_eq!(names, [Some("left"), Some("right")]);
    let visible = |frame: &serde_json::Value| frame["backend"]["pixels_visible"].as_u64().expect("a count");
    assert_eq!(visible(&stats["frame"]), eyes.iter().map(|eye| visible(&eye["frame"])).sum::<u64>());
    for eye in eyes {
        assert_eq!(eye["parallel"]["ranks"].as_array().map(Vec::len), Some(2));
        assert_eq!(eye["shift"][1].as_f64(), Some(0.0));
    }
    let shift = |eye: usize| eyes[eye]["shift"][0].as_f64().expect("a number");
    assert!(shift(0) < 0.0 && shift(0) == -shift(1));
    let outcome = place.run(&format!("{MODEL} -o a.png --stats -")).ok_silently();
    let plain: serde_json::Value = serde_json::from_str(outcome.text()).expect("JSON");
    assert!(plain["stereo"].is_null());
}

#[test]
fn standard_output_takes_one_picture() {
    let place = Place::new();
    place.run(&format!("{MODEL} -o a.png --stereo side-by-side")).ok_silently();
    let outcome = place.run(&format!("{MODEL} -o - --stereo side-by-side")).ok_silently();
    assert!(outcome.stdout == place.read("a.png"));
}

#[test]
fn what_cannot_be_is_refused() {
    let place = Place::new();
    let refused = |options: &str, parts: &[&str]| place.run(&format!("{MODEL} {options}")).failed(2, parts);
    refused("-o a.png --stereo anaglyph --orthographic", &["--stereo", "--orthographic"]);
    refused("-o a.png --stereo anaglyph --output-depth d.npy", &["--output-depth", "side-by-side"]);
    refused("--stereo anaglyph --output-ids i.npy", &["--output-ids", "pair"]);
    refused("-o a.png --stereo anaglyph --background transparent", &["anaglyph", "--background"]);
    refused("-o - --stereo pair", &["--stereo pair", "standard output"]);
    refused("-o a.png --stereo pair --output-depth -", &["--output-depth", "standard output"]);
    refused("-o a.png --stereo pair --stats a.right.png", &["a.right.png", "same file"]);
    refused("-o a.png --eye-distance 1", &["--stereo"]);
    refused("-o a.png --convergence 1", &["--stereo"]);
    refused("-o a.png --stereo", &["--stereo"]);
    refused("-o a.png --stereo crossed", &["crossed", "anaglyph"]);
    refused("-o a.png --stereo pair --eye-distance -1", &["--eye-distance"]);
    refused("-o a.png --stereo pair --convergence 0", &["--convergence"]);
    let size = |size: &str, options: &str, parts: &[&str]| {
        place.run(&format!("render model.off -q --size {size} {options}")).failed(2, parts);
    };
    size("40000x10", "-o a.png --stereo side-by-side", &["80000x10", "65536"]);
    size("10x40000", "-o a.png --stereo over-under", &["10x80000", "65536"]);
    size("10000x10", "-o a.webp --stereo side-by-side", &["WebP", "16384"]);
    #[cfg(unix)]
    refused("-o /dev/null --format png --stereo pair", &["/dev/null", "--stereo pair"]);
    let far = place.run(&format!("{MODEL} -o a.png --stereo pair --eye-distance 1e6 --convergence 1e-3"));
    far.failed(1, &["shift", "smaller distance of the eyes"]);
    let behind = "--eye 0,0,9 --target 0,0,99 --stereo pair";
    place.run(&format!("{MODEL} -o a.png {behind}")).failed(1, &["nothing was drawn", "behind the camera"]);
    assert_eq!(place.names(), ["model.off"]);
}

#[test]
fn an_input_is_not_overwritten() {
    let place = Place::new();
    std::fs::copy(place.path("model.off"), place.path("a.left.png")).expect("a copy");
    let outcome = place.run("render a.left.png -o a.png --stereo pair --size 20x20");
    outcome.failed(2, &["a.left.png", "an output must not be an input"]);
}
