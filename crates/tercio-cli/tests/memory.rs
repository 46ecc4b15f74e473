//! Errors when memory is short name the purpose, the amount, and who set the limit.
#![cfg(target_os = "linux")]

mod common;

use std::fs::File;
use std::process::{Command, Stdio};

use common::{Outcome, Place};

/// Runs the program with `ulimit -v`, in KiB.
fn limited(place: &Place, kibibytes: u32, arguments: &str) -> Outcome {
    let mut shell = Command::new("sh");
    let program = env!("CARGO_BIN_EXE_tercio");
    shell.args(["-c", &format!("ulimit -v {kibibytes}; exec {program} {arguments}")]);
    // Many threads would have no room for their stacks.
    shell.env("SLURM_CPUS_PER_TASK", "2").env("TERCIO_CONFIG", "none");
    shell.current_dir(place.path("")).stdin(Stdio::null()).output().expect("a shell").into()
}

#[track_caller]
fn one_line(outcome: Outcome, code: i32, parts: &[&str]) {
    outcome.failed(code, parts);
    assert_eq!(outcome.stderr.lines().count(), 1, "{}", outcome.stderr);
}

#[test]
fn every_line_names_the_model_and_who_set_the_limit() {
    let place = Place::new();
    let by_option = "(--memory-limit)";
    let sphere = "builtin:sphere@1k";
    for (arguments, limit, parts) in [
        ("render builtin:sphere@1k -o a.png --size 4000x4000", "8M", ["the picture needs", "8000000 bytes"]),
        ("render builtin:sphere@1k -o a.png", "1", ["needs ", " 1 bytes"]),
        ("lab simulate hybris builtin:sphere@1k", "1", ["needs ", " 1 bytes"]),
        ("info builtin:sphere@1k", "1", ["needs ", " 1 bytes"]),
    ] {
        let outcome = place.run(&format!("{arguments} --memory-limit {limit}"));
        one_line(outcome, 1, &[&format!("error: {sphere}: "), parts[0], parts[1], by_option]);
    }
    one_line(
        place.run("info builtin:sphere@50M --memory-limit 9M"),
        1,
        &["builtin:sphere@50M: needs", "9000000", by_option],
    );

    let left = "(what ulimit -v leaves)";
    for (arguments, parts) in [
        ("info builtin:sphere@50M --threads 2", ["builtin:sphere@50M: needs", "for the model"]),
        (
            "render builtin:sphere@1k -o a.ppm --size 20000x20000 --threads 2",
            ["error: builtin:sphere@1k: ", "the picture needs"],
        ),
    ] {
        one_line(limited(&place, 400_000, arguments), 1, &[parts[0], parts[1], left]);
    }
}

#[test]
fn a_limit_of_the_system_holds_for_every_command() {
    let place = Place::new();
    // Sparse files take no space until they are read.
    for name in ["large.boxes", "large.polygons", "large.png", "large.toml"] {
        File::create(place.path(name)).unwrap().set_len(1 << 30).unwrap();
    }
    for (arguments, code) in [
        ("lab simulate ring large.boxes", 1),
        ("lab simulate mcmanus large.boxes", 1),
        ("lab simulate ortega large.polygons", 1),
        ("lab simulate parks large.polygons", 1),
        ("lab machines large.toml", 1),
        ("compare large.png large.png", 2),
    ] {
        let outcome = limited(&place, 400_000, arguments);
        one_line(outcome, code, &["bytes or more for this command, the limit is", "(what ulimit -v leaves)"]);
    }
}
