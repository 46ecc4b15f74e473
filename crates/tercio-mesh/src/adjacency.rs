//! Which triangles meet at a vertex.

use std::sync::atomic::{AtomicU32, AtomicU64, Ordering::Relaxed};

use crate::loops::prelude::*;

/// For each vertex the triangles that use it, in ascending order.
pub(crate) struct Adjacency {
    /// End of a vertex's range in `triangles`; the range begins where its predecessor's ends.
    ends: Vec<u64>,
    triangles: Vec<u32>,
}

impl Adjacency {
    /// Counting sort of the triangles' corners by vertex. `vertex_of` maps an index to one of the `vertices`.
    ///
    /// A triangle that uses a vertex twice is listed there twice.
    pub(crate) fn new(
        triangles: &[[u32; 3]],
        vertices: usize,
        vertex_of: impl Fn(u32) -> u32 + Sync + Send,
    ) -> Self {
        const CHUNK: usize = 1 << 16;
        let cursors: Vec<AtomicU64> = (0..vertices).into_par_iter().map(|_| AtomicU64::new(0)).collect();
        triangles.par_chunks(CHUNK).for_each(|chunk| {
            for &i in chunk.as_flattened() {
                cursors[vertex_of(i) as usize].fetch_add(1, Relaxed);
            }
        });

        // From counts to offsets (exclusive prefix sum).
        let sums: Vec<u64> = cursors
            .par_chunks(CHUNK)
            .map(|chunk| chunk.iter().map(|c| c.load(Relaxed)).sum::<u64>())
            .collect();
        let firsts: Vec<u64> =
            sums.iter().scan(0, |sum, &n| Some(std::mem::replace(sum, *sum + n))).collect();
        cursors.par_chunks(CHUNK).zip(firsts).for_each(|(chunk, mut sum)| {
            for c in chunk {
                let count = c.load(Relaxed);
                c.store(sum, Relaxed);
                sum += count;
            }
        });

        // Threads write a vertex's triangles in any order; sorting the few triangles of each vertex afterwards makes
        // the order deterministic.
        let places: Vec<AtomicU32> =
            (0..triangles.len() * 3).into_par_iter().map(|_| AtomicU32::new(0)).collect();
        triangles.par_chunks(CHUNK).enumerate().for_each(|(n, chunk)| {
            for (k, t) in chunk.iter().enumerate() {
                for &i in t {
                    let place = cursors[vertex_of(i) as usize].fetch_add(1, Relaxed);
                    places[place as usize].store((n * CHUNK + k) as u32, Relaxed);
                }
            }
        });
        let ends: Vec<u64> = cursors.into_iter().map(AtomicU64::into_inner).collect();
        let mut list: Vec<u32> = places.into_iter().map(AtomicU32::into_inner).collect();

        // Split the list at the ends of vertices' ranges, so that each task owns its part.
        let mut pieces = Vec::new();
        let mut rest = list.as_mut_slice();
        let mut begin = 0;
        for ends in ends.chunks(CHUNK) {
            let end = ends.last().copied().unwrap_or(begin);
            let (piece, tail) = rest.split_at_mut((end - begin) as usize);
            pieces.push((begin, ends, piece));
            rest = tail;
            begin = end;
        }
        pieces.into_par_iter().for_each(|(begin, ends, piece)| {
            let mut from = 0;
            for &end in ends {
                let to = (end - begin) as usize;
                piece[from..to].sort_unstable();
                from = to;
            }
        });
        Self { ends, triangles: list }
    }

    /// The triangles at a vertex.
    #[inline]
    pub(crate) fn at(&self, vertex: usize) -> &[u32] {
        let begin = if vertex == 0 { 0 } else { self.ends[vertex - 1] };
        &self.triangles[begin as usize..self.ends[vertex] as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn triangles_are_listed_at_their_corners_in_order() {
        let triangles: Vec<[u32; 3]> = (0..200_000u32).map(|i| [i % 1000, 1000 + i % 7, 2000]).collect();
        let a = Adjacency::new(&triangles, 2002, |v| v);
        for v in 0..2002u32 {
            let here: Vec<u32> = (0..200_000).filter(|&t| triangles[t as usize].contains(&v)).collect();
            if v % 50 == 0 || v >= 1000 && here.len() > 1 || v == 2001 {
                assert_eq!(a.at(v as usize), here);
            }
        }
    }
}
