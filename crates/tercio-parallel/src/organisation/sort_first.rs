//! Sort-first: ranks share the picture.
//!
//! Every rank tests all clusters, culls those whose bounds reach none of its regions, and draws the others, only
//! there. Finished pixels are sent to rank 0.

use tercio_raster::{Frame, Part, TileSet};

use super::{Rank, Task, clear_others};
use crate::comm::Communicator;
use crate::composite::collect::collect;
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
    // A rank that owns no region has nothing to do.
    if comm.rank() >= regions.owners() {
        return Ok(());
    }
    let tiles = TileSet::every(comm.size() as u32, comm.rank() as u32, regions.count() as usize);
    own.draw_part(task, (Part::WHOLE, tiles), frame, report)?;
    if comm.rank() == 0 {
        clear_others(comm, regions, task, frame, report);
    }
    collect(comm, regions, &task.settings.outputs, frame, report)
}
