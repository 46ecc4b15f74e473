//! The sort between the front end and the back end: triangles into the tiles that they may touch.
//!
//! Each batch of clusters fills bins of its own, so that threads never share one; the back end reads a tile's
//! entries batch after batch. A batch is sorted by counting: entries are numbered by tile, then moved.

mod overlap;

pub use overlap::covers_tile;

use crate::conventions::{first_sample, last_sample};
use crate::settings::Binning;
use crate::view::ScreenVertex;

/// A triangle on the screen, ready for the back end. Its farthest corner comes first: depth is interpolated
/// from there.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
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
        let turned = [v[first], v[(first + 1) % 3], v[(first + 2) % 3]];
        Self { x: turned.map(|v| v.x), y: turned.map(|v| v.y), d: turned.map(|v| v.d), slot }
    }

    /// Twice the signed area, in square sub-pixels; positive if the corners run clockwise on the screen.
    #[inline(always)]
    pub fn area(&self) -> i64 {
        let d = |a: &[i32; 3], k: usize| i64::from(a[k] - a[0]);
        d(&self.x, 1) * d(&self.y, 2) - d(&self.x, 2) * d(&self.y, 1)
    }

    /// First and last column and row of pixels whose samples lie in the bounding box, inside the picture;
    /// `None` if there are none.
    #[inline(always)]
    pub fn samples(&self, width: u32, height: u32) -> Option<PixelRect> {
        let least = |a: &[i32; 3]| a[0].min(a[1]).min(a[2]);
        let most = |a: &[i32; 3]| a[0].max(a[1]).max(a[2]);
        let rect = PixelRect {
            x0: first_sample(least(&self.x)).max(0),
            x1: last_sample(most(&self.x)).min(width as i32 - 1),
            y0: first_sample(least(&self.y)).max(0),
            y1: last_sample(most(&self.y)).min(height as i32 - 1),
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

/// How the picture is divided into tiles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TileGrid {
    /// log2 of a tile's edge in pixels.
    pub shift: u32,
    /// Tiles across.
    pub columns: u32,
    /// Tiles down.
    pub rows: u32,
}

impl TileGrid {
    /// Divides a picture; `size` is a power of two.
    pub fn new(width: u32, height: u32, size: u32) -> Self {
        Self { shift: size.trailing_zeros(), columns: width.div_ceil(size), rows: height.div_ceil(size) }
    }

    /// Tiles of the picture.
    pub fn count(&self) -> usize {
        self.columns as usize * self.rows as usize
    }

    /// First column and row of pixels of a tile.
    pub fn corner(&self, tile: u32) -> (u32, u32) {
        ((tile % self.columns) << self.shift, (tile / self.columns) << self.shift)
    }
}

/// What one batch of clusters sorted into the tiles.
#[derive(Debug, Default)]
pub struct Bins {
    /// The triangles, in the order they came.
    pub triangles: Vec<ScreenTriangle>,
    /// Tile and triangle number of each entry, not sorted yet.
    pairs: Vec<(u32, u32)>,
    /// Where each tile's entries begin in `entries`; one more than there are tiles.
    starts: Vec<u32>,
    /// Triangle numbers, tile after tile.
    entries: Vec<u32>,
}

impl Bins {
    /// Empties the bins, keeping their memory.
    pub fn clear(&mut self) {
        self.triangles.clear();
        self.pairs.clear();
        self.entries.clear();
        self.starts.clear();
    }

    /// Adds a triangle to the tiles that it may touch; `rect` are its samples.
    #[inline(always)]
    pub fn push(&mut self, grid: &TileGrid, binning: Binning, triangle: ScreenTriangle, rect: PixelRect) {
        let number = self.triangles.len() as u32;
        self.triangles.push(triangle);
        let s = grid.shift;
        let (tx0, tx1) = (rect.x0 as u32 >> s, rect.x1 as u32 >> s);
        let (ty0, ty1) = (rect.y0 as u32 >> s, rect.y1 as u32 >> s);
        if tx0 == tx1 && ty0 == ty1 {
            self.pairs.push((ty0 * grid.columns + tx0, number));
        } else {
            self.push_many(grid, binning, number, rect, (tx0, tx1), (ty0, ty1));
        }
    }

    #[inline(never)]
    fn push_many(
        &mut self,
        grid: &TileGrid,
        binning: Binning,
        number: u32,
        rect: PixelRect,
        columns: (u32, u32),
        rows: (u32, u32),
    ) {
        let triangle = self.triangles[number as usize];
        let edge = 1i32 << grid.shift;
        for ty in rows.0..=rows.1 {
            for tx in columns.0..=columns.1 {
                let (x, y) = ((tx << grid.shift) as i32, (ty << grid.shift) as i32);
                let part = PixelRect {
                    x0: rect.x0.max(x),
                    x1: rect.x1.min(x + edge - 1),
                    y0: rect.y0.max(y),
                    y1: rect.y1.min(y + edge - 1),
                };
                if binning == Binning::BoundingBox || covers_tile(&triangle, part) {
                    self.pairs.push((ty * grid.columns + tx, number));
                }
            }
        }
    }

    /// Sorts the entries by tile, keeping their order inside a tile.
    pub fn sort(&mut self, grid: &TileGrid) {
        self.starts.clear();
        self.starts.resize(grid.count() + 1, 0);
        for &(tile, _) in &self.pairs {
            self.starts[tile as usize + 1] += 1;
        }
        let mut sum = 0;
        for start in &mut self.starts {
            sum += *start;
            *start = sum;
        }
        self.entries.clear();
        self.entries.resize(self.pairs.len(), 0);
        // Moving an entry advances its tile's start; afterwards each start is the next tile's.
        for &(tile, number) in &self.pairs {
            let at = &mut self.starts[tile as usize];
            self.entries[*at as usize] = number;
            *at += 1;
        }
        self.starts.copy_within(0..grid.count(), 1);
        self.starts[0] = 0;
    }

    /// The triangles of a tile, in the order they came.
    pub fn tile(&self, tile: u32) -> &[u32] {
        if self.starts.is_empty() {
            return &[];
        }
        let (from, to) = (self.starts[tile as usize], self.starts[tile as usize + 1]);
        &self.entries[from as usize..to as usize]
    }

    /// Entries in all tiles.
    pub fn entries(&self) -> u64 {
        self.entries.len() as u64
    }

    /// Bytes of memory held.
    pub fn bytes(&self) -> u64 {
        (self.triangles.capacity() * size_of::<ScreenTriangle>()
            + self.pairs.capacity() * 8
            + self.starts.capacity() * 4
            + self.entries.capacity() * 4) as u64
    }
}
