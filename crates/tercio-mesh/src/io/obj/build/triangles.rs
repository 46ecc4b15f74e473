//! The triangles of faces.

use crate::loops::prelude::*;
use crate::polygon::Triangulator;

use super::Chunk;

/// The faces as triangles, and each triangle's face if their numbers differ. Frees the corners.
pub fn triangles(
    chunks: &mut [Chunk],
    positions: &[[f64; 3]],
    count: usize,
) -> (Vec<[u32; 3]>, Option<Vec<u32>>) {
    let cut: Vec<Option<Cut>> = chunks
        .par_iter()
        .map(|chunk| Some(triangulate(&chunk.corners.v, chunk.corners.sizes()?, positions)))
        .collect();
    let is_mixed = cut.iter().any(Option::is_some);
    let mut triangles = Vec::with_capacity(count);
    let mut faces = Vec::with_capacity(if is_mixed { count } else { 0 });
    let mut face = 0;
    for (chunk, cut) in chunks.iter_mut().zip(cut) {
        let corners = std::mem::take(&mut chunk.corners.v);
        match cut {
            Some((t, f)) => {
                triangles.extend(t);
                faces.extend(f.into_iter().map(|f| f + face));
            }
            None => {
                triangles.extend_from_slice(corners.as_chunks::<3>().0);
                if is_mixed {
                    faces.extend(face..face + chunk.corners.faces());
                }
            }
        }
        face += chunk.corners.faces();
    }
    (triangles, is_mixed.then_some(faces))
}

/// Triangles, and the face of the chunk that each comes from.
type Cut = (Vec<[u32; 3]>, Vec<u32>);

fn triangulate(corners: &[u32], sizes: &[u32], positions: &[[f64; 3]]) -> Cut {
    let mut triangulator = Triangulator::default();
    let mut points = Vec::new();
    let mut triangles = Vec::with_capacity(corners.len() - 2 * sizes.len());
    let mut faces = Vec::with_capacity(triangles.capacity());
    let mut rest = corners;
    for (face, &size) in sizes.iter().enumerate() {
        let (polygon, tail) = rest.split_at(size as usize);
        rest = tail;
        if let &[a, b, c] = polygon {
            triangles.push([a, b, c]);
        } else {
            points.clear();
            points.extend(polygon.iter().map(|&v| positions[v as usize]));
            triangulator.triangulate(&points, |t| triangles.push(t.map(|i| polygon[i])));
        }
        faces.resize(triangles.len(), face as u32);
    }
    (triangles, faces)
}
