//! Shades the fragments of a tile, 16 at a time.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, i32x16};
use tercio_mesh::cluster::{ClusterView, MAX_TRIANGLES};
use tercio_scene::Surface;

use super::Scratch;
use super::fragments::FragmentList;
use super::sink::{Opaque, Sink, Translucent};
use crate::backend::corners::{ColorSource, Colored, Corners, Fragments, numbers_for_edges};
use crate::backend::material::has_materials;
use crate::backend::shade::{
    At, Common, Explained, Features, FragmentTarget, Look, displayable_of, fetch, late, shade, shade_inline,
};
use crate::context::FrameContext;
use crate::frame::Outputs;
use crate::projection::CornerTable;
use crate::simd::{LANES, has_wide_registers, part};
use crate::stats::BackEndCounts;

/// Is any plane requested for which fragments are shaded?
pub fn is_needed(outputs: &Outputs) -> bool {
    outputs.color || outputs.color16 || outputs.linear || outputs.normals
}

/// The planes that determine the look of a fragment.
fn planes(outputs: &Outputs) -> Outputs {
    Outputs { color: true, normals: outputs.normals, ..Outputs::NONE }
}

/// Shades the fragments of the cluster that was drawn last, cluster `number` of the frame. Not inlined, so that the kernels
/// are compiled only once per SIMD level.
#[inline(never)]
pub fn cluster<S: Simd, K: Sink>(
    simd: S,
    context: &FrameContext,
    number: u32,
    scratch: &mut Scratch,
    outputs: &Outputs,
    counts: &mut BackEndCounts,
) {
    let list = K::list(&mut scratch.memory);
    let first = list.of_cluster;
    // The opacity of layers is needed for every plane.
    if list.count == first || !is_needed(outputs) && !K::LAYERS {
        return;
    }
    simd.vectorize(
        #[inline(always)]
        || {
            let Scratch { memory, vertices, table, .. } = &mut *scratch;
            let (instance, cluster) = context.cluster(number);
            let look = Look::new(context, instance, cluster.head().normals_agree(), &planes(outputs));
            if look.is_uniform() && !outputs.normals {
                let list = K::list(memory);
                counts.pixels_shaded += (list.count - first) as u64;
                list.resize_shaded(false);
                let surface = &context.scene.instances[instance].surface;
                list.colors[first..list.count].fill(uniform(surface));
                return;
            }
            table.load_normals(simd, context, &context.objects[instance], &cluster, vertices);
            if look.position() {
                table.load_positions(simd, &cluster);
            }
            let colored = Colored::new(context, number);
            table.load_colors(&colored, look.colors());
            if look.materials() {
                table.load_texcoords(simd, &cluster);
            }
            counts.pixels_shaded += (K::list(memory).count - first) as u64;
            let at = At {
                stride_bits: memory.stride_bits,
                first_sample: vertices.sample_of([memory.rect.x0, memory.rect.y0]),
                from_middle: vertices.offset_from_middle(&context.lights.sight),
                facing: table.facing,
            };
            let work = ClusterFragments { context, instance, cluster, colored, at, first };
            if !vertices.has_wide_triangles && look.is(Common::<true>) {
                work.shade::<S, K, _>(simd, Common::<true>, scratch, outputs);
            } else if !K::LAYERS
                && has_wide_registers(simd)
                && !vertices.has_wide_triangles
                && let Some(features) = Explained::of(look, context, instance)
            {
                // Lines and data on surfaces that are not opaque are rare.
                work.shade_explained(simd, features, scratch, outputs);
            } else {
                work.shade::<S, K, _>(simd, look, scratch, outputs);
            }
        },
    );
}

/// What a [`FragmentTarget`] gets of an unlit surface of one colour.
fn uniform(surface: &Surface) -> [f32; 4] {
    let [r, g, b] = surface.base_color.map(displayable_of);
    if surface.opacity < 1.0 {
        let opacity = surface.opacity;
        return [r * opacity, g * opacity, b * opacity, opacity];
    }
    [r, g, b, 1.0]
}

/// The fragments of a cluster that are being shaded.
struct ClusterFragments<'a> {
    context: &'a FrameContext<'a>,
    instance: usize,
    cluster: ClusterView<'a>,
    colored: Colored<'a>,
    at: At,
    first: usize,
}

impl ClusterFragments<'_> {
    /// Not inlined, so that the kernels of pictures without data and edges stay small.
    #[inline(never)]
    fn shade_explained<S: Simd>(
        &self,
        simd: S,
        features: Explained,
        scratch: &mut Scratch,
        outputs: &Outputs,
    ) {
        simd.vectorize(
            #[inline(always)]
            || self.shade::<S, Opaque, _>(simd, features, scratch, outputs),
        );
    }

    #[inline(always)]
    fn shade<S: Simd, K: Sink, F: Features>(
        &self,
        simd: S,
        features: F,
        scratch: &mut Scratch,
        outputs: &Outputs,
    ) {
        let Scratch { memory, vertices, table, fragments, .. } = scratch;
        let list = K::list(memory);
        let (context, instance, at) = (self.context, self.instance, self.at);
        let scene_instance = &context.scene.instances[instance];
        let surface = &scene_instance.surface;
        let corner_table = CornerTable::new(&self.cluster);
        let count = list.count;
        list.resize_shaded(outputs.normals);
        for first in (self.first..count).step_by(LANES) {
            let last = (first + LANES).min(count);
            fragments.count = last - first;
            let triangles = gather_sixteen(simd, context, list, first, fragments);
            let (numbers, mut corners) = table.look_up(simd, vertices, &corner_table, &triangles);
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
            if features.edges() {
                corners.numbers = numbers_for_edges(&self.cluster, scene_instance, &triangles);
            }
            let normals = if outputs.normals { &mut list.normals[first..last] } else { &mut [] };
            let Some(colors) = list.colors[first..].first_chunk_mut() else { unreachable!("room was made") };
            let target = &mut FragmentTarget { colors, normals, opacity: surface.opacity };
            if F::ARE_SPECIAL {
                // The specialized kernel is used only for clusters whose triangles are not wide.
                corners.are_near = true;
                shade_inline(simd, context, instance, features, fragments, at, &corners, target);
            } else {
                let look = Look::describe(features);
                shade(simd, context, instance, look, fragments, at, &corners, target);
            }
        }
    }
}

/// Sets the points of all lanes to those of the fragments from number `first` on, and returns the numbers of their triangles
/// in the cluster.
#[inline(always)]
fn gather_sixteen<S: Simd>(
    simd: S,
    context: &FrameContext,
    list: &FragmentList,
    first: usize,
    fragments: &mut Fragments,
) -> [u8; LANES] {
    let [slot, place] = part(
        simd,
        #[inline(always)]
        || list.sixteen(simd, first),
    );
    let places: i32x16<S> = (place & 0xffff).bitcast();
    places.store_slice(&mut fragments.place);
    let from_middle = context.centers.of_sixteen(simd, (place >> 16).bitcast());
    from_middle[0].store_slice(&mut fragments.from_middle[0]);
    from_middle[1].store_slice(&mut fragments.from_middle[1]);
    let (mut triangles, slots) = ([0; LANES], slot.to_array());
    for lane in 0..LANES {
        triangles[lane] = (slots[lane] % MAX_TRIANGLES as u32) as u8;
    }
    triangles
}

/// Sets the point of a lane to that of a fragment.
#[inline(always)]
fn gather(
    context: &FrameContext,
    list: &FragmentList,
    number: usize,
    lane: usize,
    fragments: &mut Fragments,
) {
    let fragment = list.fragments[number];
    fragments.place[lane] = i32::from(fragment.pixel);
    let [x, y] = context.centers.from_middle(fragment.covered);
    fragments.from_middle[0][lane] = x;
    fragments.from_middle[1][lane] = y;
}

/// Shades the visible ones of the opaque fragments that were not shaded with a cluster.
pub fn late_fragments<S: Simd>(
    simd: S,
    context: &FrameContext,
    scratch: &mut Scratch,
    outputs: &Outputs,
    counts: &mut BackEndCounts,
) {
    if scratch.memory.list.late == 0 || !is_needed(outputs) {
        return;
    }
    let late = scratch.memory.list.late;
    let is_visible = simd.vectorize(
        #[inline(always)]
        || scratch.memory.visible_fragments(simd, late),
    );
    let visible = (0..late).filter(|&number| is_visible[number]);
    late_some::<S, Opaque>(simd, context, visible, scratch, outputs, counts);
}

/// Shades the layers that were not shaded with a cluster.
pub fn late_layers<S: Simd>(
    simd: S,
    context: &FrameContext,
    scratch: &mut Scratch,
    outputs: &Outputs,
    counts: &mut BackEndCounts,
) {
    let late = 0..scratch.memory.layers.list.late;
    late_some::<S, Translucent>(simd, context, late, scratch, outputs, counts);
}

/// Shades some of the fragments that were not shaded with a cluster.
fn late_some<S: Simd, K: Sink>(
    simd: S,
    context: &FrameContext,
    some: impl Iterator<Item = usize>,
    scratch: &mut Scratch,
    outputs: &Outputs,
    counts: &mut BackEndCounts,
) {
    let Scratch { memory, fragments, .. } = scratch;
    let at = At::in_picture(context, memory.stride_bits, [memory.rect.x0, memory.rect.y0]);
    let list = K::list(memory);
    list.resize_shaded(outputs.normals);
    let (mut numbers, mut count, mut instance) = ([0; LANES], 0, 0);
    let mut known = Known { slot: None, corners: Corners::new(simd) };
    for number in some {
        let slot = list.fragments[number].slot;
        let (own, _) = context.locate(slot / MAX_TRIANGLES as u32);
        if own != instance || count == LANES {
            late_sixteen(
                simd,
                context,
                instance,
                &numbers[..count],
                at,
                list,
                fragments,
                &mut known,
                outputs,
            );
            (instance, count) = (own, 0);
        }
        numbers[count] = number;
        count += 1;
        counts.pixels_shaded += 1;
    }
    late_sixteen(simd, context, instance, &numbers[..count], at, list, fragments, &mut known, outputs);
}

/// The corners of the last fragments, if these were all of one triangle: large triangles have many in sequence.
struct Known<S: Simd> {
    slot: Option<u32>,
    corners: Corners<S>,
}

/// Shades at most 16 fragments of one instance. Not inlined, so that it is compiled only once per SIMD level.
#[expect(clippy::too_many_arguments, reason = "one caller; a struct would only rename them")]
#[inline(never)]
fn late_sixteen<S: Simd>(
    simd: S,
    context: &FrameContext,
    instance: usize,
    numbers: &[usize],
    at: At,
    list: &mut FragmentList,
    fragments: &mut Fragments,
    known: &mut Known<S>,
    outputs: &Outputs,
) {
    let Some(&last) = numbers.last() else { return };
    fragments.count = numbers.len();
    for lane in 0..LANES {
        let number = numbers.get(lane).copied().unwrap_or(last);
        gather(context, list, number, lane, fragments);
        fragments.slot[lane] = list.fragments[number].slot;
    }
    let first = fragments.slot[0];
    if known.slot != Some(first) || fragments.slot != [first; LANES] {
        known.corners = fetch(simd, context, instance, fragments);
        known.slot = (fragments.slot == [first; LANES]).then_some(first);
    }
    let corners = &known.corners;
    let look = Look::new(context, instance, corners.normals_agree, &planes(outputs));
    let (mut colors, mut normals) = ([[0.0; 4]; LANES], [[0.0; 3]; LANES]);
    let wanted: &mut [[f32; 3]] = if outputs.normals { &mut normals } else { &mut [] };
    let opacity = context.scene.instances[instance].surface.opacity;
    let mut target = FragmentTarget { colors: &mut colors, normals: wanted, opacity };
    late(simd, context, instance, look, fragments, at, corners, &mut target);
    for (lane, &number) in numbers.iter().enumerate() {
        list.colors[number] = colors[lane];
        if outputs.normals {
            list.normals[number] = normals[lane];
        }
    }
}
