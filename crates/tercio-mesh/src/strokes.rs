//! Lines and points of a model, beside its triangles.

use std::collections::HashMap;

use glam::DVec3;

use crate::{Aabb, Attribute, AttributeDomain, FileMaterial, Mesh};

/// sRGB colour and linear alpha of each vertex, if it has one of its own.
pub type Colors = Vec<Option<[u8; 4]>>;

/// Line segments and points in object space, with vertices of their own.
#[derive(Clone, Debug, Default)]
pub struct Strokes {
    /// Position in object space of the point that [`Strokes::positions`] are relative to; that of the model's
    /// [mesh](crate::Mesh::origin), in units of length 1.
    pub origin: DVec3,
    /// Vertex positions relative to `origin`; may be not finite.
    pub positions: Vec<[f32; 3]>,
    /// Colours of vertices; `None` is the same as none for every vertex.
    pub colors: Option<Colors>,
    /// Scalars, one value per vertex.
    pub attributes: Vec<Attribute>,
    /// Two vertex numbers per line segment.
    pub segments: Vec<[u32; 2]>,
    /// A vertex number per point.
    pub points: Vec<u32>,
    /// Materials that the file names for lines and points. What they look like is in `colors`.
    pub materials: Vec<FileMaterial>,
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
            colors: mesh.vertex_colors.as_ref().map(|colors| picked(colors, &used).map(Some).collect()),
            attributes: attributes.collect(),
            segments,
            points,
            materials: Vec::new(),
        }
    }

    /// These lines and points with colours of segments and of points, sRGB and linear alpha, or without, made from their numbers and
    /// the colour of a vertex: a vertex of elements of several colours becomes several. Vertices of no element have no colour.
    pub fn colored(
        mut self,
        of_segment: impl Fn(usize, Option<[u8; 4]>) -> Option<[u8; 4]>,
        of_point: impl Fn(usize, Option<[u8; 4]>) -> Option<[u8; 4]>,
    ) -> Self {
        let before = self.colors.take();
        let own = |vertex: u32| color_of(before.as_deref(), vertex);
        // The first colour of each vertex, and copies of vertices with further ones.
        let mut firsts: Vec<Option<Option<[u8; 4]>>> = vec![None; self.positions.len()];
        let mut copies: Vec<(u32, Option<[u8; 4]>)> = Vec::new();
        let mut numbers = HashMap::new();
        let mut paint = |vertex: &mut u32, color: Option<[u8; 4]>| {
            let first = &mut firsts[*vertex as usize];
            if *first.get_or_insert(color) != color {
                let next = (self.positions.len() + copies.len()) as u32;
                *vertex = *numbers.entry((*vertex, color)).or_insert_with_key(|&copy| {
                    copies.push(copy);
                    next
                });
            }
        };
        for (number, segment) in self.segments.iter_mut().enumerate() {
            segment.iter_mut().for_each(|vertex| paint(vertex, of_segment(number, own(*vertex))));
        }
        for (number, point) in self.points.iter_mut().enumerate() {
            paint(point, of_point(number, own(*point)));
        }
        let (sources, colors): (Vec<u32>, Vec<Option<[u8; 4]>>) = copies.into_iter().unzip();
        self.positions.extend(pick(&self.positions, &sources));
        for attribute in &mut self.attributes {
            attribute.values.extend(pick(&attribute.values, &sources));
        }
        self.colors = Some(firsts.into_iter().map(Option::flatten).chain(colors).collect());
        self
    }

    /// The colour of a vertex, if it has one of its own.
    ///
    /// # Panics
    /// If there are colours, but no such vertex.
    pub fn color(&self, vertex: u32) -> Option<[u8; 4]> {
        color_of(self.colors.as_deref(), vertex)
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

fn color_of(colors: Option<&[Option<[u8; 4]>]>, vertex: u32) -> Option<[u8; 4]> {
    colors.and_then(|colors| colors[vertex as usize])
}

fn pick<T: Copy>(values: &[T], numbers: &[u32]) -> Vec<T> {
    picked(values, numbers).collect()
}

fn picked<T: Copy>(values: &[T], numbers: &[u32]) -> impl Iterator<Item = T> {
    numbers.iter().map(|&number| values[number as usize])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_vertex_of_elements_of_several_colors_becomes_several() {
        let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [9.0; 3]];
        let values = vec![5.0, 6.0, 7.0, 8.0];
        let attribute = Attribute {
            name: "a".into(),
            domain: AttributeDomain::Vertex,
            values,
            offset: 0.0,
            component: None,
        };
        let (segments, points) = (vec![[0, 1], [1, 2], [2, 1]], vec![1, 0]);
        let strokes =
            Strokes { positions, attributes: vec![attribute], segments, points, ..Strokes::default() };
        let [red, blue] = [[255, 0, 0, 255], [0, 0, 255, 128]];
        let of_segment = |n, _| Some(if n == 0 { red } else { blue });
        let painted = strokes.clone().colored(of_segment, |n, _| Some([red, blue][n]));
        assert_eq!(painted.segments, [[0, 1], [4, 2], [2, 4]]);
        assert_eq!(painted.points, [1, 5]);
        assert_eq!(painted.positions[4..], [[1.0, 0.0, 0.0], [0.0; 3]]);
        assert_eq!(painted.attributes[0].values, [5.0, 6.0, 7.0, 8.0, 6.0, 5.0]);
        let colors = |strokes: &Strokes| [0, 1, 2, 3, 4, 5].map(|v| strokes.color(v));
        let [some_red, some_blue] = [Some(red), Some(blue)];
        assert_eq!(colors(&painted), [some_red, some_red, some_blue, None, some_blue, some_blue]);
        // Some of them without a colour.
        let painted = strokes.clone().colored(|n, _| (n == 0).then_some(red), |_, _| None);
        assert_eq!(painted.segments, [[0, 1], [4, 2], [2, 4]]);
        assert_eq!(painted.points, [4, 5]);
        assert_eq!(colors(&painted), [some_red, some_red, None, None, None, None]);
        // From the colours of vertices.
        let colors = Some(vec![Some([1, 2, 3, 200]), some_red, some_red, some_red]);
        let whole = Strokes { colors, ..strokes };
        let half = |_, own: Option<[u8; 4]>| own.map(|[r, g, b, a]| [r, g, b, a / 2]);
        let halved = whole.colored(half, half);
        let half_red = Some([255, 0, 0, 127]);
        assert_eq!([0, 1, 2, 3].map(|v| halved.color(v)), [Some([1, 2, 3, 100]), half_red, half_red, None]);
    }

    #[test]
    fn bounds_are_those_of_finite_vertices() {
        let positions = vec![[1.0, 2.0, 3.0], [-1.0, 0.0, 5.0], [f32::NAN, 0.0, 9.0]];
        let strokes = Strokes { origin: DVec3::X, positions, points: vec![0], ..Strokes::default() };
        let bounds = strokes.bounds();
        assert_eq!((bounds.min, bounds.max), (DVec3::new(0.0, 0.0, 3.0), DVec3::new(2.0, 2.0, 5.0)));
        assert!(!strokes.is_empty() && Strokes::default().is_empty());
    }
}
