//! Distributions of whole numbers, as listed in document 002, appendix C.

use std::collections::BTreeMap;

/// How often each value occurred.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Distribution {
    counts: BTreeMap<u64, u64>,
}

impl Distribution {
    /// Adds `times` occurrences of a value.
    pub fn add(&mut self, value: u64, times: u64) {
        if times > 0 {
            *self.counts.entry(value).or_insert(0) += times;
        }
    }

    /// The values that occurred, ascending, with their multiplicity.
    pub fn counts(&self) -> impl Iterator<Item = (u64, u64)> + '_ {
        self.counts.iter().map(|(&value, &times)| (value, times))
    }

    /// Number of data points.
    pub fn points(&self) -> u64 {
        self.counts.values().sum()
    }

    /// Sum of the values.
    pub fn sum(&self) -> u64 {
        self.counts().map(|(value, times)| value * times).sum()
    }

    /// Mean; 0 without data.
    pub fn mean(&self) -> f64 {
        self.sum() as f64 / self.points().max(1) as f64
    }

    /// Variance of the population (divided by the number of points, as the document does).
    pub fn variance(&self) -> f64 {
        let mean = self.mean();
        let square = |value: u64| (value as f64 - mean) * (value as f64 - mean);
        self.counts().map(|(value, times)| square(value) * times as f64).sum::<f64>()
            / self.points().max(1) as f64
    }

    /// Standard deviation of the population.
    pub fn deviation(&self) -> f64 {
        self.variance().sqrt()
    }
}

impl FromIterator<(u64, u64)> for Distribution {
    fn from_iter<T: IntoIterator<Item = (u64, u64)>>(counts: T) -> Self {
        let mut distribution = Self::default();
        for (value, times) in counts {
            distribution.add(value, times);
        }
        distribution
    }
}
