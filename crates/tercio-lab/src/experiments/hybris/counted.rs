//! Tiles that triangles meet, counted one by one: figures 2.14 and 2.15 without their equations.

use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::overlap::{AREAS, TILES};
use crate::experiments::facts::Facts;
use crate::experiments::{
    Comparison, Document, Experiment, ExperimentError, Findings, Fit, Table, sweep::sweep,
};
use crate::published::ToleranceSource;

pub(crate) const EXPERIMENTS: &[Experiment] = &[
    Experiment {
        id: "hybris-fig-2-14",
        document: Document::Hybris,
        place: "figure 2.14",
        title: "A long triangle across a screen of 16 by 16 tiles, counted",
        run: long_triangle,
    },
    Experiment {
        id: "hybris-fig-2-15-counted",
        document: Document::Hybris,
        place: "figure 2.15",
        title: "Overlap of random triangles, counted tile by tile",
        run: random_triangles,
    },
];

type Point = [f64; 2];

/// Whether a triangle meets the inside of the square of side 1 with its lower left corner at `at`: no side of either
/// separates them.
fn meets(triangle: &[Point; 3], at: Point) -> bool {
    let square = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]].map(|[x, y]| [at[0] + x, at[1] + y]);
    let side = |i: usize| {
        let (a, b) = (triangle[i], triangle[(i + 1) % 3]);
        [b[1] - a[1], a[0] - b[0]]
    };
    let axes = [[1.0, 0.0], [0.0, 1.0], side(0), side(1), side(2)];
    axes.iter().all(|axis| {
        let range = |points: &[Point]| {
            let along = points.iter().map(|p| p[0] * axis[0] + p[1] * axis[1]);
            along.fold((f64::MAX, f64::MIN), |(low, high), t| (low.min(t), high.max(t)))
        };
        let (a, b) = (range(triangle), range(&square));
        a.0 < b.1 && b.0 < a.1
    })
}

/// Tiles of side 1 that a triangle meets, and those that its bounding box meets.
fn tiles(triangle: &[Point; 3]) -> [u64; 2] {
    let range = |axis: usize| {
        let along = triangle.iter().map(|p| p[axis]);
        let (low, high) = along.fold((f64::MAX, f64::MIN), |(low, high), t| (low.min(t), high.max(t)));
        (low.floor() as i32, high.ceil() as i32)
    };
    let ((x0, x1), (y0, y1)) = (range(0), range(1));
    let all = (y0..y1).flat_map(|y| (x0..x1).map(move |x| [f64::from(x), f64::from(y)]));
    let met = all.filter(|&at| meets(triangle, at)).count();
    [met as u64, u64::from((x1 - x0).unsigned_abs()) * u64::from((y1 - y0).unsigned_abs())]
}

/// Mean and standard error of the tiles that random triangles of `area` tiles meet, whose boxes are square and three
/// times as large: itself, and its box.
fn means(area: f64, samples: u32, seed: u64) -> [(f64, f64); 2] {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let mut unit = || (random.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
    let s = (3.0 * area).sqrt();
    let mut sums = [(0.0, 0.0); 2];
    for _ in 0..samples {
        let [dx, dy] = [unit(), unit()];
        // One corner of the box, and one point on each of the two sides that do not meet there: x y = 1/3 of the box.
        let x = 1.0 / 3.0 + unit() * 2.0 / 3.0;
        let (x, y) = (x, 1.0 / (3.0 * x));
        let triangle = [[0.0, 0.0], [s, s * y], [s * x, s]].map(|[x, y]| [x + dx, y + dy]);
        for (sum, count) in sums.iter_mut().zip(tiles(&triangle)) {
            let count = count as f64;
            *sum = (sum.0 + count, sum.1 + count * count);
        }
    }
    let n = f64::from(samples);
    sums.map(|(sum, squares)| {
        let mean = sum / n;
        (mean, ((squares / n - mean * mean).max(0.0) / n).sqrt())
    })
}

fn random_triangles() -> Result<Findings, ExperimentError> {
    const SAMPLES: u32 = 20_000;
    let facts = Facts::load()?;
    let mut table = Table::new(
        "counted",
        &[
            ("tile", "px"),
            ("area", "pixel"),
            ("exact, counted", ""),
            ("standard error", ""),
            ("exact, printed", ""),
            ("box, counted", ""),
            ("box, printed", ""),
        ],
    );
    let cells: Vec<_> = TILES.iter().flat_map(|&tile| AREAS.iter().map(move |&area| (tile, area))).collect();
    let counted = sweep(&cells, |&(tile, area)| {
        Ok(means(f64::from(area) / f64::from(tile * tile), SAMPLES, u64::from(tile * 2048 + area)))
    })?;
    let mut comparison = Comparison::new();
    for ((tile, area), means) in cells.into_iter().zip(counted) {
        let mut row = vec![f64::from(tile).into(), f64::from(area).into()];
        for ((kind, name), (mean, error)) in [("ex", "exact"), ("bb", "box")].into_iter().zip(means) {
            let printed = facts.printed(&format!("H2.15-{kind}-{tile}-{area}"))?;
            row.push(mean.into());
            if kind == "ex" {
                row.push(error.into());
            }
            row.push(printed.into());
            // Four standard errors: of 72 cells none is expected beyond them.
            let name = format!("{name}, tile {tile}, area {area}");
            comparison.add(name, mean, printed, 4.0 * error + 0.0005, ToleranceSource::Sampling);
        }
        table.push_row(row);
    }
    Ok(Findings {
        tables: vec![table],
        plots: Vec::new(),
        remarks: vec![format!(
            "{SAMPLES} random triangles a cell at random places, with square boxes three times their area. A tile counts if \
             no side of tile or triangle separates the two; no equation of the document is used."
        )],
        verdict: comparison.verdict(),
    })
}

fn long_triangle() -> Result<Findings, ExperimentError> {
    let columns = [("shape", ""), ("thickness", "tile"), ("exact", ""), ("bounding box", "")];
    let mut table = Table::new("buckets", &columns);
    let (mut readings, mut boxes) = (Vec::new(), true);
    for shape in ["on both sides of the diagonal", "on one side of the diagonal"] {
        let mut points = Vec::new();
        for step in 0..=60 {
            // From one corner of the screen to the opposite one; a hair inside, so that rounding adds no tile.
            let thickness = 0.05 + 0.05 * f64::from(step);
            let (low, far) = (1e-6, 16.0 - 1e-6);
            let other = if shape.contains("both") { [far, far - thickness] } else { [far, far] };
            let [exact, of_box] = tiles(&[[low, low], other, [far - thickness, far]]);
            boxes &= of_box == 256;
            table.push([shape.into(), thickness.into(), (exact as f64).into(), (of_box as f64).into()]);
            points.push((thickness, exact as f64));
        }
        readings.push(Fit::new(format!("40 buckets, {shape}"), "thickness in tiles", "40", points));
    }
    let mut comparison = Comparison::new();
    comparison.claim("its bounding box meets all 256 buckets whatever the thickness", boxes);
    comparison.fit_one_of(readings);
    Ok(Findings {
        tables: vec![table, comparison.intervals()],
        plots: Vec::new(),
        remarks: vec![
            "The corners of the figure's triangle are not given, so its thickness is swept.".into(),
        ],
        verdict: comparison.qualitative("The corners of the triangle are not given."),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn touching_is_not_meeting() {
        let triangle = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
        assert_eq!(tiles(&triangle), [1, 1]);
        assert!(!meets(&triangle, [1.0, 0.0]) && !meets(&triangle, [0.0, -1.0]));
        // The box has the corner that the triangle leaves out.
        let large = triangle.map(|p| p.map(|c| 2.0 * c));
        assert_eq!(tiles(&large), [3, 4]);
    }

    #[test]
    fn a_point_meets_one_tile_and_a_large_triangle_its_area() {
        let [(mean, _), (of_box, _)] = means(1e-12, 1000, 1);
        assert_eq!((mean, of_box), (1.0, 1.0));
        let [(mean, error), _] = means(400.0, 500, 2);
        let s = 1200f64.sqrt();
        assert!((mean - (1.0 + 2.0 * s + 400.0)).abs() < 5.0 * error + 1e-9, "{mean} {error}");
    }
}
