//! `tercio lab validate`: predicted against measured.

use std::fmt::Write;
use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::Result;
use clap::Args;
use serde_json::{Value, json};
use tercio::image::Destination;
use tercio::parallel::Organisation;
use tercio_lab::machines::{Machine, load};
use tercio_lab::predict::validate::{Model, Options, Row, TOLERANCE, compare};
use tercio_lab::predict::validate_ranks;

use super::calibrate::ClockName;
use super::plan::load_scene;
use super::validate_ranks::RanksPlan;
use crate::args::drawing::SortingName;
use crate::args::ranks::{OrganisationName, parse_ranks};
use crate::args::{ModelArgs, RunningArgs, values};
use crate::output::write_text;
use crate::progress::Display;
use crate::threads;

/// Draws models and compares counters and times with what is predicted for this machine.
#[derive(Debug, Args)]
#[command(after_help = "\
Counters have to be equal, times to lie within 25 %. Models that costs were fitted to prove little: choose others.

Examples:
  tercio lab calibrate -o mine.toml
  tercio lab validate builtin:teapot@500k dragon.ply --machine mine.toml --sizes 800x600,1920x1080
  tercio lab validate builtin:teapot@500k --machine mine.toml --ranks 1,2,4 --organisation sort-last

Exit code: 0 all hold, 1 some do not or an error, 2 wrong usage.")]
pub struct Validate {
    /// Models as 'tercio render' takes them.
    #[arg(value_name = "MODEL", required = true)]
    models: Vec<PathBuf>,
    /// This machine's description, as 'tercio lab calibrate' writes it.
    #[arg(short, long, value_name = "MACHINE")]
    machine: String,
    /// Sizes of the pictures.
    #[arg(long, value_name = "WxH,...", default_value = "800x600,1920x1080", value_delimiter = ',')]
    #[arg(value_parser = values::size)]
    sizes: Vec<(u32, u32)>,
    /// Views round each model.
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u32).range(1..=1000))]
    views: u32,
    /// Frames of each view, of which the fastest counts.
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=1000))]
    frames: u32,
    /// Rounds through all pictures.
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=1000))]
    rounds: u32,
    /// Which clock times frames.
    #[arg(long, value_name = "CLOCK", value_enum, default_value_t = ClockName::Wall)]
    clock: ClockName,
    /// Compares ranks of one thread each instead: messages, bytes and counters of every rank, and times.
    #[arg(long, value_name = "N,...", value_delimiter = ',', value_parser = parse_ranks)]
    ranks: Vec<usize>,
    /// How ranks share a frame [default: both].
    #[arg(long, value_name = "HOW", value_enum, requires = "ranks")]
    organisation: Option<OrganisationName>,
    /// What is sorted into tiles.
    #[arg(long, value_name = "WHAT", value_enum, default_value_t = SortingName::Clusters)]
    sorting: SortingName,
    /// Writes JSON with stable keys.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    running: RunningArgs,
}

impl Validate {
    /// Runs the command.
    ///
    /// # Errors
    /// What went wrong.
    pub fn run(&self) -> Result<ExitCode> {
        let machine = load(&self.machine)?;
        let pool = threads::pool(self.running.threads)?;
        let most = pool.current_num_threads();
        let options = Options {
            views: self.views,
            frames: self.frames,
            rounds: self.rounds,
            clock: self.clock.into(),
            sorting: self.sorting.into(),
        };
        let display = Display::new(self.running.progress_mode());
        let counts: Vec<usize> = if most > 1 { vec![1, most] } else { vec![1] };
        let mut models = Vec::new();
        for path in &self.models {
            let model = ModelArgs { model: path.clone() };
            let (scene, bounds) = pool.install(|| load_scene(&model, &self.running))?;
            models.push(Model { name: model.name(), scene, bounds });
        }
        if !self.ranks.is_empty() {
            return self.run_ranks(&machine, &models, most, display);
        }
        let pictures = models.len() * self.sizes.len() * counts.len() * self.rounds as usize;
        display.progress.begin("pictures", pictures as u64);
        let tell = || display.progress.advance(1);
        let rows = compare(&machine, &models, &self.sizes, &counts, options, tell)?;
        drop(display);
        let text =
            if self.json { format!("{:#}\n", rows.iter().map(json).collect::<Value>()) } else { text(&rows) };
        write_text(&Destination::Stdout, &text)?;
        Ok(ExitCode::from(u8::from(!rows.iter().all(Row::holds))))
    }
}

impl Validate {
    fn run_ranks(
        &self,
        machine: &Machine,
        models: &[Model],
        processors: usize,
        display: Display,
    ) -> Result<ExitCode> {
        let organisations: Vec<Organisation> = match self.organisation {
            Some(one) => vec![one.into()],
            None => vec![Organisation::SortFirst, Organisation::SortLast],
        };
        let plan = RanksPlan {
            machine,
            models,
            sizes: &self.sizes,
            ranks: &self.ranks,
            organisations: &organisations,
            options: validate_ranks::Options {
                views: self.views,
                frames: self.frames,
                rounds: self.rounds,
                processors,
                clock: self.clock.into(),
            },
        };
        let rows = super::validate_ranks::rows(&plan, &display)?;
        drop(display);
        let json = || rows.iter().map(super::validate_ranks::json).collect::<Value>();
        let text = if self.json { format!("{:#}\n", json()) } else { super::validate_ranks::text(&rows) };
        write_text(&Destination::Stdout, &text)?;
        Ok(ExitCode::from(u8::from(!rows.iter().all(validate_ranks::Row::holds))))
    }
}

fn json(row: &Row) -> Value {
    json!({ "row": row, "error": row.error(), "tolerance": TOLERANCE, "holds": row.holds() })
}

/// A table in Markdown.
fn text(rows: &[Row]) -> String {
    let mut text = String::from(
        "| model | size | threads | counters equal | predicted ms | measured ms | error | verdict |\n|---|---|---|---|---|---|---|---|\n",
    );
    for row in rows {
        // Writing into a string cannot fail.
        let _ = writeln!(
            text,
            "| {} | {}x{} | {} | {} of {} | {:.3} | {:.3} | {:+.1} % | {} |",
            row.model,
            row.size.0,
            row.size.1,
            row.threads,
            row.compared - row.differing.len(),
            row.compared,
            row.predicted * 1e3,
            row.measured * 1e3,
            row.error() * 100.0,
            if row.holds() { "holds" } else { "misses" },
        );
    }
    for row in rows.iter().filter(|r| !r.differing.is_empty()) {
        for (name, ours, theirs) in &row.differing {
            let _ =
                writeln!(text, "\n{} {:?}: {name} predicted {ours}, counted {theirs}", row.model, row.size);
        }
    }
    text
}
