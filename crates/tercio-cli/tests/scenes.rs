//! Several models in one picture, scene files, and the configuration.

mod common;

use std::fs;
use std::sync::Arc;

use common::{Outcome, Place};
use tercio::glam::{DAffine3, DVec3};
use tercio::{Instance, Picture, Renderer, Scene, Settings};

/// A closed box between two corners, as PLY; its vertices have the attribute `height`.
fn block(place: &Place, name: &str, min: [f64; 3], max: [f64; 3]) {
    let corner = |k: usize| [0, 1, 2].map(|axis| if k >> axis & 1 == 0 { min[axis] } else { max[axis] });
    let mut text = "ply\nformat ascii 1.0\nelement vertex 8\nproperty double x\nproperty double y\nproperty double z\n\
                    property float height\nelement face 6\nproperty list uchar int vertex_indices\nend_header\n"
        .to_owned();
    for [x, y, z] in (0..8).map(corner) {
        text += &format!("{x} {y} {z} {y}\n");
    }
    for face in [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]] {
        text += &format!("4 {} {} {} {}\n", face[0], face[1], face[2], face[3]);
    }
    fs::write(place.path(name), text).expect("a model");
}

/// The block of a file with other vertices.
fn transformed(place: &Place, from: &str, to: &str, transform: impl Fn([f64; 3]) -> [f64; 3]) {
    let text = String::from_utf8(place.read(from)).expect("a text");
    let (head, body) = text.split_once("end_header\n").expect("a header");
    let mut text = format!("{head}end_header\n");
    for (number, line) in body.lines().enumerate() {
        let v: Vec<f64> = line.split(' ').map(|word| word.parse().expect("a number")).collect();
        if number < 8 {
            let [x, y, z] = transform([v[0], v[1], v[2]]);
            text += &format!("{x} {y} {z} {}\n", v[3]);
        } else {
            text += &format!("{line}\n");
        }
    }
    fs::write(place.path(to), text).expect("a model");
}

fn scene(place: &Place, name: &str, text: &str) {
    fs::write(place.path(name), text).expect("a scene file");
}

/// The values of an NPY file of 32-bit values.
fn values(place: &Place, name: &str) -> Vec<[u8; 4]> {
    let bytes = place.read(name);
    let begin = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    bytes[begin..].as_chunks::<4>().0.to_vec()
}

fn depths(place: &Place, name: &str) -> Vec<f32> {
    values(place, name).into_iter().map(f32::from_le_bytes).collect()
}

fn ids(place: &Place, name: &str) -> Vec<u32> {
    values(place, name).into_iter().map(u32::from_le_bytes).collect()
}

fn same(place: &Place, a: &str, b: &str) {
    assert!(place.read(a) == place.read(b), "{a} and {b} differ");
}

fn stats(place: &Place, name: &str) -> serde_json::Value {
    serde_json::from_slice(&place.read(name)).expect("JSON")
}

const CAMERA: &str = "--eye 9,7,12 --target 1,0.5,0 --size 160x120 --aa 1";

/// Two blocks that hide each other partly.
fn blocks() -> Place {
    let place = Place::new();
    block(&place, "a.ply", [-1.0, 0.0, -1.0], [1.0, 2.0, 1.0]);
    block(&place, "b.ply", [1.5, -1.0, 0.5], [3.0, 1.5, 2.0]);
    scene(
        &place,
        "scene.toml",
        "size = [160, 120]\naa = 1\neye = [9, 7, 12]\ntarget = [1, 0.5, 0]\n[[model]]\nfile = \"a.ply\"\n\
         color = \"ivory\"\n\n[[model]]\nfile = \"b.ply\"\ncolor = \"#4080c0\"\nspecular = 0\n",
    );
    place
}

#[test]
fn the_nearer_of_two_models_is_seen() {
    let place = blocks();
    for model in ["a", "b"] {
        let outputs = format!("--output-depth {model}.npy --output-ids {model}_ids.npy");
        place.run(&format!("render {model}.ply {CAMERA} {outputs}")).ok_silently();
    }
    place
        .run("render scene.toml -o both.png --output-depth both.npy --output-ids ids.npy --stats both.json")
        .ok_silently();
    let [a, b, both] = ["a.npy", "b.npy", "both.npy"].map(|name| depths(&place, name));
    let [ids_a, ids_b, all] = ["a_ids.npy", "b_ids.npy", "ids.npy"].map(|name| ids(&place, name));
    let models = &stats(&place, "both.json")["models"];
    let first = models[1]["instances"][0]["first_face"].as_u64().expect("a number") as u32;
    assert_eq!((models[0]["instances"][0]["first_face"].as_u64(), first), (Some(0), 6));
    assert_eq!(models[1]["instances"][0]["first_primitive"], 12);
    let mut seen = [0; 3];
    for (pixel, &id) in all.iter().enumerate() {
        // Near planes differ, by the rounding of depths.
        let nearest = a[pixel].min(b[pixel]);
        let is_near = |depth: f32| (both[pixel] - depth).abs() <= 4e-6 * depth;
        assert!(both[pixel] == nearest || is_near(nearest), "{pixel}: {} and {nearest}", both[pixel]);
        let expected = if a[pixel] < b[pixel] {
            ids_a[pixel]
        } else if b[pixel] < f32::INFINITY {
            ids_b[pixel] + first
        } else {
            u32::MAX
        };
        assert_eq!(id, expected, "{pixel}");
        let both_cover = a[pixel] < f32::INFINITY && b[pixel] < f32::INFINITY;
        seen[if both_cover { 2 } else { usize::from(a[pixel] < f32::INFINITY) }] += 1;
    }
    assert!(seen[1] > 500 && seen[2] > 100, "{seen:?}");
}

#[test]
fn a_scene_file_is_the_scene_that_a_program_makes() {
    let place = blocks();
    let linear =
        |[r, g, b]: [u8; 3]| [r, g, b].map(|c| tercio::scene::srgb_to_linear(f64::from(c) / 255.0) as f32);
    let mut made = Scene::from_mesh(tercio::load(place.path("a.ply")).expect("a model").mesh);
    made.instances[0].surface.base_color = linear([255, 255, 240]);
    let mut second = Instance::new(tercio::load(place.path("b.ply")).expect("a model").mesh);
    second.surface.base_color = linear([0x40, 0x80, 0xc0]);
    second.surface.specular = 0.0;
    let mut third = second.clone();
    second.world_from_object = DAffine3::from_translation(DVec3::new(0.0, 1.0, -2.0));
    third.surface.opacity = 0.5;
    third.world_from_object =
        DAffine3::from_translation(DVec3::new(0.0, 0.0, -4.0)) * second.world_from_object;
    made.instances.extend([second, third]);
    let settings = Settings::new(160, 120);
    let camera = settings.framing().camera_for_scene(&made);
    let frame = Renderer::new().render(&made, &camera, &settings).expect("a picture");
    Picture::from_frame(&frame).save(place.path("made.png")).expect("room");
    scene(
        &place,
        "three.toml",
        "size = '160x120'\n[[model]]\nfile = 'a.ply'\ncolor = 'ivory'\n[[model]]\nfile = 'b.ply'\n\
         color = '#4080c0'\nspecular = 0\ntranslate = [0, 1, -2]\n[[model.instance]]\ntranslate = [0, 0, -4]\nopacity = 0.5\n",
    );
    place.run("three.toml -o scene.png").ok_silently();
    same(&place, "made.png", "scene.png");
    let with = "a.ply -o with.png --size 160x120 --color ivory --with b.ply;color=#4080c0;specular=0;translate=0,1,-2 \
                --with b.ply;color=#4080c0;specular=0;translate=0,1,-6;opacity=0.5";
    place.run(with).ok_silently();
    same(&place, "made.png", "with.png");
    assert!(Arc::ptr_eq(&made.instances[1].mesh, &made.instances[2].mesh));
}

/// Lines, points and edges of a copy have its opacity, as those of a model of its own.
#[test]
fn the_opacity_of_a_copy_is_that_of_its_lines_and_points() {
    let place = Place::new();
    block(&place, "a.ply", [-1.0, 0.0, -1.0], [1.0, 2.0, 1.0]);
    fs::write(place.path("l.obj"), "v 0 0 0\nv 1 0 0\nv 1 1 0\nl 1 2 3\np 3\n").expect("a model");
    let looks = [
        ("l.obj", "line-width = 5\npoint-size = 12\n"),
        ("a.ply", "mode = 'wireframe'\nline-width = 4\n"),
        ("a.ply", "mode = 'points'\npoint-size = 9\n"),
    ];
    for (file, options) in looks {
        let model = format!("[[model]]\nfile = '{file}'\n{options}");
        let other = "translate = [3, 0, 0]\nopacity = 0.2\n";
        let size = "size = '160x120'\n";
        let copy = format!("{size}{model}[[model.instance]]\n{other}");
        scene(&place, "copy.toml", &copy);
        scene(&place, "models.toml", &format!("{size}{model}{model}{other}"));
        scene(&place, "opaque.toml", &copy.replace("0.2", "1"));
        for name in ["copy", "models", "opaque"] {
            place.run(&format!("{name}.toml -o {name}.ppm -q")).ok_silently();
        }
        same(&place, "copy.ppm", "models.ppm");
        assert!(place.read("copy.ppm") != place.read("opaque.ppm"), "{file} {options}");
        if file == "l.obj" {
            place.run("copy.toml -o copy.svg -q").ok_silently();
            let drawing = String::from_utf8(place.read("copy.svg")).expect("a text");
            assert!(drawing.contains("stroke-opacity=\"0.2\""), "{drawing}");
        }
    }
}

/// Lines, points and vertices of a copy have its colour, if they have none of their own or the copy does not show these.
#[test]
fn the_color_of_a_copy_is_that_of_its_lines_and_points() {
    let place = Place::new();
    block(&place, "a.ply", [-1.0, 0.0, -1.0], [1.0, 2.0, 1.0]);
    let lines = "v 0 0 0\nv 1 0 0\nv 1 1 0\nl 1 2 3\np 3\n";
    fs::write(place.path("plain.obj"), lines).expect("a model");
    let colored = lines.replace("0\nv", "0 1 0 0\nv").replace("1 0\nl", "1 0 0 0 1\nl");
    fs::write(place.path("colored.obj"), colored).expect("a model");
    let widths = "line-width = 5\npoint-size = 12\n";
    let color = "color = '#40a020'\n";
    let plain = "color = '#40a020'\nno-mesh-colors = true\n";
    let looks = [
        ("plain.obj", widths, color),
        ("colored.obj", widths, plain),
        ("a.ply", "mode = 'points'\npoint-size = 9\n", color),
        ("a.ply", "mode = 'points'\npoint-size = 9\n", plain),
    ];
    for (file, options, own) in looks {
        let model = format!("[[model]]\nfile = '{file}'\n{options}");
        let place_of = "translate = [3, 0, 0]\n";
        let size = "size = '160x120'\n";
        scene(&place, "copy.toml", &format!("{size}{model}[[model.instance]]\n{place_of}{own}"));
        scene(&place, "models.toml", &format!("{size}{model}{model}{place_of}{own}"));
        scene(&place, "same.toml", &format!("{size}{model}[[model.instance]]\n{place_of}"));
        let is_drawing = file.ends_with("obj");
        for name in ["copy", "models", "same"] {
            place.run(&format!("{name}.toml -o {name}.ppm -q")).ok_silently();
            if is_drawing {
                place.run(&format!("{name}.toml -o {name}.svg -q")).ok_silently();
            }
        }
        for kind in if is_drawing { &["ppm", "svg"][..] } else { &["ppm"] } {
            same(&place, &format!("copy.{kind}"), &format!("models.{kind}"));
            let is_same = place.read(&format!("copy.{kind}")) == place.read(&format!("same.{kind}"));
            assert!(!is_same, "{file} {options} {own} {kind}");
        }
    }
}

#[test]
fn ranks_threads_and_tiles_draw_the_same() {
    let place = blocks();
    scene(
        &place,
        "full.toml",
        "size = [160, 120]\n[[model]]\nfile = 'a.ply'\nedges = true\ncolor-by = 'height'\n[[model]]\n\
         file = 'b.ply'\nopacity = 0.4\nmode = 'hidden-line'\nrotate = [0, 30, 0]\n[[model.instance]]\ntranslate = [0, 0, 3]\n\
         [[model]]\nfile = 'model.off'\nmode = 'wireframe'\ntranslate = [0, 4, 0]\n",
    );
    place.run("full.toml -o one.png --threads 1").ok_silently();
    let others = [
        "--threads 3",
        "--tile-size 16 --sorting triangles",
        "--ranks 2 --organisation sort-last",
        "--ranks 2 --organisation sort-first",
        "--ranks 3 --organisation sort-middle",
    ];
    for options in others {
        place.run(&format!("full.toml -o other.png {options}")).ok_silently();
        same(&place, "one.png", "other.png");
    }
    place.run("scene.toml -o one.png --shadows").ok_silently();
    place.run("scene.toml -o other.png --shadows --ranks 2 --organisation sort-last").ok_silently();
    same(&place, "one.png", "other.png");
    // A film has the pictures of its cameras; the eyes of a stereo picture see all models.
    place.run("full.toml -o turn_{}.png --turntable 3").ok_silently();
    assert!(place.names().contains(&"turn_2.png".to_owned()));
    place.run("full.toml -o stereo.png --stereo anaglyph").ok_silently();
}

#[test]
fn a_transformed_model_is_the_model_with_transformed_vertices() {
    let place = Place::new();
    block(&place, "a.ply", [0.0, 0.0, 0.0], [1.0, 2.0, 3.0]);
    // Scaled by 2, turned by 90 degrees about z, moved.
    transformed(&place, "a.ply", "exact.ply", |[x, y, z]| [8.0 - 2.0 * y, 2.0 * x, 2.0 * z]);
    block(&place, "other.ply", [-1.0, -1.0, -1.0], [0.0, 0.0, 0.0]);
    let camera = "--eye 20,15,30 --target 4,1,3 --fov 12 --size 160x120 --aa 1";
    let with = "--with other.ply --output-depth";
    place
        .run(&format!("render a.ply {camera} --scale 2 --rotate 0,0,90 --translate 8,0,0 {with} scene.npy"))
        .ok_silently();
    place.run(&format!("render exact.ply {camera} {with} file.npy")).ok_silently();
    assert!(depths(&place, "scene.npy") == depths(&place, "file.npy"));
    let matrix = "0,-2,0,8,2,0,0,0,0,0,2,0";
    place.run(&format!("render a.ply {camera} --matrix {matrix} {with} matrix.npy")).ok_silently();
    assert!(depths(&place, "scene.npy") == depths(&place, "matrix.npy"));
    // Not exact: turned vertices are rounded to what a file holds.
    let (sin, cos) = 25f64.to_radians().sin_cos();
    transformed(&place, "a.ply", "turned.ply", |[x, y, z]| [cos * x + sin * z, y, -sin * x + cos * z]);
    place.run(&format!("render turned.ply {camera} {with} file.npy")).ok_silently();
    place.run(&format!("render a.ply {camera} --rotate 0,25,0 {with} scene.npy")).ok_silently();
    let (a, b) = (depths(&place, "scene.npy"), depths(&place, "file.npy"));
    let edge = a.iter().zip(&b).filter(|(a, b)| a.is_finite() != b.is_finite()).count();
    let far =
        a.iter().zip(&b).filter(|(a, b)| a.is_finite() && b.is_finite() && (**a - **b).abs() > 1e-3).count();
    let all = a.iter().filter(|d| d.is_finite()).count();
    assert!(edge + far < 8 && all > 400, "{edge} {far} {all}");
}

#[test]
fn a_saved_scene_draws_the_same_picture() {
    let place = blocks();
    fs::create_dir(place.path("saved")).unwrap();
    let runs = [
        "a.ply --size 160x120",
        "a.ply b.ply --together --size 160x120 --view iso --edges",
        "a.ply --size 160x120 --color-by height --colormap coolwarm --range 0,1.50 --bar left --title Höhe \
         --with b.ply;color-by=@normal:x;isolines=3;bar-title=n;clip=x:0.5;clip=1,0,0,-1.75;clip-cap",
        "a.ply --light dir:1,1,1 --light ambient:#404040 --clip 1,0,0,0.25 --opacity 0.30 --size 160x120 --background red,blue",
        "a.ply --matrix 1,0,0,0,0,1,0,0,0,0.1,1,0 --with b.ply;scale=0.5;rotate=10,20,-30 --size 160x120 --orthographic",
        "model.off --mode points --point-size 0.1u --with builtin:sphere@1k;specular=.5 --size 160x120 --shadows",
        "scene.toml --azimuth 40 --with model.off --edge-color red --edges=feature",
    ];
    for run in runs {
        // The camera of the scene has no azimuth.
        let run = run.replace("scene.toml --azimuth 40", "scene.toml --fov 40");
        place.run(&format!("{run} -o before.png --save-scene saved/scene.toml")).ok_silently();
        fs::remove_file(place.path("saved/scene.toml.png")).ok();
        let before = place.read("before.png");
        fs::remove_file(place.path("before.png")).unwrap();
        // It names its output, too.
        place.run("saved/scene.toml").ok_silently();
        assert!(
            place.read("before.png") == before,
            "{run}:\n{}",
            String::from_utf8_lossy(&place.read("saved/scene.toml"))
        );
        let first = place.read("saved/scene.toml");
        place.run("saved/scene.toml -o again.png --save-scene saved/again.toml").ok_silently();
        same(&place, "before.png", "again.png");
        let lines = |bytes: &[u8]| -> Vec<String> {
            let text = String::from_utf8(bytes.to_vec()).unwrap();
            text.lines()
                .filter(|l| !l.starts_with(['#']) && !l.starts_with("output"))
                .map(str::to_owned)
                .collect()
        };
        assert_eq!(lines(&first), lines(&place.read("saved/again.toml")));
    }
    place.run("scene.toml -o a.png --save-scene scene.toml").failed(2, &["the same file"]);
    place.run("a.ply -o a.png --save-scene b.ply --with b.ply").failed(2, &["b.ply", ".toml"]);
    scene(&place, "c.toml", "size = [64, 48]\n");
    place.run("a.ply -o a.png --save-scene c.toml --config c.toml").failed(2, &["the same file"]);
    // A series and a batch.
    place.run("a.ply b.ply -o s_{:02}.png --size 64x48 --save-scene saved/series.toml").ok_silently();
    let step = place.read("s_01.png");
    fs::remove_file(place.path("s_01.png")).unwrap();
    place.run("saved/series.toml").ok_silently();
    assert!(place.read("s_01.png") == step);
}

/// As a shell gives the files of a pattern, each by its name.
#[test]
fn a_saved_series_or_batch_has_the_models_that_are_in_every_picture() {
    let place = blocks();
    fs::create_dir(place.path("saved")).unwrap();
    for (output, pictures) in
        [("s_{}.png", ["s_0.png", "s_1.png"]), ("n_{name}.png", ["n_a.png", "n_model.png"])]
    {
        let run =
            format!("a.ply model.off --color ivory --with b.ply;color=red -o {output} --size 64x48 --quiet");
        place.run(&format!("{run} --save-scene saved/many.toml")).ok_silently();
        let before = pictures.map(|name| place.read(name));
        assert!(before[0] != before[1]);
        pictures.iter().for_each(|name| fs::remove_file(place.path(name)).unwrap());
        place.run("saved/many.toml --quiet").ok_silently();
        assert!(pictures.map(|name| place.read(name)) == before);
        // What is read is what is saved again.
        let first = place.read("saved/many.toml");
        place.run("saved/many.toml --quiet --save-scene saved/again.toml").ok_silently();
        let text =
            |bytes: &[u8]| String::from_utf8(bytes.to_vec()).unwrap().lines().skip(1).collect::<String>();
        assert_eq!(text(&first), text(&place.read("saved/again.toml")));
    }
}

#[test]
fn the_command_line_wins_over_the_scene_and_that_over_the_configuration() {
    let place = blocks();
    scene(
        &place,
        "config.toml",
        "size = '64x48'\nbackground = 'white'\ncolormap = 'turbo'\nedge-color = 'red'\n[pattern.'*.ply']\ncolor = 'green'\n\
         [pattern.'b*']\ncolor = 'blue'\n",
    );
    let look = |arguments: &str| {
        let arguments = format!("{arguments} -o x.png --stats x.json --config config.toml");
        place.run(&arguments).ok_silently();
        stats(&place, "x.json")
    };
    let color = |stats: &serde_json::Value, model: usize| {
        stats["models"][model]["instances"][0]["color"]
            .as_array()
            .unwrap()
            .iter()
            .map(|c| c.as_f64().unwrap())
            .collect::<Vec<_>>()
    };
    let plain = look("a.ply");
    assert_eq!(
        (&plain["picture"]["width"], &plain["look"]["background"]["color"][0]),
        (&64.into(), &1.0.into())
    );
    assert!(color(&plain, 0)[1] > 0.1 && color(&plain, 0)[0] == 0.0);
    // The later pattern wins, and the command line over all.
    assert_eq!(color(&look("b.ply"), 0), [0.0, 0.0, 1.0]);
    assert_eq!(color(&look("b.ply --color red"), 0), [1.0, 0.0, 0.0]);
    let scene = look("scene.toml");
    assert_eq!(scene["picture"]["width"], 160);
    assert!(color(&scene, 1)[0] > 0.0 && scene["look"]["background"]["color"][0] == 1.0);
    assert_eq!(color(&look("scene.toml --color red"), 1), [1.0, 0.0, 0.0]);
    assert_eq!(look("scene.toml --size 80x60")["picture"]["width"], 80);
    // Defaults without effect are left out, and used where they have one.
    assert_eq!(look("a.ply --color-by height")["look"]["data"]["colormap"], "turbo");
    let mut command = place.command("a.ply -o x.png -v");
    let verbose: Outcome = command.env("TERCIO_CONFIG", place.path("config.toml")).output().unwrap().into();
    assert_eq!(verbose.code, Some(0));
    for part in ["size", "config.toml", "without effect here: ", "colormap", "edge-color"] {
        assert!(verbose.stderr.contains(part), "{part}: {}", verbose.stderr);
    }
    let mut command = place.command("a.ply -o y.png --stats x.json --config none");
    command.env("TERCIO_CONFIG", place.path("config.toml")).output().unwrap();
    assert_eq!(stats(&place, "x.json")["picture"]["width"], 1280);
    // The usual place.
    fs::create_dir(place.path("tercio")).unwrap();
    fs::rename(place.path("config.toml"), place.path("tercio/config.toml")).unwrap();
    let mut command = place.command("a.ply -o y.png --stats x.json");
    command.env_remove("TERCIO_CONFIG").env("XDG_CONFIG_HOME", place.path("")).output().unwrap();
    assert_eq!(stats(&place, "x.json")["picture"]["width"], 64);
}

#[test]
fn what_is_wrong_in_a_file_is_told_with_its_line() {
    let place = blocks();
    let cases = [
        ("colour = 'red'\n", &["s.toml: line 1: colour", "no such option", "color"][..]),
        ("size = [1, 2]\n", &["no models", "[[model]]"]),
        ("\nsize = 'big'\n[[model]]\nfile = 'a.ply'\n", &["line 2: size: ", "WIDTHxHEIGHT"]),
        ("[[model]]\nfile = 'a.ply'\nview = 'top'\n", &["line 3: view: ", "whole picture"]),
        ("[[model]]\nfile = 'a.ply'\nopacty = 0.5\n", &["line 3: opacty: ", "opacity"]),
        ("[[model]]\nfile = 'a.ply'\nopacity = 2\n", &["line 3: opacity: ", "0 (invisible)"]),
        ("[[model]]\ncolor = 'red'\n", &["line 1: [[model]]", "file"]),
        ("[[model]]\nfile = 'a.ply'\nscale = 0\n", &["line 3: scale: ", "flat"]),
        ("[[model]]\nfile = 'a.ply'\n[[model.instance]]\nmode = 'edges'\n", &["line 4: mode: ", "instance"]),
        ("[[model]]\nfile = 'a.ply'\n[[model.instance]]\ncolor = true\n", &["line 4: color: "]),
        ("models = 'a.ply'\n[[model]]\nfile = 'a.ply'\n", &["line 1: models: ", "files = [...]"]),
        ("[[model]]\nfile = ['a.ply', 'b.ply']\n", &["line 2: file: ", "files = [...]"]),
        ("[[model]]\nfile = 'a.ply'\nfiles = ['b.ply']\n", &["line 3: files: ", "already"]),
        (
            "[[model]]\nfile = 'a.ply'\n[[model]]\nfiles = ['b.ply']\n",
            &["line 4: files: ", "first [[model]]"],
        ),
        ("config = 'x'\n[[model]]\nfile = 'a.ply'\n", &["line 1: config: ", "command line only"]),
        ("color = 'red'\nno-bar = 3\n", &["line 2: no-bar: ", "true or false"]),
        ("cmap = 'turbo'\ncolormap = 'turbo'\n", &["line 2: colormap: ", "twice"]),
        ("size = \n", &["s.toml: line 1: "]),
    ];
    for (text, parts) in cases {
        scene(&place, "s.toml", text);
        place.run("s.toml -o x.png").failed(1, parts);
    }
    scene(&place, "s.toml", "range = [0, 1]\n[[model]]\nfile = 'a.ply'\n");
    place.run("s.toml -o x.png").failed(2, &["--color-by"]);
    scene(&place, "s.toml", "[[model]]\nfile = 'a.ply'\n[[model]]\nfile = 'missing.ply'\n");
    place.run("s.toml -o x.png").failed(1, &["missing.ply"]);
    place.run("s.toml").failed(2, &["--output"]);
    place.run("s.toml a.ply -o x.png").failed(2, &["name it alone"]);
    for (with, part) in [
        ("b.ply;size=3x3", "whole picture"),
        ("b.ply;colr=red", "color"),
        ("b.ply;opacity=7", "opacity"),
        (";color=red", "name of a file"),
    ] {
        place.run(&format!("a.ply -o x.png --with {with}")).failed(2, &["--with", part]);
    }
    scene(&place, "config.toml", "\nszie = [3, 3]\n");
    place.run("a.ply -o x.png --config config.toml").failed(1, &["config.toml: line 2: szie", "size"]);
    place.run("a.ply -o x.png --config missing.toml").failed(1, &["missing.toml"]);
    assert!(!place.names().contains(&"x.png".to_owned()));
}

#[test]
fn a_model_that_is_named_twice_is_loaded_once() {
    let place = Place::new();
    scene(
        &place,
        "s.toml",
        "size = [64, 48]\n[[model]]\nfile = 'builtin:sphere@5k'\n[[model.instance]]\ntranslate = [3, 0, 0]\n\
         [[model]]\nfile = 'builtin:sphere@5k'\ntranslate = [0, 3, 0]\ncolor = 'red'\n\
         [[model]]\nfile = 'builtin:sphere@5k'\ncrease-angle = 0\ntranslate = [0, -3, 0]\n",
    );
    place.run("s.toml -o x.png --stats x.json --quiet").ok_silently();
    let stats = stats(&place, "x.json");
    let models = stats["models"].as_array().unwrap();
    assert_eq!((models.len(), models[0]["instances"].as_array().unwrap().len()), (3, 2));
    assert_eq!((&models[1]["mesh_of"], &models[1]["memory_bytes"]), (&0.into(), &0.into()));
    // Other normals are another mesh.
    assert!(models[2]["mesh_of"].is_null() && models[2]["memory_bytes"].as_u64() > Some(0));
    let triangles = models[0]["instances"][0]["triangles"].as_u64().unwrap();
    assert_eq!(models[1]["instances"][0]["first_primitive"].as_u64(), Some(2 * triangles));
    // A hundred copies take no more memory than one, apart from what is drawn.
    let copies: String =
        (0..100).map(|k| format!("[[model.instance]]\ntranslate = [{}, 0, 0]\n", 3 * k)).collect();
    scene(
        &place,
        "many.toml",
        &format!("size = [64, 48]\n[[model]]\nfile = 'builtin:sphere@100k'\n{copies}"),
    );
    place.run("many.toml -o x.png --stats many.json --threads 2").ok_silently();
    place.run("builtin:sphere@100k -o x.png --size 64x48 --stats one.json --threads 2").ok_silently();
    let peak = |name: &str| self::stats(&place, name)["peak_memory_bytes"].as_u64().unwrap();
    let mesh = self::stats(&place, "one.json")["load"]["memory_bytes"].as_u64().unwrap();
    assert!(
        peak("many.json") < peak("one.json") + 20 * mesh,
        "{} {} {mesh}",
        peak("many.json"),
        peak("one.json")
    );
}

#[test]
fn each_model_has_its_scalar_bar() {
    let place = blocks();
    let run = "a.ply --color-by height --with b.ply;color-by=@normal:x;colormap=coolwarm --size 640x480 -o x.png --stats x.json";
    place.run(run).ok_silently();
    let drawn = stats(&place, "x.json")["look"]["annotation"]["drawn"].clone();
    let boxes: Vec<Vec<f64>> = drawn
        .as_array()
        .unwrap()
        .iter()
        .map(|placed| placed["box"].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect())
        .collect();
    let [a, b] = &boxes[..] else { panic!("two bars: {drawn}") };
    assert!(b[2] < a[0] && a[1] == b[1], "side by side: {drawn}");
    // The same data and colours have one bar.
    let same = "a.ply --color-by height --range 0,2 --with b.ply;color-by=height;range=0,2 --size 640x480 -o x.png --stats x.json";
    place.run(same).ok_silently();
    assert_eq!(stats(&place, "x.json")["look"]["annotation"]["drawn"].as_array().unwrap().len(), 1);
}

#[test]
fn batches_and_series_draw_added_models_in_every_picture() {
    let place = blocks();
    place.run("a.ply model.off -o out_{name}.png --size 64x48 --with b.ply --quiet").ok_silently();
    place.run("model.off -o one.png --size 64x48 --with b.ply").ok_silently();
    same(&place, "out_model.png", "one.png");
    place.run("a.ply model.off -o s_{}.png --size 64x48 --with b.ply").ok_silently();
    place.run("a.ply -o one.png --size 64x48 --with b.ply").ok_silently();
    same(&place, "s_0.png", "one.png");
    // Without {name} or a number, and together.
    place.run("a.ply b.ply -o x.png").failed(2, &["--together", "{name}"]);
    place.run("a.ply b.ply model.off --together -o t.png --size 64x48 --stats t.json").ok_silently();
    assert_eq!(stats(&place, "t.json")["models"].as_array().unwrap().len(), 3);
    let series = place.run("a.ply model.off -o s_{}.png --size 64x48 --with -");
    series.failed(2, &["standard input is read once"]);
    place.run("a.ply model.off -o s_{name}.png --size 64x48 --with -").failed(2, &["standard input"]);
    let input = place.read("b.ply");
    place.run_with_input("a.ply -o piped.png --size 64x48 --with -", &input).ok_silently();
    same(&place, "piped.png", "one.png");
    // No output replaces a model of the scene.
    place.run("a.ply --with b.ply -o b.ply --format png").failed(2, &["the same file"]);
}

/// The patterns of the configuration are compared with each model of a batch, and its picture is the one that the model has alone.
#[test]
fn each_model_of_a_batch_has_the_defaults_of_its_name() {
    let place = blocks();
    let text = "[pattern.'b*']\ncolor = 'blue'\nview = 'top'\nsize = '40x30'\n";
    scene(&place, "config.toml", text);
    let run = |arguments: &str| {
        place.run(&format!("{arguments} --config config.toml -q --size 64x48")).ok_silently()
    };
    for order in ["a.ply b.ply", "b.ply a.ply"] {
        run(&format!("render {order} -o all_{{name}}.png"));
        for name in ["a", "b"] {
            run(&format!("render {name}.ply -o alone_{name}.png"));
            same(&place, &format!("all_{name}.png"), &format!("alone_{name}.png"));
        }
        assert!(place.read("all_a.png") != place.read("all_b.png"));
    }
}

/// What would contradict the command line, or the kind of its output, is left out.
#[test]
fn defaults_that_cannot_be_used_are_left_out() {
    let place = blocks();
    let text = "quality = 50\nbackground = 'transparent'\ndepth = 16\nranks = 2\nao = true\nmode = 'contours'\nsize = '40x30'\n";
    scene(&place, "config.toml", text);
    let run = |arguments: &str| {
        place.run(&format!("render a.ply {arguments} --config config.toml -q")).ok_silently()
    };
    run("-o a.png");
    assert_eq!(&place.read("a.png")[24..26], [16, 6], "16 bits, with alpha");
    run("-o a.jpg");
    run("-o a.svg --mode hidden-line");
    assert!(String::from_utf8(place.read("a.svg")).unwrap().contains("width=\"40\" height=\"30\""));
    scene(&place, "other.toml", "output = 'b.png'\n");
    place.run("render a.ply -o c.png --config other.toml").failed(1, &["other.toml: line 1: output"]);
    place.run("render a.ply -o c.png --save-scene a.txt").failed(2, &["a.txt", ".toml"]);
}
