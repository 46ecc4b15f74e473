//! The renderer: executes the stages of a frame.

use std::cmp::Reverse;
use std::ops::Range;
use std::sync::Mutex;
use std::time::Instant;

use fearless_simd::Level;
use rayon::prelude::*;
use tercio_scene::{Camera, Scene};

use crate::backend::tally::Tally;
use crate::backend::{self, Scratch, Stage, TileTask};
use crate::binning::{Bins, Sorted};
use crate::cluster_set::{self, ClusterSet};
use crate::context::FrameContext;
use crate::dispatch;
use crate::error::RenderError;
use crate::frame::{Canvas, FragmentError, FragmentsOfTile, Frame, Outputs};
use crate::frontend;
use crate::screen::TileSet;
use crate::settings::{LastStage, Part, Settings, SimdLevel};
use crate::stats::{BackEndCounts, FrameStats, FrontEndCounts, StageTimes};

/// Batches of clusters per thread: enough to balance the load, few enough that bins stay large.
const BATCHES_PER_THREAD: usize = 8;
/// Approximate minimum number of clusters per batch.
const MIN_BATCH_CLUSTERS: usize = 16;

/// Number of batches into which the front end divides this many clusters; no more workers than this have work.
pub fn batches(clusters: usize, workers: usize) -> usize {
    clusters.div_ceil(MIN_BATCH_CLUSTERS).min(workers * BATCHES_PER_THREAD)
}

/// Only tiles with more entries than this are shared between threads.
const MIN_SHARED_ENTRIES: u64 = 64;

/// Tiles with less of the work than a worker's part of it divided by this are drawn in their order.
const SHORT_TILES: u64 = 8;

/// Draws scenes; reuses its memory from frame to frame. Runs in the rayon pool it is called in.
///
/// A frame is drawn in two halves: [`Renderer::sort`] sorts clusters into the tiles that they may overlap,
/// [`Renderer::draw`] draws any set of tiles from what was sorted, by this renderer or by another one.
/// [`Renderer::render`] is both.
#[derive(Debug, Default)]
pub struct Renderer {
    sorted: Sorted,
    /// One for each thread of the pool, and at least two if there is more than one worker.
    scratch: Vec<Mutex<Scratch>>,
}

impl Renderer {
    /// A renderer that has not allocated memory yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Draws one picture.
    ///
    /// # Errors
    /// [`RenderError`]: an invalid camera or setting, a scene with too many triangles to be numbered, or numbers
    /// outside the range of `f32`.
    pub fn render(
        &mut self,
        scene: &Scene,
        camera: &Camera,
        settings: &Settings,
    ) -> Result<Frame, RenderError> {
        let mut frame = Frame::default();
        self.render_into(scene, camera, settings, &mut frame)?;
        Ok(frame)
    }

    /// Draws one picture into an existing frame, whose memory is reused.
    ///
    /// # Errors
    /// As [`Renderer::render`]; the frame is then unchanged.
    pub fn render_into(
        &mut self,
        scene: &Scene,
        camera: &Camera,
        settings: &Settings,
        frame: &mut Frame,
    ) -> Result<(), RenderError> {
        let begin = Instant::now();
        let context = FrameContext::new(scene, camera, settings, rayon::current_num_threads())?;
        frame.resize(settings);
        let prepared = Instant::now();
        let mut sorted = std::mem::take(&mut self.sorted);
        self.sort(&context, &mut sorted);
        let binned = Instant::now();
        self.draw(&context, &sorted, &TileSet::ALL, frame);
        self.sorted = sorted;
        let milliseconds = |from: Instant, to: Instant| (to - from).as_secs_f64() * 1e3;
        let times = &mut frame.stats.milliseconds;
        times.prepare = milliseconds(begin, prepared);
        times.frontend = milliseconds(prepared, binned);
        times.total = milliseconds(begin, Instant::now());
        Ok(())
    }

    /// The front end: sorts the [`FrameContext::drawn_clusters`] into the tiles of the frame.
    pub fn sort(&mut self, context: &FrameContext, sorted: &mut Sorted) {
        let level = level(context);
        let drawn = context.drawn_clusters.ranges(context.clusters());
        let batches = batches(drawn.iter().map(Range::len).sum(), context.workers);
        sorted.bins.resize_with(batches, Bins::default);
        let shares = cluster_set::divide(&drawn, batches.max(1));
        let both = sorted.bins.par_iter_mut().zip(&shares).with_max_len(1);
        let counts = both.map(|(bins, clusters)| sort_clusters(level, context, clusters, bins));
        sorted.counts = counts.reduce(FrontEndCounts::default, FrontEndCounts::plus);
    }

    /// The counts of the front end alone: sorts the [`FrameContext::drawn_clusters`], a few at a time, and discards the
    /// result, so that memory hardly grows with the scene.
    pub fn count_front_end(context: &FrameContext) -> FrontEndCounts {
        const CLUSTERS_AT_A_TIME: usize = 256;
        let level = level(context);
        let drawn = context.drawn_clusters.ranges(context.clusters());
        let batches = drawn.iter().map(Range::len).sum::<usize>().div_ceil(CLUSTERS_AT_A_TIME).max(1);
        let shares = cluster_set::divide(&drawn, batches);
        let counts = shares
            .par_iter()
            .map_init(Bins::default, |bins, clusters| sort_clusters(level, context, clusters, bins));
        counts.reduce(FrontEndCounts::default, FrontEndCounts::plus)
    }

    /// An estimate of the work in each tile of the frame, in any unit; it depends on nothing but scene, camera, and size
    /// of picture and tiles. It looks at some thousands of clusters, whatever the size of the scene.
    pub fn estimate_load(context: &FrameContext) -> Vec<u64> {
        frontend::estimate_load(context)
    }

    /// Divides the clusters of the scene among `parts` ranks, at least 1, that draw and then composite them: into sets with about the
    /// same work, of which each is compact in the picture, so that little of one is hidden by another and few tiles are of several.
    /// It depends on nothing but scene, camera, and size of picture and tiles; it looks at some thousands of clusters.
    ///
    /// Source: Samanta et al., "Hybrid Sort-First and Sort-Last Parallel Rendering with a Cluster of PCs" (2000).
    pub fn divide_clusters(context: &FrameContext, parts: usize) -> Vec<ClusterSet> {
        frontend::divide_clusters(context, parts)
    }

    /// The back end: draws a set of the frame's tiles from what was sorted into them. The pixels of other tiles keep
    /// their values.
    ///
    /// ```
    /// use tercio_mesh::cluster::{PartitionOptions, partition};
    /// use tercio_raster::context::FrameContext;
    /// use tercio_raster::{Frame, Renderer, Settings, TileSet, binning::Sorted};
    /// use tercio_scene::Scene;
    ///
    /// let mesh = tercio_mesh::builtin::make("builtin:sphere@1k")?;
    /// let scene = Scene::from_mesh(partition(mesh, &PartitionOptions::default()));
    /// let settings = Settings { tile_size: Some(32), ..Settings::new(64, 64) };
    /// let camera = settings.framing().camera_for_scene(&scene);
    /// let expected = Renderer::new().render(&scene, &camera, &settings)?;
    ///
    /// // Four tiles, two of them at a time.
    /// let context = FrameContext::new(&scene, &camera, &settings, 1)?;
    /// let (mut renderer, mut sorted, mut frame) = (Renderer::new(), Sorted::default(), Frame::default());
    /// frame.resize(&settings);
    /// renderer.sort(&context, &mut sorted);
    /// for first in 0..2 {
    ///     renderer.draw(&context, &sorted, &TileSet::every(2, first, 4), &mut frame);
    /// }
    /// assert_eq!(frame.difference(&expected), None);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Panics
    /// If the frame does not have the size and the planes of the settings ([`Frame::resize`]).
    pub fn draw(&mut self, context: &FrameContext, sorted: &Sorted, tiles: &TileSet, frame: &mut Frame) {
        self.draw_tiles::<BackEndCounts>(context, sorted, tiles, frame);
    }

    /// The tiles that the last call of [`Renderer::draw`] or [`Renderer::render`] drew, in any order, and the
    /// [work](BackEndCounts::work) in each.
    pub fn work_of_tiles(&mut self) -> impl Iterator<Item = (u32, u64)> {
        self.scratch.iter_mut().flat_map(|scratch| of(scratch).drawn.iter().copied())
    }

    /// Fills a set of the frame's tiles with the background. The pixels of other tiles keep their values.
    ///
    /// # Panics
    /// If the frame does not have the size and the planes of the settings ([`Frame::resize`]).
    pub fn clear(&self, context: &FrameContext, tiles: &TileSet, frame: &mut Frame) {
        let settings = context.settings;
        let (outputs, background) = (&settings.outputs, &context.scene.background);
        let count = settings.elements_per_pixel();
        let (grid, height) = (&context.grid, settings.height);
        let canvas = Canvas::new(frame, outputs, background, grid, count, height, outputs.linear);
        let tiles = (0..grid.count() as u32).into_par_iter().filter(|&tile| tiles.contains(tile));
        tiles.for_each(|tile| canvas.claim(tile).write_background());
    }

    /// Makes pixels from the fragments that several ranks have drawn of the same frame, each a part of its triangles, with
    /// [`Settings::keep_fragments`]: the picture is the same as if one renderer had drawn everything. Each tile is given at
    /// most once, with the fragments of all ranks; the pixels of other tiles keep their values.
    ///
    /// The settings of this context are those of the ranks, except that they do not keep fragments, and may request keys.
    /// Returns the number of pixels in which something is drawn.
    ///
    /// # Errors
    /// [`FragmentError`] if bytes are not fragments of their tile; some of the other tiles are then not written.
    ///
    /// # Panics
    /// If the frame does not have the size and the planes of the settings ([`Frame::resize`]), or a tile is given twice.
    pub fn merge(
        &mut self,
        context: &FrameContext,
        tiles: &[FragmentsOfTile],
        frame: &mut Frame,
    ) -> Result<u64, FragmentError> {
        let threads = rayon::current_num_threads();
        if self.scratch.len() < threads {
            self.scratch.resize_with(threads, Mutex::default);
        }
        let settings = context.settings;
        let (outputs, background) = (&settings.outputs, &context.scene.background);
        let canvas = Canvas::new(frame, outputs, background, &context.grid, 1, settings.height, true);
        let (level, scratch) = (level(context), &self.scratch[..]);
        let merged = tiles.par_iter().with_max_len(1).map(|tile| {
            let own = rayon::current_thread_index().unwrap_or(0);
            // As in `Tiles::draw`, the lock is free.
            let mut scratch = scratch[own % scratch.len()].lock().unwrap_or_else(|e| e.into_inner());
            dispatch!(level, simd => backend::merge_tile(simd, context, tile, &mut scratch, &canvas))
        });
        merged.try_reduce(|| 0, |sum, pixels| Ok(sum + pixels))
    }

    /// [`Renderer::draw`] with any tally.
    pub(crate) fn draw_tiles<T: DrawTile>(
        &mut self,
        context: &FrameContext,
        sorted: &Sorted,
        tiles: &TileSet,
        frame: &mut Frame,
    ) -> T::Frame {
        let begin = Instant::now();
        let memories = rayon::current_num_threads().max(2.min(context.workers));
        if self.scratch.len() < memories {
            self.scratch.resize_with(memories, Mutex::default);
        }
        self.scratch.iter_mut().for_each(|scratch| of(scratch).drawn.clear());
        let settings = context.settings;
        let count = settings.elements_per_pixel();
        let needs_linear = context.has_fragments() || settings.outputs.linear;
        let canvas = Canvas::new(
            frame,
            &settings.outputs,
            &context.scene.background,
            &context.grid,
            count,
            settings.height,
            needs_linear,
        );
        let work = Tiles { context, sorted, canvas: &canvas, level: level(context) };
        let tallies = work.draw::<T>(tiles, &mut self.scratch[..memories]);
        frame.fragments = canvas.into_fragments();
        let milliseconds = begin.elapsed().as_secs_f64() * 1e3;
        frame.stats = FrameStats {
            frontend: sorted.counts,
            binning: sorted.counts(&context.grid),
            backend: T::sum(&tallies).finish(context.cells.count as u64),
            milliseconds: StageTimes { backend: milliseconds, total: milliseconds, ..StageTimes::default() },
            threads: context.workers,
            simd: settings.simd.unwrap_or_else(SimdLevel::best).name(),
            tile_size: 1 << context.grid.shift,
        };
        tallies
    }
}

impl Frame {
    /// Resizes the planes that the settings request, and empties the others. The values are unspecified.
    pub fn resize(&mut self, settings: &Settings) {
        let rows = settings.rows();
        (self.width, self.height) = (settings.width * settings.elements_per_pixel(), rows.end - rows.start);
        // Fragments are kept instead of planes.
        let outputs = if settings.keep_fragments { Outputs::NONE } else { settings.outputs };
        self.planes.resize(&outputs, self.width as usize * self.height as usize);
    }
}

/// The memory behind a lock that nobody else has.
fn of(scratch: &mut Mutex<Scratch>) -> &mut Scratch {
    scratch.get_mut().unwrap_or_else(|e| e.into_inner())
}

/// A tally that tiles can be drawn with.
pub(crate) trait DrawTile: Tally {
    /// Draws a tile, or a part of it, at a SIMD level.
    fn draw(level: Level, task: TileTask) -> Self;
}

impl DrawTile for BackEndCounts {
    fn draw(level: Level, task: TileTask) -> Self {
        dispatch!(level, simd => backend::draw_tile(simd, task))
    }
}

/// Sorts a range of clusters. One function for all callers, so that the front end is compiled once per SIMD level.
fn sort_clusters(
    level: Level,
    context: &FrameContext,
    clusters: &[Range<u32>],
    bins: &mut Bins,
) -> FrontEndCounts {
    dispatch!(level, simd => frontend::run(simd, context, clusters, bins))
}

/// The SIMD level of a frame. The settings were checked when its context was made.
fn level(context: &FrameContext) -> Level {
    let simd = context.settings.simd.unwrap_or_else(SimdLevel::best);
    simd.level().unwrap_or_else(|| unreachable!("`Settings::check` accepts only levels of this processor"))
}

/// Tiles in the order in which workers draw them, of which each begins with a block of the same number and helps others in the end. Long
/// tiles come first in the blocks, as one that is begun last keeps a worker busy while the others have nothing to do; short ones follow
/// in their order, in which neighbours have clusters in common.
fn in_order(tiles: Vec<u32>, fill: impl Fn(u32) -> u64, workers: usize) -> Vec<u32> {
    if workers <= 1 {
        return tiles;
    }
    let count = tiles.len();
    let limit = tiles.iter().map(|&tile| fill(tile)).sum::<u64>() / (SHORT_TILES * workers as u64);
    let (mut long, short): (Vec<u32>, Vec<u32>) = tiles.into_iter().partition(|&tile| fill(tile) > limit);
    long.sort_by_key(|&tile| Reverse(fill(tile)));
    let (mut ordered, mut short) = (Vec::with_capacity(count), short.into_iter());
    for block in 0..workers {
        ordered.extend(long.iter().skip(block).step_by(workers));
        let end = count * (block + 1) / workers;
        ordered.extend(short.by_ref().take(end.saturating_sub(ordered.len())));
    }
    ordered.extend(short);
    ordered
}

/// The back end's work on one frame.
struct Tiles<'a> {
    context: &'a FrameContext<'a>,
    sorted: &'a Sorted,
    canvas: &'a Canvas<'a>,
    level: Level,
}

impl Tiles<'_> {
    /// Draws a set of tiles: those that hold more than a worker's part of the work one after another, each by all workers
    /// together; the others in parallel, each by one worker, the longest first.
    fn draw<T: DrawTile>(&self, set: &TileSet, scratch: &mut [Mutex<Scratch>]) -> T::Frame {
        let workers = self.context.workers;
        let tiles = self.context.grid.count() as u32;
        let fill = |tile: u32| self.sorted.fill(tile);
        let is_drawn = |tile: &u32| self.context.grid.draws(*tile) && set.contains(*tile);
        let mut alone: Vec<u32> = (0..tiles).filter(is_drawn).collect();
        let mut shared = Vec::new();
        // Layers are not merged: a tile that may have some is drawn by one worker.
        let may_share = workers > 1 && !self.context.is_translucent();
        if may_share && self.context.settings.last_stage > LastStage::Bin {
            let work: u64 = (0..tiles).map(fill).sum();
            let heavy = |tile: &u32| fill(*tile) > MIN_SHARED_ENTRIES.max(work / workers as u64);
            (shared, alone) = alone.into_iter().partition(heavy);
        }
        let tallies = shared.into_iter().map(|tile| {
            let mut tally = self.draw_shared::<T>(tile, scratch);
            of(&mut scratch[0]).drawn.push((tile, tally.counts().work()));
            tally.into_frame(tile, true)
        });
        let tallies = tallies.fold(T::Frame::default(), T::join);
        let scratch = &*scratch;
        let drawn_alone = in_order(alone, fill, workers)
            .into_par_iter()
            .with_max_len(1)
            .map(|tile| {
                let own = rayon::current_thread_index().unwrap_or(0);
                // A thread that draws a tile does nothing else meanwhile, so the lock is free.
                let mut scratch = scratch[own % scratch.len()].lock().unwrap_or_else(|e| e.into_inner());
                let mut tally = self.draw_tile::<T>(tile, Stage::Whole, &mut scratch);
                scratch.drawn.push((tile, tally.counts().work()));
                tally.into_frame(tile, false)
            })
            .reduce(T::Frame::default, T::join);
        T::join(drawn_alone, tallies)
    }

    /// Draws one tile with all workers: each draws a share of the entries into a tile memory of its own. At most as
    /// many shares are drawn at a time as there are tile memories.
    fn draw_shared<T: DrawTile>(&self, tile: u32, scratch: &mut [Mutex<Scratch>]) -> T {
        let workers = self.context.workers;
        let (mut tally, mut drawn) = (T::default(), 0);
        while drawn < workers {
            // From the second round on, the first memory holds the merged result of the rounds before.
            let free = &mut scratch[usize::from(drawn > 0)..];
            let count = free.len().min(workers - drawn);
            let shares = free[..count].par_iter_mut().enumerate().with_max_len(1).map(|(i, scratch)| {
                let part = Part { number: (drawn + i) as u32, of: workers as u32 };
                self.draw_tile::<T>(tile, Stage::Part(part), of(scratch))
            });
            tally = tally.plus(shares.reduce(T::default, T::plus));
            let used = usize::from(drawn > 0) + count;
            drawn += count;
            let mut parts = scratch[..used].iter_mut().map(of);
            let Some(first) = parts.next() else { unreachable!("a pool has at least one thread") };
            parts.for_each(|part| first.merge(self.context, part));
        }
        let first = of(&mut scratch[0]);
        tally.plus(self.draw_tile(tile, Stage::Finish, first))
    }

    fn draw_tile<T: DrawTile>(&self, tile: u32, stage: Stage, scratch: &mut Scratch) -> T {
        let &Tiles { context, sorted, canvas, level } = self;
        T::draw(level, TileTask { context, bins: &sorted.bins, tile, stage, scratch, canvas })
    }
}

#[cfg(test)]
mod tests {
    use super::in_order;

    #[test]
    fn each_worker_begins_with_its_longest_tiles() {
        // Of 160, more than 160 / 8 / 2 are long.
        let fill = |tile: u32| [1, 2, 30, 4, 50, 3, 40, 5, 20, 5][tile as usize];
        assert_eq!(in_order((0..10).collect(), fill, 2), [4, 2, 0, 1, 3, 6, 8, 5, 7, 9]);
        assert_eq!(in_order((0..10).collect(), fill, 1), Vec::from_iter(0..10));
        assert!(in_order(Vec::new(), fill, 4).is_empty());
        for workers in 1..20 {
            let mut all = in_order((0..10).collect(), fill, workers);
            all.sort_unstable();
            assert_eq!(all, Vec::from_iter(0..10), "{workers} workers");
        }
    }
}
