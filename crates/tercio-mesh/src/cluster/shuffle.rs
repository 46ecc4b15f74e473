//! Shuffling for tests: a picture must not depend on how a mesh was split into clusters.

use std::sync::OnceLock;

use bytemuck::Zeroable;

use super::layout::padded;
use super::{Cluster, ClusterView, ClusteredMesh, Layout, Line, gather};

/// The mesh with its clusters, and the triangles inside each, in a random order drawn from `seed`.
pub(super) fn shuffle(mesh: &ClusteredMesh, seed: u64) -> ClusteredMesh {
    let mut random = seed;
    let mut clusters: Vec<u32> = (0..mesh.clusters.len() as u32).collect();
    permute(&mut clusters, &mut random);
    let (mut heads, mut starts, mut lines) = (Vec::new(), vec![0], Vec::new());
    for number in clusters {
        let old = mesh.cluster(number as usize);
        let mut order: Vec<u32> = (0..old.triangles() as u32).collect();
        permute(&mut order, &mut random);
        heads.push(reorder(&old, &order, &mut lines));
        starts.push(lines.len() as u32);
    }
    lines.extend([Line::zeroed(); Layout::LINES_BEHIND]);
    let (clusters, starts, lines) = (heads.into(), starts.into(), lines.into());
    ClusteredMesh { clusters, starts, lines, groups: OnceLock::new(), ..mesh.clone() }
}

/// Appends the stretch of a cluster with its triangles in another order.
fn reorder(old: &ClusterView, order: &[u32], lines: &mut Vec<Line>) -> Cluster {
    let layout = old.layout();
    let numbers: Vec<u32> = order.iter().map(|&t| old.primitive(t as usize)).collect();
    let sizes = gather::head(old.head().vertices, numbers.iter().copied());
    let head =
        Cluster { first_primitive: sizes.first_primitive, number_bits: sizes.number_bits, ..*old.head() };
    let first = lines.len();
    lines.resize(first + layout.lines(&head), Line::zeroed());
    let (to, after) = (&mut lines[first..], layout.triangle_values(&head, 0));
    to[0].0[..size_of::<Cluster>()].copy_from_slice(bytemuck::bytes_of(&head));

    // The vertices are unchanged.
    let words: &mut [u32] = bytemuck::cast_slice_mut(to);
    let from: &[u32] = bytemuck::cast_slice(old.lines());
    words[Line::BYTES / 4..after].copy_from_slice(&from[Line::BYTES / 4..after]);
    for place in 0..(layout.numbers(&head) / 4 - after) / padded(head.triangles) {
        let at = after + place * padded(head.triangles);
        for (i, &t) in order.iter().enumerate() {
            words[at + i] = from[at + t as usize];
        }
    }
    let bytes: &mut [u8] = bytemuck::cast_slice_mut(to);
    let at = layout.corners(&head);
    for (k, corner) in old.corners().into_iter().enumerate() {
        for (i, &t) in order.iter().enumerate() {
            bytes[at + k * padded(head.triangles) + i] = corner[t as usize];
        }
    }
    gather::write_numbers(bytes, &head, layout, &numbers);
    head
}

/// Fisher-Yates shuffle.
fn permute(values: &mut [u32], random: &mut u64) {
    for i in (1..values.len()).rev() {
        let j = next(random) % (i as u64 + 1);
        values.swap(i, j as usize);
    }
}

/// SplitMix64.
fn next(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let z = (*state ^ *state >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ z >> 31
}
