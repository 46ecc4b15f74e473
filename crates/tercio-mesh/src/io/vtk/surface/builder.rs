//! Makes triangles of faces.

use super::Surface;
use crate::io::vtk::cells::Shape;
use crate::io::vtk::dataset::Points;
use crate::polygon::Triangulator;

/// Collects what is drawn of some cells.
pub struct Builder<'a> {
    points: &'a Points<'a>,
    triangulator: Triangulator,
    corners: Vec<[f64; 3]>,
    /// The cell that is being drawn.
    cell: u32,
    /// The number of its polygon that is being drawn.
    polygon: u32,
    pub surface: Surface,
    /// The cell of each triangle.
    pub cells: Vec<u32>,
    /// Cells that are not drawn.
    pub not_drawn: u64,
}

impl<'a> Builder<'a> {
    pub fn new(points: &'a Points<'a>) -> Self {
        Self {
            points,
            triangulator: Triangulator::default(),
            corners: Vec::new(),
            cell: 0,
            polygon: 0,
            surface: Surface::default(),
            cells: Vec::new(),
            not_drawn: 0,
        }
    }

    /// Begins a cell.
    pub fn begin(&mut self, cell: u32) {
        (self.cell, self.polygon) = (cell, 0);
    }

    /// Draws a face of a cell that may have several.
    pub fn side(&mut self, corners: usize, nodes: &[u32]) {
        self.face(corners, nodes);
        self.polygon += 1;
    }

    /// Draws a cell without a volume.
    pub fn flat(&mut self, shape: Shape, nodes: &[u32]) {
        match shape {
            Shape::Points => self.surface.dots.extend(nodes.iter().map(|&node| [node, self.cell])),
            Shape::Line => self.line(nodes.iter().copied()),
            Shape::CurvedLine => {
                let (first, last) = (nodes.iter().take(1), nodes.iter().skip(1).take(1));
                self.line(first.chain(nodes.iter().skip(2)).chain(last).copied());
            }
            Shape::Strip => {
                for (i, corners) in nodes.windows(3).enumerate() {
                    let [a, b, c] = [corners[0], corners[1], corners[2]];
                    self.push(if i % 2 == 0 { [a, b, c] } else { [b, a, c] });
                    self.polygon += 1;
                }
            }
            Shape::Polygon => self.polygon(nodes),
            Shape::Pixel => {
                if let &[a, b, c, d] = nodes {
                    self.polygon(&[a, b, d, c]);
                }
            }
            Shape::Face { corners, .. } => self.face(corners.into(), nodes),
            Shape::QuadraticPolygon => {
                let (corners, between) = nodes.split_at(nodes.len() / 2);
                let around: Vec<u32> = corners.iter().zip(between).flat_map(|(&a, &b)| [a, b]).collect();
                self.polygon(&around);
            }
            Shape::Unsupported(_) => self.not_drawn += 1,
            Shape::Empty | Shape::Volume(_) | Shape::Polyhedron | Shape::HigherOrder(_) => {}
        }
    }

    /// Draws a face with these corners, the nodes between them, and one in the middle.
    fn face(&mut self, corners: usize, nodes: &[u32]) {
        match (corners, nodes) {
            (3, &[a, b, c]) => self.push([a, b, c]),
            (3, &[a, b, c, ab, bc, ca]) => {
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [bc, ca, ab]].into_iter().for_each(|t| self.push(t));
            }
            (3, &[a, b, c, ab, bc, ca, middle]) => {
                [
                    [a, ab, middle],
                    [middle, ab, bc],
                    [middle, bc, ca],
                    [a, middle, ca],
                    [ab, b, bc],
                    [ca, bc, c],
                ]
                .into_iter()
                .for_each(|t| self.push(t));
            }
            (4, &[a, b, c, d, ab, bc, cd, da]) => {
                [[a, ab, da], [ab, b, bc], [bc, c, cd], [cd, d, da]].into_iter().for_each(|t| self.push(t));
                self.polygon(&[ab, bc, cd, da]);
            }
            (4, &[a, b, c, d, ab, bc, cd, da, middle]) => {
                [[a, ab, middle, da], [ab, b, bc, middle], [middle, bc, c, cd], [da, middle, cd, d]]
                    .into_iter()
                    .for_each(|quad| self.polygon(&quad));
            }
            (4, &[a, b, c, d, ab, cd]) => {
                [[a, ab, cd, d], [ab, b, c, cd]].into_iter().for_each(|q| self.polygon(&q))
            }
            _ => self.polygon(nodes),
        }
    }

    fn polygon(&mut self, nodes: &[u32]) {
        let first = self.surface.triangles.len();
        let Self { points, triangulator, corners, surface, cells, cell, .. } = self;
        corners.clear();
        corners.extend(nodes.iter().map(|&node| points.get(node)));
        triangulator.triangulate(corners, |triangle| {
            surface.triangles.push(triangle.map(|corner| nodes[corner]));
            cells.push(*cell);
        });
        self.number(first);
    }

    /// Gives the triangles from this one on the number of their polygon. Where all of them have the first one of their cell, there are no
    /// numbers.
    fn number(&mut self, first: usize) {
        let Surface { triangles, polygons, .. } = &mut self.surface;
        if self.polygon > 0 || !polygons.is_empty() {
            polygons.resize(first, 0.0);
            // Triangles with the same number are not neighbours.
            polygons.resize(triangles.len(), (self.polygon % (1 << f32::MANTISSA_DIGITS)) as f32);
        }
    }

    fn push(&mut self, triangle: [u32; 3]) {
        self.surface.triangles.push(triangle);
        self.cells.push(self.cell);
        self.number(self.cells.len() - 1);
    }

    fn line(&mut self, nodes: impl Iterator<Item = u32>) {
        self.surface.lines.extend(nodes);
        self.surface.line_ends.push((self.surface.lines.len() as u64, self.cell));
    }
}
