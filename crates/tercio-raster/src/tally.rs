//! How the back end counts its work: as little as statistics show, or all that predictions are made of.
//!
//! The kernels count into a [`Tally`]. [`BackEndCounts`] is the one that pictures are drawn with. [`FullTally`] counts
//! finer things besides; where it is not asked for, nothing of it is compiled in. Counts are the same at every SIMD
//! level, so the kernels that fill it are compiled at one level only, the one that every processor of the target has.
//!
//! [`count`] draws a frame with it, divided among any number of workers: work is dealt out as to so many threads,
//! whatever the number of threads that do it.

use fearless_simd::{Level, Simd, dispatch};
use tercio_mesh::cluster::{Cluster, ClusterView};
use tercio_scene::{Camera, Scene};

use crate::RenderError;
use crate::backend::corners::ColorSource;
use crate::backend::{self, TileTask, shade};
use crate::binning::{Sorted, TileSet};
use crate::context::FrameContext;
use crate::frame::Frame;
use crate::renderer::Renderer;
use crate::settings::Settings;
use crate::simd::{LANES, baseline};
use crate::stats::{BackEndCounts, FrameStats};

/// What the back end counts with.
pub trait Tally: Default + Send {
    /// What the tallies of the tiles of a frame come to.
    type Frame: Default + Send;

    /// What is always counted.
    fn counts(&mut self) -> &mut BackEndCounts;

    /// The whole tally, for what is counted in full only; always `None` where that is off.
    fn full(&mut self) -> Option<&mut FullTally>;

    /// Draws a tile, or a part of it, at a SIMD level.
    fn draw(level: Level, task: TileTask) -> Self;

    /// The sum of shares of one tile.
    fn plus(self, o: Self) -> Self;

    /// A frame's tally, of one tile that all workers shared or one drew alone.
    fn into_frame(self, tile: u32, is_shared: bool) -> Self::Frame;

    /// Both together.
    fn join(a: Self::Frame, b: Self::Frame) -> Self::Frame;

    /// What is always counted, in all tiles of a frame.
    fn sum(frame: &Self::Frame) -> BackEndCounts;
}

impl Tally for BackEndCounts {
    type Frame = Self;

    #[inline(always)]
    fn counts(&mut self) -> &mut Self {
        self
    }

    #[inline(always)]
    fn full(&mut self) -> Option<&mut FullTally> {
        None
    }

    fn draw(level: Level, task: TileTask) -> Self {
        dispatch!(level, simd => backend::draw_tile(simd, task))
    }

    fn plus(self, o: Self) -> Self {
        self.plus(o)
    }

    fn into_frame(self, _: u32, _: bool) -> Self {
        self
    }

    fn join(a: Self, b: Self) -> Self {
        a.plus(b)
    }

    fn sum(frame: &Self) -> BackEndCounts {
        *frame
    }
}

/// All that is counted while a tile is drawn.
#[derive(Clone, Debug, Default)]
pub struct FullTally {
    /// What is always counted.
    pub counts: BackEndCounts,
    /// Finer counts.
    pub details: DetailCounts,
    /// Numbers of the clusters that were drawn; of a tile that workers share, one may stand here several times.
    pub clusters: Vec<u32>,
}

/// Counts of the back end that are finer than [`BackEndCounts`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct DetailCounts {
    /// Pixels of the tiles that are drawn.
    pub pixels: u64,
    /// Samples of the tiles with an entry, whole ones at the picture's border, too.
    pub tile_samples: u64,
    /// Pixels shaded when a tile is finished.
    pub pixels_shaded_late: u64,
    /// Of these the blocks of 4x4 that show one triangle, which is fetched once.
    pub whole_blocks: u64,
    /// Of the stamps those of triangles drawn by themselves.
    pub stamps_alone: u64,
    /// Sixteens of small triangles set up.
    pub set_ups: u64,
    /// Samples looked at, of 16 small triangles side by side.
    pub steps: u64,
    /// Clusters that won a pixel, in each tile.
    pub clusters_won: u64,
    /// Sixteens of pixels shaded with the cluster that won them.
    pub shadings: u64,
    /// Of these the ones that need the triangles' planes.
    pub shadings_by_plane: u64,
    /// Pixels shaded when a tile is finished, each fetched by itself, whose colour stands at vertices or triangles.
    pub pixels_colored: u64,
    /// Vertices of clusters that won a pixel, in each tile, whose colour stands at vertices or triangles.
    pub vertices_colored: u64,
    /// Entries of triangles drawn.
    pub entries_drawn: u64,
    /// Bytes of cache lines of the clusters drawn, in each tile.
    pub bytes_read: u64,
}

impl DetailCounts {
    /// Sums.
    pub fn plus(self, o: Self) -> Self {
        Self {
            pixels: self.pixels + o.pixels,
            tile_samples: self.tile_samples + o.tile_samples,
            pixels_shaded_late: self.pixels_shaded_late + o.pixels_shaded_late,
            whole_blocks: self.whole_blocks + o.whole_blocks,
            stamps_alone: self.stamps_alone + o.stamps_alone,
            set_ups: self.set_ups + o.set_ups,
            steps: self.steps + o.steps,
            clusters_won: self.clusters_won + o.clusters_won,
            shadings: self.shadings + o.shadings,
            shadings_by_plane: self.shadings_by_plane + o.shadings_by_plane,
            pixels_colored: self.pixels_colored + o.pixels_colored,
            vertices_colored: self.vertices_colored + o.vertices_colored,
            entries_drawn: self.entries_drawn + o.entries_drawn,
            bytes_read: self.bytes_read + o.bytes_read,
        }
    }
}

impl FullTally {
    /// Counts the picture's part of a tile, and the tile's memory if it has entries.
    pub(crate) fn tile(&mut self, context: &FrameContext, tile: u32, is_used: bool) {
        let (x, y) = context.grid.corner(tile);
        let edge = 1u32 << context.grid.shift;
        let across = edge.min(context.view.width - x);
        let down = edge.min(context.view.height - y);
        self.details.pixels += u64::from(across) * u64::from(down);
        self.details.tile_samples += u64::from(is_used) * u64::from(edge) * u64::from(edge);
    }

    /// Counts a cluster that is drawn.
    pub(crate) fn cluster(&mut self, number: u32, cluster: &ClusterView) {
        self.details.bytes_read += bytes(cluster);
        self.clusters.push(number);
    }

    /// Counts the shading of the pixels that a cluster won.
    pub(crate) fn winners(&mut self, context: &FrameContext, number: u32, pixels: usize) {
        if pixels == 0 {
            return;
        }
        let (instance, cluster) = context.cluster(number);
        let shadings = pixels.div_ceil(LANES) as u64;
        self.details.clusters_won += 1;
        self.details.shadings += shadings;
        if shade::needs_plane(context, instance, cluster.head().normals_agree()) {
            self.details.shadings_by_plane += shadings;
        }
        if is_colored(context, instance) {
            self.details.vertices_colored += cluster.vertices() as u64;
        }
    }

    /// Counts pixels of an instance that are shaded when a tile is finished: a whole block, or one fetched by itself.
    pub(crate) fn late(&mut self, context: &FrameContext, instance: usize, pixels: u64, is_block: bool) {
        self.details.pixels_shaded_late += pixels;
        if is_block {
            self.details.whole_blocks += 1;
        } else if is_colored(context, instance) {
            self.details.pixels_colored += pixels;
        }
    }
}

/// Do the colours of an instance stand at its vertices or triangles?
fn is_colored(context: &FrameContext, instance: usize) -> bool {
    let instance = &context.scene.instances[instance];
    ColorSource::of(&instance.mesh, &instance.surface) != ColorSource::Base
}

/// Bytes of the cache lines that drawing a cluster touches.
fn bytes(cluster: &ClusterView) -> u64 {
    let colors = cluster.vertex_colors().map_or(0, size_of_val);
    (size_of_val(cluster.hot_lines()) + colors) as u64
}

impl Tally for FullTally {
    type Frame = Vec<(u32, bool, Self)>;

    #[inline(always)]
    fn counts(&mut self) -> &mut BackEndCounts {
        &mut self.counts
    }

    #[inline(always)]
    fn full(&mut self) -> Option<&mut Self> {
        Some(self)
    }

    fn draw(_: Level, task: TileTask) -> Self {
        let simd = baseline();
        simd.vectorize(
            #[inline(always)]
            || backend::draw_tile(simd, task),
        )
    }

    fn plus(mut self, o: Self) -> Self {
        self.counts = self.counts.plus(o.counts);
        self.details = self.details.plus(o.details);
        self.clusters.extend(o.clusters);
        self
    }

    fn into_frame(self, tile: u32, is_shared: bool) -> Self::Frame {
        vec![(tile, is_shared, self)]
    }

    fn join(mut a: Self::Frame, b: Self::Frame) -> Self::Frame {
        a.extend(b);
        a
    }

    fn sum(frame: &Self::Frame) -> BackEndCounts {
        frame.iter().map(|tile| tile.2.counts).fold(BackEndCounts::default(), BackEndCounts::plus)
    }
}

/// The back end's work on one tile.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TileWork {
    /// What is always counted.
    pub counts: BackEndCounts,
    /// Finer counts.
    pub details: DetailCounts,
    /// All workers draw it together.
    pub is_shared: bool,
}

/// A frame's work.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Counted {
    /// As of a frame that is drawn; its times are of no use.
    pub stats: FrameStats,
    /// Finer counts of the back end.
    pub details: DetailCounts,
    /// Bytes of model and bins that the frame touches, each once.
    pub bytes_touched: u64,
    /// All tiles of the picture, row by row; those that are not drawn have no work.
    pub tiles: Vec<TileWork>,
}

/// Counts the work of a frame, or of the part of it that the settings ask for, divided among some workers, at least one,
/// by drawing it. The picture is thrown away.
///
/// # Errors
/// As [`Renderer::render`].
pub fn count(
    scene: &Scene,
    camera: &Camera,
    settings: &Settings,
    workers: usize,
) -> Result<Counted, RenderError> {
    count_into(scene, camera, settings, workers, &mut Frame::default())
}

/// [`count`] for those who want the picture, too: drawn into the memory of an older one.
///
/// # Errors
/// As [`Renderer::render`]; the frame is then as it was.
pub fn count_into(
    scene: &Scene,
    camera: &Camera,
    settings: &Settings,
    workers: usize,
    frame: &mut Frame,
) -> Result<Counted, RenderError> {
    let context = FrameContext::new(scene, camera, settings, workers)?;
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
        // Each is taken once.
        let drawn = drawn.into_iter().filter_map(|number| clusters[number as usize].take());
        counted.bytes_touched += drawn.map(|cluster| bytes(&cluster)).sum::<u64>();
    }
    counted.bytes_touched += stats.frontend.clusters_in * size_of::<Cluster>() as u64 + sorted.bytes_used();
    counted.stats = stats;
    Ok(counted)
}
