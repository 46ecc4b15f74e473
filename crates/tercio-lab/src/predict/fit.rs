//! Costs from measured frames.

/// Rounds of reweighting, after which nothing changes that would be seen.
const ROUNDS: usize = 40;

/// Non-negative values of two terms that bring `sum_k terms[i][k] * values[k]` close to `excess[i]`, relative to `times[i]`:
/// least absolute deviations, so that frames in which the machine did something else count little. By repeated least
/// squares, each time with the weights of the last deviations. Deterministic.
pub fn two_terms(terms: &[[f64; 2]], excess: &[f64], times: &[f64]) -> [f64; 2] {
    /// Deviations below this share of a frame's time are noise, all alike.
    const SMALL: f64 = 1e-3;
    let mut values = [0.0; 2];
    let mut weights = vec![1.0f64; terms.len()];
    for _ in 0..ROUNDS {
        // Squares are weighted, so that each side has the root.
        let scale: Vec<f64> = weights.iter().zip(times).map(|(weight, time)| weight.sqrt() / time).collect();
        let rows: Vec<Vec<f64>> = terms
            .iter()
            .zip(&scale)
            .map(|(row, scale)| row.iter().map(|term| term * scale).collect())
            .collect();
        let targets: Vec<f64> = excess.iter().zip(&scale).map(|(excess, scale)| excess * scale).collect();
        values.copy_from_slice(&non_negative(&rows, &targets, 2));
        for (i, weight) in weights.iter_mut().enumerate() {
            let deviation = (terms[i][0] * values[0] + terms[i][1] * values[1] - excess[i]).abs() / times[i];
            *weight = 1.0 / deviation.max(SMALL);
        }
    }
    values
}

/// Solves for non-negative costs that bring `sum_k counts[i][k] * costs[k]` close to `times[i]`, relative to the times, each
/// error times its weight: least squares by updating one cost at a time until nothing changes (sequential coordinate-wise descent, Franc,
/// Hlavac and Navara 2005). Deterministic.
///
/// # Panics
/// If there are no frames, if a time is not above zero or the rows differ in length.
pub fn costs(counts: &[Vec<f64>], times: &[f64], weights: &[f64]) -> Vec<f64> {
    assert!(!times.is_empty() && times.iter().all(|t| *t > 0.0), "frames take time");
    let n = counts[0].len();
    assert!(counts.iter().all(|row| row.len() == n), "a count for every cost");
    assert!(weights.len() == times.len(), "a weight for every frame");
    let rows: Vec<Vec<f64>> = counts
        .iter()
        .zip(times)
        .zip(weights)
        .map(|((row, time), weight)| row.iter().map(|count| count / time * weight).collect())
        .collect();
    non_negative(&rows, weights, n)
}

/// The `n` non-negative values that bring `sum_k rows[i][k] * values[k]` closest to `targets[i]`, by least squares.
fn non_negative(rows: &[Vec<f64>], targets: &[f64], n: usize) -> Vec<f64> {
    let column = |k: usize| rows.iter().map(move |r| r[k]);
    let gram: Vec<Vec<f64>> = (0..n)
        .map(|a| (0..n).map(|b| column(a).zip(column(b)).map(|(x, y)| x * y).sum()).collect())
        .collect();
    let mut values = vec![0.0f64; n];
    // The gradient with all values zero.
    let mut gradient: Vec<f64> =
        (0..n).map(|k| -column(k).zip(targets).map(|(x, target)| x * target).sum::<f64>()).collect();
    for _ in 0..200_000 {
        let mut moved = 0.0f64;
        for k in 0..n {
            if gram[k][k] <= 0.0 {
                continue;
            }
            let next = (values[k] - gradient[k] / gram[k][k]).max(0.0);
            let step = next - values[k];
            if step != 0.0 {
                values[k] = next;
                (0..n).for_each(|j| gradient[j] += step * gram[j][k]);
                // In terms of the share of a frame's time that the step changes.
                moved = moved.max(step.abs() * gram[k][k].sqrt());
            }
        }
        if moved < 1e-12 {
            break;
        }
    }
    values
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn two_terms_are_found_though_some_frames_are_disturbed() {
        let (serial, wake_up) = (0.05, 30e-6);
        let frames: Vec<f64> = (1..40).map(|i| 1e-4 * f64::from(i)).collect();
        let terms: Vec<[f64; 2]> = frames.iter().map(|t| [t / 2.0, 0.5]).collect();
        let disturbed = |i: usize| if i.is_multiple_of(5) { 0.4 * frames[i] } else { 0.0 };
        let excess: Vec<f64> =
            (0..frames.len()).map(|i| terms[i][0] * serial + terms[i][1] * wake_up + disturbed(i)).collect();
        let found = two_terms(&terms, &excess, &frames);
        assert!((found[0] / serial - 1.0).abs() < 0.1 && (found[1] / wake_up - 1.0).abs() < 0.1, "{found:?}");
        // What would be negative is zero.
        let less: Vec<f64> = terms.iter().map(|t| t[0] * 0.1 - t[1] * 1e-6).collect();
        assert_eq!(two_terms(&terms, &less, &frames)[1], 0.0);
        assert_eq!(two_terms(&terms, &vec![-1e-6; terms.len()], &frames), [0.0; 2]);
    }

    #[test]
    fn a_cost_that_would_be_negative_is_zero() {
        // Times fall with the second count: it gets no cost, and the first one is fitted alone.
        let fitted = costs(&[vec![1.0, 1.0], vec![1.0, 2.0]], &[2.0, 1.0], &[1.0; 2]);
        assert_eq!(fitted[1], 0.0);
        // Least squares of c / 2 and c / 1 against 1: c = 1.5 / 1.25.
        assert!((fitted[0] - 1.2).abs() < 1e-9, "{fitted:?}");
        // The second error is multiplied by three: c = (0.5 + 9) / (0.25 + 9).
        let weighted = costs(&[vec![1.0], vec![1.0]], &[2.0, 1.0], &[1.0, 3.0]);
        assert!((weighted[0] - 9.5 / 9.25).abs() < 1e-9, "{weighted:?}");
    }

    proptest! {
        #[test]
        fn known_costs_are_found(
            rows in prop::collection::vec(prop::array::uniform3(1.0f64..100.0), 12..20),
            truth in prop::array::uniform3(0.1f64..10.0),
        ) {
            let times: Vec<f64> = rows.iter().map(|r| (0..3).map(|k| r[k] * truth[k]).sum()).collect();
            let rows: Vec<Vec<f64>> = rows.iter().map(|r| r.to_vec()).collect();
            let fitted = costs(&rows, &times, &vec![1.0; times.len()]);
            for (row, time) in rows.iter().zip(&times) {
                let ours: f64 = row.iter().zip(&fitted).map(|(a, b)| a * b).sum();
                prop_assert!((ours / time - 1.0).abs() < 1e-3, "{} {}", ours, time);
            }
        }
    }
}
