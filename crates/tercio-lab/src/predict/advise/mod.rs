//! The best way to draw a model on a machine: all that the renderer can do is predicted, the fastest is explained.
//!
//! Candidates are all [splits] of up to so many processors into ranks and threads, each with all ways in which ranks share a
//! frame. Three models predict them, and each candidate says which: threads of one process are counted and charged tile by
//! tile; ranks come from the [formulas](super::choose) behind `--organisation auto`, with the costs and the network of the
//! machine; the best of these that are sort-first or sort-last with the usual division and composition are counted rank by rank,
//! too, and the counted time takes the place of the formula's. Of the best ranks that are counted all sizes of tiles are.
//!
//! The simulator of the sorting classes speaks besides, comparable only with its own figures.
//!
//! | module | what |
//! |---|---|
//! | [`splits`] | ranks and threads that are compared |
//! | [`formulas`] | the formulas, with the costs of a machine |
//! | [`ends`] | assumed numbers of a machine at their ends |
//! | [`uncertainty`] | how far a prediction may be off |
//! | [`explain`] | the advice in words |
//! | [`simulated`] | the simulator's candidates |

pub mod ends;
pub mod explain;
pub mod formulas;
pub mod simulated;
pub mod splits;
pub mod uncertainty;

use serde::Serialize;
use tercio_parallel::{Division, Organisation as RendererOrganisation, Sharing};

use super::PredictError;
use super::choose::terms::{Sums, Terms};
use super::frame::FrameTime;
use super::ranks::renderer::RanksFrame;
use super::ranks::{MOST_RANKS, Picture, Plan, Simulated, TILE_EDGES, predict};
use crate::machines::{Machine, Topology};
use crate::simulators::sorting::{Assignment, Organisation};
use splits::Split;
use uncertainty::Uncertainty;

/// A way to draw, predicted.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    /// Ranks and threads.
    pub split: Split,
    /// How they are used.
    pub how: How,
    /// The prediction.
    pub frame: Frame,
    /// Its seconds with the numbers that are assumed of the machine at their fast and their slow ends, if any are.
    pub assumed: Option<[f64; 2]>,
}

/// How the renderer uses processors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum How {
    /// The threads of one process draw tiles with so many pixels along their edges.
    OneProcess {
        /// Pixels.
        region: u32,
    },
    /// Ranks share the frame.
    Ranks {
        /// How.
        sharing: Sharing,
        /// Pixels along the edges of their tiles, if the renderer does not choose them.
        region: Option<u32>,
    },
}

/// A predicted frame of the renderer.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Frame {
    /// Of threads, counted tile by tile.
    Threads(FrameTime),
    /// Of ranks, counted rank by rank.
    Counted(Box<RanksFrame>),
    /// Of ranks, by formulas.
    Formulas {
        /// Seconds.
        terms: Terms,
        /// Messages and bytes.
        sent: Sums,
    },
}

impl Frame {
    /// Seconds of the frame.
    pub fn total(&self) -> f64 {
        match self {
            Self::Threads(time) => time.total(),
            Self::Counted(frame) => frame.total(),
            Self::Formulas { terms, .. } => terms.total(),
        }
    }

    /// Whether work is counted, tile by tile or rank by rank, instead of estimated by formulas.
    pub fn is_counted(&self) -> bool {
        !matches!(self, Self::Formulas { .. })
    }

    /// The model in words.
    pub fn model(&self) -> &'static str {
        match self {
            Self::Threads(_) => "counted tile by tile",
            Self::Counted(_) => "counted rank by rank",
            Self::Formulas { .. } => "formulas",
        }
    }
}

/// All candidates, and the simulator's.
#[derive(Clone, Debug, PartialEq)]
pub struct Advice {
    /// The fastest first; of equally fast ones that which comes first among the candidates. Empty where [`why_not`] has a reason.
    pub candidates: Vec<Candidate>,
    /// How far the predictions may be off; `None` if neither the machine nor that whose costs it has was calibrated.
    pub uncertainty: Option<Uncertainty>,
    /// Splits that were not predicted, because they have more than [`splits::MOST_BY_FORMULAS`] ranks.
    pub left_out: usize,
}

impl Advice {
    /// The seconds between which a candidate's frame lies, if that is known.
    pub fn interval(&self, candidate: &Candidate) -> Option<[f64; 2]> {
        Some(self.uncertainty.as_ref()?.interval(candidate))
    }

    /// Whether a candidate is not to be told apart from the best one: [`Uncertainty::may_be_as_fast`].
    pub fn is_like_the_best(&self, candidate: &Candidate) -> Option<bool> {
        let best = self.candidates.first()?;
        Some(self.uncertainty.as_ref()?.may_be_as_fast(candidate, best))
    }
}

/// Why a machine has no predictions of the renderer's frames, if so.
pub fn why_not(machine: &Machine) -> Option<Simulated> {
    let (organisation, assignment) = (Organisation::SortFirst, Assignment::Interleaved);
    Plan { organisation, ranks: 1, threads: 1, region: None, assignment, topology: None }
        .by_renderer(machine)
        .err()
}

/// Predicts everything that the renderer can do with up to so many processors of a machine, with another shape of network than
/// the machine's if one is given.
///
/// # Errors
/// [`PredictError`]: the machine may not have so many processors or lacks a cost; a picture that cannot be drawn.
pub fn advise(
    machine: &Machine,
    picture: &Picture,
    processors: usize,
    topology: Option<Topology>,
) -> Result<Advice, PredictError> {
    machine.may_have(processors)?;
    let uncertainty = Uncertainty::of(machine);
    if why_not(machine).is_some() {
        return Ok(Advice { candidates: Vec::new(), uncertainty, left_out: 0 });
    }
    let mut candidates = one_process(machine, picture, processors)?;
    let all = splits::of_ranks(machine, processors);
    let (splits, left_out): (Vec<Split>, Vec<Split>) =
        all.into_iter().partition(|split| split.ranks <= splits::MOST_BY_FORMULAS);
    candidates.extend(formulas::ranks(machine, picture, topology, &splits, None)?);
    sort(&mut candidates);
    if topology.is_none() {
        refine(machine, picture, &mut candidates)?;
    }
    Ok(Advice { candidates, uncertainty, left_out: left_out.len() })
}

/// Threads of one process, with tiles of every size.
fn one_process(
    machine: &Machine,
    picture: &Picture,
    processors: usize,
) -> Result<Vec<Candidate>, PredictError> {
    let mut candidates = Vec::new();
    let of_ends = ends::ends(machine);
    for threads in splits::threads(machine, processors) {
        for region in TILE_EDGES {
            let (time, assumed) =
                ends::on_threads(machine, of_ends.as_ref(), picture, Some(region), threads)?;
            let assumed = assumed.map(|ends| ends.map(|time| time.total()));
            let (split, how) = (Split { ranks: 1, threads }, How::OneProcess { region });
            candidates.push(Candidate { split, how, frame: Frame::Threads(time), assumed });
        }
    }
    Ok(candidates)
}

fn sort(candidates: &mut [Candidate]) {
    candidates.sort_by(|a, b| a.frame.total().total_cmp(&b.frame.total()));
}

/// As many of the best are counted rank by rank, at most: each takes as long as drawing what its ranks draw, one after another.
const REFINED: usize = 8;

/// Counts the best of a formula's candidates that can be counted as long as it is faster than all that are counted already; then, if
/// ranks are the best and nobody requested tiles, the same ranks with tiles of all sizes. Formulas do not predict those: that
/// clusters are transformed in each of their tiles is not in them.
fn refine(machine: &Machine, picture: &Picture, candidates: &mut Vec<Candidate>) -> Result<(), PredictError> {
    for _ in 0..REFINED {
        let is_next = |c: &Candidate| c.frame.is_counted() || c.counted().is_some();
        let Some(best) = candidates.iter_mut().find(|candidate| is_next(candidate)) else { break };
        let Some(plan) = best.counted() else { break };
        let Ok(frame) = predict(machine, picture, &plan)? else { break };
        // Counting moves both ends alike.
        let moved = frame.total() / best.frame.total();
        best.assumed = best.assumed.map(|ends| ends.map(|seconds| seconds * moved));
        best.frame = Frame::Counted(Box::new(frame));
        sort(candidates);
    }
    let Some(counted) = candidates.iter().find(|c| c.frame.is_counted()).cloned() else { return Ok(()) };
    let (Frame::Counted(own), Some(plan)) = (&counted.frame, counted.plan()) else { return Ok(()) };
    if picture.settings.tile_size.is_some() {
        return Ok(());
    }
    for region in TILE_EDGES.into_iter().filter(|&edge| edge != own.region).map(Some) {
        if let (How::Ranks { sharing, .. }, Ok(frame)) =
            (counted.how, predict(machine, picture, &Plan { region, ..plan })?)
        {
            let how = How::Ranks { sharing, region };
            let moved = frame.total() / counted.frame.total();
            let assumed = counted.assumed.map(|ends| ends.map(|seconds| seconds * moved));
            candidates.push(Candidate { how, frame: Frame::Counted(Box::new(frame)), assumed, ..counted });
        }
    }
    sort(candidates);
    Ok(())
}

impl Candidate {
    /// The plan by which its ranks can be counted, if it is a formula's.
    fn counted(&self) -> Option<Plan> {
        if matches!(self.frame, Frame::Formulas { .. }) { self.plan() } else { None }
    }

    /// The plan of its ranks, if there is a model that counts them.
    fn plan(&self) -> Option<Plan> {
        let How::Ranks { sharing, region } = self.how else { return None };
        let organisation = match sharing.organisation {
            RendererOrganisation::SortFirst => Organisation::SortFirst,
            RendererOrganisation::SortLast => Organisation::SortLast,
            _ => return None,
        };
        let divides = organisation == Organisation::SortFirst;
        let usual = if divides {
            sharing.division == Division::default()
        } else {
            sharing.composition == Sharing::from(sharing.organisation).composition
        };
        let Split { ranks, threads } = self.split;
        let assignment = Assignment::Interleaved;
        (usual && ranks <= MOST_RANKS).then_some(Plan {
            organisation,
            ranks,
            threads,
            region,
            assignment,
            topology: None,
        })
    }
}

#[cfg(test)]
mod tests;
