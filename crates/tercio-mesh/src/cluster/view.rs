//! Read access to a cluster.

use super::layout::padded;
use super::{Cluster, Layout, Line, MAX_TRIANGLES};
use crate::{AttributeDomain, FileMaterial, OctNormal};

/// One cluster of a mesh, read from its stretch of memory.
///
/// Arrays of vertices and triangles are padded to a multiple of [`LANES`](super::LANES): vertices past the last repeat
/// it, triangles past the last have the corners 0, 0, 0.
#[derive(Clone, Copy, Debug)]
pub struct ClusterView<'a> {
    /// The memory of the cluster, and what follows it.
    lines: &'a [Line],
    layout: &'a Layout,
}

impl<'a> ClusterView<'a> {
    /// The cluster whose memory begins with the first of `lines`. At least [`Layout::LINES_BEHIND`] lines must follow
    /// its own.
    ///
    /// # Panics
    /// If there is no line. Methods panic where there are fewer lines than the cluster needs.
    #[inline(always)]
    pub fn new(lines: &'a [Line], layout: &'a Layout) -> Self {
        assert!(!lines.is_empty(), "a stretch has a line");
        Self { lines, layout }
    }

    /// Bounds and counts.
    #[inline(always)]
    pub fn head(&self) -> &'a Cluster {
        bytemuck::from_bytes(&self.lines[0].0[..size_of::<Cluster>()])
    }

    /// The memory of the cluster, and what follows it.
    pub(super) fn lines(&self) -> &'a [Line] {
        self.lines
    }

    /// What the clusters of the mesh store.
    #[inline(always)]
    pub fn layout(&self) -> &'a Layout {
        self.layout
    }

    /// Number of vertices, not padded.
    #[inline(always)]
    pub fn vertices(&self) -> usize {
        usize::from(self.head().vertices)
    }

    /// Number of triangles, not padded.
    #[inline(always)]
    pub fn triangles(&self) -> usize {
        usize::from(self.head().triangles)
    }

    /// x, y and z of the vertices relative to the mesh's origin, in its unit; padded.
    #[inline(always)]
    pub fn positions(&self) -> [&'a [f32]; 3] {
        let head = self.head();
        let values: &[f32] = bytemuck::cast_slice(self.lines);
        [0, 1, 2].map(|axis| &values[Layout::axis(head, axis)..Layout::axis(head, axis + 1)])
    }

    /// Position of a vertex relative to the mesh's origin, in its unit.
    #[inline]
    pub fn position(&self, vertex: usize) -> [f32; 3] {
        self.positions().map(|axis| axis[vertex])
    }

    /// Normals of the vertices; padded.
    #[inline(always)]
    pub fn normals(&self) -> Option<&'a [OctNormal]> {
        let head = self.head();
        let first = Layout::normals(head);
        self.layout.normals.then(
            #[inline(always)]
            || &bytemuck::cast_slice(self.lines)[first..first + padded(head.vertices)],
        )
    }

    /// First, second and third corners of the triangles, as vertex numbers in the cluster; padded. The corner with
    /// the lowest vertex number of the [`crate::Mesh`] comes first ([`crate::Mesh::canonical`]).
    #[inline(always)]
    pub fn corners(&self) -> [&'a [u8]; 3] {
        let head = self.head();
        let bytes: &[u8] = bytemuck::cast_slice(self.lines);
        let (first, each) = (self.layout.corners(head), padded(head.triangles));
        [0, 1, 2].map(|k| &bytes[first + k * each..first + (k + 1) * each])
    }

    /// As [`ClusterView::corners`], but always [`MAX_TRIANGLES`] triangles; those past the cluster's last are not
    /// valid.
    #[inline(always)]
    pub fn corner_tables(&self) -> [&'a [u8; MAX_TRIANGLES]; 3] {
        let head = self.head();
        let bytes: &[u8] = bytemuck::cast_slice(self.lines);
        let (first, each) = (self.layout.corners(head), padded(head.triangles));
        [0, 1, 2].map(|k| match bytes[first + k * each..].first_chunk() {
            Some(table) => table,
            None => unreachable!("`LINES_BEHIND` lines follow the last cluster"),
        })
    }

    /// Corners of one triangle.
    #[inline]
    pub fn corners_of(&self, triangle: usize) -> [u8; 3] {
        self.corners().map(|corner| corner[triangle])
    }

    /// Positions of the corners of one triangle.
    #[inline]
    pub fn corner_positions(&self, triangle: usize) -> [[f32; 3]; 3] {
        self.corners_of(triangle).map(|corner| self.position(usize::from(corner)))
    }

    /// sRGB colour and linear alpha of each vertex; padded.
    #[inline]
    pub fn vertex_colors(&self) -> Option<&'a [[u8; 4]]> {
        self.layout.vertex_colors.then(|| bytemuck::cast_slice(self.vertex_values(0)))
    }

    /// Texture coordinates u and v of each vertex; padded.
    pub fn texcoords(&self) -> Option<[&'a [f32]; 2]> {
        let place = self.layout.texcoords_place();
        self.layout.texcoords.then(|| [self.vertex_values(place), self.vertex_values(place + 1)])
    }

    /// sRGB colour and linear alpha of each triangle; padded.
    #[inline]
    pub fn face_colors(&self) -> Option<&'a [[u8; 4]]> {
        self.layout.face_colors.then(|| bytemuck::cast_slice(self.triangle_values(0)))
    }

    /// Material of each triangle; padded.
    #[inline]
    pub fn triangle_materials(&self) -> Option<&'a [u32]> {
        let place = self.layout.materials_place();
        self.layout.triangle_materials.then(|| bytemuck::cast_slice(self.triangle_values(place)))
    }

    /// Is any alpha below 1 in what colours the cluster: triangle colours, else vertex colours, else the materials?
    pub fn is_translucent(&self, materials: &[FileMaterial]) -> bool {
        let any = |colors: &[[u8; 4]]| colors.iter().any(|color| color[3] < u8::MAX);
        let (vertices, triangles) = (usize::from(self.head().vertices), self.triangles());
        if let Some(colors) = self.face_colors() {
            return any(&colors[..triangles]);
        }
        if let Some(colors) = self.vertex_colors() {
            return any(&colors[..vertices]);
        }
        let Some(numbers) = self.triangle_materials() else { return false };
        let opacity = |number: u32| materials.get(number as usize).map_or(1.0, |m| m.opacity);
        numbers[..triangles].iter().any(|&number| opacity(number) < 1.0)
    }

    /// Values of one of [`Layout::attributes`], one for each vertex or triangle; padded.
    ///
    /// # Panics
    /// If there is no such attribute.
    pub fn attribute(&self, number: usize) -> &'a [f32] {
        let place = self.layout.attribute_place(number);
        match self.layout.attributes[number].1 {
            AttributeDomain::Vertex => self.vertex_values(place),
            AttributeDomain::Triangle => self.triangle_values(place),
        }
    }

    /// Number in the [`crate::Mesh`] of a triangle.
    #[inline]
    pub fn primitive(&self, triangle: usize) -> u32 {
        let head = self.head();
        if head.number_bits == 0 {
            return head.first_primitive + triangle as u32;
        }
        head.first_primitive.wrapping_add(self.number(self.layout.numbers(head), triangle))
    }

    /// [`ClusterView::primitive`] of several triangles.
    #[inline]
    pub fn primitives_of<const N: usize>(&self, triangles: &[u8; N]) -> [u32; N] {
        let head = *self.head();
        if head.number_bits == 0 {
            return triangles.map(|triangle| head.first_primitive + u32::from(triangle));
        }
        let first = self.layout.numbers(&head);
        triangles.map(|triangle| head.first_primitive.wrapping_add(self.number(first, usize::from(triangle))))
    }

    /// The line in which the number begins that [`ClusterView::primitive`] reads; none where the numbers are consecutive.
    #[inline]
    pub fn primitive_lines(&self, triangle: usize) -> &'a [Line] {
        let head = self.head();
        let bits = usize::from(head.number_bits);
        let byte = self.layout.numbers(head) + triangle * bits / 8;
        &self.lines[byte / size_of::<Line>()..][..usize::from(bits > 0)]
    }

    /// [`ClusterView::primitive`] of all triangles.
    pub fn primitives(&self) -> impl Iterator<Item = u32> + use<'a> {
        let (view, head) = (*self, *self.head());
        let first = view.layout.numbers(&head);
        (0..view.triangles()).map(move |triangle| match head.number_bits {
            0 => head.first_primitive + triangle as u32,
            _ => head.first_primitive.wrapping_add(view.number(first, triangle)),
        })
    }

    /// The number of a triangle; `first` is the byte offset of the cluster's primitive numbers.
    #[inline(always)]
    fn number(&self, first: usize, triangle: usize) -> u32 {
        let bits = usize::from(self.head().number_bits);
        let (byte, shift) = (first + triangle * bits / 8, triangle * bits % 8);
        let bytes: &[u8] = bytemuck::cast_slice(self.lines);
        match bytes[byte..].first_chunk() {
            Some(&eight) => (u64::from_le_bytes(eight) >> shift & ((1 << bits) - 1)) as u32,
            None => unreachable!("`LINES_BEHIND` lines follow the last cluster"),
        }
    }

    /// The greatest [`ClusterView::primitive`] of the cluster.
    pub fn greatest_primitive(&self) -> u64 {
        let head = self.head();
        let (first, count) = (self.layout.numbers(head), self.triangles());
        let above = match head.number_bits {
            0 => count as u32 - 1,
            _ => (0..count).map(|triangle| self.number(first, triangle)).fold(0, u32::max),
        };
        u64::from(head.first_primitive) + u64::from(above)
    }

    /// The line that holds the head.
    #[inline(always)]
    pub fn first_line(&self) -> &'a [Line] {
        &self.lines[..1]
    }

    /// The lines of the cluster that a frame without colours and attributes reads.
    #[inline(always)]
    pub fn hot_lines(&self) -> &'a [Line] {
        let head = self.head();
        let end = self.layout.corners(head) + 3 * padded(head.triangles);
        &self.lines[..end.div_ceil(Line::BYTES)]
    }

    fn vertex_values(&self, place: usize) -> &'a [f32] {
        let head = self.head();
        let first = self.layout.vertex_values(head, place);
        &bytemuck::cast_slice(self.lines)[first..first + padded(head.vertices)]
    }

    fn triangle_values(&self, place: usize) -> &'a [f32] {
        let head = self.head();
        let first = self.layout.triangle_values(head, place);
        &bytemuck::cast_slice(self.lines)[first..first + padded(head.triangles)]
    }
}
