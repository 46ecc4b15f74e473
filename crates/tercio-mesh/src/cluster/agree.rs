//! Do the vertex normals of a cluster agree with its triangles?

use fearless_simd::{Level, dispatch};
use rayon::prelude::*;

use super::{Cluster, ClusteredMesh};
use crate::OctNormal;

/// What a vertex normal's angle to the planes of the triangles must keep from zero, as a sine, so that rounding
/// anywhere between here and a pixel does not change on which side it stands.
const MARGIN: f32 = 0.02;
/// Triangles flatter than this, as a part of their cluster's radius, have no plane that rounding could not turn.
const LEAST_HEIGHT: f32 = 1e-3;

/// Notes it at every cluster ([`Cluster::normals_agree`]).
pub(super) fn note(mesh: &mut ClusteredMesh) {
    let Some(normals) = &mesh.normals else { return };
    let level = Level::new();
    mesh.clusters.par_iter_mut().with_min_len(1 << 8).for_each(|cluster| {
        let normals = &normals[cluster.vertex_range()];
        cluster.normals_agree = dispatch!(level, _ => agree(cluster, normals));
    });
}

/// Every normal stands farther from the planes than the cone of the triangles' normals is wide.
#[inline(always)]
fn agree(cluster: &Cluster, normals: &[OctNormal]) -> bool {
    if cluster.min_height <= LEAST_HEIGHT * cluster.radius {
        return false;
    }
    let axis = cluster.cone_axis.map(|a| f32::from(a) / 127.0);
    let sine = f32::from(cluster.cone_cutoff) / 127.0 + MARGIN;
    let mut all = true;
    for normal in normals {
        let [x, y, z] = normal.decode();
        let along = x * axis[0] + y * axis[1] + z * axis[2];
        all &= (along > 0.0) & (along * along > sine * sine * (x * x + y * y + z * z));
    }
    all
}
