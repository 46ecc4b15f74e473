//! `tercio lab simulate parks`: the machines of document 002.

use std::fmt::Write;
use std::path::PathBuf;

use anyhow::{Result, bail};
use clap::Args;
use serde_json::{Value, json};
use tercio_lab::simulators::parks::{
    self, Costs, Distribution, Machine, Polygon, ProcessorRun, SceneRun, listing::listing,
};

use super::polygons;

/// Scan conversion by splitter, interlace and hybrid (document 002).
#[derive(Debug, Args)]
#[command(after_help = "\
Without --chunks and --interlace all machines of the document are run: uniprocessor, interlace and splitter with
4 and 16 processors, hybrid with 16; 57 processors in all. Polygons that show their back are left out.

Examples:
  tercio lab simulate parks runway.polygons
  tercio lab simulate parks runway.polygons --chunks 4 --processor 7
  tercio lab simulate parks runway.polygons --interlace 16 --json

Exit code: 0 success, 1 error, 2 wrong usage.")]
pub struct Parks {
    /// The workload.
    #[arg(value_name = "SCENE")]
    pub(super) scene: PathBuf,
    /// Number of parts into which the splitter divides each side of the screen.
    #[arg(long, value_name = "N")]
    chunks: Option<u32>,
    /// Side of the pattern in which the pixels of each part are assigned to processors.
    #[arg(long, value_name = "N")]
    interlace: Option<u32>,
    /// Lists the statistics of one processor as the document's appendix C does; numbers run from 0, left to right,
    /// the lowest row first.
    #[arg(long, value_name = "NUMBER", conflicts_with = "json")]
    processor: Option<usize>,
    /// Writes JSON with stable keys.
    #[arg(long)]
    json: bool,
}

impl Parks {
    pub fn run(&self) -> Result<String> {
        let one = Machine { chunks: self.chunks.unwrap_or(1), interlace: self.interlace.unwrap_or(1) };
        let chosen = self.chunks.or(self.interlace).is_some() || self.processor.is_some();
        let machines = if chosen { vec![("machine", one)] } else { Machine::PUBLISHED.to_vec() };
        let scene = polygons(&self.scene)?;
        let polygons = Polygon::of_scene(&scene);
        let run = |machine| parks::simulate(machine, &Costs::pdp11(), (scene.width, scene.height), &polygons);
        if let Some(number) = self.processor {
            let run = run(&one)?;
            let count = run.processors.len();
            let Some(processor) = run.processors.get(number) else {
                bail!("expected a processor below {count}, found {number}");
            };
            return Ok(listing(processor, &Costs::pdp11()));
        }
        let runs = machines.iter().map(|(name, machine)| Ok((*name, *machine, run(machine)?)));
        let runs = runs.collect::<Result<Vec<_>>>()?;
        if self.json {
            let all: Value =
                runs.iter().map(|(name, machine, run)| machine_json(name, machine, run)).collect();
            return Ok(format!("{all:#}\n"));
        }
        let mut text = format!("{} polygons, {}x{} pixels\n", polygons.len(), scene.width, scene.height);
        for (name, machine, run) in &runs {
            text += &machine_text(name, machine, run);
        }
        Ok(text)
    }
}

fn machine_text(name: &str, machine: &Machine, run: &SceneRun) -> String {
    let (slowest, cycles) = run.slowest();
    let processor = &run.processors[slowest];
    let mut text = String::new();
    // Writing into a string cannot fail.
    let _ = writeln!(
        text,
        "{name:13} {:4} processors {cycles:13.1} memory cycles; slowest is {slowest}: {} polygons, {} vertices, {} segments ({} charged), {} pixels",
        machine.processors(),
        processor.polygons(),
        processor.vertices(),
        processor.segments(),
        processor.charged_segments(),
        processor.pixels(),
    );
    text
}

fn machine_json(name: &str, machine: &Machine, run: &SceneRun) -> Value {
    let processors = run.processors.iter().zip(&run.cycles).map(|(p, cycles)| processor_json(p, *cycles));
    let (slowest, cycles) = run.slowest();
    json!({
        "machine": name,
        "chunks": machine.chunks,
        "interlace": machine.interlace,
        "slowest": slowest,
        "cycles": cycles,
        "processors": processors.collect::<Value>(),
    })
}

fn processor_json(run: &ProcessorRun, cycles: f64) -> Value {
    let counts = |d: &Distribution| d.counts().map(|(value, times)| json!([value, times])).collect::<Value>();
    json!({
        "polygons": run.polygons(),
        "vertices": run.vertices(),
        "segments": run.segments(),
        "charged_segments": run.charged_segments(),
        "pixels": run.pixels(),
        "cycles": cycles,
        "vertices_per_polygon": counts(&run.vertices_per_polygon),
        "segments_per_polygon": counts(&run.segments_per_polygon),
        "pixels_per_segment": counts(&run.pixels_per_segment),
        "polygons_per_pixel": counts(&run.polygons_per_pixel),
        "pixels_per_polygon": counts(&run.pixels_per_polygon),
    })
}
