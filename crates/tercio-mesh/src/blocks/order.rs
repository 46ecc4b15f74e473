//! Which triangles form a block: runs in the order of the file, or regions of space.

use crate::loops::prelude::*;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use super::coherence;
use super::grid::{FINEST, Grid, rank_table};
use crate::Mesh;

/// The order in which triangles are put into blocks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Order {
    /// The order of the mesh where it makes good clusters, else by space.
    #[default]
    Auto,
    /// The order of the mesh, cut where a cluster is full. The cheapest; as good as the order in the file.
    File,
    /// Sorted by position, and grown over neighbours into compact clusters with narrow normal cones.
    Spatial,
}

/// Most triangles in a block. Blocks are processed independently, one thread each; their size is fixed, so that the
/// result does not depend on the number of threads. A block's working set stays in the L2 cache, and its vertices can
/// be numbered in 16 bits.
pub(crate) const BLOCK: usize = 20_000;

/// An order of the triangles and the lengths of the blocks that it is split into.
pub(super) struct Sequence {
    /// Triangle numbers; `None` for the order of the mesh, in which clusters are then made of consecutive triangles.
    pub order: Option<Vec<u32>>,
    /// Triangles of each block, one block after the other.
    pub lengths: Vec<usize>,
}

impl Sequence {
    pub fn new(mesh: &Mesh, order: Order) -> Self {
        match order {
            Order::File => file(mesh),
            Order::Auto if coherence::is_coherent(mesh) => file(mesh),
            Order::Auto | Order::Spatial => spatial(mesh),
        }
    }
}

/// The order of the mesh, split every [`BLOCK`] triangles.
fn file(mesh: &Mesh) -> Sequence {
    Sequence { order: None, lengths: cut_evenly(mesh.triangles.len()).collect() }
}

/// Triangles sorted into the cells of a grid along the Hilbert curve, split between cells.
///
/// A triangle belongs to the cell of its first corner. Inside a cell the order of the file is kept.
fn spatial(mesh: &Mesh) -> Sequence {
    let n = mesh.triangles.len();
    if n <= BLOCK {
        let order = (0..n as u32).collect();
        return Sequence { order: Some(order), lengths: cut_evenly(n).collect() };
    }
    let grid = Grid::new(mesh, grid_bits(n));
    let ranks = rank_table(grid.bits());
    let cells: Vec<u16> = mesh.positions.par_iter().map(|&p| ranks[grid.cell(p)]).collect();
    let (order, counts) = counting_sort(mesh, cells, ranks.len());
    let mut blocks = Sequence { order: Some(order), lengths: Vec::new() };
    blocks.gather_cells(mesh, &counts);
    blocks
}

impl Sequence {
    /// Joins neighbouring cells into blocks, and splits cells with too many triangles.
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
        if !crowded.is_empty() {
            let ranks = rank_table(FINEST);
            crowded.into_iter().for_each(|range| sort_finely(mesh, &mut order[range], &ranks));
        }
    }
}

/// Lengths of the fewest blocks that hold `n` triangles, as even as possible.
fn cut_evenly(n: usize) -> impl Iterator<Item = usize> {
    let blocks = n.div_ceil(BLOCK);
    (0..blocks).map(move |i| (i + 1) * n / blocks - i * n / blocks)
}

/// Bits per axis of a grid whose cells hold a tenth of a block where a surface crosses the grid once.
fn grid_bits(triangles: usize) -> u32 {
    let cells = (triangles / (BLOCK / 10)).max(1);
    (cells.ilog2().div_ceil(2)).clamp(2, FINEST)
}

/// Triangle numbers by the cell of the first corner, and how many triangles each cell has. `cells` are those of the
/// vertices.
fn counting_sort(mesh: &Mesh, cells: Vec<u16>, cell_count: usize) -> (Vec<u32>, Vec<usize>) {
    let n = mesh.triangles.len();
    // At most 64 chunks bound the memory of their histograms.
    let chunk = (n / 64).max(1 << 17);
    // Kept, because looking them up goes through all triangles and to places of `cells` that no one can foresee.
    let mut keys = vec![0u16; n];
    let mut places: Vec<Vec<u32>> = mesh
        .triangles
        .par_chunks(chunk)
        .zip(keys.par_chunks_mut(chunk))
        .map(|(triangles, keys)| {
            let mut histogram = vec![0u32; cell_count];
            for (t, key) in triangles.iter().zip(keys) {
                *key = cells[t[0] as usize];
                histogram[usize::from(*key)] += 1;
            }
            histogram
        })
        .collect();
    drop(cells);
    // Array by array instead of cell by cell, which are far apart.
    let mut starts = vec![0u32; cell_count];
    for histogram in &places {
        starts.iter_mut().zip(histogram).for_each(|(sum, count)| *sum += count);
    }
    let counts = starts.iter().map(|&count| count as usize).collect();
    let mut place = 0;
    for start in &mut starts {
        place += std::mem::replace(start, place);
    }
    for histogram in &mut places {
        for (start, entry) in starts.iter_mut().zip(histogram) {
            *start += std::mem::replace(entry, *start);
        }
    }
    // Every entry is written once; atomics only let the threads share the array.
    let order: Vec<AtomicU32> = bytemuck::zeroed_vec(n);
    keys.par_chunks(chunk).zip(places).enumerate().for_each(|(i, (keys, mut places))| {
        for (number, key) in ((i * chunk) as u32..).zip(keys) {
            let place = &mut places[usize::from(*key)];
            order[*place as usize].store(number, Relaxed);
            *place += 1;
        }
    });
    (order.into_iter().map(AtomicU32::into_inner).collect(), counts)
}

/// Sorts the triangles of a crowded cell along a finer curve of their own.
fn sort_finely(mesh: &Mesh, order: &mut [u32], ranks: &[u16]) {
    let point = |t: u32| mesh.positions[mesh.triangles[t as usize][0] as usize];
    let mut min = [f32::INFINITY; 3];
    let mut max = [f32::NEG_INFINITY; 3];
    for p in order.iter().map(|&t| point(t)) {
        min = std::array::from_fn(|k| min[k].min(p[k]));
        max = std::array::from_fn(|k| max[k].max(p[k]));
    }
    let edge = (0..3).map(|k| max[k] - min[k]).fold(0.0, f32::max);
    let grid = Grid::cube(min, edge, FINEST);
    rayon::slice::ParallelSliceMut::par_sort_by_cached_key(order, |&t| ranks[grid.cell(point(t))]);
}
