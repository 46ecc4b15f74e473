//! One cluster: its vertices to the screen, then its triangles 16 at a time.

use fearless_simd::Simd;
use fearless_simd::prelude::*;
use fearless_simd::{f32x16, i32x16};
use tercio_mesh::ClusteredMesh;
use tercio_mesh::cluster::{Cluster, MAX_VERTICES};

use super::Batch;
use super::clip::clip_triangle;
use super::cull::Placement;
use super::transform::project;
use crate::binning::ScreenTriangle;
use crate::binning::small::{Corners as TriangleCorners, TriangleLanes};
use crate::context::FrameContext;
use crate::conventions::{SAMPLE, SMALL_EXTENT, SUBPIXEL_BITS};
use crate::simd::{LANES, each3, load, lookup, splat_i};
use crate::view::{ObjectView, ScreenVertex};

/// The projected vertices of one cluster.
pub struct ClusterPass {
    x: [i32; MAX_VERTICES],
    y: [i32; MAX_VERTICES],
    /// Depths, as the bits of an `f32`.
    d: [i32; MAX_VERTICES],
    /// Bit v tells that vertex v needs clipping.
    beyond: u64,
}

impl Default for ClusterPass {
    fn default() -> Self {
        let zero = [0; MAX_VERTICES];
        Self { x: zero, y: zero, d: zero, beyond: 0 }
    }
}

/// 16 triangles: their corners' numbers inside the cluster.
type Corners = [[u8; LANES]; 3];

impl ClusterPass {
    /// Draws a cluster into the bins.
    #[expect(clippy::too_many_arguments, reason = "one call site; a struct would only rename them")]
    #[inline(always)]
    pub fn draw<S: Simd>(
        &mut self,
        simd: S,
        context: &FrameContext,
        object: &ObjectView,
        mesh: &ClusteredMesh,
        cluster: &Cluster,
        first_slot: u32,
        placement: Placement,
        batch: &mut Batch,
    ) {
        self.transform(simd, object, mesh, cluster);
        batch.counts.vertices_transformed += u64::from(cluster.vertices);
        if placement == Placement::Inside {
            self.beyond = 0;
        }
        let count = usize::from(cluster.triangles);
        let mut first = 0;
        while first < count {
            let from = cluster.first_triangle as usize + first;
            let mut corners: Corners = [[0; LANES]; 3];
            for k in 0..3 {
                corners[k].copy_from_slice(&mesh.corners[k][from..from + LANES]);
            }
            let live = if count - first >= LANES { 0xffff } else { (1u32 << (count - first)) - 1 };
            let slot = first_slot + first as u32;
            let whole = if self.beyond == 0 {
                live
            } else {
                self.clip_crossing(context, object, mesh, cluster, &corners, live, slot, batch)
            };
            self.draw_16(simd, context, object, &corners, whole, slot, batch);
            first += LANES;
        }
    }

    /// Projects all vertices of a cluster.
    #[inline(always)]
    fn transform<S: Simd>(&mut self, simd: S, object: &ObjectView, mesh: &ClusteredMesh, cluster: &Cluster) {
        self.beyond = 0;
        let count = usize::from(cluster.vertices);
        let mut first = 0;
        while first < count {
            let from = cluster.first_vertex as usize + first;
            let p = [
                load(simd, &mesh.x[from..from + LANES]),
                load(simd, &mesh.y[from..from + LANES]),
                load(simd, &mesh.z[from..from + LANES]),
            ];
            let v = project(simd, object, p);
            let to = first..first + LANES;
            v.x.store_slice(&mut self.x[to.clone()]);
            v.y.store_slice(&mut self.y[to.clone()]);
            v.d.bitcast::<i32x16<S>>().store_slice(&mut self.d[to]);
            self.beyond |= (!v.inside.to_bitmask() & 0xffff) << first;
            first += LANES;
        }
        if count < MAX_VERTICES {
            // Lanes behind the last vertex hold a neighbour's.
            self.beyond &= (1 << count) - 1;
        }
    }

    #[inline(always)]
    fn vertex(&self, corner: u8) -> ScreenVertex {
        let v = usize::from(corner) % MAX_VERTICES;
        ScreenVertex {
            x: self.x[v],
            y: self.y[v],
            d: f32::from_bits(self.d[v] as u32),
            inside: self.beyond >> v & 1 == 0,
        }
    }

    /// 16 triangles whose corners are all inside: drops those that reach no sample and bins the others.
    #[expect(clippy::too_many_arguments, reason = "one call site; a struct would only rename them")]
    #[inline(always)]
    fn draw_16<S: Simd>(
        &self,
        simd: S,
        context: &FrameContext,
        object: &ObjectView,
        corners: &Corners,
        live: u32,
        first_slot: u32,
        batch: &mut Batch,
    ) {
        let counts = &mut batch.counts;
        let [x0, x1, x2] = each3!(K => lookup(simd, &self.x, &corners[K]));
        let [y0, y1, y2] = each3!(K => lookup(simd, &self.y, &corners[K]));
        let (min_x, max_x) = (x0.min(x1).min(x2), x0.max(x1).max(x2));
        let (min_y, max_y) = (y0.min(y1).min(y2), y0.max(y1).max(y2));

        // Is there a sample of the picture in the box?
        let hits = first_sample_16(simd, min_x).simd_le(last_sample_16(simd, max_x, context.view.width))
            & first_sample_16(simd, min_y).simd_le(last_sample_16(simd, max_y, context.view.height));
        let hits = hits.to_bitmask() as u32 & live;
        counts.triangles_no_sample += u64::from((live & !hits).count_ones());
        if hits == 0 {
            return;
        }

        // Products of differences fit into 32 bits only for small triangles; the large ones are looked at
        // one by one.
        let limit = splat_i(simd, SMALL_EXTENT);
        let small = (max_x - min_x).simd_lt(limit) & (max_y - min_y).simd_lt(limit);
        let small = small.to_bitmask() as u32 & hits;
        let area = (x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0);
        let zero = splat_i(simd, 0);
        let mut clockwise = area.simd_gt(zero).to_bitmask() as u32 & small;
        let mut counter = area.simd_lt(zero).to_bitmask() as u32 & small;
        let mut large = hits & !small;
        while large != 0 {
            let lane = large.trailing_zeros();
            large &= large - 1;
            let area = self.triangle(corners, lane, first_slot).area();
            clockwise |= u32::from(area > 0) << lane;
            counter |= u32::from(area < 0) << lane;
        }
        counts.triangles_no_area += u64::from((hits & !clockwise & !counter).count_ones());
        let (keep, drop) = match context.settings.cull.drops_clockwise(object.mirrored) {
            None => (clockwise | counter, 0),
            Some(true) => (counter, clockwise),
            Some(false) => (clockwise, counter),
        };
        counts.triangles_facing += u64::from(drop.count_ones());

        if keep == 0 {
            return;
        }
        let d: [f32x16<S>; 3] = each3!(K => lookup(simd, &self.d, &corners[K]).bitcast());
        let boxes = [
            first_sample_16(simd, min_x),
            last_sample_16(simd, max_x, context.view.width),
            first_sample_16(simd, min_y),
            last_sample_16(simd, max_y, context.view.height),
        ];
        let lanes = TriangleLanes::new(TriangleCorners { x: [x0, x1, x2], y: [y0, y1, y2], d }, area, boxes);
        batch.counts.triangles_out += u64::from(keep.count_ones());
        let mut left = keep;
        while left != 0 {
            let lane = left.trailing_zeros() as usize;
            left &= left - 1;
            let (rect, slot) = (lanes.rect(lane), first_slot + lane as u32);
            let binning = context.settings.binning;
            if small >> lane & 1 == 1 {
                batch.bins.push_small(&context.grid, binning, lanes.small(lane, slot), rect);
            } else {
                batch.bins.push(&context.grid, binning, lanes.triangle(lane, slot), rect);
            }
        }
    }

    #[inline(always)]
    fn triangle(&self, corners: &Corners, lane: u32, first_slot: u32) -> ScreenTriangle {
        let lane_index = lane as usize;
        let v = each3!(K => self.vertex(corners[K][lane_index]));
        ScreenTriangle::new(v, first_slot + lane)
    }

    /// Clips and bins those of 16 triangles that have a corner beyond a plane; returns the others.
    #[expect(clippy::too_many_arguments, reason = "one call site; a struct would only rename them")]
    #[inline(never)]
    fn clip_crossing(
        &self,
        context: &FrameContext,
        object: &ObjectView,
        mesh: &ClusteredMesh,
        cluster: &Cluster,
        corners: &Corners,
        live: u32,
        first_slot: u32,
        batch: &mut Batch,
    ) -> u32 {
        let mut whole = live;
        for lane in 0..LANES as u32 {
            let numbers = [0, 1, 2].map(|k| corners[k][lane as usize]);
            let v = numbers.map(|n| self.vertex(n));
            if live >> lane & 1 == 0 || v.iter().all(|v| v.inside) {
                continue;
            }
            whole &= !(1 << lane);
            let positions = numbers.map(|n| {
                let at = cluster.first_vertex as usize + usize::from(n);
                [mesh.x[at], mesh.y[at], mesh.z[at]]
            });
            let mut pieces = 0;
            clip_triangle(object, positions, v, |piece| {
                pieces += 1;
                draw_piece(context, object, ScreenTriangle::new(piece, first_slot + lane), batch);
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

/// [`crate::conventions::first_sample`], not before the picture.
#[inline(always)]
fn first_sample_16<S: Simd>(simd: S, v: i32x16<S>) -> i32x16<S> {
    ((v + (SAMPLE - 1)) >> SUBPIXEL_BITS).max(splat_i(simd, 0))
}

/// [`crate::conventions::last_sample`], not behind a picture of `size` pixels.
#[inline(always)]
fn last_sample_16<S: Simd>(simd: S, v: i32x16<S>, size: u32) -> i32x16<S> {
    ((v - SAMPLE) >> SUBPIXEL_BITS).min(splat_i(simd, size as i32 - 1))
}

/// Bins one piece of a clipped triangle.
fn draw_piece(context: &FrameContext, object: &ObjectView, piece: ScreenTriangle, batch: &mut Batch) {
    let area = piece.area();
    let culled = context.settings.cull.drops_clockwise(object.mirrored) == Some(area > 0);
    if area == 0 || culled {
        return;
    }
    if let Some(rect) = piece.samples(context.view.width, context.view.height) {
        batch.counts.triangles_out += 1;
        batch.bins.push(&context.grid, context.settings.binning, piece, rect);
    }
}
