//! Which vertices are the corners of a cluster's triangles.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, u8x64};
use tercio_mesh::cluster::{ClusterView, MAX_TRIANGLES};

use crate::simd::{LANES, MANY, each3, lookup_bytes};

/// 16 triangles of a cluster: the numbers of their corners, first, second and third.
pub type CornerNumbers = [[u8; LANES]; 3];

/// The corners of 16 triangles of a cluster, from number `first` on.
#[inline(always)]
pub fn corner_numbers(cluster: &ClusterView, first: usize) -> CornerNumbers {
    let corners = cluster.corners();
    each3!(K => *corners[K][first..].first_chunk().unwrap_or(&[0; LANES]))
}

/// The corners of all triangles of a cluster: first, second and third.
#[derive(Clone, Copy, Debug)]
pub struct CornerTable<'a>([&'a [u8; MAX_TRIANGLES]; 3]);

impl<'a> CornerTable<'a> {
    /// Of a cluster.
    #[inline(always)]
    pub fn new(cluster: &ClusterView<'a>) -> Self {
        Self(cluster.corner_tables())
    }

    /// Of 64 triangles that stand one after another, `first` a multiple of 64.
    #[inline(always)]
    pub fn of_64<S: Simd>(&self, simd: S, first: usize) -> [u8x64<S>; 3] {
        each3!(K => u8x64::from_slice(simd, &self.0[K][first % MAX_TRIANGLES..][..MANY]))
    }

    /// Of one triangle.
    pub fn of(&self, triangle: u8) -> [u8; 3] {
        self.0.map(|corner| corner[usize::from(triangle) % MAX_TRIANGLES])
    }

    /// Of any 16 triangles.
    #[inline(always)]
    pub fn look_up<S: Simd>(&self, simd: S, triangles: &[u8; LANES]) -> CornerNumbers {
        each3!(K => lookup_bytes(simd, self.0[K], triangles))
    }
}
