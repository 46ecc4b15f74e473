//! `cargo xtask test`: all checks that have to pass before a change is merged.

use std::io::{self, BufRead as _, BufReader, Write};
use std::panic::resume_unwind;
use std::path::PathBuf;
use std::process::{Command, ExitCode, Stdio};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result};
use clap::ValueEnum;
use tercio_testkit::data::on_ci;

use crate::dist::{self, Outcome};
use crate::libtest::Counts;
use crate::process::{cargo, run as run_command, show};
use crate::{counts, fuzz, packages};

/// Arguments of `cargo xtask test`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Run these steps only
    #[arg(long, value_enum, value_delimiter = ',')]
    only: Vec<Step>,
    /// Seconds for each fuzz target
    #[arg(long, default_value_t = 20)]
    fuzz_seconds: u64,
}

/// A part of the suite.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Step {
    /// The formatting of the source
    Fmt,
    /// Lints; none may fire
    Clippy,
    /// All unit, integration, golden and documentation tests
    Unit,
    /// Lints and tests of ranks over MPI
    Mpi,
    /// Each fuzz target for a short time
    Fuzz,
    /// The static binary in an empty root directory
    Dist,
    /// Instruction counts of that binary, compared with tests/counts.toml
    Counts,
}

/// Runs the steps, all of them even if one fails, and prints at the end how many checks passed and failed: each test,
/// each fuzz target and each other step is one check.
pub fn run(arguments: &Arguments) -> ExitCode {
    packages::provide(packages::TESTS);
    let mut total = Counts::default();
    let mut rows = Vec::new();
    let is_chosen = |step: &Step| arguments.only.is_empty() || arguments.only.contains(step);
    // Optimizing the whole program at once keeps one processor busy, and that for minutes: it begins with the fuzz targets, and the
    // time of its own step is what it takes longer than they.
    let mut dist = None;
    for step in Step::value_variants().iter().copied().filter(is_chosen) {
        if step == Step::Fuzz && is_chosen(&Step::Dist) {
            dist = Some(thread::spawn(dist::build));
        }
        eprintln!("\n== {}", name(step));
        let begin = Instant::now();
        let counts = match step {
            Step::Fmt => one(format()),
            Step::Clippy => one(lint()),
            Step::Unit => tests(),
            Step::Mpi => mpi(),
            Step::Fuzz => fuzz::short_runs(Duration::from_secs(arguments.fuzz_seconds)),
            Step::Dist => static_binary(dist.take()),
            Step::Counts => counts::compare().unwrap_or_else(|error| one(Err(error))),
        };
        total += counts;
        rows.push((step, counts, begin.elapsed()));
    }
    println!();
    for (step, counts, time) in rows {
        // No line of this table may look like a summary line of the test harness.
        println!("{:<8}{:>7.1} s   {counts}", name(step), time.as_secs_f64());
    }
    println!("\n{total}");
    if total.failed == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn name(step: Step) -> String {
    step.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
}

fn one(result: Result<()>) -> Counts {
    if let Err(error) = &result {
        eprintln!("error: {error:#}");
    }
    Counts::one(result.is_ok())
}

fn format() -> Result<()> {
    run_command(cargo().args(["fmt", "--all", "--check"]))?;
    run_command(cargo().args(["fmt", "--check", "--manifest-path", "fuzz/Cargo.toml"]))
}

fn lint() -> Result<()> {
    const DENY: [&str; 3] = ["--", "-D", "warnings"];
    run_command(cargo().args(["clippy", "--workspace", "--all-targets"]).args(DENY))?;
    run_command(fuzz::cargo_in_fuzz("clippy")?.args(DENY))
}

fn tests() -> Counts {
    let mut command = cargo();
    command.args(["test", "--workspace", "--no-fail-fast"]);
    count_tests(&mut command, &mut io::stdout()).unwrap_or_else(|error| one(Err(error)))
}

/// Checks of the feature `mpi`. All packages are selected, so that those without the feature are built as in the steps
/// before, and need no rebuild.
fn mpi() -> Counts {
    const FEATURES: [&str; 2] =
        ["--features", "tercio-mpi/mpi,tercio-cli/mpi,tercio-capi/mpi,tercio-capi/library"];
    if let Err(missing) = packages::check_mpi() {
        if on_ci() {
            return one(Err(missing.context("on CI ranks over MPI may not be skipped")));
        }
        println!("skipped: ranks over MPI: {missing:#}");
        return Counts { ignored: 1, ..Counts::default() };
    }
    let mut lints = cargo();
    lints
        .args(["clippy", "--package", "tercio-mpi", "--package", "tercio-cli", "--package", "tercio-capi"])
        .arg("--all-targets")
        .args(FEATURES);
    let mut counts = one(run_command(lints.args(["--", "-D", "warnings"])));
    // What the tests start, or compile C programs with.
    let mut examples = cargo();
    examples.args(["build", "--workspace", "--example", "wave", "--example", "tercio"]).args(FEATURES);
    counts += one(run_command(&mut examples));
    let mut tests = cargo();
    tests.args(["test", "--workspace", "--no-fail-fast", "--test", "mpi"]).args(FEATURES);
    counts += count_tests(&mut tests, &mut io::stdout()).unwrap_or_else(|error| one(Err(error)));
    counts
}

/// Passes on what the tests print, and adds up their summary lines.
fn count_tests(command: &mut Command, shown: &mut impl Write) -> Result<Counts> {
    show(command);
    let mut child = command.stdout(Stdio::piped()).spawn().context("starting cargo")?;
    let mut stdout = BufReader::new(child.stdout.take().context("cargo's output")?);
    let mut counts = Counts::default();
    let mut line = Vec::new();
    while stdout.read_until(b'\n', &mut line)? > 0 {
        shown.write_all(&line)?;
        shown.flush()?;
        counts += Counts::from_line(&String::from_utf8_lossy(&line)).unwrap_or_default();
        line.clear();
    }
    let status = child.wait()?;
    // What does not build, or dies from a signal, prints no summary line.
    if !status.success() && counts.failed == 0 {
        eprintln!("error: cargo test ended with {status}");
        counts.failed += 1;
    }
    Ok(counts)
}

/// Checks the binary, which may have been begun to build.
fn static_binary(begun: Option<JoinHandle<Result<PathBuf>>>) -> Counts {
    let built =
        begun.map_or_else(dist::build, |begun| begun.join().unwrap_or_else(|panic| resume_unwind(panic)));
    match built.and_then(|binary| dist::check(&binary)) {
        Ok(Outcome::Skipped) => Counts { ignored: 1, ..Counts::default() },
        result => one(result.map(drop)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn count(script: &str) -> Counts {
        // Not to the standard output: the suite that runs this test would count these lines.
        count_tests(Command::new("sh").args(["-c", script]), &mut io::sink()).unwrap()
    }

    #[test]
    fn closing_lines_of_all_binaries_are_added_up() {
        let line = |passed, failed| {
            format!("echo 'test result: ok. {passed} passed; {failed} failed; 1 ignored; 0 measured';")
        };
        let counts = count(&(line(3, 0) + "printf '\\377\\n';" + &line(4, 1) + "exit 101"));
        assert_eq!(counts, Counts { passed: 7, failed: 1, ignored: 2 });
    }

    #[test]
    fn a_failure_without_closing_line_is_counted() {
        assert_eq!(count("exit 101"), Counts { passed: 0, failed: 1, ignored: 0 });
        assert_eq!(count("kill -SEGV $$"), Counts { passed: 0, failed: 1, ignored: 0 });
    }
}
