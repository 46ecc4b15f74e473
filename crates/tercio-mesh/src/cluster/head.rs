//! Bounds and counts of a cluster: what is known without reading its vertices and triangles.

use bytemuck::{Pod, Zeroable};

/// Bounds and counts of a cluster, in the units of its mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Cluster {
    /// Lower corner of the box that contains all vertices, relative to [`super::ClusteredMesh::origin`].
    pub min: [f32; 3],
    /// Its upper corner.
    pub max: [f32; 3],
    /// Radius of a sphere around the centre of the box that contains all vertices, rounded up.
    pub radius: f32,
    /// Lower bound of the smallest triangle height (twice the area over the longest edge); 0 where a triangle
    /// has no area.
    pub min_height: f32,
    /// Axis of the cone that contains all triangle normals, in 1/127; shorter than 1. Triangles without any area are
    /// not in the cone: they have no facing.
    pub cone_axis: [i8; 3],
    /// Sine of the angle between the cone's axis and its side, times the length of `cone_axis`, in 1/127 and rounded
    /// up. 127 means no cone; every test with it fails by itself, because the axis is shorter than 1.
    ///
    /// With `c` and `r` the centre and radius of [`Cluster::sphere`], `a = cone_axis / 127` and
    /// `k = cone_cutoff / 127`, every triangle is back-facing for an eye at `e` if
    /// `dot(c - e, a) > k * |c - e| + r`, and front-facing if `dot(c - e, a) < -(k * |c - e| + r)`.
    /// [`Cluster::faces_away`] and [`Cluster::faces_towards`] are these tests with a margin for rounding.
    pub cone_cutoff: i8,
    /// 1 to [`super::MAX_VERTICES`].
    pub vertices: u8,
    /// 1 to [`super::MAX_TRIANGLES`].
    pub triangles: u8,
    /// A sum of [`Cluster::NORMALS_AGREE`] and [`Cluster::TRANSLUCENT`], or 0.
    pub flags: u8,
    /// Bits per primitive number, 0 to 32: each is stored as its difference to `first_primitive`. With 0 bits the
    /// numbers are consecutive.
    pub number_bits: u8,
    /// The lowest primitive number (number of a triangle in the [`crate::Mesh`]).
    pub first_primitive: u32,
    /// Always 0.
    pub reserved: u32,
}

impl Cluster {
    /// In `flags`: the vertex normals certainly point to the same side of the planes of the cluster's triangles as
    /// the triangles' own normals, so that no pixel has to test it. Never set without vertex normals.
    pub const NORMALS_AGREE: u8 = 1;

    /// In `flags`: a triangle of the cluster is not opaque by the colours of the mesh; see
    /// [`ClusterView::is_translucent`](super::ClusterView::is_translucent).
    pub const TRANSLUCENT: u8 = 2;

    /// Is [`Cluster::TRANSLUCENT`] set?
    #[inline(always)]
    pub fn is_translucent(&self) -> bool {
        self.flags & Self::TRANSLUCENT != 0
    }

    /// Is [`Cluster::NORMALS_AGREE`] set?
    #[inline(always)]
    pub fn normals_agree(&self) -> bool {
        self.flags & Self::NORMALS_AGREE != 0
    }
}
