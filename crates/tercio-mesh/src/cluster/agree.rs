//! Do the vertex normals of a cluster agree with its triangles?

use fearless_simd::{Level, dispatch};
use glam::DVec3;
use rayon::prelude::*;

use super::{Cluster, ClusteredMesh};
use crate::OctNormal;

/// What a vertex normal's angle to the planes of its triangles must keep from zero, as a sine, so that rounding
/// anywhere between here and a pixel does not change on which side it stands.
const MARGIN: f32 = 0.02;
/// Triangles flatter than this, as a part of their cluster's radius, have no plane that rounding could not turn.
const LEAST_HEIGHT: f32 = 1e-3;
/// Nor have triangles two of whose edges meet at a smaller angle, as a sine.
const LEAST_SINE: f64 = 1e-3;

/// Notes it at every cluster ([`Cluster::normals_agree`]).
pub(super) fn note(mesh: &mut ClusteredMesh) {
    let mut clusters = std::mem::take(&mut mesh.clusters);
    if let Some(normals) = &mesh.normals {
        let level = Level::new();
        clusters.par_iter_mut().with_min_len(1 << 8).for_each(|cluster| {
            let of_cluster = &normals[cluster.vertex_range()];
            let surely = dispatch!(level, _ => with_cone(cluster, of_cluster));
            cluster.normals_agree = surely || with_triangles(mesh, cluster, of_cluster);
        });
    }
    mesh.clusters = clusters;
}

/// Every normal stands farther from the planes than the cone of the triangles' normals is wide: quick, and most
/// clusters pass.
#[inline(always)]
fn with_cone(cluster: &Cluster, normals: &[OctNormal]) -> bool {
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

/// The normals of every triangle's own corners stand on the side of its plane.
fn with_triangles(mesh: &ClusteredMesh, cluster: &Cluster, normals: &[OctNormal]) -> bool {
    let first = cluster.first_vertex as usize;
    cluster.triangle_range().all(|triangle| {
        let corners = mesh.corners.each_ref().map(|corner| usize::from(corner[triangle]));
        let [a, b, c] = corners.map(|v| {
            let v = first + v;
            DVec3::new(mesh.x[v].into(), mesh.y[v].into(), mesh.z[v].into())
        });
        let plane = (b - a).cross(c - a);
        let length = plane.length();
        length > LEAST_SINE * (b - a).length() * (c - a).length()
            && corners.iter().all(|&v| {
                let normal = DVec3::from_array(normals[v].decode().map(f64::from));
                plane.dot(normal) > f64::from(MARGIN) * length * normal.length()
            })
    })
}
