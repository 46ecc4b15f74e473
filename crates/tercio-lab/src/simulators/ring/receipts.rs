//! The three checks of document 000, appendix A.3.

use serde::Serialize;

use super::destinations::Destinations;

/// The errors found; all zero if the communication was correct.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Checks {
    /// Processors that did not receive a polygon with pixels of theirs.
    pub missing: u64,
    /// Processors that received a polygon they did not need.
    pub unneeded: u64,
    /// Processors that received a polygon again.
    pub repeated: u64,
}

impl Checks {
    /// True if there are no errors.
    pub fn passed(&self) -> bool {
        *self == Self::default()
    }
}

/// Which polygons were received where. One bit per polygon and destination.
pub struct Receipts<'a> {
    destinations: &'a Destinations,
    /// Number of destinations of all polygons before each one.
    before: Vec<u64>,
    total: u64,
    got: Vec<u64>,
    checks: Checks,
}

impl<'a> Receipts<'a> {
    /// Nothing has been received.
    pub fn new(destinations: &'a Destinations) -> Self {
        let mut total = 0;
        let before = (0..destinations.len() as u32).map(|polygon| {
            let before = total;
            total += destinations.runs(polygon).iter().map(|r| u64::from(r.last - r.first) + 1).sum::<u64>();
            before
        });
        let before = before.collect();
        let got = vec![0; total.div_ceil(64) as usize];
        Self { destinations, before, total, got, checks: Checks::default() }
    }

    /// Records that the processor `offset` to the right of a polygon's sender received the polygon.
    pub fn record(&mut self, polygon: u32, offset: u32) {
        let mut rank = self.before[polygon as usize];
        for run in self.destinations.runs(polygon) {
            if (run.first..=run.last).contains(&offset) {
                rank += u64::from(offset - run.first);
                let bit = 1 << (rank % 64);
                let word = &mut self.got[(rank / 64) as usize];
                self.checks.repeated += u64::from(*word & bit != 0);
                *word |= bit;
                return;
            }
            rank += u64::from(run.last - run.first) + 1;
        }
        self.checks.unneeded += 1;
    }

    /// The verdict, and the number of destinations of all polygons.
    pub fn finish(mut self) -> (Checks, u64) {
        let got: u64 = self.got.iter().map(|word| u64::from(word.count_ones())).sum();
        self.checks.missing = self.total - got;
        (self.checks, self.total)
    }
}
