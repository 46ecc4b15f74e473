//! Runs that are interrupted leave the old files, and no partial ones.
#![cfg(unix)]

mod common;

use std::fs;
use std::io::Read;
use std::os::unix::process::ExitStatusExt;
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use common::Place;
use rustix::process::{Pid, Signal, kill_process};

/// The picture has its partial file, and the depths, which nobody takes, do not fit into the pipe.
const STUCK: &str = "render model.off -o a.png --output-depth - --size 512x512 --quiet";

fn partial_files(place: &Place) -> usize {
    place.names().iter().filter(|name| name.ends_with(".part")).count()
}

/// A run that has a partial file and waits, and what was in its place before.
fn stuck(place: &Place, mut command: Command) -> Child {
    fs::write(place.path("a.png"), "old").unwrap();
    let mut child =
        command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("the program starts");
    let begin = Instant::now();
    while partial_files(place) == 0 {
        // A run that never gets there must fail the test, not stop all tests.
        let ended = child.try_wait().unwrap();
        let is_late = begin.elapsed() > Duration::from_secs(30);
        if ended.is_some() || is_late {
            let _ = child.kill();
            let output = child.wait_with_output().unwrap();
            let words = String::from_utf8_lossy(&output.stderr);
            panic!("no partial file after {:?}, {}: {words}", begin.elapsed(), output.status);
        }
        thread::sleep(Duration::from_millis(2));
    }
    child
}

fn send(child: &Child, signal: Signal) {
    kill_process(Pid::from_child(child), signal).expect("the program runs");
}

#[test]
fn a_signal_removes_partial_files_and_ends_the_run() {
    for (signal, number) in [(Signal::INT, 2), (Signal::TERM, 15), (Signal::HUP, 1)] {
        let place = Place::new();
        let mut child = stuck(&place, place.command(STUCK));
        send(&child, signal);
        // Its output is not read before it ended: else it could go on, and end by itself.
        child.wait().unwrap();
        let ended = child.wait_with_output().unwrap();
        // As a shell sees it: 128 and the number.
        assert_eq!(ended.status.signal(), Some(number), "{:?}", ended.status);
        assert!(ended.stderr.is_empty());
        assert_eq!(place.names(), ["a.png", "model.off"]);
        assert_eq!(place.read("a.png"), b"old");
    }
}

#[test]
fn a_signal_that_is_ignored_from_the_start_stays_ignored() {
    let place = Place::new();
    let mut shell = Command::new("sh");
    shell.current_dir(place.path("")).stdin(Stdio::null());
    shell.args(["-c", &format!("trap '' HUP; exec \"$0\" {STUCK}"), env!("CARGO_BIN_EXE_tercio")]);
    let mut child = stuck(&place, shell);
    send(&child, Signal::HUP);
    let mut depths = Vec::new();
    child.stdout.take().unwrap().read_to_end(&mut depths).unwrap();
    let ended = child.wait_with_output().unwrap();
    assert_eq!((ended.status.code(), ended.stderr), (Some(0), vec![]));
    assert!(depths.len() > 512 * 512 * 4 && place.read("a.png").starts_with(b"\x89PNG"));
}
