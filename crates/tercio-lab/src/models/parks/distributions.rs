//! Distributions in the form of appendix C: how many polygons have each height, each number of vertices.

use crate::models;
use crate::models::registry::{Argument, Model, Value};
use crate::units::{Count, Ratio, Segments};

/// Values with the number of times each occurs; the numbers are whole, and there is at least one value.
#[derive(Clone, Debug, PartialEq)]
pub struct Distribution(Vec<(f64, f64)>);

impl Distribution {
    /// A distribution of `(value, times)`.
    ///
    /// # Errors
    /// No values, or a number of times that is not whole.
    pub fn new(entries: Vec<(f64, f64)>) -> Result<Self, String> {
        if let Some(entry) = entries.iter().find(|e| !(e.1 >= 0.0 && e.1.fract() == 0.0 && e.0.is_finite())) {
            return Err(format!(
                "expected a value and a whole number of times, found {} {}",
                entry.0, entry.1
            ));
        }
        let some = entries.iter().any(|e| e.1 > 0.0);
        if some { Ok(Self(entries)) } else { Err("expected at least one value, found none".into()) }
    }

    /// Number of values, counted with their multiplicity.
    pub fn number(&self) -> f64 {
        self.0.iter().map(|e| e.1).sum()
    }

    /// The sum of `of` over all values.
    pub fn sum(&self, of: impl Fn(f64) -> f64) -> f64 {
        self.0.iter().map(|e| of(e.0) * e.1).sum()
    }

    /// The mean.
    pub fn mean(&self) -> f64 {
        self.sum(|v| v) / self.number()
    }

    /// The variance of a whole population, divided by its number.
    pub fn variance(&self) -> f64 {
        let mean = self.mean();
        self.sum(|v| (v - mean) * (v - mean)) / self.number()
    }
}

impl Argument for Distribution {
    const UNIT: &'static str = "list";

    fn form() -> String {
        Vec::<[f64; 2]>::form()
    }

    fn from_value(value: &Value) -> Result<Self, String> {
        let pairs = Vec::<[f64; 2]>::from_value(value)?;
        Self::new(pairs.into_iter().map(|[value, times]| (value, times)).collect())
    }
}

/// The segments that a processor is charged for: a polygon without a scan line on it still costs one. The document does
/// not state the rule; without it the totals of C.3, C.6, C.7 and C.8 are wrong by up to 16,432 cycles, with it all
/// eight agree.
pub fn charged_segments(heights: Distribution) -> Segments {
    Segments::new(heights.sum(|h| h.max(1.0)))
}

/// The mean (appendix C).
pub fn mean(of: Distribution) -> Ratio {
    Ratio::new(of.mean())
}

/// The variance over the whole population (appendix C).
pub fn variance(of: Distribution) -> Ratio {
    Ratio::new(of.variance())
}

/// The standard deviation over the whole population (appendix C).
pub fn deviation(of: Distribution) -> Ratio {
    Ratio::new(of.variance().sqrt())
}

/// The number of values (appendix C).
pub fn number(of: Distribution) -> Count {
    Count::new(of.number())
}

pub(crate) const MODELS: &[Model] = models! {
    "parks.charged-segments", "app. C", "segments charged for polygons of these heights, [[height, polygons], ...]":
        charged_segments["heights": Distribution] -> Segments;
    "parks.mean", "app. C", "mean of [[value, times], ...]":
        mean["of": Distribution] -> Ratio;
    "parks.variance", "app. C", "variance of [[value, times], ...], over the population":
        variance["of": Distribution] -> Ratio;
    "parks.deviation", "app. C", "standard deviation of [[value, times], ...]":
        deviation["of": Distribution] -> Ratio;
    "parks.number", "app. C", "number of values in [[value, times], ...]":
        number["of": Distribution] -> Count;
};
