//! Disorder for tests: a picture must not depend on how a mesh was cut.

use super::{Cluster, ClusteredMesh, PADDING};
use crate::AttributeDomain;

/// Puts the clusters, and the triangles inside each, into an order drawn from `seed`.
pub(super) fn shuffle(mesh: &mut ClusteredMesh, seed: u64) {
    let mut random = seed;
    let mut clusters: Vec<u32> = (0..mesh.clusters.len() as u32).collect();
    permute(&mut clusters, &mut random);
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    let mut shuffled = Vec::with_capacity(clusters.len());
    for &i in &clusters {
        let old = mesh.clusters[i as usize];
        shuffled.push(Cluster {
            first_vertex: vertices.len() as u32,
            first_triangle: triangles.len() as u32,
            ..old
        });
        vertices.extend(old.vertex_range().map(|v| v as u32));
        let begin = triangles.len();
        triangles.extend(old.triangle_range().map(|t| t as u32));
        permute(&mut triangles[begin..], &mut random);
    }
    let n = triangles.len() as u32;
    mesh.clusters = shuffled;
    let primitives = mesh.primitives.get_or_insert_with(|| (0..n + PADDING as u32).collect());
    pick(primitives, &triangles);
    mesh.corners.iter_mut().for_each(|v| pick(v, &triangles));
    mesh.face_colors.iter_mut().for_each(|v| pick(v, &triangles));
    mesh.triangle_materials.iter_mut().for_each(|v| pick(v, &triangles));
    [&mut mesh.x, &mut mesh.y, &mut mesh.z].into_iter().for_each(|v| pick(v, &vertices));
    mesh.normals.iter_mut().for_each(|v| pick(v, &vertices));
    mesh.vertex_colors.iter_mut().for_each(|v| pick(v, &vertices));
    mesh.texcoords.iter_mut().for_each(|v| pick(v, &vertices));
    for a in &mut mesh.attributes {
        let places = match a.domain {
            AttributeDomain::Vertex => &vertices,
            AttributeDomain::Triangle => &triangles,
        };
        pick(&mut a.values, places);
    }
}

/// The values at `places`, in their order, then padding.
fn pick<T: Copy + Default>(values: &mut Vec<T>, places: &[u32]) {
    let mut picked: Vec<T> = places.iter().map(|&i| values[i as usize]).collect();
    picked.resize(places.len() + PADDING, T::default());
    *values = picked;
}

/// Fisher and Yates.
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
