//! Replaces the missing or invalid normals of a file, one by one.

use crate::loops::prelude::*;

use super::{OctNormal, Splits, creased, smooth, uncreased};
use crate::Mesh;
use crate::blocks::{BlockedMesh, Blocks, Order};

/// Gives every vertex whose normal is [`OctNormal::NONE`] the normal that [`make_normals`](super::make_normals) would
/// make at its position; all others keep theirs. Returns how many were replaced.
///
/// With a crease angle (radians, 0 to pi), such a vertex at which several smooth surfaces meet is split in the same
/// way as by `make_normals`; other vertices are not split. Without one, no vertex is split.
///
/// # Panics
/// If a triangle's vertex does not exist, or a vertex array is too short.
pub fn mend_normals(mesh: &mut Mesh, crease_angle: Option<f64>) -> u64 {
    let broken = broken(mesh);
    if broken.is_empty() {
        return 0;
    }
    match crease_angle {
        Some(angle) => {
            let blocks = Blocks::new(mesh, Order::Auto);
            creased_ones(mesh, &blocks, &broken, angle).apply(&mut mesh.triangles);
        }
        None => {
            let made = uncreased(mesh);
            if let Some(normals) = &mut mesh.normals {
                broken.iter().for_each(|&v| normals[v as usize] = made[v as usize]);
            }
        }
    }
    broken.len() as u64
}

impl BlockedMesh {
    /// As [`mend_normals`] with a crease angle, for a mesh that is already split into blocks.
    ///
    /// # Panics
    /// If a vertex array is too short.
    pub fn mend_normals(&mut self, crease_angle: f64) -> u64 {
        let broken = broken(&self.mesh);
        if !broken.is_empty() {
            let splits = creased_ones(&mut self.mesh, &self.blocks, &broken, crease_angle);
            self.apply(&splits);
        }
        broken.len() as u64
    }
}

/// The vertices without a normal, in order.
fn broken(mesh: &Mesh) -> Vec<u32> {
    let normals = mesh.normals.as_deref().unwrap_or_default().par_iter().enumerate();
    normals.filter(|(_, n)| **n == OctNormal::NONE).map(|(v, _)| v as u32).collect()
}

/// Makes all normals and uses those of the broken vertices; the triangles still name the old vertices.
fn creased_ones(mesh: &mut Mesh, blocks: &Blocks, broken: &[u32], crease_angle: f64) -> Splits {
    let Some(mut normals) = mesh.normals.take() else { return Splits::default() };
    let (mut made, doubtful) = smooth::settle(mesh, blocks, crease_angle);
    let found = creased::settle(mesh, blocks, &mut made, &doubtful, crease_angle);
    broken.iter().for_each(|&v| normals[v as usize] = made[v as usize]);

    // A vertex with a normal of the file is not split, so the numbers of the new vertices are compacted.
    let first = mesh.positions.len();
    let is_broken = |v: u32| broken.binary_search(&v).is_ok();
    let mut splits = Splits::default();
    let mut numbers = Vec::with_capacity(found.sources.len());
    for (&source, &normal) in found.sources.iter().zip(&made[first..]) {
        numbers.push((first + splits.sources.len()) as u32);
        if is_broken(source) {
            splits.sources.push(source);
            normals.push(normal);
        }
    }
    splits.moves = found.moves.into_iter().filter(|m| is_broken(m.from)).collect();
    splits.moves.iter_mut().for_each(|m| m.to = numbers[m.to as usize - first]);
    splits.append_vertices(mesh);
    mesh.normals = Some(normals);
    splits
}
