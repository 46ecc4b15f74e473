//! What a frame amounts to, counted without the renderer.
//!
//! What a vertex's place on the screen is, what clipping leaves of a triangle and the bounds that a cluster has on the
//! screen are the renderer's. Everything else is counted here by its definition: which clusters go whole into which
//! tiles, which samples a triangle covers and how near it is there, what hides what, which pixels are shaded how often.
//! So equal numbers mean something.
//!
//! | module | what |
//! |---|---|
//! | [`triangle`] | samples and depth of a triangle |
//! | [`front_end`] | clusters and triangles into the tiles |
//! | [`tile`] | one tile, front to back |
//! | [`whole`] | a whole cluster into a tile |
//! | [`boxes`] | the triangles as boxes of samples, for organisations of ranks |

pub mod boxes;
mod front_end;
mod tile;
mod triangle;
mod whole;

use rayon::prelude::*;
use serde::Serialize;
use tercio_raster::{FrameStats, LastStage, Settings};
use tercio_scene::{Camera, Scene};

use super::PredictError;
use front_end::{Bins, Frame};

/// Tiles with fewer entries than this are never shared between threads.
const LEAST_SHARED: usize = 64;

/// Counts of a frame. Those of [`Counters::comparable`] the renderer counts, too, with the same meaning.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Counters {
    /// Clusters of the scene.
    pub clusters: u64,
    /// Clusters outside the view volume.
    pub clusters_outside: u64,
    /// Clusters that show only the side that is culled.
    pub clusters_facing: u64,
    /// Clusters between the samples of the picture.
    pub clusters_no_sample: u64,
    /// Clusters sorted as a whole.
    pub clusters_whole: u64,
    /// Their entries in tiles.
    pub cluster_entries: u64,
    /// Triangles of the scene.
    pub triangles: u64,
    /// Vertices of clusters that are taken apart.
    pub vertices_apart: u64,
    /// Triangles of clusters that are taken apart.
    pub triangles_apart: u64,
    /// Triangles, or pieces that clipping leaves of them, sorted by themselves.
    pub triangles_binned: u64,
    /// Their entries in tiles.
    pub entries: u64,
    /// Tiles of the picture.
    pub tiles: u64,
    /// Tiles with an entry.
    pub tiles_used: u64,
    /// Entries of both kinds of the fullest tile.
    pub largest_tile: u64,
    /// Clusters that lay behind what was drawn before them, in each tile.
    pub clusters_hidden: u64,
    /// Clusters drawn, in each tile.
    pub clusters_drawn: u64,
    /// Their vertices.
    pub vertices: u64,
    /// Their triangles.
    pub triangles_in: u64,
    /// Those of them that hold a sample of the tile in their box.
    pub triangles_drawn: u64,
    /// Stamps of 16 samples tested against triangles that are not drawn 16 at a time.
    pub stamps: u64,
    /// Samples covered, hidden or not.
    pub samples_covered: u64,
    /// Pixels shaded, some more than once.
    pub pixels_shaded: u64,
    /// Pixels that show a triangle.
    pub pixels_visible: u64,
    /// Pixels of the picture.
    pub pixels: u64,
    /// Samples of the tiles with an entry, whole ones at the picture's border, too.
    pub tile_samples: u64,
    /// Of the shaded pixels those that are shaded when a tile is finished.
    pub pixels_shaded_late: u64,
    /// Of these the blocks of 4x4 that show one triangle, which is fetched once.
    pub whole_blocks: u64,
    /// Of `stamps` those of triangles drawn by themselves.
    pub stamps_alone: u64,
    /// Sixteens of small triangles set up.
    pub set_ups: u64,
    /// Samples looked at, of 16 small triangles side by side.
    pub steps: u64,
    /// Clusters that won a pixel, in each tile.
    pub clusters_won: u64,
    /// Sixteens of pixels shaded at once.
    pub shadings: u64,
    /// Of these the ones of clusters whose normals may point to the other side than their triangles.
    pub shadings_by_plane: u64,
    /// Pixels shaded, each fetched by itself, whose colour stands at vertices or triangles.
    pub pixels_colored: u64,
    /// Vertices with a colour, of clusters that won a pixel, in each tile.
    pub vertices_colored: u64,
    /// Entries of triangles drawn.
    pub entries_drawn: u64,
    /// Bytes of cache lines of the clusters drawn, in each tile.
    pub bytes_read: u64,
    /// Bytes of model and bins that the frame touches, each once.
    pub bytes_touched: u64,
}

/// A frame and its tiles.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Counted {
    /// Everything.
    pub frame: Counters,
    /// What each tile amounts to, in the order of the tiles; nothing of the front end.
    pub tiles: Vec<TileWork>,
}

/// The back end's work on one tile.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct TileWork {
    /// Its counts.
    pub counters: Counters,
    /// All threads draw it together.
    pub is_shared: bool,
}

/// Bytes of a cluster's head.
const HEAD_BYTES: u64 = size_of::<tercio_mesh::cluster::Cluster>() as u64;
/// Bytes of a triangle in the bins.
const TRIANGLE_BYTES: u64 = size_of::<tercio_raster::binning::ScreenTriangle>() as u64;
/// Bytes of an entry of a triangle: with its tile as it comes, then sorted.
const ENTRY_BYTES: u64 = (size_of::<(u32, u32)>() + size_of::<u32>()) as u64;
/// Bytes of an entry of a cluster, likewise.
const CLUSTER_ENTRY_BYTES: u64 = (size_of::<(u32, tercio_raster::binning::BinnedCluster)>()
    + size_of::<tercio_raster::binning::BinnedCluster>()) as u64;

impl Counters {
    /// Those that the renderer counts, too, by name.
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

    /// The renderer's counters under the names of [`Counters::comparable`].
    pub fn counted(stats: &FrameStats) -> [(&'static str, u64); 22] {
        let (f, bins, b) = (&stats.frontend, &stats.binning, &stats.backend);
        Self {
            clusters: f.clusters_in,
            clusters_outside: f.clusters_outside,
            clusters_facing: f.clusters_facing,
            clusters_no_sample: f.clusters_no_sample,
            clusters_whole: bins.clusters,
            cluster_entries: bins.cluster_entries,
            triangles: f.triangles_in,
            vertices_apart: f.vertices_transformed,
            triangles_binned: bins.triangles,
            entries: bins.entries,
            tiles: bins.tiles,
            tiles_used: bins.tiles_used,
            largest_tile: bins.largest_tile,
            clusters_hidden: b.clusters_hidden,
            clusters_drawn: b.clusters_drawn,
            vertices: b.vertices_transformed,
            triangles_in: b.triangles_in,
            triangles_drawn: b.triangles_drawn,
            stamps: b.stamps,
            samples_covered: b.samples_covered,
            pixels_shaded: b.pixels_shaded,
            pixels_visible: b.pixels_visible,
            ..Self::default()
        }
        .comparable()
    }

    /// Adds what a part of the work counted. What only all parts together know, the bins and the bytes touched, is not
    /// added.
    fn add(&mut self, o: &Self) {
        self.tiles += o.tiles;
        self.tiles_used += o.tiles_used;
        self.pixels += o.pixels;
        self.tile_samples += o.tile_samples;
        self.whole_blocks += o.whole_blocks;
        self.stamps_alone += o.stamps_alone;
        self.shadings_by_plane += o.shadings_by_plane;
        self.pixels_colored += o.pixels_colored;
        self.vertices_colored += o.vertices_colored;
        self.entries_drawn += o.entries_drawn;
        self.clusters += o.clusters;
        self.clusters_outside += o.clusters_outside;
        self.clusters_facing += o.clusters_facing;
        self.clusters_no_sample += o.clusters_no_sample;
        self.triangles += o.triangles;
        self.vertices_apart += o.vertices_apart;
        self.triangles_apart += o.triangles_apart;
        self.clusters_hidden += o.clusters_hidden;
        self.clusters_drawn += o.clusters_drawn;
        self.vertices += o.vertices;
        self.triangles_in += o.triangles_in;
        self.triangles_drawn += o.triangles_drawn;
        self.stamps += o.stamps;
        self.samples_covered += o.samples_covered;
        self.pixels_shaded += o.pixels_shaded;
        self.pixels_visible += o.pixels_visible;
        self.pixels_shaded_late += o.pixels_shaded_late;
        self.set_ups += o.set_ups;
        self.steps += o.steps;
        self.clusters_won += o.clusters_won;
        self.shadings += o.shadings;
        self.bytes_read += o.bytes_read;
    }
}

/// Counts a frame, or the part of it that the settings ask for, that is drawn with these settings on some threads. (Threads change it only where a tile holds so much
/// of the work that all threads draw it together.)
///
/// # Errors
/// A camera that makes no view.
pub fn count(
    scene: &Scene,
    camera: &Camera,
    settings: &Settings,
    threads: usize,
) -> Result<Counted, PredictError> {
    let settings = &Settings { tile_size: Some(settings.tile_edge_for(threads)), ..settings.clone() };
    let frame = Frame::new(scene, camera, settings)?;
    let mut sum = Counters::default();
    let bins = front_end::sort(&frame, &mut sum);
    let tiles: Vec<TileWork> = (0..bins.tiles())
        .into_par_iter()
        .map(|number| {
            if !frame.draws(number) {
                return TileWork::default();
            }
            let is_shared = is_shared(&frame, &bins, number, threads);
            let counters = match is_shared {
                true => tile::draw_shared(&frame, &bins, number, threads),
                false => tile::draw(&frame, &bins, number),
            };
            TileWork { counters, is_shared }
        })
        .collect();
    tiles.iter().for_each(|t| sum.add(&t.counters));
    sum.tiles = bins.tiles() as u64;
    sum.bytes_touched = bins.bytes_drawn(&frame)
        + sum.clusters * HEAD_BYTES
        + sum.cluster_entries * CLUSTER_ENTRY_BYTES
        + sum.triangles_binned * TRIANGLE_BYTES
        + sum.entries * ENTRY_BYTES;
    Ok(Counted { frame: sum, tiles })
}

/// Do all threads draw this tile together?
fn is_shared(frame: &Frame, bins: &Bins, tile: usize, threads: usize) -> bool {
    let work = || (0..bins.tiles()).map(|t| bins.fill(t)).sum::<usize>();
    threads > 1
        && frame.settings.last_stage > LastStage::Bin
        && bins.fill(tile) > LEAST_SHARED
        && bins.fill(tile) > work() / (2 * threads)
}

#[cfg(test)]
mod tests;
