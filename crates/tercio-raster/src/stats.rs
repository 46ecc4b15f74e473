//! Work, counted where it is done.

use serde::{Deserialize, Deserializer, Serialize, de};

use crate::binning::{Bins, TileGrid};
use crate::settings::SimdLevel;

/// Name of a SIMD level. Under a name of its own, because `serde` would borrow a `&str` from what it reads.
pub type LevelName = &'static str;

/// What one frame did. Counts are the same from run to run unless said otherwise; times are not.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct FrameStats {
    /// What the front end met and dropped.
    pub frontend: FrontEndCounts,
    /// What was sorted into tiles.
    pub binning: BinningCounts,
    /// What was drawn.
    pub backend: BackEndCounts,
    /// Milliseconds a stage.
    pub milliseconds: StageTimes,
    /// Threads that the work was dealt out to: those of the pool.
    pub threads: usize,
    /// Name of the SIMD level; empty where nothing was drawn.
    #[serde(deserialize_with = "level_name")]
    pub simd: LevelName,
    /// Pixels along the edge of a tile.
    pub tile_size: u32,
}

/// Front end: clusters and triangles in, what was dropped by which rule, triangles out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct FrontEndCounts {
    /// Clusters of all instances.
    pub clusters_in: u64,
    /// Clusters wholly outside the view volume.
    pub clusters_outside: u64,
    /// Clusters that show only the side that is culled.
    pub clusters_facing: u64,
    /// Clusters between the samples of the picture.
    pub clusters_no_sample: u64,
    /// Clusters that reach only tiles that are not drawn.
    pub clusters_elsewhere: u64,
    /// Clusters handed to the bins as a whole.
    pub clusters_out: u64,
    /// Triangles of all instances.
    pub triangles_in: u64,
    /// Triangles in clusters outside the view volume.
    pub triangles_in_outside_clusters: u64,
    /// Triangles in clusters that show only the side that is culled.
    pub triangles_in_facing_clusters: u64,
    /// Triangles in clusters that reach only tiles that are not drawn.
    pub triangles_elsewhere: u64,
    /// Triangles wholly outside one plane of the view volume, met one by one.
    pub triangles_outside: u64,
    /// Triangles without area after snapping.
    pub triangles_no_area: u64,
    /// Triangles culled by their facing, met one by one.
    pub triangles_facing: u64,
    /// Triangles whose bounding box, or whose cluster's, holds no sample of the picture.
    pub triangles_no_sample: u64,
    /// Triangles that were clipped at the near plane or the guard band.
    pub triangles_clipped: u64,
    /// Triangles handed to the bins one by one, pieces of clipped ones counted each.
    pub triangles_out: u64,
    /// Vertices of clusters whose triangles were sorted one by one.
    pub vertices_transformed: u64,
    /// Triangles of these clusters.
    pub triangles_apart: u64,
}

/// Binning: clusters and triangles in, entries out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct BinningCounts {
    /// Triangles binned one by one.
    pub triangles: u64,
    /// Their entries in all tiles.
    pub entries: u64,
    /// Entries a triangle.
    pub overlap: f64,
    /// Clusters binned as a whole.
    pub clusters: u64,
    /// Their entries in all tiles.
    pub cluster_entries: u64,
    /// Entries a cluster.
    pub cluster_overlap: f64,
    /// Tiles of the picture.
    pub tiles: u64,
    /// Tiles with at least one entry.
    pub tiles_used: u64,
    /// Entries of both kinds of the fullest tile.
    pub largest_tile: u64,
    /// Bytes that the bins hold.
    pub bytes: u64,
}

/// Back end: what the clusters of the tiles became, samples and pixels. What a cluster does is counted in each
/// tile that draws it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct BackEndCounts {
    /// Clusters that lay behind what was drawn before them.
    pub clusters_hidden: u64,
    /// Clusters drawn.
    pub clusters_drawn: u64,
    /// Their vertices.
    pub vertices_transformed: u64,
    /// Their triangles.
    pub triangles_in: u64,
    /// Those of them that hold a sample in their bounding box and do not show the side that is culled.
    pub triangles_drawn: u64,
    /// Stamps of 16 samples tested against a triangle; triangles of a few samples need none.
    pub stamps: u64,
    /// Samples covered by a triangle, hidden or not.
    pub samples_covered: u64,
    /// Pixels shaded. Pixels of clusters are shaded when they are won, and again if a nearer cluster wins them.
    pub pixels_shaded: u64,
    /// Pixels that show a triangle.
    pub pixels_visible: u64,
    /// Samples covered a visible pixel.
    pub overdraw: f64,
}

/// Milliseconds of wall time a stage.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
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

/// The name of a level as [`SimdLevel::name`] has it, from one that another process wrote.
fn level_name<'de, D: Deserializer<'de>>(from: D) -> Result<LevelName, D::Error> {
    let name = String::deserialize(from)?;
    if name.is_empty() { Ok("") } else { name.parse().map(SimdLevel::name).map_err(de::Error::custom) }
}

impl FrontEndCounts {
    /// Sums.
    pub fn plus(self, o: Self) -> Self {
        Self {
            clusters_in: self.clusters_in + o.clusters_in,
            clusters_outside: self.clusters_outside + o.clusters_outside,
            clusters_facing: self.clusters_facing + o.clusters_facing,
            clusters_no_sample: self.clusters_no_sample + o.clusters_no_sample,
            clusters_elsewhere: self.clusters_elsewhere + o.clusters_elsewhere,
            clusters_out: self.clusters_out + o.clusters_out,
            triangles_in: self.triangles_in + o.triangles_in,
            triangles_in_outside_clusters: self.triangles_in_outside_clusters
                + o.triangles_in_outside_clusters,
            triangles_in_facing_clusters: self.triangles_in_facing_clusters + o.triangles_in_facing_clusters,
            triangles_elsewhere: self.triangles_elsewhere + o.triangles_elsewhere,
            triangles_outside: self.triangles_outside + o.triangles_outside,
            triangles_no_area: self.triangles_no_area + o.triangles_no_area,
            triangles_facing: self.triangles_facing + o.triangles_facing,
            triangles_no_sample: self.triangles_no_sample + o.triangles_no_sample,
            triangles_clipped: self.triangles_clipped + o.triangles_clipped,
            triangles_out: self.triangles_out + o.triangles_out,
            vertices_transformed: self.vertices_transformed + o.vertices_transformed,
            triangles_apart: self.triangles_apart + o.triangles_apart,
        }
    }
}

impl BinningCounts {
    /// What all bins of a frame hold.
    pub(crate) fn of(all: &[Bins], grid: &TileGrid) -> Self {
        let sum = |count: fn(&Bins) -> u64| all.iter().map(count).sum::<u64>();
        let (triangles, triangle_entries) = (sum(Bins::triangles), sum(Bins::triangle_entries));
        let (clusters, cluster_entries) = (sum(Bins::clusters), sum(Bins::cluster_entries));
        let (mut tiles_used, mut largest_tile) = (0, 0);
        for tile in 0..grid.count() as u32 {
            let fill = all.iter().map(|bins| bins.fill(tile)).sum::<u64>();
            tiles_used += u64::from(fill > 0);
            largest_tile = largest_tile.max(fill);
        }
        Self {
            triangles,
            entries: triangle_entries,
            overlap: ratio(triangle_entries, triangles),
            clusters,
            cluster_entries,
            cluster_overlap: ratio(cluster_entries, clusters),
            tiles: grid.count() as u64,
            tiles_used,
            largest_tile,
            bytes: sum(Bins::bytes),
        }
    }
}

impl BackEndCounts {
    /// Sums.
    pub fn plus(self, o: Self) -> Self {
        Self {
            clusters_hidden: self.clusters_hidden + o.clusters_hidden,
            clusters_drawn: self.clusters_drawn + o.clusters_drawn,
            vertices_transformed: self.vertices_transformed + o.vertices_transformed,
            triangles_in: self.triangles_in + o.triangles_in,
            triangles_drawn: self.triangles_drawn + o.triangles_drawn,
            stamps: self.stamps + o.stamps,
            samples_covered: self.samples_covered + o.samples_covered,
            pixels_shaded: self.pixels_shaded + o.pixels_shaded,
            pixels_visible: self.pixels_visible + o.pixels_visible,
            overdraw: 0.0,
        }
    }

    /// Fills in what follows from the sums.
    pub fn finish(self) -> Self {
        Self { overdraw: ratio(self.samples_covered, self.pixels_visible), ..self }
    }
}

/// A quotient, 0 where there is nothing to divide by.
fn ratio(of: u64, by: u64) -> f64 {
    if by == 0 { 0.0 } else { of as f64 / by as f64 }
}
