//! Converts faces and strips to triangles.

use crate::loops::prelude::*;

use super::Job;
use super::table::{Lists, Table};
use crate::error::ReadError;
use crate::mesh::MAX_ELEMENTS;
use crate::polygon::Triangulator;

/// Triangles and the faces they come from.
#[derive(Debug, Default)]
pub(super) struct Triangles {
    pub(super) list: Vec<[u32; 3]>,
    /// `None` where face i is triangle i.
    pub(super) face_of_triangle: Option<Vec<u32>>,
    /// Number of faces with no corner, with one and with two.
    pub(super) small: [u64; 3],
}

/// Makes triangles of all faces; `table.lists` and `table.triangles` are empty afterwards.
pub(super) fn from_faces(
    job: &Job,
    positions: &[[f32; 3]],
    table: &mut Table,
) -> Result<Triangles, ReadError> {
    if let Some(list) = table.triangles.take() {
        return Ok(Triangles { list, ..Triangles::default() });
    }
    let lists = std::mem::take(&mut table.lists);
    let made: u64 = lists
        .par_iter()
        .map(|l| l.counts.iter().map(|&count| u64::from(count.saturating_sub(2))).sum::<u64>())
        .sum();
    if made > MAX_ELEMENTS {
        return Err(ReadError::TooMany { file: job.file.into(), what: "triangles", count: made });
    }
    if lists.par_iter().all(|l| l.counts.iter().all(|&count| count == 3)) {
        job.reserve("triangles", 12 * made)?;
        let list = joined(lists, |l| l.corners.as_chunks().0);
        return Ok(Triangles { list, ..Triangles::default() });
    }
    job.reserve("triangles of polygons", 32 * made)?;
    let firsts: Vec<u32> = lists
        .iter()
        .scan(0, |face, l| {
            let first = *face;
            *face += l.counts.len() as u32;
            Some(first)
        })
        .collect();
    let pieces: Vec<Piece> =
        lists.into_par_iter().zip(firsts).map(|(l, first)| triangulate(positions, &l, first)).collect();
    let small = pieces.iter().fold([0; 3], |sum, p| [0, 1, 2].map(|corners| sum[corners] + p.small[corners]));
    let (lists, faces): (Vec<_>, Vec<_>) = pieces.into_iter().map(|p| (p.triangles, p.faces)).unzip();
    Ok(Triangles {
        list: joined(lists, Vec::as_slice),
        face_of_triangle: Some(joined(faces, Vec::as_slice)),
        small,
    })
}

struct Piece {
    triangles: Vec<[u32; 3]>,
    faces: Vec<u32>,
    small: [u64; 3],
}

fn triangulate(positions: &[[f32; 3]], lists: &Lists, first: u32) -> Piece {
    let mut triangulator = Triangulator::default();
    let made = lists.counts.iter().map(|&count| count.saturating_sub(2) as usize).sum();
    let mut piece =
        Piece { triangles: Vec::with_capacity(made), faces: Vec::with_capacity(made), small: [0; 3] };
    let mut points = Vec::new();
    let mut rest = lists.corners.as_slice();
    for (&count, face) in lists.counts.iter().zip(first..) {
        let (corners, after) = rest.split_at(rest.len().min(count as usize));
        rest = after;
        match *corners {
            [] | [_] | [_, _] => piece.small[corners.len()] += 1,
            [a, b, c] => piece.triangles.push([a, b, c]),
            _ => {
                points.clear();
                let point = |&v: &u32| positions.get(v as usize).map_or([0.0; 3], |p| p.map(f64::from));
                points.extend(corners.iter().map(point));
                triangulator.triangulate(&points, |triangle| {
                    piece.triangles.push(triangle.map(|i| corners.get(i).copied().unwrap_or_default()));
                });
            }
        }
        piece.faces.resize(piece.triangles.len(), face);
    }
    piece
}

/// Concatenates the pieces.
fn joined<P: Send + Sync, T: Copy + Default + Send>(
    pieces: Vec<P>,
    of: impl Fn(&P) -> &[T] + Sync,
) -> Vec<T> {
    let mut all = vec![T::default(); pieces.iter().map(|p| of(p).len()).sum()];
    let mut rest = all.as_mut_slice();
    let mut work = Vec::with_capacity(pieces.len());
    for piece in pieces {
        let (here, after) = std::mem::take(&mut rest).split_at_mut(of(&piece).len());
        work.push((here, piece));
        rest = after;
    }
    work.into_par_iter().for_each(|(here, piece)| here.copy_from_slice(of(&piece)));
    all
}

/// Adds the triangles of strips: every corner from the third on makes one with the two before it, and every second
/// one is reversed. Triangles with a repeated corner only continue the strip and are left out.
pub(super) fn from_strips(job: &Job, table: &Table, list: &mut Vec<[u32; 3]>) -> Result<(), ReadError> {
    let corners: u64 = table.lists.iter().map(|l| l.corners.len() as u64).sum();
    job.reserve("triangles of strips", 12 * corners)?;
    for lists in &table.lists {
        let mut rest = lists.corners.as_slice();
        for &count in &lists.counts {
            let (strips, after) = rest.split_at(rest.len().min(count as usize));
            rest = after;
            for strip in strips.split(|&v| v == u32::MAX) {
                for (i, corners) in strip.windows(3).enumerate() {
                    if let &[a, b, c] = corners
                        && a != b
                        && b != c
                        && c != a
                    {
                        list.push(if i % 2 == 0 { [a, b, c] } else { [b, a, c] });
                    }
                }
            }
        }
    }
    Ok(())
}
