//! One frame, stage after stage.

use std::sync::Mutex;
use std::time::Instant;

use fearless_simd::{Level, dispatch};
use rayon::prelude::*;
use tercio_scene::{Camera, Scene};

use crate::backend::{self, Scratch, Share};
use crate::binning::{Bins, Sorted, TileSet};
use crate::context::FrameContext;
use crate::error::RenderError;
use crate::frame::{Canvas, Frame};
use crate::frontend;
use crate::settings::{LastStage, Settings, SimdLevel};
use crate::stats::{BackEndCounts, FrameStats, FrontEndCounts, StageTimes};

/// Batches of clusters a thread: enough that threads finish together, few enough that bins stay large.
const BATCHES_A_THREAD: usize = 8;
/// Fewer clusters than this make no batch of their own.
const LEAST_CLUSTERS: usize = 16;

/// Tiles with fewer entries than this are never shared between threads.
const LEAST_SHARED: u64 = 64;

/// Draws scenes; keeps its memory from frame to frame. Runs in the rayon pool it is called in.
///
/// A frame is drawn in two halves: [`Renderer::sort`] takes clusters to the tiles that they may touch,
/// [`Renderer::draw`] draws any set of tiles from what was sorted, here or elsewhere. [`Renderer::render`] is both.
#[derive(Debug, Default)]
pub struct Renderer {
    sorted: Sorted,
    /// One for each thread of the pool.
    scratch: Vec<Mutex<Scratch>>,
}

impl Renderer {
    /// A renderer that holds no memory yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Draws one picture.
    ///
    /// # Errors
    /// A camera or setting that makes no picture, or a scene too large to be numbered.
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

    /// Draws one picture into the memory of an older one.
    ///
    /// # Errors
    /// As [`Renderer::render`]; the frame is then as it was.
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

    /// The front end: sorts the clusters that the frame's settings ask for into its tiles.
    pub fn sort(&mut self, context: &FrameContext, sorted: &mut Sorted) {
        let (level, threads) = (level(context), rayon::current_num_threads());
        let drawn = context.settings.clusters.range(context.clusters());
        let clusters = drawn.len();
        let batches = clusters.div_ceil(LEAST_CLUSTERS).min(threads * BATCHES_A_THREAD);
        sorted.bins.resize_with(batches, Bins::default);
        let counts = sorted.bins.par_iter_mut().enumerate().with_max_len(1).map(|(i, bins)| {
            let share = |i: usize| drawn.start + (clusters * i / batches) as u32;
            let range = share(i)..share(i + 1);
            dispatch!(level, simd => frontend::run(simd, context, range.clone(), bins))
        });
        sorted.counts = counts.reduce(FrontEndCounts::default, FrontEndCounts::plus);
    }

    /// The back end: draws those of the frame's tiles that are in a set, from what was sorted into them. Pixels of other
    /// tiles stay as they are.
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
        let begin = Instant::now();
        let (level, threads) = (level(context), rayon::current_num_threads());
        if self.scratch.len() < threads {
            self.scratch.resize_with(threads, Mutex::default);
        }
        let settings = context.settings;
        let canvas = Canvas::new(frame, &settings.outputs, &context.scene.background, &context.grid);
        let work = Tiles { context, sorted, canvas: &canvas, level };
        let backend = work.draw(tiles, &mut self.scratch);
        drop(canvas);
        let milliseconds = begin.elapsed().as_secs_f64() * 1e3;
        frame.stats = FrameStats {
            frontend: sorted.counts,
            binning: sorted.counts(&context.grid),
            backend: backend.finish(),
            milliseconds: StageTimes { backend: milliseconds, total: milliseconds, ..StageTimes::default() },
            threads,
            simd: settings.simd.unwrap_or_else(SimdLevel::best).name(),
            tile_size: 1 << context.grid.shift,
        };
    }
}

/// The SIMD level of a frame. Settings were checked when its context was made.
fn level(context: &FrameContext) -> Level {
    let simd = context.settings.simd.unwrap_or_else(SimdLevel::best);
    simd.level().unwrap_or_else(|| unreachable!("a level of this processor"))
}

/// The back end's work on one frame.
struct Tiles<'a> {
    context: &'a FrameContext<'a>,
    sorted: &'a Sorted,
    canvas: &'a Canvas<'a>,
    level: Level,
}

impl Tiles<'_> {
    /// Draws the tiles of a set: the few that hold a great part of the work one after another, shared by all threads,
    /// the others side by side.
    fn draw(&self, set: &TileSet, scratch: &mut [Mutex<Scratch>]) -> BackEndCounts {
        let threads = rayon::current_num_threads();
        let tiles = self.context.grid.count() as u32;
        let fill = |tile: u32| self.sorted.fill(tile);
        let is_drawn = |tile: &u32| self.context.grid.draws(*tile) && set.contains(*tile);
        let mut alone: Vec<u32> = (0..tiles).filter(is_drawn).collect();
        let mut shared = Vec::new();
        if threads > 1 && self.context.settings.last_stage > LastStage::Bin {
            let work: u64 = (0..tiles).map(fill).sum();
            let heavy = |tile: &u32| fill(*tile) > LEAST_SHARED.max(work / (2 * threads as u64));
            (shared, alone) = alone.into_iter().partition(heavy);
        }
        let counts = shared.into_iter().map(|tile| self.draw_shared(tile, &mut scratch[..threads]));
        let counts = counts.fold(BackEndCounts::default(), BackEndCounts::plus);
        let scratch = &*scratch;
        alone
            .into_par_iter()
            .with_max_len(1)
            .map(|tile| {
                let own = rayon::current_thread_index().unwrap_or(0);
                // A thread that draws a tile does nothing else meanwhile, so the lock is free.
                let mut scratch = scratch[own % threads].lock().unwrap_or_else(|e| e.into_inner());
                dispatch!(self.level, simd => backend::run(
                    simd, self.context, &self.sorted.bins, tile, &mut scratch, self.canvas,
                ))
            })
            .reduce(BackEndCounts::default, BackEndCounts::plus)
            .plus(counts)
    }

    /// Draws one tile with all threads, each a share of its entries into a tile memory of its own.
    fn draw_shared(&self, tile: u32, scratch: &mut [Mutex<Scratch>]) -> BackEndCounts {
        let of = scratch.len();
        let counts = scratch
            .par_iter_mut()
            .enumerate()
            .with_max_len(1)
            .map(|(part, scratch)| {
                let scratch = scratch.get_mut().unwrap_or_else(|e| e.into_inner());
                let share = Share { part, of };
                dispatch!(self.level, simd => backend::run_share(
                    simd, self.context, &self.sorted.bins, tile, share, scratch, self.canvas,
                ))
            })
            .reduce(BackEndCounts::default, BackEndCounts::plus);
        let mut parts = scratch.iter_mut().map(|s| s.get_mut().unwrap_or_else(|e| e.into_inner()));
        let Some(first) = parts.next() else { unreachable!("a pool has a thread") };
        parts.for_each(|part| first.tile.merge(self.context, &part.tile));
        let shaded =
            dispatch!(self.level, simd => backend::finish(simd, self.context, tile, first, self.canvas));
        counts.plus(shaded)
    }
}
