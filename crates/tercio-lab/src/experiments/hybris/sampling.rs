//! Samples in every row and column of a pixel against grids of them: figure 3.25.

use std::collections::BTreeSet;

use tercio_mesh::trig::sin_cos;

use crate::experiments::{
    Axis, Comparison, Document, Experiment, ExperimentError, Findings, Plot, Series, Table,
};
use crate::simulators::hybris::samples::patterns;

pub(crate) const EXPERIMENTS: &[Experiment] = &[Experiment {
    id: "hybris-fig-3-25",
    document: Document::Hybris,
    place: "figure 3.25, section 3.6.6",
    title: "Sparse samples against grids: steps and errors of edges",
    run: sampling,
}];

type Point = [f64; 2];

/// A straight edge through a pixel: what is inside has a smaller distance along its normal.
#[derive(Clone, Copy)]
struct Edge {
    normal: Point,
    distance: f64,
}

impl Edge {
    /// An edge at an angle to the vertical, at a distance from the pixel's middle.
    fn new(degrees: f64, from_middle: f64) -> Self {
        let (sin, cos) = sin_cos(degrees.to_radians());
        Self { normal: [cos, sin], distance: 0.5 * (cos + sin) + from_middle }
    }

    fn beyond(self, [x, y]: Point) -> f64 {
        x * self.normal[0] + y * self.normal[1] - self.distance
    }

    /// The area of the unit square inside: it is cut at the edge.
    fn area(self) -> f64 {
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let mut inside = Vec::new();
        for (a, b) in square.iter().zip(square.iter().cycle().skip(1)) {
            let (da, db) = (self.beyond(*a), self.beyond(*b));
            if da <= 0.0 {
                inside.push(*a);
            }
            if (da <= 0.0) != (db <= 0.0) {
                let t = da / (da - db);
                inside.push([a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])]);
            }
        }
        let pairs = inside.iter().zip(inside.iter().cycle().skip(1));
        0.5 * pairs.map(|(a, b)| a[0] * b[1] - b[0] * a[1]).sum::<f64>()
    }

    /// The share of the samples inside.
    fn coverage(self, samples: &[Point]) -> f64 {
        samples.iter().filter(|&&s| self.beyond(s) <= 0.0).count() as f64 / samples.len() as f64
    }
}

/// The samples of a pattern: the middles of its sub-pixels.
fn sparse(pattern: &[u32]) -> Vec<Point> {
    let n = pattern.len() as f64;
    let at = |(row, &column): (usize, &u32)| [(f64::from(column) + 0.5) / n, (row as f64 + 0.5) / n];
    pattern.iter().enumerate().map(at).collect()
}

/// All samples of a grid of `n` by `n`.
fn grid(n: u32) -> Vec<Point> {
    let at = |i: u32| (f64::from(i) + 0.5) / f64::from(n);
    (0..n).flat_map(|row| (0..n).map(move |column| [at(column), at(row)])).collect()
}

/// Steps of intensity between nothing and all while an edge passes: the fewest of a vertical and a horizontal one.
fn steps(samples: &[Point]) -> usize {
    let of = |degrees: f64| {
        // A little beside the samples, which are at multiples of 1/16.
        let places = (0..=128).map(|i| f64::from(i) / 128.0 - 0.5 + 1e-6);
        let levels: BTreeSet<u64> = places
            .map(|at| (Edge::new(degrees, at).coverage(samples) * samples.len() as f64).round() as u64)
            .collect();
        levels.len() - 1
    };
    of(0.0).min(of(90.0))
}

/// Root of the mean square difference between the share of samples and the area while an edge moves by a pixel.
fn error(samples: &[Point], degrees: f64) -> f64 {
    const PLACES: u32 = 300;
    // From before the pixel to after it, whatever the angle.
    const WAY: f64 = 1.5;
    let squares = (0..PLACES).map(|i| {
        let edge = Edge::new(degrees, WAY * ((f64::from(i) + 0.5) / f64::from(PLACES) - 0.5));
        (edge.coverage(samples) - edge.area()).powi(2)
    });
    (squares.sum::<f64>() * WAY / f64::from(PLACES)).sqrt()
}

/// The same for a square of half a pixel's side anywhere: how an object smaller than a pixel flashes while it moves.
fn flashing(samples: &[Point]) -> f64 {
    const PLACES: u32 = 64;
    let mut sum = 0.0;
    for place in 0..PLACES * PLACES {
        // The square's corner; samples repeat from pixel to pixel.
        let [x, y] = [place % PLACES, place / PLACES].map(|p| (f64::from(p) + 0.5) / f64::from(PLACES));
        let from = |c: f64, corner: f64| (c - corner).rem_euclid(1.0);
        let hit = samples.iter().filter(|s| from(s[0], x) < 0.5 && from(s[1], y) < 0.5).count();
        sum += (hit as f64 / samples.len() as f64 - 0.25).powi(2);
    }
    (sum / f64::from(PLACES * PLACES)).sqrt()
}

/// The square of the least distance between two samples of a pixel.
fn least_distance(samples: &[Point]) -> f64 {
    let pairs = samples.iter().enumerate().flat_map(|(i, a)| samples[i + 1..].iter().map(move |b| (a, b)));
    pairs.map(|(a, b)| (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2)).fold(f64::MAX, f64::min)
}

/// Angles of edges to the vertical, in degrees: half a turn.
fn angles() -> impl Iterator<Item = f64> {
    (0..120).map(|i| 1.5 * f64::from(i))
}

fn mean_error(samples: &[Point]) -> f64 {
    let errors: Vec<_> = angles().map(|a| error(samples, a).powi(2)).collect();
    (errors.iter().sum::<f64>() / errors.len() as f64).sqrt()
}

/// The largest angle to the vertical and the horizontal up to which edges of `samples` are closer to those of `full` than to
/// those of `square`; `None` if not even those along the axes are.
fn reach(samples: &[Point], square: &[Point], full: &[Point]) -> Option<f64> {
    let closer = |degrees: f64| {
        let [two, ours, four] = [square, samples, full].map(|s| error(s, degrees));
        ours < 0.5 * (two + four)
    };
    // On both sides of both axes.
    let all = |tilt: f64| [tilt, 90.0 - tilt, 90.0 + tilt, 180.0 - tilt].into_iter().all(closer);
    (0..=90).map(|i| 0.5 * f64::from(i)).take_while(|&tilt| all(tilt)).last()
}

fn sampling() -> Result<Findings, ExperimentError> {
    let mut table = Table::new(
        "samples",
        &[
            ("samples", ""),
            ("number", ""),
            ("steps", ""),
            ("error, vertical or horizontal", "%"),
            ("error, all angles", "%"),
            ("flashing of half a pixel", "%"),
        ],
    );
    let mut comparison = Comparison::new();
    for n in [2, 4, 8] {
        let all = patterns(n).iter().map(|p| steps(&sparse(p))).collect::<BTreeSet<_>>();
        for &count in &all {
            let name = format!("steps from {n} samples, every pattern with one a row and column");
            comparison.add_printed(name, count as f64, &n.to_string());
        }
    }
    // "Only benefit from 8 rows or columns in an 8x8 sub-sample array."
    comparison.add_printed("steps from a grid of 8x8", steps(&grid(8)) as f64, "8");
    let of_four = patterns(4);
    let even = |p: &&Vec<u32>| least_distance(&sparse(p));
    let most_even = of_four.iter().max_by(|a, b| even(a).total_cmp(&even(b))).ok_or("there are patterns")?;
    let named = [
        ("grid of 2x2", grid(2)),
        ("sparse, most even", sparse(most_even)),
        ("sparse, diagonal", sparse(&[0, 1, 2, 3])),
        ("grid of 4x4", grid(4)),
    ];
    let mut plot = Plot::new(
        "errors",
        "Error of an edge's coverage by its angle",
        Axis::linear("degrees to the vertical"),
        Axis::linear("root mean square error, % of a pixel"),
    );
    for (name, samples) in &named {
        table.push([
            (*name).into(),
            (samples.len() as f64).into(),
            (steps(samples) as f64).into(),
            (100.0 * error(samples, 0.0).max(error(samples, 90.0))).into(),
            (100.0 * mean_error(samples)).into(),
            (100.0 * flashing(samples)).into(),
        ]);
        plot = plot.with(Series::line(*name, angles().map(|a| (a, 100.0 * error(samples, a))).collect()));
    }
    let [square, evenly, diagonal, full] = &named;
    let as_good =
        |p: &Vec<u32>| [0.0, 90.0].iter().all(|&a| (error(&sparse(p), a) - error(&full.1, a)).abs() < 1e-9);
    comparison.claim(
        "vertical and horizontal edges of all 24 patterns are as good as those of 4x4 samples",
        of_four.iter().all(as_good),
    );
    let reach = reach(&evenly.1, &square.1, &full.1).unwrap_or(f64::NAN);
    comparison.claim(
        format!(
            "edges up to {reach} degrees off the axes are closer to those of 4x4 samples than to those of 2x2"
        ),
        reach > 0.0,
    );
    let of_all = mean_error(&evenly.1);
    let least = of_four.iter().map(|p| mean_error(&sparse(p))).fold(f64::MAX, f64::min);
    let [even, in_line] = [evenly, diagonal].map(|n| flashing(&n.1));
    comparison.claim("an even distribution flashes less than samples in a line", even < in_line);
    Ok(Findings {
        tables: vec![table],
        plots: vec![plot],
        remarks: vec![
            "The places of the samples in the figure are lost, so all patterns with one sample in every row and column are \
             tried (2, 24 and 40,320); the most even one of four is that with the largest least distance between samples. \
             Coverage is compared with the area of the pixel cut at the edge."
                .into(),
            format!(
                "Over edges of all angles four sparse samples are no better than 2x2: {:.1} % against {:.1} %. What they gain \
                 near the axes they lose between; the document's reason for them is that the eye minds the former more.",
                100.0 * of_all,
                100.0 * mean_error(&square.1)
            ),
            format!(
                "The least error over all angles that one of the 24 patterns has is {:.2} %; the most even one has {:.2} %.",
                100.0 * least,
                100.0 * of_all
            ),
        ],
        // The numbers alone would be reproduced; what the figure is about, quality, is so near the axes only.
        verdict: comparison.qualitative("The places of the samples are lost, and the document judges quality by eye."),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn areas_are_those_of_a_fine_grid() {
        let fine = grid(400);
        for i in 0..40 {
            let edge = Edge::new(2.25 * f64::from(i), 0.03 * f64::from(i) - 0.6);
            assert!((edge.area() - edge.coverage(&fine)).abs() < 0.004, "{i}");
        }
        // Vertical and diagonal edges by hand.
        assert!((Edge::new(0.0, -0.2).area() - 0.3).abs() < 1e-12);
        assert!((Edge::new(45.0, 0.0).area() - 0.5).abs() < 1e-12);
    }

    #[test]
    fn steps_are_columns_and_errors_are_those_of_uniform_rounding() {
        assert_eq!((steps(&grid(3)), steps(&[[0.5, 0.5]]), steps(&sparse(&[2, 0, 1]))), (3, 1, 3));
        // A vertical edge is rounded to n steps: the error is uniform, 1 / (n sqrt 12).
        for samples in [grid(4), sparse(&[1, 3, 0, 2]), sparse(&[0, 1, 2, 3])] {
            assert!((error(&samples, 0.0) - 0.25 / 12f64.sqrt()).abs() < 1e-4);
        }
    }

    #[test]
    fn a_grid_of_two_by_two_never_misses_half_a_pixel() {
        assert!(flashing(&grid(2)) < 1e-12);
        // One sample is hit a quarter of the time: deviations of 3/4 and 1/4.
        let one = flashing(&[[0.25, 0.25]]);
        assert!((one - (0.25f64 * 0.5625 + 0.75 * 0.0625).sqrt()).abs() < 1e-12, "{one}");
    }
}
