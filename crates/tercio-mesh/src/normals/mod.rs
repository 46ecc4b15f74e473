//! Vertex normals: how they are stored, and how missing ones are made from the triangles around a vertex, weighted by
//! angle.
//!
//! Source: Thürmer and Wüthrich, "Computing Vertex Normals from Polygonal Facets" (1998). Weighted by the angle at
//! the vertex, the normal does not depend on how a flat face is split into triangles.
//!
//! Weights by area besides the angle keep a large flat face flat where small triangles of a fillet meet it within the crease
//! angle: of the flat faces of `rear_case.stl`, 27 % of the area has a corner whose normal is off by more than 2 degrees, and
//! 7 % with the angle times the area. But they bend normals towards larger triangles everywhere else: a cylinder that is cut
//! unevenly gets a streak (`42400-IDGH.stl`), and normals of moderately uneven tori are wrong by 0.9 degrees in place of 0.5
//! (root mean square); only those at slivers are better. The area of the whole planar region in place of the triangle's
//! leaves nothing of the first (0 %), but makes kinks where long and short facets meet. So the angle alone is the weight.
//!
//! `smooth` makes the normals of nearly all vertices in a fast pass that reads each triangle once; `creased` handles
//! the remaining ones precisely. `mend` does the same for single vertices whose normal is broken. Sums are formed in
//! an order that does not depend on the number of threads.

mod creased;
mod faces;
mod fan;
pub(crate) mod members;
mod mend;
mod oct;
mod smooth;
#[cfg(test)]
mod tests;

pub use mend::mend_normals;
pub use oct::OctNormal;

use crate::loops::prelude::*;
use glam::DVec3;

use crate::adjacency::Adjacency;
use crate::blocks::{BlockedMesh, Blocks, Order};
use crate::weld::position_representatives;
use crate::{AttributeDomain, Mesh};
use faces::Faces;
use members::Members;

/// Computes new vertex normals for the mesh; they replace those it has.
///
/// Vertices that no triangle with an area uses get +z.
///
/// Without a `crease_angle`, vertices at the same position share their normal, even where texture coordinates
/// or colours split them.
///
/// With a `crease_angle` (radians, 0 to pi), the triangles at a position are one smooth surface only as far as they
/// are connected by edges at that position across which the face normals differ by at most the angle. Each surface
/// gets its own normal, and a vertex that several use is split: the first keeps the number, the vertices of the
/// others are appended to [`Mesh::positions`] and every vertex array. If there would be too many to number, the
/// vertex keeps the normal of its first surface. Vertices at the same position are processed together where the
/// triangles of each leave a gap, as at a seam; a vertex in the middle of a smooth surface is independent of other
/// surfaces that pass through the same point.
///
/// # Panics
///
/// If a triangle's vertex does not exist, or a vertex array is too short.
pub fn make_normals(mesh: &mut Mesh, crease_angle: Option<f64>) {
    let Some(angle) = crease_angle else {
        mesh.normals = Some(uncreased(mesh));
        return;
    };
    let blocks = Blocks::new(mesh, Order::Auto);
    let splits = make_creased(mesh, &blocks, angle);
    splits.apply(&mut mesh.triangles);
}

impl BlockedMesh {
    /// As [`make_normals`] with a crease angle, for a mesh that is already split into blocks.
    ///
    /// # Panics
    /// If a vertex array is too short.
    pub fn make_normals(&mut self, crease_angle: f64) {
        let splits = make_creased(&mut self.mesh, &self.blocks, crease_angle);
        self.apply(&splits);
    }

    fn apply(&mut self, splits: &Splits) {
        if splits.moves.is_empty() {
            return;
        }
        let left = Members::new(self.mesh.positions.len(), splits.moves.iter().map(|m| m.from));
        self.blocks.rename(&|v| left.has(v), &|t, corners| {
            let first = splits.moves.partition_point(|m| m.triangle < t);
            splits.moves[first..].iter().take_while(|m| m.triangle == t).for_each(|m| m.apply(corners));
        });
    }
}

/// New vertices, and which triangles use them in place of an old one.
#[derive(Default)]
struct Splits {
    /// The old vertex that each new one is a copy of.
    sources: Vec<u32>,
    /// In the order of triangles.
    moves: Vec<Move>,
}

impl Splits {
    fn apply(&self, triangles: &mut [[u32; 3]]) {
        self.moves.iter().for_each(|m| m.apply(&mut triangles[m.triangle as usize]));
    }

    /// Appends the new vertices to every vertex array but the normals.
    fn append_vertices(&self, mesh: &mut Mesh) {
        fn append<T: Copy>(array: &mut Vec<T>, sources: &[u32]) {
            array.reserve_exact(sources.len());
            for &s in sources {
                array.push(array[s as usize]);
            }
        }
        append(&mut mesh.positions, &self.sources);
        mesh.vertex_colors.iter_mut().for_each(|a| append(a, &self.sources));
        mesh.texcoords.iter_mut().for_each(|a| append(a, &self.sources));
        for a in &mut mesh.attributes {
            if a.domain == AttributeDomain::Vertex {
                append(&mut a.values, &self.sources);
            }
        }
    }
}

/// A corner of a triangle changes from an old vertex to a new one.
struct Move {
    triangle: u32,
    from: u32,
    to: u32,
}

impl Move {
    fn apply(&self, corners: &mut [u32; 3]) {
        corners.iter_mut().filter(|v| **v == self.from).for_each(|v| *v = self.to);
    }
}

/// Makes the normals and the new vertices; the triangles still name the old ones.
fn make_creased(mesh: &mut Mesh, blocks: &Blocks, crease_angle: f64) -> Splits {
    let (mut normals, doubtful) = smooth::settle(mesh, blocks, crease_angle);
    let splits = creased::settle(mesh, blocks, &mut normals, &doubtful, crease_angle);
    splits.append_vertices(mesh);
    mesh.normals = Some(normals);
    splits
}

/// One normal per position, smooth across every edge.
fn uncreased(mesh: &Mesh) -> Vec<OctNormal> {
    let same = position_representatives(mesh);
    let around = Adjacency::new(&mesh.triangles, mesh.positions.len(), |v| same[v as usize]);
    let faces = Faces { positions: &mesh.positions, triangles: &mesh.triangles, same: &same };
    let normals: Vec<OctNormal> = (0..mesh.positions.len())
        .into_par_iter()
        .with_min_len(1 << 14)
        .map(|v| encode(faces.sum(v as u32, around.at(v))))
        .collect();
    same.par_iter().map(|&s| normals[s as usize]).collect()
}

/// Normalizes and encodes a sum of normals.
fn encode(sum: DVec3) -> OctNormal {
    // Scaled near one, where `f32` neither overflows nor underflows.
    let n = sum / sum.abs().max_element();
    OctNormal::encode([n.x as f32, n.y as f32, n.z as f32])
}
