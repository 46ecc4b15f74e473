//! A cube of grid cells around a mesh.

use crate::loops::prelude::*;

use super::hilbert;
use crate::Mesh;

/// Bits per axis of the finest grid whose cells can be numbered in 16 bits.
pub(super) const FINEST: u32 = 5;

/// A cube of grid cells around a mesh.
pub(super) struct Grid {
    min: [f32; 3],
    /// Cells per unit of length.
    scale: f32,
    bits: u32,
}

impl Grid {
    pub fn new(mesh: &Mesh, bits: u32) -> Self {
        let bounds = mesh.bounds();
        let unit = mesh.unit();
        let min = ((bounds.min - mesh.origin) / unit).as_vec3().to_array();
        Self::cube(min, (bounds.size().max_element() / unit) as f32, bits)
    }

    pub fn cube(min: [f32; 3], edge: f32, bits: u32) -> Self {
        let scale = (1u32 << bits) as f32 / edge;
        Self { min, scale: if scale.is_finite() { scale } else { 0.0 }, bits }
    }

    /// Cell coordinates of a point; points outside go to the nearest cell.
    #[inline]
    pub fn coordinates(&self, [x, y, z]: [f32; 3]) -> [u32; 3] {
        let last = (1u32 << self.bits) - 1;
        let [min_x, min_y, min_z] = self.min;
        [
            (((x - min_x) * self.scale) as u32).min(last),
            (((y - min_y) * self.scale) as u32).min(last),
            (((z - min_z) * self.scale) as u32).min(last),
        ]
    }

    /// Cell number of a point, x fastest.
    #[inline]
    pub fn cell(&self, p: [f32; 3]) -> usize {
        let [x, y, z] = self.coordinates(p);
        (x | y << self.bits | z << (2 * self.bits)) as usize
    }

    pub fn bits(&self) -> u32 {
        self.bits
    }
}

/// Position along the Hilbert curve of each cell of a grid of at most [`FINEST`] bits.
pub(super) fn rank_table(bits: u32) -> Vec<u16> {
    let low = (1u32 << bits) - 1;
    (0..1u32 << (3 * bits))
        .into_par_iter()
        .with_min_len(1 << 10)
        .map(|i| hilbert::rank([i & low, i >> bits & low, i >> (2 * bits)], bits) as u16)
        .collect()
}
