//! Sort-last: ranks share the clusters, pixels are composited by direct send.
//!
//! Rank r of n draws consecutive clusters, the r-th of n shares: neighbours in space, so that they cover a small part
//! of the picture. Its pixels are sent to the owners of regions with their keys, and from there to rank 0.

use tercio_raster::{Frame, Outputs, Part, TileSet};

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
    own.draw_part(task, (part, TileSet::ALL), frame, report)?;
    let planes = Outputs { keys: true, ..task.settings.outputs };
    compose(comm, regions, &planes, sees, frame, report)?;
    collect(comm, regions, &task.settings.outputs, frame, report)
}
