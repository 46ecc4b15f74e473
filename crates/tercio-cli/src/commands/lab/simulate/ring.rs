//! `tercio lab simulate ring`: the ring of document 000.

use std::fmt::Write;
use std::path::PathBuf;

use anyhow::Result;
use clap::Args;
use serde_json::json;
use tercio_lab::simulators::ring::{self, Algorithm, Machine, RingRun};
use tercio_lab::workloads::ScreenMap;

use super::boxes;
use crate::args::values;
use crate::report::grouped;

/// Polygons on a ring of processors (document 000, appendix A).
#[derive(Debug, Args)]
#[command(after_help = "\
Without options the machine is the Princeton Engine with the parameters of the document's table A.1: 1,024
processors, a column of a 768x512 screen each, no duplication, a dense network, neighbour passes, one group.

Examples:
  tercio lab simulate ring teapot.boxes
  tercio lab simulate ring teapot.boxes --strides 16,1 --duplication 4
  tercio lab simulate ring made.boxes --group 16 --json

Exit code: 0 success, 1 error, 2 wrong usage.")]
pub struct Ring {
    /// The workload: boxes, or polygons, of which the bounding boxes are used.
    #[arg(value_name = "SCENE")]
    pub(super) scene: PathBuf,
    /// n: processors of the ring.
    #[arg(long, value_name = "N", default_value_t = 1024)]
    processors: u32,
    /// Size of the screen in pixels; for the default map it has as many columns as there are processors.
    #[arg(long, value_name = "WxH", default_value = "768x512", value_parser = values::size)]
    size: (u32, u32),
    /// A file that assigns pixels to processors [default: columns from left to right].
    #[arg(long, value_name = "FILE")]
    pub(super) map: Option<PathBuf>,
    /// m: processors that hold each polygon.
    #[arg(long, value_name = "M", default_value_t = 1)]
    duplication: u32,
    /// t: passes between two checks for descriptors that all processors have seen; 1 is the dense network, the number
    /// of processors the sparse one.
    #[arg(long, value_name = "T", default_value_t = 1)]
    test_period: u32,
    /// d: strides of the stages, decreasing to 1.
    #[arg(long, value_name = "D,...", default_value = "1", value_delimiter = ',')]
    strides: Vec<u32>,
    /// g: processors that share one copy of the screen; fewer than all is sort-twice [default: all].
    #[arg(long, value_name = "G")]
    group: Option<u32>,
    /// Gi: instructions to transform a polygon and keep or reject it.
    #[arg(long, value_name = "N", default_value_t = 1000)]
    examine: u32,
    /// Gf: instructions to light a polygon and compute its linear equations.
    #[arg(long, value_name = "N", default_value_t = 5000)]
    finish: u32,
    /// R: instructions to rasterize a pixel.
    #[arg(long, value_name = "N", default_value_t = 100)]
    pixel: u32,
    /// Writes JSON with stable keys.
    #[arg(long)]
    json: bool,
}

impl Ring {
    pub fn run(&self) -> Result<String> {
        let machine = Machine {
            processors: self.processors,
            examine_polygon: self.examine.into(),
            finish_polygon: self.finish.into(),
            raster_pixel: self.pixel.into(),
            ..Machine::princeton_engine()
        };
        let algorithm = Algorithm {
            duplication: self.duplication,
            test_period: self.test_period,
            strides: self.strides.clone(),
            group: self.group.unwrap_or(self.processors),
        };
        // Checked before the scene is read, and before a map is made for an impossible group.
        algorithm.check(&machine, 0)?;
        let map = match &self.map {
            Some(file) => ScreenMap::read(file)?,
            None => ScreenMap::columns(self.size.0, self.size.1, algorithm.group),
        };
        let run = ring::simulate(&machine, &algorithm, &map, &boxes(&self.scene)?)?;
        Ok(if self.json { json(&run) } else { text(&run) })
    }
}

fn json(run: &RingRun) -> String {
    let value = json!({
        "run": run,
        "passes": run.passes(),
        "overlap": run.overlap(),
        "asymmetry": run.asymmetry(),
        "communication_instructions": run.communication(),
        "instructions": run.instructions(),
    });
    format!("{value:#}\n")
}

fn text(run: &RingRun) -> String {
    let per_visible = |instructions: u64| instructions as f64 / run.visible.max(1) as f64;
    let mut text = String::new();
    let mut line = |name: &str, what: String, instructions: u64| {
        let amount = format!(
            "{:>15} instructions {:10.2} a visible polygon",
            grouped(instructions),
            per_visible(instructions)
        );
        let _ = writeln!(text, "{name:14} {what:46} {amount}");
    };
    let geometry = &run.geometry;
    let most = format!("at most {} examined and {} finished", geometry.examined, geometry.finished);
    line("geometry", most, geometry.instructions);
    for stage in &run.stages {
        let what = format!("{} passes over {}", grouped(stage.passes), stage.stride);
        line("communication", what, stage.instructions);
    }
    if run.composite_passes > 0 {
        line("compositing", format!("{} passes", grouped(run.composite_passes)), run.composite_instructions);
    }
    line("rasterization", format!("at most {} pixels", grouped(run.raster.pixels)), run.raster.instructions);
    line("frame", String::new(), run.instructions());
    let _ = writeln!(
        text,
        "{} polygons, {} visible; each on {:.3} processors, the busiest with {:.2} times the mean",
        grouped(run.polygons),
        grouped(run.visible),
        run.overlap(),
        run.asymmetry()
    );
    let checks = &run.checks;
    let _ = writeln!(
        text,
        "checks: {} missing, {} unneeded, {} repeated of {} copies",
        checks.missing,
        checks.unneeded,
        checks.repeated,
        grouped(run.copies)
    );
    text
}
