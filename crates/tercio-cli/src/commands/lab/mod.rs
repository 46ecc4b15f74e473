//! `tercio lab`: the laboratory, one file a subcommand.

mod check;
mod eval;
mod reproduce;
mod simulate;
mod workload;

use std::process::ExitCode;

use anyhow::Result;
use clap::{Args, Subcommand};

/// Rebuilds published graphics machines as formulas, descriptions and simulators.
#[derive(Debug, Args)]
pub struct Lab {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Eval(eval::Eval),
    Check(check::Check),
    Reproduce(reproduce::Reproduce),
    Workload(Box<workload::Workload>),
    Simulate(simulate::Simulate),
}

impl Lab {
    /// Runs the subcommand.
    ///
    /// # Errors
    /// What went wrong.
    pub fn run(&self) -> Result<ExitCode> {
        match &self.command {
            Command::Eval(command) => command.run(),
            Command::Check(command) => command.run(),
            Command::Reproduce(command) => command.run(),
            Command::Workload(command) => command.run(),
            Command::Simulate(command) => command.run(),
        }
    }
}
