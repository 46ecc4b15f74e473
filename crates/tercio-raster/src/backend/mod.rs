//! The back end, parallel over tiles: coverage, depth and visibility into a small tile memory, every visible
//! pixel shaded and written to the picture ([`Canvas`]).
//!
//! Clusters come front to back, and one that lies behind everything drawn where it would appear is left out.
//! What a cluster wins is shaded while it is at hand ([`cluster`]). Pixels of triangles that were sorted one by
//! one ([`visibility`]; they come first), and all pixels of a tile that several threads share, are shaded at the
//! end ([`shade`]).

mod cluster;
mod corners;
mod encode;
mod interpolate;
mod light;
mod memory;
mod order;
mod shade;
mod table;
pub mod tally;
mod visibility;

use fearless_simd::Simd;

use crate::binning::Bins;
use crate::context::FrameContext;
use crate::frame::{Canvas, Outputs, Planes};
use crate::settings::{LastStage, Part};
use cluster::ClusterPass;
use memory::TileMemory;
use order::DepthOrder;
use shade::WinnerScratch;
use tally::Tally;

/// The memory that one thread needs to draw a tile.
#[derive(Debug, Default)]
pub struct Scratch {
    /// What is seen where.
    pub tile: TileMemory,
    pixels: Planes,
    order: DepthOrder,
    pass: ClusterPass,
    winners: WinnerScratch,
}

/// What is to be done of a tile.
#[derive(Clone, Copy, Debug)]
pub enum Stage {
    /// All of it, [`run`].
    Whole,
    /// A part of its entries, [`run_part`].
    Part(Part),
    /// The end of a tile that was drawn in parts, [`finish`].
    Finish,
}

/// The work that one thread does on a tile.
pub struct TileTask<'a> {
    /// What all stages share.
    pub context: &'a FrameContext<'a>,
    /// The bins.
    pub bins: &'a [Bins],
    /// Which tile.
    pub tile: u32,
    /// What is to be done of it.
    pub stage: Stage,
    /// The thread's memory.
    pub scratch: &'a mut Scratch,
    /// Where the tile's pixels go.
    pub canvas: &'a Canvas<'a>,
}

/// Does a task.
#[inline(always)]
pub fn draw_tile<S: Simd, T: Tally>(simd: S, task: TileTask) -> T {
    let TileTask { context, bins, tile, stage, scratch, canvas } = task;
    match stage {
        Stage::Whole => run(simd, context, bins, tile, scratch, canvas),
        Stage::Part(part) => run_part(simd, context, bins, tile, part, scratch, canvas),
        Stage::Finish => finish(simd, context, tile, scratch, canvas),
    }
}

/// So many clusters before its turn a cluster is asked of the memory.
const AHEAD: usize = 2;

/// When the pixels that clusters win are shaded.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Shade {
    /// With the cluster that wins them.
    AtOnce,
    /// When all of the tile is drawn.
    Later,
}

/// Draws one tile from all bins and writes it to the picture.
#[inline(always)]
pub fn run<S: Simd, T: Tally>(
    simd: S,
    context: &FrameContext,
    bins: &[Bins],
    tile: u32,
    scratch: &mut Scratch,
    canvas: &Canvas,
) -> T {
    let mut tally = T::default();
    let target = canvas.claim(tile);
    let triangles: usize = bins.iter().map(|b| b.triangles_in(tile).len()).sum();
    let clusters: usize = bins.iter().map(|b| b.clusters_in(tile).len()).sum();
    if let Some(full) = tally.full() {
        full.tile(context, tile, triangles + clusters > 0);
    }
    let last = context.settings.last_stage;
    if triangles + clusters == 0 || last <= LastStage::Bin {
        target.write_background();
        return tally;
    }
    let stride = 1 << memory::stride_bits(context);
    target.clear(&mut scratch.pixels, stride);
    draw(simd, context, bins, tile, Part::WHOLE, Shade::AtOnce, scratch, canvas.outputs(), &mut tally);
    if triangles > 0 && last > LastStage::Visibility {
        shade::tile(simd, context, &scratch.tile, &mut scratch.pixels, canvas.outputs(), &mut tally);
    }
    tally.counts().pixels_visible += scratch.tile.visible();
    target.write(&scratch.pixels, stride);
    tally
}

/// Draws a part of a tile into the tile memory only; [`finish`] does the rest.
#[inline(always)]
pub fn run_part<S: Simd, T: Tally>(
    simd: S,
    context: &FrameContext,
    bins: &[Bins],
    tile: u32,
    part: Part,
    scratch: &mut Scratch,
    canvas: &Canvas,
) -> T {
    let mut tally = T::default();
    draw(simd, context, bins, tile, part, Shade::Later, scratch, canvas.outputs(), &mut tally);
    tally
}

/// Shades and writes a tile that was drawn in parts, from the memory that they were merged into.
#[inline(always)]
pub fn finish<S: Simd, T: Tally>(
    simd: S,
    context: &FrameContext,
    tile: u32,
    scratch: &mut Scratch,
    canvas: &Canvas,
) -> T {
    let mut tally = T::default();
    let (target, stride) = (canvas.claim(tile), 1 << memory::stride_bits(context));
    target.clear(&mut scratch.pixels, stride);
    if let Some(full) = tally.full() {
        full.tile(context, tile, true);
    }
    if context.settings.last_stage <= LastStage::Visibility {
        return tally;
    }
    shade::tile(simd, context, &scratch.tile, &mut scratch.pixels, canvas.outputs(), &mut tally);
    tally.counts().pixels_visible += scratch.tile.visible();
    target.write(&scratch.pixels, stride);
    tally
}

/// Draws a part of a tile's entries: triangles first, then clusters front to back. Not inlined, so that it is
/// compiled once a level.
#[expect(clippy::too_many_arguments, reason = "a struct would only rename them")]
#[inline(never)]
fn draw<S: Simd, T: Tally>(
    simd: S,
    context: &FrameContext,
    bins: &[Bins],
    tile: u32,
    part: Part,
    shade: Shade,
    scratch: &mut Scratch,
    outputs: &Outputs,
    tally: &mut T,
) {
    simd.vectorize(
        #[inline(always)]
        || draw_inline(simd, context, bins, tile, part, shade, scratch, outputs, tally),
    );
}

#[expect(clippy::too_many_arguments, reason = "a struct would only rename them")]
#[inline(always)]
fn draw_inline<S: Simd, T: Tally>(
    simd: S,
    context: &FrameContext,
    bins: &[Bins],
    tile: u32,
    part: Part,
    shade: Shade,
    scratch: &mut Scratch,
    outputs: &Outputs,
    tally: &mut T,
) {
    let Scratch { tile: memory, pixels, order, pass, winners } = scratch;
    memory.clear(context, tile);
    let triangles = bins.iter().flat_map(|b| b.triangles_in(tile));
    let mut mixed = false;
    let last = context.settings.last_stage;
    for triangle in part.every(triangles) {
        if last <= LastStage::Sieve {
            break;
        }
        let before = tally.counts().stamps;
        visibility::draw(simd, context, triangle, memory, None, tally.counts());
        let stamps = tally.counts().stamps - before;
        if let Some(full) = tally.full() {
            full.details.entries_drawn += 1;
            full.details.stamps_alone += stamps;
        }
        mixed = true;
    }
    let entries = bins.iter().flat_map(|b| b.clusters_in(tile));
    order.front_to_back(part.every(entries));
    let clusters = order.clusters();
    // What was hidden when it was looked at ahead stays hidden.
    let mut hidden = [false; AHEAD];
    for (i, binned) in clusters.iter().enumerate() {
        if let Some(later) = clusters.get(i + 2 * AHEAD) {
            cluster::prefetch_head(context, later);
        }
        let was_hidden = hidden[i % AHEAD];
        if let Some(later) = clusters.get(i + AHEAD) {
            hidden[i % AHEAD] = cluster::is_hidden(simd, later, memory);
            if !hidden[i % AHEAD] {
                cluster::prefetch_body(context, later);
            }
        }
        if was_hidden || cluster::is_hidden(simd, binned, memory) {
            tally.counts().clusters_hidden += 1;
            continue;
        }
        tally.counts().clusters_drawn += 1;
        pass.draw(simd, context, binned, memory, tally);
        if shade == Shade::AtOnce && last > LastStage::Visibility {
            if mixed {
                memory.mark_shaded(pass.winners.places());
            }
            let counts = tally.counts();
            shade::winners(simd, context, binned.number, pass, memory, winners, pixels, outputs, counts);
            if let Some(full) = tally.full() {
                full.winners(context, binned.number, pass.winners.len());
            }
        }
    }
}
