//! Ranks that are processes: each of them calls [`draw_frame`] with its own end of the messages.

use std::time::Instant;

use tercio_raster::Frame;

use crate::comm::Communicator;
use crate::organisation::{Rank, Task};
use crate::report::FrameReport;
use crate::{ParallelError, RankReport};

/// Draws a frame together with the other ranks, which have to call this with the same task. On rank 0 `frame` then is
/// the picture, with the bytes that one renderer gives, and what all ranks did is returned; the others get `None`.
///
/// The ranks' reports travel after the frame, as JSON: neither their messages nor their time count.
///
/// # Errors
/// [`ParallelError`]: what this rank cannot do, or that another one is gone.
pub fn draw_frame(
    own: &mut Rank,
    comm: &mut impl Communicator,
    task: &Task,
    frame: &mut Frame,
) -> Result<Option<FrameReport>, ParallelError> {
    comm.barrier()?;
    let begin = Instant::now();
    let report = own.draw_into(comm, task, frame)?;
    let milliseconds = begin.elapsed().as_secs_f64() * 1e3;
    let rank = comm.rank();
    let written = if rank == 0 { Ok(Vec::new()) } else { serde_json::to_vec(&report) };
    let messages =
        comm.gather(comm.size(), written.map_err(|error| ParallelError::Report { rank, error })?)?;
    if rank > 0 {
        return Ok(None);
    }
    let read = |(rank, message): (usize, Vec<u8>)| {
        serde_json::from_slice(&message).map_err(|error| ParallelError::Report { rank, error })
    };
    let others = (1..).zip(messages).map(read);
    let ranks = std::iter::once(Ok(report)).chain(others).collect::<Result<Vec<RankReport>, _>>()?;
    let report = FrameReport::new(task.organisation, task.settings.tile_edge(), milliseconds, ranks);
    frame.stats = report.stats();
    Ok(Some(report))
}
