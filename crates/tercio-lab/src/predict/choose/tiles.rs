//! What clusters reach which tiles, and what groups of ranks have in them.

use tercio_parallel::division::Division;
use tercio_raster::context::FrameContext;
use tercio_raster::survey::{COVERED_OF_BOX, Effort, Survey};

use super::rates::{BIN_CLUSTER, BIN_TRIANGLE, Rates};

/// Clusters of more tiles, or of more pixels along an edge of their box, are sorted triangle by triangle, like by the renderer's
/// front end.
const MOST_TILES: u64 = 16;
const LARGE: u32 = 255;
/// The share of a cluster's triangles that is drawn even where it is hidden.
const DRAWN_HIDDEN: f64 = 0.5;
/// The share of the box of a cluster in which it shows something, for the pixels that are sent; [`COVERED_OF_BOX`] is that of what
/// hides others.
const SHOWN_OF_BOX: f64 = 0.6;
/// Fragments at the edges of triangles, for each square root of a pixel and of a triangle that is seen in it.
const EDGES: f64 = 1.2;

/// How many clusters the renderer looks at, and how many tiles it visits, when it divides a picture.
const DIVIDED_BY: Effort = Effort { clusters: 4096, visits: 1 << 17 };

/// How many of a scene's clusters the renderer looks at when it divides a picture: every second, every third ...
pub fn looked_at(clusters: u64) -> u64 {
    clusters.div_ceil(clusters.div_ceil(DIVIDED_BY.clusters.into()).max(1))
}

/// A cluster in a tile; it stands for several.
#[derive(Clone, Copy, Debug)]
struct Entry {
    tile: u32,
    /// The rank in whose share of the clusters it is.
    rank: u32,
    triangles: f64,
    /// Pixels inside the box of the cluster.
    pixels: f64,
    /// Bytes in a message of bins.
    bytes: f64,
    /// Seconds of sorting it into the tile.
    sorting: f64,
}

/// The tiles of a picture, of one size.
#[derive(Clone, Debug)]
pub struct Tiles {
    /// Pixels of each tile.
    pub pixels: Vec<f64>,
    /// The work in each tile, as divisions need it.
    pub load: Vec<u64>,
    /// Clusters of the scene.
    pub clusters: f64,
    /// Seconds in which a rank finds out the work in the tiles.
    pub survey: f64,
    /// Of each rank: seconds of sorting its clusters into tiles; bytes of bins.
    pub sorted: Vec<[f64; 2]>,
    /// By the groups of clusters, then front to back.
    entries: Vec<Entry>,
}

/// What a group of ranks has in a tile.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Part {
    /// The tile.
    pub tile: u32,
    /// The group.
    pub group: u32,
    /// Triangles that are drawn.
    pub triangles: f64,
    /// Pixels that its clusters show, each for itself: where they overlap, several times.
    pub area: f64,
    /// Pixels that show something.
    pub pixels: f64,
    /// Pixels, or fragments if these are composited.
    pub shown: f64,
    /// Bytes of bins.
    pub bin_bytes: f64,
    /// Seconds of sorting its clusters into the tile.
    pub sorting: f64,
}

impl Tiles {
    /// Looks at a picture with `ranks` ranks.
    pub fn of(context: &FrameContext, effort: Effort, ranks: usize, rates: &Rates) -> Self {
        let survey = Survey::of(context, effort);
        let clusters = context.clusters();
        let tiles = context.grid.count();
        let mut entries = Vec::new();
        let mut sorted = vec![[0.0; 2]; ranks];
        survey.visits(context, |seen, visit| {
            let [x0, x1, y0, y1] = seen.rect;
            let [column0, column1, row0, row1] = context.grid.tiles_that_need(seen.rect);
            let reached = u64::from(column1 - column0 + 1) * u64::from(row1 - row0 + 1);
            let is_large = reached > MOST_TILES || (x1 - x0).max(y1 - y0) >= LARGE;
            let [bytes, sorting] = if is_large {
                [visit.triangles * BIN_TRIANGLE, visit.triangles * rates.triangle_entry]
            } else {
                [survey.step * BIN_CLUSTER, survey.step * rates.entry]
            };
            let rank = rank_of(seen.number, clusters, ranks);
            sorted[rank as usize][0] += sorting;
            sorted[rank as usize][1] += bytes;
            let (triangles, pixels) = (visit.triangles, visit.pixels);
            entries.push(Entry { tile: visit.tile, rank, triangles, pixels, bytes, sorting });
        });
        let pixels = (0..tiles as u32).map(|tile| {
            let rect = context.grid.rect(tile, context.size());
            f64::from(rect.x1 - rect.x0 + 1) * f64::from(rect.y1 - rect.y0 + 1)
        });
        let looked_at = looked_at(clusters.into()) as f64;
        let visits = entries.len() as f64 * looked_at / f64::from(survey.looked_at.max(1));
        let seconds = looked_at * rates.survey[0] + visits.min(DIVIDED_BY.visits as f64) * rates.survey[1];
        let mut found = Self {
            pixels: pixels.collect(),
            load: vec![0; tiles],
            clusters: f64::from(clusters),
            survey: seconds,
            sorted,
            entries,
        };
        for part in found.parts(ranks, rates) {
            found.load[part.tile as usize] = (part.triangles + part.pixels).ceil() as u64;
        }
        found
    }

    /// Number of clusters in tiles, the length of a loop over them.
    pub fn entries(&self) -> usize {
        self.entries.len()
    }

    /// What groups of this many ranks have in tiles, by group.
    pub fn parts(&self, group: usize, rates: &Rates) -> Vec<Part> {
        let group_of = |entry: &Entry| entry.rank as usize / group.max(1);
        let groups = self.sorted.len().div_ceil(group.max(1));
        // The entries of one group after those of another, each front to back.
        let mut ends = vec![0usize; groups + 1];
        self.entries.iter().for_each(|entry| ends[group_of(entry) + 1] += 1);
        (0..groups).for_each(|g| ends[g + 1] += ends[g]);
        let mut next = ends.clone();
        let mut order = vec![0u32; self.entries.len()];
        for (number, entry) in (0..).zip(&self.entries) {
            let at = &mut next[group_of(entry)];
            order[*at] = number;
            *at += 1;
        }
        let (mut parts, mut at) = (Vec::new(), vec![u32::MAX; self.pixels.len()]);
        let mut sums = Vec::<Sum>::new();
        for g in 0..groups {
            sums.clear();
            for &number in &order[ends[g]..ends[g + 1]] {
                let entry = &self.entries[number as usize];
                let at = &mut at[entry.tile as usize];
                if *at == u32::MAX {
                    *at = sums.len() as u32;
                    sums.push(Sum { tile: entry.tile, ..Sum::default() });
                }
                sums[*at as usize].add(entry, self.pixels[entry.tile as usize], rates);
            }
            for sum in &sums {
                at[sum.tile as usize] = u32::MAX;
                parts.push(sum.part(g as u32, self.pixels[sum.tile as usize], rates));
            }
        }
        parts
    }

    /// The owners of the tiles among this many ranks.
    pub fn owners(
        &self,
        grid: &tercio_raster::screen::TileGrid,
        division: Division,
        ranks: usize,
    ) -> Vec<u32> {
        if ranks == 1 { vec![0; self.load.len()] } else { division.owners(grid, &self.load, ranks) }
    }
}

/// The rank in whose share ([`tercio_raster::Part::range`]) of the clusters one is.
fn rank_of(cluster: u32, clusters: u32, ranks: usize) -> u32 {
    let of_next = (u64::from(cluster) + 1) * ranks as u64;
    ((of_next - 1) / u64::from(clusters.max(1))) as u32
}

/// What a group has in a tile, while its clusters are added front to back.
#[derive(Clone, Copy, Default)]
struct Sum {
    tile: u32,
    triangles: f64,
    seen: f64,
    area: f64,
    hidden: f64,
    bytes: f64,
    sorting: f64,
}

impl Sum {
    fn add(&mut self, entry: &Entry, of_tile: f64, rates: &Rates) {
        let seen = if rates.translucent { 1.0 } else { 1.0 - self.hidden };
        self.triangles += entry.triangles * (DRAWN_HIDDEN + (1.0 - DRAWN_HIDDEN) * seen);
        self.seen += entry.triangles * seen;
        self.area += entry.pixels * SHOWN_OF_BOX;
        self.hidden = (self.hidden + seen * entry.pixels * COVERED_OF_BOX / of_tile).min(1.0);
        self.bytes += entry.bytes;
        self.sorting += entry.sorting;
    }

    fn part(&self, group: u32, of_tile: f64, rates: &Rates) -> Part {
        // As if what the clusters show were scattered in the tile.
        let pixels = covered(self.area, of_tile);
        let layers = if rates.translucent { self.area * (COVERED_OF_BOX / SHOWN_OF_BOX) } else { pixels };
        let shown = if rates.fragments {
            (layers + EDGES * (layers * self.seen).sqrt()).min(layers * rates.samples)
        } else {
            pixels
        };
        let Self { tile, triangles, area, bytes: bin_bytes, sorting, .. } = *self;
        Part { tile, group, triangles, area, pixels, shown, bin_bytes, sorting }
    }
}

/// Pixels of a tile that are covered by what has so many pixels in all, if it is scattered in the tile.
pub fn covered(area: f64, of_tile: f64) -> f64 {
    of_tile * -(-area / of_tile).exp_m1()
}

#[cfg(test)]
mod tests {
    use tercio_raster::Part;

    use super::*;

    #[test]
    fn clusters_belong_to_the_ranks_that_draw_them() {
        for (clusters, ranks) in [(1u32, 1usize), (10, 3), (7, 7), (5, 8), (1000, 17), (4099, 1024)] {
            for rank in 0..ranks {
                let part = Part { number: rank as u32, of: ranks as u32 };
                for cluster in part.range(clusters) {
                    assert_eq!(rank_of(cluster, clusters, ranks), rank as u32, "{cluster} of {clusters}");
                }
            }
        }
    }

    #[test]
    fn a_tile_is_never_covered_more_than_once() {
        assert_eq!(covered(0.0, 100.0), 0.0);
        assert!((covered(1.0, 100.0) - 1.0).abs() < 0.01);
        assert!(covered(1e6, 100.0) <= 100.0 && covered(300.0, 100.0) > 90.0);
    }
}
