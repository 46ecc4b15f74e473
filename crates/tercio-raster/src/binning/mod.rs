//! The sort between the front end and the back end: clusters and triangles into the tiles that they may touch.
//!
//! A cluster that is small on the screen is sorted as a whole: its 128 triangles cost one entry, and the tile
//! that draws it finds its vertices in the cache. Only of large clusters, and of those that cross the near
//! plane, the triangles are sorted one by one.
//!
//! Each batch of clusters fills bins of its own, so that threads never share one; the back end reads a tile's
//! entries batch after batch.

mod lists;
mod sorted;

use lists::TileLists;
pub use sorted::{Sorted, SortedError};

use bytemuck::{Pod, Zeroable};

use crate::screen::{Edges, PixelRect, ScreenTriangle, TileGrid};
use crate::settings::Binning;

/// A cluster in a tile's bin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct BinnedCluster {
    /// Its number in the frame.
    pub number: u32,
    /// No sample of it is nearer: an upper bound of its depth.
    pub nearest: f32,
    /// First and last column, first and last row of the pixels that it may reach.
    pub rect: [u16; 4],
}

/// What one batch of clusters sorted into the tiles.
#[derive(Debug, Default)]
pub struct Bins {
    /// Triangles that were sorted one by one, in the order they came.
    triangles: Vec<ScreenTriangle>,
    /// Numbers of triangles.
    triangle_lists: TileLists<u32>,
    cluster_lists: TileLists<BinnedCluster>,
    /// Clusters that were sorted as a whole.
    clusters: u64,
}

impl Bins {
    /// Empties the bins, keeping their memory.
    pub fn clear(&mut self) {
        self.triangles.clear();
        self.triangle_lists.clear();
        self.cluster_lists.clear();
        self.clusters = 0;
    }

    /// Adds a triangle to the tiles that are drawn and that it may touch; `rect` are its samples.
    #[inline(never)]
    pub fn push(&mut self, grid: &TileGrid, binning: Binning, triangle: ScreenTriangle, rect: PixelRect) {
        if !grid.draws_some_of([rect.x0, rect.x1, rect.y0, rect.y1].map(|pixel| pixel as u16)) {
            return;
        }
        let number = self.triangles.len() as u32;
        self.triangles.push(triangle);
        let s = grid.shift;
        let (tx, ty) = (rect.x0 as u32 >> s, rect.y0 as u32 >> s);
        if tx == rect.x1 as u32 >> s && ty == rect.y1 as u32 >> s {
            self.triangle_lists.push(grid, ty * grid.columns + tx, number);
        } else if binning == Binning::BoundingBox {
            self.triangle_lists.push_rect(grid, number, rect, |_| true);
        } else {
            let edges = Edges::new(&triangle);
            self.triangle_lists.push_rect(grid, number, rect, |part| !edges.leave_out(part));
        }
    }

    /// Adds a whole cluster to the tiles that it may touch.
    #[inline(always)]
    pub fn push_cluster(&mut self, grid: &TileGrid, cluster: BinnedCluster) {
        let [x0, x1, y0, y1] = cluster.rect.map(i32::from);
        self.cluster_lists.push_rect(grid, cluster, PixelRect { x0, x1, y0, y1 }, |_| true);
        self.clusters += 1;
    }

    /// Sorts all that was added by tile.
    pub fn sort(&mut self, grid: &TileGrid) {
        self.triangle_lists.sort(grid);
        self.cluster_lists.sort(grid);
    }

    /// The triangles of a tile that were sorted one by one, in the order they came.
    #[inline(always)]
    pub fn triangles_in(&self, tile: u32) -> impl ExactSizeIterator<Item = &ScreenTriangle> {
        self.triangle_lists.tile(tile).iter().map(|&number| &self.triangles[number as usize])
    }

    /// The clusters of a tile, in the order they came.
    #[inline(always)]
    pub fn clusters_in(&self, tile: u32) -> &[BinnedCluster] {
        self.cluster_lists.tile(tile)
    }

    /// Entries of a tile, triangles and clusters.
    pub fn fill(&self, tile: u32) -> u64 {
        (self.triangle_lists.tile(tile).len() + self.cluster_lists.tile(tile).len()) as u64
    }

    /// Triangles that were sorted one by one.
    pub fn triangles(&self) -> u64 {
        self.triangles.len() as u64
    }

    /// Entries of triangles in all tiles.
    pub fn triangle_entries(&self) -> u64 {
        self.triangle_lists.count()
    }

    /// Clusters that were sorted as a whole.
    pub fn clusters(&self) -> u64 {
        self.clusters
    }

    /// Entries of clusters in all tiles.
    pub fn cluster_entries(&self) -> u64 {
        self.cluster_lists.count()
    }

    /// Bytes of the bins that a frame writes and reads.
    pub fn bytes_used(&self) -> u64 {
        size_of_val(&self.triangles[..]) as u64
            + self.triangle_lists.bytes_used()
            + self.cluster_lists.bytes_used()
    }

    /// Bytes of memory held.
    pub fn bytes(&self) -> u64 {
        (self.triangles.capacity() * size_of::<ScreenTriangle>()) as u64
            + self.triangle_lists.bytes()
            + self.cluster_lists.bytes()
    }
}
