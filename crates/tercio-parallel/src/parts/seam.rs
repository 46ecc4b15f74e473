//! The triangles of other ranks around a part of a model.
//!
//! What happens to a triangle and to the normals of its vertices depends on the triangles that touch its corners, and, where
//! surfaces end or meet at a crease, on those that touch their corners. So each rank gets two rings of triangles around its
//! own from the others, runs the same code as for a whole model, and drops them again.
//!
//! Touching is a matter of positions. Ranks find out which positions they share from hashes: those of a value belong to one
//! rank, which gets all hashes of that kind and answers who else has them. Only positions inside the box of another rank's
//! part are asked about. Every rank sends at most five messages to each other rank; their bytes follow the surface of the
//! parts.

use std::ops::Range;

use bytemuck::{Pod, cast_slice, pod_collect_to_vec};
use tercio_mesh::Mesh;
use tercio_mesh::loops::prelude::*;
use tercio_mesh::weld::position_bits;

use super::ghosts::{self, Ghosts};
use super::malformed;
use crate::ParallelError;
use crate::comm::Communicator;
use crate::comm::collective::{all_to_all, exclusive_sum};

/// The numbers that the vertices and triangles of a part have in the whole model.
#[derive(Clone, Debug)]
pub struct Numbers {
    /// That of the first triangle; the others follow.
    pub first_triangle: u64,
    /// Those of the vertices.
    pub vertices: VertexNumbers,
}

/// The numbers of a part's vertices in the whole model.
#[derive(Clone, Debug)]
pub enum VertexNumbers {
    /// Consecutive, from this one on.
    From(u64),
    /// In ascending order. Parts that use the same vertex have the same number.
    List(Vec<u32>),
}

impl Numbers {
    /// The numbers of a part whose vertices are its own: those of earlier ranks come first. All ranks have to call this.
    ///
    /// # Errors
    /// [`ParallelError::Comm`].
    pub fn consecutive(comm: &mut impl Communicator, mesh: &Mesh) -> Result<Self, ParallelError> {
        let own = [mesh.triangles.len() as u64, mesh.positions.len() as u64];
        let ([first_triangle, first_vertex], _) = exclusive_sum(comm, own)?;
        Ok(Self { first_triangle, vertices: VertexNumbers::From(first_vertex) })
    }

    /// Of a vertex of the part.
    pub(super) fn vertex(&self, v: u32) -> u64 {
        match &self.vertices {
            VertexNumbers::From(first) => first + u64::from(v),
            VertexNumbers::List(list) => list[v as usize].into(),
        }
    }

    /// The vertices of the part, `count` of them, whose numbers are lower.
    pub(super) fn before(&self, number: u64, count: usize) -> u32 {
        match &self.vertices {
            VertexNumbers::From(first) => number.saturating_sub(*first).min(count as u64) as u32,
            VertexNumbers::List(list) => list.partition_point(|&own| u64::from(own) < number) as u32,
        }
    }

    /// The vertex of the part that has a number.
    pub(super) fn find(&self, number: u64, count: usize) -> Option<u32> {
        let place = self.before(number, count);
        ((place as usize) < count && self.vertex(place) == number).then_some(place)
    }
}

/// Adds two rings of triangles of the other ranks to a part, and returns which triangles are its own now. Vertices and triangles
/// are in the order of the whole model then. All ranks have to call this, with meshes that have the same arrays and origin.
///
/// # Errors
/// [`ParallelError`], if another rank is gone, or a message is not valid.
///
/// # Panics
/// If a triangle's vertex does not exist, or an array of the mesh is too short.
pub fn join(
    comm: &mut impl Communicator,
    mesh: &mut Mesh,
    numbers: &Numbers,
) -> Result<Range<usize>, ParallelError> {
    let (rank, size) = (comm.rank(), comm.size());
    if size == 1 {
        return Ok(0..mesh.triangles.len());
    }
    let hashes: Vec<u64> = mesh.positions.par_iter().with_min_len(1 << 14).map(|&p| hash(p)).collect();
    let shared = shared_positions(comm, mesh, &hashes)?;
    let near = Near::new(mesh, &hashes, &shared);

    // Two rings around what a rank shares with another one are known here, as far as the triangles are this rank's.
    let mut to_send: Vec<Vec<u32>> = vec![Vec::new(); size];
    let mut requests: Vec<Vec<[u64; 2]>> = vec![Vec::new(); size];
    let mut others: Vec<u32> = shared.iter().map(|&(_, other)| other).collect();
    others.sort_unstable();
    others.dedup();
    for &other in &others {
        let seam: Vec<u64> = shared.iter().filter(|(_, of)| *of == other).map(|&(hash, _)| hash).collect();
        let around = corners(&mesh.triangles, &hashes, &near.triangles_at(&seam));
        to_send[other as usize] = near.triangles_at(&around);
        // Further ranks have triangles there, which the other rank may not know of.
        for hash in around.iter().filter(|hash| seam.binary_search(hash).is_err()) {
            let first = shared.partition_point(|(of, _)| of < hash);
            for &(_, further) in shared[first..].iter().take_while(|(of, _)| of == hash) {
                requests[further as usize].push([*hash, u64::from(other)]);
            }
        }
    }
    let messages = requests.iter().map(|list| cast_slice(list).to_vec()).collect();
    for (from, message) in all_to_all(comm, messages)?.into_iter().enumerate() {
        for [hash, other] in values::<[u64; 2]>(from, &message)? {
            if other >= size as u64 || other == rank as u64 {
                return Err(malformed(from, format!("a request for rank {other}")));
            }
            to_send[other as usize].extend(near.triangles_at(&[hash]));
        }
    }
    let messages = to_send.into_iter().map(|mut triangles| {
        triangles.sort_unstable();
        triangles.dedup();
        let mut message = Vec::new();
        if !triangles.is_empty() {
            ghosts::write(mesh, numbers, &triangles, &mut message);
        }
        message
    });
    let messages = messages.collect();
    let mut found = Ghosts::of(mesh);
    for (from, message) in all_to_all(comm, messages)?.into_iter().enumerate() {
        found.read(from, &message)?;
    }
    found.join(mesh, numbers)
}

/// A hash of a position, where -0 is 0. Equal hashes of different positions cost messages, nothing else.
fn hash(position: [f32; 3]) -> u64 {
    let mix = |z: u64| {
        let z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ z >> 31
    };
    let [x, y, z] = position_bits(position).map(u64::from);
    mix(mix(x | y << 32).wrapping_add(z.wrapping_mul(0x9e37_79b9_7f4a_7c15)))
}

/// The hashes of positions that triangles of this rank and of another one have, in ascending order, each with all other ranks.
fn shared_positions(
    comm: &mut impl Communicator,
    mesh: &Mesh,
    hashes: &[u64],
) -> Result<Vec<(u64, u32)>, ParallelError> {
    let (rank, size) = (comm.rank(), comm.size());
    let mut used = vec![false; mesh.positions.len()];
    mesh.triangles.as_flattened().iter().for_each(|&v| used[v as usize] = true);
    let used = |v: &usize| used[*v];
    let own = bounds(mesh, (0..mesh.positions.len()).filter(used));
    let boxes = comm.all_gather(cast_slice(&own).to_vec())?;
    let mut others = Vec::new();
    for (from, message) in boxes.iter().enumerate().filter(|(from, _)| *from != rank) {
        let values = values::<[f32; 3]>(from, message)?;
        let &[min, max] = &values[..] else { return Err(malformed(from, "a box of another size")) };
        others.push((min, max));
    }
    let meets =
        |p: [f32; 3]| others.iter().any(|(min, max)| (0..3).all(|k| min[k] <= p[k] && p[k] <= max[k]));
    let mut candidates: Vec<u64> = (0..mesh.positions.len())
        .into_par_iter()
        .with_min_len(1 << 14)
        .filter(|v| used(v) && meets(mesh.positions[*v]))
        .map(|v| hashes[v])
        .collect();
    candidates.par_sort_unstable();
    candidates.dedup();

    // Each hash belongs to a rank, which gets it from all that have it.
    let mut messages: Vec<Vec<u64>> = vec![Vec::new(); size];
    candidates.iter().for_each(|&hash| messages[(hash % size as u64) as usize].push(hash));
    drop(candidates);
    let messages = messages.iter().map(|list| cast_slice(list).to_vec()).collect();
    let mut holders: Vec<(u64, u32)> = Vec::new();
    for (from, message) in all_to_all(comm, messages)?.into_iter().enumerate() {
        holders.extend(values::<u64>(from, &message)?.into_iter().map(|hash| (hash, from as u32)));
    }
    holders.par_sort_unstable();
    let mut answers: Vec<Vec<[u64; 2]>> = vec![Vec::new(); size];
    for of_hash in holders.chunk_by(|a, b| a.0 == b.0).filter(|of_hash| of_hash.len() > 1) {
        for &(hash, to) in of_hash {
            let others = of_hash.iter().filter(|(_, other)| *other != to);
            answers[to as usize].extend(others.map(|&(_, other)| [hash, u64::from(other)]));
        }
    }
    drop(holders);
    let messages = answers.iter().map(|list| cast_slice(list).to_vec()).collect();
    let mut shared = Vec::new();
    for (from, message) in all_to_all(comm, messages)?.into_iter().enumerate() {
        for [hash, other] in values::<[u64; 2]>(from, &message)? {
            if other >= size as u64 || other == rank as u64 {
                return Err(malformed(from, format!("a position shared with rank {other}")));
            }
            shared.push((hash, other as u32));
        }
    }
    shared.par_sort_unstable();
    Ok(shared)
}

/// Box of the finite ones of some vertices.
fn bounds(mesh: &Mesh, vertices: impl Iterator<Item = usize>) -> [[f32; 3]; 2] {
    let start = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
    let finite = vertices.map(|v| mesh.positions[v]).filter(|p| p.iter().all(|c| c.is_finite()));
    finite.fold(start, |[min, max], p| {
        [std::array::from_fn(|k| min[k].min(p[k])), std::array::from_fn(|k| max[k].max(p[k]))]
    })
}

/// The hashes of the corners of some triangles, in ascending order.
fn corners(triangles: &[[u32; 3]], hashes: &[u64], of: &[u32]) -> Vec<u64> {
    let corners = of.iter().flat_map(|&t| triangles[t as usize]).map(|v| hashes[v as usize]);
    let mut corners: Vec<u64> = corners.collect();
    corners.sort_unstable();
    corners.dedup();
    corners
}

/// The triangles within two rings of the positions that are shared.
struct Near {
    /// Hash of a corner, and the triangle, in ascending order.
    at: Vec<(u64, u32)>,
}

impl Near {
    fn new(mesh: &Mesh, hashes: &[u64], shared: &[(u64, u32)]) -> Self {
        let mut seam: Vec<u64> = shared.iter().map(|&(hash, _)| hash).collect();
        seam.dedup();
        let touching = |positions: &[u64]| -> Vec<u32> {
            let marked: Vec<bool> =
                hashes.par_iter().map(|hash| positions.binary_search(hash).is_ok()).collect();
            let touches = |t: &u32| mesh.triangles[*t as usize].iter().any(|&v| marked[v as usize]);
            (0..mesh.triangles.len() as u32).into_par_iter().with_min_len(1 << 14).filter(touches).collect()
        };
        let around = corners(&mesh.triangles, hashes, &touching(&seam));
        let near = touching(&around);
        let of = |&t: &u32| mesh.triangles[t as usize].map(|v| (hashes[v as usize], t));
        let mut at: Vec<(u64, u32)> = near.iter().flat_map(of).collect();
        at.par_sort_unstable();
        at.dedup();
        Self { at }
    }

    /// The triangles at some positions, in ascending order.
    fn triangles_at(&self, positions: &[u64]) -> Vec<u32> {
        let mut found = Vec::new();
        for &hash in positions {
            let first = self.at.partition_point(|&(of, _)| of < hash);
            found.extend(self.at[first..].iter().take_while(|(of, _)| *of == hash).map(|&(_, t)| t));
        }
        found.sort_unstable();
        found.dedup();
        found
    }
}

/// The values of a message.
fn values<T: Pod>(from: usize, message: &[u8]) -> Result<Vec<T>, ParallelError> {
    if !message.len().is_multiple_of(size_of::<T>()) {
        let reason = format!("{} bytes, expected values of {}", message.len(), size_of::<T>());
        return Err(malformed(from, reason));
    }
    Ok(pod_collect_to_vec(message))
}
