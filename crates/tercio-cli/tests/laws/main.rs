//! The laws of time and memory, tested with the program as a user runs it.
#![cfg(target_os = "linux")]

mod memory;
mod series;

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use memory::Memory;
use series::SERIES;
use tempfile::TempDir;
use tercio_testkit::require_shared;
use wait4::Wait4 as _;

const MIB: u64 = 1 << 20;

/// What a run took and printed.
struct Run {
    code: Option<i32>,
    stderr: String,
    /// CPU time in user and kernel mode.
    cpu: Duration,
    memory: Memory,
}

fn run(folder: &Path, command: &mut Command) -> Run {
    loop {
        let errors = tempfile::NamedTempFile::new_in(folder).expect("a file");
        command.current_dir(folder).stdin(Stdio::null()).stdout(Stdio::null());
        command.stderr(errors.reopen().expect("the file"));
        let mut child = command.spawn().expect("the program starts");
        let memory = memory::until_end(&child);
        let end = child.wait4().expect("the program runs");
        let stderr = String::from_utf8_lossy(&fs::read(errors.path()).expect("the file")).into_owned();
        // Without memory it had ended before it could be watched.
        if let Some(memory) = memory {
            let cpu = end.rusage.utime + end.rusage.stime;
            return Run { code: end.status.code(), stderr, cpu, memory };
        }
    }
}

fn tercio(arguments: &str, model: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_tercio"));
    let (name, rest) = arguments.split_once(' ').unwrap_or((arguments, ""));
    command.args([name, model]).args(rest.split_whitespace()).env("TERCIO_CONFIG", "none");
    command
}

fn place() -> TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("a.mtl"), "newmtl m1\nKd 1 0 0\n".repeat(2000)).expect("a library");
    folder
}

/// Makes a file of a series.
fn make(folder: &Path, name: &str, n: usize) {
    let (.., make) = SERIES.iter().find(|s| s.0 == name).expect("a series");
    fs::write(folder.join(name), make(n)).expect("room for it");
}

/// The exit code for a file of the series: all but one are models.
fn code_of(name: &str) -> i32 {
    i32::from(name == "zeros.stl")
}

/// The instructions that a run executes, counted by valgrind.
fn instructions(folder: &Path, name: &str, arguments: &str) -> u64 {
    let (program, total) = (tercio(arguments, name), folder.join("callgrind.out"));
    let mut command = Command::new("valgrind");
    command.args(["--tool=callgrind", "--quiet"]).arg(format!("--callgrind-out-file={}", total.display()));
    command.arg(program.get_program()).args(program.get_args()).args(["--threads", "1"]);
    command.env("TERCIO_CONFIG", "none");
    let run = run(folder, &mut command);
    assert_eq!(run.code, Some(code_of(name)), "{name}, {arguments}, by valgrind: {}", run.stderr);
    let text = fs::read_to_string(total).expect("what valgrind wrote");
    let total = text.lines().find_map(|line| line.strip_prefix("totals: ")).expect("a total");
    total.trim().parse().expect("a number")
}

/// A file sixteen times as large may cost as much as sixteen runs of the small one, times two and a half for logarithms
/// and caches. A cost that grows with the power 1.5 is four times that of these runs, with the square 16 times.
///
/// CPU time only says which files cost little enough. It varies on a busy machine, so where it is larger the
/// instructions of one thread decide, which hardly vary; counting them for all files would take an hour. They are those of the
/// program, without the time of the system and of memory.
#[test]
fn time_grows_with_the_file_and_not_faster() {
    const TIMES: usize = 16;
    // Shorter times count as this.
    const FLOOR: Duration = Duration::from_millis(200);
    let folder = place();
    let time = |name: &str, arguments: &str| {
        let run = run(folder.path(), &mut tercio(arguments, name));
        // A file that is refused takes no time.
        assert_eq!(run.code, Some(code_of(name)), "{name}: {}", run.stderr);
        run.cpu
    };
    for (name, n, _) in SERIES {
        for arguments in ["info --quiet", "render --quiet -o picture.png --allow-empty --size 8x8"] {
            make(folder.path(), name, n);
            let short: Duration = (0..TIMES).map(|_| time(name, arguments)).sum();
            make(folder.path(), name, TIMES * n);
            if time(name, arguments) <= (short * 5 / 2).max(FLOOR) {
                continue;
            }
            let long = instructions(folder.path(), name, arguments);
            make(folder.path(), name, n);
            let short = TIMES as u64 * instructions(folder.path(), name, arguments);
            assert!(
                long <= short * 5 / 2,
                "{name}, {arguments}: {short} instructions for {TIMES} files, and {long} for one of their size"
            );
        }
    }
}

/// What a process may take beside its limit: stacks, the heap's own, and data of the program and its libraries.
const BESIDE: u64 = 4_000_000;

/// A run stays within the limit, or reports in one line that it cannot.
#[track_caller]
fn check_memory(folder: &Path, arguments: &str, model: &str, limit: u64) {
    let mut command = tercio(arguments, model);
    command.args(["--quiet", "--threads", "2", "--memory-limit", &limit.to_string()]);
    let run = run(folder, &mut command);
    let what = format!("{arguments} {model} in {limit} bytes: {}", run.stderr);
    assert!(run.memory.own() <= limit + BESIDE, "took {:?}: {what}", run.memory);
    match run.code {
        Some(0) => assert_eq!(run.stderr, "", "{what}"),
        Some(1) => {
            assert_eq!(run.stderr.lines().count(), 1, "{what}");
            let names_limit =
                run.stderr.starts_with("error: ") && run.stderr.contains(&format!("{limit} bytes"));
            assert!(names_limit || code_of(model) == 1, "{what}");
        }
        code => panic!("{code:?}: {what}"),
    }
}

#[test]
fn memory_stays_inside_the_limit_whatever_is_read() {
    let folder = place();
    for (name, n, _) in SERIES {
        make(folder.path(), name, 8 * n);
        // With ample memory nothing is refused.
        let run = run(folder.path(), &mut tercio("info --quiet --memory-limit 4G", name));
        assert_eq!(run.code, Some(code_of(name)), "{name}: {}", run.stderr);
        for limit in [6 * MIB, 20 * MIB, 48 * MIB] {
            check_memory(folder.path(), "info", name, limit);
            check_memory(folder.path(), "render -o picture.png --allow-empty --size 16x16", name, limit);
        }
    }
}

#[test]
fn memory_stays_inside_the_limit_for_real_models() {
    let Some(data) = require_shared("memory_stays_inside_the_limit_for_real_models") else { return };
    let folder = place();
    let mut models = Vec::new();
    let mut folders = vec![data];
    while let Some(next) = folders.pop() {
        for entry in fs::read_dir(next).expect("a folder").flatten() {
            let (path, size) = (entry.path(), entry.metadata().map_or(0, |m| m.len()));
            let name = entry.file_name().to_string_lossy().to_lowercase();
            let is_model =
                ["ply", "obj", "stl", "off", "gz"].iter().any(|e| name.ends_with(&format!(".{e}")));
            if path.is_dir() {
                folders.push(path);
            } else if is_model && (2 * MIB..64 * MIB).contains(&size) {
                models.push((size, path));
            }
        }
    }
    models.sort();
    // The largest ones, and some of every size.
    let step = models.len().div_ceil(8).max(1);
    for (size, path) in models.iter().rev().step_by(step) {
        let model = path.to_str().expect("a name of text");
        for limit in [size / 2, 2 * size] {
            check_memory(folder.path(), "info", model, limit.max(6 * MIB));
            check_memory(
                folder.path(),
                "render -o picture.png --allow-empty --size 64x64",
                model,
                limit.max(6 * MIB),
            );
        }
    }
}

#[test]
fn pictures_and_ranks_count_too() {
    let folder = place();
    let model = "builtin:sphere@50k";
    for arguments in [
        "render -o picture.png --allow-empty --size 1500x1500",
        "render -o picture.ppm --allow-empty --size 1500x1500 --output-depth d.npy --output-ids i.npy --output-normals n.npy",
        "render -o picture.png --allow-empty --size 600x600 --ranks 4 --organisation sort-last",
        "bench --frames 2 --size 600x600",
    ] {
        for limit in [12, 24, 40, 64, 120] {
            check_memory(folder.path(), arguments, model, limit * MIB);
        }
    }
}

#[test]
fn a_limit_of_the_system_leads_to_a_picture_or_one_line() {
    let folder = place();
    make(folder.path(), "fan.ply", 150_000);
    let program = env!("CARGO_BIN_EXE_tercio");
    let (mut pictures, mut errors) = (0, 0);
    // In KiB. With less the program itself cannot be loaded.
    for (ulimit, first) in [("-v", 48_000), ("-d", 6_000)] {
        for step in 0..16 {
            let limit = first + (step * step) * 1200;
            let arguments = "render fan.ply -o picture.png --allow-empty --size 64x64 --quiet --threads 2 --progress always";
            let mut shell = Command::new("sh");
            shell.args(["-c", &format!("ulimit {ulimit} {limit}; exec {program} {arguments}")]);
            let run = run(folder.path(), &mut shell);
            let what = format!("ulimit {ulimit} {limit}: {:?} {}", run.code, run.stderr);
            match run.code {
                Some(0) => pictures += 1,
                Some(1) => {
                    errors += 1;
                    assert!(run.stderr.starts_with("error: ") && run.stderr.lines().count() == 1, "{what}");
                }
                _ => panic!("{what}"),
            }
        }
    }
    assert!(pictures > 4 && errors > 4, "{pictures} pictures, {errors} errors");
}

#[test]
fn a_file_larger_than_the_limit_is_read_if_its_mesh_is_not() {
    let folder = place();
    make(folder.path(), "digits.obj", 30_000);
    assert!(fs::metadata(folder.path().join("digits.obj")).is_ok_and(|m| m.len() > 30 * MIB));
    let mut command = tercio("info --quiet --threads 2 --memory-limit 9M", "digits.obj");
    let run = run(folder.path(), &mut command);
    assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""));
    assert!(run.memory.own() <= 9_000_000 + BESIDE, "{:?}", run.memory);
}

#[test]
fn every_command_says_its_exit_codes() {
    let folder = place();
    let help = |words: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_tercio")).args(words).arg("--help").output();
        String::from_utf8(output.expect("the program runs").stdout).expect("text")
    };
    let mut commands: Vec<Vec<String>> = vec![Vec::new()];
    while let Some(words) = commands.pop() {
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        let text = help(&words);
        let below =
            text.lines().skip_while(|l| *l != "Commands:").skip(1).take_while(|l| l.starts_with("  "));
        let names: Vec<&str> = below
            .filter(|l| !l.starts_with("    "))
            .filter_map(|l| l.split_whitespace().next())
            .filter(|n| *n != "help")
            .collect();
        if names.is_empty() || words.is_empty() {
            assert!(text.contains("Exit code: 0 "), "{words:?} does not say its exit codes:\n{text}");
        }
        let deeper = |name: &&str| words.iter().chain([name]).map(ToString::to_string).collect();
        commands.extend(names.iter().map(deeper));
    }
    for (arguments, code) in [
        ("--version", 0),
        ("", 2),
        ("render", 2),
        ("render a.mtl -o", 2),
        ("info no.ply", 1),
        ("info a.mtl", 1),
        ("compare no.png no.png", 2),
        ("compare", 2),
        ("lab eval no-such-formula", 1),
    ] {
        let mut command = Command::new(env!("CARGO_BIN_EXE_tercio"));
        let run = run(folder.path(), command.args(arguments.split_whitespace()));
        assert_eq!(run.code, Some(code), "tercio {arguments}: {}", run.stderr);
    }
}
