//! The back end, parallel over tiles: coverage, depth and visibility into a small tile memory ([`visibility`]),
//! then every visible pixel shaded once ([`shade`]) and written to the picture ([`output`]).

pub mod edges;
pub mod fetch;
pub mod light;
pub mod output;
pub mod shade;
pub mod visibility;

use fearless_simd::Simd;

use crate::binning::Binned;
use crate::context::FrameContext;
use crate::frontend::Batch;
use crate::stats::BackEndCounts;
use output::Planes;
use visibility::TileMemory;

/// The memory that one thread needs to draw a tile.
#[derive(Debug, Default)]
pub struct Scratch {
    tile: TileMemory,
    pixels: output::TilePixels,
}

/// Draws one tile from the bins of all batches and writes it to the picture.
#[inline(always)]
pub fn run<S: Simd>(
    simd: S,
    context: &FrameContext,
    batches: &[Batch],
    tile: u32,
    scratch: &mut Scratch,
    planes: &Planes,
) -> BackEndCounts {
    let mut counts = BackEndCounts::default();
    let entries: usize = batches.iter().map(|b| b.bins.fill(tile)).sum();
    let rect = output::tile_rect(context, tile);
    scratch.pixels.clear(rect, planes);
    if entries > 0 {
        scratch.tile.clear(context, tile);
        for batch in batches {
            for binned in batch.bins.in_tile(tile) {
                match binned {
                    Binned::Small(triangle) => scratch.tile.draw_small(simd, context, triangle, &mut counts),
                    Binned::Any(triangle) => scratch.tile.draw(simd, context, triangle, &mut counts),
                }
            }
        }
        shade::tile(simd, context, &scratch.tile, &mut scratch.pixels, planes, &mut counts);
    }
    scratch.pixels.write(rect, planes);
    counts
}
