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
