//! From a mesh to clusters.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::grow::{Ground, Grower};
use super::{ClusteredMesh, MAX_TRIANGLES, MAX_VERTICES, PADDING, gather, runs, shuffle};
use crate::blocks::{Block, BlockedMesh, Order, Pool};
use crate::{Aabb, Mesh, Progress};

/// How to cut a mesh into clusters.
#[derive(Clone, Copy, Debug)]
pub struct PartitionOptions<'a> {
    /// Most vertices a cluster, 3 to [`MAX_VERTICES`]; other values are clamped.
    pub max_vertices: usize,
    /// Most triangles a cluster, 1 to [`MAX_TRIANGLES`]; other values are clamped.
    pub max_triangles: usize,
    /// The order in which triangles are taken.
    pub order: Order,
    /// For tests: shuffles the clusters, and the triangles inside each.
    pub shuffle_seed: Option<u64>,
    /// Told how many triangles are done.
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

/// What a cluster may hold.
#[derive(Clone, Copy)]
pub(super) struct Limits {
    pub vertices: u32,
    pub triangles: u32,
}

/// Sizes of a cluster.
#[derive(Clone, Copy)]
pub(super) struct Span {
    pub vertices: u8,
    pub triangles: u8,
}

/// A block cut into clusters.
#[derive(Default)]
pub(super) struct Cut {
    /// The clusters, in order.
    pub clusters: Vec<Span>,
    /// Vertices of the clusters, one cluster after the other, as the block numbers them.
    pub vertices: Vec<u16>,
    /// Mesh vertex of each vertex of the block.
    pub names: Vec<u32>,
}

impl Cut {
    /// Room for a block of so many triangles.
    pub fn with_capacity(triangles: usize) -> Self {
        Self {
            clusters: Vec::with_capacity(triangles / 64 + 1),
            vertices: Vec::with_capacity(triangles * 3 / 4 + 3),
            names: Vec::new(),
        }
    }

    /// Triangles of all clusters.
    pub fn triangles(&self) -> usize {
        self.clusters.iter().map(|s| usize::from(s.triangles)).sum()
    }
}

/// A block before it is cut, and its part of the result's arrays.
struct Job<'a> {
    block: Block,
    /// Corners, to be written.
    corners: [&'a mut [u8]; 3],
    /// Triangle numbers, to be put into the order of the clusters.
    order: Option<&'a mut [u32]>,
}

/// Cuts a mesh into clusters. The result does not depend on the number of threads.
///
/// The mesh is consumed, and its arrays are freed as soon as they are copied. Vertices that no triangle uses
/// are dropped.
///
/// # Panics
/// If a triangle names a vertex that is not there, an attribute's length is not the number of its elements,
/// or the clusters need 2^32 vertices or more.
pub fn partition(mesh: Mesh, options: &PartitionOptions) -> ClusteredMesh {
    partition_blocks(BlockedMesh::new(mesh, options.order), options)
}

/// As [`partition`], for a mesh that stands in blocks already; their order wins over
/// [`PartitionOptions::order`].
///
/// # Panics
/// As [`partition`].
pub fn partition_blocks(mesh: BlockedMesh, options: &PartitionOptions) -> ClusteredMesh {
    let BlockedMesh { mut mesh, blocks } = mesh;
    let limits = Limits {
        vertices: options.max_vertices.clamp(3, MAX_VERTICES) as u32,
        triangles: options.max_triangles.clamp(1, MAX_TRIANGLES) as u32,
    };
    let n = blocks.corners.len();
    if let Some(progress) = options.progress {
        progress.begin("clusters", n as u64);
    }
    let mut out = ClusteredMesh { origin: mesh.origin, exponent: mesh.exponent, ..ClusteredMesh::default() };
    out.corners = std::array::from_fn(|_| vec![0; n + PADDING]);
    out.primitives = blocks.order;
    let pool = Pool::default();
    let cuts: Vec<Cut> = jobs(&mut out, blocks.list)
        .into_par_iter()
        // So that threads finish together.
        .with_max_len(1)
        .map(|mut job| {
            let triangles = &blocks.corners[job.block.range()];
            let mut cut = cut(&mesh, triangles, &mut job, limits, &pool);
            cut.names = job.block.vertices;
            if let Some(progress) = options.progress {
                progress.advance(triangles.len() as u64);
            }
            cut
        })
        .collect();
    drop(blocks.corners);
    out.normals = mesh.normals.take().map(|n| gather::normals(&cuts, &n));
    gather::positions(&mut out, &cuts, &std::mem::take(&mut mesh.positions));
    gather::attributes(&mut out, &cuts, mesh);
    out.bounds = bounds(&out);
    if let Some(seed) = options.shuffle_seed {
        shuffle::shuffle(&mut out, seed);
    }
    out
}

/// The result's arrays cut into blocks.
fn jobs(out: &mut ClusteredMesh, blocks: Vec<Block>) -> Vec<Job<'_>> {
    let lengths = || blocks.iter().map(|b| b.triangles);
    let [a, b, c] = out.corners.each_mut().map(|v| gather::split(v, lengths()));
    let order: Vec<Option<&mut [u32]>> = match &mut out.primitives {
        Some(order) => gather::split(order, lengths()).into_iter().map(Some).collect(),
        None => blocks.iter().map(|_| None).collect(),
    };
    let corners = a.into_iter().zip(b).zip(c).map(|((a, b), c)| [a, b, c]);
    blocks
        .into_iter()
        .zip(corners)
        .zip(order)
        .map(|((block, corners), order)| Job { block, corners, order })
        .collect()
}

/// Cuts one block: a given order into runs, else by growing.
fn cut(mesh: &Mesh, triangles: &[[u16; 3]], job: &mut Job, limits: Limits, pool: &Pool<Grower>) -> Cut {
    let Some(order) = &mut job.order else {
        return runs::cut(triangles, job.block.vertices.len(), &mut job.corners, limits);
    };
    let mut grower = pool.take();
    let ground = Ground { triangles, vertices: &job.block.vertices, positions: &mesh.positions };
    let cut = grower.cut(&ground, &mut job.corners, limits);
    let old = order.to_vec();
    order.iter_mut().zip(grower.taken()).for_each(|(o, &t)| *o = old[usize::from(t)]);
    pool.give(grower);
    cut
}

/// World-space bounds of all clusters.
fn bounds(mesh: &ClusteredMesh) -> Aabb {
    let unit = mesh.unit();
    let world = |p: [f32; 3]| -> DVec3 { mesh.origin + Vec3::from(p).as_dvec3() * unit };
    mesh.clusters.iter().fold(Aabb::EMPTY, |all, c| all.union(Aabb { min: world(c.min), max: world(c.max) }))
}
