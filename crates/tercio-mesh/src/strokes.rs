//! Lines and points of a model, beside its triangles.

use glam::DVec3;

use crate::{Aabb, Attribute, AttributeDomain, Mesh};

/// Line segments and points in object space, with vertices of their own.
#[derive(Clone, Debug, Default)]
pub struct Strokes {
    /// Position in object space of the point that [`Strokes::positions`] are relative to; that of the model's
    /// [mesh](crate::Mesh::origin), in units of length 1.
    pub origin: DVec3,
    /// Vertex positions relative to `origin`; may be not finite.
    pub positions: Vec<[f32; 3]>,
    /// sRGB colour and linear alpha, one per vertex.
    pub colors: Option<Vec<[u8; 4]>>,
    /// Scalars, one value per vertex.
    pub attributes: Vec<Attribute>,
    /// Two vertex numbers per line segment.
    pub segments: Vec<[u32; 2]>,
    /// A vertex number per point.
    pub points: Vec<u32>,
}

impl Strokes {
    /// Are there neither lines nor points?
    pub fn is_empty(&self) -> bool {
        self.segments.is_empty() && self.points.is_empty()
    }

    /// Lines and points between vertices of a mesh as it was read: these are copied, with their colours and attributes.
    ///
    /// # Panics
    /// If there is no such vertex.
    pub fn of_vertices(mesh: &Mesh, mut segments: Vec<[u32; 2]>, mut points: Vec<u32>) -> Self {
        if segments.is_empty() && points.is_empty() {
            return Self::default();
        }
        let mut numbers = vec![u32::MAX; mesh.positions.len()];
        let mut used = Vec::new();
        for vertex in segments.as_flattened_mut().iter_mut().chain(&mut points) {
            let number = &mut numbers[*vertex as usize];
            if *number == u32::MAX {
                *number = used.len() as u32;
                used.push(*vertex);
            }
            *vertex = *number;
        }
        let of_vertices = mesh.attributes.iter().filter(|a| a.domain == AttributeDomain::Vertex);
        let attributes = of_vertices.map(|a| Attribute { values: pick(&a.values, &used), ..a.clone() });
        Self {
            origin: mesh.origin,
            positions: pick(&mesh.positions, &used),
            colors: mesh.vertex_colors.as_ref().map(|colors| pick(colors, &used)),
            attributes: attributes.collect(),
            segments,
            points,
        }
    }

    /// Position of a vertex in object space.
    ///
    /// # Panics
    /// If there is no such vertex.
    pub fn position(&self, vertex: u32) -> DVec3 {
        self.origin + DVec3::from(self.positions[vertex as usize].map(f64::from))
    }

    /// Bounds, in object space, of the vertices with finite coordinates.
    pub fn bounds(&self) -> Aabb {
        let mut bounds = Aabb::EMPTY;
        let points = self.positions.iter().map(|p| DVec3::from(p.map(f64::from))).filter(|p| p.is_finite());
        points.for_each(|p| bounds.add(self.origin + p));
        bounds
    }
}

fn pick<T: Copy>(values: &[T], numbers: &[u32]) -> Vec<T> {
    numbers.iter().map(|&number| values[number as usize]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_are_those_of_finite_vertices() {
        let positions = vec![[1.0, 2.0, 3.0], [-1.0, 0.0, 5.0], [f32::NAN, 0.0, 9.0]];
        let strokes = Strokes { origin: DVec3::X, positions, points: vec![0], ..Strokes::default() };
        let bounds = strokes.bounds();
        assert_eq!((bounds.min, bounds.max), (DVec3::new(0.0, 0.0, 3.0), DVec3::new(2.0, 2.0, 5.0)));
        assert!(!strokes.is_empty() && Strokes::default().is_empty());
    }
}
