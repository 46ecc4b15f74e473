//! Texture coordinates that stand at the corners of faces instead of at the vertices.

use super::table::Lists;
use crate::mesh::MAX_ELEMENTS;

/// Texture coordinates moved to the vertices.
#[derive(Debug)]
pub(super) struct Split {
    /// One pair a vertex; the vertices of the file, then the copies.
    pub(super) texcoords: Vec<[f32; 2]>,
    /// The vertex that each copy repeats.
    pub(super) copied: Vec<u32>,
    /// Faces whose list is not a pair a corner; their corners lie at (0, 0).
    pub(super) faces_without: u64,
}

const NONE: u32 = u32::MAX;

/// Gives every vertex one pair of texture coordinates: a vertex at which faces disagree is copied, and the
/// faces' corners are turned to the copies. `None` if there would be too many vertices.
pub(super) fn split(lists: &mut [Lists], vertices: usize) -> Option<Split> {
    let mut texcoords = vec![[f32::NAN; 2]; vertices];
    // The next copy of the same vertex.
    let mut next = vec![NONE; vertices];
    let mut copied = Vec::new();
    let mut faces_without = 0;
    for lists in lists {
        let (mut corners, mut wedges) = (lists.corners.as_mut_slice(), lists.wedges.as_slice());
        for (&count, &wedge_count) in lists.counts.iter().zip(&lists.wedge_counts) {
            let (of_face, rest) = std::mem::take(&mut corners).split_at_mut_checked(count as usize)?;
            corners = rest;
            let (pairs, rest) = wedges.split_at_checked(wedge_count as usize)?;
            wedges = rest;
            let complete = u64::from(wedge_count) == 2 * u64::from(count);
            faces_without += u64::from(!complete && count > 0);
            for (i, corner) in of_face.iter_mut().enumerate() {
                let pair = pairs.get(2 * i..2 * i + 2).and_then(|p| p.first_chunk::<2>().copied());
                let pair = pair.filter(|p| complete && p.iter().all(|v| v.is_finite())).unwrap_or_default();
                let first = *corner;
                let mut vertex = first;
                loop {
                    let (found, next_copy) =
                        (texcoords.get_mut(vertex as usize)?, *next.get(vertex as usize)?);
                    if found.iter().any(|v| v.is_nan()) {
                        *found = pair;
                    }
                    if *found == pair {
                        break;
                    }
                    if next_copy == NONE {
                        let new = texcoords.len();
                        if new as u64 >= MAX_ELEMENTS {
                            return None;
                        }
                        *next.get_mut(vertex as usize)? = new as u32;
                        texcoords.push(pair);
                        next.push(NONE);
                        copied.push(first);
                        vertex = new as u32;
                        break;
                    }
                    vertex = next_copy;
                }
                *corner = vertex;
            }
        }
    }
    texcoords.iter_mut().filter(|t| t[0].is_nan()).for_each(|t| *t = [0.0; 2]);
    Some(Split { texcoords, copied, faces_without })
}
