//! `cargo xtask counts`: counts the instructions of fixed frames and fixed files, and compares them with
//! `tests/counts.toml`.
//!
//! Times vary from run to run by more than most changes gain. The number of instructions that one thread executes does
//! not: it is the same to one part in ten thousand, on any machine, as long as the compiler is the same. Callgrind
//! counts them. They do not show waiting for memory; that is what `cargo xtask bench` is for.

pub mod callgrind;
mod cases;
mod recorded;

use std::process::Command;

use anyhow::{Result, ensure};
use tercio_testkit::data::on_ci;

use crate::libtest::Counts;
use crate::{dist, packages, process};
use cases::CASES;
use recorded::{Recorded, Verdict};

/// Arguments of `cargo xtask counts`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Write the new numbers to tests/counts.toml
    #[arg(long)]
    accept: bool,
}

const NEEDS_AVX2: &str = "AVX2 code is counted, and this processor has no AVX2";

/// Counts, and compares or records.
///
/// # Errors
/// Something does not build or run, or a count has changed and was not accepted.
pub fn run(arguments: &Arguments) -> Result<()> {
    packages::provide(packages::TESTS);
    if arguments.accept {
        let old = Recorded::read().unwrap_or_default();
        let new = measure()?;
        for (name, count) in &new.instructions {
            println!("{}", old.line(name, *count));
        }
        return new.write();
    }
    let counts = compare()?;
    ensure!(counts.failed == 0, "{} of {} counts changed", counts.failed, counts.passed + counts.failed);
    Ok(())
}

/// Compares with the recorded counts, and prints a line each. A changed count is a failure; if the compiler is not that
/// of the record, only on CI.
///
/// # Errors
/// Something does not build or run.
pub fn compare() -> Result<Counts> {
    if !has_avx2() && !on_ci() {
        println!("skipped: {NEEDS_AVX2}");
        return Ok(Counts { ignored: 1, ..Counts::default() });
    }
    let recorded = Recorded::read()?;
    let measured = measure()?;
    let mut counts = Counts::default();
    for (name, count) in &measured.instructions {
        println!("{}", recorded.line(name, *count));
        counts += Counts::one(recorded.verdict(name, *count) == Verdict::Same);
    }
    for name in recorded.instructions.keys().filter(|name| !measured.instructions.contains_key(*name)) {
        println!("{name}: recorded, but no longer counted");
        counts += Counts::one(false);
    }
    if counts.failed > 0 {
        println!("if that is meant: cargo xtask counts --accept");
        if recorded.made_by != measured.made_by {
            println!("recorded with {}, this is {}", recorded.made_by, measured.made_by);
            if !on_ci() {
                counts = Counts { failed: 0, ignored: counts.failed, ..counts };
            }
        }
    }
    Ok(counts)
}

fn measure() -> Result<Recorded> {
    ensure!(has_avx2(), "{NEEDS_AVX2}");
    let binary = dist::build()?;
    let folder = tempfile::tempdir()?;
    let mut instructions = std::collections::BTreeMap::new();
    for case in &CASES {
        for (name, count) in case.count(&binary, folder.path())? {
            instructions.insert(name, count);
        }
    }
    let compiler = process::output(Command::new("rustc").arg("--version"))?;
    let made_by = format!("{} on {}", compiler.trim(), process::host_triple()?);
    Ok(Recorded { made_by, instructions })
}

fn has_avx2() -> bool {
    #[cfg(target_arch = "x86_64")]
    return is_x86_feature_detected!("avx2");
    #[cfg(not(target_arch = "x86_64"))]
    return false;
}
