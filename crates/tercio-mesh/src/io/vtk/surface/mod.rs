//! From cells to triangles, lines and points: faces with two dimensions are triangulated, and of volumes those faces
//! are kept that no other volume has.
//!
//! As VTK's surface filter does at its default level of subdivision, faces of quadratic cells are split once, through
//! the nodes between their corners.

mod builder;
mod ghosts;
mod grid;
#[cfg(test)]
mod tests;
mod volumes;

use crate::loops::prelude::*;

use super::cells::{self, Shape};
use super::dataset::{Cells, DataSet, Ends, Job};
use crate::ReadError;
use crate::error::counted;
use crate::mesh::MAX_ELEMENTS;
use builder::Builder;
use ghosts::{Ghosts, Part};

/// Cells that a task looks at.
const CHUNK: usize = 1 << 13;

/// What is drawn of a data set, with the numbers of its points and cells.
#[derive(Default)]
pub struct Surface {
    pub triangles: Vec<[u32; 3]>,
    /// The cell of each triangle; `None` where it has the same number.
    pub cells: Option<Vec<u32>>,
    /// The [number](crate::Attribute::POLYGON) of each triangle's polygon in its cell; empty where all are 0.
    pub polygons: Vec<f32>,
    /// Points of all lines, one after the other.
    pub lines: Vec<u32>,
    /// Where each line ends, and its cell.
    pub line_ends: Vec<(u64, u32)>,
    /// Points that are drawn, and their cells.
    pub dots: Vec<[u32; 2]>,
}

/// Extracts the surface.
///
/// # Errors
/// Too many cells or points, or too little memory.
pub fn extract(job: &Job, data: &mut DataSet) -> Result<Surface, ReadError> {
    for (what, count) in [("points", data.points.count()), ("cells", data.cells.count())] {
        if count > MAX_ELEMENTS {
            return Err(ReadError::TooMany { file: job.file().into(), what, count });
        }
    }
    let has_ghosts = Ghosts::of(data).are_any();
    let list = match &mut data.cells {
        Cells::Structured(dims) if !has_ghosts => return grid::outer(job, *dims, &data.points, &data.beside),
        Cells::Poly([verts, lines, polygons, strips]) if !has_ghosts => {
            let others = [verts, lines, strips].iter().map(|l| l.len()).sum::<usize>();
            (others == 0).then_some(polygons)
        }
        Cells::Unstructured { types, list, .. } if !has_ghosts => {
            types.iter().all(|&t| t == cells::TRIANGLE).then_some(list)
        }
        _ => None,
    };
    if let Some(list) = list
        && let Ends::Uniform { corners: 3, .. } = list.ends
    {
        // They are triangles already.
        let (triangles, _) = list.connectivity.as_chunks::<3>();
        job.reserve("triangles", 12 * triangles.len() as u64)?;
        let triangles = triangles.to_vec();
        list.connectivity = Vec::new();
        return Ok(Surface { triangles, ..Surface::default() });
    }
    Extraction::new(data).run(job)
}

/// Looks at cells one by one.
pub(super) struct Extraction<'a> {
    data: &'a DataSet<'a>,
    ghosts: Ghosts<'a>,
    count: usize,
}

impl<'a> Extraction<'a> {
    fn new(data: &'a DataSet<'a>) -> Self {
        Self { data, ghosts: Ghosts::of(data), count: data.cells.count() as usize }
    }

    /// Type, and nodes of a cell.
    fn cell<'b>(&'b self, cell: usize, buffer: &'b mut [u32; 8]) -> (Shape, &'b [u32]) {
        match &self.data.cells {
            Cells::Poly(lists) => {
                let mut number = cell;
                let shapes = [Shape::Points, Shape::Line, Shape::Polygon, Shape::Strip];
                for (list, shape) in lists.iter().zip(shapes) {
                    if number < list.len() {
                        return (shape, list.get(number));
                    }
                    number -= list.len();
                }
                (Shape::Empty, &[])
            }
            Cells::Unstructured { types, list, polyhedra } => {
                let shape = types.get(cell).and_then(|&t| cells::shape(t)).unwrap_or(Shape::Empty);
                match shape {
                    Shape::Polyhedron if polyhedra.len() > 0 => (shape, polyhedra.get(cell)),
                    Shape::HigherOrder(linear) => {
                        let shape = cells::shape(linear).unwrap_or(Shape::Empty);
                        (shape, list.get(cell).get(..shape.nodes().0.max(2)).unwrap_or_default())
                    }
                    _ => (shape, list.get(cell)),
                }
            }
            Cells::Structured(dims) => grid::cell(*dims, cell, buffer),
        }
    }

    /// The number of faces of a cell that is a volume, known without its nodes.
    fn face_count(&self, cell: usize) -> Option<usize> {
        let Cells::Unstructured { types, .. } = &self.data.cells else { return None };
        match cells::shape(*types.get(cell)?)? {
            Shape::Volume(volume) if !self.ghosts.are_any() => Some(volume.faces.len()),
            _ => None,
        }
    }

    /// Is a cell inside of others, of whose faces this number is the first? Then that of the next cell.
    fn passed_over(&self, cell: usize, number: usize, outer: &volumes::Outer) -> Option<usize> {
        let next = number + self.face_count(cell)?;
        (!outer.are_any(number..next)).then_some(next)
    }

    /// Calls `each` with the number of corners and the nodes of every face of a volume.
    fn faces(shape: Shape, nodes: &[u32], mut each: impl FnMut(usize, &[u32])) {
        match shape {
            Shape::Volume(volume) => {
                let mut of_face = [0; 9];
                for face in volume.faces {
                    let slots = of_face.iter_mut().zip(face.nodes);
                    slots.for_each(|(slot, &n)| *slot = nodes.get(n as usize).copied().unwrap_or_default());
                    each(face.corners.into(), &of_face[..face.nodes.len()]);
                }
            }
            Shape::Polyhedron => {
                let mut rest = nodes.get(1..).unwrap_or_default();
                while let Some((&corners, tail)) = rest.split_first() {
                    let Some((face, tail)) = tail.split_at_checked(corners as usize) else { return };
                    each(face.len(), face);
                    rest = tail;
                }
            }
            _ => {}
        }
    }

    fn run(&self, job: &Job) -> Result<Surface, ReadError> {
        job.begin("extracting the surface", self.count as u64);
        let outer = volumes::Outer::find(self, job)?;
        let chunks = self.count.div_ceil(CHUNK);
        let cells = |chunk: usize| chunk * CHUNK..((chunk + 1) * CHUNK).min(self.count);
        let nodes: u64 = (0..chunks)
            .into_par_iter()
            .map(|chunk| {
                let (mut buffer, mut nodes) = ([0; 8], 0);
                let mut number = outer.first(chunk);
                for cell in cells(chunk) {
                    // Nearly all volumes are inside.
                    if let Some(next) = self.passed_over(cell, number, &outer) {
                        number = next;
                        continue;
                    }
                    let (shape, all) = self.cell(cell, &mut buffer);
                    match shape {
                        _ if self.ghosts.part(cell, all) == Part::Gone => {}
                        Shape::Volume(volume) if !outer.are_any(number..number + volume.faces.len()) => {
                            number += volume.faces.len();
                        }
                        Shape::Volume(_) | Shape::Polyhedron => Self::faces(shape, all, |_, face| {
                            nodes += if outer.is(number) { face.len() as u64 } else { 0 };
                            number += 1;
                        }),
                        _ => nodes += all.len() as u64,
                    }
                }
                nodes
            })
            .sum();
        // Triangles and their cells, at first in pieces.
        job.reserve("the surface of its cells", nodes.saturating_mul(2 * 20))?;
        let pieces: Vec<(Surface, Vec<u32>, u64)> = (0..chunks)
            .into_par_iter()
            .map(|chunk| {
                let mut builder = Builder::new(&self.data.points);
                let (mut buffer, mut number) = ([0; 8], outer.first(chunk));
                for cell in cells(chunk) {
                    if let Some(next) = self.passed_over(cell, number, &outer) {
                        number = next;
                        continue;
                    }
                    let (shape, nodes) = self.cell(cell, &mut buffer);
                    let part = self.ghosts.part(cell, nodes);
                    if part == Part::Gone {
                        continue;
                    }
                    builder.begin(cell as u32);
                    match shape {
                        Shape::Volume(volume) if !outer.are_any(number..number + volume.faces.len()) => {
                            number += volume.faces.len();
                        }
                        Shape::Volume(_) | Shape::Polyhedron => Self::faces(shape, nodes, |corners, face| {
                            if part == Part::Whole && outer.is(number) && !self.ghosts.hide(face) {
                                builder.side(corners, face);
                            }
                            number += 1;
                        }),
                        _ if part == Part::Ghost || self.ghosts.hide(nodes) => {}
                        _ => builder.flat(shape, nodes),
                    }
                }
                job.advance(cells(chunk).len() as u64);
                (builder.surface, builder.cells, builder.not_drawn)
            })
            .collect();
        self.warn(job, pieces.iter().map(|p| p.2).sum());
        Ok(Surface::join(pieces))
    }

    fn warn(&self, job: &Job, not_drawn: u64) {
        let Cells::Unstructured { types, .. } = &self.data.cells else { return };
        if not_drawn > 0 {
            let of = |t: &u8| match cells::shape(*t) {
                Some(Shape::Unsupported(what)) => Some(what),
                _ => None,
            };
            let what = types.iter().find_map(of).unwrap_or("a cell");
            let are = if not_drawn == 1 { "is" } else { "are" };
            job.warn(format!("{} {are} not drawn, of a type such as {what}", counted(not_drawn, "cell")));
        }
        let higher =
            types.iter().filter(|&&t| matches!(cells::shape(t), Some(Shape::HigherOrder(_)))).count();
        if higher > 0 {
            let cells = counted(higher as u64, "cell");
            let are = if higher == 1 { "is" } else { "are" };
            job.warn(format!("{cells} of a higher order {are} drawn straight from corner to corner"));
        }
    }
}

impl Surface {
    /// Joins pieces in their order.
    fn join(pieces: Vec<(Surface, Vec<u32>, u64)>) -> Self {
        fn flat<T: Copy>(parts: Vec<&[T]>) -> Vec<T> {
            parts.concat()
        }
        let triangles = flat(pieces.iter().map(|p| &p.0.triangles[..]).collect());
        let cells = flat(pieces.iter().map(|p| &p.1[..]).collect());
        let mut polygons = Vec::new();
        if pieces.iter().any(|p| !p.0.polygons.is_empty()) {
            for (piece, ..) in &pieces {
                let end = polygons.len() + piece.triangles.len();
                polygons.extend(&piece.polygons);
                polygons.resize(end, 0.0);
            }
        }
        let lines = flat(pieces.iter().map(|p| &p.0.lines[..]).collect());
        let dots = flat(pieces.iter().map(|p| &p.0.dots[..]).collect());
        let (mut line_ends, mut before) = (Vec::new(), 0);
        for (piece, ..) in &pieces {
            line_ends.extend(piece.line_ends.iter().map(|&(end, cell)| (end + before, cell)));
            before += piece.lines.len() as u64;
        }
        Self { triangles, cells: Some(cells), polygons, lines, line_ends, dots }
    }
}
