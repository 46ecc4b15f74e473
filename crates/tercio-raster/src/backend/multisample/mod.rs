//! Tiles with several samples per pixel.
//!
//! A **fragment** is a triangle in a pixel: it is shaded once ([`SampleShading::Pixel`](crate::SampleShading)) or is one
//! sample of the pixel. Tile memory ([`memory`]) stores the depth of every sample and the number of its fragment.
//! Triangles of a few pixels are tested 16 at a time ([`few`], [`scan`]), larger ones are set up 16 at a time and drawn one by one
//! in stamps of 16 samples ([`stamps`]), those that are larger still are set up one by one ([`triangle`]). The fragments
//! of a cluster are shaded at once, those of triangles that were binned one by one when the tile is finished ([`shade`]).
//! At last, samples become pixels ([`resolve`]).

mod blend;
mod few;
mod finished;
mod fragments;
mod layers;
mod load;
pub mod memory;
mod nearest;
mod resolve;
mod scan;
mod shade;
mod sink;
mod stamps;
mod triangle;
mod write;

use fearless_simd::Simd;
use tercio_mesh::cluster::MAX_TRIANGLES;

use super::cluster::{Sieve, Size, SmallTriangles, prefetch_body, prefetch_head, project_and_sieve};
use super::order::DepthOrder;
use super::table::ClusterTable;
use super::{PREFETCH_DISTANCE, Shade};
use crate::backend::corners::Fragments;
use crate::backend::tally::Tally;
use crate::binning::{BinnedCluster, Bins};
use crate::context::FrameContext;
use crate::frame::{Canvas, CanvasTile, FinishedPart, FragmentError, FragmentsOfTile, Outputs, Planes};
use crate::projection::LocalVertices;
use crate::screen::ScreenTriangle;
use crate::settings::{LastStage, Part};
use crate::simd::part;
use crate::stats::BackEndCounts;
use few::{FEW, FewHits};
use finished::FinishedBlocks;
use memory::SampleMemory;
use scan::Hits;
use sink::{Opaque, Sink, Translucent};
use stamps::{Found, Lanes};

/// The memory that one thread needs to draw a tile with several samples per pixel.
#[derive(Debug, Default)]
pub struct Scratch {
    /// Depth and fragment of each sample.
    pub memory: SampleMemory,
    vertices: LocalVertices,
    sieve: Sieve,
    few: FewHits,
    hits: Hits,
    found: Found,
    table: ClusterTable,
    fragments: Fragments,
    blend_order: blend::Order,
    /// The fragments of the tile as bytes, if the frame keeps them.
    kept: Vec<u8>,
    finished: FinishedBlocks,
}

/// Draws a part of a tile's entries. Not inlined, so that it is compiled only once per SIMD level.
#[expect(clippy::too_many_arguments, reason = "a struct would only rename them")]
#[inline(never)]
pub fn draw<S: Simd, T: Tally>(
    simd: S,
    context: &FrameContext,
    bins: &[Bins],
    tile: u32,
    part: Part,
    shade: Shade,
    order: &mut DepthOrder,
    scratch: &mut Scratch,
    outputs: &Outputs,
    tally: &mut T,
) {
    simd.vectorize(
        #[inline(always)]
        || {
            scratch.memory.clear(context, tile);
            draw_entries::<S, T, Opaque>(
                simd, context, bins, tile, part, shade, order, scratch, outputs, tally,
            );
        },
    );
}

/// Draws the layers of a tile whose opaque triangles are drawn. Not inlined, so that it is compiled only once per SIMD
/// level.
#[expect(clippy::too_many_arguments, reason = "a struct would only rename them")]
#[inline(never)]
pub fn draw_layers<S: Simd, T: Tally>(
    simd: S,
    context: &FrameContext,
    bins: &[Bins],
    tile: u32,
    order: &mut DepthOrder,
    scratch: &mut Scratch,
    outputs: &Outputs,
    tally: &mut T,
) {
    let keeps = context.settings.keep_fragments;
    if !keeps {
        let SampleMemory { blended, rect, stride_bits, count_bits, .. } = &mut scratch.memory;
        let pixels = ((rect.y1 - rect.y0 + 1) as usize) << *stride_bits;
        blended.clear(pixels, *count_bits, resolve::has_geometry(outputs));
    }
    simd.vectorize(
        #[inline(always)]
        || loop {
            let (part, shade) = (Part::WHOLE, Shade::Immediate);
            draw_entries::<S, T, Translucent>(
                simd, context, bins, tile, part, shade, order, scratch, outputs, tally,
            );
            if context.settings.last_stage <= LastStage::Visibility {
                return;
            }
            shade::late_layers(simd, context, scratch, outputs, tally.counts());
            let Scratch { memory, blend_order, kept, .. } = &mut *scratch;
            let is_unfinished = if keeps {
                memory.layers.write_bytes(context, outputs, kept);
                true
            } else {
                blend::slice(simd, context, memory, blend_order);
                blend::is_unfinished(memory)
            };
            if !is_unfinished || !memory.layers.next_slice() {
                return;
            }
        },
    );
}

/// Draws a part of a tile's entries that a sink takes: triangles first, then clusters front to back.
#[expect(clippy::too_many_arguments, reason = "a struct would only rename them")]
#[inline(always)]
fn draw_entries<S: Simd, T: Tally, K: Sink>(
    simd: S,
    context: &FrameContext,
    bins: &[Bins],
    tile: u32,
    part: Part,
    shade: Shade,
    order: &mut DepthOrder,
    scratch: &mut Scratch,
    outputs: &Outputs,
    tally: &mut T,
) {
    let has_layers = context.is_translucent();
    let takes = |cluster: u32| (has_layers && context.has_translucency(cluster)) == K::LAYERS;
    let last = context.settings.last_stage;
    if last > LastStage::Sieve {
        let triangles = part.every(bins.iter().flat_map(|b| b.triangles_in(tile)));
        let triangles = triangles.filter(|t| takes(t.slot / MAX_TRIANGLES as u32));
        if K::LAYERS {
            draw_triangle_layers(simd, context, triangles, &mut scratch.memory, tally.counts());
        } else {
            for triangle in triangles {
                K::make_room(&mut scratch.memory, context);
                triangle::draw::<S, K>(simd, context, triangle, &mut scratch.memory, tally.counts());
            }
        }
    }
    K::list(&mut scratch.memory).all_are_late();
    let clusters = bins.iter().flat_map(|b| b.clusters_in(tile)).filter(|c| takes(c.number));
    order.front_to_back(part.every(clusters));
    draw_clusters::<S, T, K>(simd, context, order.clusters(), shade, scratch, outputs, tally);
}

/// Draws triangles as layers, approximately front to back: then few layers have to be sorted, and few are discarded if there
/// are too many.
fn draw_triangle_layers<'a, S: Simd>(
    simd: S,
    context: &FrameContext,
    triangles: impl Iterator<Item = &'a ScreenTriangle>,
    memory: &mut SampleMemory,
    counts: &mut BackEndCounts,
) {
    let triangles: Vec<&ScreenTriangle> = triangles.collect();
    // The pieces of a clipped triangle follow each other.
    let mut whole: Vec<&[&ScreenTriangle]> = triangles.chunk_by(|a, b| a.slot == b.slot).collect();
    let nearest = |pieces: &[&ScreenTriangle]| pieces.iter().flat_map(|t| t.d).fold(0.0, f32::max);
    whole.sort_by(|a, b| nearest(b).total_cmp(&nearest(a)));
    for pieces in whole {
        memory.layers.make_room(context);
        let before = memory.layers.list.count;
        if pieces.len() > 1 {
            memory.layers.begin_pieces();
        }
        for piece in pieces {
            triangle::draw::<S, Translucent>(simd, context, piece, memory, counts);
        }
        if pieces.len() > 1 {
            memory.layers.end_pieces(context, before);
        }
    }
}

/// Draws clusters that are sorted front to back, except hidden ones.
#[inline(always)]
fn draw_clusters<S: Simd, T: Tally, K: Sink>(
    simd: S,
    context: &FrameContext,
    clusters: &[BinnedCluster],
    shade: Shade,
    scratch: &mut Scratch,
    outputs: &Outputs,
    tally: &mut T,
) {
    // The results of the occlusion tests of the next clusters: a cluster that is already hidden stays hidden, and is
    // not prefetched.
    let mut hidden = [false; PREFETCH_DISTANCE];
    for (i, binned) in clusters.iter().enumerate() {
        if let Some(later) = clusters.get(i + 2 * PREFETCH_DISTANCE) {
            prefetch_head(context, later);
        }
        let was_hidden = hidden[i % PREFETCH_DISTANCE];
        if let Some(later) = clusters.get(i + PREFETCH_DISTANCE) {
            hidden[i % PREFETCH_DISTANCE] = is_hidden(simd, later, &mut scratch.memory);
            if !hidden[i % PREFETCH_DISTANCE] {
                prefetch_body(context, later);
            }
        }
        if was_hidden || is_hidden(simd, binned, &mut scratch.memory) {
            tally.counts().clusters_hidden += 1;
            continue;
        }
        tally.counts().clusters_drawn += 1;
        K::make_room(&mut scratch.memory, context);
        K::list(&mut scratch.memory).begin_cluster();
        draw_cluster::<S, T, K>(simd, context, binned, scratch, tally);
        if shade == Shade::Deferred {
            K::list(&mut scratch.memory).all_are_late();
        } else if context.settings.last_stage > LastStage::Visibility {
            shade::cluster::<S, K>(simd, context, binned.number, scratch, outputs, tally.counts());
        }
    }
}

/// Occlusion test: is everything drawn in a cluster's part of a tile nearer than the cluster can be?
#[inline(always)]
fn is_hidden<S: Simd>(simd: S, binned: &BinnedCluster, memory: &mut SampleMemory) -> bool {
    let rect = binned.pixels().intersect(memory.rect);
    part(
        simd,
        #[inline(always)]
        || memory.all_nearer(simd, rect, binned.nearest),
    )
}

/// Draws a cluster: adds its fragments to the tile's.
#[inline(always)]
fn draw_cluster<S: Simd, T: Tally, K: Sink>(
    simd: S,
    context: &FrameContext,
    binned: &BinnedCluster,
    scratch: &mut Scratch,
    tally: &mut T,
) {
    let Scratch { memory, vertices, sieve, few, hits, found, .. } = scratch;
    let first_slot = binned.number * MAX_TRIANGLES as u32;
    let origin = context.cells.origin;
    let corners =
        &project_and_sieve(simd, context, binned.number, memory.rect, origin, vertices, sieve, tally);
    let counts = tally.counts();
    if context.settings.last_stage == LastStage::Sieve {
        return;
    }
    for size in Size::ALL {
        for (numbers, lanes) in sieve.of_size(size) {
            K::make_room(memory, context);
            if size != Size::Huge {
                let of = &corners.look_up(simd, numbers);
                let triangles = SmallTriangles::new(simd, vertices, of, &context.cells, memory.rect);
                let is_small = matches!(size, Size::Tiny | Size::Small);
                let (is_few, stride_bits) = (context.cells.count <= FEW, memory.stride_bits);
                let one_by_one = match is_small {
                    true if is_few => lanes & few::beyond(simd, &triangles),
                    true => 0,
                    false => lanes,
                };
                if is_small && is_few {
                    let (lanes, is_tiny) = (lanes & !one_by_one, size == Size::Tiny);
                    few.scan(simd, &context.cells, &triangles, lanes, is_tiny, stride_bits);
                    few.test::<S, K>(simd, context, &triangles, first_slot, numbers, memory, counts);
                } else if is_small {
                    hits.scan(simd, &context.cells, &triangles, lanes, stride_bits);
                    hits.test::<S, K>(simd, context, &triangles, first_slot, numbers, memory, counts);
                }
                if one_by_one != 0 {
                    let unpacked = Lanes::new(simd, &triangles);
                    unpacked
                        .draw::<S, K>(simd, context, one_by_one, first_slot, numbers, found, memory, counts);
                }
                continue;
            }
            for &number in &numbers[..lanes.count_ones() as usize] {
                let v = corners.of(number).map(|corner| vertices.vertex(corner));
                let triangle = ScreenTriangle::new(v, first_slot + u32::from(number));
                // A triangle without area covers nothing, and its edge functions are not defined.
                if triangle.area() != 0 {
                    triangle::draw::<S, K>(simd, context, &triangle, memory, counts);
                }
            }
        }
    }
}

/// Shades what is not shaded yet, and writes the tile to the picture.
#[inline(always)]
pub fn finish<S: Simd, T: Tally>(
    simd: S,
    context: &FrameContext,
    scratch: &mut Scratch,
    mut target: CanvasTile,
    pixels: &mut Planes,
    outputs: &Outputs,
    tally: &mut T,
) {
    if context.settings.last_stage <= LastStage::Visibility {
        tally.counts().pixels_visible += visible(simd, &scratch.memory);
        target.write_background();
        return;
    }
    shade::late_fragments(simd, context, scratch, outputs, tally.counts());
    if context.settings.keep_fragments {
        let Scratch { memory, kept, finished, .. } = scratch;
        let hides = finished.find(simd, context, memory, target.number(), outputs, kept);
        tally.counts().pixels_visible += visible(simd, memory);
        memory.write_bytes(context, outputs, finished, kept);
        let bytes = if context.is_translucent() {
            // There may be many layers: they are not copied.
            std::mem::take(kept)
        } else {
            let bytes = kept.as_slice().into();
            kept.clear();
            bytes
        };
        let mut part = FinishedPart { pixels: 0, hides };
        if finished.any() {
            finished.retain(memory);
            part.pixels = write(simd, context, memory, &mut target, false, pixels, outputs);
        } else if context.others_in(target.number()).is_some() {
            target.write_background();
        }
        target.keep(part, bytes);
        return;
    }
    tally.counts().pixels_visible +=
        write(simd, context, &scratch.memory, &mut target, false, pixels, outputs);
}

/// Number of pixels of the tile in which something is drawn. Not inlined, so that it is compiled only once per SIMD level.
#[inline(never)]
fn visible<S: Simd>(simd: S, memory: &SampleMemory) -> u64 {
    simd.vectorize(
        #[inline(always)]
        || memory.visible(simd),
    )
}

/// Writes a tile from the fragments of several ranks to the picture, and returns the number of pixels in which something is
/// drawn.
///
/// # Errors
/// [`FragmentError`]; nothing is written then.
pub fn merge<S: Simd>(
    simd: S,
    context: &FrameContext,
    tile: &FragmentsOfTile,
    scratch: &mut Scratch,
    canvas: &Canvas,
    pixels: &mut Planes,
) -> Result<u64, FragmentError> {
    let outputs = canvas.outputs();
    let Scratch { memory, blend_order, .. } = &mut *scratch;
    if tile.parts.is_empty() {
        if !tile.has_finished {
            canvas.claim(tile.tile).write_background();
        }
        return Ok(0);
    }
    memory.load(context, tile)?;
    if context.is_translucent() {
        let pixels = ((memory.rect.y1 - memory.rect.y0 + 1) as usize) << memory.stride_bits;
        memory.blended.clear(pixels, memory.count_bits, resolve::has_geometry(outputs));
        simd.vectorize(
            #[inline(always)]
            || blend::slice(simd, context, memory, blend_order),
        );
    }
    Ok(write(simd, context, memory, &mut canvas.claim(tile.tile), tile.has_finished, pixels, outputs))
}

/// Writes a tile, whose fragments are shaded and blended, to the picture, and returns the number of pixels in which something
/// is drawn. The others get the background, or, if the tile `has_finished` ones, keep their values.
fn write<S: Simd>(
    simd: S,
    context: &FrameContext,
    memory: &SampleMemory,
    target: &mut CanvasTile,
    has_finished: bool,
    pixels: &mut Planes,
    outputs: &Outputs,
) -> u64 {
    let stride = (1 << context.grid.shift) * context.settings.elements_per_pixel() as usize;
    target.clear(pixels, stride);
    if has_finished {
        target.read(pixels, stride);
    }
    let background = target.background();
    let drawn = resolve::tile(simd, context, memory, background, stride, pixels, outputs);
    target.write(pixels, stride);
    drawn.unwrap_or_else(|| visible(simd, memory))
}
