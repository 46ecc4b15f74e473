//! Work, counted where it is done.

use serde::{Deserialize, Deserializer, Serialize, de};

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

/// Declares a struct of counts with its sum, so that no field is forgotten there. Fields behind `and` are computed from
/// the sums later, and 0 in them.
macro_rules! counts {
    (
        $(#[$meta:meta])* pub struct $name:ident { $($(#[$doc:meta])* pub $field:ident: u64,)* }
        $(and { $($(#[$later_doc:meta])* pub $later:ident: $type:ty,)* })?
    ) => {
        $(#[$meta])*
        pub struct $name {
            $($(#[$doc])* pub $field: u64,)*
            $($($(#[$later_doc])* pub $later: $type,)*)?
        }

        impl $name {
            /// Sums.
            pub fn plus(self, o: Self) -> Self {
                Self { $($field: self.$field + o.$field,)* $($($later: <$type>::default(),)*)? }
            }
        }
    };
}
pub(crate) use counts;

counts! {
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

counts! {
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
    } and {
        /// Samples covered a visible pixel.
        pub overdraw: f64,
    }
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

impl BackEndCounts {
    /// Fills in what follows from the sums.
    pub fn finish(self) -> Self {
        Self { overdraw: ratio(self.samples_covered, self.pixels_visible), ..self }
    }
}

/// A quotient, 0 where there is nothing to divide by.
pub(crate) fn ratio(of: u64, by: u64) -> f64 {
    if by == 0 { 0.0 } else { of as f64 / by as f64 }
}
