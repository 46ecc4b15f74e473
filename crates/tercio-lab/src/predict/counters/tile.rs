//! One tile: triangles of its bins, then clusters front to back, each only if it is not wholly behind what is there.

use std::sync::atomic::Ordering;

use tercio_raster::LastStage;

use super::Counters;
use super::front_end::{Bins, Frame, WholeCluster};
use super::triangle::Triangle;
use super::whole;
use crate::workloads::PixelBox;

/// Edge of a block of samples.
pub const BLOCK: i32 = 4;
/// Steps of depth in which clusters are drawn.
const STEPS: usize = 16;
/// In rows of fewer blocks none is skipped.
const LEAST_SKIPPED: i32 = 5;
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

    /// The box of whole blocks round a box of pixels of the tile.
    fn blocks_round(&self, p: PixelBox) -> PixelBox {
        let down = |v: i32, k: usize| self.corner[k] + (v - self.corner[k]) / BLOCK * BLOCK;
        PixelBox {
            x0: down(p.x0, 0),
            y0: down(p.y0, 1),
            x1: down(p.x1, 0) + BLOCK - 1,
            y1: down(p.y1, 1) + BLOCK - 1,
        }
    }

    /// Lies all that is drawn, in the blocks that a cluster may reach, before it?
    fn hides(&self, cluster: &WholeCluster) -> bool {
        let Some(pixels) = cluster.pixels.intersection(&self.pixels) else { return true };
        let b = self.blocks_round(pixels);
        let nearer = |x: i32, y: i32| self.depth[self.place(x, y)] > cluster.nearest;
        (b.y0..=b.y1).all(|y| (b.x0..=b.x1).all(|x| nearer(x, y)))
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

    /// Draws a triangle by itself, in blocks of samples, and tells what it wins. At the picture's border blocks reach
    /// beyond it.
    pub fn triangle(&mut self, t: &Triangle, counters: &mut Counters, mut won: impl FnMut((i32, i32))) {
        let Some(pixels) = t.samples().and_then(|s| s.intersection(&self.pixels)) else { return };
        let b = self.blocks_round(pixels);
        let skips = (b.x1 - b.x0 + 1) / BLOCK >= LEAST_SKIPPED;
        for y in (b.y0..=b.y1).step_by(BLOCK as usize) {
            for x in (b.x0..=b.x1).step_by(BLOCK as usize) {
                let block = PixelBox { x0: x, y0: y, x1: x + BLOCK - 1, y1: y + BLOCK - 1 };
                if skips && !t.may_cover(&block) {
                    continue;
                }
                counters.blocks += 1;
                counters.blocks_alone += 1;
                for (x, y) in (y..y + BLOCK).flat_map(|y| (x..x + BLOCK).map(move |x| (x, y))) {
                    // The picture's border may cut the block.
                    let inside = x <= self.pixels.x1 && y <= self.pixels.y1;
                    if inside && t.covers(x, y) {
                        counters.samples_covered += 1;
                        if self.test(x, y, t.depth(x, y), t.primitive) {
                            won((x, y));
                        }
                    }
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
