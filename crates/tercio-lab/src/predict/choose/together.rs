//! All ranks of a job choose the same.

use std::time::Instant;

use tercio_parallel::comm::{CommError, Communicator};
use tercio_parallel::organisation::Task;
use tercio_parallel::{Organisation, ParallelError, Sharing, between_processes};

use super::candidates::Limits;
use super::network::{self, Network, Source};
use super::{Choice, Job, choose};
use crate::predict::PredictError;
use crate::predict::ranks::{Picture, RanksError};

/// On what each rank runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Resources {
    /// Threads of each rank.
    pub threads: usize,
    /// Processors of all ranks together.
    pub processors: usize,
}

/// Chooses how the ranks of a communicator share a frame. All of them have to call this with the same picture and limits: first
/// they compare these, then rank 0 measures the messages between some of them and chooses, and all learn its choice. Rank 0 alone
/// returns the reasons.
///
/// # Errors
/// On rank 0 [`ParallelError::Differs`] if the ranks would draw different pictures, or choose in different ways, as one of them
/// does that was started with an organisation. [`PredictError`] if the limits leave no candidate, or the picture cannot be drawn;
/// [`ParallelError::Comm`].
pub fn choose_together(
    comm: &mut impl Communicator,
    picture: &Picture,
    resources: Resources,
    limits: &Limits,
) -> Result<(Sharing, Option<Choice>), RanksError> {
    let ranks = comm.size();
    let Picture { scene, camera, settings } = *picture;
    // The organisation is not compared, because there is none yet.
    let task = Task { sharing: Organisation::SortMiddle.into(), scene, camera, settings };
    between_processes::compare(comm, &task, &format!("auto {limits:?}"))?;
    // Before anybody waits: all have the same limits, and fail alike.
    let candidates = limits.candidates(ranks).map_err(PredictError::from)?;
    let begin = Instant::now();
    let measured = network::measure(comm).map_err(ParallelError::from)?;
    let measuring = begin.elapsed().as_secs_f64();
    let mut choice = None;
    let mut own = u64::MAX;
    if comm.rank() == 0 {
        // Alone there are no messages.
        let none = Network { latency: 0.0, bandwidth: f64::INFINITY, source: Source::Constants };
        let network = measured.unwrap_or(none);
        let Resources { threads, processors } = resources;
        let job = Job { ranks, threads, processors, network };
        let chosen = Choice { measuring, ..choose(picture, job, limits)? };
        own = candidates.iter().position(|one| *one == chosen.sharing()).map_or(0, |number| number as u64);
        choice = Some(chosen);
    }
    let all = comm.all_gather(own.to_le_bytes().to_vec()).map_err(ParallelError::from)?;
    let sharing = number(all.first()).and_then(|number| candidates.get(number));
    let Some(sharing) = sharing else {
        let reason = format!("it chose none of the {} ways to share a frame", candidates.len());
        return Err(ParallelError::from(CommError::Transport { rank: 0, reason }).into());
    };
    Ok((*sharing, choice))
}

fn number(block: Option<&Vec<u8>>) -> Option<usize> {
    let bytes: [u8; 8] = block?.as_slice().try_into().ok()?;
    usize::try_from(u64::from_le_bytes(bytes)).ok()
}
