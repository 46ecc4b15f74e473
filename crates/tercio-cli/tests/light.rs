//! Exposure, tone mapping, environments and eye-dome lighting, as a user asks for them.

mod common;

use common::Place;

const MODEL: &str = "render builtin:teapot@2k --size 120x90 -q";

/// A Radiance HDR picture of one colour, as mantissas and exponent.
fn hdr(width: usize, height: usize, pixel: [u8; 4]) -> Vec<u8> {
    let mut bytes = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n").into_bytes();
    bytes.extend((0..width * height).flat_map(|_| pixel));
    bytes
}

#[test]
fn every_option_changes_the_picture_and_how_it_is_drawn_does_not() {
    let place = Place::new();
    std::fs::write(place.path("sky.hdr"), hdr(4, 2, [128, 150, 200, 128])).expect("a file");
    place.run(&format!("{MODEL} -o plain.png")).ok_silently();
    for (number, look) in [
        "--exposure 1",
        "--tone neutral",
        "--tone filmic --exposure=-0.5",
        "--tone reinhard --shading pbr",
        "--edl",
        "--edl=3 --edl-radius 4",
        "--edl --ao",
        "--environment gradient",
        "--environment gradient:#f00,#0f0,#00f --shading pbr --roughness 0.1",
        "--environment sky.hdr --environment-strength 0.5",
        "--environment sky.hdr --light dir:1,2,1 --shadows=64",
    ]
    .into_iter()
    .enumerate()
    {
        let name = format!("{number}.png");
        place.run(&format!("{MODEL} -o {name} {look}")).ok_silently();
        assert!(place.read("plain.png") != place.read(&name), "{look}");
        for how in ["--threads 1 --tile-size 8", "--ranks 3", "--ranks 2 --organisation sort-first"] {
            place.run(&format!("{MODEL} -o again.png {look} {how}")).ok_silently();
            assert!(place.read(&name) == place.read("again.png"), "{look} {how}");
        }
    }
    place.run(&format!("{MODEL} -o none.png --exposure 0 --tone none --edl=0")).ok_silently();
    assert!(place.read("plain.png") == place.read("none.png"));
}

/// Effects cannot darken what is nearly black already.
#[test]
fn points_are_light_where_an_effect_darkens_them() {
    let place = Place::new();
    let brightest = |options: &str| {
        place.run(&format!("{MODEL} -o p.ppm --mode points --background black {options}")).ok_silently();
        place.read("p.ppm").split_off("P6 120 90 255 ".len()).into_iter().max()
    };
    assert!(brightest("") < Some(60));
    assert!(brightest("--edl") > Some(150) && brightest("--ao") > Some(150));
    assert_eq!(brightest("--edl --color #0a0000"), Some(10));
}

/// Points and lines have the colour that is asked for in place of those of the file, too.
#[test]
fn no_mesh_colors_holds_for_points_and_lines() {
    let place = Place::new();
    let head = "v 0 0 0 1 0 0\nv 1 0 0 1 0 0\nv 1 1 0 1 0 0\n";
    for (name, elements) in [("line", "l 1 2 3\n"), ("points", "p 1 2 3\n"), ("mesh", "f 1 2 3\n")] {
        std::fs::write(place.path("m.obj"), format!("{head}{elements}")).unwrap();
        let colors = |options: &str| {
            let mode = if name == "mesh" { "--mode points" } else { "" };
            let command =
                format!("render m.obj -o m.ppm --size 60x50 --aa 1 --background black -q {mode} {options}");
            place.run(&command).ok_silently();
            let pixels = place.read("m.ppm").split_off("P6 60 50 255 ".len());
            let drawn = |p: &&[u8]| **p != [0; 3];
            pixels.chunks(3).filter(drawn).map(<[u8]>::to_vec).collect::<std::collections::BTreeSet<_>>()
        };
        assert_eq!(colors(""), [vec![255, 0, 0]].into(), "{name}");
        assert_eq!(colors("--no-mesh-colors --color #0000ff"), [vec![0, 0, 255]].into(), "{name}");
    }
}

/// One side of a sphere is lit: the one that the bright half of the panorama is on, as it turns.
#[test]
fn environments_turn() {
    let place = Place::new();
    // Bright on the right.
    let mut sky = hdr(4, 2, [0; 4]);
    let first = sky.len() - 4 * 8;
    for pixel in [2, 3, 6, 7] {
        sky[first + 4 * pixel..first + 4 * pixel + 4].copy_from_slice(&[200, 200, 200, 129]);
    }
    // The same format, by its other name.
    let rgbe = [b"#?RGBE", &sky[10..]].concat();
    std::fs::write(place.path("sky.hdr"), sky).expect("a file");
    std::fs::write(place.path("rgbe.hdr"), rgbe).expect("a file");
    let draw = |options: &str| {
        let model = "render builtin:sphere@2k --size 64x64 -q -o a.ppm --background #000";
        place.run(&format!("{model} --environment {options}")).ok_silently();
        let bytes = place.read("a.ppm");
        let pixels = bytes[bytes.len() - 64 * 64 * 3..].to_vec();
        let half = |right: bool| {
            let of_half = pixels.chunks(3).enumerate().filter(|(i, _)| (i % 64 >= 32) == right);
            of_half.map(|(_, pixel)| u64::from(pixel[1])).sum::<u64>()
        };
        (half(false), half(true), pixels)
    };
    let front = "--view front";
    let (left, right, expected) = draw(&format!("sky.hdr {front}"));
    assert!(4 * right > 5 * left, "{left} {right}");
    let (left, right, _) = draw(&format!("sky.hdr {front} --environment-rotation 180"));
    assert!(4 * left > 5 * right, "{left} {right}");
    // Counter-clockwise seen from above: what was on the right is behind, seen from the front.
    let (_, _, behind) = draw(&format!("sky.hdr {front} --environment-rotation 90"));
    let (_, _, before) = draw(&format!("sky.hdr {front} --environment-rotation=-90"));
    let sum = |pixels: &[u8]| pixels.iter().map(|&c| u64::from(c)).sum::<u64>();
    assert!(sum(&before) > 2 * sum(&behind), "{} {}", sum(&before), sum(&behind));
    assert!(behind == draw(&format!("sky.hdr {front} --environment-rotation=-270")).2);
    assert!(expected == draw(&format!("rgbe.hdr {front}")).2);
    // With another axis upwards, the front is another side, and its right is still on the right.
    let (left, right, _) = draw(&format!("sky.hdr {front} --up-axis z"));
    assert!(4 * right > 5 * left, "{left} {right}");
    // Seen from behind, it is on the left.
    let (left, right, _) = draw("sky.hdr --view back");
    assert!(4 * left > 5 * right, "{left} {right}");
}

#[test]
fn wrong_values_are_refused() {
    let place = Place::new();
    for (bad, option) in [
        ("--exposure 16", "--exposure"),
        ("--exposure nan", "--exposure"),
        ("--tone bright", "--tone"),
        ("--edl=-1", "--edl"),
        ("--edl --edl-radius 0", "--edl-radius"),
        ("--edl-radius 2", "--edl"),
        ("--environment gradient:#fff", "--environment"),
        ("--environment-strength 2", "--environment"),
        ("--environment gradient --environment-strength=-1", "--environment-strength"),
        ("--environment gradient --shading unlit", "--environment"),
        ("--tone filmic --shading unlit", "--tone"),
        ("--environment gradient --shadows", "--shadows"),
        ("--environment gradient --environment-rotation 9", "--environment-rotation"),
        ("--environment -", "--environment"),
        ("--ao --ao-radius 3", "--ao-radius"),
    ] {
        place.run(&format!("{MODEL} -o a.png {bad}")).failed(2, &[option]);
    }
    assert!(!place.path("a.png").exists());
    let arrays = "render builtin:teapot@2k --size 120x90 -q --output-depth d.npy";
    for useless in ["--ao", "--tone filmic", "--environment gradient"] {
        place.run(&format!("{arrays} {useless}")).failed(2, &["-o"]);
    }
}

#[test]
fn files_that_are_no_panorama_are_refused() {
    let place = Place::new();
    let broken = hdr(4, 2, [128; 4]);
    for (name, bytes, words) in [
        ("square.hdr", hdr(4, 4, [128; 4]), "twice as wide as high"),
        ("short.hdr", broken[..broken.len() - 9].to_vec(), "short.hdr"),
        ("bright.hdr", hdr(4, 2, [200, 128, 128, 160]), "column 0 of row 0"),
        ("text.hdr", b"sky".to_vec(), "expected a Radiance HDR"),
        ("empty.hdr", Vec::new(), "an empty file"),
    ] {
        std::fs::write(place.path(name), bytes).expect("a file");
        place.run(&format!("{MODEL} -o a.png --environment {name}")).failed(1, &[name, words]);
    }
    std::fs::write(place.path("large.hdr"), hdr(2048, 1024, [128; 4])).expect("a file");
    for (limit, word) in [("7M", "memory"), ("40M", "memory")] {
        let limited = format!("{MODEL} -o a.png --memory-limit {limit} --environment large.hdr");
        place.run(&limited).failed(1, &["large.hdr", word]);
    }
    place.run(&format!("{MODEL} -o a.png --environment missing.hdr")).failed(1, &["missing.hdr"]);
    place.run(&format!("{MODEL} -o a.png --environment .")).failed(1, &["not a file"]);
    std::fs::write(place.path("sky.hdr"), hdr(4, 2, [128; 4])).expect("a file");
    place.run(&format!("{MODEL} -o sky.hdr --format png --environment sky.hdr")).failed(2, &["sky.hdr"]);
    assert!(!place.path("a.png").exists());
}
