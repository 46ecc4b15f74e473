//! Ranks: every organisation, division and composition with 2 to 64 ranks of one process, and what is measured against the
//! program without ranks ([`super::ranks`]).

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context as _, Result};
use serde_json::Value;
use tercio_testkit::workspace_root;

use super::report::{Report, digits};
use super::{Arguments, machine, ranks};
use crate::{packages, process};

/// Models of about a million triangles: a solid that covers a fifth of the picture, one with many layers, and one that fills it.
const MODELS: [&str; 3] = ["builtin:teapot@1M", "builtin:gyroid@1M", "builtin:terrain@1M"];

const RANKS: [usize; 5] = [2, 4, 8, 16, 64];

/// Ways to share a frame, as options.
const WAYS: [&str; 20] = [
    "--organisation sort-first",
    "--organisation sort-first --division adaptive",
    "--organisation sort-middle",
    "--organisation sort-middle --division interleaved",
    "--organisation sort-middle --division rows",
    "--organisation sort-middle --division columns",
    "--organisation sort-middle --division blocks",
    "--organisation sort-last",
    "--organisation sort-last --encoding sparse",
    "--organisation sort-last --composition binary-swap",
    "--organisation sort-last --composition radix-k --radix 4",
    "--organisation sort-last --composition radix-k --radix 8",
    "--organisation sort-last --composition 2-3-swap",
    "--organisation sort-last --composition tree",
    "--organisation sort-last --composition ring",
    "--organisation sort-twice",
    "--organisation sort-twice --composition binary-swap",
    "--organisation sort-last --aa 1",
    "--organisation sort-last --aa 1 --encoding dense",
    "--organisation sort-last --aa 1 --encoding dense --composition binary-swap",
];

/// Measures and writes `parallel.md`.
///
/// # Errors
/// tercio does not build, or fails.
pub fn run(arguments: &Arguments) -> Result<()> {
    let mpi = packages::check_mpi();
    let program = match &arguments.tercio {
        Some(program) => program.clone(),
        None => build(mpi.is_ok())?,
    };
    let mut report = Report::new(machine::of(&simd(&program)?, "cargo xtask bench parallel")?);
    for model in MODELS {
        virtual_ranks(&program, model, arguments, &mut report)?;
    }
    ranks::overhead(&program, arguments, &mut report)?;
    ranks::active_pixels(&program, arguments, &mut report)?;
    match mpi {
        Ok(()) => ranks::two_processes(&program, arguments, &mut report)?,
        Err(missing) => report.note(&format!("Processes were not measured: {missing:#}.")),
    }
    report.note_load();
    println!("{}", report.markdown());
    let folder = arguments.output.clone().unwrap_or_else(|| workspace_root().join("docs/performance"));
    report.write_text(&folder, "parallel.md")
}

/// Builds the program, with MPI or without.
pub fn build(with_mpi: bool) -> Result<PathBuf> {
    let features: &[&str] = if with_mpi { &["--features", "mpi"] } else { &[] };
    process::run(process::cargo().args(["build", "--release", "--package", "tercio-cli"]).args(features))?;
    Ok(process::target_folder()?.join("release/tercio"))
}

/// The SIMD level that the program uses here.
pub fn simd(program: &Path) -> Result<String> {
    let output = bench(Command::new(program), "builtin:sphere@1k", "--size 8x8", 1)?;
    Ok(output["simd"].as_str().context("tercio bench names no SIMD level")?.to_owned())
}

/// Runs `tercio bench`, which the command begins with.
pub fn bench(mut command: Command, model: &str, options: &str, frames: u32) -> Result<Value> {
    command.args(["bench", model, "--json", "--quiet", "--frames", &frames.to_string()]);
    let text = process::output(command.args(options.split_whitespace()))?;
    serde_json::from_str(&text).context("reading what tercio bench printed")
}

/// Runs the program as an MPI job of so many processes.
pub fn mpirun(program: &Path, processes: usize) -> Command {
    let mut command = Command::new("mpirun");
    if process::is_root() {
        command.arg("--allow-run-as-root");
    }
    command.args(["-n", &processes.to_string()]).arg(program);
    command
}

/// The table of a model.
fn virtual_ranks(program: &Path, model: &str, arguments: &Arguments, report: &mut Report) -> Result<()> {
    let introduction = format!(
        "1920x1080, 4 samples per pixel unless `--aa` says otherwise. Of each number of ranks: megabytes that they send in the last frame, all together; \
         triangles drawn, most over mean; and milliseconds of a frame, the median of {} views, with all ranks on this \
         machine's processors.",
        arguments.frames
    );
    let columns = RANKS.map(|ranks| format!("{ranks}: MB, imbalance, ms"));
    let columns: Vec<&str> = std::iter::once("options").chain(columns.iter().map(String::as_str)).collect();
    report.table(model, &introduction, &columns);
    let alone = bench(Command::new(program), model, "--size 1920x1080", arguments.frames)?;
    for way in WAYS {
        let mut cells = vec![format!("`{way}`")];
        for ranks in RANKS {
            eprintln!("{model}, {ranks} ranks, {way}");
            let options = format!("--size 1920x1080 --ranks {ranks} {way}");
            let measured = bench(Command::new(program), model, &options, arguments.frames)?;
            let last = &measured["last_frame_of_ranks"];
            let megabytes = last["bytes"].as_f64().unwrap_or(f64::NAN) / 1e6;
            let median = measured["median_ms"].as_f64().unwrap_or(f64::NAN);
            cells.push(format!("{}, {}, {}", digits(megabytes), digits(imbalance(last)), digits(median)));
        }
        report.row(&cells);
    }
    let median = alone["median_ms"].as_f64().unwrap_or(f64::NAN);
    report.note(&format!("Without ranks, with all threads: {} ms.", digits(median)));
    Ok(())
}

/// Triangles drawn, most over mean.
fn imbalance(frame: &Value) -> f64 {
    let ranks = frame["ranks"].as_array().map(Vec::as_slice).unwrap_or_default();
    let drawn = ranks.iter().filter_map(|rank| rank["frame"]["backend"]["triangles_drawn"].as_f64());
    let (most, sum) = drawn.fold((0.0f64, 0.0), |(most, sum), n| (most.max(n), sum + n));
    most * ranks.len() as f64 / sum
}
