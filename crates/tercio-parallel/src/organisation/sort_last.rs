//! Sort-last: ranks share the clusters, pixels are composited by direct send.
//!
//! Rank r of n draws consecutive clusters, the r-th of n shares: neighbours in space, so that they cover a small part
//! of the picture. Its pixels are sent to the owners of regions with their keys, and from there to rank 0.
//!
//! If pixels have several samples, these are sent instead of pixels, and rank 0 makes the picture from them.
//!
//! Of what may not be opaque, the owners get all layers, once the opaque surfaces are composited, and blend them. That is done
//! in rounds, so that memory is bounded.

use tercio_raster::context::FrameContext;
use tercio_raster::frame::layers::layer_bytes;
use tercio_raster::{Frame, FrameStats, Outputs, Part, Settings, TileSet, resolve_into};
use tercio_scene::Instance;

use super::{Rank, Task, clusters_of, rounds, share};
use crate::comm::Communicator;
use crate::composite::collect::collect;
use crate::composite::direct_send::compose;
use crate::composite::layers;
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
        return draw_samples(own, comm, task, regions, (part, sees), frame, report);
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
fn draw_samples(
    own: &mut Rank,
    comm: &mut impl Communicator,
    task: &Task,
    regions: &Regions,
    (part, sees): (Part, impl Fn(usize) -> bool),
    frame: &mut Frame,
    report: &mut RankReport,
) -> Result<(), ParallelError> {
    let Settings { width, height, .. } = *task.settings;
    let wanted = task.settings.outputs;
    let has_color = wanted.color || wanted.color16 || wanted.linear;
    let planes = Outputs { keys: true, linear: has_color, color: false, color16: false, ..wanted };
    let settings = Settings { unresolved: true, outputs: planes, ..task.settings.clone() };
    let columns_per_pixel = settings.elements_per_pixel();
    // Packets number the samples of a picture with 32 bits.
    let samples = u64::from(width) * u64::from(height) * u64::from(columns_per_pixel);
    if samples > 1 << 32 {
        return Err(ParallelError::Samples { width, height, samples: columns_per_pixel });
    }
    let regions = Regions { columns_per_pixel, ..*regions };
    let samples_task = Task { settings: &settings, ..*task };
    let mut samples = std::mem::take(&mut own.samples);
    if is_translucent(task) {
        draw_rounds(own, comm, &samples_task, &regions, (part, sees), &mut samples, report)?;
    } else {
        own.draw_part(&samples_task, (part, TileSet::ALL), &mut samples, report)?;
        compose(comm, &regions, &planes, sees, &mut samples, report)?;
    }
    collect(comm, &regions, &planes, &mut samples, report)?;
    if comm.rank() == 0 {
        report.stages.collect.time(|| resolve_into(&samples, task.scene, task.settings, frame));
        frame.stats = samples.stats.clone();
    }
    own.samples = samples;
    Ok(())
}

/// Draws and composites samples and layers, round by round.
fn draw_rounds(
    own: &mut Rank,
    comm: &mut impl Communicator,
    task: &Task,
    regions: &Regions,
    (part, sees): (Part, impl Fn(usize) -> bool),
    samples: &mut Frame,
    report: &mut RankReport,
) -> Result<(), ParallelError> {
    let Rank { pool, renderer, sorted, .. } = own;
    // Tiles are the regions, as in `Rank::draw_part`.
    let tile_size = Some(task.settings.tile_edge());
    let settings = Settings { clusters: part, separate_layers: true, tile_size, ..task.settings.clone() };
    let context = FrameContext::new(task.scene, task.camera, &settings, pool.current_num_threads())?;
    samples.resize(&settings);
    report.clusters = part.range(clusters_of(task.scene)).len() as u64;
    let mut stage = report.stages.draw;
    pool.install(|| stage.time(|| renderer.sort(&context, sorted)));
    let of_pixel = layer_bytes(&settings.outputs, settings.sampling.pattern.count()) as u64;
    let layers = sorted.layer_pixels(&context).into_iter().map(|pixels| pixels.saturating_mul(of_pixel));
    // All of them may be of one rank.
    let most = settings.layer_memory as u64;
    let takes_part = |rank: usize| sees(rank) || rank < regions.owners();
    let rounds = rounds::agree(comm, layers.collect(), most, takes_part, &mut report.stages.wait)?;
    let mut stats: Option<FrameStats> = None;
    for round in rounds {
        let tiles = TileSet::from_fn(context.grid.count(), |tile| round.contains(&tile.into()));
        pool.install(|| stage.time(|| renderer.draw(&context, sorted, &tiles, samples)));
        stats = Some(match stats {
            None => samples.stats.clone(),
            Some(mut sum) => {
                sum.backend = sum.backend.plus(samples.stats.backend);
                sum
            }
        });
        let regions = Regions { numbers: [round.start, round.end], ..*regions };
        compose(comm, &regions, &settings.outputs, &sees, samples, report)?;
        layers::blend(comm, &regions, &sees, (pool, &context), samples, report)?;
    }
    report.stages.draw = stage;
    report.frame = stats.unwrap_or_default();
    samples.stats = report.frame.clone();
    Ok(())
}
