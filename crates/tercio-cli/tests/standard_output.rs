//! Standard output that cannot be written is an error, for every command that writes there.
#![cfg(target_os = "linux")]

mod common;

use std::process::{Command, Stdio};

use common::{Outcome, Place};

/// Runs the program from a shell, with a redirection.
fn shell(place: &Place, arguments: &str, redirection: &str) -> Outcome {
    let mut command = Command::new("sh");
    command.args(["-c", &format!("\"$0\" {arguments} {redirection}"), env!("CARGO_BIN_EXE_tercio")]);
    command
        .env("TERCIO_CONFIG", "none")
        .current_dir(place.path(""))
        .stdin(Stdio::null())
        .output()
        .expect("a shell")
        .into()
}

#[test]
fn closed_and_full_standard_output_is_an_error() {
    let place = Place::new();
    place.run("render model.off -o a.png --size 32x24").ok_silently();
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
        // Open, but only for reading.
        shell(&place, arguments, "1</dev/null").failed(code, &["standard output"]);
        // Output may be discarded, however the null device is opened.
        assert_eq!(shell(&place, arguments, ">/dev/null").code, Some(0), "{arguments}");
        assert_eq!(shell(&place, arguments, "1<>/dev/null").code, Some(0), "{arguments}");
    }
    // Reported before the model is opened.
    shell(&place, "render missing.ply -o -", ">&-").failed(1, &["standard output", "closed"]);
    // A command that writes nothing there does not need it.
    let quiet = shell(&place, "render model.off -o c.png --size 64x48", ">&-");
    assert_eq!((quiet.code, quiet.stderr.as_str()), (Some(0), ""));
    assert_eq!(shell(&place, "compare a.png a.png --quiet", ">&-").code, Some(0));
}

/// Runs the program with a pipe as standard output whose reader has closed it.
fn unread(place: &Place, arguments: &str) -> Outcome {
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
fn a_reader_that_closes_the_pipe_changes_neither_exit_code_nor_other_outputs() {
    let place = Place::new();
    place.run("render model.off -o a.png --size 32x24").ok_silently();
    place.run("render model.off -o b.png --size 32x24 --view top").ok_silently();
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
        .ok_silently();
    place.run(&format!("render model.off -o e.ppm --output-depth e.npy {size}")).ok_silently();
    assert_eq!(place.read("d.npy"), place.read("e.npy"));
    assert!(place.read("s.json").ends_with(b"}\n"));
    unread(&place, &format!("render model.off -o f.ppm --output-depth - --stats t.json {size}"))
        .ok_silently();
    assert_eq!(place.read("f.ppm"), place.read("e.ppm"));
    assert!(place.read("t.json").ends_with(b"}\n"));
}
