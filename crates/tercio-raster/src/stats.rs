//! Work, counted where it is done.

use serde::Serialize;

use crate::binning::TileGrid;
use crate::frontend::Batch;

/// What one frame did. Counts are the same from run to run unless said otherwise; times are not.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct FrameStats {
    /// What the front end met and dropped.
    pub frontend: FrontEndCounts,
    /// What was sorted into tiles.
    pub binning: BinningCounts,
    /// What was drawn.
    pub backend: BackEndCounts,
    /// Milliseconds a stage.
    pub milliseconds: StageTimes,
    /// Threads of the pool.
    pub threads: usize,
    /// Name of the SIMD level.
    pub simd: &'static str,
    /// Pixels along the edge of a tile.
    pub tile_size: u32,
}

/// Front end: clusters and triangles in, what was dropped by which rule, triangles out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct FrontEndCounts {
    /// Clusters of all instances.
    pub clusters_in: u64,
    /// Clusters wholly outside the view volume.
    pub clusters_outside: u64,
    /// Clusters that show only the side that is culled.
    pub clusters_facing: u64,
    /// Triangles of all instances.
    pub triangles_in: u64,
    /// Triangles in clusters outside the view volume.
    pub triangles_in_outside_clusters: u64,
    /// Triangles in clusters that show only the side that is culled.
    pub triangles_in_facing_clusters: u64,
    /// Triangles wholly outside one plane of the view volume, met one by one.
    pub triangles_outside: u64,
    /// Triangles without area after snapping.
    pub triangles_no_area: u64,
    /// Triangles culled by their facing, met one by one.
    pub triangles_facing: u64,
    /// Triangles whose bounding box holds no sample of the picture.
    pub triangles_no_sample: u64,
    /// Triangles that were clipped at the near plane or the guard band.
    pub triangles_clipped: u64,
    /// Triangles handed to the bins, pieces of clipped ones counted each.
    pub triangles_out: u64,
    /// Vertices transformed.
    pub vertices_transformed: u64,
}

/// Binning: triangles in, entries out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct BinningCounts {
    /// Triangles binned.
    pub triangles: u64,
    /// Entries in all tiles.
    pub entries: u64,
    /// Entries a triangle.
    pub overlap: f64,
    /// Tiles of the picture.
    pub tiles: u64,
    /// Tiles with at least one entry.
    pub tiles_used: u64,
    /// Entries of the fullest tile.
    pub largest_tile: u64,
    /// Bytes that the bins hold.
    pub bytes: u64,
}

/// Back end: samples and pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct BackEndCounts {
    /// Blocks of 4x4 samples tested against a triangle.
    pub blocks: u64,
    /// Samples covered by a triangle, hidden or not.
    pub samples_covered: u64,
    /// Pixels that show a triangle, each shaded once.
    pub pixels_shaded: u64,
    /// Samples covered a pixel shaded.
    pub overdraw: f64,
}

/// Milliseconds of wall time a stage.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct StageTimes {
    /// Set-up of the frame: matrices, lists, memory.
    pub prepare: f64,
    /// Front end and binning.
    pub frontend: f64,
    /// Back end: coverage, depth, shading, writing.
    pub backend: f64,
    /// The whole frame.
    pub total: f64,
}

impl FrontEndCounts {
    /// Sums.
    pub(crate) fn plus(self, o: Self) -> Self {
        Self {
            clusters_in: self.clusters_in + o.clusters_in,
            clusters_outside: self.clusters_outside + o.clusters_outside,
            clusters_facing: self.clusters_facing + o.clusters_facing,
            triangles_in: self.triangles_in + o.triangles_in,
            triangles_in_outside_clusters: self.triangles_in_outside_clusters
                + o.triangles_in_outside_clusters,
            triangles_in_facing_clusters: self.triangles_in_facing_clusters + o.triangles_in_facing_clusters,
            triangles_outside: self.triangles_outside + o.triangles_outside,
            triangles_no_area: self.triangles_no_area + o.triangles_no_area,
            triangles_facing: self.triangles_facing + o.triangles_facing,
            triangles_no_sample: self.triangles_no_sample + o.triangles_no_sample,
            triangles_clipped: self.triangles_clipped + o.triangles_clipped,
            triangles_out: self.triangles_out + o.triangles_out,
            vertices_transformed: self.vertices_transformed + o.vertices_transformed,
        }
    }
}

impl BinningCounts {
    /// What the batches of a frame hold.
    pub(crate) fn of(batches: &[Batch], grid: &TileGrid) -> Self {
        let triangles: u64 = batches.iter().map(|b| b.bins.len()).sum();
        let entries: u64 = batches.iter().map(|b| b.bins.entries()).sum();
        let fill = |tile: u32| batches.iter().map(|b| b.bins.fill(tile) as u64).sum::<u64>();
        let (mut tiles_used, mut largest_tile) = (0, 0);
        for fill in (0..grid.count() as u32).map(fill) {
            tiles_used += u64::from(fill > 0);
            largest_tile = largest_tile.max(fill);
        }
        Self {
            triangles,
            entries,
            overlap: ratio(entries, triangles),
            tiles: grid.count() as u64,
            tiles_used,
            largest_tile,
            bytes: batches.iter().map(|b| b.bins.bytes()).sum(),
        }
    }
}

impl BackEndCounts {
    /// Sums.
    pub(crate) fn plus(self, o: Self) -> Self {
        Self {
            blocks: self.blocks + o.blocks,
            samples_covered: self.samples_covered + o.samples_covered,
            pixels_shaded: self.pixels_shaded + o.pixels_shaded,
            overdraw: 0.0,
        }
    }

    /// Fills in what follows from the sums.
    pub(crate) fn finish(self) -> Self {
        Self { overdraw: ratio(self.samples_covered, self.pixels_shaded), ..self }
    }
}

/// A quotient, 0 where there is nothing to divide by.
fn ratio(of: u64, by: u64) -> f64 {
    if by == 0 { 0.0 } else { of as f64 / by as f64 }
}
