//! Reading a clustered mesh triangle by triangle.

use glam::DVec3;

use super::{Cluster, ClusteredMesh, MAX_TRIANGLES};
use crate::Aabb;
use crate::mesh::power_of_two;

impl Default for ClusteredMesh {
    fn default() -> Self {
        Self {
            origin: DVec3::ZERO,
            exponent: 0,
            bounds: Aabb::EMPTY,
            clusters: Vec::new(),
            x: Vec::new(),
            y: Vec::new(),
            z: Vec::new(),
            corners: Default::default(),
            primitives: None,
            normals: None,
            vertex_colors: None,
            face_colors: None,
            texcoords: None,
            triangle_materials: None,
            materials: Vec::new(),
            face_of_triangle: None,
            attributes: Vec::new(),
        }
    }
}

impl Cluster {
    /// Places of the vertices in `x`, `y`, `z` and the vertex attributes.
    #[inline]
    pub fn vertex_range(&self) -> std::ops::Range<usize> {
        let first = self.first_vertex as usize;
        first..first + usize::from(self.vertices)
    }

    /// Places of the triangles in `corners`, `primitives` and the triangle attributes.
    #[inline]
    pub fn triangle_range(&self) -> std::ops::Range<usize> {
        let first = self.first_triangle as usize;
        first..first + usize::from(self.triangles)
    }
}

impl ClusteredMesh {
    /// Length of a unit of `x`, `y`, `z` and of the clusters' bounds.
    pub fn unit(&self) -> f64 {
        power_of_two(self.exponent)
    }

    /// [`ClusteredMesh::bounds`] in the numbers of `x`, `y`, `z`: relative to `origin`, in units of 2^`exponent`.
    pub fn local_bounds(&self) -> Aabb {
        let local = |p: DVec3| (p - self.origin) / self.unit();
        Aabb { min: local(self.bounds.min), max: local(self.bounds.max) }
    }

    /// Number of triangles, padding not counted.
    pub fn triangle_count(&self) -> usize {
        self.clusters.last().map_or(0, |c| c.triangle_range().end)
    }

    /// Number of vertices with their copies, padding not counted.
    pub fn vertex_count(&self) -> usize {
        self.clusters.last().map_or(0, |c| c.vertex_range().end)
    }

    /// Number in the [`crate::Mesh`] of the triangle at a place in `corners`.
    #[inline]
    pub fn primitive(&self, triangle: usize) -> u32 {
        self.primitives.as_ref().map_or(triangle as u32, |p| p[triangle])
    }

    /// Place in `corners` of a slot (`cluster * MAX_TRIANGLES + local number`).
    #[inline]
    pub fn triangle_of_slot(&self, slot: u32) -> usize {
        let slot = slot as usize;
        self.clusters[slot / MAX_TRIANGLES].first_triangle as usize + slot % MAX_TRIANGLES
    }

    /// Number in the [`crate::Mesh`] of the triangle in a slot.
    #[inline]
    pub fn primitive_of_slot(&self, slot: u32) -> u32 {
        self.primitive(self.triangle_of_slot(slot))
    }

    /// Position of a vertex relative to `origin`.
    #[inline]
    pub fn position(&self, vertex: usize) -> [f32; 3] {
        [self.x[vertex], self.y[vertex], self.z[vertex]]
    }

    /// Places of a triangle's corners in `x`, `y`, `z` and the vertex attributes.
    #[inline]
    pub fn corner_places(&self, cluster: &Cluster, triangle: usize) -> [usize; 3] {
        std::array::from_fn(|k| cluster.first_vertex as usize + usize::from(self.corners[k][triangle]))
    }

    /// Every triangle in the order of the clusters: its primitive number and its corners relative to
    /// `origin`, the corner with the lowest mesh vertex number first.
    pub fn triangles(&self) -> impl Iterator<Item = (u32, [[f32; 3]; 3])> + '_ {
        self.clusters.iter().flat_map(move |c| {
            c.triangle_range()
                .map(move |t| (self.primitive(t), self.corner_places(c, t).map(|v| self.position(v))))
        })
    }

    /// Bytes of positions, connectivity, primitive numbers and clusters: what the mesh needs without
    /// attributes.
    pub fn core_memory_bytes(&self) -> usize {
        bytes(&self.clusters)
            + bytes(&self.x)
            + bytes(&self.y)
            + bytes(&self.z)
            + self.corners.iter().map(bytes).sum::<usize>()
            + self.primitives.as_ref().map_or(0, bytes)
    }

    /// Bytes of all arrays.
    pub fn memory_bytes(&self) -> usize {
        self.core_memory_bytes()
            + self.normals.as_ref().map_or(0, bytes)
            + self.vertex_colors.as_ref().map_or(0, bytes)
            + self.face_colors.as_ref().map_or(0, bytes)
            + self.texcoords.as_ref().map_or(0, bytes)
            + self.triangle_materials.as_ref().map_or(0, bytes)
            + self.face_of_triangle.as_ref().map_or(0, bytes)
            + bytes(&self.materials)
            + self.attributes.iter().map(|a| bytes(&a.values)).sum::<usize>()
    }
}

fn bytes<T>(v: &Vec<T>) -> usize {
    v.capacity() * size_of::<T>()
}
