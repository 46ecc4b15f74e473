//! The front end: partitions are culled, triangles are culled, the rest goes into the buckets of its tiles.

use serde::Serialize;

use super::heap::{Heap, HeapLayout};
use super::triangle::PixelBox;
use super::{Partition, Scene, Triangle};

/// Counts of a front end.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct FrontEndCounts {
    /// Partitions processed.
    pub partitions: u64,
    /// Partitions without a triangle that faces the eye: none of their vertices is transformed.
    pub partitions_culled: u64,
    /// Vertices transformed.
    pub vertices: u64,
    /// Triangles processed, each tested by its normal.
    pub triangles: u64,
    /// Triangles that face away, or reach behind the eye.
    pub back_facing: u64,
    /// Triangles whose rounded bounding box has no width or no height.
    pub sub_pixel: u64,
    /// Triangles outside the picture.
    pub outside: u64,
    /// Triangles set up: one node each, however many buckets it goes into.
    pub nodes: u64,
    /// Nodes written, one per bucket.
    pub entries: u64,
}

impl FrontEndCounts {
    /// The sum of both.
    pub fn plus(self, o: Self) -> Self {
        Self {
            partitions: self.partitions + o.partitions,
            partitions_culled: self.partitions_culled + o.partitions_culled,
            vertices: self.vertices + o.vertices,
            triangles: self.triangles + o.triangles,
            back_facing: self.back_facing + o.back_facing,
            sub_pixel: self.sub_pixel + o.sub_pixel,
            outside: self.outside + o.outside,
            nodes: self.nodes + o.nodes,
            entries: self.entries + o.entries,
        }
    }

    /// Mean number of buckets per triangle.
    pub fn overlap(&self) -> f64 {
        if self.nodes == 0 { 0.0 } else { self.entries as f64 / self.nodes as f64 }
    }
}

/// The screen in square tiles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tiles {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Pixels along the edge of a tile.
    pub edge: u32,
}

impl Tiles {
    /// Tiles across.
    pub fn columns(&self) -> u32 {
        self.width.div_ceil(self.edge)
    }

    /// Tiles down.
    pub fn rows(&self) -> u32 {
        self.height.div_ceil(self.edge)
    }

    /// All tiles.
    pub fn count(&self) -> usize {
        self.columns() as usize * self.rows() as usize
    }

    /// The pixels of a tile inside the picture.
    pub fn pixels(&self, tile: usize) -> PixelBox {
        let (column, row) = self.place(tile);
        let (x0, y0) = (column * self.edge, row * self.edge);
        PixelBox {
            x0: x0 as i32,
            x1: (x0 + self.edge).min(self.width) as i32,
            y0: y0 as i32,
            y1: (y0 + self.edge).min(self.height) as i32,
        }
    }

    /// Column and row of a tile.
    pub fn place(&self, tile: usize) -> (u32, u32) {
        (tile as u32 % self.columns(), tile as u32 / self.columns())
    }

    /// Tiles that a box touches, row by row.
    fn touched(&self, pixels: PixelBox) -> impl Iterator<Item = usize> {
        let (edge, columns) = (self.edge as i32, self.columns() as usize);
        let (left, right) = (pixels.x0 / edge, (pixels.x1 - 1) / edge);
        (pixels.y0 / edge..=(pixels.y1 - 1) / edge)
            .flat_map(move |row| (left..=right).map(move |column| row as usize * columns + column as usize))
    }
}

/// The output of one front end.
#[derive(Clone, Debug)]
pub struct FrontEnd {
    /// Counts.
    pub counts: FrontEndCounts,
    /// Triangles that were set up, in the order of their nodes.
    pub nodes: Vec<Triangle>,
    /// The bucket sorted heap.
    pub heap: Heap,
}

impl FrontEnd {
    /// Runs partitions through one front end into one heap.
    pub fn run(partitions: &[Partition], tiles: Tiles, layout: HeapLayout) -> Self {
        let screen = PixelBox { x0: 0, x1: tiles.width as i32, y0: 0, y1: tiles.height as i32 };
        let mut out = Self {
            counts: FrontEndCounts::default(),
            nodes: Vec::new(),
            heap: Heap::new(tiles.count(), layout),
        };
        for partition in partitions {
            out.counts = out.counts.plus(out.partition(partition, tiles, screen));
        }
        out
    }

    fn partition(&mut self, partition: &Partition, tiles: Tiles, screen: PixelBox) -> FrontEndCounts {
        let outside = u64::from(partition.outside);
        let mut c = FrontEndCounts {
            partitions: 1,
            triangles: partition.triangles.len() as u64 + outside,
            back_facing: outside,
            ..Default::default()
        };
        let facing = partition.triangles.iter().filter(|t| t.area() < 0);
        c.back_facing += partition.triangles.len() as u64 - facing.clone().count() as u64;
        if c.back_facing == c.triangles {
            c.partitions_culled = 1;
            return c;
        }
        c.vertices = u64::from(partition.vertices);
        for triangle in facing {
            let Some(rounded) = triangle.rounded_box() else {
                c.sub_pixel += 1;
                continue;
            };
            let Some(visible) = rounded.and(screen) else {
                c.outside += 1;
                continue;
            };
            let node = self.nodes.len() as u32;
            self.nodes.push(*triangle);
            c.nodes += 1;
            for tile in tiles.touched(visible) {
                self.heap.push(tile, node);
                c.entries += 1;
            }
        }
        c
    }

    /// Distributes a scene's partitions over several front ends: the first part of them to the first, and so on
    /// (document 001, 4.3.2: halves).
    pub fn run_parallel(scene: &Scene, tiles: Tiles, layout: HeapLayout, front_ends: usize) -> Vec<Self> {
        let share = scene.partitions.len().div_ceil(front_ends.max(1)).max(1);
        let mut done: Vec<_> = scene.partitions.chunks(share).map(|p| Self::run(p, tiles, layout)).collect();
        done.resize_with(front_ends.max(1), || Self::run(&[], tiles, layout));
        done
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TILES: Tiles = Tiles { width: 128, height: 64, edge: 32 };

    fn run(triangles: Vec<Triangle>) -> FrontEnd {
        let partition = Partition { vertices: 3, outside: 0, triangles };
        FrontEnd::run(&[partition], TILES, HeapLayout::DOCUMENT)
    }

    /// Corners in pixels, counter-clockwise.
    fn front(x: i32, y: i32, size: i32) -> Triangle {
        Triangle::new([(x, y), (x, y + size), (x + size, y)].map(|(x, y)| (x * 256, y * 256)))
    }

    #[test]
    fn a_triangle_goes_into_every_bucket_that_its_box_touches() {
        let done = run(vec![front(20, 20, 20)]);
        let filled: Vec<_> = (0..TILES.count()).filter(|&t| done.heap.bucket(t).len() == 1).collect();
        // Tiles (0,0), (1,0), (0,1), (1,1); the last one contains no part of the triangle, only of its box.
        assert_eq!(filled, [0, 1, 4, 5]);
        assert_eq!((done.counts.nodes, done.counts.entries), (1, 4));
    }

    #[test]
    fn a_triangle_that_ends_on_a_border_stays_on_its_side() {
        // Columns 0 to 31 only: the end is exclusive.
        assert_eq!(run(vec![front(0, 0, 32)]).counts.entries, 1);
    }

    #[test]
    fn every_triangle_is_counted_once() {
        let mut back = front(3, 3, 9);
        back.x.swap(0, 1);
        back.y.swap(0, 1);
        let tiny = Triangle::new([(300, 300), (310, 340), (330, 310)]);
        let c = run(vec![front(3, 3, 9), back, tiny, front(500, 0, 9)]).counts;
        assert_eq!((c.triangles, c.back_facing, c.sub_pixel, c.outside, c.nodes), (4, 1, 1, 1, 1));
        let c = run(vec![back, back]).counts;
        assert_eq!((c.partitions_culled, c.vertices), (1, 0));
    }
}
