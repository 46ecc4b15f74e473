//! The machine, compiler and other programs that a table of times belongs to.

use std::process::Command;

use anyhow::Result;

use super::programs::Programs;
use crate::process;

/// One paragraph on the machine and the rivals.
pub fn describe(programs: &Programs) -> Result<String> {
    Ok(format!("{} {}", of(&programs.simd()?, "cargo xtask bench")?, programs.describe_rivals()))
}

/// One paragraph on the machine, where a command measured tercio at a SIMD level.
pub fn of(simd: &str, command: &str) -> Result<String> {
    let read = |path: &str| std::fs::read_to_string(path).unwrap_or_default();
    let (cpu, memory) = (read("/proc/cpuinfo"), read("/proc/meminfo"));
    let value = |text: &str, key: &str| {
        let line = text.lines().find_map(|line| line.strip_prefix(key));
        line.and_then(|line| line.split_once(':'))
            .map_or_else(|| "unknown".into(), |(_, v)| v.trim().to_owned())
    };
    let cores = std::thread::available_parallelism()?;
    let compiler = process::output(Command::new("rustc").arg("--version"))?;
    let commit = process::output(Command::new("git").args(["describe", "--always", "--dirty"]))
        .map_or_else(|_| "unknown".into(), |text| text.trim().to_owned());
    let kibibytes: f64 = value(&memory, "MemTotal").trim_end_matches(" kB").parse().unwrap_or(f64::NAN);
    Ok(format!(
        "Written by `{command}` at commit {commit}. Processor {} (family {}, model {}), {cores} threads; \
         {:.0} GB; {}; tercio takes {simd}.",
        value(&cpu, "model name"),
        value(&cpu, "cpu family"),
        value(&cpu, "model\t"),
        kibibytes * 1024.0 / 1e9,
        compiler.trim(),
    ))
}
