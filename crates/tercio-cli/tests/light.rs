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

#[test]
fn environments_turn() {
    let place = Place::new();
    let draw = |name: &str, options: &str| {
        place
            .run(&format!("{MODEL} -o {name} --environment gradient:#fff,#888,#000 {options}"))
            .ok_silently();
        place.read(name)
    };
    // A gradient is the same all round, and has another direction with another axis upwards.
    assert!(draw("a.png", "") == draw("b.png", "--environment-rotation 360"));
    let eye = "--eye 3,2,10 --up 0,1,0";
    assert!(draw("a.png", eye) != draw("b.png", &format!("{eye} --up-axis z")));
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
    ] {
        place.run(&format!("{MODEL} -o a.png {bad}")).failed(2, &[option]);
    }
    assert!(!place.path("a.png").exists());
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
    place.run(&format!("{MODEL} -o a.png --environment missing.hdr")).failed(1, &["missing.hdr"]);
    place.run(&format!("{MODEL} -o a.png --environment .")).failed(1, &["not a file"]);
    std::fs::write(place.path("sky.hdr"), hdr(4, 2, [128; 4])).expect("a file");
    place.run(&format!("{MODEL} -o sky.hdr --format png --environment sky.hdr")).failed(2, &["sky.hdr"]);
    assert!(!place.path("a.png").exists());
}
