//! Options that commands share, and the syntax of their values.

pub mod annotation;
pub mod bench;
pub mod camera;
pub mod clip;
pub mod color_list;
pub mod data;
pub mod drawing;
pub mod effects;
pub mod environment;
pub mod light;
pub mod place;
pub mod ranks;
pub mod sampling;
pub mod scene;
pub mod series;
pub mod stereo;
pub mod strokes;
pub mod textures;
pub mod values;
pub mod writing;

use std::path::{Path, PathBuf};

use anyhow::Result;
use clap::{Args, ValueEnum};
use rayon::ThreadPool;
use tercio::image::StandardStream;

use crate::output::UsageError;
use crate::threads::MAX_THREADS;
use crate::{memory, scene_file, threads};

/// When progress is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ProgressMode {
    /// On a terminal, for work of more than half a second.
    Auto,
    /// For work of more than half a second; a line a second where standard error is no terminal.
    Always,
    /// Not at all.
    Never,
}

/// The model that a command works on.
#[derive(Clone, Debug, Args)]
pub struct ModelArgs {
    /// A file (PLY, OBJ, STL, OFF, VTK, PCD, LAS, LAZ or a point cloud as text, each also gzip-compressed; or a model from `tercio prepare`), `-` for
    /// standard input, or builtin:NAME@COUNT, such as builtin:teapot@1M (teapot, gyroid, terrain, sphere, soup).
    pub model: PathBuf,
    /// Which of the times of a collection is meant.
    #[arg(skip)]
    pub moment: Option<Moment>,
    /// The time that the file itself has, if it is wanted.
    #[arg(skip)]
    pub time: Option<f64>,
}

/// One of the times of a collection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// Its number, counted from 0.
    pub number: usize,
    /// The time.
    pub time: f64,
}

impl ModelArgs {
    /// A model.
    pub fn of(model: &Path) -> Self {
        Self { model: model.into(), moment: None, time: None }
    }

    /// Its time: that in its collection, or that of its file.
    pub fn time(&self) -> Option<f64> {
        self.moment.map(|moment| moment.time).or(self.time)
    }

    /// True if the model comes from standard input, which reaches one process only.
    pub fn is_standard_input(&self) -> bool {
        self.model.as_os_str() == "-" || StandardStream::from_path(&self.model) == Some(StandardStream::Input)
    }

    /// Whether the model is there when it is read a second time: not that of a pipe.
    pub fn can_be_read_again(&self) -> bool {
        // What is not there at all is reported when it is read.
        !self.is_standard_input() && std::fs::metadata(&self.model).map_or(true, |found| found.is_file())
    }

    /// Checks that all processes of an MPI job can read the model.
    ///
    /// # Errors
    /// [`UsageError`] if there are several and it comes from standard input.
    pub fn check_reaches_all(&self, processes: Option<usize>) -> Result<(), UsageError> {
        if processes.is_some_and(|p| p > 1) && self.is_standard_input() {
            return Err(UsageError("standard input reaches one rank only: name a file".into()));
        }
        Ok(())
    }

    /// Checks that it is no scene file, for commands that take models only.
    ///
    /// # Errors
    /// [`UsageError`] that says what a scene file is, and which command takes it.
    pub fn check_is_no_scene(&self) -> Result<(), UsageError> {
        if !scene_file::is_scene(&self.model) {
            return Ok(());
        }
        let name = self.name();
        Err(UsageError(format!(
            "{name}: a scene file says which models are drawn into one picture, and how; tercio render draws it: name a model here (docs/scenes.md)"
        )))
    }

    /// The model's name in messages, the same as in those of the reader.
    pub fn name(&self) -> String {
        if self.model.as_os_str() == "-" { "standard input".into() } else { self.model.display().to_string() }
    }
}

/// Resources that a command may use, and how much it prints.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Running")]
pub struct RunningArgs {
    /// Number of threads, 1 to 256 [default: as many as the process may use: affinity, cgroup quota,
    /// SLURM_CPUS_PER_TASK].
    #[arg(long, value_name = "N", value_parser = parse_threads)]
    pub threads: Option<usize>,
    /// Most memory that models and pictures may take, such as 500M, 2G or 2Gi; what needs more is refused. The
    /// program itself comes on top: 4 MB at most, and the pages of its file, up to 16 MB [default: what the
    /// machine, the control groups and 'ulimit' leave].
    #[arg(long, value_name = "SIZE", value_parser = values::bytes)]
    memory_limit: Option<u64>,
    /// When to show progress on standard error.
    #[arg(long, value_name = "WHEN", value_enum, default_value_t = ProgressMode::Auto)]
    pub progress: ProgressMode,
    /// Print errors only.
    #[arg(short, long)]
    pub quiet: bool,
    /// Print what is done and how long it takes.
    #[arg(short, long, conflicts_with = "quiet")]
    pub verbose: bool,
}

impl RunningArgs {
    /// Most memory that models and pictures may take. The first call sets the limit for all allocations from then on.
    pub fn memory_limit(&self) -> Option<u64> {
        memory::limit(self.memory_limit, threads::wanted(self.threads))
    }

    /// The pool in which everything runs. Sets the memory limit.
    ///
    /// # Errors
    /// If the system refuses that many threads.
    pub fn pool(&self) -> Result<ThreadPool> {
        memory::prepare(self.memory_limit);
        let pool = threads::pool(self.threads)?;
        self.memory_limit();
        Ok(pool)
    }

    /// No progress with `--quiet`.
    pub fn progress_mode(&self) -> ProgressMode {
        if self.quiet { ProgressMode::Never } else { self.progress }
    }
}

fn parse_threads(text: &str) -> std::result::Result<usize, String> {
    let n = text.parse().ok().filter(|n| (1..=MAX_THREADS).contains(n));
    n.ok_or_else(|| format!("expected 1 to {MAX_THREADS}"))
}
