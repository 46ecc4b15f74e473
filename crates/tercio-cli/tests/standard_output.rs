//! Standard output that takes nothing is an error, for everything that is written there.
#![cfg(target_os = "linux")]

mod common;

use std::process::{Command, Stdio};

use common::{Place, Said};

/// Runs the program from a shell, with a redirection.
fn shell(place: &Place, arguments: &str, redirection: &str) -> Said {
    let mut command = Command::new("sh");
    command.args(["-c", &format!("\"$0\" {arguments} {redirection}"), env!("CARGO_BIN_EXE_tercio")]);
    command.current_dir(place.path("")).stdin(Stdio::null()).output().expect("a shell").into()
}

#[test]
fn closed_and_full_standard_output_is_an_error() {
    let place = Place::new();
    place.run("render model.off -o a.png --size 32x24").quietly_well();
    let commands = [
        ("--help", 1),
        ("--version", 1),
        ("render --help", 1),
        ("render model.off -o - --size 64x48", 1),
        ("render model.off --output-ids /dev/stdout --size 64x48", 1),
        ("render model.off -o b.png --stats - --size 64x48", 1),
        ("info model.off", 1),
        ("bench model.off --frames 1 --size 32x32", 1),
        ("compare a.png a.png", 2),
        ("lab eval eldridge.5.6", 1),
        ("lab machines", 1),
        ("lab workload model.off -o - --format boxes", 1),
    ];
    for (arguments, code) in commands {
        shell(&place, arguments, ">&-").failed(code, &["standard output", "closed"]);
        shell(&place, arguments, ">/dev/full").failed(code, &["standard output", "No space left"]);
        // Open, but for reading.
        shell(&place, arguments, "1</dev/null").failed(code, &["standard output"]);
        // Whoever throws the output away may do so, whichever way it is opened.
        assert_eq!(shell(&place, arguments, ">/dev/null").code, Some(0), "{arguments}");
        assert_eq!(shell(&place, arguments, "1<>/dev/null").code, Some(0), "{arguments}");
    }
    // Told before the model is looked for.
    shell(&place, "render missing.ply -o -", ">&-").failed(1, &["standard output", "closed"]);
    // Whoever writes nothing there does not need it.
    let quiet = shell(&place, "render model.off -o c.png --size 64x48", ">&-");
    assert_eq!((quiet.code, quiet.stderr.as_str()), (Some(0), ""));
    assert_eq!(shell(&place, "compare a.png a.png --quiet", ">&-").code, Some(0));
}

/// Runs the program with a standard output that nobody reads any longer.
fn unread(place: &Place, arguments: &str) -> Said {
    let (reader, writer) = std::io::pipe().expect("a pipe");
    drop(reader);
    place
        .command(arguments)
        .stdout(writer)
        .stderr(Stdio::piped())
        .output()
        .expect("the program starts")
        .into()
}

#[test]
fn a_reader_that_has_enough_changes_neither_the_answer_nor_other_outputs() {
    let place = Place::new();
    place.run("render model.off -o a.png --size 32x24").quietly_well();
    place.run("render model.off -o b.png --size 32x24 --view top").quietly_well();
    for (arguments, code) in [
        ("compare a.png a.png", 0),
        ("compare a.png b.png", 1),
        ("info model.off", 0),
        ("--help", 0),
        ("render model.off -o c.png --size 32x24 --eye 0,0,5 --target 0,0,9 --stats -", 1),
    ] {
        assert_eq!(unread(&place, arguments).code, Some(code), "{arguments}");
    }
    let size = "--size 256x256";
    unread(&place, &format!("render model.off -o - --output-depth d.npy --stats s.json {size}"))
        .quietly_well();
    place.run(&format!("render model.off -o e.ppm --output-depth e.npy {size}")).quietly_well();
    assert_eq!(place.read("d.npy"), place.read("e.npy"));
    assert!(place.read("s.json").ends_with(b"}\n"));
    unread(&place, &format!("render model.off -o f.ppm --output-depth - --stats t.json {size}"))
        .quietly_well();
    assert_eq!(place.read("f.ppm"), place.read("e.ppm"));
    assert!(place.read("t.json").ends_with(b"}\n"));
}
