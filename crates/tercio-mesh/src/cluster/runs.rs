//! Cuts consecutive triangles into clusters: a new one begins where the next triangle no longer fits.

use super::partition::{Cut, Limits, Span};
use crate::Mesh;

const SLOTS: usize = 256;

/// Numbers of mesh vertices inside the open cluster.
struct LocalVertices {
    /// Mesh vertex in the high half, its number in the cluster plus one in the low half; 0 for a free slot.
    slots: [u64; SLOTS],
}

impl LocalVertices {
    /// The slot where a vertex stands or would stand.
    #[inline]
    fn slot(&self, vertex: u32) -> usize {
        let mut i = (vertex.wrapping_mul(0x9e37_79b9) >> 24) as usize;
        while self.slots[i] != 0 && (self.slots[i] >> 32) as u32 != vertex {
            i = (i + 1) % SLOTS;
        }
        i
    }

    /// The vertex's number, a new one if it is not there yet.
    #[inline]
    fn number(&mut self, vertex: u32, used: &mut u32) -> u32 {
        let i = self.slot(vertex);
        if self.slots[i] == 0 {
            *used += 1;
            self.slots[i] = u64::from(vertex) << 32 | u64::from(*used);
        }
        self.slots[i] as u32 - 1
    }
}

/// Cuts `triangles` in their order, and writes the numbers of their corners.
pub(super) fn cut(
    triangles: impl ExactSizeIterator<Item = [u32; 3]>,
    corners: &mut [&mut [u8]; 3],
    limits: Limits,
) -> Cut {
    let mut cut = Cut::with_capacity(triangles.len());
    let mut local = LocalVertices { slots: [0; SLOTS] };
    let (mut used, mut count) = (0u32, 0u32);
    for (i, triangle) in triangles.enumerate() {
        let triangle = Mesh::canonical(triangle);
        let missing = triangle.iter().filter(|&&v| local.slots[local.slot(v)] == 0).count() as u32;
        if count == limits.triangles || used + missing > limits.vertices {
            cut.clusters.push(Span { vertices: used as u8, triangles: count as u8 });
            local.slots.fill(0);
            (used, count) = (0, 0);
        }
        for (k, &v) in triangle.iter().enumerate() {
            let before = used;
            corners[k][i] = local.number(v, &mut used) as u8;
            if used > before {
                cut.vertices.push(v);
            }
        }
        count += 1;
    }
    if count > 0 {
        cut.clusters.push(Span { vertices: used as u8, triangles: count as u8 });
    }
    cut
}
