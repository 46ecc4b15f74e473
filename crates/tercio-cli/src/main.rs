//! The program `tercio`: one command a file, all of them thin over the library of the same name.

mod args;
mod commands;
mod ending;
mod memory;
mod messages;
mod mpi;
mod nothing_drawn;
mod output;
mod progress;
mod report;
mod threads;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

#[global_allocator]
static ALLOCATOR: memory::Allocator = memory::Allocator;

/// Draws very large polygon models without a GPU.
#[derive(Debug, Parser)]
#[command(
    name = "tercio",
    version,
    propagate_version = true,
    max_term_width = 100,
    after_help = "\
Exit code: 0 success, 1 error, 2 wrong usage; of compare, as of cmp: 0 the same, 1 different, 2 error or wrong usage."
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Render(Box<commands::render::Render>),
    Info(commands::info::Info),
    Compare(commands::compare::Compare),
    Bench(commands::bench::Bench),
    Lab(commands::lab::Lab),
}

fn main() -> ExitCode {
    ending::prepare();
    let (result, failure) = match Cli::parse().command {
        Command::Render(command) => (command.run(), 1),
        Command::Info(command) => (command.run(), 1),
        Command::Bench(command) => (command.run(), 1),
        Command::Lab(command) => (command.run(), 1),
        // As with cmp and diff, 1 says that the pictures differ.
        Command::Compare(command) => {
            ending::set_code(2);
            (command.run(), 2)
        }
    };
    match result {
        Ok(code) => code,
        Err(error) if error.is::<output::UsageError>() => {
            messages::error(&error);
            messages::note("\nFor more information, try '--help'.");
            ExitCode::from(2)
        }
        // Whoever read our output has enough; that is no error.
        Err(error) if messages::is_broken_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            messages::error(&error);
            ExitCode::from(failure)
        }
    }
}
