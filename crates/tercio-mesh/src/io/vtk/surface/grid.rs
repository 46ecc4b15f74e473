//! The outside of structured grids.

use super::Surface;
use super::builder::Builder;
use crate::ReadError;
use crate::io::vtk::cells::{self, Shape};
use crate::io::vtk::dataset::{Job, Points};
use crate::io::vtk::extents::Range3;

/// Number of cells along an axis with so many points.
fn along(points: u64) -> u64 {
    if points > 1 { points - 1 } else { points }
}

/// A cell of a grid: points, lines, quadrilaterals or hexahedra.
pub fn cell(dims: [u64; 3], cell: usize, buffer: &mut [u32; 8]) -> (Shape, &[u32]) {
    let number = cell as u64;
    let [x, y, _] = dims.map(along);
    let at = [number % x.max(1), number / x.max(1) % y.max(1), number / (x * y).max(1)];
    let steps = [1, dims[0], dims[0] * dims[1]];
    let first: u64 = at.iter().zip(steps).map(|(n, step)| n * step).sum();
    let used: Vec<u64> = steps.iter().zip(dims).filter(|&(_, n)| n > 1).map(|(&step, _)| step).collect();
    let (shape, corners): (Shape, &[u64]) = match used[..] {
        [] => (Shape::Points, &[0]),
        [a] => (Shape::Line, &[0, a]),
        [a, b] => (Shape::Polygon, &[0, a, a + b, b]),
        _ => {
            let [a, b, c] = steps;
            let corners = [0, a, a + b, b, c, a + c, a + b + c, b + c];
            buffer.iter_mut().zip(corners).for_each(|(slot, n)| *slot = (first + n) as u32);
            return (cells::shape(cells::HEXAHEDRON_CELL).unwrap_or(Shape::Empty), &buffer[..]);
        }
    };
    buffer.iter_mut().zip(corners).for_each(|(slot, n)| *slot = (first + n) as u32);
    (shape, &buffer[..corners.len()])
}

/// The faces at the borders of a grid in the order of its cells, except those that cells `beside` it touch.
pub fn outer(job: &Job, dims: [u64; 3], points: &Points, beside: &[Range3]) -> Result<Surface, ReadError> {
    let [x, y, z] = dims.map(along);
    if x == 0 || y == 0 || z == 0 {
        // The other axes may be as long as numbers allow.
        return Ok(Surface { cells: Some(Vec::new()), ..Surface::default() });
    }
    let is_solid = dims.iter().all(|&n| n > 1);
    let faces = if is_solid { 2 * (x * y + y * z + z * x) } else { x * y * z };
    job.reserve("the surface of its grid", 2 * 20 * 2 * faces)?;
    job.begin("extracting the surface", z);
    let mut builder = Builder::new(points);
    let mut buffer = [0; 8];
    let touching = touching([x, y, z], beside);
    for k in 0..z {
        for j in 0..y {
            let whole_row = !is_solid || j == 0 || j + 1 == y || k == 0 || k + 1 == z;
            let step = if whole_row { 1 } else { (x - 1).max(1) };
            for i in (0..x).step_by(step as usize) {
                let number = i + x * (j + y * k);
                let (shape, nodes) = cell(dims, number as usize, &mut buffer);
                builder.begin(number as u32);
                let Shape::Volume(volume) = shape else {
                    builder.flat(shape, nodes);
                    continue;
                };
                // In the order of the faces of a hexahedron.
                let at = [i, j, k];
                let border = [i == 0, i + 1 == x, j == 0, j + 1 == y, k == 0, k + 1 == z];
                let is_open = |side: usize| border[side] && !is_touched(&touching[side], side / 2, at);
                for (face, _) in volume.faces.iter().zip(0..).filter(|&(_, side)| is_open(side)) {
                    let corners = [0, 1, 2, 3].map(|c| nodes[face.nodes[c] as usize]);
                    builder.side(4, &corners);
                }
            }
        }
        job.advance(1);
    }
    Ok(Surface { cells: Some(builder.cells), ..builder.surface })
}

/// Of cells beside a grid of so many, those that touch each of its sides, in the order of the faces of a hexahedron.
fn touching(cells: [u64; 3], beside: &[Range3]) -> [Vec<&Range3>; 6] {
    std::array::from_fn(|side| {
        let axis = side / 2;
        // The layer of cells beyond the side.
        let layer = if side % 2 == 0 { -1 } else { cells[axis] as i64 };
        beside.iter().filter(|cells| cells[axis].contains(&layer)).collect()
    })
}

/// Is a cell at a side, across this axis, beside one of these cells?
fn is_touched(touching: &[&Range3], axis: usize, at: [u64; 3]) -> bool {
    let is_along = |cells: &Range3, other: usize| other == axis || cells[other].contains(&(at[other] as i64));
    touching.iter().any(|cells| (0..3).all(|other| is_along(cells, other)))
}
