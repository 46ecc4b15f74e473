//! Binning, between the front end and the back end: sorts clusters and triangles into the tiles that they may overlap.
//!
//! A cluster that is small on the screen is binned as a whole: its up to 128 triangles cost one entry per tile, and the
//! tile that draws it has its vertices in cache. Only large clusters, and those that cross the near plane, are binned
//! triangle by triangle.
//!
//! Each batch of clusters fills bins of its own, so that threads never share them; the back end reads a tile's entries
//! batch after batch.

mod lists;
mod sorted;

use lists::TileLists;
pub use sorted::{Numbering, Sorted, SortedError};

use bytemuck::{Pod, Zeroable};

use crate::sampling::SampleCells;
use crate::screen::{Edges, PixelRect, ScreenTriangle, TileGrid};
use crate::settings::Binning;

/// An entry of a tile's bin: a whole cluster.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct BinnedCluster {
    /// Number of the cluster in the frame.
    pub number: u32,
    /// Upper bound of its depth: no sample of it is nearer.
    pub nearest: f32,
    /// First and last column, first and last row of the pixels that it may reach.
    pub rect: [u16; 4],
}

impl BinnedCluster {
    /// The pixels that it may reach.
    #[inline(always)]
    pub fn pixels(&self) -> PixelRect {
        let [x0, x1, y0, y1] = self.rect.map(i32::from);
        PixelRect { x0, x1, y0, y1 }
    }
}

/// The bins that one batch of clusters is sorted into.
#[derive(Debug, Default)]
pub struct Bins {
    /// Triangles that were binned one by one, in the order in which they were added.
    triangles: Vec<ScreenTriangle>,
    /// By tile, indices into `triangles`.
    triangle_lists: TileLists<u32>,
    /// By tile, clusters that were binned as a whole.
    cluster_lists: TileLists<BinnedCluster>,
    /// Number of clusters that were binned as a whole.
    clusters: u64,
}

impl Bins {
    /// Clears the bins, keeping their memory.
    pub fn clear(&mut self) {
        self.triangles.clear();
        self.triangle_lists.clear();
        self.cluster_lists.clear();
        self.clusters = 0;
    }

    /// Adds a triangle to the drawn tiles that may need it; `rect` are the pixels with samples in its bounding box.
    #[inline(never)]
    pub fn push(
        &mut self,
        grid: &TileGrid,
        cells: &SampleCells,
        binning: Binning,
        triangle: ScreenTriangle,
        rect: PixelRect,
    ) {
        if !grid.draws_some_of([rect.x0, rect.x1, rect.y0, rect.y1].map(|pixel| pixel as u16)) {
            return;
        }
        let number = self.triangles.len() as u32;
        self.triangles.push(triangle);
        let [tx, last_x, ty, last_y] =
            grid.tiles_that_need([rect.x0, rect.x1, rect.y0, rect.y1].map(|pixel| pixel as u32));
        if tx == last_x && ty == last_y {
            self.triangle_lists.push(grid, grid.number(tx, ty), number);
        } else if binning == Binning::BoundingBox {
            self.triangle_lists.push_rect(grid, number, rect, |_| true);
        } else {
            let edges = Edges::of_cells(&triangle, cells);
            self.triangle_lists
                .push_rect(grid, number, rect, |part| !edges.leave_out(part.cells(cells.cell_bits())));
        }
    }

    /// Adds a whole cluster to the drawn tiles that may need it.
    #[inline(always)]
    pub fn push_cluster(&mut self, grid: &TileGrid, cluster: BinnedCluster) {
        self.cluster_lists.push_rect(grid, cluster, cluster.pixels(), |_| true);
        self.clusters += 1;
    }

    /// Sorts all entries by tile.
    pub fn sort(&mut self, grid: &TileGrid) {
        self.triangle_lists.sort(grid);
        self.cluster_lists.sort(grid);
    }

    /// The triangles of a tile that were binned one by one, in the order in which they were added.
    #[inline(always)]
    pub fn triangles_in(&self, tile: u32) -> impl ExactSizeIterator<Item = &ScreenTriangle> {
        self.triangle_lists.tile(tile).iter().map(|&number| &self.triangles[number as usize])
    }

    /// The clusters of a tile, in the order in which they were added.
    #[inline(always)]
    pub fn clusters_in(&self, tile: u32) -> &[BinnedCluster] {
        self.cluster_lists.tile(tile)
    }

    /// Number of entries of a tile, triangles and clusters.
    pub fn fill(&self, tile: u32) -> u64 {
        (self.triangle_lists.tile(tile).len() + self.cluster_lists.tile(tile).len()) as u64
    }

    /// Number of triangles that were binned one by one.
    pub fn triangles(&self) -> u64 {
        self.triangles.len() as u64
    }

    /// Number of entries of triangles in all tiles.
    pub fn triangle_entries(&self) -> u64 {
        self.triangle_lists.count()
    }

    /// Number of clusters that were binned as a whole.
    pub fn clusters(&self) -> u64 {
        self.clusters
    }

    /// Number of entries of clusters in all tiles.
    pub fn cluster_entries(&self) -> u64 {
        self.cluster_lists.count()
    }

    /// Bytes of the bins that are in use: that a frame writes and reads.
    pub fn bytes_used(&self) -> u64 {
        size_of_val(&self.triangles[..]) as u64
            + self.triangle_lists.bytes_used()
            + self.cluster_lists.bytes_used()
    }

    /// Bytes of memory allocated.
    pub fn bytes(&self) -> u64 {
        (self.triangles.capacity() * size_of::<ScreenTriangle>()) as u64
            + self.triangle_lists.bytes()
            + self.cluster_lists.bytes()
    }
}
