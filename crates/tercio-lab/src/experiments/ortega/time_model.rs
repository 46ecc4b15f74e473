//! A time model fitted on one row of a table and tested on the others.

use super::speed::{Partition, ROWS, TABLES, time};
use crate::experiments::facts::Facts;
use crate::experiments::{
    Axis, Comparison, Document, Experiment, ExperimentError, Findings, Plot, Series, Table,
};

pub(crate) const EXPERIMENTS: &[Experiment] = &[Experiment {
    id: "ortega-time-model",
    document: Document::Ortega,
    place: "tables 1 to 4",
    title: "Times by Amdahl's law, fitted on one row and tested on the others",
    run: model,
}];

/// Serial time and time of one processor, t = a + b / p, with the least sum of squared relative errors.
fn fit(points: &[(f64, f64)]) -> [f64; 2] {
    // Minimize the sum of (a/t + b/(p t) - 1)^2.
    let mut m = [0.0; 5];
    for &(p, t) in points {
        let (u, v) = (1.0 / t, 1.0 / (p * t));
        for (sum, term) in m.iter_mut().zip([u * u, u * v, v * v, u, v]) {
            *sum += term;
        }
    }
    let [uu, uv, vv, u, v] = m;
    let determinant = uu * vv - uv * uv;
    [(u * vv - v * uv) / determinant, (uu * v - uv * u) / determinant]
}

/// The largest relative error of the model with the serial share of `row` on another row, whose own time scale is that of
/// its first partition: only the shape is carried over.
fn largest_error([a, b]: [f64; 2], row: &[(f64, f64)]) -> f64 {
    let shape = |p: f64| a + b / p;
    let scale = row[0].1 / shape(row[0].0);
    row.iter().map(|&(p, t)| (scale * shape(p) / t - 1.0).abs()).fold(0.0, f64::max)
}

fn model() -> Result<Findings, ExperimentError> {
    let facts = Facts::load()?;
    let mut table = Table::new(
        "errors",
        &[
            ("table", ""),
            ("fitted on row", ""),
            ("serial", "s"),
            ("parallel", "s processor"),
            ("tested on row", ""),
            ("largest error", "%"),
        ],
    );
    let mut comparison = Comparison::new();
    // The errors of each row by the model of row 1, table by table.
    let mut errors = ROWS.map(|_| Vec::new());
    for (number, name, partitions) in TABLES {
        let rows =
            ROWS.iter().map(|&row| points(&facts, number, row, partitions)).collect::<Result<Vec<_>, _>>()?;
        for (from, fitted) in rows.iter().enumerate() {
            let [a, b] = fit(fitted);
            for (to, row) in rows.iter().enumerate() {
                let error = 100.0 * largest_error([a, b], row);
                table.push([
                    f64::from(number).into(),
                    (from as f64 + 1.0).into(),
                    a.into(),
                    b.into(),
                    (to as f64 + 1.0).into(),
                    error.into(),
                ]);
                if from == 0 {
                    errors[to].push((f64::from(number), error));
                }
            }
        }
        let of_table = errors[1..].iter().flatten().filter(|p| p.0 == f64::from(number));
        let worst = of_table.map(|p| p.1).fold(0.0, f64::max);
        comparison.claim(
            format!("{name}: row 1 predicts the times of rows 2 and 3 within 10 % ({worst:.1} %)"),
            worst <= 10.0,
        );
    }
    let mut plot = Plot::new(
        "errors",
        "Largest error of a time, fitted on row 1",
        Axis::categories("table", 1, TABLES.map(|t| t.1)),
        Axis::linear("percent"),
    );
    for (label, points) in ["row 1 itself", "row 2", "row 3"].into_iter().zip(errors) {
        plot = plot.with(Series::points(label, points));
    }
    Ok(Findings {
        tables: vec![table],
        plots: vec![plot],
        remarks: vec![
            "A serial part and a parallel one, t = a + b/p. The document has no such model: what is contradicted here is \
             ours, of which we ask 10 %. The rows' labels are lost. Where a row is not predicted, its times are not those of one serial \
             share: on the CM-5 the step from 32 to 64 processors gains 1.2 in rows 1 and 2 of table 3 and 2.4 in row 3."
                .into(),
        ],
        verdict: comparison.of_our_model("The document has no model of its times; this one is ours."),
    })
}

fn points(
    facts: &Facts,
    table: u32,
    row: u32,
    partitions: &[Partition],
) -> Result<Vec<(f64, f64)>, ExperimentError> {
    partitions.iter().map(|&(name, p)| Ok((p, time(facts, table, row, name)?.get()))).collect()
}

#[cfg(test)]
mod tests {
    use super::super::speed::{CM5, CM200};
    use super::*;

    #[test]
    fn a_law_is_found_again_and_another_one_is_not() {
        let of = |a: f64, b: f64| CM5.map(|(_, p)| (p, a + b / p));
        let [a, b] = fit(&of(2.0, 300.0));
        assert!((a - 2.0).abs() < 1e-9 && (b - 300.0).abs() < 1e-7, "{a} {b}");
        assert!(largest_error([a, b], &of(4.0, 600.0)) < 1e-9, "twice as long is the same shape");
        assert!(largest_error([a, b], &of(0.0, 300.0)) > 0.5);
        assert_eq!(CM200.len(), 3);
    }
}
