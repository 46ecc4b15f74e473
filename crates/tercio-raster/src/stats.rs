//! Work, counted where it is done.

use serde::Serialize;

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
    /// Clusters hidden by what was drawn before. Depends on the order of work.
    pub clusters_occluded: u64,
    /// Triangles of all instances.
    pub triangles_in: u64,
    /// Triangles in clusters outside the view volume.
    pub triangles_in_outside_clusters: u64,
    /// Triangles in clusters that show only the side that is culled.
    pub triangles_in_facing_clusters: u64,
    /// Triangles in clusters hidden by what was drawn before. Depends on the order of work.
    pub triangles_in_occluded_clusters: u64,
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
