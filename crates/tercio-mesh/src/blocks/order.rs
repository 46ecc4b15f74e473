//! Which triangles come together: blocks of the file's order, or blocks of space.

use rayon::prelude::*;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use glam::Vec3;

use super::partition::Limits;
use super::{PADDING, hilbert, runs};
use crate::Mesh;

/// Triangles a block has at most. Blocks are clustered independently, one thread each; their size is fixed,
/// so that the result does not depend on the number of threads. A block's working set stays in the L2 cache.
pub(super) const BLOCK: usize = 20_000;

/// Consecutive triangles of a sample that tells whether the mesh's order is good.
const SAMPLE: usize = 2048;
/// Samples taken, evenly over the mesh.
const SAMPLES: usize = 16;

/// An order of the triangles and the lengths of the blocks it is cut into.
pub(super) struct Blocks {
    /// Triangle numbers, then padding; `None` for the order of the mesh.
    pub order: Option<Vec<u32>>,
    /// Triangles of each block, one block after the other.
    pub lengths: Vec<usize>,
}

/// The order of the mesh, cut every [`BLOCK`] triangles.
pub(super) fn file(mesh: &Mesh) -> Blocks {
    Blocks { order: None, lengths: cut_evenly(mesh.triangles.len()).collect() }
}

/// Triangles sorted into the cells of a grid along the Hilbert curve, cut between cells.
///
/// A triangle lies in the cell of its first corner. Inside a cell the file's order stays.
pub(super) fn spatial(mesh: &Mesh) -> Blocks {
    let n = mesh.triangles.len();
    if n <= BLOCK {
        let order = (0..n as u32).chain([0; PADDING]).collect();
        return Blocks { order: Some(order), lengths: cut_evenly(n).collect() };
    }
    let grid = Grid::new(mesh, grid_bits(n));
    let ranks = grid.rank_table();
    let cells: Vec<u16> = mesh.positions.par_iter().map(|&p| ranks[grid.cell(p)]).collect();
    let (order, counts) = counting_sort(mesh, &cells, ranks.len());
    let mut blocks = Blocks { order: Some(order), lengths: Vec::new() };
    blocks.gather_cells(mesh, &counts);
    blocks
}

impl Blocks {
    /// Joins neighbouring cells into blocks, and cuts cells that are too full.
    fn gather_cells(&mut self, mesh: &Mesh, counts: &[usize]) {
        let order = self.order.as_mut().map_or(&mut [][..], |o| &mut o[..]);
        let (mut open, mut begin, mut crowded) = (0, 0, Vec::new());
        for &count in counts {
            if open + count > BLOCK && open > 0 {
                self.lengths.push(open);
                open = 0;
            }
            if count > BLOCK {
                crowded.push(begin..begin + count);
                self.lengths.extend(cut_evenly(count));
            } else {
                open += count;
            }
            begin += count;
        }
        if open > 0 {
            self.lengths.push(open);
        }
        for range in crowded {
            sort_finely(mesh, &mut order[range]);
        }
    }
}

/// True if consecutive triangles of the mesh make full and compact clusters, judged by a few samples.
pub(super) fn is_coherent(mesh: &Mesh, limits: Limits) -> bool {
    let n = mesh.triangles.len();
    let length = SAMPLE.min(n);
    let starts = (0..SAMPLES).map(|i| (n - length) / (SAMPLES - 1) * i);
    let (mut clusters, mut vertices, mut spread, mut area) = (0, 0, 0.0, 0.0);
    let mut corners = [const { [0; SAMPLE] }; 3];
    for triangles in starts.map(|s| &mesh.triangles[s..s + length]) {
        let cut = runs::cut(triangles.iter().copied(), &mut corners.each_mut().map(|c| &mut c[..]), limits);
        clusters += cut.clusters.len();
        vertices += cut.vertices.len();
        let mut next = 0;
        for span in &cut.clusters {
            let piece = &triangles[next..next + usize::from(span.triangles)];
            next += piece.len();
            let (diagonal, surface) = extent(mesh, piece);
            spread += diagonal;
            area += surface;
        }
    }
    // The square of the diagonal is 2.5 times the area of a round flat patch, and 7 times for tiles of 7 x 7
    // squares when a sample begins inside a tile.
    let full = vertices as f32 <= 0.75 * (length * SAMPLES) as f32;
    full && clusters > 0 && spread <= 8.0 * area
}

/// Square of the diagonal of the box round triangles, and their surface.
fn extent(mesh: &Mesh, triangles: &[[u32; 3]]) -> (f32, f32) {
    let (mut min, mut max, mut area) = (Vec3::INFINITY, Vec3::NEG_INFINITY, 0.0);
    for t in triangles {
        let [a, b, c] = t.map(|v| Vec3::from(mesh.positions[v as usize]));
        (min, max) = (min.min(a).min(b).min(c), max.max(a).max(b).max(c));
        area += (b - a).cross(c - a).length() * 0.5;
    }
    (min.distance_squared(max), area)
}

/// Lengths of the fewest blocks that hold `n` triangles, as even as can be.
fn cut_evenly(n: usize) -> impl Iterator<Item = usize> {
    let blocks = n.div_ceil(BLOCK);
    (0..blocks).map(move |i| (i + 1) * n / blocks - i * n / blocks)
}

/// Bits of a grid whose cells hold a tenth of a block where a surface crosses the grid once.
fn grid_bits(triangles: usize) -> u32 {
    let cells = (triangles / (BLOCK / 10)).max(1);
    (cells.ilog2().div_ceil(2)).clamp(2, 5)
}

/// A cube of cells round a mesh.
struct Grid {
    min: [f32; 3],
    /// Cells per unit of length.
    scale: f32,
    bits: u32,
}

impl Grid {
    fn new(mesh: &Mesh, bits: u32) -> Self {
        let bounds = mesh.bounds();
        let min = (bounds.min - mesh.origin).as_vec3().to_array();
        Self::cube(min, bounds.size().max_element() as f32, bits)
    }

    fn cube(min: [f32; 3], edge: f32, bits: u32) -> Self {
        let scale = (1u32 << bits) as f32 / edge;
        Self { min, scale: if scale.is_finite() { scale } else { 0.0 }, bits }
    }

    /// Cell coordinates of a point; points outside go to the nearest cell.
    #[inline]
    fn coordinates(&self, p: [f32; 3]) -> [u32; 3] {
        let last = (1u32 << self.bits) - 1;
        std::array::from_fn(|k| (((p[k] - self.min[k]) * self.scale) as u32).min(last))
    }

    /// Cell number of a point, x fastest.
    #[inline]
    fn cell(&self, p: [f32; 3]) -> usize {
        let [x, y, z] = self.coordinates(p);
        (x | y << self.bits | z << (2 * self.bits)) as usize
    }

    /// Place along the Hilbert curve of each cell; at most 5 bits.
    fn rank_table(&self) -> Vec<u16> {
        let low = (1u32 << self.bits) - 1;
        (0..1u32 << (3 * self.bits))
            .map(|i| hilbert::rank([i & low, i >> self.bits & low, i >> (2 * self.bits)], self.bits) as u16)
            .collect()
    }
}

/// Triangle numbers by the cell of the first corner, and how many triangles each cell has.
fn counting_sort(mesh: &Mesh, cells: &[u16], cell_count: usize) -> (Vec<u32>, Vec<usize>) {
    let n = mesh.triangles.len();
    // At most 64 chunks bound the memory of their histograms.
    let chunk = (n / 64).max(1 << 17);
    let key = |t: &[u32; 3]| usize::from(cells[t[0] as usize]);
    let mut places: Vec<Vec<u32>> = mesh
        .triangles
        .par_chunks(chunk)
        .map(|triangles| {
            let mut histogram = vec![0u32; cell_count];
            triangles.iter().for_each(|t| histogram[key(t)] += 1);
            histogram
        })
        .collect();
    let (mut place, mut counts) = (0u32, vec![0usize; cell_count]);
    for (cell, total) in counts.iter_mut().enumerate() {
        let begin = place;
        for histogram in &mut places {
            place += std::mem::replace(&mut histogram[cell], place);
        }
        *total = (place - begin) as usize;
    }
    // Every place is written once; atomics only tell the compiler that threads may share the array.
    let order: Vec<AtomicU32> = (0..n + PADDING).into_par_iter().map(|_| AtomicU32::new(0)).collect();
    mesh.triangles.par_chunks(chunk).zip(places).enumerate().for_each(|(i, (triangles, mut places))| {
        for (j, t) in triangles.iter().enumerate() {
            let place = &mut places[key(t)];
            order[*place as usize].store((i * chunk + j) as u32, Relaxed);
            *place += 1;
        }
    });
    (order.into_iter().map(AtomicU32::into_inner).collect(), counts)
}

/// Sorts the triangles of a crowded cell along a finer curve of their own.
fn sort_finely(mesh: &Mesh, order: &mut [u32]) {
    let point = |t: u32| mesh.positions[mesh.triangles[t as usize][0] as usize];
    let mut min = [f32::INFINITY; 3];
    let mut max = [f32::NEG_INFINITY; 3];
    for p in order.iter().map(|&t| point(t)) {
        min = std::array::from_fn(|k| min[k].min(p[k]));
        max = std::array::from_fn(|k| max[k].max(p[k]));
    }
    let edge = (0..3).map(|k| max[k] - min[k]).fold(0.0, f32::max);
    let grid = Grid::cube(min, edge, 10);
    order.par_sort_by_cached_key(|&t| hilbert::rank(grid.coordinates(point(t)), 10));
}
