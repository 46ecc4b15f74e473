//! No output is an input or another output, whatever names are used for them.
#![cfg(unix)]

mod common;

use std::fs::{self, File};
use std::os::unix::fs::symlink;
use std::process::{Command, Stdio};

use common::{OCTAHEDRON, Outcome, Place};

/// A folder with a model, a picture, and other names for both.
fn place() -> Place {
    let place = Place::new();
    let at = |name: &str| place.path(name);
    fs::create_dir(at("d")).unwrap();
    symlink("model.off", at("link.off")).unwrap();
    symlink(".", at("here")).unwrap();
    fs::hard_link(at("model.off"), at("hard.off")).unwrap();
    symlink("d/new.npy", at("to_new.npy")).unwrap();
    place.run("render model.off -o a.png --size 32x24 -q").ok_silently();
    place.run("render model.off -o b.png --size 32x24 -q --view top").ok_silently();
    place
}

/// Wrong usage, reported in one line with both names, and nothing is written.
#[track_caller]
fn is_refused(place: &Place, arguments: &str, names: &[&str]) {
    let before = place.names();
    let outcome = place.run(arguments);
    outcome.failed(2, names);
    assert!(outcome.stdout.is_empty());
    assert_eq!(place.names(), before, "{arguments}");
    assert_eq!(place.read("model.off"), OCTAHEDRON.as_bytes(), "{arguments}");
}

#[test]
fn an_output_is_never_the_model() {
    let place = place();
    for name in ["model.off", "./model.off", "d/../model.off", "link.off", "here/link.off", "hard.off"] {
        let outputs = [
            format!("-o {name} --format png"),
            format!("-o a.png --stats {name}"),
            format!("--output-depth {name}"),
            format!("--output-ids {name}"),
            format!("--output-normals {name}"),
        ];
        for output in outputs {
            is_refused(
                &place,
                &format!("render model.off {output}"),
                &["the model model.off", name, "same file"],
            );
        }
        // The other way round: the model by its other name.
        is_refused(
            &place,
            &format!("render {name} --stats model.off -o a.png"),
            &["--stats model.off", name],
        );
    }
    // A missing model would be created, and read by the second run.
    is_refused(&place, "render new.ply -o d/../new.ply --format png", &["--output d/../new.ply", "new.ply"]);
}

#[test]
fn an_output_is_never_another_output() {
    let place = place();
    let cases = [
        ("--output-depth n.npy --output-ids ./n.npy", ["--output-depth n.npy", "--output-ids ./n.npy"]),
        (
            "--output-depth d/new.npy --output-ids to_new.npy",
            ["--output-depth d/new.npy", "--output-ids to_new.npy"],
        ),
        ("-o a.png --output-ids here/a.png", ["--output a.png", "--output-ids here/a.png"]),
        ("-o n.png --stats d/../n.png", ["--output n.png", "--stats d/../n.png"]),
        ("--output-normals - --stats -", ["--output-normals -", "--stats -"]),
        ("-o - --stats /dev/stdout", ["--output -", "standard output"]),
        ("-o /dev/fd/1 --stats /proc/self/fd/1", ["--output -", "standard output"]),
    ];
    for (outputs, names) in cases {
        is_refused(&place, &format!("render model.off {outputs}"), &names);
    }
    // On file systems that ignore case, one of them would be lost.
    for outputs in ["--output-depth n.npy --output-ids N.npy", "-o d/n.png --stats d/../d/N.PNG"] {
        is_refused(
            &place,
            &format!("render model.off {outputs}"),
            &["upper and lower case", "choose other names"],
        );
    }
    let several =
        "-o /dev/null --format png --output-depth /dev/null --output-ids /dev/null --stats /dev/null";
    place.run(&format!("render model.off {several} --size 32x24")).ok_silently();
    place.run("render model.off -o n.png --output-ids n.npy --stats n.json --size 32x24").ok_silently();
    // A link to a missing file stays, and its target is created.
    place.run("render model.off --output-ids to_new.npy --size 32x24").ok_silently();
    assert!(fs::symlink_metadata(place.path("to_new.npy")).unwrap().is_symlink());
    assert!(place.path("d/new.npy").is_file());
}

#[test]
fn standard_streams_that_are_files_count() {
    let place = place();
    let open = |name: &str| File::open(place.path(name)).unwrap();
    let append = |name: &str| File::options().append(true).open(place.path(name)).unwrap();
    let of = |outcome: std::process::Output| Outcome::from(outcome);
    let outcome =
        of(place.command("render - -o model.off --format png").stdin(open("model.off")).output().unwrap());
    outcome.failed(2, &["--output model.off", "the model from standard input"]);
    let from = "render /dev/stdin -o link.off --format png";
    of(place.command(from).stdin(open("model.off")).output().unwrap()).failed(2, &["/dev/stdin", "link.off"]);
    for arguments in ["info model.off", "bench model.off --frames 1", "render model.off -o - --format ppm"] {
        let outcome =
            of(place.command(arguments).stdout(append("model.off")).stderr(Stdio::piped()).output().unwrap());
        outcome.failed(2, &["the model model.off", "same file"]);
    }
    let outcome = of(place
        .command("compare a.png b.png")
        .stdout(append("b.png"))
        .stderr(Stdio::piped())
        .output()
        .unwrap());
    outcome.failed(2, &["standard output", "b.png"]);
    assert_eq!(place.read("model.off"), OCTAHEDRON.as_bytes());
    // The earlier content of an open file stays.
    fs::write(place.path("log"), "before\n").unwrap();
    let stats = "render model.off -o c.png --size 32x24 --stats /dev/stderr";
    place.command(stats).stderr(append("log")).status().unwrap();
    let log = String::from_utf8(place.read("log")).unwrap();
    assert!(log.starts_with("before\n") && log.contains("tercio_version"), "{log}");
    let stats = "render model.off -o c.png --size 32x24 --stats /dev/stdout";
    place.command(stats).stdout(append("log")).status().unwrap();
    assert_eq!(String::from_utf8(place.read("log")).unwrap().matches("tercio_version").count(), 2);
}

/// The content of `log`, which is `$0` of the script, after the program and other commands have written to it.
fn log_of(place: &Place, script: &str) -> String {
    let _ = fs::remove_file(place.path("log"));
    let render = format!("{} render model.off -o c.png --size 32x24 --stats", env!("CARGO_BIN_EXE_tercio"));
    let mut shell = Command::new("sh");
    shell.args(["-c", &script.replace("RENDER", &render)]);
    assert!(shell.current_dir(place.path("")).stdin(Stdio::null()).status().unwrap().success(), "{script}");
    String::from_utf8(place.read("log")).unwrap()
}

#[test]
fn a_file_that_is_open_already_keeps_what_is_in_it() {
    let place = place();
    symlink("/dev/stdout", place.path("out")).unwrap();
    symlink("out", place.path("to_out")).unwrap();
    symlink("/dev/stderr", place.path("errors")).unwrap();
    symlink("/proc/self/fd", place.path("open")).unwrap();
    symlink("log", place.path("to_log")).unwrap();
    for name in ["out", "to_out", "/proc/thread-self/fd/1", "open/1", "/dev/fd/1", "./log", "to_log"] {
        let log = log_of(&place, &format!("(echo precious; RENDER {name}; echo more) > log"));
        assert!(log.starts_with("precious\n{") && log.ends_with("}\nmore\n"), "{name}: {log}");
    }
    for name in ["errors", "/dev/stderr", "open/2", "log"] {
        let log = log_of(&place, &format!("(echo precious >&2; RENDER {name}; echo more >&2) 2> log"));
        assert!(log.starts_with("precious\n{") && log.ends_with("}\nmore\n"), "{name}: {log}");
    }
    let log = log_of(&place, "(echo precious >&3; RENDER open/3) 3>> log");
    assert!(log.starts_with("precious\n{"), "{log}");
    // A name determines the format also if it is a link to standard output.
    symlink("/dev/stdout", place.path("p.ppm")).unwrap();
    let outcome = place.run("render model.off -o p.ppm --size 32x24").ok_silently();
    assert!(outcome.stdout.starts_with(b"P6"));
    assert!(fs::symlink_metadata(place.path("p.ppm")).unwrap().is_symlink());
    // If standard output is another file, a file is replaced as usual.
    let log = log_of(&place, "echo old > log; RENDER to_log");
    assert!(log.starts_with('{'), "{log}");
}

#[test]
fn an_output_is_no_other_file_of_the_model() {
    let place = place();
    let square = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\n";
    fs::write(place.path("m.obj"), format!("mtllib d/m.mtl\n{square}usemtl a\nf 1/1 2/1 3/1\n")).unwrap();
    let library = "newmtl a\nKd 1 0 0\nmap_Kd skin.png\nmap_Bump ..\\bumps.png\n";
    fs::write(place.path("d/m.mtl"), library).unwrap();
    fs::write(place.path("d/skin.png"), "skin").unwrap();
    fs::write(place.path("bumps.png"), "bumps").unwrap();
    for output in ["-o d/m.mtl --format png", "-o d/skin.png", "-o x.png --stats here/bumps.png"] {
        let outcome = place.run(&format!("render m.obj {output} --size 32x24 -q"));
        outcome.failed(2, &["material library or texture of m.obj", "same file"]);
    }
    place.run("lab workload m.obj -o d/m.mtl --format boxes").failed(2, &["--output d/m.mtl", "m.obj"]);
    for arguments in
        ["info m.obj", "bench m.obj --frames 1 --size 32x24", "lab simulate hybris m.obj --size 32x24"]
    {
        let library = File::options().append(true).open(place.path("d/m.mtl")).unwrap();
        let output = place.command(arguments).stdout(library).stderr(Stdio::piped()).output().unwrap();
        Outcome::from(output).failed(2, &["standard output", "library or texture of m.obj"]);
    }
    let kept = ["d/m.mtl", "d/skin.png", "bumps.png"].map(|name| place.read(name));
    assert_eq!(kept.map(|bytes| bytes.len()), [library.len(), 4, 5]);
    // A missing texture cannot be overwritten.
    fs::remove_file(place.path("d/skin.png")).unwrap();
    place.run("render m.obj -o d/skin.png --size 32x24 -q").ok_silently();

    let ply = "ply\nformat ascii 1.0\ncomment TextureFile t.png\nelement vertex 3\nproperty float x\n\
        property float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n\
        0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    fs::write(place.path("t.ply"), ply).unwrap();
    fs::write(place.path("t.png"), "texture").unwrap();
    place.run("render t.ply -o t.png --size 32x24").failed(2, &["--output t.png", "texture of t.ply"]);
    assert_eq!(place.read("t.png"), b"texture");
}

#[test]
fn the_rule_holds_for_every_command() {
    let place = place();
    let (a, b) = (place.read("a.png"), place.read("b.png"));
    for diff in ["a.png", "./b.png", "here/a.png"] {
        is_refused(&place, &format!("compare a.png b.png --diff {diff}"), &["--diff", diff, "the picture"]);
    }
    assert_eq!((place.read("a.png"), place.read("b.png")), (a, b));

    place.run("lab workload model.off -o s.boxes --size 64x64").ok_silently();
    fs::write(place.path("m.toml"), place.run("lab machines two-core-2026").stdout).unwrap();
    let machine = place.read("m.toml");
    is_refused(
        &place,
        "lab workload model.off -o link.off --format boxes",
        &["--output link.off", "model.off"],
    );
    let validate = "lab validate builtin:sphere@100 --machine m.toml -o ./m.toml";
    is_refused(&place, validate, &["--output ./m.toml", "the machine m.toml"]);
    is_refused(
        &place,
        "lab validate model.off --machine m.toml -o hard.off",
        &["--output hard.off", "model.off"],
    );
    let appended = ["s.boxes", "m.toml"];
    let before = appended.map(|name| place.read(name));
    for (arguments, file) in [
        ("lab simulate ring s.boxes", "s.boxes"),
        ("lab simulate mcmanus s.boxes", "s.boxes"),
        ("lab simulate sorting s.boxes --machine m.toml", "m.toml"),
        ("lab machines m.toml", "m.toml"),
        ("lab predict model.off --machine m.toml", "m.toml"),
        ("lab advise model.off --machine m.toml", "m.toml"),
    ] {
        let out = File::options().append(true).open(place.path(file)).unwrap();
        let outcome = place.command(arguments).stdout(out).stderr(Stdio::piped()).output().unwrap();
        Outcome::from(outcome).failed(2, &["standard output", file]);
    }
    assert_eq!(appended.map(|name| place.read(name)), before);
    assert_eq!(place.read("m.toml"), machine);
}
