//! The sort between the front end and the back end: clusters and triangles into the tiles that they may touch.
//!
//! A cluster that is small on the screen is sorted as a whole: its 128 triangles cost one entry, and the tile
//! that draws it finds its vertices in the cache. Only of large clusters, and of those that cross the near
//! plane, the triangles are sorted one by one.
//!
//! Each batch of clusters fills bins of its own, so that threads never share one; the back end reads a tile's
//! entries batch after batch.

mod lists;
mod overlap;
mod sorted;
mod tile_set;

pub use lists::TileLists;
pub use overlap::covers_tile;
pub use sorted::{Sorted, SortedError};
pub use tile_set::TileSet;

use bytemuck::{Pod, Zeroable};

use crate::backend::edges::Edges;
use crate::conventions::{first_sample, last_sample};
use crate::settings::Binning;
use crate::view::ScreenVertex;

/// A triangle on the screen, ready for the back end. Its farthest corner comes first: depth is interpolated
/// from there.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct ScreenTriangle {
    /// Screen coordinates of the corners.
    pub x: [i32; 3],
    /// Screen coordinates of the corners.
    pub y: [i32; 3],
    /// Depths of the corners.
    pub d: [f32; 3],
    /// Which triangle it is: cluster number times `MAX_TRIANGLES`, plus its number inside the cluster.
    pub slot: u32,
}

impl ScreenTriangle {
    /// From three projected corners in mesh order; turns the farthest one (the first among equals) to the
    /// front.
    #[inline(always)]
    pub fn new(v: [ScreenVertex; 3], slot: u32) -> Self {
        let mut first = 0;
        if v[1].d < v[first].d {
            first = 1;
        }
        if v[2].d < v[first].d {
            first = 2;
        }
        const NEXT: [usize; 3] = [1, 2, 0];
        let (a, b, c) = (v[first], v[NEXT[first]], v[NEXT[NEXT[first]]]);
        Self { x: [a.x, b.x, c.x], y: [a.y, b.y, c.y], d: [a.d, b.d, c.d], slot }
    }

    /// Twice the signed area, in square sub-pixels; positive if the corners run clockwise on the screen.
    #[inline(always)]
    pub fn area(&self) -> i64 {
        let (x1, x2) = (i64::from(self.x[1] - self.x[0]), i64::from(self.x[2] - self.x[0]));
        let (y1, y2) = (i64::from(self.y[1] - self.y[0]), i64::from(self.y[2] - self.y[0]));
        x1 * y2 - x2 * y1
    }

    /// First and last column and row of pixels whose samples lie in the bounding box, inside the picture;
    /// `None` if there are none.
    #[inline(always)]
    pub fn samples(&self, width: u32, height: u32) -> Option<PixelRect> {
        let ([x0, x1, x2], [y0, y1, y2]) = (self.x, self.y);
        let rect = PixelRect {
            x0: first_sample(x0.min(x1).min(x2)).max(0),
            x1: last_sample(x0.max(x1).max(x2)).min(width as i32 - 1),
            y0: first_sample(y0.min(y1).min(y2)).max(0),
            y1: last_sample(y0.max(y1).max(y2)).min(height as i32 - 1),
        };
        (rect.x0 <= rect.x1 && rect.y0 <= rect.y1).then_some(rect)
    }
}

/// A rectangle of pixels, all borders inclusive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PixelRect {
    /// First column.
    pub x0: i32,
    /// Last column.
    pub x1: i32,
    /// First row.
    pub y0: i32,
    /// Last row.
    pub y1: i32,
}

impl PixelRect {
    /// The pixels of both.
    #[inline(always)]
    pub fn intersect(self, o: Self) -> Self {
        Self { x0: self.x0.max(o.x0), x1: self.x1.min(o.x1), y0: self.y0.max(o.y0), y1: self.y1.min(o.y1) }
    }

    /// It holds no pixel.
    #[inline(always)]
    pub fn is_empty(self) -> bool {
        self.x0 > self.x1 || self.y0 > self.y1
    }
}

/// How the picture is divided into tiles.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TileGrid {
    /// log2 of a tile's edge in pixels.
    pub shift: u32,
    /// Tiles across.
    pub columns: u32,
    /// Tiles down.
    pub rows: u32,
    /// Which of them are drawn.
    pub drawn: TileSet,
}

impl TileGrid {
    /// Divides a picture; `size` is a power of two.
    pub fn new(width: u32, height: u32, size: u32, drawn: TileSet) -> Self {
        let [columns, rows] = [width, height].map(|n| n.div_ceil(size));
        Self { shift: size.trailing_zeros(), columns, rows, drawn }
    }

    /// Is the tile drawn?
    #[inline(always)]
    pub fn draws(&self, tile: u32) -> bool {
        self.drawn.contains(tile)
    }

    /// Is one of the tiles that a rectangle of pixels touches drawn? Columns, then rows, first and last.
    pub fn draws_some_of(&self, rect: [u16; 4]) -> bool {
        let [x0, x1, y0, y1] = rect.map(|pixel| u32::from(pixel) >> self.shift);
        self.drawn.is_all() || (y0..=y1).any(|y| (x0..=x1).any(|x| self.draws(y * self.columns + x)))
    }

    /// Tiles of the picture.
    pub fn count(&self) -> usize {
        self.columns as usize * self.rows as usize
    }

    /// Tiles that a rectangle of pixels touches: first and last column, first and last row.
    pub fn tiles_of(&self, [x0, x1, y0, y1]: [u16; 4]) -> u32 {
        let along =
            |first: u16, last: u16| (u32::from(last) >> self.shift) - (u32::from(first) >> self.shift) + 1;
        along(x0, x1) * along(y0, y1)
    }

    /// The pixels of a tile that lie inside a picture of some pixels across and down.
    pub fn rect(&self, tile: u32, [width, height]: [u32; 2]) -> PixelRect {
        let (x, y) = self.corner(tile);
        let edge = 1u32 << self.shift;
        PixelRect {
            x0: x as i32,
            x1: (x + edge).min(width) as i32 - 1,
            y0: y as i32,
            y1: (y + edge).min(height) as i32 - 1,
        }
    }

    /// First column and row of pixels of a tile.
    pub fn corner(&self, tile: u32) -> (u32, u32) {
        ((tile % self.columns) << self.shift, (tile / self.columns) << self.shift)
    }
}

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
            self.triangle_lists.push_rect(grid, number, rect, |part| covers_tile(&edges, part));
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
