//! Costs from measured frames.

/// Solves for non-negative costs that bring `sum_k counts[i][k] * costs[k]` close to `times[i]`, relative to the times:
/// least squares by updating one cost at a time until nothing changes (sequential coordinate-wise descent, Franc,
/// Hlavac and Navara 2005). Deterministic.
///
/// # Panics
/// If there are no frames, if a time is not above zero or the rows differ in length.
pub fn costs(counts: &[Vec<f64>], times: &[f64]) -> Vec<f64> {
    assert!(!times.is_empty() && times.iter().all(|t| *t > 0.0), "frames take time");
    let n = counts[0].len();
    assert!(counts.iter().all(|row| row.len() == n), "a count for every cost");
    let rows: Vec<Vec<f64>> =
        counts.iter().zip(times).map(|(row, t)| row.iter().map(|c| c / t).collect()).collect();
    let column = |k: usize| rows.iter().map(move |r| r[k]);
    let gram: Vec<Vec<f64>> = (0..n)
        .map(|a| (0..n).map(|b| column(a).zip(column(b)).map(|(x, y)| x * y).sum()).collect())
        .collect();
    let mut costs = vec![0.0f64; n];
    // The gradient with all costs zero; every target is 1.
    let mut gradient: Vec<f64> = (0..n).map(|k| -column(k).sum::<f64>()).collect();
    for _ in 0..200_000 {
        let mut moved = 0.0f64;
        for k in 0..n {
            if gram[k][k] <= 0.0 {
                continue;
            }
            let next = (costs[k] - gradient[k] / gram[k][k]).max(0.0);
            let step = next - costs[k];
            if step != 0.0 {
                costs[k] = next;
                (0..n).for_each(|j| gradient[j] += step * gram[j][k]);
                // In terms of the share of a frame's time that the step changes.
                moved = moved.max(step.abs() * gram[k][k].sqrt());
            }
        }
        if moved < 1e-12 {
            break;
        }
    }
    costs
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn a_cost_that_would_be_negative_is_zero() {
        // Times fall with the second count: it gets no cost, and the first one is fitted alone.
        let fitted = costs(&[vec![1.0, 1.0], vec![1.0, 2.0]], &[2.0, 1.0]);
        assert_eq!(fitted[1], 0.0);
        // Least squares of c / 2 and c / 1 against 1: c = 1.5 / 1.25.
        assert!((fitted[0] - 1.2).abs() < 1e-9, "{fitted:?}");
    }

    proptest! {
        #[test]
        fn known_costs_are_found(
            rows in prop::collection::vec(prop::array::uniform3(1.0f64..100.0), 12..20),
            truth in prop::array::uniform3(0.1f64..10.0),
        ) {
            let times: Vec<f64> = rows.iter().map(|r| (0..3).map(|k| r[k] * truth[k]).sum()).collect();
            let rows: Vec<Vec<f64>> = rows.iter().map(|r| r.to_vec()).collect();
            let fitted = costs(&rows, &times);
            for (row, time) in rows.iter().zip(&times) {
                let ours: f64 = row.iter().zip(&fitted).map(|(a, b)| a * b).sum();
                prop_assert!((ours / time - 1.0).abs() < 1e-3, "{} {}", ours, time);
            }
        }
    }
}
