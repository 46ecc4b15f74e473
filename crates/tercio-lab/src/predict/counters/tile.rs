//! One tile: triangles of its bins, then clusters front to back, each only if it is not wholly behind what is there.

use std::sync::atomic::Ordering;

use tercio_raster::LastStage;

use super::Counters;
use super::front_end::{Bins, Frame, WholeCluster};
use super::triangle::Triangle;
use super::whole;
use crate::workloads::PixelBox;

/// Edge of a block of pixels that are shaded together when a tile is finished.
const BLOCK: i32 = 4;
/// Samples of a stamp, which are tested together, and edge of the blocks in which wide triangles are looked for.
pub const STAMP: i32 = 16;
/// Steps of depth in which clusters are drawn.
const STEPS: usize = 16;
/// Nothing was drawn here.
const NOBODY: u64 = u64::MAX;

/// What is seen at the samples of a tile. It is whole at the picture's border, too.
pub struct Tile {
    /// First pixel.
    corner: [i32; 2],
    /// Pixels inside the picture.
    pub pixels: PixelBox,
    edge: i32,
    depth: Vec<f32>,
    /// Primitive number.
    owner: Vec<u64>,
    /// Won by a cluster and shaded at once.
    shaded: Vec<bool>,
}

/// Every `of`-th entry of a tile, from number `part` on.
#[derive(Clone, Copy)]
pub struct Share {
    pub part: usize,
    pub of: usize,
}

/// Draws a tile that one thread draws alone.
pub fn draw(frame: &Frame, bins: &Bins, number: usize) -> Counters {
    let mut tile = Tile::new(frame, number);
    let mut counters = tile.begin(bins, number);
    if bins.fill(number) == 0 || frame.settings.last_stage <= LastStage::Bin {
        return counters;
    }
    tile.draw_share(frame, bins, number, Share { part: 0, of: 1 }, true, &mut counters);
    if !bins.triangles_of[number].is_empty() && frame.settings.last_stage > LastStage::Visibility {
        // What clusters did not shade is shaded now.
        tile.shade_late(frame, &mut counters);
    }
    counters.pixels_visible = tile.count(|_, _| true);
    counters
}

/// Draws a tile that several threads draw together: each a share into a memory of its own, merged and shaded then.
pub fn draw_shared(frame: &Frame, bins: &Bins, number: usize, threads: usize) -> Counters {
    let mut counters = Tile::new(frame, number).begin(bins, number);
    let mut merged: Option<Tile> = None;
    for part in 0..threads {
        let mut tile = Tile::new(frame, number);
        tile.draw_share(frame, bins, number, Share { part, of: threads }, false, &mut counters);
        merged = Some(match merged {
            None => tile,
            Some(mut first) => {
                first.merge(&tile);
                first
            }
        });
    }
    if let Some(tile) = merged.filter(|_| frame.settings.last_stage > LastStage::Visibility) {
        counters.pixels_visible = tile.count(|_, _| true);
        tile.shade_late(frame, &mut counters);
    }
    counters
}

impl Tile {
    fn new(frame: &Frame, number: usize) -> Self {
        let edge = frame.tile;
        let corner = [number % frame.tiles[0], number / frame.tiles[0]].map(|k| k as i32 * edge);
        let size = [frame.settings.width as i32, frame.settings.height as i32];
        let last = [0, 1].map(|k| (corner[k] + edge).min(size[k]) - 1);
        let samples = (edge * edge) as usize;
        Self {
            corner,
            pixels: PixelBox { x0: corner[0], y0: corner[1], x1: last[0], y1: last[1] },
            edge,
            depth: vec![0.0; samples],
            owner: vec![NOBODY; samples],
            shaded: vec![false; samples],
        }
    }

    /// What a tile amounts to before anything is drawn.
    fn begin(&self, bins: &Bins, number: usize) -> Counters {
        let used = u64::from(bins.fill(number) > 0);
        Counters {
            tiles: 1,
            tiles_used: used,
            pixels: self.pixels.area(),
            tile_samples: used * self.depth.len() as u64,
            ..Counters::default()
        }
    }

    /// Shades what is not shaded yet.
    fn shade_late(&self, frame: &Frame, counters: &mut Counters) {
        counters.pixels_shaded_late = self.count(|tile, place| !tile.shaded[place]);
        counters.pixels_shaded += counters.pixels_shaded_late;
        let p = self.pixels;
        let corners = (p.y0..=p.y1 + 1 - BLOCK)
            .step_by(BLOCK as usize)
            .flat_map(|y| (p.x0..=p.x1 + 1 - BLOCK).step_by(BLOCK as usize).map(move |x| (x, y)));
        let is_whole = |&(x, y): &(i32, i32)| {
            let owner = self.owner[self.place(x, y)];
            let mut places = (0..BLOCK * BLOCK).map(|k| self.place(x + k % BLOCK, y + k / BLOCK));
            owner != NOBODY && places.all(|place| self.owner[place] == owner && !self.shaded[place])
        };
        counters.whole_blocks = corners.filter(is_whole).count() as u64;
        let colored = self.count(|tile, place| !tile.shaded[place] && frame.is_colored(tile.owner[place]));
        counters.pixels_colored += colored.saturating_sub((BLOCK * BLOCK) as u64 * counters.whole_blocks);
    }

    fn place(&self, x: i32, y: i32) -> usize {
        ((y - self.corner[1]) * self.edge + (x - self.corner[0])) as usize
    }

    /// Keeps the nearer of what is there and a triangle; tells whether the triangle won.
    pub fn test(&mut self, x: i32, y: i32, depth: f32, primitive: u64) -> bool {
        let place = self.place(x, y);
        let before = self.depth[place];
        let wins = depth > before || depth == before && primitive < self.owner[place];
        if wins {
            (self.depth[place], self.owner[place]) = (depth, primitive);
        }
        wins
    }

    /// Notes that a pixel is shaded.
    pub fn shade(&mut self, x: i32, y: i32) {
        let place = self.place(x, y);
        self.shaded[place] = true;
    }

    fn merge(&mut self, other: &Self) {
        for (place, (&depth, &owner)) in other.depth.iter().zip(&other.owner).enumerate() {
            let before = self.depth[place];
            if depth > before || depth == before && owner < self.owner[place] {
                (self.depth[place], self.owner[place]) = (depth, owner);
            }
        }
    }

    /// Pixels of the picture that show something and pass a test.
    fn count(&self, test: impl Fn(&Self, usize) -> bool) -> u64 {
        let p = self.pixels;
        let places = (p.y0..=p.y1).flat_map(|y| (p.x0..=p.x1).map(move |x| self.place(x, y)));
        places.filter(|&place| self.owner[place] != NOBODY && test(self, place)).count() as u64
    }

    /// Lies all that is drawn, where a cluster may appear, before it?
    fn hides(&self, cluster: &WholeCluster) -> bool {
        let Some(p) = cluster.pixels.intersection(&self.pixels) else { return true };
        let nearer = |x: i32, y: i32| self.depth[self.place(x, y)] > cluster.nearest;
        (p.y0..=p.y1).all(|y| (p.x0..=p.x1).all(|x| nearer(x, y)))
    }

    fn draw_share(
        &mut self,
        frame: &Frame,
        bins: &Bins,
        number: usize,
        share: Share,
        shade: bool,
        counters: &mut Counters,
    ) {
        let triangles = &bins.triangles_of[number];
        if frame.settings.last_stage > LastStage::Sieve {
            for &t in triangles.iter().skip(share.part).step_by(share.of) {
                counters.entries_drawn += 1;
                self.triangle(&bins.triangles[t as usize], counters, |_| ());
            }
        }
        // The renderer's order: triangles and clusters are dealt out each by itself.
        let clusters = bins.clusters_of[number].iter().skip(share.part).step_by(share.of);
        let clusters = clusters.map(|&number| (number as usize, bins.clusters[number as usize])).collect();
        for (number, cluster) in front_to_back(clusters) {
            if self.hides(&cluster) {
                counters.clusters_hidden += 1;
                continue;
            }
            counters.clusters_drawn += 1;
            bins.drawn[number].store(true, Ordering::Relaxed);
            whole::draw(frame, &cluster, self, shade, counters);
        }
    }

    /// Draws a triangle by itself and tells what it wins. One of more columns than a stamp has is looked for in blocks.
    pub fn triangle(&mut self, t: &Triangle, counters: &mut Counters, mut won: impl FnMut((i32, i32))) {
        let Some(p) = t.samples().and_then(|s| s.intersection(&self.pixels)) else { return };
        let is_wide = p.x1 - p.x0 >= STAMP;
        let first = if is_wide { p.x0 - (p.x0 - self.corner[0]) % STAMP } else { p.x0 };
        let corners = (first..=p.x1)
            .step_by(STAMP as usize)
            .flat_map(|x| (p.y0..=p.y1).step_by(STAMP as usize).map(move |y| (x, y)));
        for (x0, y0) in corners {
            let block = PixelBox { x0, y0, x1: x0 + STAMP - 1, y1: (y0 + STAMP - 1).min(p.y1) };
            if is_wide && !t.may_cover(&block) {
                continue;
            }
            let rows = (block.y1 - block.y0 + 1) as u64;
            counters.stamps += rows;
            counters.stamps_alone += rows;
            if let Some(inside) = block.intersection(&p) {
                self.cover(t, &inside, counters, &mut won);
            }
        }
    }

    /// Draws the samples of a triangle that lie in a box.
    pub fn cover(
        &mut self,
        t: &Triangle,
        p: &PixelBox,
        counters: &mut Counters,
        mut won: impl FnMut((i32, i32)),
    ) {
        for (x, y) in (p.y0..=p.y1).flat_map(|y| (p.x0..=p.x1).map(move |x| (x, y))) {
            if t.covers(x, y) {
                counters.samples_covered += 1;
                if self.test(x, y, t.depth(x, y), t.primitive) {
                    won((x, y));
                }
            }
        }
    }
}

/// Clusters in steps of depth from the nearest to the farthest; inside a step they keep their order.
fn front_to_back(mut clusters: Vec<(usize, WholeCluster)>) -> Vec<(usize, WholeCluster)> {
    let nearest = clusters.iter().fold(f32::NEG_INFINITY, |n, c| n.max(c.1.nearest));
    let farthest = clusters.iter().fold(f32::INFINITY, |f, c| f.min(c.1.nearest));
    // Without a range the factor is not finite, and every cluster falls into step 0.
    let factor = STEPS as f32 / (nearest - farthest);
    clusters.sort_by_key(|c| (((nearest - c.1.nearest) * factor) as usize).min(STEPS - 1));
    clusters
}
