//! `tercio lab predict`: a frame of the real renderer on a described machine.

use std::fmt::Write;
use std::process::ExitCode;

use anyhow::{Context, Result, anyhow};
use clap::{Args, ValueEnum};
use serde_json::json;
use tercio::image::Destination;
use tercio_lab::machines::Machine;
use tercio_lab::predict::advise::simulated::describe;
use tercio_lab::predict::frame::{FrameTime, need_costs};
use tercio_lab::predict::ranks::extrapolated::{ExtrapolatedFrame, Term};
use tercio_lab::predict::ranks::renderer::{Carrier, RankSeconds, RanksFrame};
use tercio_lab::predict::ranks::simulated::SimulatedFrame;
use tercio_lab::predict::ranks::{Plan, Simulated, extrapolate, predict, simulate};
use tercio_lab::simulators::sorting::{Assignment, Organisation, usual_group};
use tercio_lab::words::counted as counted_words;

use super::plan::{Counted, MachineArgs, PictureArgs};
use crate::args::RunningArgs;
use crate::output::{UsageError, write_text};

/// Predicts a frame of the renderer: time of each phase, bytes, imbalance, memory.
///
/// Threads, and ranks in the renderer's own organisations, come from the models that 'tercio lab validate' compares
/// with it. Of more than 1,024 ranks each part of the frame is continued from 256 and 1,024 of them, and the output says
/// which parts grow. Other organisations come from the simulator of the sorting classes; the output says where it is from.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  tercio lab predict dragon.ply --machine two-core-2026 --ranks 2
  tercio lab predict builtin:gyroid@5M --machine cluster-64 --organisation sort-twice --group 8 --ranks 512
  tercio lab predict dragon.ply --machine cluster-64 --organisation sort-last --ranks 64 --network mesh --json
  tercio lab predict dragon.ply --machine two-core-2026 --organisation sort-last --ranks 64 --share-processors

Exit code: 0 success, 1 error, 2 wrong usage.")]
pub struct Predict {
    #[command(flatten)]
    picture: PictureArgs,
    #[command(flatten)]
    machine: MachineArgs,
    /// How ranks share a frame.
    #[arg(short = 'O', long, value_name = "CLASS", value_enum, default_value_t = OrganisationName::Threads)]
    organisation: OrganisationName,
    /// Ranks, or threads, each with a processor of its own [default: all processors of the machine; of threads, all that
    /// share a memory].
    #[arg(short = 'n', long, value_name = "N", value_parser = ranks)]
    ranks: Option<usize>,
    /// Lets more ranks than the machine may have processors share these. For sort-first and sort-last by the model of the
    /// renderer's ranks, on a machine without nodes.
    #[arg(long)]
    share_processors: bool,
    /// Ranks of a group of sort-twice [default: 16, or all of fewer; of a machine whose processors are 'simd' the most up
    /// to 16 that divide them].
    #[arg(short, long, value_name = "G", value_parser = ranks)]
    group: Option<usize>,
    /// Pixels along the edge of a region [default: the renderer's tile; in the simulator the largest that gives every
    /// rank a region].
    #[arg(long, value_name = "PIXELS", value_parser = clap::value_parser!(u32).range(1..=32768))]
    region: Option<u32>,
    /// Neighbouring regions go to the same rank instead of different ones.
    #[arg(long)]
    blocks: bool,
    /// Uses the simulator of the sorting classes even where the renderer has the organisation.
    #[arg(long)]
    simulate: bool,
    /// Writes JSON with stable keys.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    running: RunningArgs,
}

/// How ranks share a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum OrganisationName {
    /// Threads of one process with shared memory.
    Threads,
    /// Primitives are sent before the geometry work.
    SortFirst,
    /// Set-up triangles are sent.
    SortMiddle,
    /// Pictures are composited.
    SortLast,
    /// Triangles inside groups, pictures between them.
    SortTwice,
}

/// Selects one of a rank's times.
type Seconds = fn(&RankSeconds) -> f64;

impl Predict {
    /// Runs the command.
    ///
    /// # Errors
    /// What went wrong.
    pub fn run(&self) -> Result<ExitCode> {
        if self.share_processors && self.organisation == OrganisationName::Threads {
            let text = "--share-processors is for ranks: expected --organisation sort-first or sort-last, found threads";
            return Err(UsageError(text.into()).into());
        }
        self.picture.ready(&self.machine)?;
        let machine = self.machine.machine(self.running.quiet)?;
        if let Some(per_node) = machine.processors.per_node.as_ref().filter(|_| self.share_processors) {
            let text = format!(
                "--share-processors is for a machine without nodes, found {}, whose nodes have {}",
                machine.name,
                counted_words(per_node.whole(), "processor", "processors")
            );
            return Err(UsageError(text).into());
        }
        need_costs(&machine)?;
        let on_threads = self.organisation == OrganisationName::Threads;
        let count = machine.processors.count.whole();
        let own = if on_threads { count.min(machine.most_threads()) } else { count };
        let ranks = self.ranks.unwrap_or(own as usize);
        let plan = self.plan(&machine, ranks);
        match &plan {
            None => machine.may_share_memory(ranks)?,
            Some(plan) if !self.share_processors => need_processors(&machine, plan, !self.simulate)?,
            Some(_) => {}
        }
        let pool = self.running.pool()?;
        let threads = if on_threads { ranks } else { 1 };
        let counted = pool.install(|| self.picture.count(&self.running, &machine, threads))?;
        let Some(plan) = plan else {
            let time = FrameTime::on_threads(&machine, &counted.counted, ranks);
            write_text(&Destination::Stdout, &self.threads_text(&counted, ranks, time))?;
            return Ok(ExitCode::SUCCESS);
        };
        let rendered = match self.simulate {
            true => Err(Simulated::Asked),
            false => pool.install(|| predict(&machine, &counted.picture(), &plan))?,
        };
        let processors = machine.processors_for(ranks);
        let text = match rendered {
            Ok(frame) => self.renderer_text(&counted, &plan, processors, &frame),
            Err(Simulated::Ranks) => {
                let frame = pool.install(|| extrapolate(&machine, &counted.picture(), &plan))?;
                self.extrapolated_text(&counted, processors, &frame)
            }
            Err(reason) => {
                plan.need_processors(&machine)
                    .with_context(|| format!("the simulator gives each rank a processor ({reason})"))?;
                let time =
                    simulate(&machine, &counted.counted.frame, &counted.boxes()?, counted.size, &plan)?;
                self.simulated_text(&counted, reason, &time)
            }
        };
        write_text(&Destination::Stdout, &text)?;
        Ok(ExitCode::SUCCESS)
    }

    /// How ranks share a frame; `None` for threads.
    fn plan(&self, machine: &Machine, ranks: usize) -> Option<Plan> {
        let organisation = match self.organisation {
            OrganisationName::Threads => return None,
            OrganisationName::SortFirst => Organisation::SortFirst,
            OrganisationName::SortMiddle => Organisation::SortMiddle,
            OrganisationName::SortLast => Organisation::SortLast,
            OrganisationName::SortTwice => {
                Organisation::SortTwice(self.group.unwrap_or_else(|| usual_group(machine, ranks)))
            }
        };
        let assignment = if self.blocks { Assignment::Blocks } else { Assignment::Interleaved };
        let topology = self.machine.topology();
        Some(Plan { organisation, ranks, threads: 1, region: self.region, assignment, topology })
    }

    fn threads_text(&self, counted: &Counted, threads: usize, time: FrameTime) -> String {
        if self.json {
            let value = json!({
                "organisation": "threads", "ranks": threads, "counters": counted.counted.frame,
                "seconds": time, "total_seconds": time.total(),
            });
            return format!("{value:#}\n");
        }
        let phases = [
            ("front end", time.front_end),
            ("geometry", time.geometry),
            ("rasterization", time.raster),
            ("shading", time.shading),
            ("memory", time.memory),
            ("picture", time.picture),
            ("waking", time.waking),
        ];
        let mut text = table(&counted_threads(threads), &phases, time.total());
        let c = &counted.counted.frame;
        // Writing into a string cannot fail.
        let _ = writeln!(text, "busiest over mean thread in the tiles: {:.2}", time.imbalance);
        let _ = writeln!(
            text,
            "clusters: {} tested, {} hidden and {} drawn in {} tiles of {} pixels",
            c.clusters, c.clusters_hidden, c.clusters_drawn, c.tiles_used, counted.tile_size
        );
        let _ = writeln!(
            text,
            "memory: {} bytes of model and bins touched, {} read for clusters, {} of picture",
            c.bytes_touched,
            c.bytes_read,
            4 * c.pixels
        );
        text
    }

    fn renderer_text(&self, counted: &Counted, plan: &Plan, processors: usize, frame: &RanksFrame) -> String {
        if self.json {
            let value = json!({
                "model": "renderer", "organisation": frame.organisation, "ranks": plan.ranks, "processors": processors,
                "counters": counted.counted.frame, "prediction": frame, "total_seconds": frame.total(),
            });
            return format!("{value:#}\n");
        }
        let how = renderer_words(plan);
        let place = match frame.carrier {
            Carrier::Threads => "threads of one process",
            Carrier::Processes => "processes of one machine",
            Carrier::Network => "messages by network",
        };
        let head = format!(
            "{}, {how}, regions of {} pixels, {place}\n\
             by the model of the renderer's ranks, which 'tercio lab validate --ranks' compares with it; rank 0:",
            ranks_on(plan.ranks, processors),
            frame.region
        );
        let mut text = table(&head, &frame.phases(), frame.total());
        let _ = writeln!(text, "{:16} {:>12}    {:>12}    busiest over mean", "all ranks", "busiest", "mean");
        let stages: [(&str, Seconds); 6] = [
            ("dividing", |r| r.divide),
            ("drawing", |r| r.draw),
            ("composing", |r| r.compose),
            ("collecting", |r| r.collect),
            ("waiting", |r| r.wait),
            ("all but waiting", RankSeconds::busy),
        ];
        for (name, of) in stages {
            let (busiest, mean) = frame.busiest_and_mean(of);
            // Writing into a string cannot fail.
            let _ = writeln!(
                text,
                "{name:16} {:12.4} ms {:12.4} ms {:8.2}",
                busiest * 1e3,
                mean * 1e3,
                frame.imbalance(of)
            );
        }
        let _ = writeln!(
            text,
            "{} bytes in {}, at most {} bytes from one rank",
            frame.bytes,
            counted_words(frame.messages, "message", "messages"),
            frame.most_bytes_sent
        );
        let m = frame.memory;
        let _ = writeln!(
            text,
            "memory of the rank that needs most: {} bytes, {} of them its picture, {} messages, {} model and bins touched",
            m.total(),
            m.picture,
            m.messages,
            m.model
        );
        text
    }

    fn extrapolated_text(&self, counted: &Counted, processors: usize, frame: &ExtrapolatedFrame) -> String {
        let plan = &frame.plan;
        if self.json {
            let organisation = renderer_words(plan).split(' ').next();
            let value = json!({
                "model": "extrapolated", "organisation": organisation, "ranks": plan.ranks, "processors": processors,
                "counters": counted.counted.frame, "prediction": frame, "total_seconds": frame.total(),
            });
            return format!("{value:#}\n");
        }
        let [fewer, more] = frame.counted;
        let mut text = format!(
            "{}, {}\nby the model of the renderer's ranks for {fewer} and {more} of them, and each part continued as a power of their number n; rank 0:\n",
            ranks_on(plan.ranks, processors),
            renderer_words(plan)
        );
        // Writing into a string cannot fail.
        let _ = writeln!(text, "{:16} {fewer:>12}    {more:>12}    {:>12}    grows as", "ranks", plan.ranks);
        for term in &frame.terms {
            let [fewer, more] = term.counted.map(|seconds| seconds * 1e3);
            let seconds = term.seconds * 1e3;
            let _ = writeln!(
                text,
                "{:16} {fewer:12.4} ms {more:12.4} ms {seconds:12.4} ms    n^{:.2}",
                term.name,
                // Without the sign of a zero.
                (term.exponent * 100.0).round() / 100.0 + 0.0
            );
        }
        let sum = |of: fn(&Term) -> f64| frame.terms.iter().map(of).sum::<f64>() * 1e3;
        let (fewer, more) = (sum(|term| term.counted[0]), sum(|term| term.counted[1]));
        let _ =
            writeln!(text, "{:16} {fewer:12.4} ms {more:12.4} ms {:12.4} ms", "frame", frame.total() * 1e3);
        let growing: Vec<&str> =
            frame.terms.iter().filter(|term| term.grows()).map(|term| term.name).collect();
        let growing = if growing.is_empty() { "none".into() } else { growing.join(", ") };
        let _ = writeln!(text, "parts that grow with the number of ranks: {growing}");
        let _ =
            writeln!(text, "(the busiest ranks, bytes and memory: of {} ranks and fewer)", frame.counted[1]);
        text
    }

    fn simulated_text(&self, counted: &Counted, reason: Simulated, time: &SimulatedFrame) -> String {
        let s = &time.sorting;
        if self.json {
            let value = json!({
                "model": "simulator", "why": reason, "organisation": describe(&time.plan), "ranks": time.plan.ranks, "counters": counted.counted.frame,
                "prediction": time, "total_seconds": time.total(),
            });
            return format!("{value:#}\n");
        }
        let head = format!(
            "{}, {}\nby the simulator of the sorting classes: {reason}",
            ranks_on(time.plan.ranks, time.plan.ranks),
            describe(&time.plan)
        );
        let mut text = table(&head, &time.phases(), time.total());
        // Writing into a string cannot fail.
        let _ = writeln!(text, "overlap {:.3}", s.overlap);
        let _ = writeln!(
            text,
            "busiest over mean rank: geometry {:.2}, rasterization {:.2}",
            s.geometry.imbalance(),
            s.raster.imbalance()
        );
        for (name, t) in
            [("redistribution", s.redistribution), ("composition", s.composition), ("delivery", s.delivery)]
        {
            let _ = writeln!(
                text,
                "{name}: {} bytes in {}, busiest link {:.0} bytes, longest way {}",
                t.bytes,
                counted_words(t.messages, "message", "messages"),
                t.busiest_link.max(t.inside.busiest_link),
                counted_words(t.most_hops.max(t.inside.most_hops).into(), "hop", "hops")
            );
        }
        let _ = writeln!(
            text,
            "memory of the fullest rank: {} bytes for triangles and picture",
            s.most_bytes_kept
        );
        text
    }
}

/// Refuses ranks that have no processors of their own, and says how they can share them if this plan's can.
fn need_processors(machine: &Machine, plan: &Plan, by_renderer: bool) -> Result<()> {
    let can_share = by_renderer && machine.processors.per_node.is_none() && plan.by_renderer(machine).is_ok();
    plan.need_processors(machine).map_err(|error| match can_share {
        true => anyhow!("{error}; with --share-processors ranks share them"),
        false => error.into(),
    })
}

/// The renderer's own organisation.
fn renderer_words(plan: &Plan) -> &'static str {
    match plan.organisation {
        Organisation::SortFirst => "sort-first",
        _ => "sort-last with direct send",
    }
}

fn counted_threads(threads: usize) -> String {
    counted_words(threads as u64, "thread", "threads")
}

/// Ranks, and how many processors they share if these are fewer.
fn ranks_on(ranks: usize, processors: usize) -> String {
    let ranks_in_words = counted_words(ranks as u64, "rank", "ranks");
    if ranks <= processors {
        return ranks_in_words;
    }
    format!("{ranks_in_words} that share {}", counted_words(processors as u64, "processor", "processors"))
}

fn table(head: &str, phases: &[(&str, f64)], total: f64) -> String {
    let mut text = format!("{head}\n");
    for (name, seconds) in phases.iter().chain([&("frame", total)]) {
        // Writing into a string cannot fail.
        let _ = writeln!(text, "{name:16} {:12.4} ms", seconds * 1e3);
    }
    text
}

/// One rank or more, up to the simulator's limit.
pub fn ranks(text: &str) -> Result<usize, String> {
    let most = 1 << 20;
    text.parse().ok().filter(|n| (1..=most).contains(n)).ok_or_else(|| format!("expected 1 to {most}"))
}
