//! Sweeps over a parameter inside one experiment.

use tercio_mesh::loops::prelude::*;

use super::ExperimentError;

/// Runs the points of a sweep on the cores of the current pool. The results are in the order of the points; if several
/// fail, the error is that of the first in this order.
///
/// # Errors
/// The error of `run`.
pub(super) fn sweep<P: Sync, R: Send>(
    points: &[P],
    run: impl Fn(&P) -> Result<R, ExperimentError> + Sync,
) -> Result<Vec<R>, ExperimentError> {
    let results: Vec<_> = points.par_iter().map(&run).collect();
    results.into_iter().collect()
}

/// All pairs of two lists; the second element varies fastest.
pub(super) fn pairs<'a, A, B: Copy>(first: &'a [A], second: &[B]) -> Vec<(&'a A, B)> {
    first.iter().flat_map(|a| second.iter().map(move |b| (a, *b))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn order_and_error_are_those_of_the_points() {
        let points: Vec<u32> = (0..500).collect();
        let doubled = sweep(&points, |p| Ok(2 * p)).unwrap();
        assert!(doubled.iter().zip(&points).all(|(d, p)| *d == 2 * p));
        let failing = |p: &u32| if p % 7 == 3 { Err(format!("point {p}").into()) } else { Ok(()) };
        for _ in 0..20 {
            assert_eq!(sweep(&points, failing).unwrap_err().to_string(), "point 3");
        }
        assert_eq!(pairs(&["a", "b"], &[1, 2]), [(&"a", 1), (&"a", 2), (&"b", 1), (&"b", 2)]);
    }
}
