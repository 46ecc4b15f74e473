//! From a mesh to clusters.

use std::sync::Mutex;

use rayon::prelude::*;

use super::{
    ClusteredMesh, MAX_TRIANGLES, MAX_VERTICES, PADDING, gather, grow::Grower, order, runs, shuffle,
};
use crate::{Aabb, Mesh, Progress};
use glam::{DVec3, Vec3};

/// In which order triangles are taken into clusters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Order {
    /// The order of the mesh where it makes good clusters, else by space.
    #[default]
    Auto,
    /// The order of the mesh, cut where a cluster is full. The cheapest; as good as the order of the file.
    File,
    /// Sorted by place, and grown over neighbours into compact clusters with narrow cones.
    Spatial,
}

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
    /// Mesh vertices of the clusters, one cluster after the other.
    pub vertices: Vec<u32>,
}

impl Cut {
    /// Room for a block of so many triangles.
    pub fn with_capacity(triangles: usize) -> Self {
        Self {
            clusters: Vec::with_capacity(triangles / 64 + 1),
            vertices: Vec::with_capacity(triangles * 3 / 4 + 3),
        }
    }

    /// Triangles of all clusters.
    pub fn triangles(&self) -> usize {
        self.clusters.iter().map(|s| usize::from(s.triangles)).sum()
    }
}

/// A block before it is cut: its part of the result's arrays.
struct Block<'a> {
    /// Number of the first triangle in the new order.
    first: usize,
    /// Corners, to be written.
    corners: [&'a mut [u8]; 3],
    /// Triangle numbers, to be put into the order of the clusters.
    order: Option<&'a mut [u32]>,
}

/// Cuts a mesh into clusters. The result does not depend on the number of threads.
///
/// The mesh is consumed, and its arrays are freed as soon as they are copied: beside mesh and result about
/// 4 bytes a triangle are taken. Vertices that no triangle uses are dropped.
///
/// # Panics
/// If a triangle names a vertex that is not there, an attribute's length is not the number of its elements,
/// or the clusters need 2^32 vertices or more.
pub fn partition(mut mesh: Mesh, options: &PartitionOptions) -> ClusteredMesh {
    let n = mesh.triangles.len();
    let limits = Limits {
        vertices: options.max_vertices.clamp(3, MAX_VERTICES) as u32,
        triangles: options.max_triangles.clamp(1, MAX_TRIANGLES) as u32,
    };
    if let Some(progress) = options.progress {
        progress.begin("clusters", n as u64);
    }
    let blocks = match options.order {
        Order::File => order::file(&mesh),
        Order::Auto if order::is_coherent(&mesh, limits) => order::file(&mesh),
        Order::Auto | Order::Spatial => order::spatial(&mesh),
    };
    let mut out = ClusteredMesh { origin: mesh.origin, ..ClusteredMesh::default() };
    out.corners = std::array::from_fn(|_| vec![0; n + PADDING]);
    out.primitives = blocks.order;
    let pool = Mutex::new(Vec::new());
    let cuts: Vec<Cut> = jobs(&mut out, &blocks.lengths)
        .into_par_iter()
        .map(|mut block| {
            let cut = cut(&mesh, &mut block, limits, &pool);
            if let Some(progress) = options.progress {
                progress.advance(block.corners[0].len() as u64);
            }
            cut
        })
        .collect();
    mesh.triangles = Vec::new();
    gather::positions(&mut out, &cuts, &std::mem::take(&mut mesh.positions));
    gather::attributes(&mut out, &cuts, mesh);
    out.bounds = bounds(&out);
    if let Some(seed) = options.shuffle_seed {
        shuffle::shuffle(&mut out, seed);
    }
    out
}

/// The result's arrays cut into blocks.
fn jobs<'a>(out: &'a mut ClusteredMesh, lengths: &[usize]) -> Vec<Block<'a>> {
    let [a, b, c] = out.corners.each_mut().map(|v| gather::split(v, lengths.iter().copied()));
    let order: Vec<Option<&mut [u32]>> = match &mut out.primitives {
        Some(order) => gather::split(order, lengths.iter().copied()).into_iter().map(Some).collect(),
        None => lengths.iter().map(|_| None).collect(),
    };
    let firsts = lengths.iter().scan(0, |next, &n| Some(std::mem::replace(next, *next + n)));
    let corners = a.into_iter().zip(b).zip(c).map(|((a, b), c)| [a, b, c]);
    firsts.zip(corners).zip(order).map(|((first, corners), order)| Block { first, corners, order }).collect()
}

/// Cuts one block: a given order into runs, else by growing.
fn cut(mesh: &Mesh, block: &mut Block, limits: Limits, pool: &Mutex<Vec<Grower>>) -> Cut {
    let Some(order) = &mut block.order else {
        let range = block.first..block.first + block.corners[0].len();
        return runs::cut(mesh.triangles[range].iter().copied(), &mut block.corners, limits);
    };
    // Working memory goes from block to block; as many exist as threads run at a time.
    let mut grower = pool.lock().ok().and_then(|mut p| p.pop()).unwrap_or_default();
    grower.mesh.fill(mesh, order.iter().map(|&t| mesh.triangles[t as usize]));
    let cut = grower.cut(&mut block.corners, limits);
    let old = order.to_vec();
    order.iter_mut().zip(&grower.taken).for_each(|(o, &t)| *o = old[usize::from(t)]);
    if let Ok(mut pool) = pool.lock() {
        pool.push(grower);
    }
    cut
}

/// World-space bounds of all clusters.
fn bounds(mesh: &ClusteredMesh) -> Aabb {
    let world = |p: [f32; 3]| -> DVec3 { mesh.origin + Vec3::from(p).as_dvec3() };
    mesh.clusters.iter().fold(Aabb::EMPTY, |all, c| all.union(Aabb { min: world(c.min), max: world(c.max) }))
}
