//! `tercio lab advise`: the best organisation for a machine and a model.

use std::fmt::Write;
use std::process::ExitCode;

use anyhow::Result;
use clap::Args;
use serde_json::{Value, json};
use tercio::image::Destination;
use tercio_lab::predict::advise::{advise, describe, plans};

use super::plan::{MachineArgs, PictureArgs};
use super::predict::ranks;
use crate::args::RunningArgs;
use crate::output::write_text;
use crate::threads;

/// Searches organisation, group size, region size and assignment for a machine and a model, and says why.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  tercio lab advise dragon.ply --machine cluster-64 --ranks 1024
  tercio lab advise builtin:gyroid@2M --machine princeton-engine --size 768x512 --top 10 --json

Exit code: 0 success, 1 error, 2 wrong usage.")]
pub struct Advise {
    #[command(flatten)]
    picture: PictureArgs,
    #[command(flatten)]
    machine: MachineArgs,
    /// Ranks [default: all processors of the machine].
    #[arg(short = 'n', long, value_name = "N", value_parser = ranks)]
    ranks: Option<usize>,
    /// How many of the best are listed.
    #[arg(long, value_name = "N", default_value_t = 5)]
    top: usize,
    /// Writes JSON with stable keys.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    running: RunningArgs,
}

impl Advise {
    /// Runs the command.
    ///
    /// # Errors
    /// What went wrong.
    pub fn run(&self) -> Result<ExitCode> {
        let machine = self.machine.machine()?;
        let ranks = self.ranks.unwrap_or(machine.processors.count.whole() as usize);
        let pool = threads::pool(self.running.threads)?;
        let advice = pool.install(|| -> Result<_> {
            let c = self.picture.count(&self.running, &machine, None)?;
            let plans = plans(ranks, self.machine.topology());
            Ok(advise(&machine, &c.counted.frame, &c.boxes, c.size, &plans)?)
        })?;
        let best = advice.plans.iter().take(self.top.max(1));
        let text = if self.json {
            let listed: Value = best
                .map(|p| json!({ "plan": describe(&p.plan), "total_seconds": p.total(), "prediction": p }))
                .collect();
            let value = json!({
                "machine": machine.name, "ranks": ranks, "plans_compared": advice.plans.len(),
                "best": listed, "explanation": advice.explanation(),
            });
            format!("{value:#}\n")
        } else {
            let mut text =
                format!("{}, {ranks} ranks, {} plans compared\n", machine.name, advice.plans.len());
            for p in best {
                // Writing into a string cannot fail.
                let _ = writeln!(text, "{:12.4} ms  {}", p.total() * 1e3, describe(&p.plan));
            }
            advice.explanation().iter().for_each(|line| text += &format!("{line}.\n"));
            text
        };
        write_text(&Destination::Stdout, &text)?;
        Ok(ExitCode::SUCCESS)
    }
}
