//! Sort-last: ranks share the clusters, pixels are composited by direct send.
//!
//! Rank r of n draws consecutive clusters, the r-th of n shares: neighbours in space, so that they cover a small part
//! of the picture. Its pixels are sent to the owners of regions with their keys, and from there to rank 0.
//!
//! If pixels have several samples, or not all is opaque, fragments are sent instead of pixels, and their owners make pixels from
//! them. What is not opaque may have any number of fragments: then that is done in rounds of some tiles each.

use super::rounds::Rounds;
use super::{Rank, Task, clear_others, clusters_of, is_translucent, share};
use crate::comm::Communicator;
use crate::composite::collect::collect;
use crate::composite::direct_send::compose;
use crate::composite::fragments::exchange;
use crate::regions::Regions;
use crate::{ParallelError, RankReport};
use tercio_raster::binning::Sorted;
use tercio_raster::context::FrameContext;
use tercio_raster::frame::fragments::fragment_bytes;
use tercio_raster::{Frame, FrameStats, Outputs, Part, SampleShading, Settings, TileSet};

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
    if task.settings.sampling.pattern.count() > 1 || is_translucent(task.scene) {
        return draw_fragments(own, comm, task, regions, (part, sees), frame, report);
    }
    own.draw_part(task, (part, TileSet::ALL), frame, report)?;
    let planes = Outputs { keys: true, ..task.settings.outputs };
    compose(comm, regions, &planes, sees, frame, report)?;
    collect(comm, regions, &task.settings.outputs, frame, report)
}

/// The rounds for what is not opaque.
fn rounds_of(context: &FrameContext, sorted: &Sorted) -> Rounds {
    let Settings { sampling, outputs, layer_memory, .. } = context.settings;
    let count = sampling.pattern.count();
    let of_pixel = match sampling.shading {
        SampleShading::Sample => count * fragment_bytes(outputs, 1),
        _ => fragment_bytes(outputs, count),
    };
    let bytes = |pixels: u64| pixels.saturating_mul(of_pixel as u64);
    // All of a round may be of one rank, and the owner needs as much again.
    Rounds::new(sorted.layer_pixels(context).into_iter().map(bytes).collect(), *layer_memory as u64 / 2)
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
    let tile_size = Some(regions.edge);
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
    let mut rounds =
        if is_translucent(task.scene) { rounds_of(&context, sorted) } else { Rounds::whole(regions.count()) };
    let takes_part = |rank: usize| sees(rank) || rank < regions.owners();
    let mut stats: Option<FrameStats> = None;
    while let Some(round) = rounds.next(comm, takes_part, &mut report.stages.wait)? {
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
        rounds.found(&round, drawn.iter().map(|of_tile| of_tile.bytes.len() as u64).sum());
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
