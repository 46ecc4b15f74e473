//! The edges of a surface: lines along the sides of its triangles.

use tercio_mesh::color::srgb_to_linear;
use tercio_mesh::edges::Beyond;

/// Lines along the sides of a surface's triangles, drawn when the triangles are shaded: a triangle draws the half of a line that
/// lies on it. So lines are never hidden by the surface that they belong to, and end at its silhouette and at its borders. Lines
/// on a translucent surface are as translucent as it; they change no plane of a picture but its colours.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceEdges {
    /// Linear RGB. Neither light nor tone mapping changes it.
    pub color: [f32; 3],
    /// How much of the colour of the surface lines hide, 0 to 1.
    pub opacity: f32,
    /// Width in pixels, of both halves.
    pub width: f32,
    /// For each triangle of the mesh, by its number there, which of its sides have a line: bit k is that of the side opposite to
    /// corner k of the [canonical](tercio_mesh::Mesh::canonical) triangle. Without it, all sides have one.
    pub sides: Option<Vec<u8>>,
    /// Lines along the edges of polygons that are no sides of a triangle, but reach over the sides of it that have no line. Without
    /// them, lines end at these sides.
    pub beyond: Beyond,
}

impl SurfaceEdges {
    /// The bits of all sides of a triangle.
    pub const ALL: u8 = 0b111;

    /// Opaque lines in an sRGB colour, which end at the sides that have none.
    pub fn new(color: [u8; 3], width: f32, sides: Option<Vec<u8>>) -> Self {
        let color = color.map(|level| srgb_to_linear(f64::from(level) / 255.0) as f32);
        Self { color, opacity: 1.0, width, sides, beyond: Beyond::Nothing }
    }

    /// The sides of a triangle that have a line.
    #[inline]
    pub fn sides_of(&self, triangle: u32) -> u8 {
        self.sides.as_ref().map_or(Self::ALL, |sides| sides[triangle as usize])
    }
}
