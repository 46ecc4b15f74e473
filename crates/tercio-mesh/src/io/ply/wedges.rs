//! Texture coordinates given at the corners of faces instead of at the vertices.

use std::collections::HashMap;

use super::table::Lists;
use crate::mesh::MAX_ELEMENTS;

/// Texture coordinates moved to the vertices.
#[derive(Debug)]
pub(super) struct Split {
    /// One pair per vertex; the vertices of the file, then the copies.
    pub(super) texcoords: Vec<[f32; 2]>,
    /// The vertex that each copy repeats.
    pub(super) copied: Vec<u32>,
    /// Faces whose list does not have a pair per corner; their corners get (0, 0).
    pub(super) faces_without: u64,
}

const NONE: u32 = u32::MAX;

/// Copies of one vertex after the first `CHAIN` are looked up by hash, so that a vertex at which all faces disagree
/// does not take quadratic time.
const CHAIN: usize = 32;

/// Gives every vertex one pair of texture coordinates: a vertex at which faces disagree is copied, and the faces'
/// corners are changed to the copies. `None` if there would be too many vertices.
pub(super) fn split(lists: &mut [Lists], vertices: usize) -> Option<Split> {
    let mut texcoords = vec![[f32::NAN; 2]; vertices];
    // The next copy of the same vertex.
    let mut next = vec![NONE; vertices];
    let mut copied = Vec::new();
    // Copies that are in no chain, by the vertex of the file and the bits of the pair, with -0 stored as 0.
    let mut others: HashMap<(u32, [u32; 2]), u32> = HashMap::new();
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
                let mut links = 0;
                loop {
                    let (found, next_copy) =
                        (texcoords.get_mut(vertex as usize)?, *next.get(vertex as usize)?);
                    if found.iter().any(|v| v.is_nan()) {
                        *found = pair;
                    }
                    if *found == pair {
                        break;
                    }
                    links += 1;
                    if next_copy != NONE && links < CHAIN {
                        vertex = next_copy;
                        continue;
                    }
                    let new = texcoords.len();
                    if new as u64 >= MAX_ELEMENTS {
                        return None;
                    }
                    if links == CHAIN {
                        let key = (first, pair.map(|v| (v + 0.0).to_bits()));
                        let copy = *others.entry(key).or_insert(new as u32);
                        if copy as usize != new {
                            vertex = copy;
                            break;
                        }
                    } else {
                        *next.get_mut(vertex as usize)? = new as u32;
                    }
                    texcoords.push(pair);
                    next.push(NONE);
                    copied.push(first);
                    vertex = new as u32;
                    break;
                }
                *corner = vertex;
            }
        }
    }
    texcoords.iter_mut().filter(|t| t[0].is_nan()).for_each(|t| *t = [0.0; 2]);
    Some(Split { texcoords, copied, faces_without })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_vertex_at_which_all_faces_disagree_is_copied_once_a_pair() {
        let faces = 300_000u32;
        let mut lists = vec![Lists {
            counts: vec![3; faces as usize],
            corners: (0..faces).flat_map(|_| [0, 1, 2]).collect(),
            wedge_counts: vec![6; faces as usize],
            // The first vertex has a different pair in each face of the first half, and the same pairs again in the
            // second.
            wedges: (0..faces).flat_map(|i| [(i % (faces / 2)) as f32, -0.0, 0.0, 0.0, -0.0, 1.0]).collect(),
        }];
        let split = split(&mut lists, 3).expect("room for all");
        assert_eq!(split.texcoords.len() as u32, 3 + faces / 2 - 1);
        assert!(split.copied.iter().all(|&v| v == 0));
        for (i, corners) in lists[0].corners.chunks(3).enumerate() {
            let pair = split.texcoords[corners[0] as usize];
            assert_eq!((pair[0], &corners[1..]), ((i as u32 % (faces / 2)) as f32, &[1, 2][..]));
        }
    }
}
