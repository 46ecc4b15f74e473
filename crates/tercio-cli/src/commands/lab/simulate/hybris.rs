//! `tercio lab simulate hybris`: the machines of document 001.

use std::fmt::Write;

use anyhow::Result;
use clap::{Args, ValueEnum};
use tercio::LoadOptions;
use tercio_lab::machines::load;
use tercio_lab::predict::views;
use tercio_lab::simulators::hybris::scene::project;
use tercio_lab::simulators::hybris::{HybrisFrame, Sharing, simulate};

use crate::args::{ModelArgs, RunningArgs, values};
use crate::ending;
use crate::named_files::NamedFiles;
use crate::progress::Display;

/// Partitions, triangle heap, tile engines cycle by cycle, bus and processors of Hybris (document 001).
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  tercio lab simulate hybris bunny.ply
  tercio lab simulate hybris bunny.ply --machine hybris-asic-two-engines --sharing composition --json
  tercio lab simulate hybris builtin:teapot@69k --machine hybris-dual-cpu --size 1024x768

Exit code: 0 success, 1 error, 2 wrong usage.")]
pub struct Hybris {
    #[command(flatten)]
    pub(super) model: ModelArgs,
    /// A machine with a heap and tile engines ('tercio lab machines'), or a file.
    #[arg(short, long, value_name = "MACHINE", default_value = "hybris-asic")]
    pub(super) machine: String,
    /// Size of the picture in pixels.
    #[arg(short, long, value_name = "WxH", default_value = "1280x1024", value_parser = values::size)]
    size: (u32, u32),
    /// The view, of 36 round the model.
    #[arg(long, value_name = "K", default_value_t = 0)]
    view: u32,
    /// How several engines share a frame.
    #[arg(long, value_name = "HOW", value_enum, default_value_t = SharingName::Tiles)]
    sharing: SharingName,
    /// Writes JSON with stable keys.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    running: RunningArgs,
}

/// How several engines share a frame.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum SharingName {
    /// Tiles of a checkerboard.
    Tiles,
    /// Every engine draws its share of the triangles of every tile; the results are composited.
    Composition,
    /// Pairs of engines have tiles of their own, and each of a pair draws every other triangle of them.
    Hybrid,
}

impl Hybris {
    pub fn run(&self, files: &NamedFiles) -> Result<String> {
        const VIEWS: u32 = 36;
        let machine = load(&self.machine)?;
        ending::name_model(self.model.name());
        let pool = self.running.pool()?;
        let sharing = match self.sharing {
            SharingName::Tiles => Sharing::Tiles,
            SharingName::Composition => Sharing::Composition,
            SharingName::Hybrid => Sharing::Hybrid,
        };
        let frame = pool.install(|| -> Result<HybrisFrame> {
            let display = Display::new(self.running.progress_mode());
            let options = LoadOptions {
                memory_limit: self.running.memory_limit(),
                progress: Some(&display.progress),
                ..LoadOptions::default()
            };
            let loaded = options.load_mesh(&self.model.model)?;
            files.check_companions(&self.model.name(), &loaded.report.read.companions)?;
            let mesh = loaded.mesh;
            let camera = views::camera(&mesh.bounds(), self.size, self.view % VIEWS, VIEWS);
            let scene = project(&mesh, &camera, self.size)?;
            Ok(simulate(&machine, &scene, sharing)?)
        })?;
        if self.json {
            return Ok(format!("{:#}\n", serde_json::to_value(&frame)?));
        }
        Ok(text(&machine.name, &frame))
    }
}

fn text(name: &str, f: &HybrisFrame) -> String {
    let c = f.front_end;
    let mut t = format!("{name}\n");
    // Writing into a string cannot fail.
    let _ = writeln!(
        t,
        "front end: {} partitions ({} culled), {} triangles: {} face away, {} below a pixel, {} outside, {} set up",
        c.partitions, c.partitions_culled, c.triangles, c.back_facing, c.sub_pixel, c.outside, c.nodes
    );
    let _ = writeln!(
        t,
        "heap: {} entries, {:.3} a triangle, {} buffers, {} bytes",
        c.entries, f.overlap, f.buffers, f.heap_bytes
    );
    // In software there are none.
    if let Some((back, seconds)) = f.engines() {
        let total = back.total();
        let _ = writeln!(
            t,
            "tile engines: {} tiles, {} pixels, {} cycles ({:.2} a triangle), {:.3} ms, imbalance {:.3}",
            back.tiles_used,
            total.pixels,
            back.cycles,
            total.cycles_per_triangle(),
            seconds * 1e3,
            back.imbalance()
        );
        let names = ["set-up triangle", "draw triangle", "set-up span", "draw span"];
        for (name, s) in names.iter().zip(total.stages) {
            let share = |n: u64| 100.0 * n as f64 / (s.busy + s.stalled + s.starved).max(1) as f64;
            let _ = writeln!(
                t,
                "  {name:16} busy {:5.1} %, stalled {:5.1} %, starved {:5.1} %",
                share(s.busy),
                share(s.stalled),
                share(s.starved)
            );
        }
    }
    if let Some(p) = f.pages {
        let _ = writeln!(
            t,
            "page misses: writing {} of {} in order, {} by tile; reading {} of {}",
            p.written_in_order.misses,
            p.written_in_order.accesses,
            p.written_by_tile.misses,
            p.read.misses,
            p.read.accesses
        );
    }
    if let Some(b) = f.transfer {
        let _ = writeln!(t, "bus: {} bytes in {} transfers, {:.3} ms", b.bytes, b.transfers, b.seconds * 1e3);
    }
    if let Some(s) = &f.software {
        let times = |seconds: &[f64]| {
            let each: Vec<_> = seconds.iter().map(|s| format!("{:.3} ms", s * 1e3)).collect();
            each.join(" and ")
        };
        let _ = writeln!(
            t,
            "software: front ends {}, back ends {}, serial {}",
            times(&s.front),
            times(&s.back),
            times(&[s.serial])
        );
    }
    let _ = match f.seconds() {
        seconds if seconds > 0.0 => {
            writeln!(t, "frame: {:.3} ms, {:.2} a second", seconds * 1e3, 1.0 / seconds)
        }
        _ => writeln!(t, "frame: nothing is drawn, which takes no time"),
    };
    t
}
