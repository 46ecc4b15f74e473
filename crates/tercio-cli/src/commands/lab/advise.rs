//! `tercio lab advise`: the best organisation for a machine and a model.

use std::fmt::Write;
use std::process::ExitCode;

use anyhow::Result;
use clap::Args;
use serde_json::{Value, json};
use tercio::image::Destination;
use tercio_lab::predict::advise::simulated::{Found, describe_with_processors, search};
use tercio_lab::predict::advise::{Advice, Candidate, advise, why_not};
use tercio_lab::predict::ranks::Simulated;
use tercio_lab::predict::ranks::simulated::SimulatedFrame;
use tercio_lab::words::counted;

use super::plan::{MachineArgs, PictureArgs};
use super::predict::ranks;
use crate::args::RunningArgs;
use crate::output::write_text;

/// Searches all ways to draw a model on a machine for the fastest, and says why it is.
///
/// Compared are threads of one process, and all splits of processors into ranks and threads, with every organisation, division, group
/// and composition of 'tercio render': of all numbers of processors up to 16, then of powers of two, the middle between two of them,
/// whole nodes, and N. The output says what is not compared, and why. Each time is shown with the model that it is from. If the machine
/// has a calibration, or says how sure its numbers are, it has an interval, too; '=' marks candidates that cannot be told apart from the
/// best one. The simulator of the sorting classes covers its own plans; the output says which. Its figures are comparable with each
/// other only.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  tercio lab advise dragon.ply --machine cluster-64 --processors 1024
  tercio lab advise builtin:gyroid@2M --machine princeton-engine --size 768x512 --top 10 --json

Exit code: 0 success, 1 error, 2 wrong usage.")]
pub struct Advise {
    #[command(flatten)]
    picture: PictureArgs,
    #[command(flatten)]
    machine: MachineArgs,
    /// Processors at most: ranks times threads [default: all of the machine].
    #[arg(short = 'n', long, value_name = "N", value_parser = ranks)]
    processors: Option<usize>,
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
        let machine = self.machine.machine(self.running.quiet)?;
        let processors = self.processors.unwrap_or(machine.processors.count.whole() as usize);
        machine.may_have(processors)?;
        let pool = self.running.pool()?;
        let topology = self.machine.topology();
        let (advice, simulated) = pool.install(|| -> Result<_> {
            let c = self.picture.count(&self.running, &machine, 1)?;
            let advice = advise(&machine, &c.picture(), processors, topology)?;
            let boxes = c.boxes()?;
            Ok((advice, search(&machine, &c.counted.frame, &boxes, c.size, topology, processors)?))
        })?;
        let why_not = why_not(&machine);
        let answer =
            Answer { machine: &machine.name, processors, advice, simulated, why_not, top: self.top.max(1) };
        let text = if self.json { answer.json_text() } else { answer.text() };
        write_text(&Destination::Stdout, &text)?;
        Ok(ExitCode::SUCCESS)
    }
}

/// What is printed.
struct Answer<'a> {
    machine: &'a str,
    processors: usize,
    advice: Advice,
    simulated: Found,
    why_not: Option<Simulated>,
    /// Plans that are listed.
    top: usize,
}

impl Answer<'_> {
    fn json_text(&self) -> String {
        let Self { machine, processors, ref advice, ref simulated, why_not, top } = *self;
        let of_candidate = |c: &Candidate| {
            json!({
                "plan": c.describe(), "ranks": c.split.ranks, "threads": c.split.threads,
                "total_seconds": c.frame.total(), "model": c.frame.model(), "interval_seconds": advice.interval(c),
                "assumed_seconds": c.assumed,
                "like_the_best": advice.is_like_the_best(c), "prediction": c.frame,
            })
        };
        let of_simulator = |p: &SimulatedFrame| {
            let plan = describe_with_processors(&p.plan);
            json!({ "plan": plan, "processors": p.plan.ranks, "total_seconds": p.total(), "prediction": p })
        };
        let value = json!({
            "machine": machine, "processors": processors,
            "renderer": {
                "plans_compared": advice.candidates.len(), "splits_left_out": advice.left_out,
                "best": advice.candidates.iter().take(top).map(of_candidate).collect::<Value>(),
                "why_not": why_not, "uncertainty": advice.uncertainty,
            },
            "simulator": {
                "plans_compared": simulated.frames.len(), "numbers_of_processors": simulated.numbers,
                "given_up": simulated.given_up,
                "best": simulated.frames.iter().take(top).map(of_simulator).collect::<Value>(),
            },
            "explanation": lines(advice, simulated),
        });
        format!("{value:#}\n")
    }

    fn text(&self) -> String {
        let Self { machine, processors, ref advice, ref simulated, why_not, top } = *self;
        let mut text =
            format!("{machine}, up to {}\n", counted(processors as u64, "processor", "processors"));
        // Writing into a string cannot fail.
        let _ = match why_not {
            Some(reason) => writeln!(text, "no prediction by the models of the renderer: {reason}"),
            None => writeln!(text, "the renderer, {} candidates compared", advice.candidates.len()),
        };
        for c in advice.candidates.iter().take(top) {
            let like = if advice.is_like_the_best(c) == Some(true) { "=" } else { " " };
            let interval = advice.interval(c);
            let interval = interval.map(|[low, high]| format!(" ({:.4} to {:.4})", low * 1e3, high * 1e3));
            let (time, interval) = (c.frame.total() * 1e3, interval.unwrap_or_default());
            let _ = writeln!(text, "{like}{time:11.4} ms{interval}  {} [{}]", c.describe(), c.frame.model());
        }
        let _ = writeln!(text, "simulator of the sorting classes, {} plans compared", simulated.frames.len());
        for p in simulated.frames.iter().take(top) {
            let _ = writeln!(text, "{:12.4} ms  {}", p.total() * 1e3, describe_with_processors(&p.plan));
        }
        lines(advice, simulated).iter().for_each(|line| text += &format!("{line}.\n"));
        text
    }
}

/// Both advices in words.
fn lines(advice: &Advice, simulated: &Found) -> Vec<String> {
    let mut lines = advice.explanation();
    if !lines.is_empty() {
        lines.push("the rest is from the simulator of the sorting classes, another model".into());
    }
    lines.extend(simulated.explanation());
    lines
}
