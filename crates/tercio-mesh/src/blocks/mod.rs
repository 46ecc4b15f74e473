//! A mesh split into blocks: neighbouring triangles whose vertices are numbered inside the block.
//!
//! Work on a triangle and its neighbours (making normals, growing clusters) is done block by block, one thread each:
//! a block's working set stays in the L2 cache, and two bytes name a vertex. `order` decides which triangles form a
//! block, `numbering` numbers their vertices, `around` finds the triangles at each vertex.

mod around;
mod coherence;
mod grid;
mod hilbert;
mod numbering;
pub(crate) mod order;

pub(crate) use around::{Around, Corner};
pub use hilbert::interleave;
pub(crate) use numbering::Numbering;
pub use order::Order;

use std::sync::Mutex;

use crate::loops::prelude::*;

use crate::Mesh;
use order::Sequence;

/// A mesh on its way into clusters: its triangles are stored in blocks, everything else is unchanged.
///
/// The result of all work on blocks does not depend on the number of threads.
#[derive(Debug)]
pub struct BlockedMesh {
    /// The mesh; [`Mesh::triangles`] is empty.
    pub(crate) mesh: Mesh,
    pub(crate) blocks: Blocks,
}

/// Triangles in blocks.
#[derive(Debug)]
pub(crate) struct Blocks {
    /// Mesh number of each triangle; `None` where the blocks hold the order of the mesh, in which clusters are then made of
    /// consecutive triangles.
    pub order: Option<Vec<u32>>,
    /// Corners of all triangles, block after block, as vertex numbers inside the block. The corner with the lowest
    /// number in the mesh comes first ([`Mesh::canonical`]).
    pub corners: Vec<[u16; 3]>,
    /// The blocks.
    pub list: Vec<Block>,
}

/// A block's range in [`Blocks`].
#[derive(Debug)]
pub(crate) struct Block {
    /// Its first triangle.
    pub first: usize,
    /// Its number of triangles, at most [`order::BLOCK`].
    pub triangles: usize,
    /// Mesh vertex of each of its vertices, in the order of first use.
    pub vertices: Vec<u32>,
}

impl Block {
    /// Indices of the triangles in [`Blocks::corners`] and [`Blocks::order`].
    pub fn range(&self) -> std::ops::Range<usize> {
        self.first..self.first + self.triangles
    }

    /// Mesh vertices of a triangle's corners.
    pub fn name(&self, corners: [u16; 3]) -> [u32; 3] {
        corners.map(|v| self.vertices[usize::from(v)])
    }
}

impl BlockedMesh {
    /// Splits a mesh into blocks; its triangles are freed.
    ///
    /// # Panics
    /// If a triangle names a vertex that does not exist.
    pub fn new(mut mesh: Mesh, order: Order) -> Self {
        let blocks = Blocks::new(&mesh, order);
        mesh.triangles = Vec::new();
        Self { mesh, blocks }
    }

    /// Number of triangles.
    pub fn triangle_count(&self) -> usize {
        self.blocks.corners.len()
    }

    /// The mesh without its triangles: vertices, their attributes and those of the triangles.
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }
}

impl Blocks {
    pub fn new(mesh: &Mesh, order: Order) -> Self {
        let Sequence { order, lengths } = Sequence::new(mesh, order);
        let mut corners = vec![[0; 3]; mesh.triangles.len()];
        let mut rest = corners.as_mut_slice();
        let mut first = 0;
        let mut jobs = Vec::with_capacity(lengths.len());
        for triangles in lengths {
            let (here, after) = rest.split_at_mut(triangles);
            jobs.push((Block { first, triangles, vertices: Vec::new() }, here));
            (rest, first) = (after, first + triangles);
        }
        let pool = Pool::default();
        let list = jobs
            .into_par_iter()
            .with_max_len(1)
            .map(|(mut block, corners)| {
                let mut numbering: Numbering = pool.take();
                match &order {
                    Some(order) => {
                        let numbers = &order[block.range()];
                        numbering.number(numbers.iter().map(|&t| mesh.triangles[t as usize]), corners);
                    }
                    None => numbering.number(mesh.triangles[block.range()].iter().copied(), corners),
                }
                block.vertices = numbering.vertices.clone();
                pool.give(numbering);
                block
            })
            .collect();
        Self { order, corners, list }
    }

    /// Mesh number of a block's triangle.
    pub fn number(&self, block: &Block, triangle: usize) -> u32 {
        let place = block.first + triangle;
        self.order.as_ref().map_or(place as u32, |order| order[place])
    }

    /// Replaces vertices of triangles: `change` gets the mesh number and the corners of every triangle that has a
    /// vertex for which `concerns` is true.
    pub fn rename(
        &mut self,
        concerns: &(impl Fn(u32) -> bool + Sync),
        change: &(impl Fn(u32, &mut [u32; 3]) + Sync),
    ) {
        let Self { order, corners, list, .. } = self;
        let mut rest = corners.as_mut_slice();
        let mut jobs = Vec::with_capacity(list.len());
        for block in list {
            let (here, after) = rest.split_at_mut(block.triangles);
            jobs.push((block, here));
            rest = after;
        }
        let jobs = jobs.into_par_iter().filter(|(block, _)| block.vertices.iter().any(|&v| concerns(v)));
        jobs.for_each_init(Numbering::default, |numbering, (block, corners)| {
            let mut named: Vec<[u32; 3]> = corners.iter().map(|&c| block.name(c)).collect();
            for (place, corners) in (block.first..).zip(&mut named) {
                if corners.iter().any(|&v| concerns(v)) {
                    change(order.as_ref().map_or(place as u32, |order| order[place]), corners);
                }
            }
            numbering.number(named.into_iter(), corners);
            block.vertices = numbering.vertices.clone();
        });
    }
}

/// Working memory that is reused from block to block; there are as many as threads run at a time.
#[derive(Default)]
pub(crate) struct Pool<T>(Mutex<Vec<T>>);

impl<T: Default> Pool<T> {
    pub fn take(&self) -> T {
        self.0.lock().ok().and_then(|mut free| free.pop()).unwrap_or_default()
    }

    pub fn give(&self, memory: T) {
        if let Ok(mut free) = self.0.lock() {
            free.push(memory);
        }
    }
}
