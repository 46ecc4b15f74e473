//! `tercio lab calibrate`: measures a description of this machine.

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::Result;
use clap::{Args, ValueEnum};
use tercio::image::Destination;
use tercio::parallel::Communicator as _;
use tercio_lab::machines::Network;
use tercio_lab::predict::calibrate::{Options, Progress, calibrate};
use tercio_lab::predict::measure::Clock;
use tercio_lab::predict::messages::{Way, measure, network};
use tercio_lab::predict::ranks;

use crate::args::RunningArgs;
use crate::named_files::NamedFiles;
use crate::output::{check, write_text};
use crate::{messages, mpi, threads};

/// Measures this machine (costs of the renderer's work, memory, messages between threads and, if started by mpirun,
/// over MPI) and writes its description.
#[derive(Debug, Args)]
#[command(after_help = "\
Costs are fitted to frames of built-in models on one thread, whole ones and ones that end at earlier stages; the
serial share follows from the whole frames on all threads. Costs of ranks are fitted to frames of one, two and
three of them. Residuals of the fit, spread of the rounds, day, processor and version are in the section calibration.
A measurement that is doubtful (rounds that spread by more than 15 %, residuals above 20 %, a serial share above 15 %)
is repeated, by default at most twice (--repeats); if that does not help, it is kept with a warning, which is in the file, too (calibration.doubt), or
refused above 25 %, 40 % and 50 %. Messages are sent back and forth: half
the median round trip of small ones is the latency, that of large ones gives the bandwidth. Those between threads of
one process are the section network. mpirun with two processes or more measures the section mpi first, between ranks
0 and 1; then all ranks except 0, which writes, end. mpirun may bind a process to one processor: with --bind-to none
rank 0 can use its whole machine.

Examples:
  tercio lab calibrate -o mine.toml
  tercio lab calibrate --clock processor -o mine.toml   (others use the machine at the same time)
  mpirun -n 2 --bind-to none tercio lab calibrate -o mine.toml   (built with --features mpi)
  mpirun -n 2 --map-by node --bind-to none tercio lab calibrate -o cluster.toml   (between two machines)

Exit code: 0 success, 1 error, 2 wrong usage.")]
pub struct Calibrate {
    /// The file to write, - for standard output.
    #[arg(short, long, value_name = "FILE", default_value = "-")]
    output: PathBuf,
    /// Frames of each picture; the fastest counts.
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=1000))]
    frames: u32,
    /// Rounds through all pictures, at least 2.
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(2..=1000))]
    rounds: u32,
    /// How often a doubtful measurement is repeated, at most; each takes as long as the first.
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u32).range(..=1000))]
    repeats: u32,
    /// Which clock times frames; processor time does not see threads that wait.
    #[arg(long, value_name = "CLOCK", value_enum, default_value_t = ClockName::Wall)]
    clock: ClockName,
    /// Writes the description even if the measurement is too noisy; its section calibration says how noisy and why.
    #[arg(long)]
    accept_noise: bool,
    #[command(flatten)]
    running: RunningArgs,
}

/// Clocks.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum ClockName {
    /// Wall-clock time.
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
        let destination = Destination::from_path(&self.output);
        NamedFiles::default().writes("--output", &destination).check()?;
        let mpi = match mpi::processes() {
            Some(processes) if processes > 1 => match mpi::run(|comm| over_mpi(comm, &destination))? {
                Some(measured) => Some(measured),
                None => return Ok(ExitCode::SUCCESS),
            },
            _ => {
                check(&destination)?;
                None
            }
        };
        // All ranks except this one have ended.
        let mut alone = self.running.clone();
        alone.threads = alone.threads.or(mpi.is_some().then(threads::without_others));
        let pool = alone.pool()?;
        let options = Options {
            threads: pool.current_num_threads(),
            frames: self.frames,
            rounds: self.rounds,
            clock: self.clock.into(),
            repeats: self.repeats,
            accept_noise: self.accept_noise,
        };
        let bound = threads::of_machine().filter(|&all| mpi.is_some() && all > options.threads);
        if let Some(all) = bound.filter(|_| self.running.threads.is_none() && !self.running.quiet) {
            messages::warning(&format!(
                "this process may use {} of {all} processors; if mpirun bound it, --bind-to none allows all of them",
                options.threads
            ));
        }
        let progress = |what: Progress<'_>| match what {
            Progress::Next(what) if self.running.verbose => messages::note(what),
            Progress::Repeated(why) if !self.running.quiet => {
                messages::warning(&format!("the machine is busy, so it is measured again: {why}"));
            }
            Progress::Doubtful(why) if !self.running.quiet => {
                messages::warning(&format!(
                    "the measurement is doubtful, as calibration.doubt in the file says: {why}"
                ));
            }
            _ => {}
        };
        let mut calibration = pool.install(|| calibrate(options, mpi, progress))?;
        progress(Progress::Next("ranks"));
        let costs = ranks::calibrate::measure(self.frames, self.rounds, &calibration.machine)?;
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

/// Measures messages over MPI with all ranks of the job; the result is rank 0's.
fn over_mpi(comm: &mut mpi::Comm, destination: &Destination) -> Result<Option<Network>> {
    if comm.rank() == 0 {
        check(destination)?;
    }
    let measured = measure(comm, Way::Copied)?;
    let own = comm.machine().into_bytes();
    let other = comm.gather(2, own.clone())?.into_iter().next();
    Ok(measured.map(|measured| {
        let (machines, hop) = if other.is_some_and(|name| name == own) {
            ("one machine", "one machine: no switch between ranks 0 and 1")
        } else {
            ("two machines", "what is between ranks 0 and 1 is part of message")
        };
        let between = format!("over {}, between ranks 0 and 1 on {machines}", mpi::library(comm));
        network(measured, &between, hop)
    }))
}
