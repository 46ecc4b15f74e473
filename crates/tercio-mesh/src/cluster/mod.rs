//! The mesh cut into clusters: small, compact pieces that are culled and transformed as one.
//!
//! Vertices that several clusters share stand in each of them, so that a cluster is read as one stretch of
//! memory. Arrays are structures of arrays: a kernel loads 16 vertices or triangles at a time, and may load
//! past a cluster's end into its neighbour (the last cluster is followed by padding).
//!
//! The work walks through the modules in this order: [`partition`] is the entrance, [`crate::blocks`] bring
//! neighbouring triangles together, `runs` or `grow` (with the `rim` of the open cluster) cuts a block into
//! clusters, `gather` copies vertices and attributes to their new places, `bounds` finds each cluster's box
//! and cone. [`cone`] holds the tests that a renderer makes with them.

mod access;
mod bounds;
mod cone;
mod gather;
mod grow;
mod partition;
mod rim;
mod runs;
mod shuffle;

pub use crate::blocks::Order;
pub use partition::{PartitionOptions, partition, partition_blocks};

use glam::DVec3;

use crate::{Aabb, Attribute, FileMaterial, OctNormal};

/// The most vertices a cluster holds: what a renderer keeps transformed in vector registers.
pub const MAX_VERTICES: usize = 64;
/// The most triangles a cluster holds; a triangle's slot is `cluster * MAX_TRIANGLES + local number`.
pub const MAX_TRIANGLES: usize = 128;
/// Elements that may be read behind the end of every array that kernels load many at a time.
pub const PADDING: usize = MAX_VERTICES;

/// Where a cluster stands in the arrays of its mesh, and what bounds it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct Cluster {
    /// First vertex in `x`, `y`, `z` and the vertex attributes.
    pub first_vertex: u32,
    /// First triangle in `corners` and the triangle attributes.
    pub first_triangle: u32,
    /// 1 to [`MAX_VERTICES`].
    pub vertices: u8,
    /// 1 to [`MAX_TRIANGLES`].
    pub triangles: u8,
    /// Sine of the angle between the cone's axis and its side, times the length of `cone_axis`, in 1/127 and
    /// rounded up. 127 means no cone; every test with it fails by itself, because the axis is shorter than 1.
    ///
    /// With `c` and `r` the centre and radius of [`Cluster::sphere`], `a = cone_axis / 127` and
    /// `k = cone_cutoff / 127`, every triangle shows its back to an eye at `e` if
    /// `dot(c - e, a) > k * |c - e| + r`, and its front if `dot(c - e, a) < -(k * |c - e| + r)`.
    /// [`Cluster::faces_away`] and [`Cluster::faces_towards`] are these tests with room for rounding.
    pub cone_cutoff: i8,
    /// Unused.
    pub reserved: u8,
    /// Object-space box, lower corner.
    pub min: [f32; 3],
    /// Object-space box, upper corner.
    pub max: [f32; 3],
    /// Axis of the cone that holds all triangle normals, in 1/127; shorter than 1. Triangles without any area
    /// are not in the cone: no facing can be told from them.
    pub cone_axis: [i8; 3],
    /// True only if the vertex normals surely lie on the same side of the planes of the cluster's triangles as
    /// the triangles' own normals: then no pixel needs to ask. False without vertex normals.
    pub normals_agree: bool,
    /// Radius of a sphere round the middle of the box that holds all vertices, rounded up.
    pub radius: f32,
    /// Lower bound of the smallest triangle height (twice the area over the longest edge), in object units;
    /// 0 where a triangle has no area.
    pub min_height: f32,
}

/// A mesh partitioned into clusters; what the renderer draws.
///
/// It keeps no indexed copy of the mesh: positions stand once a cluster, connectivity is three bytes a
/// triangle.
#[derive(Clone, Debug)]
pub struct ClusteredMesh {
    /// Position in object space of the point that `x`, `y`, `z` are relative to.
    pub origin: DVec3,
    /// log2 of the length of a unit of `x`, `y`, `z`; see [`crate::Mesh::exponent`].
    pub exponent: i32,
    /// World-space bounds of the vertices that triangles use.
    pub bounds: Aabb,
    /// The clusters.
    pub clusters: Vec<Cluster>,
    /// Vertex positions relative to `origin`, cluster after cluster, then [`PADDING`].
    pub x: Vec<f32>,
    /// See `x`.
    pub y: Vec<f32>,
    /// See `x`.
    pub z: Vec<f32>,
    /// First, second and third corner of each triangle, as vertex numbers inside the cluster, then
    /// [`PADDING`]. The corner with the lowest vertex number of the [`crate::Mesh`] comes first
    /// ([`crate::Mesh::canonical`]).
    pub corners: [Vec<u8>; 3],
    /// Number in the [`crate::Mesh`] of each triangle, then [`PADDING`]; `None` where triangles stand in
    /// the order of the mesh.
    pub primitives: Option<Vec<u32>>,
    /// Vertex normals, parallel to `x`.
    pub normals: Option<Vec<OctNormal>>,
    /// Vertex colours, parallel to `x`.
    pub vertex_colors: Option<Vec<[u8; 4]>>,
    /// Triangle colours, parallel to `corners`.
    pub face_colors: Option<Vec<[u8; 4]>>,
    /// Texture coordinates, parallel to `x`.
    pub texcoords: Option<Vec<[f32; 2]>>,
    /// Material of each triangle, parallel to `corners`.
    pub triangle_materials: Option<Vec<u32>>,
    /// Materials that the file names.
    pub materials: Vec<FileMaterial>,
    /// Input face of each primitive, in the order of the mesh (not of the clusters).
    pub face_of_triangle: Option<Vec<u32>>,
    /// Attributes, vertex ones parallel to `x`, triangle ones parallel to `corners`.
    pub attributes: Vec<Attribute>,
}
