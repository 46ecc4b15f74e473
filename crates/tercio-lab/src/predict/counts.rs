//! The work of a frame: the renderer's own counts with all details, for any number of threads.

use serde::Serialize;
use tercio_raster::stats::BackEndCounts;
use tercio_raster::tally::{self, DetailCounts};
use tercio_raster::{Frame, FrameStats, Settings};
use tercio_scene::{Camera, Scene};

use super::{PredictError, occlusion};

/// Counts of a frame or a tile. Those of [`Counters::comparable`] are part of every picture's statistics.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Counters {
    /// Clusters of the scene.
    pub clusters: u64,
    /// Clusters outside the view volume.
    pub clusters_outside: u64,
    /// Clusters that show only the side that is culled.
    pub clusters_facing: u64,
    /// Clusters that contain no sample of the picture.
    pub clusters_no_sample: u64,
    /// Clusters sorted as a whole.
    pub clusters_whole: u64,
    /// Their entries in tiles.
    pub cluster_entries: u64,
    /// Triangles of the scene.
    pub triangles: u64,
    /// Clusters that are sorted triangle by triangle.
    pub clusters_apart: u64,
    /// Vertices of clusters that are sorted triangle by triangle.
    pub vertices_apart: u64,
    /// Triangles of clusters that are sorted triangle by triangle.
    pub triangles_apart: u64,
    /// Triangles, or their pieces after clipping, that are binned by themselves.
    pub triangles_binned: u64,
    /// Their entries in tiles.
    pub entries: u64,
    /// Tiles of the picture.
    pub tiles: u64,
    /// Tiles with an entry.
    pub tiles_used: u64,
    /// Entries of both kinds in the fullest tile.
    pub largest_tile: u64,
    /// Clusters hidden by what was drawn before them, summed over tiles.
    pub clusters_hidden: u64,
    /// Clusters drawn, summed over tiles.
    pub clusters_drawn: u64,
    /// Their vertices.
    pub vertices: u64,
    /// Their triangles.
    pub triangles_in: u64,
    /// Of these triangles, those with a sample of the tile in their box.
    pub triangles_drawn: u64,
    /// Stamps of 16 samples tested against triangles that are not processed 16 at a time.
    pub stamps: u64,
    /// Samples covered, hidden or not.
    pub samples_covered: u64,
    /// Pixels shaded, some more than once.
    pub pixels_shaded: u64,
    /// Pixels that show a triangle.
    pub pixels_visible: u64,
    /// Pixels of the picture.
    pub pixels: u64,
    /// Samples of the tiles with an entry, including those outside the picture at its border.
    pub tile_samples: u64,
    /// Of the shaded pixels, those shaded when a tile is finished.
    pub pixels_shaded_late: u64,
    /// Of these, blocks of 4x4 that show one triangle, which is fetched once.
    pub whole_blocks: u64,
    /// Of `stamps`, those of triangles that are binned by themselves.
    pub stamps_alone: u64,
    /// Groups of up to 16 small triangles set up.
    pub set_ups: u64,
    /// Sample steps, each for up to 16 small triangles in parallel.
    pub steps: u64,
    /// Clusters that won a pixel, summed over tiles.
    pub clusters_won: u64,
    /// Groups of up to 16 pixels shaded in parallel.
    pub shadings: u64,
    /// Of these, those that need the triangles' planes.
    pub shadings_by_plane: u64,
    /// Of the groups of pixels shaded, those in tiles that show colours of vertices or triangles.
    pub shadings_colored: u64,
    /// Stamps of 16 samples that the clusters of the tiles may reach, times the share of the clusters that are hidden.
    pub hidden_stamps: u64,
    /// Pixels shaded whose colour is that of vertices or triangles; each is fetched by itself.
    pub pixels_colored: u64,
    /// Vertices with a colour, of clusters that won a pixel, summed over tiles.
    pub vertices_colored: u64,
    /// Entries of triangles drawn.
    pub entries_drawn: u64,
    /// Bytes of cache lines of the clusters drawn, summed over tiles.
    pub bytes_read: u64,
    /// Bytes of model and bins that the frame touches, each counted once.
    pub bytes_touched: u64,
}

/// A frame and its tiles.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Counted {
    /// The whole frame.
    pub frame: Counters,
    /// The work of each tile, in the order of the tiles; without the front end.
    pub tiles: Vec<TileWork>,
}

/// The back end's work on one tile.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct TileWork {
    /// Its counts.
    pub counters: Counters,
    /// Whether all threads draw it together.
    pub is_shared: bool,
}

impl Counters {
    /// The counters that are part of every picture's statistics, by name.
    pub fn comparable(&self) -> [(&'static str, u64); 22] {
        [
            ("clusters", self.clusters),
            ("clusters outside", self.clusters_outside),
            ("clusters facing away", self.clusters_facing),
            ("clusters without a sample", self.clusters_no_sample),
            ("clusters binned", self.clusters_whole),
            ("cluster entries", self.cluster_entries),
            ("triangles", self.triangles),
            ("vertices of clusters taken apart", self.vertices_apart),
            ("triangles binned", self.triangles_binned),
            ("triangle entries", self.entries),
            ("tiles", self.tiles),
            ("tiles used", self.tiles_used),
            ("largest tile", self.largest_tile),
            ("clusters hidden", self.clusters_hidden),
            ("clusters drawn", self.clusters_drawn),
            ("vertices", self.vertices),
            ("triangles in", self.triangles_in),
            ("triangles drawn", self.triangles_drawn),
            ("stamps", self.stamps),
            ("samples covered", self.samples_covered),
            ("pixels shaded", self.pixels_shaded),
            ("pixels visible", self.pixels_visible),
        ]
    }

    /// The counters of a picture that was drawn.
    pub fn from_stats(stats: &FrameStats) -> Self {
        let (f, bins) = (&stats.frontend, &stats.binning);
        let culled = f.clusters_outside + f.clusters_facing + f.clusters_no_sample + f.clusters_elsewhere;
        // A frame that ends with culling takes none apart.
        let is_apart = f.vertices_transformed > 0;
        let left = f.clusters_in.saturating_sub(culled + bins.clusters);
        Self {
            clusters_apart: if is_apart { left } else { 0 },
            clusters: f.clusters_in,
            clusters_outside: f.clusters_outside,
            clusters_facing: f.clusters_facing,
            clusters_no_sample: f.clusters_no_sample,
            clusters_whole: bins.clusters,
            cluster_entries: bins.cluster_entries,
            triangles: f.triangles_in,
            vertices_apart: f.vertices_transformed,
            triangles_apart: f.triangles_apart,
            triangles_binned: bins.triangles,
            entries: bins.entries,
            tiles: bins.tiles,
            tiles_used: bins.tiles_used,
            largest_tile: bins.largest_tile,
            ..Self::default()
        }
        .with_back_end(&stats.backend)
    }

    fn with_back_end(self, b: &BackEndCounts) -> Self {
        Self {
            clusters_hidden: b.clusters_hidden,
            clusters_drawn: b.clusters_drawn,
            vertices: b.vertices_transformed,
            triangles_in: b.triangles_in,
            triangles_drawn: b.triangles_drawn,
            stamps: b.stamps,
            samples_covered: b.samples_covered,
            pixels_shaded: b.pixels_shaded,
            pixels_visible: b.pixels_visible,
            ..self
        }
    }

    fn with_details(self, d: &DetailCounts) -> Self {
        Self {
            pixels: d.pixels,
            tile_samples: d.tile_samples,
            pixels_shaded_late: d.pixels_shaded_late,
            whole_blocks: d.whole_blocks,
            stamps_alone: d.stamps_alone,
            set_ups: d.set_ups,
            steps: d.steps,
            clusters_won: d.clusters_won,
            shadings: d.shadings,
            shadings_by_plane: d.shadings_by_plane,
            shadings_colored: if d.vertices_colored > 0 { d.shadings } else { 0 },
            pixels_colored: d.pixels_colored,
            vertices_colored: d.vertices_colored,
            entries_drawn: d.entries_drawn,
            bytes_read: d.bytes_read,
            ..self
        }
    }
}

impl TileWork {
    fn from_tile(tile: &tally::TileWork) -> Self {
        let tiles = u64::from(tile.details.pixels > 0);
        let tiles_used = u64::from(tile.details.tile_samples > 0);
        let counters = Counters { tiles, tiles_used, ..Counters::default() };
        let counters = counters.with_back_end(&tile.counts).with_details(&tile.details);
        Self { counters, is_shared: tile.is_shared }
    }
}

/// Counts a frame, or the part of it that the settings select, drawn with these settings on `threads` threads, whose
/// number decides how large tiles are, and which of them all threads draw together.
///
/// # Errors
/// What makes the frame impossible to draw.
pub fn count(
    scene: &Scene,
    camera: &Camera,
    settings: &Settings,
    threads: usize,
) -> Result<Counted, PredictError> {
    count_into(scene, camera, settings, threads, &mut Frame::default())
}

/// [`count`] that also returns the picture, in `frame`.
///
/// # Errors
/// What makes the frame impossible to draw.
pub fn count_into(
    scene: &Scene,
    camera: &Camera,
    settings: &Settings,
    threads: usize,
    frame: &mut Frame,
) -> Result<Counted, PredictError> {
    let counted = tally::count_into(scene, camera, settings, threads, frame)?;
    let sum = Counters::from_stats(&counted.stats).with_details(&counted.details);
    let mut tiles: Vec<TileWork> = counted.tiles.iter().map(TileWork::from_tile).collect();
    if counted.stats.backend.clusters_hidden > 0 {
        let stamps = occlusion::stamps(scene, camera, settings, threads)?;
        for (tile, stamps) in tiles.iter_mut().zip(stamps) {
            let c = &mut tile.counters;
            c.hidden_stamps = stamps * c.clusters_hidden / (c.clusters_hidden + c.clusters_drawn).max(1);
        }
    }
    let of_tiles = |of: fn(&Counters) -> u64| tiles.iter().map(|tile| of(&tile.counters)).sum();
    let frame = Counters {
        bytes_touched: counted.bytes_touched,
        shadings_colored: of_tiles(|c| c.shadings_colored),
        hidden_stamps: of_tiles(|c| c.hidden_stamps),
        ..sum
    };
    Ok(Counted { frame, tiles })
}
