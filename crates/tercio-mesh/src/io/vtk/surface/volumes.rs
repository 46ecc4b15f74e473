//! Faces that belong to one volume only.
//!
//! Faces are sorted into buckets by their lowest corner, and those of a bucket are compared with each other: a point of a
//! usual grid is the lowest corner of few faces, so time is linear. A bucket with many faces is sorted: whatever the file
//! holds, time is linear up to a logarithm.

use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use crate::loops::prelude::*;

use super::{CHUNK, Extraction, Part};
use crate::ReadError;
use crate::io::vtk::cells::Shape;
use crate::io::vtk::dataset::{Cells, Job};

/// Faces that are sorted into their buckets at once, so that the buckets are in the cache.
const SLICE: u64 = 1 << 15;
/// Slices at most: every chunk of cells knows where its faces of each slice begin.
const MOST_SLICES: u64 = 1 << 10;
/// Faces of a bucket that are compared each with each.
const FEW: usize = 32;

/// A face of a volume.
#[derive(Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord)]
struct Face {
    /// The three lowest corners in ascending order, and the fourth, or a hash of the rest.
    corners: [u32; 4],
    number: u32,
}

/// The buckets of faces, by the lowest corner.
#[derive(Clone, Copy)]
struct Buckets {
    /// A bucket is for so many points: two to this.
    points: u32,
    /// A slice has so many buckets: two to this.
    of_slice: u32,
    slices: usize,
}

impl Buckets {
    fn of(points: u64, faces: u64) -> Self {
        let mut buckets = Self { points: 0, of_slice: 0, slices: 0 };
        // Many more buckets than faces would only take memory.
        while points >> buckets.points > faces.max(1) {
            buckets.points += 1;
        }
        let all = (points >> buckets.points) + 1;
        let slices = (faces / SLICE).clamp(1, MOST_SLICES);
        while all >> buckets.of_slice >= slices {
            buckets.of_slice += 1;
        }
        buckets.slices = (all >> buckets.of_slice) as usize + 1;
        buckets
    }

    fn slice(self, face: &Face) -> usize {
        (face.corners[0] >> self.points >> self.of_slice) as usize
    }

    /// The bucket of a face among those of its slice.
    fn in_slice(self, face: &Face) -> usize {
        (face.corners[0] >> self.points) as usize & ((1 << self.of_slice) - 1)
    }
}

/// Which faces are drawn, by their numbers in the order of the cells.
pub struct Outer {
    /// Number of the first face of each chunk of cells.
    first: Vec<u32>,
    bits: Vec<AtomicU64>,
}

impl Outer {
    pub fn first(&self, chunk: usize) -> usize {
        self.first.get(chunk).map_or(0, |&n| n as usize)
    }

    pub fn is(&self, face: usize) -> bool {
        self.bits.get(face / 64).is_some_and(|word| word.load(Relaxed) >> (face % 64) & 1 > 0)
    }

    /// Is one of these faces drawn? No more than 64 are asked for.
    pub fn are_any(&self, faces: Range<usize>) -> bool {
        let word = |at: usize| self.bits.get(at).map_or(0, |word| word.load(Relaxed));
        let (first, shift) = (faces.start / 64, faces.start % 64);
        // Two words hold them all.
        let both = u128::from(word(first)) | u128::from(word(first + 1)) << 64;
        (both >> shift) & ((1 << faces.len()) - 1) != 0
    }

    /// Finds the faces that no other volume has.
    pub fn find(cells: &Extraction, job: &Job) -> Result<Self, ReadError> {
        let none = Self { first: Vec::new(), bits: Vec::new() };
        if matches!(cells.data.cells, Cells::Poly(_)) {
            return Ok(none);
        }
        let chunks = cells.count.div_ceil(CHUNK);
        let counts: Vec<u64> = (0..chunks).into_par_iter().map(|chunk| count(cells, chunk)).collect();
        let all: u64 = counts.iter().sum();
        if all == 0 {
            return Ok(none);
        }
        if all > u32::MAX.into() {
            return Err(ReadError::TooMany { file: job.file().into(), what: "faces of volumes", count: all });
        }
        let buckets = Buckets::of(cells.data.points.count(), all);
        // All faces, and those of the slices that are sorted: at worst all are in one.
        let starts = (chunks as u64).saturating_mul(4 * (buckets.slices as u64 + 1));
        job.reserve(
            "the faces of its volumes",
            (all * (2 * size_of::<Face>() as u64 + 1)).saturating_add(starts),
        )?;
        let first: Vec<u32> = counts
            .iter()
            .scan(0, |sum, &n| {
                *sum += n;
                Some((*sum - n) as u32)
            })
            .collect();
        let sorted: Vec<Sliced> = (0..chunks)
            .into_par_iter()
            .map(|chunk| {
                let (count, first) = (counts.get(chunk), first.get(chunk));
                let mut faces = Vec::with_capacity(count.map_or(0, |&n| n as usize));
                push_faces(cells, chunk, first.copied().unwrap_or(0), &mut faces);
                Sliced::new(&faces, buckets)
            })
            .collect();
        let bits: Vec<AtomicU64> = (0..all.div_ceil(64)).map(|_| AtomicU64::new(0)).collect();
        (0..buckets.slices).into_par_iter().for_each(|slice| {
            let parts: Vec<&[Face]> = sorted.iter().map(|chunk| chunk.slice(slice)).collect();
            for_each_outer(&parts, buckets, |face| {
                if let Some(word) = bits.get(face.number as usize / 64) {
                    word.fetch_or(1 << (face.number % 64), Relaxed);
                }
            });
        });
        Ok(Self { first, bits })
    }
}

/// The volumes of a chunk of cells.
fn volumes(cells: &Extraction, chunk: usize, mut each: impl FnMut(Shape, &[u32])) {
    let mut buffer = [0; 8];
    for cell in chunk * CHUNK..((chunk + 1) * CHUNK).min(cells.count) {
        let (shape, nodes) = cells.cell(cell, &mut buffer);
        if matches!(shape, Shape::Volume(_) | Shape::Polyhedron)
            && cells.ghosts.part(cell, nodes) != Part::Gone
        {
            each(shape, nodes);
        }
    }
}

fn count(cells: &Extraction, chunk: usize) -> u64 {
    let all = chunk * CHUNK..((chunk + 1) * CHUNK).min(cells.count);
    if let Some(count) = all.map(|cell| cells.face_count(cell)).sum::<Option<usize>>() {
        return count as u64;
    }
    let mut count = 0;
    volumes(cells, chunk, |shape, nodes| match shape {
        Shape::Volume(volume) => count += volume.faces.len() as u64,
        _ => Extraction::faces(shape, nodes, |_, _| count += 1),
    });
    count
}

/// Appends the faces of a chunk of cells.
fn push_faces(cells: &Extraction, chunk: usize, first: u32, faces: &mut Vec<Face>) {
    let (mut number, mut scratch) = (first, Vec::new());
    volumes(cells, chunk, |shape, nodes| {
        Extraction::faces(shape, nodes, |corners, nodes| {
            let corners = nodes.get(..corners).unwrap_or(nodes);
            faces.push(Face { corners: key(corners, &mut scratch), number });
            number += 1;
        });
    });
}

/// Faces of a chunk of cells in the order of their slices.
struct Sliced {
    faces: Vec<Face>,
    ends: Vec<u32>,
}

impl Sliced {
    fn new(faces: &[Face], buckets: Buckets) -> Self {
        let (faces, ends) = counting_sort(&[faces], buckets.slices, |face| buckets.slice(face));
        Self { faces, ends }
    }

    fn slice(&self, slice: usize) -> &[Face] {
        range(&self.faces, &self.ends, slice)
    }
}

/// The elements of a bucket after [`counting_sort`].
fn range<'a>(faces: &'a [Face], ends: &[u32], bucket: usize) -> &'a [Face] {
    let end = |i: usize| ends.get(i).map_or(0, |&n| n as usize);
    faces.get(bucket.checked_sub(1).map_or(0, end)..end(bucket)).unwrap_or_default()
}

/// Faces in the order of their buckets, and the end of each bucket.
fn counting_sort(
    parts: &[&[Face]],
    buckets: usize,
    bucket: impl Fn(&Face) -> usize,
) -> (Vec<Face>, Vec<u32>) {
    let mut ends = vec![0u32; buckets];
    let all = || parts.iter().copied().flatten();
    let mut count = 0;
    for face in all() {
        ends[bucket(face)] += 1;
        count += 1;
    }
    let mut sum = 0;
    for end in &mut ends {
        // For now the begin.
        (*end, sum) = (sum, sum + *end);
    }
    let mut sorted = vec![Face::default(); count];
    for face in all() {
        let next = &mut ends[bucket(face)];
        sorted[*next as usize] = *face;
        *next += 1;
    }
    (sorted, ends)
}

/// Calls `each` for the faces of a slice that are there once and have an area.
fn for_each_outer(parts: &[&[Face]], buckets: Buckets, mut each: impl FnMut(&Face)) {
    let (mut faces, ends) = counting_sort(parts, 1 << buckets.of_slice, |face| buckets.in_slice(face));
    let mut each = |face: &Face| {
        // Of collapsed cells some faces are lines.
        if face.corners[2] != u32::MAX {
            each(face);
        }
    };
    let mut begin = 0;
    for end in ends {
        let end = end as usize;
        let faces = &mut faces[begin..end];
        begin = end;
        if faces.len() <= FEW {
            for (i, face) in faces.iter().enumerate() {
                let is_other = |(k, other): (usize, &Face)| k != i && other.corners == face.corners;
                if !faces.iter().enumerate().any(is_other) {
                    each(face);
                }
            }
        } else {
            faces.sort_unstable();
            for same in faces.chunk_by(|a, b| a.corners == b.corners) {
                if let [face] = same {
                    each(face);
                }
            }
        }
    }
}

/// Equal for faces with equal corners.
fn key(corners: &[u32], scratch: &mut Vec<u32>) -> [u32; 4] {
    // Nearly all faces are triangles and quadrilaterals.
    let [a, b, c, d] = match *corners {
        [a, b, c] => sort4([a, b, c, u32::MAX]),
        [a, b, c, d] => sort4([a, b, c, d]),
        _ => [0; 4],
    };
    if a < b && b < c && c < d {
        return [a, b, c, d];
    }
    scratch.clear();
    scratch.extend_from_slice(corners);
    scratch.sort_unstable();
    // Of collapsed cells some corners are one.
    scratch.dedup();
    let at = |i: usize| scratch.get(i).copied().unwrap_or(u32::MAX);
    let fourth = match scratch.get(3..) {
        Some(rest) if rest.len() > 1 => {
            // Begun with a large number, so that lists of different lengths do not meet.
            let begin = (rest.len() as u32).wrapping_mul(0x85eb_ca6b);
            rest.iter().fold(begin, |hash, &n| (hash.rotate_left(13) ^ n).wrapping_mul(0x9e37_79b1))
        }
        _ => at(3),
    };
    // A polyhedron may have faces of no points, which are in the first bucket and have no area.
    [scratch.first().copied().unwrap_or(0), at(1), at(2), fourth]
}

/// In ascending order.
fn sort4([a, b, c, d]: [u32; 4]) -> [u32; 4] {
    let (a, b) = (a.min(b), a.max(b));
    let (c, d) = (c.min(d), c.max(d));
    let (a, c) = (a.min(c), a.max(c));
    let (b, d) = (b.min(d), b.max(d));
    let (b, c) = (b.min(c), b.max(c));
    [a, b, c, d]
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Faces, few enough points that many are equal.
    fn faces() -> impl Strategy<Value = Vec<Vec<u32>>> {
        prop::collection::vec(prop::collection::vec(0..12u32, 0..7), 0..200)
    }

    proptest! {
        #[test]
        fn outer_faces_are_those_that_are_there_once(faces in faces(), shift in 0..3u32, chunk in 1..50usize) {
            let mut sets: Vec<Vec<u32>> = faces.clone();
            for set in &mut sets {
                set.sort_unstable();
                set.dedup();
            }
            let expected: Vec<u32> = (0..sets.len())
                .filter(|&i| sets[i].len() > 2 && sets.iter().filter(|set| **set == sets[i]).count() == 1)
                .map(|i| i as u32)
                .collect();
            let mut scratch = Vec::new();
            let faces: Vec<Face> = faces
                .iter()
                .zip(0..)
                .map(|(corners, number)| Face { corners: key(corners, &mut scratch), number })
                .collect();
            let buckets = Buckets { points: shift, of_slice: 1, slices: (12 >> shift >> 1) + 1 };
            let chunks: Vec<Sliced> = faces.chunks(chunk).map(|faces| Sliced::new(faces, buckets)).collect();
            let mut found = Vec::new();
            for slice in 0..buckets.slices {
                let parts: Vec<&[Face]> = chunks.iter().map(|chunk| chunk.slice(slice)).collect();
                for_each_outer(&parts, buckets, |face| found.push(face.number));
            }
            found.sort_unstable();
            prop_assert_eq!(found, expected);
        }

        #[test]
        fn every_point_has_a_bucket(points in 1..u64::from(u32::MAX), faces in 1..u64::from(u32::MAX), at in 0.0..1.0f64) {
            let buckets = Buckets::of(points, faces);
            prop_assert!(buckets.slices as u64 <= MOST_SLICES + 1);
            prop_assert!(1u64 << buckets.of_slice <= 4 * faces.max(SLICE).max(points / MOST_SLICES));
            let lowest = ((points as f64 * at) as u64).min(points - 1) as u32;
            let face = Face { corners: [lowest; 4], number: 0 };
            prop_assert!(buckets.slice(&face) < buckets.slices);
            prop_assert!(buckets.in_slice(&face) < 1 << buckets.of_slice);
        }
    }
}
