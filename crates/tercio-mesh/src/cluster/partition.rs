//! From a mesh to clusters.

use crate::loops::prelude::*;

use super::grow::{Ground, Grower};
use super::{Cluster, ClusteredMesh, MAX_TRIANGLES, MAX_VERTICES, gather, runs, shuffle};
use crate::blocks::{Block, BlockedMesh, Order, Pool};
use crate::{Mesh, Progress};

/// How to split a mesh into clusters.
#[derive(Clone, Copy, Debug)]
pub struct PartitionOptions<'a> {
    /// Most vertices in a cluster, 3 to [`MAX_VERTICES`]; other values are clamped.
    pub max_vertices: usize,
    /// Most triangles in a cluster, 1 to [`MAX_TRIANGLES`]; other values are clamped.
    pub max_triangles: usize,
    /// The order in which triangles are taken.
    pub order: Order,
    /// For tests: shuffles the clusters, and the triangles inside each.
    pub shuffle_seed: Option<u64>,
    /// Receives the number of finished triangles.
    pub progress: Option<&'a Progress>,
}

impl Default for PartitionOptions<'_> {
    fn default() -> Self {
        Self {
            max_vertices: MAX_VERTICES,
            max_triangles: MAX_TRIANGLES,
            order: Order::Auto,
            shuffle_seed: None,
            progress: None,
        }
    }
}

/// Most vertices and triangles of a cluster.
#[derive(Clone, Copy)]
pub(super) struct Limits {
    pub vertices: u32,
    pub triangles: u32,
}

/// A block that has been split into clusters.
#[derive(Default)]
pub(super) struct Cut {
    /// Sizes of the clusters, in order, and which triangles they hold; no bounds yet.
    pub clusters: Vec<Cluster>,
    /// Vertices of the clusters, one cluster after the other, as the block numbers them.
    pub vertices: Vec<u16>,
    /// First, second and third corners of the triangles, cluster after cluster, as vertex numbers in the cluster.
    pub corners: [Vec<u8>; 3],
    /// Mesh vertex of each vertex of the block.
    pub names: Vec<u32>,
}

impl Cut {
    /// An empty result, with memory reserved for a block of this many triangles.
    pub fn new(triangles: usize) -> Self {
        Self {
            clusters: Vec::with_capacity(triangles / 64 + 1),
            vertices: Vec::with_capacity(triangles * 3 / 4 + 3),
            corners: std::array::from_fn(|_| vec![0; triangles]),
            names: Vec::new(),
        }
    }

    /// Triangles of all clusters.
    pub fn triangles(&self) -> usize {
        self.corners[0].len()
    }
}

/// A block before it is split.
struct Job<'a> {
    block: Block,
    /// Mesh numbers of the triangles, to be sorted by cluster.
    order: Option<&'a mut [u32]>,
}

/// Splits a mesh into clusters. The result does not depend on the number of threads.
///
/// The mesh is consumed, and its arrays are freed as soon as they are copied. Vertices that no triangle uses are
/// dropped.
///
/// # Panics
/// If a triangle names a vertex that does not exist, an attribute's length is not the number of its elements, or the
/// clusters need 2^32 cache lines (256 GiB) or more.
pub fn partition(mesh: Mesh, options: &PartitionOptions) -> ClusteredMesh {
    partition_blocks(BlockedMesh::new(mesh, options.order), options)
}

/// As [`partition`], for a mesh that is already split into blocks; their order takes precedence over
/// [`PartitionOptions::order`].
///
/// # Panics
/// As [`partition`].
pub fn partition_blocks(mesh: BlockedMesh, options: &PartitionOptions) -> ClusteredMesh {
    let BlockedMesh { mesh, blocks } = mesh;
    let limits = Limits {
        vertices: options.max_vertices.clamp(3, MAX_VERTICES) as u32,
        triangles: options.max_triangles.clamp(1, MAX_TRIANGLES) as u32,
    };
    let n = blocks.corners.len();
    if let Some(progress) = options.progress {
        progress.begin("clusters", n as u64);
    }
    let mut order = blocks.order;
    let pool = Pool::default();
    let cuts: Vec<Cut> = jobs(order.as_deref_mut(), blocks.list)
        .into_par_iter()
        // One block per task, so that threads finish together.
        .with_max_len(1)
        .map(|job| {
            let triangles = &blocks.corners[job.block.range()];
            let cut = cut(&mesh, triangles, job, limits, &pool);
            if let Some(progress) = options.progress {
                progress.advance(triangles.len() as u64);
            }
            cut
        })
        .collect();
    drop(blocks.corners);
    finish(mesh, &cuts, order.as_deref(), options)
}

/// Writes the clusters; `order` holds the mesh numbers of all triangles, cluster after cluster.
pub(super) fn finish(
    mut mesh: Mesh,
    cuts: &[Cut],
    order: Option<&[u32]>,
    options: &PartitionOptions,
) -> ClusteredMesh {
    let mut out = ClusteredMesh { origin: mesh.origin, exponent: mesh.exponent, ..ClusteredMesh::default() };
    gather::clusters(&mut out, cuts, order, &mesh);
    out.materials = std::mem::take(&mut mesh.materials);
    out.face_of_triangle = mesh.face_of_triangle.take().map(Into::into);
    out.sum_up();
    match options.shuffle_seed {
        Some(seed) => shuffle::shuffle(&out, seed),
        None => out,
    }
}

/// Pairs the blocks with their parts of the order.
fn jobs(order: Option<&mut [u32]>, blocks: Vec<Block>) -> Vec<Job<'_>> {
    let parts: Vec<Option<&mut [u32]>> = match order {
        Some(order) => {
            gather::split(order, blocks.iter().map(|b| b.triangles)).into_iter().map(Some).collect()
        }
        None => blocks.iter().map(|_| None).collect(),
    };
    blocks.into_iter().zip(parts).map(|(block, order)| Job { block, order }).collect()
}

/// Splits one block into clusters: into runs if the order is that of the mesh, else by growing.
fn cut(mesh: &Mesh, triangles: &[[u16; 3]], job: Job, limits: Limits, pool: &Pool<Grower>) -> Cut {
    let Job { block, order } = job;
    let vertices = block.vertices.len();
    let mut cut = match order {
        None => runs::cut(triangles, |place| (block.first + place) as u32, vertices, limits),
        Some(order) => {
            let mut grower = pool.take();
            let ground = Ground { triangles, vertices: &block.vertices, positions: &mesh.positions };
            let cut = grower.cut(&ground, order, limits);
            pool.give(grower);
            cut
        }
    };
    cut.names = block.vertices;
    cut
}
