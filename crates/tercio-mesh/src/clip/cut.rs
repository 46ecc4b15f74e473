//! One mesh cut at one plane.

use std::collections::HashSet;

use crate::loops::prelude::*;

use super::ClipError;
use super::outline::Segment;
use super::plane::{LocalPlane, Side};
use super::vertices;
use crate::Mesh;
use crate::mesh::MAX_ELEMENTS;
use crate::weld::position_bits;

/// Triangles of a task.
const CHUNK: usize = 1 << 14;

/// What a cut has left.
pub(super) struct Cut {
    /// For each new triangle the number of the old one that it is, or is a piece of; never descending.
    pub sources: Vec<u32>,
    /// The edges along the plane, if requested.
    pub outline: Vec<Edge>,
}

/// An edge along the plane at which the surface that is kept ends.
pub(super) struct Edge {
    /// Its ends; a cap has it in this direction.
    pub segment: Segment,
    /// The old number of its triangle.
    pub triangle: u32,
    /// Whether its triangle was cut; otherwise nothing is left of it.
    pub is_cut: bool,
}

/// Removes what is on the other side of the plane. Vertices that are no longer used stay; arrays of triangles
/// are not changed, except for [`Mesh::triangles`]. `None` if nothing was removed.
///
/// With `outline`, triangles in the plane whose front is on the side that is kept are removed: they end a solid
/// of which nothing else is left. Those which face the other way are where the solid that is kept ends.
pub(super) fn cut(mesh: &mut Mesh, plane: &LocalPlane, outline: bool) -> Result<Option<Cut>, ClipError> {
    let sides: Vec<Side> = mesh.positions.par_iter().map(|&p| plane.side(p)).collect();
    let is_whole = |t: &[u32; 3]| is_kept(t.map(|v| sides[v as usize]), mesh, t, plane, outline);
    if mesh.triangles.par_iter().all(is_whole) {
        return Ok(None);
    }
    let mut edges: Vec<(u32, u32)> =
        mesh.triangles.par_iter().flat_map_iter(|t| crossed_edges(t, &sides)).collect();
    edges.par_sort_unstable();
    edges.dedup();
    let first = mesh.positions.len();
    check(first + edges.len(), "vertices")?;
    vertices::append_crossings(mesh, &edges, plane);

    let number = |kept, removed| {
        let found = edges.binary_search(&(kept, removed));
        (first + found.unwrap_or_else(|_| unreachable!("all crossed edges were collected"))) as u32
    };
    let cutter = Cutter { mesh, plane, sides: &sides, number: &number, outline };
    let chunks: Vec<Chunk> = mesh
        .triangles
        .par_chunks(CHUNK)
        .enumerate()
        .map(|(n, chunk)| cutter.chunk(n * CHUNK, chunk))
        .collect();
    let count = chunks.iter().map(|c| c.triangles.len()).sum();
    check(count, "triangles")?;
    let mut cut = Cut { sources: Vec::with_capacity(count), outline: Vec::new() };
    mesh.triangles = Vec::with_capacity(count);
    for chunk in chunks {
        mesh.triangles.extend(chunk.triangles);
        cut.sources.extend(chunk.sources);
        cut.outline.extend(chunk.outline);
    }
    Ok(Some(cut))
}

fn check(count: usize, what: &'static str) -> Result<(), ClipError> {
    let count = count as u64;
    if count > MAX_ELEMENTS { Err(ClipError::TooMany { what, count }) } else { Ok(()) }
}

/// Whether nothing of a triangle is removed.
fn is_kept(sides: [Side; 3], mesh: &Mesh, t: &[u32; 3], plane: &LocalPlane, outline: bool) -> bool {
    if sides == [Side::On; 3] {
        return !(outline && faces_the_kept_side(mesh, t, plane));
    }
    !sides.contains(&Side::Removed)
}

fn faces_the_kept_side(mesh: &Mesh, t: &[u32; 3], plane: &LocalPlane) -> bool {
    let [a, b, c] = t.map(|v| glam::Vec3::from(mesh.positions[v as usize]).as_dvec3());
    (b - a).cross(c - a).dot(plane.normal) > 0.0
}

/// The edges of a triangle that cross the plane, from the vertex that is kept to the other.
fn crossed_edges(t: &[u32; 3], sides: &[Side]) -> impl Iterator<Item = (u32, u32)> {
    let [a, b, c] = *t;
    let of_edge = |(v, w): (u32, u32)| match (sides[v as usize], sides[w as usize]) {
        (Side::Kept, Side::Removed) => Some((v, w)),
        (Side::Removed, Side::Kept) => Some((w, v)),
        _ => None,
    };
    [(a, b), (b, c), (c, a)].map(of_edge).into_iter().flatten()
}

/// What is left of a run of triangles.
#[derive(Default)]
struct Chunk {
    triangles: Vec<[u32; 3]>,
    sources: Vec<u32>,
    outline: Vec<Edge>,
}

struct Cutter<'a, N> {
    mesh: &'a Mesh,
    plane: &'a LocalPlane,
    sides: &'a [Side],
    /// The vertex in which an edge crosses the plane.
    number: &'a N,
    outline: bool,
}

impl<N: Fn(u32, u32) -> u32 + Sync> Cutter<'_, N> {
    fn chunk(&self, first: usize, triangles: &[[u32; 3]]) -> Chunk {
        let mut chunk = Chunk::default();
        for (source, t) in (first as u32..).zip(triangles) {
            let sides = t.map(|v| self.sides[v as usize]);
            if is_kept(sides, self.mesh, t, self.plane, self.outline) {
                chunk.triangles.push(*t);
                chunk.sources.push(source);
            } else if sides.contains(&Side::Kept) {
                self.split(t, source, &mut chunk);
            } else if self.outline {
                for [v, w] in [[0, 1], [1, 2], [2, 0]] {
                    if [sides[v], sides[w]] == [Side::On; 2] {
                        chunk.outline.push(self.edge([t[v], t[w]], source, false));
                    }
                }
            }
        }
        chunk
    }

    /// Adds the part of a triangle that is kept.
    fn split(&self, t: &[u32; 3], source: u32, chunk: &mut Chunk) {
        let mut polygon = [0; 4];
        let mut count = 0;
        let mut add = |v: u32| {
            polygon[count] = v;
            count += 1;
        };
        // The vertices in the plane: where the border leaves the kept side, and where it comes back.
        let (mut leaves, mut returns) = (0, 0);
        for k in 0..3 {
            let (v, w, before) = (t[k], t[(k + 1) % 3], t[(k + 2) % 3]);
            let [here, next, previous] = [v, w, before].map(|v| self.sides[v as usize]);
            match here {
                Side::Kept => add(v),
                Side::On => {
                    add(v);
                    if next == Side::Removed {
                        leaves = v;
                    }
                    if previous == Side::Removed {
                        returns = v;
                    }
                }
                Side::Removed => {}
            }
            match (here, next) {
                (Side::Kept, Side::Removed) => {
                    leaves = (self.number)(v, w);
                    add(leaves);
                }
                (Side::Removed, Side::Kept) => {
                    returns = (self.number)(w, v);
                    add(returns);
                }
                _ => {}
            }
        }
        let [a, b, c, d] = polygon;
        let mut add = |t: [u32; 3]| {
            let [a, b, c] = t.map(|v| position_bits(self.mesh.positions[v as usize]));
            // Crossings of two edges that are rounded to the same point: nothing is between them.
            if a != b && b != c && c != a {
                chunk.triangles.push(t);
                chunk.sources.push(source);
            }
        };
        if count == 3 {
            add([a, b, c]);
        } else if self.length(a, c) <= self.length(b, d) {
            add([a, b, c]);
            add([a, c, d]);
        } else {
            add([a, b, d]);
            add([b, c, d]);
        }
        if self.outline {
            chunk.outline.push(self.edge([returns, leaves], source, true));
        }
    }

    /// The square of the distance of two vertices.
    fn length(&self, a: u32, b: u32) -> f64 {
        let [a, b] = [a, b].map(|v| glam::Vec3::from(self.mesh.positions[v as usize]).as_dvec3());
        a.distance_squared(b)
    }

    fn edge(&self, ends: [u32; 2], triangle: u32, is_cut: bool) -> Edge {
        let [from, to] = ends.map(|v| self.mesh.positions[v as usize]);
        Edge { segment: Segment { from, to, weight: 1 }, triangle, is_cut }
    }
}

/// The positions of the vertices in the plane at which something is left.
pub(super) fn rim(mesh: &Mesh, plane: &LocalPlane) -> HashSet<[u32; 3]> {
    let used = vertices::used(mesh);
    let all = mesh.positions.par_iter().zip(used);
    let on = all.filter(|&(&p, used)| used && plane.side(p) == Side::On);
    let on: Vec<[u32; 3]> = on.map(|(&p, _)| position_bits(p)).collect();
    on.into_iter().collect()
}
