//! `tercio lab calibrate`: this machine's description, measured.

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::Result;
use clap::{Args, ValueEnum};
use tercio::image::Destination;
use tercio_lab::predict::calibrate::{Options, calibrate};
use tercio_lab::predict::measure::Clock;
use tercio_lab::predict::ranks;

use crate::args::RunningArgs;
use crate::messages;
use crate::output::write_text;
use crate::threads;

/// Measures this machine, costs of the renderer's work, memory and messages between threads, and writes its
/// description.
#[derive(Debug, Args)]
#[command(after_help = "\
Costs are fitted to frames of built-in models on one thread, whole ones and such that end at earlier stages; the
share that is not divided follows from the whole frames on all threads. Ranks are
fitted to frames of one, two and three of them. Messages are those between threads of
one process, as ranks in one process send them; MPI is not measured.

Examples:
  tercio lab calibrate -o mine.toml
  tercio lab calibrate --clock processor -o mine.toml   (others use the machine at the same time)

Exit code: 0 success, 1 error, 2 wrong usage.")]
pub struct Calibrate {
    /// The file to write, - for standard output.
    #[arg(short, long, value_name = "FILE", default_value = "-")]
    output: PathBuf,
    /// Frames of each picture, of which the fastest counts.
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=1000))]
    frames: u32,
    /// Rounds through all pictures.
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=1000))]
    rounds: u32,
    /// Which clock times frames; processor time does not see threads that wait.
    #[arg(long, value_name = "CLOCK", value_enum, default_value_t = ClockName::Wall)]
    clock: ClockName,
    #[command(flatten)]
    running: RunningArgs,
}

/// Clocks.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum ClockName {
    /// Time that passes.
    Wall,
    /// Processor time of the process, divided by its threads.
    Processor,
}

impl From<ClockName> for Clock {
    fn from(name: ClockName) -> Self {
        match name {
            ClockName::Wall => Self::Wall,
            ClockName::Processor => Self::Processor,
        }
    }
}

impl Calibrate {
    /// Runs the command.
    ///
    /// # Errors
    /// What went wrong.
    pub fn run(&self) -> Result<ExitCode> {
        let destination = Destination::parse(&self.output);
        destination.check()?;
        let pool = threads::pool(self.running.threads)?;
        let options = Options {
            threads: pool.current_num_threads(),
            frames: self.frames,
            rounds: self.rounds,
            clock: self.clock.into(),
        };
        let tell = |what: &str| {
            if self.running.verbose {
                messages::note(what);
            }
        };
        let mut calibration = pool.install(|| calibrate(options, tell))?;
        tell("ranks");
        let costs = ranks::calibrate::measure(self.frames, self.rounds)?;
        ranks::calibrate::describe(
            &costs,
            "fitted by tercio lab calibrate to ranks",
            &mut calibration.machine,
        );
        if self.running.verbose {
            for s in &calibration.samples {
                messages::note(&format!(
                    "{} {}x{} {:?} {:?}: measured {:.3} ms, fitted {:.3} ms",
                    s.model,
                    s.settings.width,
                    s.settings.height,
                    s.settings.sorting,
                    s.settings.last_stage,
                    s.seconds * 1e3,
                    s.fitted * 1e3
                ));
            }
        }
        write_text(&destination, &calibration.machine.to_toml()?)?;
        Ok(ExitCode::SUCCESS)
    }
}
