//! Bins a cluster triangle by triangle, testing 16 triangles at a time.
//!
//! This is the path of clusters that are large on the screen, of those that cross the near plane or the guard band, and
//! with [`crate::Sorting::Triangles`] of all clusters. Clusters that are small on the screen are binned as a whole and
//! drawn by `backend::cluster`.

use fearless_simd::Simd;
use fearless_simd::prelude::*;
use tercio_mesh::cluster::ClusterView;

use super::Batch;
use super::cull::Placement;
use crate::context::FrameContext;
use crate::projection::clip::clip_triangle;
use crate::projection::{Anchored, ClusterVertices, CornerNumbers, ScreenTriangles, corner_numbers};
use crate::screen::{PixelRect, ScreenTriangle};
use crate::simd::{LANES, each3, live_lanes, part, splat_i};
use crate::view::ObjectView;

/// Bins clusters triangle by triangle.
#[derive(Default)]
pub struct TrianglePass {
    vertices: ClusterVertices,
}

impl TrianglePass {
    /// Bins the triangles of a cluster.
    #[expect(clippy::too_many_arguments, reason = "one call site; a struct would only rename them")]
    #[inline(always)]
    pub fn bin_cluster<S: Simd>(
        &mut self,
        simd: S,
        context: &FrameContext,
        object: &ObjectView,
        cluster: &ClusterView,
        first_slot: u32,
        placement: Placement,
        batch: &mut Batch,
    ) {
        self.vertices.project(simd, object, cluster);
        batch.counts.vertices_transformed += cluster.vertices() as u64;
        batch.counts.triangles_apart += cluster.triangles() as u64;
        if placement == Placement::Inside {
            self.vertices.needs_clipping = 0;
        }
        let count = cluster.triangles();
        let mut first = 0;
        while first < count {
            let corners = corner_numbers(cluster, first);
            let live = live_lanes(count - first);
            let slot = first_slot + first as u32;
            let whole = if self.vertices.needs_clipping == 0 {
                live
            } else {
                self.clip_crossing(context, object, cluster, &corners, live, slot, batch)
            };
            self.bin_16(simd, context, object, &corners, whole, slot, batch);
            first += LANES;
        }
    }

    /// Culls 16 triangles that need no clipping, and bins the rest.
    #[expect(clippy::too_many_arguments, reason = "one call site; a struct would only rename them")]
    #[inline(always)]
    fn bin_16<S: Simd>(
        &self,
        simd: S,
        context: &FrameContext,
        object: &ObjectView,
        corners: &CornerNumbers,
        live: u32,
        first_slot: u32,
        batch: &mut Batch,
    ) {
        let counts = &mut batch.counts;
        let coordinates = self.vertices.coordinates(simd, corners);
        let t = ScreenTriangles::new(simd, coordinates, context.cells.origin, context.picture());
        let hits = t.hits() & live;
        counts.triangles_no_sample += u64::from((live & !hits).count_ones());
        if hits == 0 {
            return;
        }

        // The area fits into 32 bits only for small triangles; that of large ones is computed one by one.
        let [small, clockwise, counter] = small_triangles(simd, &t).map(|lanes| lanes & hits);
        let (mut clockwise, mut counter) = (clockwise & small, counter & small);
        let mut large = hits & !small;
        while large != 0 {
            let lane = large.trailing_zeros();
            large &= large - 1;
            let v = each3!(K => self.vertices.vertex(corners[K][lane as usize]));
            let area = ScreenTriangle::new(v, first_slot).area();
            clockwise |= u32::from(area > 0) << lane;
            counter |= u32::from(area < 0) << lane;
        }
        counts.triangles_no_area += u64::from((hits & !clockwise & !counter).count_ones());
        let (keep, drop) = context.settings.cull.split(object.mirrored, clockwise, counter);
        counts.triangles_facing += u64::from(drop.count_ones());
        if keep == 0 {
            return;
        }
        counts.triangles_out += u64::from(keep.count_ones());

        let anchored = Anchored::new(simd, self.vertices.depths(simd, corners), &t);
        bin(context, &anchored, &t, keep, first_slot, batch);
    }

    /// Clips and bins those of 16 triangles that need clipping; returns the lanes of the others.
    #[expect(clippy::too_many_arguments, reason = "one call site; a struct would only rename them")]
    #[inline(never)]
    fn clip_crossing(
        &self,
        context: &FrameContext,
        object: &ObjectView,
        cluster: &ClusterView,
        corners: &CornerNumbers,
        live: u32,
        first_slot: u32,
        batch: &mut Batch,
    ) -> u32 {
        let mut whole = live;
        for lane in 0..LANES as u32 {
            let numbers = [0, 1, 2].map(|k| corners[k][lane as usize]);
            let v = numbers.map(|n| self.vertices.vertex(n));
            if live >> lane & 1 == 0 || v.iter().all(|v| v.inside) {
                continue;
            }
            whole &= !(1 << lane);
            let positions = numbers.map(|n| cluster.position(usize::from(n)));
            let mut pieces = 0;
            clip_triangle(object, positions, v, |piece| {
                pieces += 1;
                bin_piece(context, object, ScreenTriangle::new(piece, first_slot + lane), batch);
            });
            let counter = if pieces == 0 {
                &mut batch.counts.triangles_outside
            } else {
                &mut batch.counts.triangles_clipped
            };
            *counter += 1;
        }
        whole
    }
}

/// Bins the triangles in the given lanes.
#[inline(always)]
fn bin<S: Simd>(
    context: &FrameContext,
    anchored: &Anchored<S>,
    t: &ScreenTriangles<S>,
    mut lanes: u32,
    first_slot: u32,
    batch: &mut Batch,
) {
    part(
        t.x[0].simd,
        #[inline(always)]
        || {
            let x = each3!(K => anchored.x[K].to_array());
            let y = each3!(K => anchored.y[K].to_array());
            let d = each3!(K => anchored.d[K].to_array());
            let columns = [t.columns[0].to_array(), t.columns[1].to_array()];
            let rows = [t.rows[0].to_array(), t.rows[1].to_array()];
            while lanes != 0 {
                let lane = lanes.trailing_zeros() as usize;
                lanes &= lanes - 1;
                let triangle = ScreenTriangle {
                    x: each3!(K => x[K][lane]),
                    y: each3!(K => y[K][lane]),
                    d: each3!(K => d[K][lane]),
                    slot: first_slot + lane as u32,
                };
                let rect = PixelRect {
                    x0: columns[0][lane],
                    x1: columns[1][lane],
                    y0: rows[0][lane],
                    y1: rows[1][lane],
                };
                batch.bins.push(&context.grid, &context.cells, context.settings.binning, triangle, rect);
            }
        },
    );
}

/// Three masks: lanes whose area fits into 32 bits; of these, the clockwise and the counter-clockwise triangles.
#[inline(always)]
fn small_triangles<S: Simd>(simd: S, t: &ScreenTriangles<S>) -> [u32; 3] {
    part(
        simd,
        #[inline(always)]
        || {
            let (area, zero) = (t.area(), splat_i(simd, 0));
            let bits = [area.simd_gt(zero), area.simd_lt(zero)];
            [!t.large(simd), bits[0].to_bitmask() as u32, bits[1].to_bitmask() as u32]
        },
    )
}

/// Bins one piece of a clipped triangle.
fn bin_piece(context: &FrameContext, object: &ObjectView, piece: ScreenTriangle, batch: &mut Batch) {
    let area = piece.area();
    let culled = context.settings.cull.drops_clockwise(object.mirrored) == Some(area > 0);
    if area == 0 || culled {
        return;
    }
    if let Some(rect) = piece.pixels(context.cells.origin, context.view.width, context.view.height) {
        batch.counts.triangles_out += 1;
        batch.bins.push(&context.grid, &context.cells, context.settings.binning, piece, rect);
    }
}
