//! One frame, stage after stage.

use std::sync::Mutex;
use std::time::Instant;

use fearless_simd::{Level, dispatch};
use rayon::prelude::*;
use tercio_scene::camera::CameraError;
use tercio_scene::{Camera, Scene};

use crate::backend::output::Planes;
use crate::backend::{self, Scratch, Share};
use crate::binning::TileGrid;
use crate::context::FrameContext;
use crate::frame::Frame;
use crate::frontend::{self, Batch};
use crate::settings::{LastStage, Settings, SimdLevel};
use crate::stats::{BackEndCounts, BinningCounts, FrameStats, FrontEndCounts, StageTimes};
use crate::view::View;

/// Why a picture could not be drawn.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// The camera is not one.
    #[error(transparent)]
    Camera(#[from] CameraError),
    /// A setting is out of its range.
    #[error("{what} must be {range}, is {value}")]
    Setting {
        /// Which setting.
        what: &'static str,
        /// What it may be.
        range: String,
        /// What it is.
        value: String,
    },
    /// More triangles than can be numbered.
    #[error(
        "the scene holds {triangles} triangles in {clusters} clusters; 32 bits do not suffice to number them"
    )]
    TooLarge {
        /// Triangles of all instances.
        triangles: u64,
        /// Clusters of all instances.
        clusters: u64,
    },
    /// A mesh whose coordinates leave `f32` no room to calculate with.
    #[error(
        "the coordinates of instance {instance} reach {largest:e}, and 32-bit floating-point numbers can calculate with \
         2^-60 to 2^60 only: choose another unit of the mesh (clean or Mesh::bring_into_range)"
    )]
    OutOfRange {
        /// Number of the instance.
        instance: usize,
        /// Largest absolute value of a coordinate, in units of the mesh.
        largest: f64,
    },
    /// Distances were asked for that `f32` does not hold.
    #[error(
        "distances up to {farthest:e} do not fit into 32-bit floating-point numbers: scale the model, or ask for no depth"
    )]
    Distances {
        /// The largest distance, world units.
        farthest: f64,
    },
}

/// Batches of clusters a thread: enough that threads finish together, few enough that bins stay large.
const BATCHES_A_THREAD: usize = 8;
/// Fewer clusters than this make no batch of their own.
const LEAST_CLUSTERS: usize = 16;

/// Tiles with fewer entries than this are never shared between threads.
const LEAST_SHARED: u64 = 64;

/// Draws scenes; keeps its memory from frame to frame. Runs in the rayon pool it is called in.
#[derive(Debug, Default)]
pub struct Renderer {
    batches: Vec<Batch>,
    /// One a thread of the pool.
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
        settings.check()?;
        let simd = settings.simd.unwrap_or_else(SimdLevel::best);
        let Some(level) = simd.level() else { unreachable!("checked above") };
        let view = View::new(camera, &scene.bounds(), settings.width, settings.height)?;
        let threads = rayon::current_num_threads();
        let tile_size = settings.tile_edge_for(threads);
        let grid = TileGrid::new(settings.width, settings.height, tile_size, settings.tiles);
        let context = FrameContext::new(scene, settings, view, grid)?;
        frame.resize(settings);

        let drawn = settings.clusters.range(context.clusters());
        let clusters = drawn.len();
        let batches = clusters.div_ceil(LEAST_CLUSTERS).min(threads * BATCHES_A_THREAD);
        self.batches.resize_with(batches, Batch::default);
        if self.scratch.len() < threads {
            self.scratch.resize_with(threads, Mutex::default);
        }
        let prepared = Instant::now();

        self.batches.par_iter_mut().enumerate().with_max_len(1).for_each(|(i, batch)| {
            let share = |i: usize| drawn.start + (clusters * i / batches) as u32;
            let range = share(i)..share(i + 1);
            dispatch!(level, simd => frontend::run(simd, &context, range.clone(), batch));
        });
        let binned = Instant::now();

        let planes = Planes::new(frame, &scene.background);
        let tiles = Tiles { context: &context, batches: &self.batches, planes: &planes, level };
        let backend = tiles.draw(&mut self.scratch);
        drop(planes);
        let drawn = Instant::now();

        let milliseconds = |from: Instant, to: Instant| (to - from).as_secs_f64() * 1e3;
        frame.stats = FrameStats {
            frontend: self
                .batches
                .iter()
                .map(|b| b.counts)
                .fold(FrontEndCounts::default(), FrontEndCounts::plus),
            binning: BinningCounts::of(&self.batches, &grid),
            backend: backend.finish(),
            milliseconds: StageTimes {
                prepare: milliseconds(begin, prepared),
                frontend: milliseconds(prepared, binned),
                backend: milliseconds(binned, drawn),
                total: milliseconds(begin, drawn),
            },
            threads,
            simd: simd.name(),
            tile_size,
        };
        Ok(())
    }
}

/// The back end's work on one frame.
struct Tiles<'a> {
    context: &'a FrameContext<'a>,
    batches: &'a [Batch],
    planes: &'a Planes<'a>,
    level: Level,
}

impl Tiles<'_> {
    /// Draws all tiles: the few that hold a great part of the work one after another, shared by all threads,
    /// the others side by side.
    fn draw(&self, scratch: &mut [Mutex<Scratch>]) -> BackEndCounts {
        let threads = rayon::current_num_threads();
        let tiles = self.context.grid.count() as u32;
        let fill = |tile: u32| self.batches.iter().map(|b| b.bins.fill(tile)).sum::<u64>();
        let mut alone: Vec<u32> = (0..tiles).filter(|&tile| self.context.grid.draws(tile)).collect();
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
                    simd, self.context, self.batches, tile, &mut scratch, self.planes,
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
                    simd, self.context, self.batches, tile, share, scratch, self.planes,
                ))
            })
            .reduce(BackEndCounts::default, BackEndCounts::plus);
        let mut parts = scratch.iter_mut().map(|s| s.get_mut().unwrap_or_else(|e| e.into_inner()));
        let Some(first) = parts.next() else { unreachable!("a pool has a thread") };
        parts.for_each(|part| first.tile.merge(self.context, &part.tile));
        let shaded =
            dispatch!(self.level, simd => backend::finish(simd, self.context, tile, first, self.planes));
        counts.plus(shaded)
    }
}
