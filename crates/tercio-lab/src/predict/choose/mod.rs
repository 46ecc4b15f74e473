//! Chooses how ranks share a frame: `--organisation auto`.
//!
//! All [candidates] are predicted from what is known before anything is drawn: which tiles some of the clusters may reach
//! ([`tercio_raster::survey`]), the costs of work of the laboratory's machine ([`rates`]), and the [cost of messages](network),
//! measured between processes. A frame is five terms, each a formula over ranks and tiles, not a simulation of messages: choosing
//! among a thousand ranks takes some dozens of milliseconds.
//!
//! | module | what |
//! |---|---|
//! | [`candidates`] | what is compared |
//! | [`rates`] | seconds of work |
//! | [`network`] | seconds of messages |
//! | [`wires`] | messages inside nodes and between them |
//! | [`tiles`] | what groups of ranks have in which tiles |
//! | [`sights`] | a picture in tiles of each size, looked at once |
//! | [`frame`] | the frame of a candidate |
//! | [`compose`] | of which: compositing |
//! | [`terms`] | stages on processors and ports |
//! | [`together`] | all ranks of a job choose the same |

pub mod candidates;
pub mod compose;
pub mod frame;
pub mod network;
pub mod rates;
pub mod sights;
pub mod terms;
pub mod tiles;
pub mod together;
pub mod wires;

use std::time::Instant;

use serde::Serialize;
use tercio_parallel::{Composition, Division, Organisation, Sharing};
use tercio_scene::Instance;

use super::PredictError;
use super::frame::waking;
use super::ranks::Picture;
use crate::machines::{self, Machine, MachineError};
use candidates::Limits;
use network::Network;
use rates::Rates;
use sights::Sights;
use terms::{Stage, Sums, Terms};

/// The machine of the laboratory whose costs are used.
pub const MACHINE: &str = "two-core-2026";

/// Ranks, and on what they run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Job {
    /// Ranks, at least 1.
    pub ranks: usize,
    /// Threads of each.
    pub threads: usize,
    /// Processors of all ranks together.
    pub processors: usize,
    /// Messages between them.
    pub network: Network,
}

/// A candidate, predicted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Predicted {
    /// How ranks share the frame.
    pub sharing: Sharing,
    /// Seconds.
    pub terms: Terms,
    /// Messages and bytes of all ranks.
    pub sent: Sums,
}

/// All candidates, and why the first was chosen.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// Ranks, and on what they run.
    pub job: Job,
    /// The fastest first; of equally fast ones that which comes first among the candidates.
    pub candidates: Vec<Predicted>,
    /// Seconds that choosing took, without measuring the network.
    pub seconds: f64,
    /// Seconds that measuring the network took.
    pub measuring: f64,
    /// How many tiles and parts of tiles were looked at.
    pub steps: u64,
}

impl Choice {
    /// How ranks are to share the frame.
    pub fn sharing(&self) -> Sharing {
        self.candidates.first().map_or(Organisation::SortMiddle.into(), |first| first.sharing)
    }
}

/// The machine whose costs are used.
///
/// # Errors
/// None for the built-in one.
pub fn machine() -> Result<Machine, MachineError> {
    machines::load(MACHINE)
}

/// Predicts all candidates. The result is a function of the arguments, except for the times that it took.
///
/// # Errors
/// [`PredictError`]: no candidate fits the limits; a picture that cannot be drawn.
pub fn choose(picture: &Picture, job: Job, limits: &Limits) -> Result<Choice, PredictError> {
    let begin = Instant::now();
    let candidates = limits.candidates(job.ranks)?;
    let translucent = picture.scene.instances.iter().any(Instance::is_translucent);
    let machine = machine()?;
    let rates = Rates::of(&machine, picture.settings, translucent);
    let (threads, processors) = (job.threads.max(1) as f64, job.processors.max(1) as f64);
    let share = 1.0 / threads.min(processors);
    let waking = waking(&machine, job.threads);
    let stage = Stage { rates: &rates, wires: job.network.into(), share, processors, waking };
    let mut sights = Sights::new(picture, job.ranks);
    let mut predicted = sights.predict(&candidates, &stage)?;
    let steps = sights.steps;
    predicted.sort_by(|a, b| a.terms.total().total_cmp(&b.terms.total()));
    let seconds = begin.elapsed().as_secs_f64();
    Ok(Choice { job, candidates: predicted, seconds, measuring: 0.0, steps })
}

/// The parts of a candidate that have a meaning for this many ranks.
pub fn parts_of(sharing: &Sharing, ranks: usize) -> (Option<usize>, Option<Division>, Option<Composition>) {
    let organisation = sharing.organisation;
    let group = matches!(organisation, Organisation::SortTwice { .. }).then(|| organisation.group(ranks));
    let division = (organisation != Organisation::SortLast).then_some(sharing.division);
    let composites = matches!(organisation, Organisation::SortLast | Organisation::SortTwice { .. });
    (group, division, composites.then_some(sharing.composition))
}

#[cfg(test)]
mod tests;
