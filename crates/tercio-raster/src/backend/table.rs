//! The vertices of one cluster as tables that fit into vector registers, for shading what it won.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16};
use tercio_mesh::ClusteredMesh;
use tercio_mesh::cluster::{Cluster, MAX_VERTICES};
use tercio_scene::Surface;

use super::corners::{ColorSource, CornerLanes, decode_normal, linear, triangle_color};
use crate::frontend::transform::{ClusterVertices, CornerTable};
use crate::simd::{LANES, dot, each3, live_lanes, load, lookup, part, splat};

/// Positions and normals of a cluster, as the bits of `f32`.
#[derive(Debug)]
pub struct ClusterTable {
    /// Axis, vertex; only where positions are needed.
    position: [[i32; MAX_VERTICES]; 3],
    /// Axis, vertex; only where the mesh has normals.
    normal: [[i32; MAX_VERTICES]; 3],
    /// See [`CornerLanes::normals_agree`].
    pub normals_agree: bool,
    first_vertex: usize,
    first_triangle: usize,
}

impl Default for ClusterTable {
    fn default() -> Self {
        let zero = [[0; MAX_VERTICES]; 3];
        Self { position: zero, normal: zero, normals_agree: false, first_vertex: 0, first_triangle: 0 }
    }
}

/// What the interpolated normal's angle to the side of a triangle's plane must keep from a right angle, as a
/// sine, so that rounding does not change on which side it stands.
const MARGIN: f32 = 0.02;
/// Triangles flatter than this, as a part of their cluster's radius, have no plane that rounding could not turn.
const LEAST_HEIGHT: f32 = 1e-3;

impl ClusterTable {
    /// Decodes the normals of a cluster.
    #[inline(always)]
    pub fn load_normals<S: Simd>(&mut self, simd: S, mesh: &ClusteredMesh, cluster: &Cluster) {
        self.first_vertex = cluster.first_vertex as usize;
        self.first_triangle = cluster.first_triangle as usize;
        self.normals_agree = false;
        let Some(normals) = &mesh.normals else { return };
        let axis = each3!(K => splat(simd, f32::from(cluster.cone_axis[K]) / 127.0));
        let sine = splat(simd, f32::from(cluster.cone_cutoff) / 127.0 + MARGIN);
        let count = usize::from(cluster.vertices);
        let mut agree = cluster.min_height > LEAST_HEIGHT * cluster.radius;
        let mut first = 0;
        while first < count {
            let mut packed = [0; LANES];
            for (to, from) in packed.iter_mut().zip(&normals[self.first_vertex + first..]) {
                *to = from.0 as i32;
            }
            let normal = decode_normal(simd, i32x16::load_array(simd, packed));
            for k in 0..3 {
                normal[k].bitcast::<i32x16<S>>().store_slice(&mut self.normal[k][first..first + LANES]);
            }
            let live = live_lanes(count - first);
            let within = part(
                simd,
                #[inline(always)]
                || dot(normal, axis).simd_gt(sine * dot(normal, normal).sqrt()).to_bitmask() as u32,
            );
            agree &= live & !within == 0;
            first += LANES;
        }
        self.normals_agree = agree;
    }

    /// Copies the positions of a cluster.
    #[inline(always)]
    pub fn load_positions<S: Simd>(&mut self, simd: S, mesh: &ClusteredMesh, cluster: &Cluster) {
        let mut first = 0;
        while first < usize::from(cluster.vertices) {
            let from = cluster.first_vertex as usize + first;
            for (axis, values) in [&mesh.x, &mesh.y, &mesh.z].into_iter().enumerate() {
                load(simd, &values[from..from + LANES])
                    .bitcast::<i32x16<S>>()
                    .store_slice(&mut self.position[axis][first..first + LANES]);
            }
            first += LANES;
        }
    }

    /// Looks up the corners of 16 triangles, given by their numbers in the cluster.
    #[expect(clippy::too_many_arguments, reason = "one call site; a struct would only rename them")]
    #[inline(always)]
    pub fn look_up<S: Simd>(
        &self,
        simd: S,
        (mesh, surface): (&ClusteredMesh, &Surface),
        vertices: &ClusterVertices,
        corners: &CornerTable,
        triangles: &[u8; LANES],
        colors: ColorSource,
        positions: bool,
        lanes: &mut CornerLanes,
    ) {
        let numbers = corners.look_up(simd, triangles);
        lanes.beyond = 0;
        lanes.normals_agree = self.normals_agree;
        for k in 0..3 {
            lookup(simd, &vertices.x, &numbers[k]).store_slice(&mut lanes.x[k]);
            lookup(simd, &vertices.y, &numbers[k]).store_slice(&mut lanes.y[k]);
            let d: f32x16<S> = lookup(simd, &vertices.d, &numbers[k]).bitcast();
            d.store_slice(&mut lanes.d[k]);
            if mesh.normals.is_some() {
                let normal = each3!(A => lookup(simd, &self.normal[A], &numbers[k]).bitcast::<f32x16<S>>());
                lanes.set_normal(k, normal);
            }
            if positions {
                for axis in 0..3 {
                    let p: f32x16<S> = lookup(simd, &self.position[axis], &numbers[k]).bitcast();
                    p.store_slice(&mut lanes.position[k][axis]);
                }
            }
        }
        match (colors, &mesh.vertex_colors) {
            (ColorSource::Base, _) => {}
            (ColorSource::Vertex, Some(of_vertices)) => {
                for k in 0..3 {
                    for lane in 0..LANES {
                        let vertex = self.first_vertex + usize::from(numbers[k][lane]) % MAX_VERTICES;
                        lanes.set_color(k, lane, linear(of_vertices[vertex]));
                    }
                }
            }
            _ => {
                for lane in 0..LANES {
                    let triangle = self.first_triangle + usize::from(triangles[lane]);
                    let color = triangle_color(mesh, surface, triangle);
                    (0..3).for_each(|k| lanes.set_color(k, lane, color));
                }
            }
        }
    }
}
