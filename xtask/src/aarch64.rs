//! `cargo xtask aarch64`: builds the renderer's tests for AArch64 and runs them under emulation.
//!
//! The scalar and the NEON level draw the same golden pictures as the levels of x86-64. Not part of `cargo xtask test`:
//! the standard library of another target has to be downloaded, which not every machine may do.

use std::env::consts::ARCH;
use std::process::Command;

use anyhow::Result;

use crate::packages;
use crate::process::{cargo, run};

const TARGET: &str = "aarch64-unknown-linux-gnu";

/// Builds the program, and builds and runs the tests of the given packages.
#[derive(clap::Args)]
pub struct Arguments {
    /// Packages whose tests run
    #[arg(short, long = "package", default_values_t = ["tercio-raster".to_owned()])]
    packages: Vec<String>,
}

pub fn run_tests(arguments: &Arguments) -> Result<()> {
    let mut build = cargo();
    let mut test = cargo();
    if ARCH != "aarch64" {
        packages::provide(packages::AARCH64);
        run(Command::new("rustup").args(["target", "add", TARGET]))?;
        for command in [&mut build, &mut test] {
            command.env("CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_LINKER", "aarch64-linux-gnu-gcc").env(
                "CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_RUNNER",
                "qemu-aarch64 -L /usr/aarch64-linux-gnu",
            );
        }
    }
    run(build.args(["build", "--package", "tercio-cli", "--target", TARGET]))?;
    test.args(["test", "--no-fail-fast", "--target", TARGET]);
    test.args(arguments.packages.iter().flat_map(|package| ["--package", package]));
    run(&mut test)
}
