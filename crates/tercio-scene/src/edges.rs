//! The edges of a surface: lines along the sides of its triangles.

use tercio_mesh::color::srgb_to_linear;

/// Lines along the sides of a surface's triangles, drawn when the triangles are shaded: a triangle draws the half of a line that
/// lies on it. So lines are never hidden by the surface that they belong to, and end at its silhouette and at its borders. Lines
/// have the opacity of the surface; they change no plane of a picture but its colours.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceEdges {
    /// Linear RGB. Neither light nor tone mapping changes it.
    pub color: [f32; 3],
    /// Width in pixels, of both halves.
    pub width: f32,
    /// For each triangle of the mesh, by its number there, which of its sides have a line: bit k is that of the side opposite to
    /// corner k of the [canonical](tercio_mesh::Mesh::canonical) triangle. Without it, all sides have one.
    pub sides: Option<Vec<u8>>,
    /// For each triangle of the mesh, if exactly one of its sides has no line and it is half of a quadrilateral there, where the fourth
    /// corner is ([`Edges::fourths`](tercio_mesh::edges::Edges::fourths)): lines along the sides of the other half are drawn on this one,
    /// too, as far as they reach over the diagonal. Without it, and where a value is 0, they end at the diagonal.
    pub fourths: Option<Vec<[f32; 2]>>,
}

impl SurfaceEdges {
    /// The bits of all sides of a triangle.
    pub const ALL: u8 = 0b111;

    /// Lines in an sRGB colour, which end at the sides that have none.
    pub fn new(color: [u8; 3], width: f32, sides: Option<Vec<u8>>) -> Self {
        let color = color.map(|level| srgb_to_linear(f64::from(level) / 255.0) as f32);
        Self { color, width, sides, fourths: None }
    }

    /// The sides of a triangle that have a line.
    #[inline]
    pub fn sides_of(&self, triangle: u32) -> u8 {
        self.sides.as_ref().map_or(Self::ALL, |sides| sides[triangle as usize])
    }
}
