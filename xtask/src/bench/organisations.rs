//! `--organisation auto` against what it chooses from: ten scenes, ranks of one process and of an MPI job.

use std::path::Path;
use std::process::Command;

use anyhow::{Context as _, Result, ensure};
use serde_json::Value;
use tercio_testkit::workspace_root;

use super::parallel::{bench, build, mpirun, simd};
use super::report::{Report, digits};
use super::{Arguments, machine};
use crate::packages;

/// Models and options: dense and coarse, one sample and several, small and large on the screen, opaque and not.
const SCENES: [(&str, &str); 10] = [
    ("builtin:teapot@100k", "--size 1024x768"),
    ("builtin:teapot@300k", "--size 1920x1080 --aa 1"),
    ("builtin:gyroid@100k", "--size 1024x768"),
    ("builtin:gyroid@60k", "--size 1280x720 --aa 1"),
    ("builtin:terrain@100k", "--size 1024x768"),
    ("builtin:terrain@300k", "--size 1920x1080 --aa 1"),
    ("builtin:sphere@300k", "--size 200x200 --aa 1"),
    ("builtin:soup@5k", "--size 800x600"),
    ("builtin:teapot@50k", "--size 640x480 --opacity 0.5"),
    ("builtin:sphere@10k", "--size 800x600 --copies 27"),
];

const RANKS: [usize; 3] = [2, 4, 8];
/// Processes of the MPI job.
const PROCESSES: usize = 2;
/// Candidates that are predicted to take more than this many times the best one's time are measured only if they are the best of
/// their organisation.
const WORTH: f64 = 1.5;

/// A candidate, in the order of the predictions.
struct Candidate {
    options: String,
    organisation: String,
    predicted: f64,
    /// The fastest turn's median.
    measured: f64,
}

/// Measures and writes `organisations.md`.
///
/// # Errors
/// tercio does not build, or fails.
pub fn run(arguments: &Arguments) -> Result<()> {
    let mpi = packages::check_mpi();
    let program = match &arguments.tercio {
        Some(program) => program.clone(),
        None => build(mpi.is_ok())?,
    };
    let mut report = Report::new(machine::of(&simd(&program)?, "cargo xtask bench organisations")?);
    let introduction = format!(
        "What `--organisation auto` chose, and the fastest of what it compared: milliseconds of a frame, of the median of {} \
         views the least of {} turns. Ways that were predicted to take more than {WORTH} times as long as the chosen one were \
         measured only if they were the best of their organisation.",
        arguments.frames, arguments.rounds
    );
    let columns =
        ["scene", "ranks", "chosen", "predicted", "measured", "fastest", "measured", "ratio", "choosing ms"];
    report.table("Chosen and fastest", &introduction, &columns);
    let mut ratios = Vec::new();
    for (model, options) in SCENES {
        for ranks in RANKS {
            ratios.push(compare(&program, (model, options), ranks, false, arguments, &mut report)?);
        }
        if mpi.is_ok() {
            ratios.push(compare(&program, (model, options), PROCESSES, true, arguments, &mut report)?);
        }
    }
    if let Err(missing) = mpi {
        report.note(&format!("Processes were not measured: {missing:#}."));
    }
    let within = ratios.iter().filter(|&&ratio| ratio <= 1.1).count();
    let worst = ratios.iter().copied().fold(1.0, f64::max);
    report.note(&format!(
        "Chosen over fastest is at most 1.1 in {within} of {} rows, and {} in the worst.",
        ratios.len(),
        digits(worst)
    ));
    report.note_load();
    println!("{}", report.markdown());
    let folder = arguments.output.clone().unwrap_or_else(|| workspace_root().join("docs/performance"));
    report.write_text(&folder, "organisations.md")
}

/// A row: the ratio of chosen and fastest.
fn compare(
    program: &Path,
    (model, options): (&str, &str),
    ranks: usize,
    as_job: bool,
    arguments: &Arguments,
    report: &mut Report,
) -> Result<f64> {
    let measure = |how: &str| {
        if as_job {
            let command = mpirun(program, PROCESSES);
            bench(command, model, &format!("{options} --threads 1 {how}"), arguments.frames)
        } else {
            let options = format!("{options} --ranks {ranks} {how}");
            bench(Command::new(program), model, &options, arguments.frames)
        }
    };
    let auto = measure("--organisation auto")?;
    let choice = &auto["choice"];
    let mut candidates = worth_measuring(&choice["candidates"])?;
    // In turns, so that other load of the machine affects all of them alike.
    for turn in 0..arguments.rounds {
        eprintln!("{model} {options}, {ranks} ranks, turn {} of {}", turn + 1, arguments.rounds);
        for candidate in &mut candidates {
            let measured = measure(&candidate.options)?;
            let median = measured["median_ms"].as_f64().context("tercio bench reports no median")?;
            candidate.measured = candidate.measured.min(median);
        }
    }
    let (chosen, mut fastest) = (&candidates[0], &candidates[0]);
    for candidate in &candidates {
        if candidate.measured < fastest.measured {
            fastest = candidate;
        }
    }
    let ratio = chosen.measured / fastest.measured;
    let short = |options: &str| format!("`{}`", options.trim_start_matches("--organisation "));
    report.row(&[
        format!("{} `{options}`", model.trim_start_matches("builtin:")),
        format!("{ranks}{}", if as_job { ", MPI" } else { "" }),
        short(&chosen.options),
        digits(chosen.predicted),
        digits(chosen.measured),
        short(&fastest.options),
        digits(fastest.measured),
        format!("{ratio:.2}"),
        digits(choice["choosing_milliseconds"].as_f64().unwrap_or(f64::NAN)),
    ]);
    Ok(ratio)
}

/// The candidates that are measured, the chosen one first.
fn worth_measuring(all: &Value) -> Result<Vec<Candidate>> {
    let all = all.as_array().context("tercio bench does not say what it compared")?;
    let mut found = Vec::<Candidate>::new();
    for candidate in all {
        let text = |key: &str| candidate[key].as_str().map(String::from).context("a candidate without names");
        let predicted = candidate["milliseconds"].as_f64().context("a candidate without a time")?;
        let organisation = text("organisation")?;
        let is_worth = found.first().is_none_or(|best| predicted <= WORTH * best.predicted);
        if is_worth || found.iter().all(|other| other.organisation != organisation) {
            let options = text("options")?;
            found.push(Candidate { options, organisation, predicted, measured: f64::INFINITY });
        }
    }
    ensure!(!found.is_empty(), "tercio bench compared nothing");
    Ok(found)
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::worth_measuring;

    #[test]
    fn slow_candidates_are_measured_once_for_each_organisation() {
        let of = |organisation: &str, milliseconds: f64| {
            let options = format!("{organisation} {milliseconds}");
            json!({ "organisation": organisation, "milliseconds": milliseconds, "options": options })
        };
        let all = json!([of("a", 2.0), of("b", 2.9), of("a", 3.0), of("a", 3.1), of("c", 9.0), of("c", 9.5)]);
        let found = worth_measuring(&all).expect("candidates");
        let options: Vec<&str> = found.iter().map(|c| c.options.as_str()).collect();
        assert_eq!(options, ["a 2", "b 2.9", "a 3", "c 9"]);
        assert!(worth_measuring(&json!([])).is_err() && worth_measuring(&json!(null)).is_err());
    }
}
