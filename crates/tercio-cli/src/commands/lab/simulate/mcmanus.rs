//! `tercio lab simulate mcmanus`: the arrays of document 003.

use std::fmt::Write;
use std::path::PathBuf;

use anyhow::{Result, bail};
use clap::Args;
use serde_json::{Value, json};
use tercio_lab::simulators::mcmanus::{AreaModel, raster_cycles, renderers, silicon};
use tercio_lab::workloads::{MAX_SCREEN_PIXELS, PolygonScene};

use super::{boxes, is_polygons};
use crate::args::values;

/// Raster cycles and silicon of pixel processor arrays (document 003).
#[derive(Debug, Args)]
#[command(after_help = "\
Lists for each size of region what the document's tables 1 and 2 list: raster cycles, overlap factor, polygons a
second, and the areas of geometry engine, array and renderer in square inches.

Examples:
  tercio lab simulate mcmanus dragon.polygons
  tercio lab simulate mcmanus teapot.boxes --size 768x512 --regions 8,16,32 --json

Exit code: 0 success, 1 error, 2 wrong usage.")]
pub struct McManus {
    /// The workload: boxes, or polygons, of which the bounding boxes are used.
    #[arg(value_name = "SCENE")]
    pub(super) scene: PathBuf,
    /// Size of the screen in pixels [default: that of the polygons; 512x512 for boxes].
    #[arg(long, value_name = "WxH", value_parser = values::size)]
    size: Option<(u32, u32)>,
    /// Sides of the regions in pixels.
    #[arg(long, value_name = "A,...", default_value = "1,2,4,8,16,32,64,128,256,512", value_delimiter = ',')]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=32768))]
    regions: Vec<u32>,
    /// Raster cycles a second.
    #[arg(long, value_name = "RATE", default_value = "1e6", value_parser = values::positive)]
    rate: f64,
    /// Writes JSON with stable keys.
    #[arg(long)]
    json: bool,
}

impl McManus {
    pub fn run(&self) -> Result<String> {
        let (scene, own) = if is_polygons(&self.scene) {
            let scene = PolygonScene::read(&self.scene)?;
            (scene.boxes(), (scene.width, scene.height))
        } else {
            (boxes(&self.scene)?, (512, 512))
        };
        let size = self.size.unwrap_or(own);
        if u64::from(size.0) * u64::from(size.1) > MAX_SCREEN_PIXELS {
            bail!("expected a screen of at most {MAX_SCREEN_PIXELS} pixels, found {}x{}", size.0, size.1);
        }
        let cycles: Vec<_> = self.regions.iter().map(|&side| raster_cycles(&scene, size, side)).collect();
        let renderers = renderers(&cycles, &AreaModel::PUBLISHED, self.rate);
        let best = silicon::best(&renderers).map(|r| r.side);
        if self.json {
            let rows = cycles.iter().zip(&renderers).map(|(c, r)| {
                json!({
                    "cycles": c,
                    "overlap": c.overlap(),
                    "rate": r.rate,
                    "geometry_area": r.geometry,
                    "array_area": r.array,
                    "area": r.area(),
                })
            });
            return Ok(format!("{:#}\n", json!({ "regions": rows.collect::<Value>(), "best": best })));
        }
        let mut text = format!(
            "{:>9} {:>12} {:>8} {:>12} {:>10} {:>10} {:>10}\n",
            "region", "cycles", "overlap", "polygons/s", "geometry", "array", "renderer"
        );
        for (c, r) in cycles.iter().zip(&renderers) {
            let region = format!("{0}x{0}", c.side);
            // Writing into a string cannot fail.
            let _ = writeln!(
                text,
                "{region:>9} {:12} {:8.2} {:12.0} {:10.3} {:10.5} {:10.3}",
                c.cycles,
                c.overlap(),
                r.rate,
                r.geometry,
                r.array,
                r.area()
            );
        }
        if let Some(side) = best {
            let _ = writeln!(text, "least silicon for a polygon a second: {side}x{side}");
        }
        Ok(text)
    }
}
