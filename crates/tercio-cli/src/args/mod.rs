//! Options that commands share, and how their values are written.

pub mod bench;
pub mod camera;
pub mod drawing;
pub mod light;
pub mod ranks;
pub mod values;
pub mod writing;

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use crate::threads::MAX_THREADS;

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
#[derive(Debug, Args)]
pub struct ModelArgs {
    /// A file (PLY, OBJ, STL or OFF, each also gzip-compressed), `-` for standard input, or
    /// builtin:NAME@COUNT, such as builtin:teapot@1M (teapot, gyroid, terrain, sphere, soup).
    pub model: PathBuf,
}

impl ModelArgs {
    /// True if the model comes from standard input, which reaches one process only.
    pub fn is_standard_input(&self) -> bool {
        let names: &[&str] =
            if cfg!(unix) { &["-", "/dev/stdin", "/dev/fd/0", "/proc/self/fd/0"] } else { &["-"] };
        names.iter().any(|name| self.model.as_os_str() == *name)
    }

    /// The model's name in messages, the same as in those of the reader.
    pub fn name(&self) -> String {
        if self.model.as_os_str() == "-" { "standard input".into() } else { self.model.display().to_string() }
    }
}

/// What a command may use of the machine, and how much it says.
#[derive(Debug, Args)]
#[command(next_help_heading = "Running")]
pub struct RunningArgs {
    /// Number of threads, 1 to 256 [default: as many as the process may use: affinity, cgroup quota,
    /// SLURM_CPUS_PER_TASK].
    #[arg(long, value_name = "N", value_parser = parse_threads)]
    pub threads: Option<usize>,
    /// Most memory that models and pictures may take, such as 500M, 2G or 2Gi; larger ones are refused
    /// before the memory is taken [default: what the machine and the control group have free].
    #[arg(long, value_name = "SIZE", value_parser = values::bytes)]
    memory_limit: Option<u64>,
    /// When to show progress on standard error.
    #[arg(long, value_name = "WHEN", value_enum, default_value_t = ProgressMode::Auto)]
    pub progress: ProgressMode,
    /// Say nothing but errors.
    #[arg(short, long)]
    pub quiet: bool,
    /// Say what is done and how long it takes.
    #[arg(short, long, conflicts_with = "quiet")]
    pub verbose: bool,
}

impl RunningArgs {
    /// Most memory that models and pictures may take.
    pub fn memory_limit(&self) -> Option<u64> {
        self.memory_limit.or_else(crate::memory::available_bytes)
    }

    /// Warnings and progress are for users who did not ask for quiet.
    pub fn progress_mode(&self) -> ProgressMode {
        if self.quiet { ProgressMode::Never } else { self.progress }
    }
}

fn parse_threads(text: &str) -> Result<usize, String> {
    let n = text.parse().ok().filter(|n| (1..=MAX_THREADS).contains(n));
    n.ok_or_else(|| format!("expected 1 to {MAX_THREADS}"))
}
