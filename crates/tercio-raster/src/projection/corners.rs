//! The index data of a cluster: the vertex numbers of its triangles' corners.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, u8x64};
use tercio_mesh::cluster::{ClusterView, MAX_TRIANGLES};

use crate::simd::{BYTE_LANES, LANES, each3, lookup_bytes};

/// Vertex numbers of the first, second and third corners of 16 triangles of a cluster.
pub type CornerNumbers = [[u8; LANES]; 3];

/// The corners of 16 triangles of a cluster, from triangle `first` on.
#[inline(always)]
pub fn corner_numbers(cluster: &ClusterView, first: usize) -> CornerNumbers {
    let corners = cluster.corners();
    each3!(K => *corners[K][first..].first_chunk().unwrap_or(&[0; LANES]))
}

/// Vertex numbers of the first, second and third corners of all triangles of a cluster.
#[derive(Clone, Copy, Debug)]
pub struct CornerTable<'a>([&'a [u8; MAX_TRIANGLES]; 3]);

impl<'a> CornerTable<'a> {
    /// Of a cluster.
    #[inline(always)]
    pub fn new(cluster: &ClusterView<'a>) -> Self {
        Self(cluster.corner_tables())
    }

    /// The corners of 64 consecutive triangles; `first` is a multiple of 64.
    #[inline(always)]
    pub fn of_64<S: Simd>(&self, simd: S, first: usize) -> [u8x64<S>; 3] {
        each3!(K => u8x64::from_slice(simd, &self.0[K][first % MAX_TRIANGLES..][..BYTE_LANES]))
    }

    /// The corners of one triangle.
    pub fn of(&self, triangle: u8) -> [u8; 3] {
        self.0.map(|corner| corner[usize::from(triangle) % MAX_TRIANGLES])
    }

    /// The corners of any 16 triangles.
    #[inline(always)]
    pub fn look_up<S: Simd>(&self, simd: S, triangles: &[u8; LANES]) -> CornerNumbers {
        each3!(K => lookup_bytes(simd, self.0[K], triangles))
    }
}
