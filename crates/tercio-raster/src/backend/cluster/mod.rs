//! A whole cluster into a tile: transform, set up 16 triangles at a time, test samples, test depths, shade.
//!
//! All that a cluster needs stays in registers and in the first-level cache from its vertices to its pixels:
//! [`setup`] makes edge functions and depth planes of 16 triangles, [`scan`] finds the samples that triangles of
//! a few pixels cover, all 16 at once, and [`depth_test`] keeps those that are nearer than what was drawn.
//! Larger triangles are drawn one by one, block after block ([`blocks`]). What won is shaded at once, 16 pixels
//! at a time ([`shade_winners`](super::shade::shade_winners)), from the vertices that lie ready.

mod blocks;
mod depth_test;
mod scan;
mod setup;

use fearless_simd::Simd;
use fearless_simd::prelude::*;

use crate::binning::{BinnedCluster, PixelRect};
use crate::context::FrameContext;
use crate::frontend::transform::{ClusterVertices, ScreenTriangles, corner_numbers};
use crate::simd::{LANES, part, prefetch, splat_i};
use crate::stats::BackEndCounts;
use depth_test::Covered;
pub use depth_test::Winners;
use setup::SmallTriangles;
use tercio_mesh::cluster::MAX_TRIANGLES;

use super::visibility::TileMemory;

/// What is kept from cluster to cluster.
#[derive(Debug, Default)]
pub struct ClusterPass {
    vertices: ClusterVertices,
    covered: Covered,
    /// What the cluster shows, for whoever shades it.
    pub winners: Winners,
}

impl ClusterPass {
    /// Draws a cluster into a tile and lists the samples that it won.
    #[inline(always)]
    pub fn draw<S: Simd>(
        &mut self,
        simd: S,
        context: &FrameContext,
        binned: &BinnedCluster,
        tile: &mut TileMemory,
        counts: &mut BackEndCounts,
    ) {
        let (instance, index) = context.locate(binned.number);
        let (mesh, object) = (&*context.scene.instances[instance].mesh, &context.objects[instance]);
        let cluster = &mesh.clusters[index];
        let first_slot = binned.number * MAX_TRIANGLES as u32;
        let cull = context.settings.cull;
        self.vertices.project(simd, object, mesh, cluster);
        self.winners.clear();
        counts.vertices_transformed += u64::from(cluster.vertices);
        counts.triangles_in += u64::from(cluster.triangles);
        let rect = tile.rect();
        let count = usize::from(cluster.triangles);
        let mut first = 0;
        while first < count {
            let corners = corner_numbers(mesh, cluster.first_triangle as usize + first);
            let live = if count - first >= LANES { 0xffff } else { (1u32 << (count - first)) - 1 };
            let t = ScreenTriangles::new(simd, &self.vertices, &corners, rect);
            let hits = t.hits() & live;
            if hits != 0 {
                let area = t.area();
                let zero = splat_i(simd, 0);
                let clockwise = area.simd_gt(zero).to_bitmask() as u32 & hits;
                let counter = area.simd_lt(zero).to_bitmask() as u32 & hits;
                let (keep, _) = cull.split(object.mirrored, clockwise, counter);
                if keep != 0 {
                    counts.triangles_drawn += u64::from(keep.count_ones());
                    let triangles = SmallTriangles::new(simd, &self.vertices, &corners, &t, area);
                    let few = triangles.few_samples() & keep;
                    if few != 0 {
                        scan::scan(simd, &triangles, few, first as u32, tile, &mut self.covered);
                    }
                    if few != keep {
                        let lanes = blocks::Lanes::new(&triangles);
                        blocks::draw(
                            simd,
                            context,
                            &lanes,
                            keep & !few,
                            first_slot + first as u32,
                            tile,
                            &mut self.winners,
                            counts,
                        );
                    }
                    if self.covered.is_nearly_full() {
                        self.covered.test(context, first_slot, tile, &mut self.winners, counts);
                    }
                }
            }
            first += LANES;
        }
        self.covered.test(context, first_slot, tile, &mut self.winners, counts);
    }
}

/// Asks the memory for the head of a cluster that will be drawn soon.
#[inline(always)]
pub fn prefetch_head(context: &FrameContext, binned: &BinnedCluster) {
    let (instance, index) = context.locate(binned.number);
    prefetch(&context.scene.instances[instance].mesh.clusters, index, 1);
}

/// Asks the memory for the vertices and triangles of a cluster that will be drawn soon.
#[inline(always)]
pub fn prefetch_body(context: &FrameContext, binned: &BinnedCluster) {
    let (instance, index) = context.locate(binned.number);
    let mesh = &*context.scene.instances[instance].mesh;
    let cluster = &mesh.clusters[index];
    let (first, vertices) = (cluster.first_vertex as usize, usize::from(cluster.vertices));
    for axis in [&mesh.x, &mesh.y, &mesh.z] {
        prefetch(axis, first, vertices);
    }
    if let Some(normals) = &mesh.normals {
        prefetch(normals, first, vertices);
    }
    for corner in &mesh.corners {
        prefetch(corner, cluster.first_triangle as usize, usize::from(cluster.triangles));
    }
}

/// True only if everything in a part of a tile is nearer than a cluster can be.
#[inline(always)]
pub fn is_hidden<S: Simd>(simd: S, binned: &BinnedCluster, tile: &TileMemory) -> bool {
    let [x0, x1, y0, y1] = binned.rect.map(i32::from);
    let rect = PixelRect { x0, x1, y0, y1 }.intersect(tile.rect());
    part(
        simd,
        #[inline(always)]
        || tile.all_nearer(simd, rect, binned.nearest),
    )
}
