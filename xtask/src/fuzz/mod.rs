//! `cargo xtask fuzz`: coverage-guided fuzzing from the bytes of a file to the pixels, with the stable toolchain.
//!
//! The targets in `fuzz/` have the layout of cargo-fuzz and run under it, too. cargo-fuzz needs a nightly compiler
//! because of its sanitizers; the coverage instrumentation that guides libFuzzer needs only code generation flags, and
//! the readers are safe Rust, where a sanitizer finds little that overflow checks and panics do not.

mod seeds;

use std::fs::{self, File};
use std::io::{BufRead as _, BufReader, Write as _};
use std::num::NonZero;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use anyhow::{Context as _, Result, bail, ensure};
use clap::ValueEnum;
use tercio_testkit::workspace_root;

use crate::libtest::Counts;
use crate::process;

/// The instrumentation that libFuzzer reads, with the flags of cargo-fuzz, without a sanitizer.
const COVERAGE: [&str; 6] = [
    "--cfg=fuzzing",
    "-Cpasses=sancov-module",
    "-Cllvm-args=-sanitizer-coverage-level=4",
    "-Cllvm-args=-sanitizer-coverage-inline-8bit-counters",
    "-Cllvm-args=-sanitizer-coverage-pc-table",
    "-Cllvm-args=-sanitizer-coverage-trace-compares",
];

/// Largest input in bytes; seeds are no larger either. Small files reach all states of a parser.
const LARGEST_INPUT: u64 = 64 << 10;

/// A program in `fuzz/fuzz_targets`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
#[value(rename_all = "snake_case")]
enum Target {
    /// The PLY reader
    Ply,
    /// The OBJ reader
    Obj,
    /// The STL reader
    Stl,
    /// The OFF reader
    Off,
    /// The readers of VTK's files
    Vtk,
    /// The PCD reader
    Pcd,
    /// The LAS and LAZ reader
    Las,
    /// The reader of point clouds as text
    Xyz,
    /// Decompression, the choice of the reader, and the reader
    SniffRead,
    /// Loading with all its steps, and a small picture from three renderers that must agree
    Picture,
    /// Prepared models, and a small picture of them
    Prepared,
    /// Keyframes of a camera
    CameraPath,
    /// Colour maps
    ColorMap,
    /// Scene files and configurations
    SceneFile,
}

impl Target {
    fn name(self) -> &'static str {
        match self {
            Self::Ply => "ply",
            Self::Obj => "obj",
            Self::Stl => "stl",
            Self::Off => "off",
            Self::Vtk => "vtk",
            Self::Pcd => "pcd",
            Self::Las => "las",
            Self::Xyz => "xyz",
            Self::SniffRead => "sniff_read",
            Self::Picture => "picture",
            Self::Prepared => "prepared",
            Self::CameraPath => "camera_path",
            Self::ColorMap => "color_map",
            Self::SceneFile => "scene_file",
        }
    }
}

/// Arguments of `cargo xtask fuzz`.
#[derive(clap::Args)]
pub struct Arguments {
    /// The target [default: all, one after the other]
    target: Option<Target>,
    /// How long each target runs
    #[arg(long, default_value_t = 60)]
    seconds: u64,
    /// Run this file once instead, such as an input that failed
    #[arg(long, value_name = "FILE", requires = "target")]
    input: Option<PathBuf>,
    /// Merge the corpora first, even small ones
    #[arg(long)]
    merge: bool,
}

/// A corpus with more files than this is merged before use: of the files that reach the same code only the smallest are
/// kept.
const MOST_FILES: usize = 2_000;

/// Fuzzes one target or all.
///
/// # Errors
/// A target does not build, or an input fails, hangs or takes too much memory.
pub fn run(arguments: &Arguments) -> Result<()> {
    let programs = build()?;
    if let (Some(target), Some(input)) = (arguments.target, &arguments.input) {
        return process::run(Command::new(programs.join(target.name())).args(limits(1)).arg(input));
    }
    let mut failed = Vec::new();
    for target in Target::value_variants().iter().copied() {
        if arguments.target.is_some_and(|chosen| chosen != target) {
            continue;
        }
        let merged = if arguments.merge { merge(target, &programs, 1) } else { Ok(()) };
        let time = Duration::from_secs(arguments.seconds);
        if let Err(error) = merged.and_then(|()| fuzz(target, &programs, time, 1)) {
            eprintln!("error: {error:#}");
            failed.push(target.name());
        }
    }
    ensure!(failed.is_empty(), "failed: {}", failed.join(" "));
    Ok(())
}

/// Fuzzes every target for a short time, as many at once as there are processors; each target is one check.
pub fn short_runs(time: Duration) -> Counts {
    let programs = build();
    if let Err(error) = &programs {
        eprintln!("error: {error:#}");
    }
    let threads = std::thread::available_parallelism().map_or(1, NonZero::get);
    // The targets of all threads, and what else is built meanwhile.
    let sharing = threads + 1;
    let waiting = Mutex::new(Target::value_variants().iter());
    let counts = Mutex::new(Counts::default());
    let next = || waiting.lock().unwrap_or_else(PoisonError::into_inner).next();
    let run_all = || {
        while let Some(target) = next() {
            let result = programs.as_ref().ok().map(|programs| fuzz(*target, programs, time, sharing));
            if let Some(Err(error)) = &result {
                eprintln!("error: {error:#}");
            }
            *counts.lock().unwrap_or_else(PoisonError::into_inner) +=
                Counts::one(matches!(result, Some(Ok(()))));
        }
    };
    std::thread::scope(|scope| (0..threads).for_each(|_| drop(scope.spawn(run_all))));
    counts.into_inner().unwrap_or_else(PoisonError::into_inner)
}

/// A cargo command in the fuzz workspace, with the host as an explicit target, so that `RUSTFLAGS` do not apply to
/// build scripts.
///
/// # Errors
/// Cargo or rustc fail.
pub fn cargo_in_fuzz(subcommand: &str) -> Result<Command> {
    let mut command = process::cargo();
    command.args([subcommand, "--release", "--manifest-path", "fuzz/Cargo.toml", "--target"]);
    command.arg(process::host_triple()?).arg("--target-dir").arg(target_folder()?);
    Ok(command)
}

fn target_folder() -> Result<PathBuf> {
    Ok(process::target_folder()?.join("fuzz"))
}

/// Builds all targets and returns the folder of the programs.
fn build() -> Result<PathBuf> {
    ensure!(process::find_program("c++").is_some(), "libFuzzer needs a C++ compiler (Debian: g++)");
    process::run(cargo_in_fuzz("build")?.env("RUSTFLAGS", process::rustflags(&COVERAGE)))?;
    Ok(target_folder()?.join(process::host_triple()?).join("release"))
}

/// One input may take ten seconds and two gigabytes, as any malformed file may. The seconds are those of a clock: as many times as long
/// where so many programs share the processors.
fn limits(sharing: usize) -> [String; 2] {
    [format!("-timeout={}", 10 * sharing), "-rss_limit_mb=2048".into()]
}

/// The folder of a target's inputs that reached new code.
fn corpus_of(target: Target) -> PathBuf {
    workspace_root().join("fuzz/corpus").join(target.name())
}

/// The option that names the folder of failing inputs, which is created.
fn artifacts_of(target: Target) -> Result<String> {
    let folder = workspace_root().join("fuzz/artifacts").join(target.name());
    fs::create_dir_all(&folder)?;
    // The slash at the end makes it a folder.
    Ok(format!("-artifact_prefix={}/", folder.display()))
}

/// Reduces a target's corpus to the smallest files that reach the same code together.
///
/// # Errors
/// A file of the corpus fails: merging would drop it, and the failure would go unnoticed.
fn merge(target: Target, programs: &Path, sharing: usize) -> Result<()> {
    let corpus = corpus_of(target);
    if !corpus.is_dir() {
        return Ok(());
    }
    let artifacts = artifacts_of(target)?;
    let command = || {
        let mut command = Command::new(programs.join(target.name()));
        command.args(limits(sharing)).arg(&artifacts).stdout(Stdio::null());
        command
    };
    process::run(command().arg("-runs=0").arg(&corpus))
        .with_context(|| format!("a file of {} fails", corpus.display()))?;
    let merged = corpus.with_extension("merged");
    if merged.exists() {
        fs::remove_dir_all(&merged)?;
    }
    fs::create_dir_all(&merged)?;
    let before = fs::read_dir(&corpus)?.count();
    process::run(command().arg("-merge=1").args([&merged, &corpus]))?;
    let after = fs::read_dir(&merged)?.count();
    ensure!(after > 0 || before == 0, "merging left nothing of {}", corpus.display());
    replace_folder(&corpus, &merged)?;
    println!("fuzz target {}: {before} files merged into {after}", target.name());
    Ok(())
}

/// Replaces a folder by another one. The old one is deleted last: if this is interrupted, one of them is complete.
fn replace_folder(old: &Path, new: &Path) -> Result<()> {
    let aside = old.with_extension("replaced");
    if aside.exists() {
        fs::remove_dir_all(&aside)?;
    }
    fs::rename(old, &aside)?;
    fs::rename(new, old)?;
    fs::remove_dir_all(&aside)?;
    Ok(())
}

/// Fuzzes a target while so many programs share the processors. If it is alone, what it reports is shown.
fn fuzz(target: Target, programs: &Path, time: Duration, sharing: usize) -> Result<()> {
    let name = target.name();
    let folder = workspace_root().join("fuzz");
    let corpus = corpus_of(target);
    if corpus.is_dir() && fs::read_dir(&corpus)?.count() > MOST_FILES {
        merge(target, programs, sharing)?;
    }
    fs::create_dir_all(&corpus)?;
    let seeds = seeds::write(target, &corpus, LARGEST_INPUT)?;

    let mut command = Command::new(programs.join(name));
    command
        .current_dir(&folder)
        .args(limits(sharing))
        .arg(format!("-max_total_time={}", time.as_secs()))
        .arg(format!("-max_len={LARGEST_INPUT}"))
        .arg(format!("-dict=dict/{name}.dict"))
        .arg(artifacts_of(target)?)
        .arg("-print_final_stats=1")
        .arg(&corpus)
        .stdout(Stdio::null())
        .stderr(Stdio::piped());
    process::show(&command);

    let log_path = target_folder()?.join(format!("{name}.log"));
    let mut log = File::create(&log_path)?;
    let mut child = command.spawn().with_context(|| format!("starting the fuzz target {name}"))?;
    let mut stderr = BufReader::new(child.stderr.take().context("the fuzz target's output")?);
    let mut seen = Seen::default();
    let mut bytes = Vec::new();
    while stderr.read_until(b'\n', &mut bytes)? > 0 {
        log.write_all(&bytes)?;
        let line = String::from_utf8_lossy(&bytes);
        seen.line(line.trim_end());
        if sharing == 1 {
            eprint!("{line}");
        }
        bytes.clear();
    }
    let status = child.wait()?;

    if let Some(input) = &seen.written {
        bail!(
            "fuzz target {name}: {}\n  input: {input}\n  again: cargo xtask fuzz {name} --input {input}\n  log: {}",
            seen.reason.as_deref().unwrap_or("failed"),
            log_path.display()
        );
    }
    ensure!(status.success(), "fuzz target {name}: {status}, log: {}", log_path.display());
    // Without counters libFuzzer mutates at random, and a run without failures means little.
    ensure!(seen.counters > 0, "fuzz target {name} was built without coverage counters");
    ensure!(seen.runs > 0, "fuzz target {name} ran no input");
    println!("fuzz target {name}: {} runs from {seeds} seeds, {} edges covered", seen.runs, seen.edges);
    Ok(())
}

/// The results in libFuzzer's log.
#[derive(Debug, Default)]
struct Seen {
    counters: u64,
    runs: u64,
    edges: u64,
    /// The panic message, or libFuzzer's message.
    reason: Option<String>,
    /// Path of the failing input.
    written: Option<String>,
}

impl Seen {
    fn line(&mut self, line: &str) {
        let number_after = |text: &str| {
            let (_, rest) = line.split_once(text)?;
            let rest = rest.trim_start();
            rest[..rest.find(|c: char| !c.is_ascii_digit()).unwrap_or(rest.len())].parse::<u64>().ok()
        };
        if line.contains("inline 8-bit counters") {
            self.counters = number_after("(").unwrap_or(0);
        } else if let Some(runs) = number_after("stat::number_of_executed_units:") {
            self.runs = runs;
        } else if line.starts_with('#') {
            self.edges = number_after(" cov:").unwrap_or(self.edges);
        } else if let Some((_, path)) = line.split_once("Test unit written to ") {
            // Slow inputs are written, too, but they are within the limit and no failure.
            if !path.contains("slow-unit-") {
                self.written = Some(path.to_owned());
            }
        } else if line.contains("panicked at") || line.contains("ERROR: libFuzzer") {
            self.reason.get_or_insert_with(|| line.trim().to_owned());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_merged_corpus_replaces_the_old_one() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        // Leftovers of an interrupted run do not matter.
        for (path, text) in [("c/old", "a"), ("c.merged/new", "b"), ("c.replaced/older", "c")] {
            fs::create_dir_all(at(path).parent().unwrap()).unwrap();
            fs::write(at(path), text).unwrap();
        }
        replace_folder(&at("c"), &at("c.merged")).unwrap();
        assert_eq!(fs::read_to_string(at("c/new")).unwrap(), "b");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
        assert_eq!(fs::read_dir(at("c")).unwrap().count(), 1);
    }

    #[test]
    fn the_log_of_a_good_run_is_understood() {
        let mut seen = Seen::default();
        for line in [
            "INFO: Loaded 1 modules   (159 inline 8-bit counters): 159 [0x1, 0x2), ",
            "INFO: Loaded 1 PC tables (159 PCs): 159 [0x1,0x2), ",
            "#2\tINITED cov: 8 ft: 8 corp: 1/1b exec/s: 0 rss: 27Mb",
            "#56448447\tDONE   cov: 9 ft: 9 corp: 2/5b lim: 4096 exec/s: 2688021 rss: 27Mb",
            "stat::number_of_executed_units: 56448447",
            "artifact_prefix='x/'; Test unit written to x/slow-unit-0a",
        ] {
            seen.line(line);
        }
        assert_eq!((seen.counters, seen.runs, seen.edges), (159, 56448447, 9));
        assert_eq!((seen.reason, seen.written), (None, None));
    }

    #[test]
    fn a_crash_is_reported_with_its_panic_and_its_input() {
        let mut seen = Seen::default();
        for line in [
            "thread '<unnamed>' (9788) panicked at fuzz_targets/a.rs:4:85:",
            "==9788== ERROR: libFuzzer: deadly signal",
            "artifact_prefix='x/'; Test unit written to x/crash-93c5",
        ] {
            seen.line(line);
        }
        assert!(seen.reason.unwrap().contains("panicked at fuzz_targets/a.rs:4:85"));
        assert_eq!(seen.written.as_deref(), Some("x/crash-93c5"));
    }

    #[test]
    fn every_target_has_its_files() {
        for target in Target::value_variants() {
            let fuzz = workspace_root().join("fuzz");
            assert!(fuzz.join(format!("fuzz_targets/{}.rs", target.name())).is_file(), "{target:?}");
            assert!(fuzz.join(format!("dict/{}.dict", target.name())).is_file(), "{target:?}");
            assert_eq!(target.to_possible_value().unwrap().get_name(), target.name());
        }
    }
}
