//! Parses the summary lines of Rust's test harness.

use std::fmt;
use std::ops::AddAssign;

/// How many tests passed, failed and were skipped.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Passed.
    pub passed: u64,
    /// Failed.
    pub failed: u64,
    /// Marked as ignored.
    pub ignored: u64,
}

impl Counts {
    /// A single check.
    pub fn one(passed: bool) -> Self {
        Self { passed: passed.into(), failed: (!passed).into(), ignored: 0 }
    }

    /// Reads a line such as `test result: ok. 12 passed; 0 failed; 1 ignored; 0 measured; …`; `None` for
    /// any other line.
    pub fn from_line(line: &str) -> Option<Self> {
        // A program started by a test may have left text of its own at the start of the line.
        let (_, result) = line.split_once("test result: ")?;
        let (_, counts) = result.split_once(". ")?;
        let count = |what: &str| {
            counts.split(';').find_map(|part| part.trim().strip_suffix(what)?.trim_end().parse().ok())
        };
        Some(Self { passed: count("passed")?, failed: count("failed")?, ignored: count("ignored")? })
    }
}

impl AddAssign for Counts {
    fn add_assign(&mut self, other: Self) {
        self.passed += other.passed;
        self.failed += other.failed;
        self.ignored += other.ignored;
    }
}

impl fmt::Display for Counts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} passed, {} failed", self.passed, self.failed)?;
        if self.ignored > 0 {
            write!(f, ", {} skipped", self.ignored)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closing_lines_are_read() {
        let ok =
            "test result: ok. 12 passed; 0 failed; 1 ignored; 0 measured; 2 filtered out; finished in 0.00s";
        assert_eq!(Counts::from_line(ok), Some(Counts { passed: 12, failed: 0, ignored: 1 }));
        let failed = "noisetest result: FAILED. 3 passed; 4 failed; 0 ignored; 0 measured; 0 filtered out";
        assert_eq!(Counts::from_line(failed), Some(Counts { passed: 3, failed: 4, ignored: 0 }));
    }

    #[test]
    fn other_lines_are_not() {
        for line in ["", "running 12 tests", "test a ... ok", "test result: ok", "test result: ok. 1 passed"]
        {
            assert_eq!(Counts::from_line(line), None, "{line}");
        }
    }

    #[test]
    fn counts_add_up_to_the_closing_line() {
        let mut sum = Counts { passed: 2, failed: 0, ignored: 0 };
        sum += Counts::one(true);
        assert_eq!(sum.to_string(), "3 passed, 0 failed");
        sum += Counts { passed: 0, failed: 1, ignored: 5 };
        assert_eq!(sum.to_string(), "3 passed, 1 failed, 5 skipped");
    }
}
