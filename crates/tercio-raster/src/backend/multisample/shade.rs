//! Shades the fragments of a tile, 16 at a time.

use fearless_simd::Simd;
use tercio_mesh::cluster::{ClusterView, MAX_TRIANGLES};
use tercio_scene::Instance;

use super::Scratch;
use super::memory::SampleMemory;
use crate::backend::corners::{ColorSource, Fragments};
use crate::backend::shade::{At, Common, Features, FragmentTarget, Look, fetch, late, shade, shade_inline};
use crate::context::FrameContext;
use crate::frame::Outputs;
use crate::projection::CornerTable;
use crate::simd::LANES;
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
pub fn cluster<S: Simd>(
    simd: S,
    context: &FrameContext,
    number: u32,
    scratch: &mut Scratch,
    outputs: &Outputs,
    counts: &mut BackEndCounts,
) {
    let first = scratch.memory.of_cluster;
    if scratch.memory.count() == first || !is_needed(outputs) {
        return;
    }
    simd.vectorize(
        #[inline(always)]
        || {
            let Scratch { memory, vertices, table, .. } = &mut *scratch;
            let (instance, cluster) = context.cluster(number);
            let look = Look::new(context, instance, cluster.head().normals_agree(), &planes(outputs));
            table.load_normals(simd, context, &context.objects[instance], &cluster, vertices);
            if look.position() {
                table.load_positions(simd, &cluster);
            }
            if look.colors() == ColorSource::Vertex {
                table.load_colors(&cluster);
            }
            counts.pixels_shaded += (memory.count() - first) as u64;
            let at = At {
                stride_bits: memory.stride_bits,
                first_sample: vertices.sample_of([memory.rect.x0, memory.rect.y0]),
                from_middle: vertices.offset_from_middle(&context.lights.sight),
                facing: table.facing,
            };
            let work = ClusterFragments { context, number, instance, cluster, at, first };
            if !vertices.is_wide && look.is(Common::<true>) {
                work.shade(simd, Common::<true>, scratch, outputs);
            } else {
                work.shade(simd, look, scratch, outputs);
            }
        },
    );
}

/// The fragments of a cluster that are being shaded.
struct ClusterFragments<'a> {
    context: &'a FrameContext<'a>,
    number: u32,
    instance: usize,
    cluster: ClusterView<'a>,
    at: At,
    first: usize,
}

impl ClusterFragments<'_> {
    #[inline(always)]
    fn shade<S: Simd, F: Features>(&self, simd: S, features: F, scratch: &mut Scratch, outputs: &Outputs) {
        let Scratch { memory, vertices, table, fragments, .. } = scratch;
        let (context, instance, at) = (self.context, self.instance, self.at);
        let Instance { mesh, surface, .. } = &context.scene.instances[instance];
        let corner_table = CornerTable::new(&self.cluster);
        let count = memory.count();
        memory.colors.resize(count.max(memory.colors.len()), [0.0; 4]);
        if outputs.normals {
            memory.normals.resize(count.max(memory.normals.len()), [0.0; 3]);
        }
        for first in (self.first..count).step_by(LANES) {
            let last = (first + LANES).min(count);
            fragments.count = last - first;
            let mut triangles = [0; LANES];
            for (lane, triangle) in triangles.iter_mut().enumerate() {
                let number = (first + lane).min(last - 1);
                gather(context, memory, number, lane, fragments);
                *triangle = (memory.fragments[number].slot - self.number * MAX_TRIANGLES as u32) as u8;
            }
            let (numbers, mut corners) = table.look_up(simd, vertices, &corner_table, &triangles);
            if features.position() {
                table.look_up_positions(simd, &numbers, &mut corners);
            }
            if features.colors() != ColorSource::Base {
                let of = (&**mesh, &self.cluster, surface);
                table.look_up_colors(simd, of, &triangles, &numbers, features.colors(), &mut corners);
            }
            let normals = if outputs.normals { &mut memory.normals[first..last] } else { &mut [] };
            let target = &mut FragmentTarget { colors: &mut memory.colors[first..last], normals };
            if F::ARE_CONSTANT {
                // The specialized kernel is used only for clusters that are not wide.
                corners.are_near = true;
                shade_inline(simd, context, instance, features, fragments, at, &corners, target);
            } else {
                let look = Look::describe(features);
                shade(simd, context, instance, look, fragments, at, &corners, target);
            }
        }
    }
}

/// Sets the point of a lane to that of a fragment.
#[inline(always)]
fn gather(
    context: &FrameContext,
    memory: &SampleMemory,
    number: usize,
    lane: usize,
    fragments: &mut Fragments,
) {
    let fragment = memory.fragments[number];
    fragments.place[lane] = i32::from(fragment.pixel);
    let [x, y] = context.centers.from_middle(fragment.covered);
    fragments.from_middle[0][lane] = x;
    fragments.from_middle[1][lane] = y;
}

/// Shades the visible ones of the fragments that were not shaded with a cluster.
pub fn late_fragments<S: Simd>(
    simd: S,
    context: &FrameContext,
    scratch: &mut Scratch,
    outputs: &Outputs,
    counts: &mut BackEndCounts,
) {
    let Scratch { memory, fragments, .. } = scratch;
    if memory.late == 0 || !is_needed(outputs) {
        return;
    }
    memory.colors.resize(memory.count().max(memory.colors.len()), [0.0; 4]);
    if outputs.normals {
        memory.normals.resize(memory.count().max(memory.normals.len()), [0.0; 3]);
    }
    let is_visible = memory.visible_fragments();
    let (mut numbers, mut count, mut instance) = ([0; LANES], 0, 0);
    for number in (0..memory.late).filter(|&number| is_visible[number]) {
        let slot = memory.fragments[number].slot;
        let (own, _) = context.locate(slot / MAX_TRIANGLES as u32);
        if own != instance || count == LANES {
            late_sixteen(simd, context, instance, &numbers[..count], memory, fragments, outputs);
            (instance, count) = (own, 0);
        }
        numbers[count] = number;
        count += 1;
        counts.pixels_shaded += 1;
    }
    late_sixteen(simd, context, instance, &numbers[..count], memory, fragments, outputs);
}

/// Shades at most 16 fragments of one instance. Not inlined, so that it is compiled only once per SIMD level.
#[inline(never)]
fn late_sixteen<S: Simd>(
    simd: S,
    context: &FrameContext,
    instance: usize,
    numbers: &[usize],
    memory: &mut SampleMemory,
    fragments: &mut Fragments,
    outputs: &Outputs,
) {
    let Some(&last) = numbers.last() else { return };
    fragments.count = numbers.len();
    for lane in 0..LANES {
        let number = numbers.get(lane).copied().unwrap_or(last);
        gather(context, memory, number, lane, fragments);
        fragments.slot[lane] = memory.fragments[number].slot;
    }
    let corners = fetch(simd, context, instance, fragments);
    let look = Look::new(context, instance, corners.normals_agree, &planes(outputs));
    let at = At::in_picture(context, memory.stride_bits, [memory.rect.x0, memory.rect.y0]);
    let (mut colors, mut normals) = ([[0.0; 4]; LANES], [[0.0; 3]; LANES]);
    let wanted: &mut [[f32; 3]] = if outputs.normals { &mut normals } else { &mut [] };
    let mut target = FragmentTarget { colors: &mut colors, normals: wanted };
    late(simd, context, instance, look, fragments, at, &corners, &mut target);
    for (lane, &number) in numbers.iter().enumerate() {
        memory.colors[number] = colors[lane];
        if outputs.normals {
            memory.normals[number] = normals[lane];
        }
    }
}
