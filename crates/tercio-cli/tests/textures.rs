//! Materials and textures from the files of a model to the picture.

mod common;

use std::fs;

use common::Place;
use serde_json::Value;
use tercio::image::{Picture, Pixels};

const SQUARE: &str = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n\
    usemtl a\nf 1/1 2/2 3/3 4/4\n";

/// A square with this material, and pictures a.png and maps/b.webp.
fn place(material: &str) -> Place {
    let place = Place::new();
    fs::write(place.path("m.obj"), SQUARE).unwrap();
    fs::write(place.path("m.mtl"), format!("newmtl a\n{material}")).unwrap();
    fs::create_dir(place.path("maps")).unwrap();
    for picture in ["a.png", "maps/b.webp"] {
        place.run(&format!("render model.off -o {picture} --size 16x8")).ok_silently();
    }
    place
}

fn stats(place: &Place, arguments: &str) -> Value {
    let render = format!("render m.obj -o out.png --size 32x24 --view front --stats - {arguments}");
    serde_json::from_str(place.run(&render).ok_silently().text()).unwrap()
}

#[test]
fn textures_are_loaded_unless_they_are_not_wanted() {
    let place = place("map_Kd a.png\nmap_Bump -bm 0.5 maps\\b.webp\nKs 1 1 1\nNs 100\n");
    let loaded = &stats(&place, "")["textures"];
    let counts = ["materials", "textures", "files"].map(|key| loaded[key].as_u64());
    assert_eq!(counts, [Some(1), Some(2), Some(2)]);
    // 128 texels of 8 bytes, and their mipmaps.
    let bytes = loaded["memory_bytes"].as_u64().unwrap();
    assert!((2 * 128 * 8..3 * 128 * 8).contains(&bytes), "{bytes}");
    for option in ["--no-textures", "--no-mesh-colors"] {
        assert!(stats(&place, option)["textures"].is_null(), "{option}");
    }
    let bench = place.run("bench m.obj --frames 1 --size 32x24 --json").ok_silently();
    let bench: Value = serde_json::from_str(bench.text()).unwrap();
    assert_eq!(bench["textures"]["textures"], 2);
    let bench = place.run("bench m.obj --frames 1 --size 32x24 --json --no-textures").ok_silently();
    assert!(serde_json::from_str::<Value>(bench.text()).unwrap()["textures"].is_null());
    let verbose = place.run("render m.obj -o out.png --size 32x24 --view front -v");
    assert!(verbose.stderr.contains("\n2 textures in 2.") && verbose.code == Some(0), "{}", verbose.stderr);
}

#[test]
fn statements_that_are_not_applied_are_one_warning() {
    let place = place("Tf 0.5 1 1\nmap_Kd -boost 2 a.png\nmap_Ks -boost 2 a.png\nPc 0.5\n");
    let outcome = place.run("render m.obj -o out.png --size 32x24 --view front");
    let warning =
        "warning: m.obj: did not apply of the material library \"m.mtl\": \"tf\", \"-boost\", \"pc\"\n";
    assert_eq!((outcome.code, outcome.stderr.as_str()), (Some(0), warning));
}

#[test]
fn illumination_0_is_a_colour_without_light() {
    let place = place("illum 0\nKd 1 0.2 0\nKe 1 1 1\nKs 1 1 1\n");
    for shading in ["phong", "pbr", "unlit"] {
        let picture = format!("{shading}.png");
        place
            .run(&format!("render m.obj -o {picture} --size 32x24 --view front --shading {shading}"))
            .ok_silently();
        let Pixels::Eight(pixels) = Picture::from_bytes(&place.read(&picture)).unwrap().pixels else {
            panic!("8 bits")
        };
        assert_eq!(pixels[12 * 32 + 16][..3], [255, 51, 0], "{shading}");
    }
}

#[test]
fn shadows_of_what_is_not_opaque_are_one_warning() {
    let place = place("d 0.5\n");
    let draw = |options: &str| {
        place
            .run(&format!("render m.obj -o out.png --size 32x24 --view front --light dir:1,1,1 {options}"))
            .stderr
    };
    let warning = "warning: m.obj: what is not opaque casts the shadows of opaque surfaces\n";
    assert_eq!(draw("--shadows"), warning);
    assert_eq!(draw("--shadows --stereo side-by-side"), warning);
    let none = "warning: m.obj: surfaces with an opacity below 1 cast no shadows\n";
    assert_eq!(draw("--shadows --opacity 0.5"), none);
    for silent in ["", "--opacity 0.5", "--shadows --no-mesh-colors"] {
        assert_eq!(draw(silent), "", "{silent}");
    }
}

#[test]
fn what_cannot_be_drawn_is_one_warning() {
    let place = place("map_Kd gone.png\nmap_Ks folder.png\nmap_Ke text.png\nmap_Pr a.png\n");
    fs::create_dir(place.path("folder.png")).unwrap();
    fs::write(place.path("text.png"), "hello").unwrap();
    let outcome = place.run("render m.obj -o out.png --size 32x24 --view front");
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    let begin = "warning: m.obj: did not draw 3 textures: \"gone.png\" (not found), \"folder.png\" (not a file), \"text.png\"";
    assert!(outcome.stderr.starts_with(begin), "{}", outcome.stderr);
    assert_eq!(outcome.stderr.lines().count(), 1, "{}", outcome.stderr);
    place.run("render m.obj -o out.png --size 32x24 --view front -q").ok_silently();
    place.run("render m.obj -o out.png --size 32x24 --view front --no-textures").ok_silently();
    let bench = place.run("bench m.obj --frames 1 --size 32x24");
    assert!(bench.code == Some(0) && bench.stderr.starts_with(begin), "{}", bench.stderr);
}

#[test]
fn ranks_load_the_same_textures() {
    let place = place("map_Kd a.png\nmap_Pm b.webp\n");
    let alone = place.run("render m.obj -o a1.png --size 64x48 --view front").ok_silently();
    let ranks = place.run("render m.obj -o a2.png --size 64x48 --view front --ranks 2").ok_silently();
    assert_eq!((alone.code, ranks.code), (Some(0), Some(0)));
    assert_eq!(place.read("a1.png"), place.read("a2.png"));
}

#[test]
fn a_model_without_a_folder_has_no_textures() {
    let place = place("map_Kd a.png\n");
    let ply = "ply\nformat ascii 1.0\ncomment TextureFile a.png\nelement vertex 3\nproperty float x\n\
        property float y\nproperty float z\nproperty float s\nproperty float t\nelement face 1\n\
        property list uchar int vertex_indices\nend_header\n0 0 0 0 0\n1 0 0 1 0\n0 1 0 0 1\n3 0 1 2\n";
    let outcome = place.run_with_input("render - -o out.png --size 32x24 --view front", ply.as_bytes());
    let warning = "warning: standard input: did not look for 1 texture: the model comes without a folder\n";
    assert_eq!((outcome.code, outcome.stderr.as_str()), (Some(0), warning));
    fs::write(place.path("m.ply"), ply).unwrap();
    place.run("render m.ply -o out.png --size 32x24 --view front").ok_silently();
}

#[test]
fn no_texture_is_overwritten_wherever_it_was_found() {
    let place = place("map_Kd C:\\art\\B.webp\n");
    let before = place.read("maps/b.webp");
    place
        .run("render m.obj -o maps/b.webp --size 32x24 --view front")
        .failed(2, &["maps/b.webp", "texture of m.obj"]);
    assert_eq!(place.read("maps/b.webp"), before);
    place.run("prepare m.obj -o m.tercio").ok_silently();
    place
        .run("render m.tercio -o maps/b.webp --size 32x24 --view front")
        .failed(2, &["maps/b.webp", "texture of m.tercio"]);
}

#[test]
fn textures_of_prepared_models_are_loaded() {
    let place = place("map_Kd a.png\n");
    place.run("prepare m.obj -o maps/m.tercio").ok_silently();
    // Beside the model that it was made from.
    let render = "render maps/m.tercio -o out.png --size 32x24 --view front --stats -";
    let stats: Value = serde_json::from_str(place.run(render).ok_silently().text()).unwrap();
    assert_eq!(stats["textures"]["textures"], 1);
    for name in ["m.obj", "m.mtl"] {
        fs::remove_file(place.path(name)).unwrap();
    }
    let outcome = place.run(render);
    assert!(outcome.stderr.contains("did not draw 1 texture: \"a.png\" (not found)"), "{}", outcome.stderr);
    fs::rename(place.path("a.png"), place.path("maps/a.png")).unwrap();
    place.run(render).ok_silently();
}

#[test]
fn options_of_alpha_are_checked() {
    let place = place("map_Kd a.png\n");
    for option in ["blend", "ignore", "cutout", "cutout --alpha-cutoff 0.25"] {
        stats(&place, &format!("--texture-alpha {option}"));
    }
    let render = "render m.obj -o out.png --size 32x24";
    place
        .run(&format!("{render} --alpha-cutoff 0.25"))
        .failed(2, &["--alpha-cutoff has no effect without --texture-alpha cutout"]);
    for option in ["--alpha-cutoff 2 --texture-alpha cutout", "--texture-alpha half"] {
        assert_eq!(place.run(&format!("{render} {option}")).code, Some(2), "{option}");
    }
}

#[test]
fn the_memory_limit_holds_for_textures() {
    let place = place("map_Kd a.png\n");
    // A picture whose head claims more than the limit allows: its size is in bytes 16 to 23, their checksum follows.
    let mut bytes = place.read("a.png");
    bytes[16..24].copy_from_slice(&[0, 0, 0x75, 0x30, 0, 0, 0x75, 0x30]);
    let mut crc = flate2::Crc::new();
    crc.update(&bytes[12..29]);
    bytes[29..33].copy_from_slice(&crc.sum().to_be_bytes());
    fs::write(place.path("a.png"), bytes).unwrap();
    let outcome = place.run("render m.obj -o out.png --size 32x24 --view front --memory-limit 200M");
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    let begin = "warning: m.obj: did not draw 1 texture: \"a.png\" (needs ";
    assert!(outcome.stderr.starts_with(begin) && outcome.stderr.lines().count() == 1, "{}", outcome.stderr);
}

#[test]
fn info_lists_textures_by_role() {
    let place = place("map_Kd a.png\nmap_Bump -bm 2 b.png\nrefl c.png\nKs 0.5\n");
    let info = place.run("info m.obj").ok_silently();
    let row = info.text().lines().find(|line| line.starts_with("material")).unwrap();
    assert!(row.ends_with("a, texture a.png, bump texture b.png, texture that is not drawn c.png"), "{row}");
    let info: Value = serde_json::from_str(place.run("info m.obj --json").ok_silently().text()).unwrap();
    let material = &info["materials"][0];
    assert_eq!((&material["diffuse_texture"], &material["specular"][1]), (&"a.png".into(), &0.5.into()));
    assert_eq!(
        (&material["textures"]["bump"]["file"], &material["textures"]["bump"]["bump_multiplier"]),
        (&"b.png".into(), &2.0.into())
    );
    assert_eq!(material["other_textures"][0], "c.png");
    assert_eq!(info["not_drawn"]["textures"], 1);
}
