//! The normals of vertices where surfaces end, meet at a crease, or touch.

use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use crate::loops::prelude::*;

use super::faces::Faces;
use super::fan::{Fan, Split};
use super::members::Members;
use super::smooth::UNSETTLED;
use super::{Move, OctNormal, Splits};
use crate::Mesh;
use crate::adjacency::Adjacency;
use crate::blocks::{Block, Blocks};
use crate::trig::sin_cos;
use crate::weld::first_at_position;

const CHUNK: usize = 1 << 14;

/// Computes the normals of the vertices whose normal is [`UNSETTLED`]; `doubtful` are their numbers, in any order.
/// The normals of new vertices are appended.
pub(super) fn settle(
    mesh: &Mesh,
    blocks: &Blocks,
    normals: &mut Vec<OctNormal>,
    doubtful: &[u32],
    crease_angle: f64,
) -> Splits {
    if doubtful.is_empty() {
        return Splits::default();
    }
    let part = Part::new(mesh, blocks, normals, doubtful);
    let vertices = part.vertices.len();
    let around = Adjacency::new(&part.triangles, vertices, |v| part.same[v as usize]);
    let faces = Faces { positions: &part.positions, triangles: &part.triangles, same: &part.same };
    let cos_crease = sin_cos(crease_angle.clamp(0.0, std::f64::consts::PI)).1;
    let found: Vec<AtomicU32> =
        (0..vertices).into_par_iter().map(|_| AtomicU32::new(OctNormal::default().0)).collect();
    let splits: Vec<Split> = (0..vertices.div_ceil(CHUNK))
        .into_par_iter()
        .map(|chunk| {
            let mut split = Split::default();
            let mut fan = Fan::default();
            for r in (chunk * CHUNK..vertices.min((chunk + 1) * CHUNK)).filter(|&r| part.doubtful[r]) {
                fan.split(&faces, r as u32, around.at(r), cos_crease, &found, &mut split);
            }
            split
        })
        .collect();
    for (place, &v) in part.vertices.iter().enumerate().filter(|(place, _)| part.doubtful[*place]) {
        normals[v as usize] = OctNormal(found[place].load(Relaxed));
    }
    part.join(splits, normals)
}

/// The triangles at doubtful vertices, with their vertices renumbered in the same order.
struct Part {
    /// Vertex of the mesh, in order.
    vertices: Vec<u32>,
    /// For each vertex: is its normal to be computed? The others are only neighbours.
    doubtful: Vec<bool>,
    /// For each vertex the first doubtful one at the same position; itself if it is not doubtful.
    same: Vec<u32>,
    positions: Vec<[f32; 3]>,
    /// Triangle of the mesh, in order.
    names: Vec<u32>,
    triangles: Vec<[u32; 3]>,
}

impl Part {
    fn new(mesh: &Mesh, blocks: &Blocks, normals: &[OctNormal], doubtful: &[u32]) -> Self {
        let mut found = triangles_at(blocks, normals);
        found.par_sort_unstable();
        let used = found.iter().flat_map(|t| t.1).chain(doubtful.iter().copied());
        let members = Members::new(mesh.positions.len(), used);
        let vertices = members.list();
        let doubtful: Vec<bool> = vertices.par_iter().map(|&v| normals[v as usize].0 == UNSETTLED).collect();
        let positions: Vec<[f32; 3]> = vertices.par_iter().map(|&v| mesh.positions[v as usize]).collect();
        let names = found.par_iter().map(|t| t.0).collect();
        let triangles = found.par_iter().map(|t| t.1.map(|v| members.rank(v))).collect();
        let same = representatives(&positions, &doubtful);
        Self { vertices, doubtful, same, positions, names, triangles }
    }

    /// Numbers the new vertices of all chunks, and appends their normals. If there would be too many, the vertices
    /// keep the normal of their first surface.
    fn join(&self, splits: Vec<Split>, normals: &mut Vec<OctNormal>) -> Splits {
        let mut all = Splits::default();
        for split in splits {
            let first = normals.len() as u64;
            if first + split.copies.len() as u64 > crate::mesh::MAX_ELEMENTS {
                break;
            }
            for (source, normal) in split.copies {
                all.sources.push(self.vertices[source as usize]);
                normals.push(normal);
            }
            all.moves.extend(split.moves.iter().map(|&(t, corner, copy)| {
                let from = self.vertices[self.triangles[t as usize][usize::from(corner)] as usize];
                Move { triangle: self.names[t as usize], from, to: first as u32 + copy }
            }));
        }
        all.moves.par_sort_unstable_by_key(|m| (m.triangle, m.from));
        all
    }
}

/// Number and corners of all triangles at unsettled vertices, in no particular order.
fn triangles_at(blocks: &Blocks, normals: &[OctNormal]) -> Vec<(u32, [u32; 3])> {
    let in_block = |block: &Block| -> Vec<(u32, [u32; 3])> {
        let doubtful: Vec<bool> =
            block.vertices.iter().map(|&v| normals[v as usize].0 == UNSETTLED).collect();
        if !doubtful.contains(&true) {
            return Vec::new();
        }
        let corners = blocks.corners[block.range()].iter().enumerate();
        let here = corners.filter(|(_, corners)| corners.iter().any(|&v| doubtful[usize::from(v)]));
        here.map(|(t, &corners)| (blocks.number(block, t), block.name(corners))).collect()
    };
    blocks.list.par_iter().flat_map_iter(in_block).collect()
}

/// Maps each doubtful vertex to the first doubtful one at the same position, and every other vertex to itself.
fn representatives(positions: &[[f32; 3]], doubtful: &[bool]) -> Vec<u32> {
    let mut same: Vec<u32> = (0..positions.len() as u32).collect();
    let places: Vec<u32> = (0..positions.len() as u32).filter(|&v| doubtful[v as usize]).collect();
    let points: Vec<[f32; 3]> = places.iter().map(|&v| positions[v as usize]).collect();
    for (&place, first) in places.iter().zip(first_at_position(&points)) {
        same[place as usize] = places[first as usize];
    }
    same
}
