//! Statistics of a frame: the work of each stage, counted where it is done, and its times.

use serde::{Deserialize, Deserializer, Serialize, de};

use crate::simd::SimdLevel;

/// Name of a SIMD level. A type alias, because `serde` would try to borrow a plain `&str` from its input.
pub type LevelName = &'static str;

/// Statistics of one frame. Counts are the same from run to run unless stated otherwise; times are not.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct FrameStats {
    /// What the front end received, culled and passed on.
    pub frontend: FrontEndCounts,
    /// What was sorted into tiles.
    pub binning: BinningCounts,
    /// What was drawn.
    pub backend: BackEndCounts,
    /// Milliseconds per stage.
    pub milliseconds: StageTimes,
    /// Threads that the work was divided among: those of the pool.
    pub threads: usize,
    /// Name of the SIMD level; empty where nothing was drawn.
    #[serde(deserialize_with = "level_name")]
    pub simd: LevelName,
    /// Pixels along the edge of a tile.
    pub tile_size: u32,
}

impl FrameStats {
    /// The statistics of two bands of one picture, or of the pictures of two eyes, together.
    pub fn plus(&self, o: &Self) -> Self {
        let (a, b) = (&self.milliseconds, &o.milliseconds);
        Self {
            frontend: self.frontend.plus(o.frontend),
            binning: self.binning.plus(&o.binning),
            backend: {
                let sum = self.backend.plus(o.backend);
                let share = |of: &BackEndCounts| of.overdraw * of.pixels_visible as f64;
                let overdraw = share(&self.backend) + share(&o.backend);
                BackEndCounts { overdraw: overdraw / sum.pixels_visible.max(1) as f64, ..sum }
            },
            milliseconds: StageTimes {
                prepare: a.prepare + b.prepare,
                frontend: a.frontend + b.frontend,
                backend: a.backend + b.backend,
                total: a.total + b.total,
            },
            ..self.clone()
        }
    }
}

impl BinningCounts {
    /// The counts of two bands of one picture, or of the pictures of two eyes, together.
    pub fn plus(&self, o: &Self) -> Self {
        let (triangles, entries) = (self.triangles + o.triangles, self.entries + o.entries);
        let (clusters, cluster_entries) =
            (self.clusters + o.clusters, self.cluster_entries + o.cluster_entries);
        Self {
            triangles,
            entries,
            overlap: ratio(entries, triangles),
            clusters,
            cluster_entries,
            cluster_overlap: ratio(cluster_entries, clusters),
            tiles: self.tiles + o.tiles,
            tiles_used: self.tiles_used + o.tiles_used,
            largest_tile: self.largest_tile.max(o.largest_tile),
            bytes: self.bytes.max(o.bytes),
        }
    }
}

/// Declares a struct of counts together with its sum, so that the sum cannot miss a field. Fields after `and` are
/// derived from the sums later; in the sums themselves they are 0.
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
            /// The sum of two, field by field.
            pub fn plus(self, o: Self) -> Self {
                Self { $($field: self.$field + o.$field,)* $($($later: <$type>::default(),)*)? }
            }
        }
    };
}
pub(crate) use counts;

counts! {
    /// Front end: clusters and triangles in, those culled by each test, clusters and triangles out.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
    #[non_exhaustive]
    pub struct FrontEndCounts {
        /// Clusters of all instances.
        pub clusters_in: u64,
        /// Clusters wholly outside the view volume.
        pub clusters_outside: u64,
        /// Clusters of which all triangles show the culled side.
        pub clusters_facing: u64,
        /// Clusters that fall between the samples of the picture.
        pub clusters_no_sample: u64,
        /// Clusters that overlap only tiles that are not drawn.
        pub clusters_elsewhere: u64,
        /// Clusters binned as a whole.
        pub clusters_out: u64,
        /// Triangles of all instances.
        pub triangles_in: u64,
        /// Triangles in clusters outside the view volume.
        pub triangles_in_outside_clusters: u64,
        /// Triangles in clusters of which all triangles show the culled side.
        pub triangles_in_facing_clusters: u64,
        /// Triangles in clusters that overlap only tiles that are not drawn.
        pub triangles_elsewhere: u64,
        /// Triangles of which clipping left nothing, in clusters that are binned triangle by triangle.
        pub triangles_outside: u64,
        /// Triangles whose area is zero after snapping, likewise.
        pub triangles_no_area: u64,
        /// Triangles removed by face culling, likewise.
        pub triangles_facing: u64,
        /// Triangles whose bounding box, or whose cluster's bounding box, contains no sample of the picture.
        pub triangles_no_sample: u64,
        /// Triangles that were clipped at the near plane or the guard band.
        pub triangles_clipped: u64,
        /// Triangles binned one by one; each piece of a clipped triangle counts.
        pub triangles_out: u64,
        /// Vertices of the clusters that were binned triangle by triangle.
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
    /// Entries per triangle.
    pub overlap: f64,
    /// Clusters binned as a whole.
    pub clusters: u64,
    /// Their entries in all tiles.
    pub cluster_entries: u64,
    /// Entries per cluster.
    pub cluster_overlap: f64,
    /// Tiles of the picture.
    pub tiles: u64,
    /// Tiles with at least one entry.
    pub tiles_used: u64,
    /// Entries of both kinds in the fullest tile.
    pub largest_tile: u64,
    /// Bytes of memory allocated by the bins.
    pub bytes: u64,
}

counts! {
    /// Back end: clusters, triangles, samples and pixels. The work on a cluster is counted in each tile that draws it.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
    #[non_exhaustive]
    pub struct BackEndCounts {
        /// Clusters that were occluded by what was drawn before them.
        pub clusters_hidden: u64,
        /// Clusters drawn.
        pub clusters_drawn: u64,
        /// Their vertices.
        pub vertices_transformed: u64,
        /// Their triangles.
        pub triangles_in: u64,
        /// Those of them whose bounding box contains a sample and that do not show the culled side.
        pub triangles_drawn: u64,
        /// Stamps of 16 samples tested against a triangle; triangles of a few samples need none.
        pub stamps: u64,
        /// Samples covered by a triangle, hidden or not.
        pub samples_covered: u64,
        /// Pixels shaded; with several samples per pixel, triangles shaded in pixels (or samples). A pixel of a cluster is
        /// shaded as soon as the cluster is drawn, and again if a nearer cluster covers it later.
        pub pixels_shaded: u64,
        /// Pixels that show a triangle.
        pub pixels_visible: u64,
    } and {
        /// Samples covered per sample of the visible pixels.
        pub overdraw: f64,
    }
}

/// Milliseconds of wall time per stage.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct StageTimes {
    /// Setup of the frame: matrices, lists, memory.
    pub prepare: f64,
    /// Front end and binning.
    pub frontend: f64,
    /// Back end: coverage, depth, shading, writing.
    pub backend: f64,
    /// The whole frame.
    pub total: f64,
}

/// Deserializes the name of a level to the string of [`SimdLevel::name`].
fn level_name<'de, D: Deserializer<'de>>(from: D) -> Result<LevelName, D::Error> {
    let name = String::deserialize(from)?;
    // Reports of earlier versions may have a level that has become one with SSE2.
    let name = if name == "sse4.2" { SimdLevel::Sse2.name() } else { &name };
    if name.is_empty() { Ok("") } else { name.parse().map(SimdLevel::name).map_err(de::Error::custom) }
}

impl BackEndCounts {
    /// Fills in the fields that are derived from the sums, of a picture with this many samples per pixel.
    pub fn finish(self, samples: u64) -> Self {
        Self { overdraw: ratio(self.samples_covered, self.pixels_visible * samples), ..self }
    }

    /// The work, in about nanoseconds of one processor: the costs are those of the laboratory's machine `two-core-2026`, roughly. It
    /// is for comparing tiles of a frame, and the same from run to run.
    pub fn work(&self) -> u64 {
        48 * self.clusters_hidden
            + 71 * self.clusters_drawn
            + self.vertices_transformed
            + 3 * self.triangles_drawn
            + 7 * self.stamps
            + 3 * self.pixels_shaded
    }
}

/// A quotient; 0 if the divisor is 0.
pub(crate) fn ratio(of: u64, by: u64) -> f64 {
    if by == 0 { 0.0 } else { of as f64 / by as f64 }
}
