//! Cells and points that a data set says are not to be drawn.
//!
//! Source: VTK 9.7.2, `vtkDataSetAttributes.h`, and what `vtkDataSetSurfaceFilter` and `vtkGeometryFilter` draw. Each
//! shows holes of hidden points where the other one does not, the former in grids of volumes and the latter in all
//! others; here all have them.

use crate::loops::prelude::*;

use crate::io::vtk::dataset::{Array, Cells, DataSet};

/// Bits of `vtkGhostType` of a cell: it belongs to another piece, or is not there.
const DUPLICATE_CELL: u64 = 1;
const HIDDEN_CELL: u64 = 32;

/// The bit of `vtkGhostType` of a point that is not there. One that belongs to another piece as well is drawn.
const HIDDEN_POINT: u64 = 2;

/// How a cell takes part.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Part {
    Whole,
    /// Its faces are those of a neighbour, but not drawn.
    Ghost,
    Gone,
}

/// What arrays say about cells and points.
pub struct Ghosts<'a> {
    cells: Option<&'a Array<'a>>,
    /// Of points, if any is hidden.
    points: Option<&'a Array<'a>>,
    /// Hidden points take volumes away as a whole, not only those of their faces that use them.
    is_grid: bool,
}

impl<'a> Ghosts<'a> {
    pub fn of(data: &'a DataSet<'a>) -> Self {
        // VTK draws polygonal data whatever their points are.
        let is_poly = matches!(data.cells, Cells::Poly(_));
        let points = data.point_data.iter().find(|a| a.name == "vtkGhostType" && a.components == 1);
        Self {
            cells: Array::ghosts(&data.cell_data),
            points: points.filter(|array| !is_poly && has_hidden(array)),
            is_grid: matches!(data.cells, Cells::Structured(_)),
        }
    }

    pub fn are_any(&self) -> bool {
        self.cells.is_some() || self.points.is_some()
    }

    /// How a cell with these nodes takes part.
    pub fn part(&self, cell: usize, nodes: &[u32]) -> Part {
        if self.is_grid && self.is_one_hidden(nodes) {
            return Part::Gone;
        }
        let Some(ghosts) = self.cells else { return Part::Whole };
        let bits = ghosts.numbers.index(cell).unwrap_or(0);
        match ghosts.name.as_str() {
            "vtkGhostLevels" if bits > 0 => Part::Ghost,
            "vtkGhostLevels" => Part::Whole,
            _ if bits & HIDDEN_CELL > 0 => Part::Gone,
            _ if bits & DUPLICATE_CELL > 0 => Part::Ghost,
            _ => Part::Whole,
        }
    }

    /// Do they hide a face, or a cell without a volume, with these nodes? As in VTK, volumes of unstructured grids do
    /// not open for what is behind such a face.
    pub fn hide(&self, nodes: &[u32]) -> bool {
        !self.is_grid && self.is_one_hidden(nodes)
    }

    fn is_one_hidden(&self, nodes: &[u32]) -> bool {
        self.points.is_some_and(|array| nodes.iter().any(|&node| is_hidden(array, node as usize)))
    }
}

fn is_hidden(array: &Array, point: usize) -> bool {
    array.numbers.index(point).unwrap_or(0) & HIDDEN_POINT > 0
}

fn has_hidden(array: &Array) -> bool {
    (0..array.numbers.len()).into_par_iter().any(|point| is_hidden(array, point))
}
