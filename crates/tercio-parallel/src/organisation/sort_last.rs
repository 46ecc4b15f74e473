//! Sort-last: ranks share the clusters, pixels are composited by direct send.
//!
//! Rank r of n draws consecutive clusters, the r-th of n shares: neighbours in space, so that they cover a small part
//! of the picture. Its pixels are sent to the owners of regions with their keys, and from there to rank 0.
//!
//! If pixels have several samples, or not all is opaque, fragments are sent instead of pixels, and their owners make pixels from
//! them. What is not opaque may have any number of fragments: then that is done in rounds, so that memory is bounded.

use std::iter;
use std::ops::Range;

use tercio_raster::context::FrameContext;
use tercio_raster::frame::fragments::fragment_bytes;
use tercio_raster::{Frame, FrameStats, Outputs, Part, Settings, TileSet};
use tercio_scene::Instance;

use super::{Rank, Task, clear_others, clusters_of, rounds, share};
use crate::comm::Communicator;
use crate::composite::collect::collect;
use crate::composite::direct_send::compose;
use crate::composite::fragments::exchange;
use crate::regions::Regions;
use crate::{ParallelError, RankReport};

/// A rank's part of a frame.
pub(super) fn draw(
    own: &mut Rank,
    comm: &mut impl Communicator,
    task: &Task,
    regions: &Regions,
    frame: &mut Frame,
    report: &mut RankReport,
) -> Result<(), ParallelError> {
    let part = share(comm);
    let clusters = clusters_of(task.scene);
    let sees = |rank: usize| !Part { number: rank as u32, ..part }.range(clusters).is_empty();
    // A rank that neither draws nor owns anything has nothing to do.
    if !sees(comm.rank()) && comm.rank() >= regions.owners() {
        return Ok(());
    }
    if task.settings.sampling.pattern.count() > 1 || is_translucent(task) {
        return draw_fragments(own, comm, task, regions, (part, sees), frame, report);
    }
    own.draw_part(task, (part, TileSet::ALL), frame, report)?;
    let planes = Outputs { keys: true, ..task.settings.outputs };
    compose(comm, regions, &planes, sees, frame, report)?;
    collect(comm, regions, &task.settings.outputs, frame, report)
}

/// May anything in the scene not be opaque?
fn is_translucent(task: &Task) -> bool {
    task.scene.instances.iter().any(Instance::is_translucent)
}

/// The same for pixels of several samples, or with layers.
fn draw_fragments(
    own: &mut Rank,
    comm: &mut impl Communicator,
    task: &Task,
    regions: &Regions,
    (part, sees): (Part, impl Fn(usize) -> bool),
    frame: &mut Frame,
    report: &mut RankReport,
) -> Result<(), ParallelError> {
    let Task { scene, camera, settings, .. } = *task;
    if frame.planes.keys.is_empty() {
        frame.planes.keys = std::mem::take(&mut own.keys);
    }
    let Rank { pool, renderer, sorted, fragments, .. } = own;
    let threads = pool.current_num_threads();
    // Tiles are the regions, as in `Rank::draw_part`.
    let tile_size = Some(settings.tile_edge());
    let drawing = Settings { clusters: part, keep_fragments: true, tile_size, ..settings.clone() };
    let outputs = Outputs { keys: true, ..settings.outputs };
    let merging = Settings { outputs, tile_size, ..settings.clone() };
    let context = FrameContext::new(scene, camera, &drawing, threads)?;
    let merged = FrameContext::new(scene, camera, &merging, threads)?;
    let owns = comm.rank() < regions.owners();
    if owns {
        frame.resize(&merging);
    }
    fragments.resize(&drawing);
    report.clusters = part.range(clusters_of(scene)).len() as u64;
    let mut stage = report.stages.draw;
    pool.install(|| stage.time(|| renderer.sort(&context, sorted)));
    let mut rounds: Vec<Range<u64>> = iter::once(0..regions.count()).collect();
    if is_translucent(task) {
        let of_pixel = fragment_bytes(&settings.outputs, settings.sampling.pattern.count()) as u64;
        let layers = sorted.layer_pixels(&context).into_iter().map(|pixels| pixels.saturating_mul(of_pixel));
        // All of them may be of one rank.
        let most = settings.layer_memory as u64;
        let takes_part = |rank: usize| sees(rank) || rank < regions.owners();
        rounds = rounds::agree(comm, layers.collect(), most, takes_part, &mut report.stages.wait)?;
    }
    let mut stats: Option<FrameStats> = None;
    for round in rounds {
        let tiles = TileSet::from_fn(context.grid.count(), |tile| round.contains(&tile.into()));
        pool.install(|| stage.time(|| renderer.draw(&context, sorted, &tiles, fragments)));
        stats = Some(match stats {
            None => fragments.stats.clone(),
            Some(mut sum) => {
                sum.backend = sum.backend.plus(fragments.stats.backend);
                sum
            }
        });
        let regions = Regions { numbers: [round.start, round.end], ..*regions };
        let drawn = std::mem::take(&mut fragments.fragments);
        exchange(comm, &regions, &sees, &drawn, (pool, renderer, &merged), frame, report)?;
    }
    report.stages.draw = stage;
    report.frame = stats.unwrap_or_default();
    frame.stats = report.frame.clone();
    if comm.rank() == 0 {
        clear_others(comm, regions, task, frame, report);
    }
    collect(comm, regions, &settings.outputs, frame, report)
}
