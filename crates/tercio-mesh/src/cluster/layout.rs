//! Where in its stretch each part of a cluster lies.
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
//! | primitive numbers, one behind the other, lowest bit first | [`Cluster::number_bits`] / 8 for each triangle |
//! | zeros up to a whole line | |
//!
//! What a frame reads stands first. Vertices past the last repeat it; corners past the last triangle are 0, so
//! that they span no area.

use serde::{Deserialize, Serialize};

use super::{Cluster, LANES, Line};
use crate::AttributeDomain;

/// What the clusters of a mesh hold beside positions and corners.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
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
    /// Names and owners of the other scalars.
    pub attributes: Vec<(String, AttributeDomain)>,
}

/// A whole number of vectors that holds so many vertices or triangles.
#[inline(always)]
pub(super) fn padded(count: u8) -> usize {
    usize::from(count).next_multiple_of(LANES)
}

/// Bytes of a number of 32 bits.
const WORD: usize = 4;

impl Layout {
    /// Lines that may be read behind the last stretch of a mesh: kernels copy tables of
    /// [`MAX_TRIANGLES`](super::MAX_TRIANGLES) corners whatever a cluster has.
    pub const LINES_BEHIND: usize = super::MAX_TRIANGLES / Line::BYTES;

    /// Lines of a cluster's stretch.
    pub fn lines(&self, cluster: &Cluster) -> usize {
        let bits = usize::from(cluster.triangles) * usize::from(cluster.number_bits);
        (self.numbers(cluster) + bits.div_ceil(8)).div_ceil(Line::BYTES)
    }

    /// Where a coordinate of the vertices begins, in words.
    #[inline(always)]
    pub(super) fn axis(cluster: &Cluster, axis: usize) -> usize {
        Line::BYTES / WORD + axis * padded(cluster.vertices)
    }

    /// Where the normals begin, in words.
    #[inline(always)]
    pub(super) fn normals(cluster: &Cluster) -> usize {
        Self::axis(cluster, 3)
    }

    /// Where the first corners begin, in bytes.
    #[inline(always)]
    pub(super) fn corners(&self, cluster: &Cluster) -> usize {
        WORD * Self::axis(cluster, 3 + usize::from(self.normals))
    }

    /// Where the vertex values behind the corners begin, in words; `place` of them stand before.
    #[inline]
    pub(super) fn vertex_values(&self, cluster: &Cluster, place: usize) -> usize {
        (self.corners(cluster) + 3 * padded(cluster.triangles)) / WORD + place * padded(cluster.vertices)
    }

    /// Where the triangle values begin, in words; `place` of them stand before.
    #[inline]
    pub(super) fn triangle_values(&self, cluster: &Cluster, place: usize) -> usize {
        self.vertex_values(cluster, self.vertex_count()) + place * padded(cluster.triangles)
    }

    /// Where the primitive numbers begin, in bytes.
    #[inline]
    pub(super) fn numbers(&self, cluster: &Cluster) -> usize {
        WORD * self.triangle_values(cluster, self.triangle_count())
    }

    /// Place of the texture coordinates u among the vertex values.
    #[inline]
    pub(super) fn texcoords_place(&self) -> usize {
        usize::from(self.vertex_colors)
    }

    /// Place of the materials among the triangle values.
    #[inline]
    pub(super) fn materials_place(&self) -> usize {
        usize::from(self.face_colors)
    }

    /// Place of an attribute among the values of its domain.
    pub(super) fn attribute_place(&self, attribute: usize) -> usize {
        let domain = self.attributes[attribute].1;
        let before = self.attributes[..attribute].iter().filter(|a| a.1 == domain).count();
        let first = match domain {
            AttributeDomain::Vertex => self.texcoords_place() + 2 * usize::from(self.texcoords),
            AttributeDomain::Triangle => self.materials_place() + usize::from(self.triangle_materials),
        };
        first + before
    }

    /// Values at the vertices behind the corners.
    fn vertex_count(&self) -> usize {
        let attributes = self.attributes.iter().filter(|a| a.1 == AttributeDomain::Vertex).count();
        usize::from(self.vertex_colors) + 2 * usize::from(self.texcoords) + attributes
    }

    /// Values of the triangles.
    fn triangle_count(&self) -> usize {
        let attributes = self.attributes.iter().filter(|a| a.1 == AttributeDomain::Triangle).count();
        usize::from(self.face_colors) + usize::from(self.triangle_materials) + attributes
    }
}
