//! The back end, parallel over tiles: resolves coverage, depth and visibility in a small tile memory, shades every
//! visible pixel and writes it to the picture ([`Canvas`]).
//!
//! A tile first draws its triangles that were binned one by one ([`visibility`]), then its clusters front to back,
//! except those that are occluded by what was drawn before. The winners of a cluster are shaded at once, while its
//! vertices are in cache ([`cluster`]). The pixels of triangles that were binned one by one, and all pixels of a tile
//! that several threads share, are shaded at the end ([`shade`]).

mod cluster;
mod corners;
mod data;
mod edges;
pub mod encode;
mod interpolate;
mod light;
mod material;
mod memory;
mod multisample;
mod order;
mod shade;
mod table;
pub mod tally;
mod tone;
mod visibility;

use fearless_simd::Simd;

use crate::binning::Bins;
use crate::context::FrameContext;
use crate::frame::{Canvas, FragmentError, FragmentsOfTile, Outputs, Planes};
use crate::settings::{LastStage, Part};
use cluster::ClusterPass;
use memory::TileMemory;
use order::DepthOrder;
use shade::WinnerScratch;
use tally::Tally;

/// The memory that one thread needs to draw a tile.
#[derive(Debug, Default)]
pub struct Scratch {
    /// Depth and visible triangle of each sample.
    tile: TileMemory,
    pixels: Planes,
    order: DepthOrder,
    pass: ClusterPass,
    winners: WinnerScratch,
    multisample: multisample::Scratch,
    /// Tiles that were drawn with this memory, and the work in each.
    pub drawn: Vec<(u32, u64)>,
}

impl Scratch {
    /// Merges the memory of another part of the same tile: the nearer samples win.
    pub fn merge(&mut self, context: &FrameContext, other: &Self) {
        if context.has_fragments() {
            self.multisample.memory.merge(context, &other.multisample.memory);
        } else {
            self.tile.merge(context, &other.tile);
        }
    }
}

/// Which work of a tile a task does.
#[derive(Clone, Copy, Debug)]
pub enum Stage {
    /// All of it, [`run`].
    Whole,
    /// Draw a part of its entries, [`run_part`].
    Part(Part),
    /// Shade and write a tile that was drawn in parts, [`finish`].
    Finish,
}

/// The work of one thread on a tile.
pub struct TileTask<'a> {
    /// The immutable state of the frame.
    pub context: &'a FrameContext<'a>,
    /// The bins.
    pub bins: &'a [Bins],
    /// Number of the tile.
    pub tile: u32,
    /// Which work of the tile to do.
    pub stage: Stage,
    /// The thread's memory.
    pub scratch: &'a mut Scratch,
    /// The picture that the tile's pixels are written to.
    pub canvas: &'a Canvas<'a>,
}

/// Executes a task.
#[inline(always)]
pub fn draw_tile<S: Simd, T: Tally>(simd: S, task: TileTask) -> T {
    let TileTask { context, bins, tile, stage, scratch, canvas } = task;
    match stage {
        Stage::Whole => run(simd, context, bins, tile, scratch, canvas),
        Stage::Part(part) => run_part(simd, context, bins, tile, part, scratch, canvas),
        Stage::Finish => finish(simd, context, tile, scratch, canvas),
    }
}

/// Writes a tile from the fragments of several ranks to the picture, and returns the number of pixels in which something is
/// drawn.
///
/// # Errors
/// [`FragmentError`]; nothing is written then.
#[inline(always)]
pub fn merge_tile<S: Simd>(
    simd: S,
    context: &FrameContext,
    tile: &FragmentsOfTile,
    scratch: &mut Scratch,
    canvas: &Canvas,
) -> Result<u64, FragmentError> {
    let Scratch { pixels, multisample, .. } = scratch;
    multisample::merge(simd, context, tile, multisample, canvas, pixels)
}

/// Prefetch distance, in clusters.
const PREFETCH_DISTANCE: usize = 2;

/// When the winners of a cluster are shaded.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Shade {
    /// Right after the cluster is drawn.
    Immediate,
    /// When all of the tile is drawn.
    Deferred,
}

/// The planes that shading writes. Keys are those of the samples that are visible in the end: written once, not whenever a
/// pixel is shaded, they leave the fastest kernels usable.
fn shaded_outputs(canvas: &Canvas) -> Outputs {
    Outputs { keys: false, ties: false, ..*canvas.outputs() }
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
    let mut target = canvas.claim(tile);
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
    if context.has_fragments() {
        let Scratch { pixels, order, multisample, .. } = scratch;
        let (outputs, part, shade) = (canvas.outputs(), Part::WHOLE, Shade::Immediate);
        multisample::draw(simd, context, bins, tile, part, shade, order, multisample, outputs, &mut tally);
        if context.is_translucent() {
            multisample::draw_layers(simd, context, bins, tile, order, multisample, outputs, &mut tally);
        }
        multisample::finish(simd, context, multisample, target, pixels, outputs, &mut tally);
        return tally;
    }
    let stride = 1 << memory::stride_bits(context);
    target.clear(&mut scratch.pixels, stride);
    let shaded = &shaded_outputs(canvas);
    draw(simd, context, bins, tile, Part::WHOLE, Shade::Immediate, scratch, shaded, &mut tally);
    if triangles > 0 && last > LastStage::Visibility {
        shade::tile(simd, context, &scratch.tile, &mut scratch.pixels, shaded, &mut tally);
    }
    if last > LastStage::Visibility {
        scratch.tile.write_keys(context, &mut scratch.pixels);
    }
    tally.counts().pixels_visible += scratch.tile.visible();
    target.write(&scratch.pixels, stride);
    tally
}

/// Draws a part of a tile's entries into the tile memory only; [`finish`] shades and writes the tile.
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
    let (shade, outputs) = (Shade::Deferred, &shaded_outputs(canvas));
    if context.has_fragments() {
        let Scratch { order, multisample, .. } = scratch;
        multisample::draw(simd, context, bins, tile, part, shade, order, multisample, outputs, &mut tally);
        return tally;
    }
    draw(simd, context, bins, tile, part, shade, scratch, outputs, &mut tally);
    tally
}

/// Shades and writes a tile that was drawn in parts, from the tile memory that they were merged into.
#[inline(always)]
pub fn finish<S: Simd, T: Tally>(
    simd: S,
    context: &FrameContext,
    tile: u32,
    scratch: &mut Scratch,
    canvas: &Canvas,
) -> T {
    let mut tally = T::default();
    let mut target = canvas.claim(tile);
    if let Some(full) = tally.full() {
        full.tile(context, tile, true);
    }
    if context.has_fragments() {
        let Scratch { pixels, multisample, .. } = scratch;
        multisample::finish(simd, context, multisample, target, pixels, canvas.outputs(), &mut tally);
        return tally;
    }
    tally.counts().pixels_visible += scratch.tile.visible();
    if context.settings.last_stage <= LastStage::Visibility {
        target.write_background();
        return tally;
    }
    let stride = 1 << memory::stride_bits(context);
    target.clear(&mut scratch.pixels, stride);
    shade::tile(simd, context, &scratch.tile, &mut scratch.pixels, &shaded_outputs(canvas), &mut tally);
    scratch.tile.write_keys(context, &mut scratch.pixels);
    target.write(&scratch.pixels, stride);
    tally
}

/// Draws a part of a tile's entries: triangles first, then clusters front to back. Not inlined, so that it is
/// compiled only once per SIMD level.
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
    let Scratch { tile: memory, pixels, order, pass, winners, .. } = scratch;
    memory.clear(context, tile);
    let triangles = bins.iter().flat_map(|b| b.triangles_in(tile));
    let mut has_triangles = false;
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
        has_triangles = true;
    }
    let entries = bins.iter().flat_map(|b| b.clusters_in(tile));
    order.front_to_back(part.every(entries));
    let clusters = order.clusters();
    // The results of the occlusion tests of the next clusters: a cluster that is already hidden stays hidden, and is
    // not prefetched.
    let mut hidden = [false; PREFETCH_DISTANCE];
    for (i, binned) in clusters.iter().enumerate() {
        if let Some(later) = clusters.get(i + 2 * PREFETCH_DISTANCE) {
            cluster::prefetch_head(context, later);
        }
        let was_hidden = hidden[i % PREFETCH_DISTANCE];
        if let Some(later) = clusters.get(i + PREFETCH_DISTANCE) {
            hidden[i % PREFETCH_DISTANCE] = cluster::is_hidden(simd, later, memory);
            if !hidden[i % PREFETCH_DISTANCE] {
                cluster::prefetch_body(context, later);
            }
        }
        if was_hidden || cluster::is_hidden(simd, binned, memory) {
            tally.counts().clusters_hidden += 1;
            continue;
        }
        tally.counts().clusters_drawn += 1;
        pass.draw(simd, context, binned, memory, tally);
        if shade == Shade::Immediate && last > LastStage::Visibility {
            if has_triangles {
                memory.mark_shaded(pass.winners.sample_indices());
            }
            let counts = tally.counts();
            shade::winners(simd, context, binned.number, pass, memory, winners, pixels, outputs, counts);
            if let Some(full) = tally.full() {
                full.winners(context, binned.number, pass.winners.len(), pass.vertices.has_wide_triangles);
            }
        }
    }
}
