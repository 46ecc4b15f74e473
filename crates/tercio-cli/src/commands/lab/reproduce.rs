//! `tercio lab reproduce`: reproduces published figures and tables.

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{Result, bail};
use clap::Args;
use tercio::image::Destination;
use tercio_lab::experiments::{self, Experiment, Outcome, report};
use tercio_lab::published;

use crate::args::RunningArgs;
use crate::output::{check, write_text};
use crate::progress::Display;

/// Reproduces published figures and tables: data, plot and verdict of each.
#[derive(Debug, Args)]
#[command(after_help = "\
Each experiment has a folder with its data (CSV), its plots (SVG, PDF) and verdict.json. Without ID all are run,
and a report joins them: index.html, with a page for each document, and report.md.

Examples:
  tercio lab reproduce -o report
  tercio lab reproduce eldridge-fig-5-5 mcmanus -o figures
  tercio lab reproduce --list

Exit code: 0 success, 1 an experiment failed or an error, 2 wrong usage.")]
pub struct Reproduce {
    /// Only experiments whose ID begins with this.
    #[arg(value_name = "ID")]
    ids: Vec<String>,
    /// The folder to write into.
    #[arg(short, long, value_name = "DIR", required_unless_present = "list")]
    output: Option<PathBuf>,
    /// Lists the experiments.
    #[arg(long)]
    list: bool,
    #[command(flatten)]
    running: RunningArgs,
}

impl Reproduce {
    /// Runs the command.
    ///
    /// # Errors
    /// An ID that no experiment has, or a file that cannot be written.
    pub fn run(&self) -> Result<ExitCode> {
        let chosen = self.chosen()?;
        let Some(directory) = self.output.as_ref().filter(|_| !self.list) else {
            write_text(&Destination::Stdout, &list(&chosen))?;
            return Ok(ExitCode::SUCCESS);
        };
        if !self.running.quiet {
            check(&Destination::Stdout)?;
        }
        let pool = self.running.pool()?;
        let display = Display::new(self.running.progress_mode());
        display.progress.begin("experiments", chosen.len() as u64);
        let outcomes =
            pool.install(|| experiments::reproduce(&chosen, directory, |_| display.progress.advance(1)))?;
        drop(display);
        if self.ids.is_empty() {
            report::write(&outcomes, &published::check_all()?, directory)?;
        }
        if !self.running.quiet {
            let lines: String = outcomes.iter().map(line).collect();
            write_text(&Destination::Stdout, &format!("{lines}\n{}\n", experiments::summary(&outcomes)))?;
        }
        Ok(ExitCode::from(u8::from(outcomes.iter().any(|o| o.findings.is_err()))))
    }

    fn chosen(&self) -> Result<Vec<Experiment>> {
        let begins = |e: &Experiment, id: &String| e.id.starts_with(id.as_str());
        if let Some(id) = self.ids.iter().find(|id| !experiments::all().any(|e| begins(&e, id))) {
            bail!("no experiment's name begins with '{id}'; 'tercio lab reproduce --list' lists them");
        }
        let chosen = |e: &Experiment| self.ids.is_empty() || self.ids.iter().any(|id| begins(e, id));
        Ok(experiments::all().filter(chosen).collect())
    }
}

fn list(chosen: &[Experiment]) -> String {
    let line = |e: &Experiment| format!("{:28}  {} {}: {}\n", e.id, e.document.number(), e.place, e.title);
    chosen.iter().map(line).collect()
}

fn line(outcome: &Outcome) -> String {
    let verdict = match &outcome.findings {
        Ok(findings) => findings.verdict.name().to_owned(),
        Err(error) => format!("failed: {error}"),
    };
    format!("{:28}  {verdict}\n", outcome.experiment.id)
}
