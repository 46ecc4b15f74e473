//! `tercio lab simulate ortega`: the data-parallel passes of document 004.

use std::fmt::Write;
use std::path::PathBuf;

use anyhow::Result;
use clap::Args;
use serde_json::{Value, json};
use tercio_lab::simulators::ortega::{self, Machine};

use super::polygons;

/// Data-parallel passes over polygons and segments (document 004).
#[derive(Debug, Args)]
#[command(after_help = "\
Steps are passes times the layers of polygons or segments on the processors; the document gives no time for them.

Examples:
  tercio lab simulate ortega dragon.polygons
  tercio lab simulate ortega dragon.polygons --processors 32,64,128,256,512 --buffer 65536 --json

Exit code: 0 success, 1 error, 2 wrong usage.")]
pub struct Ortega {
    /// The workload.
    #[arg(value_name = "SCENE")]
    pub(super) scene: PathBuf,
    /// Numbers of processors.
    #[arg(long, value_name = "N,...", default_value = "16384,32768,65536", value_delimiter = ',')]
    #[arg(value_parser = clap::value_parser!(u64).range(1..))]
    processors: Vec<u64>,
    /// Segments that are collected before they are split into pixels [default: one a processor].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    buffer: Option<u64>,
    /// Writes JSON with stable keys.
    #[arg(long)]
    json: bool,
}

impl Ortega {
    pub fn run(&self) -> Result<String> {
        let scene = polygons(&self.scene)?;
        let runs: Vec<_> = (self.processors.iter())
            .map(|&processors| {
                let machine = Machine { processors, buffer: self.buffer.unwrap_or(processors) };
                (machine, ortega::simulate(&machine, &scene).0)
            })
            .collect();
        if self.json {
            let rows = runs.iter().map(|(machine, run)| {
                json!({
                    "processors": machine.processors,
                    "buffer": machine.buffer,
                    "run": run,
                    "line_utilization": run.line_utilization(),
                    "pixel_utilization": run.pixel_utilization(machine),
                })
            });
            return Ok(format!("{:#}\n", rows.collect::<Value>()));
        }
        let mut text = String::new();
        for (machine, run) in &runs {
            // Writing into a string cannot fail.
            let _ = writeln!(
                text,
                "{:7} processors: {} line passes in {} steps, {} pixel passes in {} steps ({} buffers), {} segments, {} pixels, {} clipped, {} collisions",
                machine.processors,
                run.line_passes,
                run.line_steps,
                run.pixel_passes,
                run.pixel_steps,
                run.flushes,
                run.segments,
                run.pixels,
                run.clipped,
                run.collisions,
            );
        }
        Ok(text)
    }
}
