//! Rates and speed-ups on the CM-200 and the CM-5: tables 1 to 4, figures 3 and 4.

use crate::experiments::facts::Facts;
use crate::experiments::hidden::in_words;
use crate::experiments::{
    Axis, Comparison, Document, Experiment, ExperimentError, Findings, Plot, Series, Table,
};
use crate::models::ortega;
use crate::units::{Polygons, Seconds};

pub(crate) const EXPERIMENTS: &[Experiment] = &[
    Experiment {
        id: "ortega-tables",
        document: Document::Ortega,
        place: "tables 1 to 4",
        title: "Polygon rates, from times and the implied numbers of polygons",
        run: rates,
    },
    Experiment {
        id: "ortega-fig-3",
        document: Document::Ortega,
        place: "figure 3",
        title: "Speed-up on the CM-5",
        run: cm5,
    },
    Experiment {
        id: "ortega-fig-4",
        document: Document::Ortega,
        place: "figure 4",
        title: "Speed-up on the CM-200",
        run: cm200,
    },
];

/// A partition as the tables name it, with its processors.
pub(super) type Partition = (&'static str, f64);

pub(super) const CM200: [Partition; 3] = [("16K", 16_384.0), ("32K", 32_768.0), ("64K", 65_536.0)];
pub(super) const CM5: [Partition; 5] =
    [("32", 32.0), ("64", 64.0), ("128", 128.0), ("256", 256.0), ("512", 512.0)];
/// The tables: number, polygons, partitions. The text swaps 3 and 4; the captions are right.
pub(super) const TABLES: [(u32, &str, &[Partition]); 4] = [
    (1, "small polygons on the CM-200", &CM200),
    (2, "large polygons on the CM-200", &CM200),
    (3, "small polygons on the CM-5", &CM5),
    (4, "large polygons on the CM-5", &CM5),
];
/// Rows without their labels, which are lost; slowest first.
pub(super) const ROWS: [u32; 3] = [1, 2, 3];

/// The time in a cell.
pub(super) fn time(facts: &Facts, table: u32, row: u32, partition: &str) -> Result<Seconds, ExperimentError> {
    Ok(Seconds::new(facts.given(&format!("O-T{table}-r{row}-{partition}"), "t")?))
}

fn rates() -> Result<Findings, ExperimentError> {
    let facts = Facts::load()?;
    let mut table = Table::new(
        "rates",
        &[
            ("table", ""),
            ("polygons", ""),
            ("row", ""),
            ("partition", ""),
            ("time", "s"),
            ("ours", "polygon/s"),
            ("printed", "polygon/s"),
        ],
    );
    let mut plot = Plot::new(
        "rates",
        "Fastest row of each table",
        Axis::log2("processors"),
        Axis::log10("polygons a second"),
    );
    for (number, name, partitions) in TABLES {
        for row in ROWS {
            let mut points = Vec::new();
            for &(partition, processors) in partitions {
                let id = format!("O-T{number}-r{row}-{partition}");
                let polygons = Polygons::new(facts.given(&id, "N")?);
                let time = time(&facts, number, row, partition)?;
                let rate = ortega::rate(polygons, time).get();
                table.push([
                    f64::from(number).into(),
                    polygons.get().into(),
                    f64::from(row).into(),
                    partition.into(),
                    time.get().into(),
                    rate.into(),
                    facts.printed(&id)?.into(),
                ]);
                points.push((processors, rate));
            }
            if row == ROWS[2] {
                plot = plot.with(Series::line_points(name, points).published());
            }
        }
    }
    Ok(Findings {
        tables: vec![table],
        plots: vec![plot],
        remarks: vec!["Rates are cut off, not rounded. Times are the document's measurements.".into()],
        verdict: Comparison::of_published(&["O-T#-r#-*", "O-NS", "O-NL", "O-10x", "O-600k", "O-1M"])?
            .verdict(),
    })
}

fn cm5() -> Result<Findings, ExperimentError> {
    speed_ups("cm5", "CM-5, over 32 processors", [3, 4], &CM5)
}

fn cm200() -> Result<Findings, ExperimentError> {
    speed_ups("cm200", "CM-200, over 16,384 processors", [1, 2], &CM200)
}

fn speed_ups(
    name: &str,
    title: &str,
    tables: [u32; 2],
    partitions: &[Partition],
) -> Result<Findings, ExperimentError> {
    let facts = Facts::load()?;
    let (first, least) = partitions[0];
    let mut table = Table::new(name, &[("table", ""), ("row", ""), ("processors", ""), ("speed-up", "")]);
    let mut plot = Plot::new(name, title, Axis::log2("processors"), Axis::log2("speed-up"));
    plot = plot.with(Series::line("linear", partitions.iter().map(|p| (p.1, p.1 / least)).collect()));
    // Speed-ups of the largest partition: small polygons, large ones.
    let mut most = [const { Vec::new() }; 2];
    for (number, most) in tables.into_iter().zip(&mut most) {
        let kind = if number % 2 == 1 { "small" } else { "large" };
        for row in ROWS {
            let smallest = time(&facts, number, row, first)?;
            let mut points = Vec::new();
            for &(partition, processors) in partitions {
                let speed_up = ortega::speed_up(smallest, time(&facts, number, row, partition)?).get();
                table.push([
                    f64::from(number).into(),
                    f64::from(row).into(),
                    processors.into(),
                    speed_up.into(),
                ]);
                points.push((processors, speed_up));
            }
            most.extend(points.last().map(|p| p.1));
            plot = plot.with(Series::line_points(format!("{kind} polygons, row {row}"), points).published());
        }
    }
    let names = tables.map(|t| format!("O-T{t}-su#-*"));
    let names: Vec<_> = names.iter().map(String::as_str).collect();
    let mut comparison = Comparison::of_published(&names)?;
    let [small, large] = most.map(|all| {
        let range = all.iter().fold((f64::MAX, f64::MIN), |(l, m), &s| (f64::min(l, s), f64::max(m, s)));
        (range.0, range.1)
    });
    comparison.claim(
        format!(
            "small polygons scale better than large ones: {} times with the largest partition, and {} times",
            in_words(&[[small.0, small.1]]),
            in_words(&[[large.0, large.1]])
        ),
        small.0 > large.1,
    );
    Ok(Findings {
        tables: vec![table],
        plots: vec![plot],
        remarks: vec![
            "Small polygons scale nearly linearly; large ones lengthen the loops that run serially. The plotted curves \
             are lost; they follow from the tables' times."
                .into(),
        ],
        verdict: comparison.qualitative(format!(
            "The figure's curves are lost, and no speed-up is printed: ours follow from the times that tables {} and {} print.",
            tables[0], tables[1]
        )),
    })
}
