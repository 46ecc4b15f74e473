//! Who draws what, and where work is redistributed.

mod rounds;
mod sort_first;
mod sort_last;

use std::fmt;
use std::sync::Arc;

use rayon::{ThreadPool, ThreadPoolBuilder};
use serde::Serialize;
use tercio_raster::binning::Sorted;
use tercio_raster::{Frame, Outputs, Part, RenderError, Renderer, Settings, TileSet};
use tercio_scene::{Camera, Instance, Scene};

use crate::comm::Communicator;
use crate::composite::collect::clear;
use crate::regions::Regions;
use crate::report::RankReport;
use crate::{ParallelError, report::Stage};

/// Where work is redistributed between ranks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Organisation {
    /// Before the front end: every rank draws the clusters that reach its regions, and only there.
    SortFirst,
    /// After the back end: every rank draws a share of the clusters, and the pictures are composited.
    SortLast,
}

impl Organisation {
    /// The name on the command line and in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::SortFirst => "sort-first",
            Self::SortLast => "sort-last",
        }
    }
}

impl fmt::Display for Organisation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A rank's renderer and threads, kept from frame to frame.
#[derive(Debug)]
pub struct Rank {
    pool: Arc<ThreadPool>,
    renderer: Renderer,
    /// Memory for the keys of a picture whose settings do not request keys.
    keys: Vec<u64>,
    /// The fragments that this rank drew, if fragments are composited.
    fragments: Frame,
    /// What it draws them from.
    sorted: Sorted,
}

/// The input of a frame, the same on all ranks.
#[derive(Clone, Copy, Debug)]
pub struct Task<'a> {
    /// How ranks share it.
    pub organisation: Organisation,
    /// The whole scene. Its meshes are in shared memory here; a rank reads only the parts of them that it draws.
    pub scene: &'a Scene,
    /// The camera.
    pub camera: &'a Camera,
    /// The settings. The organisation chooses the parts: those in the settings are ignored. Bands, and frames that keep
    /// samples, are refused.
    pub settings: &'a Settings,
}

impl Rank {
    /// A rank that draws with this many threads, at least 1.
    ///
    /// # Errors
    /// [`ParallelError::Threads`].
    pub fn new(threads: usize) -> Result<Self, ParallelError> {
        let pool = ThreadPoolBuilder::new().num_threads(threads.max(1)).build();
        let pool = pool.map_err(|source| ParallelError::Threads { threads, source })?;
        Ok(Self::from_pool(Arc::new(pool)))
    }

    /// A rank that draws with the threads of a pool. Calls from one of these threads draw without waking another.
    pub fn from_pool(pool: Arc<ThreadPool>) -> Self {
        Self {
            pool,
            renderer: Renderer::new(),
            keys: Vec::new(),
            fragments: Frame::default(),
            sorted: Sorted::default(),
        }
    }

    /// Its threads. Calls from one of them draw without waking another.
    pub fn pool(&self) -> Arc<ThreadPool> {
        self.pool.clone()
    }

    /// Does this rank's part of a frame; all ranks of the communicator have to do theirs. On rank 0 `frame` is then
    /// the picture, with the bytes that one renderer gives; elsewhere it is memory for the next frame.
    ///
    /// # Errors
    /// [`ParallelError`] if this rank fails, or another one is gone.
    pub fn draw_into(
        &mut self,
        comm: &mut impl Communicator,
        task: &Task,
        frame: &mut Frame,
    ) -> Result<RankReport, ParallelError> {
        let before = comm.traffic();
        let mut report = RankReport { rank: comm.rank(), ..RankReport::default() };
        task.settings.check()?;
        refuse_parts(task.settings)?;
        let regions = Regions {
            width: task.settings.width,
            height: task.settings.height,
            edge: region_edge(task.scene, task.settings),
            ranks: comm.size(),
            numbers: [0, u64::MAX],
        };
        match task.organisation {
            // A filter that is wider than a pixel draws further pixels, which are counted by their keys.
            _ if comm.size() == 1 && task.settings.sampling.halo() == 0 => {
                self.draw_alone(task, frame, &mut report)?
            }
            Organisation::SortFirst => sort_first::draw(self, comm, task, &regions, frame, &mut report)?,
            Organisation::SortLast => sort_last::draw(self, comm, task, &regions, frame, &mut report)?,
        }
        if comm.rank() == 0 && !task.settings.outputs.keys {
            self.keys = std::mem::take(&mut frame.planes.keys);
        }
        report.traffic = comm.traffic().since(before);
        Ok(report)
    }

    /// Draws everything: the only rank needs no keys.
    fn draw_alone(
        &mut self,
        task: &Task,
        frame: &mut Frame,
        report: &mut RankReport,
    ) -> Result<(), ParallelError> {
        self.draw_planes(task, (Part::WHOLE, TileSet::ALL), task.settings.outputs, frame, report)?;
        report.pixels.visible = report.frame.backend.pixels_visible;
        Ok(())
    }

    /// Draws a part, with keys.
    fn draw_part(
        &mut self,
        task: &Task,
        part: (Part, TileSet),
        frame: &mut Frame,
        report: &mut RankReport,
    ) -> Result<(), ParallelError> {
        if frame.planes.keys.is_empty() {
            frame.planes.keys = std::mem::take(&mut self.keys);
        }
        let outputs = Outputs { keys: true, ..task.settings.outputs };
        self.draw_planes(task, part, outputs, frame, report)
    }

    fn draw_planes(
        &mut self,
        task: &Task,
        (clusters, tiles): (Part, TileSet),
        outputs: Outputs,
        frame: &mut Frame,
        report: &mut RankReport,
    ) -> Result<(), ParallelError> {
        // Tiles are the regions: the same for every rank, however many threads it has.
        let tile_size = Some(region_edge(task.scene, task.settings));
        let settings = Settings { clusters, tiles, outputs, tile_size, ..task.settings.clone() };
        let Self { pool, renderer, .. } = self;
        report.clusters = clusters.range(clusters_of(task.scene)).len() as u64;
        let (stage, drawn) = pool.install(|| {
            let mut stage = Stage::default();
            let drawn = stage.time(|| renderer.render_into(task.scene, task.camera, &settings, frame));
            (stage, drawn)
        });
        drawn?;
        report.stages.draw = stage;
        report.frame = frame.stats.clone();
        Ok(())
    }
}

/// May anything in the scene not be opaque?
fn is_translucent(scene: &Scene) -> bool {
    scene.instances.iter().any(Instance::is_translucent)
}

/// Pixels along the edge of the regions of a frame. Smaller ones for what is not opaque: memory has to hold all fragments of a
/// region.
pub(crate) fn region_edge(scene: &Scene, settings: &Settings) -> u32 {
    let edge = settings.tile_edge();
    if settings.tile_size.is_none() && is_translucent(scene) { edge.min(32) } else { edge }
}

/// Fills the regions of other ranks with the background: of these, only drawn pixels are sent.
fn clear_others(
    comm: &impl Communicator,
    regions: &Regions,
    task: &Task,
    frame: &mut Frame,
    report: &mut RankReport,
) {
    let others = (0..regions.owners()).filter(|&rank| rank != comm.rank());
    report.stages.collect.time(|| {
        for region in others.flat_map(|rank| regions.of(rank)) {
            clear(frame, &region, &task.scene.background);
        }
    });
}

/// Ranks draw whole pictures.
fn refuse_parts(settings: &Settings) -> Result<(), RenderError> {
    let refused = |what, value: String| {
        Err(RenderError::Setting { what, range: "not set: ranks draw whole pictures".into(), value })
    };
    match &settings.band {
        Some(band) => refused("band", format!("{band:?}")),
        None if settings.unresolved => refused("unresolved", "true".into()),
        None if settings.keep_fragments => refused("keep_fragments", "true".into()),
        None => Ok(()),
    }
}

/// This rank's share of clusters or tiles.
fn share(comm: &impl Communicator) -> Part {
    Part { number: comm.rank() as u32, of: comm.size() as u32 }
}

/// Number of clusters of all instances; if there are too many to number, the renderer returns an error.
fn clusters_of(scene: &Scene) -> u32 {
    let clusters = scene.instances.iter().map(|i| i.mesh.clusters().len()).sum::<usize>();
    u32::try_from(clusters).unwrap_or(u32::MAX)
}
