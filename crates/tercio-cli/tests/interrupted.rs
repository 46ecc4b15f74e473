//! Runs that are interrupted leave the old files, and no partial ones.
#![cfg(unix)]

mod common;

use std::fs;
use std::io::Read;
use std::os::unix::process::ExitStatusExt;
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use common::{Outcome, Place};
use rustix::process::{Pid, Signal, kill_process};

/// The picture has its partial file; the run blocks because nobody reads the depths from the full pipe.
const STUCK: &str = "render model.off -o a.png --output-depth - --size 512x512 --quiet";

fn partial_files(place: &Place) -> usize {
    place.names().iter().filter(|name| name.ends_with(".part")).count()
}

/// Waits until a condition holds: false if that takes more than half a minute, which must fail a test, not hang all tests.
fn comes_true(mut condition: impl FnMut() -> bool) -> bool {
    let begin = Instant::now();
    while !condition() {
        if begin.elapsed() > Duration::from_secs(30) {
            return false;
        }
        thread::sleep(Duration::from_millis(2));
    }
    true
}

/// Starts a run that has a partial file and blocks; its output exists already.
fn stuck(place: &Place, mut command: Command) -> Child {
    fs::write(place.path("a.png"), "old").unwrap();
    let mut child =
        command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("the program starts");
    let mut has_ended = false;
    let blocks = comes_true(|| {
        let is_writing = partial_files(place) > 0;
        has_ended = !is_writing && child.try_wait().unwrap().is_some();
        is_writing || has_ended
    });
    if !blocks || has_ended {
        let _ = child.kill();
        let output = child.wait_with_output().unwrap();
        panic!("no partial file, {}: {}", output.status, String::from_utf8_lossy(&output.stderr));
    }
    child
}

fn send(child: &Child, signal: Signal) {
    kill_process(Pid::from_child(child), signal).expect("the program runs");
}

#[test]
fn a_signal_removes_partial_files_and_ends_the_run() {
    let signals = [
        Signal::INT,
        Signal::TERM,
        Signal::HUP,
        Signal::QUIT,
        Signal::ALARM,
        Signal::USR1,
        Signal::USR2,
        Signal::XCPU,
    ];
    for signal in signals {
        let place = Place::new();
        // Some of these signals write a core dump where that is allowed.
        let mut child = stuck(&place, shell(&place, &format!("ulimit -c 0; exec \"$0\" {STUCK}")));
        send(&child, signal);
        // Its output is read only after its end: otherwise it could go on and finish.
        if !comes_true(|| child.try_wait().unwrap().is_some()) {
            let _ = child.kill();
            panic!("{signal:?} did not end the run: was it ignored where the tests were started (nohup, &)?");
        }
        let ended = child.wait_with_output().unwrap();
        // A shell reports 128 plus the number.
        assert_eq!(ended.status.signal(), Some(signal.as_raw()), "{:?}", ended.status);
        assert!(ended.stderr.is_empty());
        assert_eq!(place.names(), ["a.png", "model.off"]);
        assert_eq!(place.read("a.png"), b"old");
    }
}

/// A shell that runs a script, with the program as `$0`.
fn shell(place: &Place, script: &str) -> Command {
    let mut shell = Command::new("sh");
    shell.current_dir(place.path("")).stdin(Stdio::null()).env("TERCIO_CONFIG", "none");
    shell.args(["-c", script, env!("CARGO_BIN_EXE_tercio")]);
    shell
}

#[test]
fn a_file_that_grows_too_large_is_an_error_and_leaves_nothing() {
    let place = Place::new();
    fs::write(place.path("a.png"), "old").unwrap();
    for outputs in ["-o a.png --output-depth d.npy", "--output-depth a.png", "-o a.png --format ppm"] {
        let script = format!("ulimit -f 8; exec \"$0\" render model.off {outputs} --size 512x512 --quiet");
        let outcome = Outcome::from(shell(&place, &script).output().unwrap());
        outcome.failed(1, &["File too large"]);
        assert_eq!(outcome.stderr.lines().count(), 1, "{}", outcome.stderr);
        assert_eq!(place.names(), ["a.png", "model.off"], "{outputs}");
        assert_eq!(place.read("a.png"), b"old", "{outputs}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_run_without_memory_for_writing_leaves_nothing() {
    let place = Place::new();
    fs::write(place.path("a.webp"), "old").unwrap();
    let mut while_writing = 0;
    // The frame has 9 MB, and encoding WebP copies the picture.
    for limit in (8..24).map(|mib| mib << 20) {
        let render = "render model.off -o a.webp --size 1500x1500 --quiet --threads 1 --memory-limit";
        let outcome = place.run(&format!("{render} {limit}"));
        if outcome.code == Some(0) {
            break;
        }
        outcome.failed(1, &["model.off: ", "--memory-limit"]);
        while_writing += u32::from(outcome.stderr.contains("for writing"));
        assert_eq!(place.names(), ["a.webp", "model.off"], "{limit}: {}", outcome.stderr);
        assert_eq!(place.read("a.webp"), b"old");
    }
    assert!(while_writing > 0, "no run came as far as writing");
}

#[test]
fn a_signal_that_is_ignored_from_the_start_stays_ignored() {
    let place = Place::new();
    let mut child = stuck(&place, shell(&place, &format!("trap '' HUP; exec \"$0\" {STUCK}")));
    send(&child, Signal::HUP);
    let mut depths = Vec::new();
    child.stdout.take().unwrap().read_to_end(&mut depths).unwrap();
    let ended = child.wait_with_output().unwrap();
    assert_eq!((ended.status.code(), ended.stderr), (Some(0), vec![]));
    assert!(depths.len() > 512 * 512 * 4 && place.read("a.png").starts_with(b"\x89PNG"));
}
