//! Many models in one command, from the outside; and short ways to say things.

mod common;

use common::{OCTAHEDRON, Place};

const SMALL: &str = "--size 48x36";

fn place_with(names: &[&str]) -> Place {
    let place = Place::new();
    std::fs::remove_file(place.path("model.off")).unwrap();
    names.iter().for_each(|name| std::fs::write(place.path(name), OCTAHEDRON).unwrap());
    place
}

#[test]
fn one_bad_file_does_not_stop_the_others() {
    let place = place_with(&["a.off", "b.off", "c.off"]);
    std::fs::write(place.path("bad.off"), "OFF\n3 1 0\n0 0 0\n").unwrap();
    std::fs::write(place.path("none.off"), "OFF\n3 1 0\n0 0 0\n1 0 0\n2 0 0\n3 0 1 2\n").unwrap();
    // The pattern is expanded here, not by a shell.
    let outcome = place.run(&format!("render *.off -o {{name}}.png {SMALL}"));
    assert_eq!(outcome.code, Some(1), "{}", outcome.stderr);
    for part in ["error: bad.off: ", "error: none.off: nothing was drawn", "3 models of 5 drawn, 2 failed"] {
        assert!(outcome.stderr.contains(part), "{part:?} is not in {}", outcome.stderr);
    }
    let pictures: Vec<String> = place.names().into_iter().filter(|name| name.ends_with(".png")).collect();
    assert_eq!(pictures, ["a.png", "b.png", "c.png"]);
    // As each alone, by any number of threads.
    place.run(&format!("render b.off -o alone.png --quiet {SMALL}")).ok_silently();
    assert!(place.read("alone.png") == place.read("b.png"));
    place
        .run(&format!("render a.off b.off c.off -o t_{{name}}.png --threads 3 --quiet {SMALL}"))
        .ok_silently();
    assert!(place.read("t_c.png") == place.read("c.png"));
    place
        .run(&format!("render a.off b.off -o r_{{name}}_{{}}.png --turntable 2 --ranks 2 --quiet {SMALL}"))
        .ok_silently();
    assert!(place.read("r_a_1.png") == place.read("r_b_1.png"));
}

#[test]
fn outputs_that_would_be_one_file_are_refused_before_anything_is_drawn() {
    let place = place_with(&["a.off", "a.obj", "b.off"]);
    place.run("render a.off a.obj -o {name}.png").failed(2, &["a.png", "same file"]);
    place
        .run("render a.off b.off -o {name}.off --format png")
        .failed(2, &["a.off", "an output must not be an input"]);
    place.run("render a.off b.off -o {name}.png --stats s.json").failed(2, &["s.json", "same file"]);
    place.run("render a.off b.off -o missing/deep/{name}.png").failed(1, &["missing"]);
    place.run("render *.stl -o {name}.png").failed(2, &["*.stl", "no such file"]);
    assert_eq!(place.names(), ["a.obj", "a.off", "b.off"]);
}

#[test]
fn the_folder_of_many_pictures_is_made() {
    let place = place_with(&["a.off", "b.off"]);
    place.run(&format!("render a.off b.off -o thumbs/{{name}}.png --quiet {SMALL}")).ok_silently();
    assert!(place.path("thumbs/a.png").is_file() && place.path("thumbs/b.png").is_file());
    place.run(&format!("render a.off -o turn/{{}}.png --turntable 2 --quiet {SMALL}")).ok_silently();
    assert!(place.path("turn/0.png").is_file());
    // Nothing is made for pictures that would replace each other.
    std::fs::create_dir(place.path("c")).unwrap();
    std::fs::copy(place.path("a.off"), place.path("c/a.off")).unwrap();
    let run = format!("render a.off c/a.off -o new/{{name}}.png {SMALL}");
    place.run(&run).failed(2, &["same file"]);
    assert!(!place.path("new").exists());
    place.run(&run.replace("new/", "thumbs/")).failed(2, &["same file"]);
}

/// A picture of one model is drawn before a texture of another one is read.
#[test]
fn textures_of_other_models_are_not_replaced() {
    let place = place_with(&["a.off"]);
    let write = |name: &str, text: &str| std::fs::write(place.path(name), text).unwrap();
    write("b.obj", "mtllib b.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/1 3/1\n");
    write("a.png", "a texture, or what is left of one");
    let found_as = ["a.png", "textures/a.png", "C:\\work\\a.png"];
    for name in found_as {
        write("b.mtl", &format!("newmtl m\nmap_Kd {name}\n"));
        let refused =
            |command: &str| place.run(command).failed(2, &["a.png", "an output must not be an input"]);
        refused(&format!("render a.off b.obj -o {{name}}.png {SMALL}"));
        place.run("prepare b.obj -o c.tercio --quiet").ok_silently();
        refused(&format!("render a.off c.tercio -o {{name}}.png {SMALL}"));
        std::fs::copy(place.path("a.png"), place.path("t_0.png")).unwrap();
        write("b.mtl", &format!("newmtl m\nmap_Kd {}\n", name.replace("a.png", "t_0.png")));
        place
            .run(&format!("render a.off b.obj -o t_{{step}}.png {SMALL}"))
            .failed(2, &["t_0.png", "an output must not be an input"]);
        assert_eq!(place.read("a.png"), b"a texture, or what is left of one", "{name}");
        assert_eq!(place.read("t_0.png"), place.read("a.png"), "{name}");
    }
    // Pictures of models without such files are replaced.
    place.run(&format!("render a.off -o a.png --quiet {SMALL}")).ok_silently();
    place.run(&format!("render a.off b.obj -o {{name}}.webp --quiet {SMALL}"));
    assert!(place.read("a.png").starts_with(b"\x89PNG"));
}

#[test]
fn short_ways_and_names_of_other_programs_mean_the_same() {
    let place = place_with(&["a.off"]);
    let draw = |arguments: &str| {
        place.run(&format!("{arguments} --quiet")).ok_silently();
        place.read("o.png")
    };
    let plain = draw("render a.off -o o.png --size 48x36 --background #ffffff --view iso --up-axis z");
    for same in [
        "a.off -o o.png --size 48x36 --background #ffffff --view iso --up-axis z",
        "--output o.png a.off --resolution 48,36 --bg-color white --view isometric --up +Z",
        "render a.off -o o.png --size 48x36 --background rgb(255,255,255) --camera-direction -1,1,-1 --up z",
    ] {
        assert!(draw(same) == plain, "{same}");
    }
    place.run("render a.off -o o.png --up 0,0,1").failed(2, &["--eye"]);
    place.run("rendr a.off -o o.png").failed(2, &["render"]);
    for arguments in ["completions bash", "completions zsh", "man", "man render"] {
        let outcome = place.run(arguments).ok_silently();
        assert!(outcome.text().contains("render") && outcome.text().len() > 1000, "{arguments}");
    }
    assert!(place.run("man render").text().contains("turntable"));
    let page = include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/options.md"));
    let latest = place.run("man --markdown").ok_silently();
    assert!(latest.text() == page, "docs/options.md is not the latest: cargo xtask options");
}

#[test]
fn stl_stands_on_the_plane_of_x_and_y() {
    let place = place_with(&["a.off"]);
    let corner = |v: [i32; 3]| format!("vertex {} {} {}\n", v[0], v[1], v[2]);
    let facet = [[0, 0, 0], [3, 0, 0], [0, 0, 9]].map(corner).concat();
    let stl = format!("solid x\nfacet normal 0 0 0\nouter loop\n{facet}endloop\nendfacet\nendsolid x\n");
    std::fs::write(place.path("x.stl"), stl).unwrap();
    std::fs::write(place.path("x.off"), "OFF\n3 1 0\n0 0 0\n3 0 0\n0 0 9\n3 0 1 2\n").unwrap();
    for (name, arguments) in
        [("stl", "x.stl"), ("z", "x.off --up-axis z"), ("stl-y", "x.stl --up-axis y"), ("y", "x.off")]
    {
        place.run(&format!("render {arguments} -o {name}.png --quiet {SMALL}")).ok_silently();
    }
    assert!(place.read("stl.png") == place.read("z.png"));
    assert!(place.read("stl-y.png") == place.read("y.png"));
    assert!(place.read("y.png") != place.read("z.png"));
    place.run("prepare x.stl -o x.tercio --quiet").ok_silently();
    place.run(&format!("render x.tercio -o prepared.png --quiet {SMALL}")).ok_silently();
    assert!(place.read("prepared.png") == place.read("stl.png"), "prepared models remember it");
    let note = place.run(&format!("render x.stl -o stl.png -v {SMALL}")).stderr;
    assert!(note.contains("z is up"), "{note}");
}
