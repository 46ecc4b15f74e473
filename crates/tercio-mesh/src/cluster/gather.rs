//! Copies vertices and attributes to the places that the partition gives them.

use fearless_simd::{Level, dispatch};
use rayon::prelude::*;

use super::partition::Cut;
use super::{Cluster, ClusteredMesh};
use super::{PADDING, bounds};
use crate::{AttributeDomain, OctNormal};

/// Cuts `data` into consecutive pieces of the given lengths; what is left over is dropped.
pub(super) fn split<T>(mut data: &mut [T], lengths: impl Iterator<Item = usize>) -> Vec<&mut [T]> {
    lengths
        .map(|n| {
            let (piece, rest) = std::mem::take(&mut data).split_at_mut(n);
            data = rest;
            piece
        })
        .collect()
}

/// The values of a block's vertices. Clusters take them in an order that memory cannot foresee; here they come
/// about as they stand in the mesh.
fn of_block<'a, T: Copy>(memory: &'a mut Vec<T>, cut: &Cut, source: &[T]) -> &'a [T] {
    memory.clear();
    memory.extend(cut.names.iter().map(|&v| source[v as usize]));
    memory
}

/// Per-vertex values in cluster order, padded.
pub(super) fn vertices<T: Copy + Default + Send + Sync>(cuts: &[Cut], source: &[T]) -> Vec<T> {
    vertices_as(cuts, source, |value| value)
}

fn vertices_as<T: Copy + Send + Sync, U: Copy + Default + Send + Sync>(
    cuts: &[Cut],
    source: &[T],
    convert: impl Fn(T) -> U + Sync,
) -> Vec<U> {
    let total: usize = cuts.iter().map(|c| c.vertices.len()).sum();
    let mut out = vec![U::default(); total + PADDING];
    split(&mut out, cuts.iter().map(|c| c.vertices.len())).into_par_iter().zip(cuts).for_each_init(
        Vec::new,
        |memory, (out, cut)| {
            let near = of_block(memory, cut, source);
            out.iter_mut().zip(&cut.vertices).for_each(|(o, &v)| *o = convert(near[usize::from(v)]));
        },
    );
    out
}

/// [`vertices`] of normals. Theirs is no type that new memory is known to be zero for, and filling it takes long.
pub(super) fn normals(cuts: &[Cut], source: &[OctNormal]) -> Vec<OctNormal> {
    vertices_as(cuts, source, |normal| normal.0).into_iter().map(OctNormal).collect()
}

/// Per-triangle values in cluster order, padded.
pub(super) fn triangles<T: Copy + Default + Send + Sync>(
    primitives: Option<&[u32]>,
    mut source: Vec<T>,
) -> Vec<T> {
    let n = source.len();
    match primitives {
        None => {
            source.reserve_exact(PADDING);
            source.resize(n + PADDING, T::default());
            source
        }
        Some(primitives) => {
            let mut out = vec![T::default(); n + PADDING];
            let (places, _) = out.split_at_mut(n);
            places
                .par_iter_mut()
                .zip(primitives)
                .with_min_len(1 << 14)
                .for_each(|(o, &p)| *o = source[p as usize]);
            out
        }
    }
}

/// Fills `x`, `y`, `z`, `clusters` and their bounds. `mesh.corners` and `mesh.normals` stand already.
pub(super) fn positions(mesh: &mut ClusteredMesh, cuts: &[Cut], source: &[[f32; 3]]) {
    let lengths = || cuts.iter().map(|c| c.vertices.len());
    let total: usize = lengths().sum();
    assert!(u32::try_from(total).is_ok(), "more than 2^32 vertices in clusters");
    let mut xyz: [Vec<f32>; 3] = std::array::from_fn(|_| vec![0.0; total + PADDING]);
    mesh.clusters = vec![Cluster::default(); cuts.iter().map(|c| c.clusters.len()).sum()];
    let [x, y, z] = &mut xyz;
    let (x, y, z) = (split(x, lengths()), split(y, lengths()), split(z, lengths()));
    let clusters = split(&mut mesh.clusters, cuts.iter().map(|c| c.clusters.len()));
    let firsts = cuts.iter().scan((0u32, 0u32), |next, cut| {
        let first = *next;
        next.0 += cut.vertices.len() as u32;
        next.1 += cut.triangles() as u32;
        Some(first)
    });
    let jobs: Vec<_> = x.into_iter().zip(y).zip(z).zip(clusters).zip(cuts).zip(firsts).collect();
    let (corners, normals) = (&mesh.corners, mesh.normals.as_deref());
    let level = Level::new();
    jobs.into_par_iter().for_each_init(Vec::new, |memory, (((((x, y), z), clusters), cut), first)| {
        let near = of_block(memory, cut, source);
        for (i, &v) in cut.vertices.iter().enumerate() {
            [x[i], y[i], z[i]] = near[usize::from(v)];
        }
        let mut next = first;
        for (cluster, span) in clusters.iter_mut().zip(&cut.clusters) {
            cluster.first_vertex = next.0;
            cluster.first_triangle = next.1;
            cluster.vertices = span.vertices;
            cluster.triangles = span.triangles;
            next.0 += u32::from(span.vertices);
            next.1 += u32::from(span.triangles);
            let begin = (cluster.first_vertex - first.0) as usize;
            let range = begin..begin + usize::from(span.vertices);
            let points = [&x[range.clone()], &y[range.clone()], &z[range]];
            let corners = std::array::from_fn(|k| &corners[k][cluster.triangle_range()]);
            let normals = normals.map(|n| &n[cluster.vertex_range()]);
            dispatch!(level, _ => bounds::bound(cluster, points, normals, corners));
        }
    });
    [mesh.x, mesh.y, mesh.z] = xyz;
}

/// Moves the attributes over, one at a time.
pub(super) fn attributes(mesh: &mut ClusteredMesh, cuts: &[Cut], source: crate::Mesh) {
    let primitives = mesh.primitives.as_deref();
    mesh.vertex_colors = source.vertex_colors.map(|v| vertices(cuts, &v));
    mesh.texcoords = source.texcoords.map(|v| vertices(cuts, &v));
    mesh.face_colors = source.face_colors.map(|v| triangles(primitives, v));
    mesh.triangle_materials = source.triangle_materials.map(|v| triangles(primitives, v));
    mesh.materials = source.materials;
    mesh.face_of_triangle = source.face_of_triangle;
    mesh.attributes = source
        .attributes
        .into_iter()
        .map(|mut a| {
            a.values = match a.domain {
                AttributeDomain::Vertex => vertices(cuts, &a.values),
                AttributeDomain::Triangle => triangles(primitives, a.values),
            };
            a
        })
        .collect();
}
