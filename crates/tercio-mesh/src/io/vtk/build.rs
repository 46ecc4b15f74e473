//! Makes lists of cells of the numbers of a file, and checks them.

use crate::loops::prelude::*;

use super::cells::{self, POLYHEDRON, Shape};
use super::dataset::{CellList, Cells, Ends, Job};
use super::numbers::Numbers;
use crate::ReadError;
use crate::error::expected_vertex;

/// Numbers between two reports that they were read.
const STEP: usize = 1 << 15;

/// The error for a number that is no point.
fn no_point(job: &Job, numbers: &Numbers, at: usize, points: u64) -> ReadError {
    job.malformed(numbers.place(at), expected_vertex(points), found(numbers, at))
}

fn found(numbers: &Numbers, at: usize) -> String {
    if at < numbers.len() { numbers.double(at).to_string() } else { "the end of the array".into() }
}

/// Numbers below `limit`, checked.
fn indices(job: &Job, numbers: &Numbers, points: u64, limit: u64) -> Result<Vec<u32>, ReadError> {
    job.reserve("the points of its cells", 4 * numbers.len() as u64)?;
    numbers.indices(limit).map_err(|at| no_point(job, numbers, at, points))
}

/// A list as files before version 5 hold it: the number of points of each cell, then these.
pub fn counted_list(
    job: &Job,
    what: &str,
    cells: u64,
    numbers: &Numbers,
    limit: u64,
) -> Result<CellList, ReadError> {
    let size = numbers.len() as u64;
    if cells > size {
        let (expected, found) =
            (format!("at least {cells} numbers of {what}"), format!("only {size} of them"));
        return Err(job.malformed(numbers.place(0), expected, found));
    }
    let first = numbers.index(0).unwrap_or(0);
    let is_uniform = cells > 0
        && first.checked_add(1).and_then(|n| n.checked_mul(cells)) == Some(size)
        && (0..cells as usize).all(|cell| {
            if cell.is_multiple_of(STEP) {
                numbers.consumed(4 * STEP);
            }
            numbers.index(cell * (first as usize + 1)) == Some(first)
        });
    let flat = size - cells;
    job.reserve("the points of its cells", 4 * flat + if is_uniform { 0 } else { 8 * cells })?;
    let mut connectivity = Vec::with_capacity(flat as usize);
    let mut ends = Vec::with_capacity(if is_uniform { 0 } else { cells as usize });
    let (mut at, mut reported) = (0, 0);
    for cell in 0..cells {
        let left = numbers.len() - at;
        let count = match numbers.index(at).filter(|_| left > 0) {
            Some(n) if n < left as u64 => n as usize,
            _ => {
                let expected = format!("the number of points of cell {cell} of {cells} of {what}, and these");
                return Err(job.malformed(numbers.place(at), expected, found(numbers, at)));
            }
        };
        for i in at + 1..at + 1 + count {
            match numbers.index(i) {
                Some(point) if point < limit.min(u32::MAX.into()) => connectivity.push(point as u32),
                _ => return Err(no_point(job, numbers, i, limit)),
            }
        }
        at += count + 1;
        if at - reported > STEP {
            numbers.consumed(4 * (at - reported));
            reported = at;
        }
        if !is_uniform {
            ends.push(connectivity.len() as u64);
        }
    }
    if at < numbers.len() {
        let expected = format!("{} numbers of {what}, as it announces", numbers.len());
        return Err(job.malformed(
            numbers.place(at),
            expected,
            format!("the end of the last cell after {at}"),
        ));
    }
    let ends = if is_uniform {
        Ends::Uniform { corners: first as usize, cells: cells as usize }
    } else {
        Ends::Each(ends)
    };
    Ok(CellList { ends, connectivity })
}

/// A list as newer files hold it. `offsets` are the ends of cells, after a 0 if `has_zero`.
pub fn offset_list(
    job: &Job,
    what: &str,
    offsets: &Numbers,
    connectivity: &Numbers,
    has_zero: bool,
    limit: u64,
) -> Result<CellList, ReadError> {
    let skipped = usize::from(has_zero && offsets.len() > 0);
    if skipped > 0 && offsets.index(0) != Some(0) {
        return Err(job.malformed(
            offsets.place(0),
            format!("a 0 as the first offset of {what}"),
            found(offsets, 0),
        ));
    }
    let cells = offsets.len() - skipped;
    let points = connectivity.len() as u64;
    let first = if cells > 0 { offsets.index(skipped).unwrap_or(0) } else { 0 };
    let is_uniform = first.checked_mul(cells as u64) == Some(points)
        && !(0..cells)
            .into_par_iter()
            .any(|cell| offsets.index(cell + skipped) != Some(first * (cell as u64 + 1)));
    let ends = if is_uniform {
        Ends::Uniform { corners: first as usize, cells }
    } else {
        job.reserve("the ends of its cells", 8 * cells as u64)?;
        let (mut ends, mut before) = (Vec::with_capacity(cells), 0);
        for i in skipped..offsets.len() {
            match offsets.index(i) {
                Some(end) if (before..=points).contains(&end) => before = end,
                _ => {
                    let expected = format!("an offset of {what} from {before} to {points}");
                    return Err(job.malformed(offsets.place(i), expected, found(offsets, i)));
                }
            }
            ends.push(before);
        }
        if before != points {
            let expected = format!("{before} points of cells, which the offsets of {what} announce");
            return Err(job.malformed(connectivity.place(0), expected, format!("{points} of them")));
        }
        Ends::Each(ends)
    };
    let connectivity = indices(job, connectivity, limit, limit)?;
    Ok(CellList { ends, connectivity })
}

/// Checks types and numbers of nodes of cells. `faces` holds those of polyhedra, if `list` does not.
pub fn unstructured(
    job: &Job,
    types: &Numbers,
    list: CellList,
    faces: Option<CellList>,
    points: u64,
) -> Result<Cells, ReadError> {
    job.reserve("the types of its cells", types.len() as u64)?;
    if types.len() != list.len() {
        let expected = format!("as many types as cells, {}", list.len());
        return Err(job.malformed(types.place(0), expected, types.len().to_string()));
    }
    let has_faces = faces.is_some();
    let polyhedra = faces.unwrap_or_default();
    // A number too large for a type is none, as is this one.
    let number = |i: usize| types.index(i).and_then(|n| u8::try_from(n).ok()).unwrap_or(u8::MAX);
    let checked: Vec<u8> = (0..types.len()).into_par_iter().map(number).collect();
    // What was expected of a cell and what it has instead, if it is wrong.
    let wrong = |i: usize| {
        let cell_type = checked.get(i).copied().unwrap_or(u8::MAX);
        let Some(shape) = cells::shape(cell_type) else {
            return Some((format!("the type of a cell (cell {i})"), found(types, i)));
        };
        let nodes = list.get(i);
        let (least, most) = shape.nodes();
        if !(least..=most).contains(&nodes.len()) {
            let expected = format!("{least} points of cell {i}, whose type is {cell_type}");
            return Some((expected, nodes.len().to_string()));
        }
        if shape == Shape::Polyhedron {
            let stream = if has_faces { polyhedra.get(i) } else { nodes };
            let expected =
                || format!("the faces of cell {i}, a polyhedron, each its number of points and these");
            return polyhedron(stream, points).map(|wrong| (expected(), wrong));
        }
        let node = nodes.iter().find(|&&n| u64::from(n) >= points)?;
        Some((expected_vertex(points), format!("{node} in cell {i}")))
    };
    let chunks = (0..types.len().div_ceil(STEP)).into_par_iter();
    let first_wrong = chunks.map(|chunk| {
        let mut cells = chunk * STEP..((chunk + 1) * STEP).min(types.len());
        cells.find(|&i| wrong(i).is_some()).unwrap_or(usize::MAX)
    });
    let first_wrong = first_wrong.reduce(|| usize::MAX, usize::min);
    if first_wrong < types.len()
        && let Some((expected, found)) = wrong(first_wrong)
    {
        return Err(job.malformed(types.place(first_wrong), expected, found));
    }
    Ok(Cells::Unstructured { types: checked, list, polyhedra })
}

/// What is wrong with the faces of a polyhedron, if anything is.
fn polyhedron(stream: &[u32], points: u64) -> Option<String> {
    let Some((&faces, mut rest)) = stream.split_first() else { return Some("none".into()) };
    for face in 0..faces {
        let Some((&corners, tail)) = rest.split_first() else {
            return Some(format!("{face} faces of {faces}"));
        };
        let Some((nodes, tail)) = tail.split_at_checked(corners as usize) else {
            return Some(format!("a face of {corners} points, of which {} are there", tail.len()));
        };
        if let Some(node) = nodes.iter().find(|&&n| u64::from(n) >= points) {
            return Some(format!("point {node} of {points}"));
        }
        rest = tail;
    }
    (!rest.is_empty()).then(|| format!("{} numbers after the last face", rest.len()))
}

/// Are there polyhedra?
pub fn has_polyhedra(types: &Numbers) -> bool {
    (0..types.len()).any(|i| types.index(i) == Some(POLYHEDRON.into()))
}
