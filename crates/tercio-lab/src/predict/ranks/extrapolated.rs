//! More ranks than are counted one by one: each term of the frame goes on as it did between two counted numbers of ranks.

use serde::Serialize;

use super::renderer::RanksFrame;
use super::{MOST_RANKS, Picture, Plan, predict};
use crate::machines::Machine;
use crate::predict::PredictError;

/// The numbers of ranks that are counted.
const COUNTED: [usize; 2] = [MOST_RANKS / 4, MOST_RANKS];

/// A frame of more than [`MOST_RANKS`] ranks; seconds of rank 0.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ExtrapolatedFrame {
    /// How they share it.
    pub plan: Plan,
    /// The numbers of ranks that were counted.
    pub counted: [usize; 2],
    /// The parts of the frame, in their order.
    pub terms: Vec<Term>,
}

/// A part of the frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Term {
    /// One of [`RanksFrame::PHASES`].
    pub name: &'static str,
    /// Seconds with the counted numbers of ranks.
    pub counted: [f64; 2],
    /// It is proportional to this power of the number of ranks: from -1, work that is divided evenly, to 1, work for each rank.
    pub exponent: f64,
    /// Seconds with all ranks.
    pub seconds: f64,
}

impl Term {
    fn new(name: &'static str, counted: [f64; 2], ranks: usize) -> Self {
        let [fewer, more] = counted;
        let doublings = |from: usize, to: usize| (to as f64 / from as f64).log2();
        let exponent = match () {
            () if more <= 0.0 => 0.0,
            () if fewer <= 0.0 => 1.0,
            () => ((more / fewer).log2() / doublings(COUNTED[0], COUNTED[1])).clamp(-1.0, 1.0),
        };
        let seconds = more * (exponent * doublings(COUNTED[1], ranks)).exp2();
        Self { name, counted, exponent, seconds }
    }

    /// Does it take noticeably longer with more ranks?
    pub fn grows(&self) -> bool {
        self.exponent >= 0.01
    }
}

impl ExtrapolatedFrame {
    /// Seconds until rank 0 has the picture.
    pub fn total(&self) -> f64 {
        self.terms.iter().map(|term| term.seconds).sum()
    }

    fn new(plan: Plan, counted: &[RanksFrame; 2]) -> Self {
        let terms = counted[0].phases().into_iter().zip(counted[1].phases());
        let term = |((name, fewer), (_, more))| Term::new(name, [fewer, more], plan.ranks);
        Self { plan, counted: COUNTED, terms: terms.map(term).collect() }
    }
}

/// Predicts a frame of a plan that has more than [`MOST_RANKS`] ranks, where that is the only reason for which [`predict`] does not.
///
/// # Errors
/// As [`predict`].
///
/// # Panics
/// If there is another reason.
pub fn extrapolate(
    machine: &Machine,
    picture: &Picture,
    plan: &Plan,
) -> Result<ExtrapolatedFrame, PredictError> {
    let of = |ranks| -> Result<RanksFrame, PredictError> {
        let frame = predict(machine, picture, &Plan { ranks, ..*plan })?;
        Ok(frame.unwrap_or_else(|reason| panic!("{ranks} of {} ranks are not counted: {reason}", plan.ranks)))
    };
    if machine.processors.per_node.is_some() {
        machine.may_have(plan.ranks * plan.threads.max(1))?;
    }
    let [fewer, more] = COUNTED;
    Ok(ExtrapolatedFrame::new(*plan, &[of(fewer)?, of(more)?]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn terms_go_on_as_they_did() {
        let at = |counted, ranks| Term::new("drawing", counted, ranks);
        // Four times the ranks: half, as long, twice as long.
        assert_eq!(at([4.0, 2.0], 4096).seconds, 1.0);
        assert_eq!(at([3.0, 3.0], 1 << 20).seconds, 3.0);
        assert_eq!(at([1.0, 2.0], 16384).seconds, 8.0);
        assert!(at([1.0, 2.0], 4096).grows() && !at([2.0, 1.0], 4096).grows());
        // Nothing is divided among more than all, and nothing is done more than once for each rank.
        assert_eq!([at([64.0, 1.0], 2048).exponent, at([1.0, 64.0], 2048).exponent], [-1.0, 1.0]);
        assert_eq!([at([0.0, 1.0], 2048).seconds, at([1.0, 0.0], 2048).seconds], [2.0, 0.0]);
        // There is no step.
        let next = at([5.0, 3.0], MOST_RANKS + 1).seconds;
        assert!((next / 3.0 - 1.0).abs() < 1e-3, "{next}");
    }
}
