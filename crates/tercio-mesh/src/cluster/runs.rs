//! Splits consecutive triangles into clusters: a new one begins where the next triangle no longer fits.

use super::gather;
use super::partition::{Cut, Limits};

/// Splits the triangles of a block in their order. `number_of` gives the mesh number of each of them, `vertices` is the number of
/// vertices in the block.
pub(super) fn cut(
    triangles: &[[u16; 3]],
    number_of: impl Fn(usize) -> u32,
    vertices: usize,
    limits: Limits,
) -> Cut {
    let mut cut = Cut::new(triangles.len());
    // For each vertex: number of the last cluster that contains it, from 1, times 256, plus its number in that
    // cluster.
    let mut member = vec![0u32; vertices];
    let mut number = 1;
    let (mut used, mut count) = (0u32, 0u32);
    let head = |used: u32, count: u32, end: usize| {
        gather::head(used as u8, (end - count as usize..end).map(&number_of))
    };
    for (i, triangle) in triangles.iter().enumerate() {
        let missing = triangle.iter().filter(|&&v| member[usize::from(v)] >> 8 != number).count() as u32;
        if count == limits.triangles || used + missing > limits.vertices {
            cut.clusters.push(head(used, count, i));
            number += 1;
            (used, count) = (0, 0);
        }
        for (k, &v) in triangle.iter().enumerate() {
            let member = &mut member[usize::from(v)];
            if *member >> 8 != number {
                *member = number << 8 | used;
                used += 1;
                cut.vertices.push(v);
            }
            cut.corners[k][i] = *member as u8;
        }
        count += 1;
    }
    if count > 0 {
        cut.clusters.push(head(used, count, triangles.len()));
    }
    cut
}
