//! Sort-last: ranks share the clusters, pixels are composited by direct send.
//!
//! Rank r of n draws consecutive clusters, the r-th of n shares: neighbours in space, so that they cover a small part
//! of the picture. Its pixels are sent to the owners of regions with their keys, and from there to rank 0.
//!
//! If pixels have several samples, these are sent instead of pixels, and rank 0 makes the picture from them.

use tercio_raster::{Frame, Outputs, Part, Settings, TileSet, resolve_into};

use super::{Rank, Task, clusters_of, share};
use crate::comm::Communicator;
use crate::composite::collect::collect;
use crate::composite::direct_send::compose;
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
    if task.settings.sampling.pattern.count() > 1 {
        return draw_samples(own, comm, task, regions, (part, sees), frame, report);
    }
    own.draw_part(task, (part, TileSet::ALL), frame, report)?;
    let planes = Outputs { keys: true, ..task.settings.outputs };
    compose(comm, regions, &planes, sees, frame, report)?;
    collect(comm, regions, &task.settings.outputs, frame, report)
}

/// The same for pixels with several samples.
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
    own.draw_part(&samples_task, (part, TileSet::ALL), &mut samples, report)?;
    compose(comm, &regions, &planes, sees, &mut samples, report)?;
    collect(comm, &regions, &planes, &mut samples, report)?;
    if comm.rank() == 0 {
        report.stages.collect.time(|| resolve_into(&samples, task.scene, task.settings, frame));
        frame.stats = samples.stats.clone();
    }
    own.samples = samples;
    Ok(())
}
