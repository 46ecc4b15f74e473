//! What clusters reach which tiles, and what groups of ranks have in them.

use tercio_parallel::division::Division;
use tercio_raster::context::FrameContext;
use tercio_raster::screen::PixelRect;
use tercio_raster::survey::{COVERED_OF_BOX, Effort, Survey, WORK_OF_HIDDEN};

use super::rates::{BIN_CLUSTER, BIN_TRIANGLE, Rates};

/// Clusters of more tiles, or of more pixels along an edge of their box, are sorted triangle by triangle, like by the renderer's
/// front end.
const MOST_TILES: u64 = 16;
const LARGE: u32 = 255;
/// The share of the box of a cluster in which it shows something, for the pixels that are sent; [`COVERED_OF_BOX`] is that of what
/// hides others.
const SHOWN_OF_BOX: f64 = 0.4;
/// Fragments at the edges of triangles, for each square root of a pixel and of a triangle that is seen in it.
const EDGES: f64 = 1.2;

/// How many of a scene's clusters the renderer looks at with an effort: every second, every third ...
pub fn looked_at(effort: Effort, clusters: u64) -> u64 {
    clusters.div_ceil(clusters.div_ceil(effort.clusters.into()).max(1))
}

/// A cluster in a tile; it stands for several.
#[derive(Clone, Copy, Debug)]
struct Entry {
    tile: u32,
    /// The rank that draws it where pictures are composited.
    rank: u32,
    triangles: f64,
    /// Pixels inside the box of the cluster.
    pixels: f64,
    /// Bytes in a message of bins.
    bytes: f64,
    /// Seconds of sorting it into the tile.
    sorting: f64,
    /// Pixels of the tile in which it shows something.
    shown: f64,
    /// Where these are in the tile.
    place: Place,
}

/// Columns, and rows, of the cells into which a tile is divided to estimate which of its pixels show something: most clusters are
/// smaller than a tile, and at the outline of a model they lie on one side of it.
const CELLS: usize = 4;

/// Where in a tile a box is: of each column and each row of cells, the share of the part of the box in the tile, in 255ths.
#[derive(Clone, Copy, Debug, Default)]
struct Place {
    columns: [u8; CELLS],
    rows: [u8; CELLS],
}

/// What a cluster whose box has these pixels, first and last column and row, shows in a tile: the number of pixels, and where. It is
/// taken to be in the middle of the box.
fn shown([x0, x1, y0, y1]: [u32; 4], tile: PixelRect) -> (f64, Place) {
    let along = |a0: u32, a1: u32, b0: i32, b1: i32| {
        let inset = (f64::from(a1 - a0) + 1.0) * 0.5 * (1.0 - SHOWN_OF_BOX.sqrt());
        let (first, end) = (f64::from(b0), f64::from(b1) + 1.0);
        let (from, to) = ((f64::from(a0) + inset).max(first), (f64::from(a1) + 1.0 - inset).min(end));
        let size = (end - first) / CELLS as f64;
        let length = (to - from).max(0.0);
        let share = |cell: usize| {
            let start = first + cell as f64 * size;
            let inside = (to.min(start + size) - from.max(start)).max(0.0);
            (inside / length.max(1e-9) * 255.0).round() as u8
        };
        (length, std::array::from_fn(share))
    };
    let (width, columns) = along(x0, x1, tile.x0, tile.x1);
    let (height, rows) = along(y0, y1, tile.y0, tile.y1);
    (width * height, Place { columns, rows })
}

/// Pixels that boxes show in the cells of a tile, each for itself.
#[derive(Clone, Copy, Default)]
struct Cells([[f32; CELLS]; CELLS]);

impl Cells {
    fn add(&mut self, pixels: f64, place: &Place) {
        let each = (pixels / (255.0 * 255.0)) as f32;
        for (row, share) in self.0.iter_mut().zip(place.rows) {
            let of_row = each * f32::from(share);
            row.iter_mut().zip(place.columns).for_each(|(cell, share)| *cell += of_row * f32::from(share));
        }
    }

    /// Pixels that show something, as if what is shown were scattered in each cell.
    fn covered(&self, of_tile: f64) -> f64 {
        let of_cell = of_tile / (CELLS * CELLS) as f64;
        self.0.as_flattened().iter().map(|&area| covered(f64::from(area), of_cell)).sum()
    }
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
    /// The same of the clusters.
    pub survey_of_clusters: f64,
    /// Of each rank: seconds of sorting its clusters into tiles; bytes of bins. First where nothing is composited, and then where it is.
    pub sorted: [Vec<[f64; 2]>; 2],
    /// Pixels of each tile that show something.
    pub covered: Vec<f64>,
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
        let mut sorted = [vec![[0.0; 2]; ranks], vec![[0.0; 2]; ranks]];
        let mut cells = vec![Cells::default(); tiles];
        let ranks_of = survey.divide(context, ranks);
        survey.visits(context, |place, visit| {
            let seen = &survey.seen[place];
            let [x0, x1, y0, y1] = seen.rect;
            let [column0, column1, row0, row1] = context.grid.tiles_that_need(seen.rect);
            let reached = u64::from(column1 - column0 + 1) * u64::from(row1 - row0 + 1);
            let is_large = reached > MOST_TILES || (x1 - x0).max(y1 - y0) >= LARGE;
            let [bytes, sorting] = if is_large {
                [visit.triangles * BIN_TRIANGLE, visit.triangles * rates.triangle_entry]
            } else {
                [survey.step * BIN_CLUSTER, survey.step * rates.entry]
            };
            let rank = ranks_of[place];
            for (sorted, rank) in sorted.iter_mut().zip([rank_of(seen.number, clusters, ranks), rank]) {
                let [seconds, of_bins] = sorted[rank as usize];
                sorted[rank as usize] = [seconds + sorting, of_bins + bytes];
            }
            let (triangles, pixels) = (visit.triangles, visit.pixels);
            let (shown, place) = shown(seen.rect, context.grid.rect(visit.tile, context.size()));
            let shown = shown * survey.step;
            cells[visit.tile as usize].add(shown, &place);
            entries.push(Entry { tile: visit.tile, rank, triangles, pixels, bytes, sorting, shown, place });
        });
        let pixels = (0..tiles as u32).map(|tile| {
            let rect = context.grid.rect(tile, context.size());
            f64::from(rect.x1 - rect.x0 + 1) * f64::from(rect.y1 - rect.y0 + 1)
        });
        let pixels: Vec<f64> = pixels.collect();
        let seconds = |effort: Effort| {
            let looked_at = looked_at(effort, clusters.into()) as f64;
            let visits = entries.len() as f64 * looked_at / f64::from(survey.looked_at.max(1));
            looked_at * rates.survey[0] + visits.min(effort.visits as f64) * rates.survey[1]
        };
        let (survey, survey_of_clusters) = (seconds(Effort::OF_TILES), seconds(Effort::of_clusters(ranks)));
        let mut found = Self {
            covered: cells.iter().zip(&pixels).map(|(cells, &of_tile)| cells.covered(of_tile)).collect(),
            pixels,
            load: vec![0; tiles],
            clusters: f64::from(clusters),
            survey,
            survey_of_clusters,
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
        let groups = self.sorted[0].len().div_ceil(group.max(1));
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

/// The rank in whose share ([`tercio_raster::Part::range`]) of the clusters one is where nothing is composited.
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
    shown: f64,
    cells: Cells,
    hidden: f64,
    bytes: f64,
    sorting: f64,
}

impl Sum {
    fn add(&mut self, entry: &Entry, of_tile: f64, rates: &Rates) {
        let seen = if rates.translucent { 1.0 } else { 1.0 - self.hidden };
        self.triangles += entry.triangles * (WORK_OF_HIDDEN + (1.0 - WORK_OF_HIDDEN) * seen);
        self.seen += entry.triangles * seen;
        self.shown += entry.shown;
        self.cells.add(entry.shown, &entry.place);
        self.hidden = (self.hidden + seen * entry.pixels * COVERED_OF_BOX / of_tile).min(1.0);
        self.bytes += entry.bytes;
        self.sorting += entry.sorting;
    }

    fn part(&self, group: u32, of_tile: f64, rates: &Rates) -> Part {
        let pixels = self.cells.covered(of_tile);
        let layers = if rates.translucent { self.shown * (COVERED_OF_BOX / SHOWN_OF_BOX) } else { pixels };
        let shown = if rates.fragments {
            (layers + EDGES * (layers * self.seen).sqrt()).min(layers * rates.samples)
        } else {
            pixels
        };
        let Self { tile, triangles, bytes: bin_bytes, sorting, .. } = *self;
        Part { tile, group, triangles, pixels, shown, bin_bytes, sorting }
    }
}

/// Pixels of an area that are covered by what has so many pixels in all, if it is scattered there.
fn covered(pixels: f64, of_area: f64) -> f64 {
    of_area * -(-pixels / of_area).exp_m1()
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

    /// What lies in one corner of a tile covers no more than that, however much it is.
    #[test]
    fn boxes_cover_the_cells_in_which_they_are() {
        let tile = PixelRect { x0: 64, x1: 127, y0: 0, y1: 63 };
        // The middle 12.65 by 12.65 pixels of a box of 20 by 20, of which half the rows are in the tile.
        let (pixels, place) = shown([70, 89, 54, 73], tile);
        assert!((pixels - 80.0).abs() < 1e-9, "{pixels}");
        assert_eq!(place.rows, [0, 0, 0, 255]);
        assert!(place.columns[0] > 100 && place.columns[1] > 100 && place.columns[2..] == [0, 0]);
        let mut cells = Cells::default();
        (0..1000).for_each(|_| cells.add(pixels, &place));
        assert!((cells.covered(4096.0) - 2.0 * 256.0).abs() < 1.0);
        // Boxes of the whole tile, and beside it.
        let (pixels, place) = shown([0, 575, 0, 575], PixelRect { x0: 256, x1: 319, y0: 256, y1: 319 });
        let mut cells = Cells::default();
        cells.add(1000.0, &place);
        assert_eq!(pixels, 4096.0);
        assert!((cells.covered(4096.0) - covered(1000.0, 4096.0)).abs() < 20.0);
        assert_eq!(shown([0, 65, 0, 500], tile).0, 0.0);
    }

    #[test]
    fn a_tile_is_never_covered_more_than_once() {
        assert_eq!(covered(0.0, 100.0), 0.0);
        assert!((covered(1.0, 100.0) - 1.0).abs() < 0.01);
        assert!(covered(1e6, 100.0) <= 100.0 && covered(300.0, 100.0) > 90.0);
    }
}
