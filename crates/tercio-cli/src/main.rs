//! The program `tercio`: one command a file, all of them thin over the library of the same name.

mod args;
mod commands;
mod ending;
mod look;
mod memory;
mod messages;
mod mpi;
mod named_files;
mod nothing_drawn;
mod organisation;
mod other_programs;
mod output;
mod progress;
mod report;
mod scene_file;
mod series;
mod short;
mod signals;
mod stdio;
mod stereo;
mod threads;
mod tips;

use std::ffi::OsString;
use std::process::ExitCode;

use anstream::{AutoStream, ColorChoice};
use clap::{CommandFactory as _, FromArgMatches as _, Parser, Subcommand};
use tercio::image::{Destination, remove_partial_files};

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
    Sheet(Box<commands::render::Sheet>),
    Prepare(commands::prepare::Prepare),
    Info(commands::info::Info),
    Compare(commands::compare::Compare),
    Bench(commands::bench::Bench),
    Lab(commands::lab::Lab),
    Completions(commands::definition::Completions),
    Man(commands::definition::Man),
}

impl Command {
    /// Do the processes of an MPI job run it together?
    fn runs_as_job(&self) -> bool {
        match self {
            Self::Render(_) | Self::Bench(_) => true,
            Self::Lab(lab) => lab.runs_as_job(),
            Self::Sheet(_)
            | Self::Prepare(_)
            | Self::Info(_)
            | Self::Compare(_)
            | Self::Completions(_)
            | Self::Man(_) => false,
        }
    }
}

/// The one definition of all commands and options.
fn definition() -> clap::Command {
    short::with_short_help(Cli::command())
}

/// The arguments, with the command that was left out and the options that other programs call otherwise.
fn arguments(program: &clap::Command) -> Vec<OsString> {
    other_programs::translated(short::with_command(program, std::env::args_os()))
}

fn main() -> ExitCode {
    ending::prepare();
    ending::at_end(remove_partial_files);
    let program = definition();
    let arguments = arguments(&program);
    match scene_file::render(&arguments) {
        Ok(None) => {}
        Ok(Some(render)) => return run(Cli { command: Command::Render(Box::new(render)) }),
        Err(error) => return fail(&error, 1),
    }
    let parsed = program.clone().try_get_matches_from(&arguments);
    let cli = match parsed.and_then(|matches| Cli::from_arg_matches(&matches)) {
        Ok(cli) => cli,
        Err(mut answer) => {
            tips::add(&mut answer, &program, &arguments);
            return print_answer(&answer);
        }
    };
    run(cli)
}

fn run(cli: Cli) -> ExitCode {
    signals::watch();
    memory::begin();
    if !cli.command.runs_as_job() && mpi::processes().is_some_and(|processes| processes > 1) {
        // Once, not by each of them.
        if mpi::is_first() {
            let text = "mpirun started several processes, but this command is not run by several together";
            fail(&output::UsageError(text.into()).into(), 2);
        }
        return ExitCode::from(2);
    }
    let (result, failure) = match cli.command {
        Command::Render(command) => (command.run(), 1),
        Command::Sheet(command) => (command.run(), 1),
        Command::Prepare(command) => (command.run(), 1),
        Command::Info(command) => (command.run(), 1),
        Command::Bench(command) => (command.run(), 1),
        Command::Lab(command) => (command.run(), 1),
        Command::Completions(command) => (command.run(), 1),
        Command::Man(command) => (command.run(), 1),
        // As with cmp and diff, exit code 1 means that the pictures differ.
        Command::Compare(command) => {
            ending::set_code(2);
            (command.run(), 2)
        }
    };
    result.unwrap_or_else(|error| fail(&error, failure))
}

/// Prints the error; wrong usage once for all processes of a job that were started alike.
fn fail(error: &anyhow::Error, code: u8) -> ExitCode {
    if error.is::<output::UsageError>() {
        if mpi::is_first_alike() {
            messages::usage_error(error);
        }
        return ExitCode::from(2);
    }
    messages::error(error);
    ExitCode::from(code)
}

/// Prints the parser's answer: help and version, whose printing must not fail silently, or wrong usage.
fn print_answer(answer: &clap::Error) -> ExitCode {
    if answer.use_stderr() {
        if mpi::is_first_alike() {
            messages::answer(answer);
        }
        return ExitCode::from(2);
    }
    let text = answer.render();
    let styled = AutoStream::choice(&std::io::stdout()) != ColorChoice::Never;
    let text = if styled { text.ansi().to_string() } else { text.to_string() };
    match output::write_text(&Destination::Stdout, &text) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => fail(&error, 1),
    }
}
