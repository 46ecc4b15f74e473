//! How far a prediction may be off.

use serde::Serialize;

use super::{Candidate, Frame};
use crate::machines::{Machine, builtin};

/// Relative errors that an interval is wide, to each side.
const WIDTH: f64 = 2.0;

/// Root mean square of predicted over measured time, minus 1, of 1,170 ways to share a frame that formulas predict
/// (docs/laboratory/advice.md): of two to four ranks of one thread, on one machine. Ranks that are counted were not among them; they
/// are taken to be no better.
pub const OF_RANKS: f64 = 0.27;

/// The uncertainty of predictions with the costs of a calibrated machine. What is assumed of another machine that has these costs
/// is the candidates' part: [`Candidate::assumed`].
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Uncertainty {
    /// Root of the mean square of the residuals of its costs.
    pub residual: f64,
    /// The machine that was calibrated, if it is another one.
    pub costs_of: Option<String>,
    /// Whether the residual was not measured with these costs, but is assumed.
    pub is_assumed: bool,
}

impl Uncertainty {
    /// That of a machine's costs, by its calibration, by that of the machine whose costs it has, or as it is assumed; `None` without
    /// any of these: then nobody knows.
    pub fn of(machine: &Machine) -> Option<Self> {
        if let Some(own) = &machine.calibration {
            return Some(Self { residual: own.residual.value, costs_of: None, is_assumed: false });
        }
        let assumed = machine.uncertainty.as_ref()?;
        let name = assumed.costs_of.as_deref();
        let other = name.and_then(|name| builtin(name)?.ok()?.calibration);
        let is_assumed = other.is_none();
        let residual = other.map(|c| c.residual.value).or(assumed.residual.as_ref().map(|r| r.value))?;
        Some(Self { residual, costs_of: name.map(str::to_owned), is_assumed })
    }

    /// Root mean square of predicted over measured time, minus 1, that is assumed of a frame. That of ranks was measured with fitted
    /// costs, so that it contains their residuals.
    pub fn error(&self, frame: &Frame) -> f64 {
        match frame {
            Frame::Threads(_) => self.residual,
            Frame::Counted(_) | Frame::Formulas { .. } => self.residual.max(OF_RANKS),
        }
    }

    /// Seconds between which a frame lies if its prediction is at most twice that far off, and the numbers that are assumed of the
    /// machine are between their ends; without an upper end, which is then infinite, if it may be too low by all of the frame.
    pub fn interval(&self, candidate: &Candidate) -> [f64; 2] {
        let Candidate { frame, assumed, .. } = candidate;
        let [fast, slow] = assumed.unwrap_or([frame.total(); 2]);
        [self.around(frame, fast)[0], self.around(frame, slow)[1]]
    }

    /// The same for a frame that is predicted as so many seconds, with numbers that are as they are.
    fn around(&self, frame: &Frame, seconds: f64) -> [f64; 2] {
        let off = WIDTH * self.error(frame);
        let most = if off < 1.0 { seconds / (1.0 - off) } else { f64::INFINITY };
        [seconds / (1.0 + off), most]
    }

    /// Whether a candidate may be as fast as another with the same numbers of the machine: as predicted, all at their fast ends, or all
    /// at their slow ones. What is assumed is wrong for both alike.
    pub fn may_be_as_fast(&self, candidate: &Candidate, as_other: &Candidate) -> bool {
        let seconds = |c: &Candidate| {
            let total = c.frame.total();
            let [fast, slow] = c.assumed.unwrap_or([total; 2]);
            [total, fast, slow]
        };
        let mut pairs = seconds(candidate).into_iter().zip(seconds(as_other));
        pairs.any(|(ours, others)| {
            self.around(&candidate.frame, ours)[0] <= self.around(&as_other.frame, others)[1]
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::splits::Split;
    use super::super::{How, ends};
    use super::*;
    use crate::machines::{Calibration, Sourced};
    use crate::predict::choose::terms::{Sums, Terms};
    use crate::predict::frame::FrameTime;

    fn calibration(residual: f64) -> Calibration {
        let share = |value| Sourced::new(value, String::new(), String::new());
        Calibration {
            date: String::new(),
            processor: String::new(),
            version: String::new(),
            frames: Sourced::new(9.0, "9".into(), String::new()),
            residual: share(residual),
            worst_residual: share(0.5),
            spread: share(0.3),
            doubt: None,
        }
    }

    fn of(frame: Frame) -> Candidate {
        let (split, how) = (Split { ranks: 1, threads: 1 }, How::OneProcess { region: 8 });
        Candidate { split, how, frame, assumed: None }
    }

    #[test]
    fn intervals_come_from_the_residuals_and_those_of_formulas_are_wider() {
        let mut machine = builtin("server-128").unwrap().unwrap();
        machine.uncertainty = None;
        assert_eq!(Uncertainty::of(&machine), None);
        machine.calibration = Some(calibration(0.05));
        let uncertainty = Uncertainty::of(&machine).unwrap();
        // Frames of 10 s and of 11 / 0.9 s that are predicted as 11 s are 10 % off.
        let frame = of(Frame::Threads(FrameTime { raster: 11.0, ..FrameTime::default() }));
        let [low, high] = uncertainty.interval(&frame);
        assert!((low - 10.0).abs() < 1e-12 && (high - 11.0 / 0.9).abs() < 1e-12, "{low} {high}");
        let terms = Terms { draw: 11.0, ..Terms::default() };
        let wider = uncertainty.interval(&of(Frame::Formulas { terms, sent: Sums::default() }));
        assert!(wider[0] < low && wider[1] > high, "{wider:?}");
        // Costs that miss by half say nothing of how slow a frame may be.
        let useless = Uncertainty { residual: 0.5, ..uncertainty.clone() };
        assert_eq!(useless.interval(&frame), [5.5, f64::INFINITY]);
        // The ends of what is assumed come first.
        let assumed = Candidate { assumed: Some([5.5, 22.0]), ..frame };
        let [wide_low, wide_high] = uncertainty.interval(&assumed);
        assert!(
            (wide_low - 5.0).abs() < 1e-12 && (wide_high - 22.0 / 0.9).abs() < 1e-12,
            "{wide_low} {wide_high}"
        );
    }

    /// A machine has the residuals of that whose costs it has, as soon as that one has any, and otherwise those assumed; its
    /// own come first.
    #[test]
    fn borrowed_costs_have_the_residuals_of_their_machine() {
        for name in ["server-128", "cluster-64"] {
            let mut machine = builtin(name).unwrap().unwrap();
            let lender = machine.uncertainty.clone().unwrap().costs_of.unwrap();
            let theirs = builtin(&lender).unwrap().unwrap().calibration.map(|c| c.residual.value);
            let stated = machine.uncertainty.clone().unwrap().residual.map(|r| r.value);
            let borrowed = Uncertainty::of(&machine).unwrap();
            assert_eq!(Some(borrowed.residual), theirs.or(stated), "{name}");
            assert!(borrowed.is_assumed == theirs.is_none() && borrowed.costs_of == Some(lender), "{name}");
            machine.uncertainty.as_mut().unwrap().residual = None;
            assert_eq!(Uncertainty::of(&machine).map(|u| u.residual), theirs, "{name}");
            machine.calibration = Some(calibration(0.07));
            let own = Uncertainty { residual: 0.07, costs_of: None, is_assumed: false };
            assert_eq!(Uncertainty::of(&machine), Some(own));
            assert!(ends::ends(&machine).is_some(), "{name}: what is assumed of it");
        }
    }
}
