//! `tercio lab`: the laboratory, one file a subcommand.

mod advise;
mod calibrate;
mod check;
mod eval;
mod machines;
mod measured;
mod plan;
mod predict;
mod reproduce;
mod simulate;
mod validate;
mod validate_advice;
mod validate_ranks;
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
    Machines(machines::Machines),
    Workload(Box<workload::Workload>),
    Simulate(simulate::Simulate),
    Predict(predict::Predict),
    Advise(advise::Advise),
    Calibrate(calibrate::Calibrate),
    Validate(validate::Validate),
}

impl Lab {
    /// Do the processes of an MPI job run it together?
    pub fn runs_as_job(&self) -> bool {
        matches!(self.command, Command::Calibrate(_) | Command::Validate(_))
    }

    /// Runs the subcommand.
    ///
    /// # Errors
    /// What went wrong.
    pub fn run(&self) -> Result<ExitCode> {
        match &self.command {
            Command::Eval(command) => command.run(),
            Command::Check(command) => command.run(),
            Command::Reproduce(command) => command.run(),
            Command::Machines(command) => command.run(),
            Command::Workload(command) => command.run(),
            Command::Simulate(command) => command.run(),
            Command::Predict(command) => command.run(),
            Command::Advise(command) => command.run(),
            Command::Calibrate(command) => command.run(),
            Command::Validate(command) => command.run(),
        }
    }
}
