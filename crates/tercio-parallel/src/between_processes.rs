//! Ranks that are processes: each of them calls [`draw_frame`] with its own communicator.

use std::time::Instant;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use tercio_raster::Frame;

use crate::agreement::{agree, agree_to_choose};
use crate::clock::{clocks_ahead, machine_clock, now};
use crate::comm::{Communicator, Kind, Observed, PartnerTraffic};
use crate::organisation::{Rank, Task, tile_edge};
use crate::report::FrameReport;
use crate::trace::{Step, Trace};
use crate::{ParallelError, RankReport};

/// What a rank reports to rank 0.
#[derive(Serialize, Deserialize)]
struct TimedReport {
    /// When it began, by the [clock of its machine](machine_clock).
    began: Option<u64>,
    report: RankReport,
}

/// Draws a frame together with the other ranks, which have to call this with the same task. On rank 0 `frame` is then
/// the picture, with the bytes that one renderer gives, and the report of all ranks is returned; the others get
/// `None`.
///
/// The ranks' reports are sent after the frame, as JSON: neither their messages nor their time count. The frame's
/// time begins with the first rank on rank 0's machine.
///
/// Before it is drawn, the ranks compare their tasks.
///
/// # Errors
/// [`ParallelError`] if this rank fails, or another one is gone; on rank 0 [`ParallelError::Differs`] if the tasks are not the
/// same.
pub fn draw_frame(
    own: &mut Rank,
    comm: &mut impl Communicator,
    task: &Task,
    frame: &mut Frame,
) -> Result<Option<FrameReport>, ParallelError> {
    let came = machine_clock();
    let mut agreeing = Observed::new(comm, Kind::Agreement);
    let number = own.frames().wrapping_add(1);
    own.timed(Step::Agree, number, || agree(&mut agreeing, task))?;
    let agreed = agreeing.finish();
    let (begin, began) = (Instant::now(), machine_clock());
    let mut report = own.draw_into(comm, task, frame)?;
    let since_own = begin.elapsed().as_secs_f64() * 1e3;
    if own.tells_partners() {
        report.add_partners(agreed);
    } else {
        report.partners = Vec::new();
    }
    let mut telling = Observed::new(comm, Kind::Report);
    let told = own.timed(Step::Report, number, || tell(&mut telling, TimedReport { began, report }))?;
    let Some(mut all) = told else { return Ok(None) };
    if own.tells_partners() {
        // The senders could not count these.
        for with in telling.finish() {
            let PartnerTraffic { partner, kind, traffic } = with;
            all[partner].report.add_partners([PartnerTraffic {
                partner: 0,
                kind,
                traffic: traffic.reversed(),
            }]);
            all[0].report.partners.push(with);
        }
        all[0].report.add_partners([]);
    }
    let earlier = match came.zip(began) {
        Some((came, began)) => began - first(came, began, all.iter().filter_map(|told| told.began)),
        None => 0,
    };
    let milliseconds = since_own + earlier as f64 * 1e-6;
    let ranks: Vec<RankReport> = all.into_iter().map(|told| told.report).collect();
    let region = tile_edge(task.scene, task.settings, task.sharing.organisation, ranks.len());
    let report = FrameReport::new(task.sharing, region, task.settings, milliseconds, ranks);
    frame.stats = report.stats();
    Ok(Some(report))
}

/// Waits until all ranks have called this, and compares what they are going to draw, before they choose together how they share
/// it: `how` says how they choose, and must not be that of a rank that chooses in another way. The sharing of the task has no
/// meaning. A rank that calls [`draw_frame`] instead differs, too, and no rank waits for ever.
///
/// # Errors
/// On rank 0 [`ParallelError::Differs`]; [`ParallelError::Comm`].
pub fn compare(comm: &mut impl Communicator, task: &Task, how: &str) -> Result<(), ParallelError> {
    agree_to_choose(comm, task, how)
}

/// Gathers the values of all ranks, in their order, on rank 0; the others get `None`. They are sent as JSON, and all
/// ranks have to call this.
///
/// # Errors
/// [`ParallelError::Report`] if a value cannot be written or parsed, and an error if a rank is gone.
pub fn tell<T: Serialize + DeserializeOwned>(
    comm: &mut impl Communicator,
    own: T,
) -> Result<Option<Vec<T>>, ParallelError> {
    let rank = comm.rank();
    let written = if rank == 0 { Ok(Vec::new()) } else { serde_json::to_vec(&own) };
    let messages =
        comm.gather(comm.size(), written.map_err(|source| ParallelError::Report { rank, source })?)?;
    if rank > 0 {
        return Ok(None);
    }
    let read = |(rank, message): (usize, Vec<u8>)| {
        serde_json::from_slice(&message).map_err(|source| ParallelError::Report { rank, source })
    };
    let others = (1..).zip(messages).map(read);
    std::iter::once(Ok(own)).chain(others).collect::<Result<Vec<T>, _>>().map(Some)
}

/// Gathers what all ranks did when on rank 0, by its clock, and ends the recording ([`Rank::record`]); the others get `None`. All
/// ranks have to call this, after their frames.
///
/// # Errors
/// [`ParallelError`] if a rank is gone, or its answer is not valid.
pub fn gather_trace(own: &mut Rank, comm: &mut impl Communicator) -> Result<Option<Trace>, ParallelError> {
    let ahead = clocks_ahead(comm, now)?;
    let Some(mut ranks) = tell(comm, own.take_timeline())? else { return Ok(None) };
    ranks.iter_mut().zip(ahead).for_each(|(rank, ahead)| rank.shift(ahead));
    Ok(Some(Trace { ranks }))
}

/// When the first rank began. If ranks share processors, rank 0 may be the last, but no rank begins before rank 0 has
/// reached the barrier: any earlier time is of another machine's clock.
fn first(came: u64, began: u64, others: impl Iterator<Item = u64>) -> u64 {
    others.filter(|other| (came..began).contains(other)).min().unwrap_or(began)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_begins_with_the_first_rank_of_the_machine() {
        let first = |others: &[u64]| first(100, 200, others.iter().copied());
        assert_eq!(first(&[]), 200);
        assert_eq!(first(&[300, 180, 150]), 150);
        // Clocks of other machines.
        assert_eq!(first(&[7, 190]), 190);
        assert_eq!(first(&[99, 1 << 60]), 200);
    }
}
