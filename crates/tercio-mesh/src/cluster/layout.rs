//! Where each part of a cluster is in its memory.
//!
//! With V the vertices and T the triangles, both rounded up to a multiple of [`LANES`]:
//!
//! | part | bytes |
//! |---|---|
//! | the [`Cluster`], then zeros | one line |
//! | x, y, z, each | 4 V |
//! | packed normals, if there are any | 4 V |
//! | first, second and third corners, as vertex numbers in the cluster, each | T |
//! | vertex colours, texture coordinates u and v, vertex attributes, each if there are any | 4 V |
//! | triangle colours, materials, triangle attributes, each if there are any | 4 T |
//! | primitive numbers, packed without gaps, lowest bit first | [`Cluster::number_bits`] / 8 for each triangle |
//! | zeros up to the end of a line | |
//!
//! What a frame reads comes first. Vertices past the last repeat it; corners past the last triangle are 0, so that
//! these triangles have no area.

use serde::{Deserialize, Serialize};

use super::{Cluster, LANES, Line};
use crate::AttributeDomain;

/// What the clusters of a mesh store besides positions and corners.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Layout {
    /// Unit normals at the vertices.
    pub normals: bool,
    /// Colours at the vertices.
    pub vertex_colors: bool,
    /// Texture coordinates at the vertices.
    pub texcoords: bool,
    /// A colour for each triangle.
    pub face_colors: bool,
    /// A material for each triangle.
    pub triangle_materials: bool,
    /// Name and domain of each further scalar.
    pub attributes: Vec<(String, AttributeDomain)>,
    /// The [offset](crate::Attribute::offset) of each of them; none if all are 0.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub offsets: Vec<f64>,
    /// The [name](crate::Attribute::component) of each as a component of an array; none if no attribute has one.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub components: Vec<Option<String>>,
}

/// The smallest multiple of [`LANES`] that is at least `count`.
#[inline(always)]
pub(super) fn padded(count: u8) -> usize {
    usize::from(count).next_multiple_of(LANES)
}

/// Bytes of a 32-bit number.
const WORD: usize = 4;

impl Layout {
    /// Lines that must be readable after the end of the last cluster of a mesh: kernels read tables of
    /// [`MAX_TRIANGLES`](super::MAX_TRIANGLES) corners, however many a cluster has.
    pub const LINES_BEHIND: usize = super::MAX_TRIANGLES / Line::BYTES;

    /// What is added to the values of an attribute.
    pub fn offset(&self, attribute: usize) -> f64 {
        self.offsets.get(attribute).copied().unwrap_or(0.0)
    }

    /// [`Layout::offsets`] of some attributes.
    pub fn offsets_of(attributes: &[crate::Attribute]) -> Vec<f64> {
        let has_any = attributes.iter().any(|a| a.offset != 0.0);
        attributes.iter().filter(|_| has_any).map(|a| a.offset).collect()
    }

    /// What a file calls an attribute as a component of an array.
    pub fn component(&self, attribute: usize) -> Option<&str> {
        self.components.get(attribute)?.as_deref()
    }

    /// [`Layout::components`] of some attributes.
    pub fn components_of(attributes: &[crate::Attribute]) -> Vec<Option<String>> {
        let has_any = attributes.iter().any(|a| a.component.is_some());
        attributes.iter().filter(|_| has_any).map(|a| a.component.clone()).collect()
    }

    /// Lines that a cluster takes.
    pub fn lines(&self, cluster: &Cluster) -> usize {
        let bits = usize::from(cluster.triangles) * usize::from(cluster.number_bits);
        (self.numbers(cluster) + bits.div_ceil(8)).div_ceil(Line::BYTES)
    }

    /// Offset in words of a coordinate of the vertices.
    #[inline(always)]
    pub(super) fn axis(cluster: &Cluster, axis: usize) -> usize {
        Line::BYTES / WORD + axis * padded(cluster.vertices)
    }

    /// Offset in words of the normals.
    #[inline(always)]
    pub(super) fn normals(cluster: &Cluster) -> usize {
        Self::axis(cluster, 3)
    }

    /// Offset in bytes of the first corners.
    #[inline(always)]
    pub(super) fn corners(&self, cluster: &Cluster) -> usize {
        WORD * Self::axis(cluster, 3 + usize::from(self.normals))
    }

    /// Offset in words of array number `place` of the vertex values after the corners.
    #[inline]
    pub(super) fn vertex_values(&self, cluster: &Cluster, place: usize) -> usize {
        (self.corners(cluster) + 3 * padded(cluster.triangles)) / WORD + place * padded(cluster.vertices)
    }

    /// Offset in words of array number `place` of the triangle values.
    #[inline]
    pub(super) fn triangle_values(&self, cluster: &Cluster, place: usize) -> usize {
        self.vertex_values(cluster, self.vertex_count()) + place * padded(cluster.triangles)
    }

    /// Offset in bytes of the primitive numbers.
    #[inline]
    pub(super) fn numbers(&self, cluster: &Cluster) -> usize {
        WORD * self.triangle_values(cluster, self.triangle_count())
    }

    /// Array number of the texture coordinates u among the vertex values.
    #[inline]
    pub(super) fn texcoords_place(&self) -> usize {
        usize::from(self.vertex_colors)
    }

    /// Array number of the materials among the triangle values.
    #[inline]
    pub(super) fn materials_place(&self) -> usize {
        usize::from(self.face_colors)
    }

    /// Array number of an attribute among the values of its domain.
    pub(super) fn attribute_place(&self, attribute: usize) -> usize {
        let domain = self.attributes[attribute].1;
        let before = self.attributes[..attribute].iter().filter(|a| a.1 == domain).count();
        let first = match domain {
            AttributeDomain::Vertex => self.texcoords_place() + 2 * usize::from(self.texcoords),
            AttributeDomain::Triangle => self.materials_place() + usize::from(self.triangle_materials),
        };
        first + before
    }

    /// Number of arrays of vertex values after the corners.
    fn vertex_count(&self) -> usize {
        let attributes = self.attributes.iter().filter(|a| a.1 == AttributeDomain::Vertex).count();
        usize::from(self.vertex_colors) + 2 * usize::from(self.texcoords) + attributes
    }

    /// Number of arrays of triangle values.
    fn triangle_count(&self) -> usize {
        let attributes = self.attributes.iter().filter(|a| a.1 == AttributeDomain::Triangle).count();
        usize::from(self.face_colors) + usize::from(self.triangle_materials) + attributes
    }
}
