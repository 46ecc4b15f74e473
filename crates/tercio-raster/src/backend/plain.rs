//! The look of most pictures in a kernel of its own: normals at the vertices, one colour a surface, distant lights
//! without highlights, 8-bit colours and nothing else. It asks for so little that all of it stays in registers.

use fearless_simd::Simd;
use fearless_simd::prelude::*;

use super::cluster::ClusterPass;
use super::encode::opaque;
use super::interpolate::{near_areas, weighted};
use super::light::{bend, beside, diffuse, normalize, towards_viewer};
use super::memory::TileMemory;
use super::output::TilePixels;
use super::table::ClusterTable;
use crate::context::FrameContext;
use crate::simd::{LANES, each3, splat};

/// Shades the samples that a cluster of an instance won; none of its triangles is wide.
#[inline(always)]
pub fn winners<S: Simd>(
    simd: S,
    context: &FrameContext,
    instance: usize,
    pass: &mut ClusterPass,
    memory: &TileMemory,
    table: &ClusterTable,
    pixels: &mut TilePixels,
) {
    let ClusterPass { vertices, corners, winners, .. } = pass;
    let color = context.scene.instances[instance].surface.base_color;
    let first_sample = vertices.sample_of(memory.corner);
    let from_middle = vertices.from_middle(&context.lights.sight);
    for first in (0..winners.len()).step_by(LANES) {
        let (places, triangles) = winners.sixteen(first);
        let numbers = corners.look_up(simd, triangles);
        let [x, y] = vertices.coordinates(simd, &numbers);
        let sample = memory.samples(simd, places, first_sample);
        let area = near_areas(simd, sample, x, y);
        let normal = weighted(&area, table.look_up_normals(simd, &numbers));
        let mut normal = normalize(simd, normal, beside(simd, &context.lights));
        // Normals of triangles that appear clockwise are turned over, because their areas are negative.
        let (whole, zero) = ((area[0] + area[1]) + area[2], splat(simd, 0.0));
        let face_viewer = table.face_viewer && !whole.simd_lt(zero).any_true()
            || table.face_away && !whole.simd_gt(zero).any_true();
        if !face_viewer {
            normal = bend(simd, normal, towards_viewer(simd, &context.lights, sample, from_middle));
        }
        let light = diffuse(simd, &context.lights, normal);
        let levels = opaque(simd, each3!(C => light[C] * color[C])).to_array();
        for lane in 0..LANES {
            pixels.color[places[lane] as usize] = (levels[lane] as u32).to_le_bytes();
        }
    }
}
