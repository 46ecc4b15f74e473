//! The project's own commands: `cargo xtask COMMAND`.

#![forbid(unsafe_code)]

mod aarch64;
mod bench;
mod beside;
mod bless;
mod capi;
mod counts;
mod dist;
mod elf;
mod figures;
mod fuzz;
mod gallery;
mod header;
mod libtest;
mod models;
mod options;
mod packages;
mod process;
mod suite;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

#[derive(Parser)]
#[command(bin_name = "cargo xtask", about = "The commands that build, test and document tercio")]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Run all checks: format, lints, tests, short fuzzing, the static binary
    Test(suite::Arguments),
    /// Fuzz the readers and the processing of their models with the stable toolchain
    Fuzz(fuzz::Arguments),
    /// Build one static binary into dist/
    Dist(dist::Arguments),
    /// Draw the golden pictures again and show what changed
    Bless(bless::Arguments),
    /// Count the instructions of fixed frames, and compare them with tests/counts.toml
    Counts(counts::Arguments),
    /// Write the models and scenes that the bench draws, as files for any program
    Models(models::Arguments),
    /// Measure speed and print a table
    Bench(bench::Arguments),
    /// Compare pictures with those of a ray tracer, POV-Ray
    Beside(beside::Arguments),
    /// Test the renderer as a program of AArch64
    Aarch64(aarch64::Arguments),
    /// Build the libraries for C, and install them with their header
    Capi(capi::Arguments),
    /// Make the header of the C interface again
    Header,
    /// Write docs/options.md from the definition of the options
    Options,
    /// Draw the pictures of the README into docs/images/
    Figures,
    /// Draw the pictures of docs/gallery.md, and write that page from docs/gallery.toml; fail when one that was there has changed
    Gallery(gallery::Arguments),
}

fn main() -> ExitCode {
    let result = match Arguments::parse().command {
        Command::Test(arguments) => return suite::run(&arguments),
        Command::Fuzz(arguments) => fuzz::run(&arguments),
        Command::Dist(arguments) => dist::run(&arguments),
        Command::Bless(arguments) => bless::run(&arguments),
        Command::Counts(arguments) => counts::run(&arguments),
        Command::Models(arguments) => models::run(&arguments),
        Command::Bench(arguments) => bench::run(&arguments),
        Command::Beside(arguments) => beside::run(&arguments),
        Command::Aarch64(arguments) => aarch64::run_tests(&arguments),
        Command::Capi(arguments) => capi::run(&arguments),
        Command::Header => header::run(),
        Command::Options => options::run(),
        Command::Figures => figures::run(),
        Command::Gallery(arguments) => gallery::run(&arguments),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}
