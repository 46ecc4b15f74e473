//! How far a prediction may be off.

use serde::Serialize;

use super::Frame;
use crate::machines::Machine;

/// Relative errors that an interval is wide, to each side.
const WIDTH: f64 = 2.0;

/// Root mean square of predicted over measured time, minus 1, of 500 ways to share a frame that formulas predict
/// (docs/laboratory/advice.md): of two to four ranks of one thread, on one machine. Ranks that are counted were not among them; they
/// are taken to be no better.
pub const OF_RANKS: f64 = 0.22;

/// The uncertainty of predictions with the costs of a calibrated machine.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Uncertainty {
    /// Root of the mean square of the residuals of its costs.
    pub residual: f64,
}

impl Uncertainty {
    /// That of a machine's costs; `None` without a calibration: then nobody knows.
    pub fn of(machine: &Machine) -> Option<Self> {
        machine.calibration.as_ref().map(|c| Self { residual: c.residual.value })
    }

    /// Root mean square of predicted over measured time, minus 1, that is assumed of a frame. That of ranks was measured with fitted
    /// costs, so that it contains their residuals.
    pub fn error(self, frame: &Frame) -> f64 {
        match frame {
            Frame::Threads(_) => self.residual,
            Frame::Counted(_) | Frame::Formulas { .. } => self.residual.max(OF_RANKS),
        }
    }

    /// Seconds between which a frame lies if its prediction is at most twice that far off; without an upper end, which is then infinite,
    /// if it may be too low by all of the frame.
    pub fn interval(self, frame: &Frame) -> [f64; 2] {
        let (seconds, off) = (frame.total(), WIDTH * self.error(frame));
        let most = if off < 1.0 { seconds / (1.0 - off) } else { f64::INFINITY };
        [seconds / (1.0 + off), most]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machines::{Calibration, Sourced, builtin};
    use crate::predict::choose::terms::{Sums, Terms};
    use crate::predict::frame::FrameTime;

    #[test]
    fn intervals_come_from_the_residuals_and_those_of_formulas_are_wider() {
        let mut machine = builtin("server-128").unwrap().unwrap();
        assert_eq!(Uncertainty::of(&machine), None);
        let share = |value| Sourced::new(value, String::new(), String::new());
        machine.calibration = Some(Calibration {
            date: String::new(),
            processor: String::new(),
            version: String::new(),
            frames: Sourced::new(9.0, "9".into(), String::new()),
            residual: share(0.05),
            worst_residual: share(0.5),
            spread: share(0.3),
        });
        let uncertainty = Uncertainty::of(&machine).unwrap();
        // Frames of 10 s and of 11 / 0.9 s that are predicted as 11 s are 10 % off.
        let frame = Frame::Threads(FrameTime { raster: 11.0, ..FrameTime::default() });
        let [low, high] = uncertainty.interval(&frame);
        assert!((low - 10.0).abs() < 1e-12 && (high - 11.0 / 0.9).abs() < 1e-12, "{low} {high}");
        let terms = Terms { draw: 11.0, ..Terms::default() };
        let wider = uncertainty.interval(&Frame::Formulas { terms, sent: Sums::default() });
        assert!(wider[0] < low && wider[1] > high, "{wider:?}");
        // Costs that miss by half say nothing of how slow a frame may be.
        let useless = Uncertainty { residual: 0.5 };
        assert_eq!(useless.interval(&frame), [5.5, f64::INFINITY]);
    }
}
