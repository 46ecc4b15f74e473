//! Detailed counts of the work of a frame, made by drawing it: the input of performance predictions.
//!
//! [`count`] divides a frame among any number of workers: the work is divided as among that many threads, whatever the
//! number of threads that execute it. Counts are the same at every SIMD level, so the kernels with the full counts are
//! compiled at one level only, the baseline of the target.

use fearless_simd::{Level, Simd};
use tercio_mesh::cluster::{Cluster, ClusterView};
use tercio_scene::{Camera, Scene};

pub use crate::backend::tally::DetailCounts;

use crate::backend::tally::{FullTally, bytes};
use crate::backend::{self, TileTask};
use crate::binning::Sorted;
use crate::context::FrameContext;
use crate::error::RenderError;
use crate::frame::Frame;
pub use crate::renderer::batches;
use crate::renderer::{DrawTile, Renderer};
use crate::screen::TileSet;
use crate::settings::Settings;
use crate::simd::baseline;
use crate::stats::{BackEndCounts, FrameStats};

impl DrawTile for FullTally {
    fn draw(_: Level, task: TileTask) -> Self {
        let simd = baseline();
        simd.vectorize(
            #[inline(always)]
            || backend::draw_tile(simd, task),
        )
    }
}

/// The back end's work on one tile.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TileWork {
    /// The counts of every frame's statistics.
    pub counts: BackEndCounts,
    /// Finer counts.
    pub details: DetailCounts,
    /// Whether all workers draw the tile together.
    pub is_shared: bool,
}

/// A frame's work.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Counted {
    /// The statistics of the frame; the times are not meaningful.
    pub stats: FrameStats,
    /// Finer counts of the back end.
    pub details: DetailCounts,
    /// Bytes of model and bins that the frame touches, each counted once.
    pub bytes_touched: u64,
    /// All tiles of the picture, row by row; the counts of tiles that are not drawn are zero.
    pub tiles: Vec<TileWork>,
}

/// Counts the work of a frame (or of the part of it that the settings select), divided among this many workers (at
/// least one), by drawing it. The picture is discarded.
///
/// # Errors
/// As [`Renderer::render`]; [`RenderError::Setting`] for several samples per pixel and for surfaces that are not opaque,
/// whose work is not counted.
pub fn count(
    scene: &Scene,
    camera: &Camera,
    settings: &Settings,
    workers: usize,
) -> Result<Counted, RenderError> {
    count_into(scene, camera, settings, workers, &mut Frame::default())
}

/// [`count`] that keeps the picture: draws it into an existing frame, whose memory is reused.
///
/// # Errors
/// As [`Renderer::render`]; the frame is then unchanged.
pub fn count_into(
    scene: &Scene,
    camera: &Camera,
    settings: &Settings,
    workers: usize,
    frame: &mut Frame,
) -> Result<Counted, RenderError> {
    let pattern = settings.sampling.pattern;
    if pattern.count() > 1 {
        let range = "1: work is counted for pictures with one sample per pixel".into();
        return Err(RenderError::Setting { what: "samples", range, value: pattern.to_string() });
    }
    let context = FrameContext::new(scene, camera, settings, workers)?;
    if context.is_translucent() {
        let range = "1: work is counted for opaque surfaces".into();
        return Err(RenderError::Setting { what: "opacity", range, value: "less in places".into() });
    }
    frame.resize(settings);
    let (mut renderer, mut sorted) = (Renderer::new(), Sorted::default());
    renderer.sort(&context, &mut sorted);
    let tallies = renderer.draw_tiles::<FullTally>(&context, &sorted, &TileSet::ALL, frame);
    let stats = frame.stats.clone();
    let mut counted =
        Counted { tiles: vec![TileWork::default(); stats.binning.tiles as usize], ..Counted::default() };
    let clusters = scene.instances.iter().flat_map(|instance| instance.mesh.views());
    let mut clusters: Vec<Option<ClusterView>> = clusters.map(Some).collect();
    for (tile, is_shared, FullTally { counts, details, clusters: drawn }) in tallies {
        counted.details = counted.details.plus(details);
        counted.tiles[tile as usize] = TileWork { counts, details, is_shared };
        // `take` makes each cluster count once.
        let drawn = drawn.into_iter().filter_map(|number| clusters[number as usize].take());
        counted.bytes_touched += drawn.map(|cluster| bytes(&cluster)).sum::<u64>();
    }
    counted.bytes_touched += stats.frontend.clusters_in * size_of::<Cluster>() as u64 + sorted.bytes_used();
    counted.stats = stats;
    Ok(counted)
}
