//! `tercio lab advise`: the best organisation for a machine and a model.

use std::fmt::Write;
use std::process::ExitCode;

use anyhow::Result;
use clap::Args;
use serde_json::{Value, json};
use tercio::image::Destination;
use tercio_lab::predict::advise::{Advice, advise, describe, plans, renderer_plans, why_not};
use tercio_lab::predict::ranks::Simulated;

use super::plan::{MachineArgs, PictureArgs};
use super::predict::ranks;
use crate::args::RunningArgs;
use crate::output::write_text;

/// Searches threads, ranks, organisation, group size, region size and assignment for a machine and a model, and says why.
///
/// Of the renderer, threads of one process are compared with ranks of one thread and of several, in sort-first and
/// sort-last, by the models that 'tercio lab validate' compares with it. The simulator of the sorting classes covers all
/// classes; its figures are comparable with each other only.
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
    /// Processors: ranks times threads [default: all of the machine].
    #[arg(short = 'n', long, value_name = "N", value_parser = ranks)]
    ranks: Option<usize>,
    /// Number of the best plans to list.
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
        self.picture.ready(&self.machine)?;
        let machine = self.machine.machine()?;
        let ranks = self.ranks.unwrap_or(machine.processors.count.whole() as usize);
        machine.may_have(ranks)?;
        let pool = self.running.pool()?;
        let advice = pool.install(|| -> Result<_> {
            let c = self.picture.count(&self.running, &machine, 1)?;
            let topology = self.machine.topology();
            // Only the simulator supports a network other than the machine's.
            let rendered = if topology.is_none() { renderer_plans(&machine, ranks) } else { Vec::new() };
            let simulated = plans(&machine, ranks, topology);
            let counters = &c.counted.frame;
            Ok(advise(&machine, &c.picture(), counters, &c.boxes()?, (&rendered, &simulated))?)
        })?;
        let why_not = why_not(&machine, self.machine.topology());
        let text = match self.json {
            true => self.json_text(&machine.name, ranks, &advice, why_not),
            false => self.text(&machine.name, ranks, &advice, why_not),
        };
        write_text(&Destination::Stdout, &text)?;
        Ok(ExitCode::SUCCESS)
    }

    fn json_text(&self, machine: &str, ranks: usize, advice: &Advice, why_not: Option<Simulated>) -> String {
        let top = self.top.max(1);
        let rendered = advice.renderer.iter().take(top).map(
            |r| json!({ "plan": r.describe(), "total_seconds": r.frame.total(), "prediction": r.frame }),
        );
        let simulated = advice
            .simulated
            .iter()
            .take(top)
            .map(|p| json!({ "plan": describe(&p.plan), "total_seconds": p.total(), "prediction": p }));
        let value = json!({
            "machine": machine, "processors": ranks,
            "renderer": {
                "plans_compared": advice.renderer.len(), "best": rendered.collect::<Value>(), "why_not": why_not,
            },
            "simulator": {
                "plans_compared": advice.simulated.len(), "best": simulated.collect::<Value>(),
            },
            "explanation": advice.explanation(),
        });
        format!("{value:#}\n")
    }

    fn text(&self, machine: &str, ranks: usize, advice: &Advice, why_not: Option<Simulated>) -> String {
        let top = self.top.max(1);
        let mut text = format!("{machine}, {ranks} processors\n");
        // Writing into a string cannot fail.
        let _ = match why_not {
            Some(reason) => writeln!(text, "no prediction by the model of the renderer's ranks: {reason}"),
            None => writeln!(text, "the renderer, {} plans compared", advice.renderer.len()),
        };
        for r in advice.renderer.iter().take(top) {
            let _ = writeln!(text, "{:12.4} ms  {}", r.frame.total() * 1e3, r.describe());
        }
        let _ = writeln!(text, "simulator of the sorting classes, {} plans compared", advice.simulated.len());
        for p in advice.simulated.iter().take(top) {
            let _ = writeln!(text, "{:12.4} ms  {}", p.total() * 1e3, describe(&p.plan));
        }
        advice.explanation().iter().for_each(|line| text += &format!("{line}.\n"));
        text
    }
}
