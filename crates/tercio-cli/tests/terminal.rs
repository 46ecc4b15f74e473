//! Output on a terminal, and in a file or a pipe instead.
#![cfg(target_os = "linux")]

mod common;

use std::fs::File;
use std::io::{BufRead, BufReader, Read, Write};
use std::process::{Child, Command, Stdio};
use std::time::Instant;

use common::{OCTAHEDRON, Place};
use rustix::fs::{Mode, OFlags, open};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};

/// Runs a command whose standard error is a terminal; returns what the terminal received. `look` is called with what it
/// has received so far.
fn on_terminal(command: &mut Command, mut look: impl FnMut(&[u8])) -> String {
    let controller = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).unwrap();
    grantpt(&controller).unwrap();
    unlockpt(&controller).unwrap();
    let name = ptsname(&controller, Vec::new()).unwrap();
    let terminal = open(name, OFlags::RDWR | OFlags::NOCTTY, Mode::empty()).unwrap();
    for variable in ["NO_COLOR", "CLICOLOR", "CLICOLOR_FORCE", "CI"] {
        if command.get_envs().all(|(name, _)| name != variable) {
            command.env_remove(variable);
        }
    }
    let mut child = command.stdout(Stdio::null()).stderr(terminal).spawn().expect("the program starts");
    // The terminal is open in the child only, so that reading ends when the child does.
    command.stderr(Stdio::null());
    let mut shown = Vec::new();
    let mut part = [0; 4096];
    // Linux reports the end of a terminal as an error.
    let mut controller = File::from(controller);
    while let Ok(n @ 1..) = controller.read(&mut part) {
        shown.extend_from_slice(&part[..n]);
        look(&shown);
    }
    child.wait().unwrap();
    String::from_utf8(shown).unwrap()
}

fn shown(place: &Place, arguments: &str, variables: &[(&str, &str)]) -> String {
    let mut command = place.command(arguments);
    command.env("TERM", "xterm").envs(variables.iter().copied());
    on_terminal(&mut command, |_| {})
}

/// The word with the control characters round it.
fn word<'s>(shown: &'s str, word: &str) -> &'s str {
    let from = shown.find('\u{1b}').unwrap_or(0);
    let to = shown.find(word).unwrap_or_else(|| panic!("{word} is not in {shown:?}")) + word.len();
    &shown[from..to]
}

#[test]
fn errors_and_warnings_are_coloured_as_usage_errors_are() {
    let place = Place::new();
    std::fs::write(place.path("odd.off"), "3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n").unwrap();
    let usage = shown(&place, "render --no-such-option", &[]);
    let error = shown(&place, "info missing.ply", &[]);
    assert!(usage.starts_with('\u{1b}'), "{usage:?}");
    assert_eq!(word(&error, "error:"), word(&usage, "error:"));
    let own_usage = shown(&place, "render model.off -o a", &[]);
    assert_eq!(word(&own_usage, "error:"), word(&usage, "error:"));
    let warning = shown(&place, "info odd.off", &[]);
    assert!(warning.contains("\u{1b}[33m") && warning.contains("warning:"), "{warning:?}");

    // A line that is written without allocating.
    File::create(place.path("large.boxes")).unwrap().set_len(1 << 30).unwrap();
    let short = |variables: &[(&str, &str)]| {
        let mut shell = Command::new("sh");
        let run = "ulimit -v 400000; exec \"$0\" lab simulate ring large.boxes";
        shell
            .args(["-c", run, env!("CARGO_BIN_EXE_tercio")])
            .current_dir(place.path(""))
            .env("TERM", "xterm");
        on_terminal(shell.envs(variables.iter().copied()), |_| {})
    };
    let memory = short(&[]);
    assert_eq!(word(&memory, "error:"), word(&usage, "error:"));
    assert!(memory.contains(" needs ") && memory.trim_end().lines().count() == 1, "{memory:?}");

    for variables in [("NO_COLOR", "1"), ("TERM", "dumb")] {
        assert!(short(&[variables]).starts_with("error: needs "), "{variables:?}");
        for arguments in ["info missing.ply", "info odd.off", "render --no-such-option"] {
            let plain = shown(&place, arguments, &[variables]);
            assert!(!plain.contains('\u{1b}') && plain.contains(": "), "{variables:?}: {plain:?}");
        }
    }
    // Elsewhere colours appear only on request.
    assert!(place.run("info missing.ply").stderr.starts_with("error: "));
    let forced = place.command("info missing.ply").env("CLICOLOR_FORCE", "1").output().unwrap();
    assert!(forced.stderr.starts_with(b"\x1b["), "{:?}", String::from_utf8_lossy(&forced.stderr));
}

/// A run that waits for its model.
fn waiting(place: &Place, mode: &str) -> Child {
    let arguments = format!("render - -o a.png --size 32x24 --progress {mode}");
    let mut command = place.command(&arguments);
    command.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped());
    command.spawn().expect("the program starts")
}

#[test]
fn progress_is_printed_in_lines_if_there_is_no_terminal() {
    let place = Place::new();
    let begin = Instant::now();
    let mut child = waiting(&place, "always");
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
    // The model is sent after three lines; if they never come, it is sent at last, so that the test fails instead of
    // waiting.
    let mut stdin = child.stdin.take().unwrap();
    let (seen, are_seen) = std::sync::mpsc::channel::<()>();
    let feeder = std::thread::spawn(move || {
        let _ = are_seen.recv_timeout(std::time::Duration::from_secs(30));
        stdin.write_all(OCTAHEDRON.as_bytes()).unwrap();
    });
    let mut times = Vec::new();
    for _ in 0..3 {
        assert_eq!(lines.next().map(Result::unwrap).as_deref(), Some("progress: reading"));
        times.push(begin.elapsed().as_secs_f64());
    }
    drop(seen);
    // The first line comes after half a second, each other one a second after the one before. A line may be seen late,
    // which makes the interval to the next one look shorter, but never too early, counted from the beginning.
    for (time, least) in times.iter().zip([0.5, 1.3, 2.1]) {
        assert!(*time >= least, "{times:?}");
    }
    feeder.join().unwrap();
    assert!(child.wait().unwrap().success());
    for line in lines.map(Result::unwrap) {
        assert!(line.starts_with("progress: ") && !line.contains(char::is_control), "{line:?}");
    }
}

#[test]
fn progress_is_shown_on_terminals_only_unless_requested() {
    let place = Place::new();
    for mode in ["auto", "never"] {
        let mut child = waiting(&place, mode);
        std::thread::sleep(std::time::Duration::from_millis(800));
        child.stdin.take().unwrap().write_all(OCTAHEDRON.as_bytes()).unwrap();
        let ended = child.wait_with_output().unwrap();
        assert_eq!((ended.status.code(), ended.stderr), (Some(0), vec![]), "{mode}");
    }
    // On a terminal, control characters erase the progress again.
    let (reader, writer) = std::io::pipe().unwrap();
    let mut command = place.command("render - -o a.png --size 32x24");
    command.stdin(reader).env("TERM", "xterm");
    // The model is sent only when the terminal shows that the program waits for it.
    let mut writer = Some(writer);
    let shown = on_terminal(&mut command, |shown| {
        if shown.windows(7).any(|part| part == b"reading")
            && let Some(mut writer) = writer.take()
        {
            writer.write_all(OCTAHEDRON.as_bytes()).unwrap();
        }
    });
    assert!(shown.contains('\u{1b}') && !shown.contains("progress:"), "{shown:?}");
}
