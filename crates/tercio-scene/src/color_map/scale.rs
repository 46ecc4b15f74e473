//! From values to positions in a colour map.

use tercio_mesh::trig::{exp2, log2};

/// How the range of values is spread over a colour map.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Scale {
    /// Evenly.
    #[default]
    Linear,
    /// By their logarithms. Values of 0 and less are below every range.
    Log,
    /// By their logarithms on both sides of 0, and evenly between minus and plus a threshold above 0, with the same step there as
    /// for the first 10/9 decades beyond (as matplotlib's `SymLogNorm`).
    SymmetricLog {
        /// Values closer to 0 are linear.
        threshold: f64,
    },
}

/// log2(10)
const DECADE: f64 = std::f64::consts::LOG2_10;

/// The length of the linear part of a symmetric logarithm on one side, in decades.
const LINEAR: f64 = 1.0 / (1.0 - 0.1);

impl Scale {
    /// A value on this scale: the number that is spread evenly. NaN for what a logarithm does not have.
    pub fn forward(self, value: f64) -> f64 {
        match self {
            Self::Linear => value,
            Self::Log => log2(value) / DECADE,
            Self::SymmetricLog { threshold } => {
                let size = value.abs() / threshold;
                let decades = if size > 1.0 { LINEAR + log2(size) / DECADE } else { LINEAR * size };
                if value < 0.0 { -decades } else { decades }
            }
        }
    }

    /// The value of a number on this scale: the inverse of [`Scale::forward`].
    pub fn back(self, number: f64) -> f64 {
        match self {
            Self::Linear => number,
            Self::Log => exp2(number * DECADE),
            Self::SymmetricLog { threshold } => {
                let size = number.abs();
                let beyond = || exp2((size - LINEAR) * DECADE);
                let value = threshold * if size > LINEAR { beyond() } else { size / LINEAR };
                if number < 0.0 { -value } else { value }
            }
        }
    }
}
