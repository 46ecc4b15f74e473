//! The projected vertices of clusters that are large on the screen or cross the near plane or the guard band.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16};
use tercio_mesh::cluster::{ClusterView, MAX_VERTICES};

use super::{CornerNumbers, positions, project};
use crate::simd::{LANES, each3, lookup};
use crate::view::{ObjectView, ScreenVertex};

/// The projected vertices of one cluster.
#[derive(Debug)]
pub struct ClusterVertices {
    /// Screen coordinates.
    pub x: [i32; MAX_VERTICES],
    /// Screen coordinates.
    pub y: [i32; MAX_VERTICES],
    /// Depths, as the bits of an `f32`.
    pub d: [i32; MAX_VERTICES],
    /// Bit v is set if vertex v is before the near plane or outside the guard band: its triangles need clipping.
    pub needs_clipping: u64,
}

impl Default for ClusterVertices {
    fn default() -> Self {
        let zero = [0; MAX_VERTICES];
        Self { x: zero, y: zero, d: zero, needs_clipping: 0 }
    }
}

impl ClusterVertices {
    /// Projects all vertices of a cluster.
    #[inline(always)]
    pub fn project<S: Simd>(&mut self, simd: S, object: &ObjectView, cluster: &ClusterView) {
        self.needs_clipping = 0;
        let axes = cluster.positions();
        let mut first = 0;
        while first < axes[0].len() {
            let v = project(simd, object, positions(simd, &axes, first));
            let to = first..first + LANES;
            v.x.store_slice(&mut self.x[to.clone()]);
            v.y.store_slice(&mut self.y[to.clone()]);
            v.d.bitcast::<i32x16<S>>().store_slice(&mut self.d[to]);
            self.needs_clipping |= (!v.inside.to_bitmask() & 0xffff) << first;
            first += LANES;
        }
    }

    /// Depths of the corners of 16 triangles.
    #[inline(always)]
    pub fn depths<S: Simd>(&self, simd: S, corners: &CornerNumbers) -> [f32x16<S>; 3] {
        each3!(K => lookup(simd, &self.d, &corners[K]).bitcast())
    }

    /// Screen coordinates of the corners of 16 triangles: x, y.
    #[inline(always)]
    pub fn coordinates<S: Simd>(&self, simd: S, corners: &CornerNumbers) -> [[i32x16<S>; 3]; 2] {
        [each3!(K => lookup(simd, &self.x, &corners[K])), each3!(K => lookup(simd, &self.y, &corners[K]))]
    }

    /// One vertex.
    #[inline(always)]
    pub fn vertex(&self, corner: u8) -> ScreenVertex {
        let v = usize::from(corner) % MAX_VERTICES;
        ScreenVertex {
            x: self.x[v],
            y: self.y[v],
            d: f32::from_bits(self.d[v] as u32),
            inside: self.needs_clipping >> v & 1 == 0,
        }
    }
}
