//! Direct send: every rank sends its pixels of a region straight to the region's owner, which keeps the visible ones.

use tercio_raster::{Frame, Outputs};

use super::packet::{pack, unpack};
use crate::comm::Communicator;
use crate::regions::Regions;
use crate::report::{RankPixels, RankStages};
use crate::{ParallelError, RankReport};

/// Composites the ranks' frames: afterwards every owner has the picture of all ranks in its regions.
///
/// `sees(rank)` returns whether a rank drew anything at all: the others send nothing and are not waited for. All
/// ranks have to agree on it. Every frame has keys; `planes`, which include keys, are sent.
///
/// # Errors
/// [`ParallelError::Comm`], [`ParallelError::Packet`].
pub fn compose(
    comm: &mut impl Communicator,
    regions: &Regions,
    planes: &Outputs,
    sees: impl Fn(usize) -> bool,
    frame: &mut Frame,
    report: &mut RankReport,
) -> Result<(), ParallelError> {
    let (rank, size) = (comm.rank(), comm.size());
    let RankReport { pixels: RankPixels { sent, compared, won, .. }, stages, .. } = report;
    let RankStages { compose, wait, .. } = stages;
    // Every rank begins with the next one, so that no rank gets all messages at once.
    let others = |step: usize| (rank + step) % size;
    if sees(rank) {
        for to in (1..size).map(others).filter(|&to| to < regions.owners()) {
            let mut message = comm.buffer(to);
            *sent += compose.time(|| {
                regions.of(to).map(|region| pack(frame, &region, planes, &mut message)).sum::<u64>()
            });
            comm.send(to, message)?;
        }
    }
    if rank < regions.owners() {
        for from in (1..size).map(|step| others(size - step)).filter(|&from| sees(from)) {
            let message = wait.time(|| comm.receive(from))?;
            let done = compose.time(|| unpack(&message, planes, true, frame));
            let done = done.map_err(|source| ParallelError::Packet { from, source })?;
            *compared += done.pixels;
            *won += done.written;
            comm.give_back(from, message);
        }
    }
    Ok(())
}
