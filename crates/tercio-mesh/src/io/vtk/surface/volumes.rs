//! Faces that two volumes share.
//!
//! All faces are sorted by their corners, so that equal ones are neighbours: time is linear up to a logarithm,
//! whatever the file holds.

use crate::loops::prelude::*;

use super::{CHUNK, Extraction, Part};
use crate::ReadError;
use crate::io::vtk::cells::Shape;
use crate::io::vtk::dataset::{Cells, Job};

/// A face of a volume.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Face {
    /// The three lowest corners, and the fourth, or a sum of the rest.
    corners: [u32; 4],
    number: u32,
}

/// Which faces are not drawn, by their numbers in the order of the cells.
pub struct Hidden {
    /// Number of the first face of each chunk of cells.
    first: Vec<u32>,
    hidden: Vec<bool>,
}

impl Hidden {
    pub fn first(&self, chunk: usize) -> usize {
        self.first.get(chunk).map_or(0, |&n| n as usize)
    }

    pub fn is(&self, face: usize) -> bool {
        self.hidden.get(face).copied().unwrap_or(false)
    }

    /// Finds the faces that two or more volumes have.
    pub fn find(cells: &Extraction, job: &Job) -> Result<Self, ReadError> {
        let none = Self { first: Vec::new(), hidden: Vec::new() };
        if matches!(cells.data.cells, Cells::Poly(_)) {
            return Ok(none);
        }
        let chunks = cells.count.div_ceil(CHUNK);
        let each = |chunk: usize, face: &mut dyn FnMut(usize, &[u32])| {
            let mut buffer = [0; 8];
            for cell in chunk * CHUNK..((chunk + 1) * CHUNK).min(cells.count) {
                let (shape, nodes) = cells.cell(cell, &mut buffer);
                if matches!(shape, Shape::Volume(_) | Shape::Polyhedron)
                    && cells.ghosts.part(cell, nodes) != Part::Gone
                {
                    Extraction::faces(shape, nodes, |corners, nodes| face(corners, nodes));
                }
            }
        };
        let counts: Vec<u64> = (0..chunks)
            .into_par_iter()
            .map(|chunk| {
                let mut count = 0;
                each(chunk, &mut |_, _| count += 1);
                count
            })
            .collect();
        let all: u64 = counts.iter().sum();
        if all == 0 {
            return Ok(none);
        }
        if all > u32::MAX.into() {
            return Err(ReadError::TooMany { file: job.file().into(), what: "faces of volumes", count: all });
        }
        job.reserve("the faces of its volumes", all * (2 * size_of::<Face>() as u64 + 1))?;
        let first: Vec<u32> = counts
            .iter()
            .scan(0, |sum, &n| {
                *sum += n;
                Some((*sum - n) as u32)
            })
            .collect();
        let mut faces: Vec<Face> = (0..chunks)
            .into_par_iter()
            .flat_map_iter(|chunk| {
                let mut faces = Vec::with_capacity(counts.get(chunk).map_or(0, |&n| n as usize));
                let mut number = first.get(chunk).copied().unwrap_or(0);
                let mut sorted = Vec::new();
                each(chunk, &mut |corners, nodes| {
                    sorted.clear();
                    sorted.extend_from_slice(nodes.get(..corners).unwrap_or(nodes));
                    sorted.sort_unstable();
                    // Of collapsed cells some corners are one.
                    sorted.dedup();
                    faces.push(Face { corners: key(&sorted), number });
                    number += 1;
                });
                faces
            })
            .collect();
        faces.par_sort_unstable();
        let mut hidden = vec![false; all as usize];
        for same in faces.chunk_by(|a, b| a.corners == b.corners) {
            if same.len() > 1 || same.iter().any(|f| f.corners[2] == u32::MAX) {
                same.iter().for_each(|face| hidden[face.number as usize] = true);
            }
        }
        Ok(Self { first, hidden })
    }
}

/// Equal for faces with equal corners.
fn key(sorted: &[u32]) -> [u32; 4] {
    let at = |i: usize| sorted.get(i).copied().unwrap_or(u32::MAX);
    let fourth = match sorted.get(3..) {
        Some(rest) if rest.len() > 1 => {
            rest.iter().fold(rest.len() as u32, |sum, &n| (sum ^ n).wrapping_mul(0x9e37_79b1).rotate_left(13))
        }
        _ => at(3),
    };
    [at(0), at(1), at(2), fourth]
}
