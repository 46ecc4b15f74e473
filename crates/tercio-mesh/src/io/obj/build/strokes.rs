//! Lines and points, and their colours.

use crate::error::counted;
use crate::strokes::Strokes;
use crate::{FileMaterial, Mesh};

use super::{Chunk, Names};

/// The lines and points of the file.
pub fn strokes(chunks: &mut [Chunk], mesh: &Mesh, warnings: &mut Vec<String>) -> Strokes {
    let broken: u64 = chunks.iter().map(|c| c.not_vertices).sum();
    if broken > 0 {
        let are = if broken == 1 { "is no vertex" } else { "are no vertices" };
        warnings.push(format!("{} of lines and points (l, p) {are}", counted(broken, "end")));
    }
    let segments = chunks.iter_mut().flat_map(|c| std::mem::take(&mut c.segments)).collect();
    let points = chunks.iter_mut().flat_map(|c| std::mem::take(&mut c.dots)).collect();
    Strokes::of_vertices(mesh, segments, points)
}

/// Materials of lines and points, and their colours.
pub struct Painted<'a> {
    pub segments: Paints<'a>,
    pub points: Paints<'a>,
    /// All of these materials, each once.
    pub materials: Vec<FileMaterial>,
}

/// Materials of elements of one kind.
pub struct Paints<'a> {
    pub used: Names<'a>,
    /// The colour of each name.
    pub colors: Vec<Option<[u8; 4]>>,
}

impl Painted<'_> {
    /// The lines and points in these colours.
    pub fn paint(self, strokes: Strokes) -> Strokes {
        let Self { segments, points, materials } = self;
        let colored = strokes
            .colored(|number, own| segments.color(number, own), |number, own| points.color(number, own));
        Strokes { materials, ..colored }
    }
}

impl Paints<'_> {
    /// The colour of an element at a vertex with a colour of its own, which then has only the material's opacity, as at the corners
    /// of faces. Without a material, or with an undefined one, it is that of the vertex, if it has one.
    fn color(&self, element: usize, own: Option<[u8; 4]>) -> Option<[u8; 4]> {
        let of_material = self.used.of(element).and_then(|name| self.colors[name as usize]);
        let with_opacity = |[r, g, b, a]: [u8; 4], opacity: u8| {
            [r, g, b, (f32::from(a) * f32::from(opacity) / 255.0).round() as u8]
        };
        match (own, of_material) {
            (Some(own), Some([.., opacity])) => Some(with_opacity(own, opacity)),
            (own, of_material) => own.or(of_material),
        }
    }
}
