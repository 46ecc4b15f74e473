//! Textures, shadows and physically based shading, as a user draws them.

mod common;

use std::fs;
use std::io::BufWriter;

use common::Place;

/// A square facing +z with a texture of 2x2 texels: red, green above blue, white; with `material` added.
fn textured_square(material: &str) -> Place {
    let place = Place::new();
    let obj = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nusemtl a\n\
        f 1/1 2/2 3/3 4/4\n";
    fs::write(place.path("m.obj"), obj).unwrap();
    fs::write(place.path("m.mtl"), format!("newmtl a\nmap_Kd t.png\n{material}")).unwrap();
    let file = BufWriter::new(fs::File::create(place.path("t.png")).unwrap());
    let mut encoder = png::Encoder::new(file, 2, 2);
    encoder.set_color(png::ColorType::Rgba);
    let texels = [[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255], [255, 255, 255, 0]];
    encoder.write_header().unwrap().write_image_data(&texels.concat()).unwrap();
    place
}

const VIEW: &str = "--view front --background #808080 --size 33x33 -q";

/// Pixels of a PPM of 33x33: at the middle of each quarter of the square.
fn quarters(place: &Place, name: &str) -> [[u8; 3]; 4] {
    let picture = place.read(name);
    let pixels = &picture[picture.len() - 33 * 33 * 3..];
    [(9, 9), (23, 9), (9, 23), (23, 23)].map(|(x, y)| {
        let at = 3 * (33 * y + x);
        [pixels[at], pixels[at + 1], pixels[at + 2]]
    })
}

#[test]
fn a_texture_is_where_its_coordinates_are() {
    let place = textured_square("Kd 1 1 1\n");
    let draw = |options: &str| {
        place.run(&format!("render m.obj -o a.ppm --shading unlit {VIEW} {options}")).ok_silently();
        quarters(&place, "a.ppm")
    };
    let (red, green, blue, grey) = ([255, 0, 0], [0, 255, 0], [0, 0, 255], [128, 128, 128]);
    assert_eq!(draw("--texture-filter nearest"), [red, green, blue, grey]);
    assert_eq!(draw("--texture-filter nearest --texture-alpha cutout"), [red, green, blue, grey]);
    assert_eq!(draw("--texture-filter nearest --texture-alpha ignore")[..3], [red, green, blue]);
    let plain = draw("--no-textures");
    assert_eq!(plain, [[255; 3]; 4]);
    for filter in ["bilinear", "trilinear", "anisotropic"] {
        let [upper_left, ..] = draw(&format!("--texture-filter {filter} --texture-alpha ignore"));
        assert!(upper_left[0] > 200 && upper_left[1] < 160, "{filter}: {upper_left:?}");
    }
    // The material's colour multiplies the texture.
    let place = textured_square("Kd 1 1 0\n");
    place
        .run(&format!("render m.obj -o a.ppm --shading unlit --texture-filter nearest {VIEW}"))
        .ok_silently();
    assert_eq!(quarters(&place, "a.ppm"), [red, green, [0; 3], grey]);
}

#[test]
fn textures_and_shadows_do_not_depend_on_how_they_are_drawn() {
    let place = textured_square("Kd 1 1 1\nKs 1 1 1\nNs 50\n");
    let looks = [
        "--shadows=64 --light dir:1,1,1 --light point:0,0,1:*0.3",
        "--shadows=64 --shading pbr --roughness 0.3 --light spot:0.5,0.5,2:0,0,-1:20",
        "--shadows --texture-filter trilinear",
        "--shadows --texture-filter nearest --texture-alpha cutout --aa 1",
    ];
    for look in looks {
        for model in ["m.obj", "builtin:soup@2k"] {
            let render = format!("render {model} --size 120x90 -q {look}");
            place.run(&format!("{render} -o a.png")).ok_silently();
            for how in [
                "--threads 2",
                "--simd sse2",
                "--tile-size 16",
                "--ranks 3",
                "--ranks 3 --organisation sort-first",
                "--ranks 2 --organisation sort-last",
                "--ranks 3 --organisation sort-twice --group 2",
            ] {
                place.run(&format!("{render} {how} -o b.png")).ok_silently();
                assert!(place.read("a.png") == place.read("b.png"), "{model} {look} {how}");
            }
        }
    }
}

#[test]
fn a_shadow_falls_on_what_is_behind() {
    let place = Place::new();
    // A small square in front of a large one.
    let obj = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nf 1 2 3 4\n\
        v -0.3 -0.3 0.5\nv 0.3 -0.3 0.5\nv 0.3 0.3 0.5\nv -0.3 0.3 0.5\nf 5 6 7 8\n";
    fs::write(place.path("a.obj"), obj).unwrap();
    // From the right: the shadow of the small square is to its left.
    let view =
        "--view front --orthographic --shading flat --specular 0 --background #000 --size 33x33 --zoom 1 -q";
    let draw = |light: &str| {
        place.run(&format!("render a.obj -o a.ppm {view} --shadows {light}")).ok_silently();
        let picture = place.read("a.ppm");
        let row = &picture[picture.len() - 33 * 33 * 3 + 33 * 16 * 3..][..33 * 3];
        (0..33).map(|x| row[3 * x]).collect::<Vec<u8>>()
    };
    let lights = ["--light dir:1,0,1", "--light point:8,0,8.3", "--light spot:8,0,8.3:-1,0,-1:20"];
    for light in lights {
        let row = draw(light);
        let dark: Vec<usize> = (0..33).filter(|&x| row[x] == 0).collect();
        let surface: Vec<usize> = (0..33).filter(|&x| row[x] > 0).collect();
        // The large square is lit at both ends; in between, a shadow, then the small square.
        let shadow: Vec<usize> =
            dark.into_iter().filter(|x| surface.first() < Some(x) && Some(x) < surface.last()).collect();
        let (first, last) = (shadow.first(), shadow.last());
        assert!(!shadow.is_empty() && last < Some(&16), "{light}: {row:?}");
        assert_eq!(
            last.zip(first).map(|(l, f)| l - f + 1),
            Some(shadow.len()),
            "{light}: one shadow, {row:?}"
        );
    }
    assert!(draw("--light dir:0,0,1").iter().filter(|&&level| level == 0).count() < 16);
}

#[test]
fn options_without_effect_are_refused() {
    let place = Place::new();
    let render = "render builtin:sphere@1k -o a.png --size 32x24";
    for (options, message) in [
        ("--shadows --light ambient:#fff", "--shadows needs a directional, point or spot light"),
        ("--shadows --light studio", "--shadows needs a directional, point or spot light"),
        ("--shadows --shading unlit", "--shadows has no effect with --shading unlit"),
        ("--roughness 0.5", "no effect without --shading pbr"),
        ("--specular 0 --shading pbr", "--specular has no effect"),
        ("--metallic 0.5", "no effect without --shading pbr"),
        ("--shadows=8", "16"),
        ("--roughness 2 --shading pbr", "roughness"),
        ("--light spot:1,2,3:0,0,0:30", "direction of a light"),
        ("--light spot:1,2,3:0,0,1:120", "below 90"),
        ("--texture-filter best", "texture-filter"),
    ] {
        place.run(&format!("{render} {options}")).failed(2, &[message]);
    }
    place.run(&format!("{render} --shading pbr --metallic 1 --roughness 0 --shadows")).ok_silently();
}
