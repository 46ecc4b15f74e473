//! Shading of the visible pixels, 16 at a time.
//!
//! For the winners of a cluster, the corners of their triangles are looked up in the cluster's tables ([`winners`]).
//! The visible pixels of triangles that were binned one by one are packed into full groups of 16 ([`tile`]); the
//! corners of their triangles are fetched from the mesh, and projected again as in the front end. Both use the same
//! `kernel`, which is compiled for any look, and specialized for the most common ones (`features`). Lines along the sides of triangles
//! are drawn over what is shaded ([`super::edges`]).

mod features;
mod kernel;
mod target;

use fearless_simd::prelude::*;
use fearless_simd::{Simd, u32x16};
use tercio_mesh::cluster::{ClusterView, MAX_TRIANGLES};

use super::cluster::ClusterPass;
use super::corners::{ColorSource, Colored, Corners, Fragments, numbers_for_edges};
use super::material::has_materials;
use super::memory::TileMemory;
use super::table::ClusterTable;
use crate::backend::tally::Tally;
use crate::context::{FrameContext, NO_SLOT};
use crate::frame::{Outputs, Planes};
use crate::projection::CornerTable;
use crate::simd::{LANES, has_wide_registers};
use crate::stats::BackEndCounts;
pub use features::{Common, Explained, Features, Look, needs_plane};
pub use kernel::{At, Facing, seen_plane, shade, shade_inline, to_eye};
use target::PixelTarget;
pub use target::{FragmentTarget, Target, displayable, displayable_of};

/// Shades every visible pixel of a tile that is not shaded yet.
#[inline(always)]
pub fn tile<S: Simd, T: Tally>(
    simd: S,
    context: &FrameContext,
    memory: &TileMemory,
    pixels: &mut Planes,
    outputs: &Outputs,
    tally: &mut T,
) {
    let mut fragments = Fragments::default();
    let mut instance = 0;
    let mut whole = WholeBlocks::new(simd);
    for places in memory.blocks(simd) {
        let corner = places[0];
        let slots = memory.slots_of_block(simd, corner);
        let empty = slots.simd_eq(u32x16::splat(simd, NO_SLOT)).to_bitmask() as u32;
        let mut left = !(empty | memory.shaded_of_block(corner)) & 0xffff;
        let slots = slots.to_array();
        if left == 0xffff && slots == [slots[0]; LANES] {
            whole.shade(simd, context, memory, places, slots[0], pixels, outputs);
            tally.counts().pixels_shaded += LANES as u64;
            if let Some(full) = tally.full() {
                full.late(context, whole.instance, LANES as u64, true);
            }
            continue;
        }
        while left != 0 {
            let lane = left.trailing_zeros() as usize % LANES;
            left &= left - 1;
            let (slot, place) = (slots[lane], places[lane]);
            tally.counts().pixels_shaded += 1;
            let (own, _) = context.locate(slot / MAX_TRIANGLES as u32);
            if let Some(full) = tally.full() {
                full.late(context, own, 1, false);
            }
            if own != instance {
                flush(simd, context, instance, &mut fragments, memory, pixels, outputs);
                instance = own;
            }
            if fragments.push(place, slot, memory.depth[place as usize]) {
                flush(simd, context, instance, &mut fragments, memory, pixels, outputs);
            }
        }
    }
    flush(simd, context, instance, &mut fragments, memory, pixels, outputs);
}

/// Shades blocks of 4x4 samples that show a single triangle. Large triangles have many such blocks in sequence, for
/// which the corners are fetched once.
struct WholeBlocks<S: Simd> {
    slot: Option<u32>,
    instance: usize,
    corners: Corners<S>,
}

impl<S: Simd> WholeBlocks<S> {
    #[inline(always)]
    fn new(simd: S) -> Self {
        Self { slot: None, instance: 0, corners: Corners::new(simd) }
    }

    /// Shades a block, given by its sample indices.
    #[expect(clippy::too_many_arguments, reason = "one call site; a struct would only rename them")]
    #[inline(always)]
    fn shade(
        &mut self,
        simd: S,
        context: &FrameContext,
        memory: &TileMemory,
        places: [i32; LANES],
        slot: u32,
        pixels: &mut Planes,
        outputs: &Outputs,
    ) {
        let mut fragments = Fragments {
            count: LANES,
            place: places,
            slot: [slot; LANES],
            is_block: true,
            ..Fragments::default()
        };
        if self.slot != Some(slot) {
            self.slot = Some(slot);
            (self.instance, _) = context.locate(slot / MAX_TRIANGLES as u32);
            self.corners = fetch(simd, context, self.instance, &fragments);
        }
        let look = Look::new(context, self.instance, self.corners.normals_agree, outputs);
        if look.more() {
            for lane in 0..LANES {
                fragments.depth[lane] = memory.depth[places[lane] as usize];
            }
        }
        let at = At::in_picture(context, memory.stride_bits(), memory.corner);
        let target = &mut PixelTarget { pixels, outputs };
        late(simd, context, self.instance, look, &fragments, at, &self.corners, target);
    }
}

/// Shades 16 pixels whose corners have been fetched, with the kernel for their look.
#[expect(clippy::too_many_arguments, reason = "a struct would only rename them")]
#[inline(always)]
pub fn late<S: Simd, T: Target>(
    simd: S,
    context: &FrameContext,
    instance: usize,
    look: Look,
    fragments: &Fragments,
    at: At,
    corners: &Corners<S>,
    target: &mut T,
) {
    if look.is(Common::<true>) {
        shade(simd, context, instance, Common::<true>, fragments, at, corners, target);
    } else {
        shade(simd, context, instance, look, fragments, at, corners, target);
    }
}

/// Fetches the corners of 16 pixels of one instance. Not inlined, so that it is compiled only once per SIMD level.
#[inline(never)]
pub fn fetch<S: Simd>(simd: S, context: &FrameContext, instance: usize, fragments: &Fragments) -> Corners<S> {
    simd.vectorize(
        #[inline(always)]
        || Corners::fetch(simd, context, instance, &fragments.slot),
    )
}

/// Shades the pixels gathered so far. Not inlined, so that the kernel is compiled once per SIMD level, not three times.
#[inline(never)]
fn flush<S: Simd>(
    simd: S,
    context: &FrameContext,
    instance: usize,
    fragments: &mut Fragments,
    memory: &TileMemory,
    pixels: &mut Planes,
    outputs: &Outputs,
) {
    if fragments.count == 0 {
        return;
    }
    fragments.fill_up();
    let corners = fetch(simd, context, instance, fragments);
    let look = Look::new(context, instance, corners.normals_agree, outputs);
    let at = At::in_picture(context, memory.stride_bits(), memory.corner);
    late(simd, context, instance, look, fragments, at, &corners, &mut PixelTarget { pixels, outputs });
    fragments.count = 0;
}

/// The memory of [`winners`], reused from cluster to cluster.
#[derive(Debug, Default)]
pub struct WinnerScratch {
    table: ClusterTable,
    fragments: Fragments,
}

/// A cluster whose winners are being shaded.
struct Won<'a> {
    context: &'a FrameContext<'a>,
    number: u32,
    instance: usize,
    cluster: ClusterView<'a>,
    colored: Colored<'a>,
    memory: &'a TileMemory,
    at: At,
}

/// Shades the samples that cluster `number` of the frame won.
#[expect(clippy::too_many_arguments, reason = "one call site; a struct would only rename them")]
#[inline(never)]
pub fn winners<S: Simd>(
    simd: S,
    context: &FrameContext,
    number: u32,
    pass: &mut ClusterPass,
    memory: &TileMemory,
    scratch: &mut WinnerScratch,
    pixels: &mut Planes,
    outputs: &Outputs,
    counts: &mut BackEndCounts,
) {
    if pass.winners.is_empty() {
        return;
    }
    simd.vectorize(
        #[inline(always)]
        || {
            let (instance, cluster) = context.cluster(number);
            let look = Look::new(context, instance, cluster.head().normals_agree(), outputs);
            let table = &mut scratch.table;
            table.load_normals(simd, context, &context.objects[instance], &cluster, &pass.vertices);
            if look.position() {
                table.load_positions(simd, &cluster);
            }
            let colored = Colored::new(context, number);
            table.load_colors(&colored, look.colors());
            if look.materials() {
                table.load_texcoords(simd, &cluster);
            }
            counts.pixels_shaded += pass.winners.len() as u64;
            let at = At {
                stride_bits: memory.stride_bits(),
                first_sample: pass.vertices.sample_of(memory.corner),
                from_middle: pass.vertices.offset_from_middle(&context.lights.sight),
                facing: table.facing,
            };
            let won = Won { context, number, instance, cluster, colored, memory, at };
            let is_common = !pass.vertices.has_wide_triangles;
            if is_common && look.is(Common::<true>) {
                won.shade(simd, Common::<true>, pass, scratch, pixels, outputs);
            } else if is_common && look.is(Common::<false>) {
                won.shade(simd, Common::<false>, pass, scratch, pixels, outputs);
            } else if is_common
                && has_wide_registers(simd)
                && let Some(features) = Explained::of(look, context, instance)
            {
                won.shade_explained(simd, features, pass, scratch, pixels, outputs);
            } else {
                won.shade(simd, look, pass, scratch, pixels, outputs);
            }
        },
    );
}

impl Won<'_> {
    /// Not inlined, so that the kernels of pictures without data and edges stay small.
    #[inline(never)]
    fn shade_explained<S: Simd>(
        &self,
        simd: S,
        features: Explained,
        pass: &mut ClusterPass,
        scratch: &mut WinnerScratch,
        pixels: &mut Planes,
        outputs: &Outputs,
    ) {
        simd.vectorize(
            #[inline(always)]
            || self.shade(simd, features, pass, scratch, pixels, outputs),
        );
    }

    #[inline(always)]
    fn shade<S: Simd, F: Features>(
        &self,
        simd: S,
        features: F,
        pass: &mut ClusterPass,
        scratch: &mut WinnerScratch,
        pixels: &mut Planes,
        outputs: &Outputs,
    ) {
        let WinnerScratch { table, fragments } = scratch;
        let scene_instance = &self.context.scene.instances[self.instance];
        let corner_table = CornerTable::new(&self.cluster);
        let count = pass.winners.len();
        for first in (0..count).step_by(LANES) {
            let (places, triangles) = pass.winners.sixteen(first);
            fragments.count = (count - first).min(LANES);
            fragments.place = places;
            let (numbers, mut corners) = table.look_up(simd, &pass.vertices, &corner_table, &triangles);
            if features.position() {
                table.look_up_positions(simd, &numbers, &mut corners);
            }
            if features.colors() != ColorSource::Base {
                let of = &self.colored;
                table.look_up_colors(simd, of, &triangles, &numbers, features.colors(), &mut corners);
            }
            if features.materials() && has_materials(scene_instance) {
                let cluster = &self.cluster;
                table.look_up_materials(simd, scene_instance, cluster, &triangles, &numbers, &mut corners);
            }
            if features.more() {
                for lane in 0..LANES {
                    fragments.slot[lane] = self.number * MAX_TRIANGLES as u32 + u32::from(triangles[lane]);
                    fragments.depth[lane] = self.memory.depth[places[lane] as usize];
                }
            }
            if features.edges() {
                corners.numbers = numbers_for_edges(&self.cluster, scene_instance, &triangles);
            }
            let (context, instance, at) = (self.context, self.instance, self.at);
            let target = &mut PixelTarget { pixels, outputs };
            if F::ARE_SPECIAL {
                // Here, the specialized kernels are used only for clusters whose triangles are not wide.
                corners.are_near = true;
                shade_inline(simd, context, instance, features, fragments, at, &corners, target);
            } else {
                let look = Look::describe(features);
                shade(simd, context, instance, look, fragments, at, &corners, target);
            }
        }
    }
}
