//! `tercio lab validate`: compares predictions with measurements.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::Result;
use clap::{Args, ValueEnum};
use rayon::ThreadPool;
use serde_json::{Value, json};
use tercio::image::Destination;
use tercio::parallel::{Communicator as _, Organisation};
use tercio_lab::predict::quoted::{self, ThreadsRow};
use tercio_lab::predict::validate::{Model, Options, Row, compare};
use tercio_lab::predict::validate_advice::{self as advice, MODELS};
use tercio_lab::predict::validate_ranks as ranks;

use super::calibrate::ClockName;
use super::measured::Measured;
use super::plan::{load_scene, machine};
use super::validate_advice;
use super::validate_ranks::{self, Who};
use crate::args::drawing::SortingName;
use crate::args::ranks::parse_ranks;
use crate::args::{ModelArgs, ProgressMode, RunningArgs, values};
use crate::named_files::NamedFiles;
use crate::output::UsageError;
use crate::progress::Display;
use crate::{mpi, threads};

/// Draws models and compares counters and times with the prediction for this machine.
#[derive(Debug, Args)]
#[command(after_help = "\
Counters have to be equal, times to lie within 15 %; within 20 % if no two triangles of the model share a vertex, and
within 25 % for processes. Each row names the stages that make up the difference between predicted and measured time,
the largest first, with milliseconds (predicted less measured). Models that costs were fitted to prove little: choose
others.
Processes that mpirun started are ranks: all of them draw, rank 0 predicts and writes. The description needs the
section mpi then, which calibrate writes if mpirun starts it.

Examples:
  tercio lab calibrate -o mine.toml
  tercio lab validate builtin:teapot@500k dragon.ply --machine mine.toml --sizes 800x600,1920x1080
  tercio lab validate builtin:teapot@500k --machine mine.toml --ranks 1,2,4 --organisation sort-last
  mpirun -n 2 --bind-to none tercio lab validate builtin:teapot@500k --machine mine.toml   (built with --features mpi)
  tercio lab validate --advice --machine mine.toml --ranks 3,4 --sizes 800x600

Exit code: 0 all hold, 1 some do not or an error, 2 wrong usage.")]
pub struct Validate {
    /// Models as for 'tercio render' [default with --advice: ten built-in ones].
    #[arg(value_name = "MODEL", required_unless_present = "advice")]
    models: Vec<PathBuf>,
    /// This machine's description, from 'tercio lab calibrate'.
    #[arg(short, long, value_name = "MACHINE")]
    machine: String,
    /// Sizes of the pictures.
    #[arg(long, value_name = "WxH,...", default_value = "800x600,1920x1080", value_delimiter = ',')]
    #[arg(value_parser = values::size)]
    sizes: Vec<(u32, u32)>,
    /// Views round each model.
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u32).range(1..=1000))]
    views: u32,
    /// Frames of each view; the fastest counts.
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=1000))]
    frames: u32,
    /// Rounds through all pictures.
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=1000))]
    rounds: u32,
    /// Which clock times frames.
    #[arg(long, value_name = "CLOCK", value_enum, default_value_t = ClockName::Wall)]
    clock: ClockName,
    /// Tests the advice instead: draws one view in all ways that 'tercio lab advise' compares for this machine, and compares the
    /// advised one with the fastest, which it may exceed by 10 %. With --ranks, as many ranks are drawn, too, though there
    /// are fewer processors.
    #[arg(long, conflicts_with_all = ["organisation", "clock", "sorting", "views"])]
    advice: bool,
    /// Compares ranks of one thread each instead: messages, bytes and counters of every rank, and times. Processes that
    /// mpirun started are ranks without this option.
    #[arg(long, value_name = "N,...", value_delimiter = ',', value_parser = parse_ranks)]
    ranks: Vec<usize>,
    /// How ranks share a frame [default: both].
    #[arg(long, value_name = "HOW", value_enum)]
    organisation: Option<PredictedName>,
    /// What is sorted into tiles.
    #[arg(long, value_name = "WHAT", value_enum, default_value_t = SortingName::Clusters)]
    sorting: SortingName,
    /// Writes JSON with stable keys.
    #[arg(long)]
    json: bool,
    /// Also puts the rows into a table (TOML) such as 'tercio lab reproduce' quotes: a new one, or in place of the rows
    /// of the same pictures.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    running: RunningArgs,
}

/// The organisations of ranks that are predicted from the renderer's own counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum PredictedName {
    /// Ranks share the picture.
    SortFirst,
    /// Ranks share the clusters: their pictures are composited.
    SortLast,
}

impl Validate {
    /// Runs the command.
    ///
    /// # Errors
    /// [`UsageError`] for options that contradict each other, else what went wrong.
    pub fn run(&self) -> Result<ExitCode> {
        if self.advice {
            if mpi::processes().is_some_and(|count| count > 1) {
                let text = "--advice draws with ranks of one process: start it without mpirun";
                return Err(UsageError(text.into()).into());
            }
            return self.advice();
        }
        let who = Who::of(&self.ranks, self.organisation.is_some(), mpi::processes()).map_err(UsageError)?;
        let files = self.files();
        files.check()?;
        let pool = self.running.pool()?;
        let holds = match who {
            Who::Threads => self.threads(&pool)?,
            Who::Ranks => self.ranks(&pool)?,
            Who::Processes(count) => {
                let check = |model: &PathBuf| ModelArgs::of(model).check_reaches_all(Some(count));
                self.models.iter().try_for_each(check)?;
                // A rank draws with one thread, the one that MPI was initialised on.
                let own = threads::pool(Some(1))?;
                own.install(|| mpi::run(|comm| self.processes(&pool, comm)))?
            }
        };
        Ok(ExitCode::from(u8::from(!holds)))
    }

    fn files(&self) -> NamedFiles {
        // An existing table is extended, so that it is an input as well, but it may not be another file.
        let table = self.output.iter().map(Destination::from_path);
        let files =
            table.fold(NamedFiles::default().prints(), |files, table| files.writes("--output", &table));
        self.models.iter().fold(files.reads_machine(&self.machine), |files, model| files.reads_model(model))
    }

    /// Compares the advised way to draw with all others.
    fn advice(&self) -> Result<ExitCode> {
        let pool = self.running.pool()?;
        let named: Vec<PathBuf>;
        let models = if self.models.is_empty() {
            named = MODELS.iter().map(PathBuf::from).collect();
            &named
        } else {
            &self.models
        };
        self.files().check()?;
        let machine = machine(&self.machine, self.running.quiet)?;
        let views = format!(" --views {}", self.views);
        let command = self.command().replacen("validate ", "validate --advice ", 1);
        let command = command.replace(&views, "").replace("  ", " ");
        let output = Measured::new(self.output.clone(), command, machine.summary.clone())?;
        let models = self.load(models, &pool, self.running.progress_mode())?;
        let (frames, rounds, more_ranks) = (self.frames, self.rounds, self.ranks.as_slice());
        let processors = pool.current_num_threads();
        let options = advice::Options { processors, more_ranks, frames, rounds };
        let display = Display::new(self.running.progress_mode());
        let rows =
            pool.install(|| validate_advice::rows(&machine, &models, &self.sizes, options, &display))?;
        drop(display);
        let holds = validate_advice::write(&rows, self.json, &output)?;
        Ok(ExitCode::from(u8::from(!holds)))
    }

    /// Compares threads; returns whether all rows hold.
    fn threads(&self, pool: &ThreadPool) -> Result<bool> {
        let machine = machine(&self.machine, self.running.quiet)?;
        let output = self.measured(None, &machine.summary)?;
        let models = self.load_models(pool, self.running.progress_mode())?;
        let display = Display::new(self.running.progress_mode());
        let options = Options {
            views: self.views,
            frames: self.frames,
            rounds: self.rounds,
            clock: self.clock.into(),
            sorting: self.sorting.into(),
        };
        let most = pool.current_num_threads();
        let counts: Vec<usize> = if most > 1 { vec![1, most] } else { vec![1] };
        let pictures = models.len() * self.sizes.len() * counts.len() * self.rounds as usize;
        display.progress.begin("pictures", pictures as u64);
        let progress = || display.progress.advance(1);
        let rows = compare(&machine, &models, &self.sizes, &counts, options, progress)?;
        drop(display);
        let quoted: Vec<ThreadsRow> = rows.iter().map(ThreadsRow::from).collect();
        output.write(self.json, || rows.iter().map(json).collect(), || text(&rows, &quoted), &quoted)?;
        Ok(rows.iter().all(Row::holds))
    }

    /// Compares ranks of this process.
    fn ranks(&self, pool: &ThreadPool) -> Result<bool> {
        let machine = machine(&self.machine, self.running.quiet)?;
        let output = self.measured(None, &machine.summary)?;
        let models = self.load_models(pool, self.running.progress_mode())?;
        let how = self.how(&self.ranks);
        let display = Display::new(self.running.progress_mode());
        let rows = validate_ranks::of_this_process(
            &machine,
            self.table(&models, &how, pool.current_num_threads()),
            &display,
        )?;
        drop(display);
        validate_ranks::write(&rows, self.json, &output)
    }

    /// Compares the processes of a job, each of which draws with the thread that calls this. Rank 0 reports; the others only
    /// draw.
    fn processes(&self, pool: &ThreadPool, comm: &mut mpi::Comm) -> Result<bool> {
        let reports = comm.rank() == 0;
        let machine = machine(&self.machine, self.running.quiet || !reports)?.over_mpi()?;
        let mode = if reports { self.running.progress_mode() } else { ProgressMode::Never };
        let processors = validate_ranks::processors(comm, pool.current_num_threads())?;
        let how = self.how(&[comm.size()]);
        if !reports {
            let models = self.load_models(pool, mode)?;
            ranks::follow(comm, self.table(&models, &how, processors))?;
            return Ok(true);
        }
        let output = self.measured(Some(comm.size()), &machine.summary)?;
        let models = self.load_models(pool, mode)?;
        let display = Display::new(mode);
        let table = self.table(&models, &how, processors);
        let rows = validate_ranks::of_processes(&machine, table, comm, &display)?;
        drop(display);
        validate_ranks::write(&rows, self.json, &output)
    }

    fn load_models(&self, pool: &ThreadPool, progress: ProgressMode) -> Result<Vec<Model>> {
        self.load(&self.models, pool, progress)
    }

    fn load(&self, models: &[PathBuf], pool: &ThreadPool, progress: ProgressMode) -> Result<Vec<Model>> {
        let files = self.files();
        let load = |path: &PathBuf| {
            let model = ModelArgs::of(path);
            let (scene, bounds) = pool.install(|| load_scene(&model, &self.running, progress, &files))?;
            Ok(Model { name: file_name(path), scene, bounds })
        };
        models.iter().map(load).collect()
    }

    fn how(&self, ranks: &[usize]) -> Vec<(usize, Organisation)> {
        let organisations: Vec<Organisation> = match self.organisation {
            Some(PredictedName::SortFirst) => vec![Organisation::SortFirst],
            Some(PredictedName::SortLast) => vec![Organisation::SortLast],
            None => vec![Organisation::SortFirst, Organisation::SortLast],
        };
        ranks.iter().flat_map(|&ranks| organisations.iter().map(move |&o| (ranks, o))).collect()
    }

    fn table<'a>(
        &'a self,
        models: &'a [Model],
        how: &'a [(usize, Organisation)],
        processors: usize,
    ) -> ranks::Table<'a> {
        let (views, frames, rounds) = (self.views, self.frames, self.rounds);
        let options = ranks::Options { views, frames, rounds, processors, clock: self.clock.into() };
        ranks::Table { models, sizes: &self.sizes, how, options }
    }

    /// The output of the rows; checked before the work begins.
    fn measured(&self, processes: Option<usize>, machine: &str) -> Result<Measured> {
        let started = processes.map_or(String::new(), |n| format!("mpirun -n {n} --bind-to none "));
        Measured::new(self.output.clone(), format!("{started}{}", self.command()), machine.into())
    }

    /// The command, with file names only, and without options that do not change the rows.
    fn command(&self) -> String {
        let models: Vec<String> = self.models.iter().map(|m| file_name(m)).collect();
        let sizes: Vec<String> = self.sizes.iter().map(|(w, h)| format!("{w}x{h}")).collect();
        let mut text = format!(
            "tercio lab validate {} --machine {} --sizes {} --views {} --frames {} --rounds {}",
            models.join(" "),
            file_name(Path::new(&self.machine)),
            sizes.join(","),
            self.views,
            self.frames,
            self.rounds
        );
        // Writing into a string cannot fail.
        if !self.ranks.is_empty() {
            let ranks: Vec<String> = self.ranks.iter().map(ToString::to_string).collect();
            let _ = write!(text, " --ranks {}", ranks.join(","));
        }
        if let Some(name) = self.organisation.as_ref().and_then(values::name) {
            let _ = write!(text, " --organisation {name}");
        }
        if matches!(self.sorting, SortingName::Triangles) {
            text.push_str(" --sorting triangles");
        }
        if matches!(self.clock, ClockName::Processor) {
            text.push_str(" --clock processor");
        }
        text
    }
}

/// A model's or description's file name; builtin:NAME@COUNT has no folder.
fn file_name(path: &Path) -> String {
    path.file_name().map_or_else(|| path.display().to_string(), |name| name.to_string_lossy().into_owned())
}

fn json(row: &Row) -> Value {
    json!({ "row": row, "error": row.error(), "tolerance": row.tolerance(), "holds": row.holds() })
}

/// A table in Markdown, and the counters that differ.
fn text(rows: &[Row], quoted: &[ThreadsRow]) -> String {
    let mut text = quoted::markdown(quoted);
    for row in rows {
        for (name, ours, theirs) in &row.differing {
            // Writing into a string cannot fail.
            let _ =
                writeln!(text, "\n{} {:?}: {name} predicted {ours}, counted {theirs}", row.model, row.size);
        }
    }
    text
}
