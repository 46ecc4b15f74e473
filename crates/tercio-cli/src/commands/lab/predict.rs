//! `tercio lab predict`: a frame of the real renderer on a described machine.

use std::fmt::Write;
use std::process::ExitCode;

use anyhow::Result;
use clap::{Args, ValueEnum};
use serde_json::json;
use tercio::image::Destination;
use tercio_lab::predict::advise::describe;
use tercio_lab::predict::frame::FrameTime;
use tercio_lab::predict::ranks::{Plan, RanksTime, predict};
use tercio_lab::simulators::sorting::{Assignment, Organisation};

use super::plan::{Counted, MachineArgs, PictureArgs};
use crate::args::RunningArgs;
use crate::output::write_text;
use crate::threads;

/// Predicts a frame of the renderer: time of each phase, bytes, imbalance, memory.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  tercio lab predict dragon.ply --machine two-core-2026 --ranks 2
  tercio lab predict builtin:gyroid@5M --machine cluster-64 --organisation sort-twice --group 8 --ranks 512
  tercio lab predict dragon.ply --machine mine.toml --organisation sort-last --ranks 64 --network mesh --json

Exit code: 0 success, 1 error, 2 wrong usage.")]
pub struct Predict {
    #[command(flatten)]
    picture: PictureArgs,
    #[command(flatten)]
    machine: MachineArgs,
    /// How ranks share a frame.
    #[arg(short = 'O', long, value_name = "CLASS", value_enum, default_value_t = OrganisationName::Threads)]
    organisation: OrganisationName,
    /// Ranks, or threads [default: all processors of the machine].
    #[arg(short = 'n', long, value_name = "N", value_parser = ranks)]
    ranks: Option<usize>,
    /// Ranks of a group of sort-twice.
    #[arg(short, long, value_name = "G", default_value = "16", value_parser = ranks)]
    group: usize,
    /// Pixels along the edge of a region [default: the largest of which there is one a rank].
    #[arg(long, value_name = "PIXELS", value_parser = clap::value_parser!(u32).range(1..=32768))]
    region: Option<u32>,
    /// Neighbouring regions go to one rank rather than to different ones.
    #[arg(long)]
    blocks: bool,
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
    /// Primitives travel before the geometry work.
    SortFirst,
    /// Set-up triangles travel.
    SortMiddle,
    /// Pictures are composed.
    SortLast,
    /// Triangles inside groups, pictures between them.
    SortTwice,
}

impl Predict {
    /// Runs the command.
    ///
    /// # Errors
    /// What went wrong.
    pub fn run(&self) -> Result<ExitCode> {
        let machine = self.machine.machine()?;
        let ranks = self.ranks.unwrap_or(machine.processors.count.whole() as usize);
        let pool = threads::pool(self.running.threads)?;
        let threads = (self.organisation == OrganisationName::Threads).then_some(ranks);
        let counted = pool.install(|| self.picture.count(&self.running, &machine, threads))?;
        let organisation = match self.organisation {
            OrganisationName::Threads => {
                let time = FrameTime::on_threads(&machine, &counted.counted, ranks);
                write_text(&Destination::Stdout, &self.threads_text(&counted, ranks, time))?;
                return Ok(ExitCode::SUCCESS);
            }
            OrganisationName::SortFirst => Organisation::SortFirst,
            OrganisationName::SortMiddle => Organisation::SortMiddle,
            OrganisationName::SortLast => Organisation::SortLast,
            OrganisationName::SortTwice => Organisation::SortTwice(self.group),
        };
        let assignment = if self.blocks { Assignment::Blocks } else { Assignment::Interleaved };
        let topology = self.machine.topology();
        let plan = Plan { organisation, ranks, region: self.region, assignment, topology };
        let time = predict(&machine, &counted.counted.frame, &counted.boxes, counted.size, plan)?;
        write_text(&Destination::Stdout, &self.ranks_text(&counted, &time))?;
        Ok(ExitCode::SUCCESS)
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
        ];
        let mut text = table(&format!("{threads} threads"), &phases, time.total());
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

    fn ranks_text(&self, counted: &Counted, time: &RanksTime) -> String {
        let s = &time.sorting;
        if self.json {
            let value = json!({
                "organisation": describe(&time.plan), "ranks": time.plan.ranks, "counters": counted.counted.frame,
                "prediction": time, "total_seconds": time.total(),
            });
            return format!("{value:#}\n");
        }
        let head = format!("{} ranks, {}", time.plan.ranks, describe(&time.plan));
        let mut text = table(&head, &time.phases(), time.total());
        // Writing into a string cannot fail.
        let _ = writeln!(text, "overlap {:.3}", s.overlap);
        let _ = writeln!(
            text,
            "busiest over mean rank: geometry {:.2}, rasterization {:.2}",
            s.geometry.imbalance(),
            s.raster.imbalance()
        );
        for (name, t) in [("redistribution", s.redistribution), ("composition", s.composition)] {
            let _ = writeln!(
                text,
                "{name}: {} bytes in {} messages, busiest link {:.0} bytes, longest way {} hops",
                t.bytes, t.messages, t.busiest_link, t.most_hops
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

fn table(head: &str, phases: &[(&str, f64)], total: f64) -> String {
    let mut text = format!("{head}\n");
    for (name, seconds) in phases.iter().chain([&("frame", total)]) {
        // Writing into a string cannot fail.
        let _ = writeln!(text, "{name:16} {:12.4} ms", seconds * 1e3);
    }
    text
}

/// One rank or more, as many as the simulator is made for.
pub fn ranks(text: &str) -> Result<usize, String> {
    let most = 1 << 20;
    text.parse().ok().filter(|n| (1..=most).contains(n)).ok_or_else(|| format!("expected 1 to {most}"))
}
