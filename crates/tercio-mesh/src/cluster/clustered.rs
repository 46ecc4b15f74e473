//! The mesh that a renderer draws.

use std::sync::OnceLock;

use bytemuck::Zeroable;
use glam::{DVec3, Vec3};

use super::farthest::Corners;
use super::{Buffer, Cluster, ClusterView, Layout, Line, MAX_TRIANGLES};
use crate::mesh::power_of_two;
use crate::{Aabb, FileMaterial, checksum};

/// A mesh partitioned into clusters; what the renderer draws.
///
/// It keeps no indexed copy of the mesh: each cluster has its own copy of its vertices, and connectivity takes three
/// bytes per triangle.
#[derive(Clone, Debug)]
pub struct ClusteredMesh {
    /// Position in object space of the point that vertex positions are relative to.
    pub origin: DVec3,
    /// log2 of the length of a unit of the positions; see [`crate::Mesh::exponent`].
    pub exponent: i32,
    /// World-space bounds of the vertices that triangles use; of the whole model if the mesh is a
    /// [part](ClusteredMesh::as_part_of) of one.
    pub bounds: Aabb,
    /// Materials that the file names.
    pub materials: Vec<FileMaterial>,
    /// Input face of each primitive, in the order of the mesh (not of the clusters).
    pub face_of_triangle: Option<Buffer<u32>>,
    /// Input face of each triangle by its slot (`cluster * MAX_TRIANGLES + local number`): in place of `face_of_triangle` where
    /// the mesh has clusters of several parts of a model, so that primitives are not numbered without gaps.
    pub(crate) face_of_slot: Option<Vec<u32>>,
    /// What the clusters hold.
    pub(crate) layout: Layout,
    /// The heads, which are also the first bytes of every stretch: all that culling needs.
    pub(crate) clusters: Buffer<Cluster>,
    /// First line of each cluster, and the end of the last cluster.
    pub(crate) starts: Buffer<u32>,
    /// The stretches of all clusters, then [`Layout::LINES_BEHIND`] lines of zeros.
    pub(crate) lines: Buffer<Line>,
    /// Vertices of all clusters.
    pub(crate) vertices: u64,
    /// Triangles of all clusters.
    pub(crate) triangles: u64,
    /// A cluster is translucent; of the whole model if the mesh is a part of one.
    pub(crate) translucent: bool,
    /// [`ClusteredMesh::checksum`], once it was asked for.
    pub(crate) checksum: OnceLock<u64>,
    /// Boxes of groups of clusters, once [`ClusteredMesh::farthest`] needed them.
    pub(crate) groups: OnceLock<Vec<Corners>>,
}

impl Default for ClusteredMesh {
    fn default() -> Self {
        Self {
            origin: DVec3::ZERO,
            exponent: 0,
            bounds: Aabb::EMPTY,
            materials: Vec::new(),
            face_of_triangle: None,
            face_of_slot: None,
            layout: Layout::default(),
            clusters: Buffer::default(),
            starts: vec![0].into(),
            lines: vec![Line::zeroed(); Layout::LINES_BEHIND].into(),
            vertices: 0,
            triangles: 0,
            translucent: false,
            checksum: OnceLock::new(),
            groups: OnceLock::new(),
        }
    }
}

impl ClusteredMesh {
    /// What the clusters store besides positions and corners.
    #[inline(always)]
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// Bounds and counts of all clusters.
    #[inline(always)]
    pub fn clusters(&self) -> &[Cluster] {
        &self.clusters
    }

    /// A cluster by its number.
    ///
    /// # Panics
    /// If there is no such cluster.
    #[inline(always)]
    pub fn cluster(&self, number: usize) -> ClusterView<'_> {
        ClusterView::new(&self.lines[self.starts[number] as usize..], &self.layout)
    }

    /// The contiguous memory of a cluster, which can be moved to any address.
    ///
    /// # Panics
    /// If there is no such cluster.
    pub fn stretch(&self, number: usize) -> &[Line] {
        &self.lines[self.starts[number] as usize..self.starts[number + 1] as usize]
    }

    /// All clusters in order.
    pub fn views(&self) -> impl ExactSizeIterator<Item = ClusterView<'_>> {
        (0..self.clusters.len()).map(|number| self.cluster(number))
    }

    /// Fills in the sums and bounds that follow from the clusters' heads.
    pub(crate) fn sum_up(&mut self) {
        let (unit, origin) = (self.unit(), self.origin);
        let world = |p: [f32; 3]| origin + Vec3::from(p).as_dvec3() * unit;
        let add = |all: Aabb, c: &Cluster| all.union(Aabb { min: world(c.min), max: world(c.max) });
        self.bounds = self.clusters.iter().fold(Aabb::EMPTY, add);
        self.vertices = self.clusters.iter().map(|head| u64::from(head.vertices)).sum();
        self.triangles = self.clusters.iter().map(|head| u64::from(head.triangles)).sum();
        self.translucent = self.clusters.iter().any(Cluster::is_translucent);
    }

    /// Length of a unit of the positions and of the clusters' bounds.
    pub fn unit(&self) -> f64 {
        power_of_two(self.exponent)
    }

    /// Position of a vertex of one of its clusters in object space.
    ///
    /// # Panics
    /// If the cluster has no such vertex.
    pub fn position(&self, cluster: &ClusterView, vertex: usize) -> DVec3 {
        self.origin + DVec3::from(cluster.position(vertex).map(f64::from)) * self.unit()
    }

    /// [`ClusteredMesh::bounds`] in the coordinates of the positions: relative to `origin`, in units of 2^`exponent`.
    pub fn local_bounds(&self) -> Aabb {
        let local = |p: DVec3| (p - self.origin) / self.unit();
        Aabb { min: local(self.bounds.min), max: local(self.bounds.max) }
    }

    /// Is any triangle not opaque by the colours of the mesh (triangle colours, else vertex colours, else materials)? Of the
    /// whole model if the mesh is a [part](ClusteredMesh::as_part_of) of one.
    #[inline(always)]
    pub fn is_translucent(&self) -> bool {
        self.translucent
    }

    /// A checksum of the clusters and of the faces' numbers: equal for equal meshes, almost certainly different for others; of
    /// the whole model if the mesh is a [part](ClusteredMesh::as_part_of) of one.
    /// Computed by all threads when it is first asked for, at some gigabytes a second.
    pub fn checksum(&self) -> u64 {
        *self.checksum.get_or_init(|| {
            let faces = self.face_of_triangle.as_deref().map_or(&[][..], bytemuck::cast_slice);
            let parts = [bytemuck::cast_slice(&self.starts), bytemuck::cast_slice(&self.lines), faces];
            let sums = parts.map(checksum::of);
            let place = [self.origin.x, self.origin.y, self.origin.z].map(f64::to_bits);
            let lengths = parts.map(|part| part.len() as u64);
            let all = [&sums[..], &lengths, &place, &[self.exponent as u64]].concat();
            checksum::of(bytemuck::cast_slice(&all))
        })
    }

    /// Number of triangles.
    pub fn triangle_count(&self) -> usize {
        self.triangles as usize
    }

    /// Number of vertices, counting the copies in several clusters.
    pub fn vertex_count(&self) -> usize {
        self.vertices as usize
    }

    /// Number in the [`crate::Mesh`] of the triangle in a slot (`cluster * MAX_TRIANGLES + local number`).
    ///
    /// # Panics
    /// If there is no such triangle.
    #[inline]
    pub fn primitive_of_slot(&self, slot: u32) -> u32 {
        let slot = slot as usize;
        self.cluster(slot / MAX_TRIANGLES).primitive(slot % MAX_TRIANGLES)
    }

    /// Number of the input face that a triangle of a cluster comes from, counted from the first of this mesh.
    ///
    /// # Panics
    /// If there is no such cluster or triangle.
    #[inline]
    pub fn face(&self, cluster: usize, triangle: usize) -> u32 {
        let primitive = self.cluster(cluster).primitive(triangle);
        match (&self.face_of_triangle, &self.face_of_slot) {
            (Some(faces), _) => faces[primitive as usize],
            (None, None) => primitive,
            (None, Some(faces)) => faces[cluster * MAX_TRIANGLES + triangle],
        }
    }

    /// [`ClusteredMesh::face`] of all triangles of a cluster.
    ///
    /// # Panics
    /// If there is no such cluster.
    pub fn faces(&self, cluster: usize) -> impl Iterator<Item = u32> + '_ {
        let view = self.cluster(cluster);
        let of_primitive = self.face_of_triangle.as_deref();
        let of_slot = self.face_of_slot.as_deref().map(|faces| &faces[cluster * MAX_TRIANGLES..]);
        view.primitives().enumerate().map(move |(triangle, primitive)| match (of_primitive, of_slot) {
            (Some(faces), _) => faces[primitive as usize],
            (None, None) => primitive,
            (None, Some(faces)) => faces[triangle],
        })
    }

    /// Every triangle in the order of the clusters: its primitive number and its corners relative to
    /// `origin`, the corner with the lowest mesh vertex number first.
    pub fn triangles(&self) -> impl Iterator<Item = (u32, [[f32; 3]; 3])> + '_ {
        self.views().flat_map(|c| (0..c.triangles()).map(move |t| (c.primitive(t), c.corner_positions(t))))
    }

    /// Bytes of positions, connectivity, primitive numbers and bounds: what the mesh would need without normals,
    /// colours and other attributes.
    pub fn core_bytes(&self) -> usize {
        let bare = Layout::default();
        let lines: usize = self.clusters.iter().map(|head| bare.lines(head)).sum();
        size_of_val(&*self.clusters) + size_of_val(&*self.starts) + lines * Line::BYTES
    }

    /// Bytes of the mesh that are in a mapped file.
    pub fn mapped_bytes(&self) -> usize {
        self.clusters.mapped_bytes()
            + self.starts.mapped_bytes()
            + self.lines.mapped_bytes()
            + self.face_of_triangle.as_ref().map_or(0, Buffer::mapped_bytes)
    }

    /// Bytes of memory that the mesh takes; what is in a mapped file is not counted.
    pub fn memory_bytes(&self) -> usize {
        self.clusters.owned_bytes()
            + self.starts.owned_bytes()
            + self.lines.owned_bytes()
            + self.face_of_triangle.as_ref().map_or(0, Buffer::owned_bytes)
            + self.face_of_slot.as_ref().map_or(0, |faces| faces.capacity() * size_of::<u32>())
            + self.materials.capacity() * size_of::<FileMaterial>()
    }
}
