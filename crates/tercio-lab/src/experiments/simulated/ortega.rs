//! Document 004: speed-up of the data-parallel loops.

use super::super::sweep::{pairs, sweep};
use super::super::{Axis, Comparison, Document, Experiment, ExperimentError, Findings, Plot, Series, Table};
use crate::simulators::ortega::{Machine, simulate};
use crate::workloads::synthetic::{Distribution, Spread};
use crate::workloads::{PolygonScene, ScreenPolygon};

pub(in crate::experiments) const EXPERIMENTS: &[Experiment] = &[
    Experiment {
        id: "ortega-fig-3-steps",
        document: Document::Ortega,
        place: "figure 3",
        title: "CM-5: steps of the loops against processors",
        run: cm5,
    },
    Experiment {
        id: "ortega-fig-4-steps",
        document: Document::Ortega,
        place: "figure 4",
        title: "CM-200: steps of the loops against processors",
        run: cm200,
    },
];

/// Segments in the buffer; the document gives no size.
const BUFFER: u64 = 65_536;

/// As many small polygons as in the timed set; and as many with several of 3/4 of the picture (section 6).
fn scenes() -> [(&'static str, PolygonScene); 2] {
    let distribution = |polygons| Distribution {
        width: 512,
        height: 512,
        polygons,
        visible: 0.5,
        size: [5.0, 5.0],
        spread: [Spread::Uniform; 2],
        seed: 4,
    };
    let small = distribution(228_288).triangles();
    let mut large = distribution(217_983 - 8).triangles();
    for i in 0..8 {
        let (low, high) = (i, 512 - 60 + i);
        large.polygons.push(ScreenPolygon::at_pixels(&[[low, low], [high, low], [high, high], [low, high]]));
    }
    [("small polygons", small), ("with large polygons", large)]
}

fn cm5() -> Result<Findings, ExperimentError> {
    // Published times of the slowest row of tables 3 and 4.
    let small = [5.756, 4.754, 1.482, 0.796, 0.463];
    let large = [37.326, 20.169, 12.488, 8.466, 6.220];
    findings(&[32, 64, 128, 256, 512], [&small, &large])
}

fn cm200() -> Result<Findings, ExperimentError> {
    // Published times of the slowest row of tables 1 and 2.
    findings(&[16_384, 32_768, 65_536], [&[1.894, 1.04, 0.571], &[22.094, 15.005, 8.574]])
}

fn findings(processors: &[u64], published: [&[f64]; 2]) -> Result<Findings, ExperimentError> {
    let columns = [
        ("scene", ""),
        ("processors", ""),
        ("line steps", ""),
        ("pixel steps", ""),
        ("speed-up", ""),
        ("speed-up published", ""),
    ];
    let mut table = Table::new("steps", &columns);
    let (mut series, mut last) = (Vec::new(), Vec::new());
    let scenes = scenes();
    let runs = sweep(&pairs(&scenes, processors), |&((_, scene), processors)| {
        Ok(simulate(&Machine { processors, buffer: BUFFER }, scene).0)
    })?;
    for (((name, _), times), runs) in scenes.iter().zip(published).zip(runs.chunks(processors.len())) {
        let (mut ours, mut theirs, mut first) = (Vec::new(), Vec::new(), None);
        for ((&processors, time), run) in processors.iter().zip(times).zip(runs) {
            let steps = (run.line_steps + run.pixel_steps) as f64;
            let speed_up = *first.get_or_insert(steps) / steps;
            let printed = times[0] / time;
            table.push([
                (*name).into(),
                (processors as f64).into(),
                (run.line_steps as f64).into(),
                (run.pixel_steps as f64).into(),
                speed_up.into(),
                printed.into(),
            ]);
            ours.push((processors as f64, speed_up));
            theirs.push((processors as f64, printed));
        }
        last.push(ours[ours.len() - 1].1);
        series.push(Series::line_points(*name, ours));
        series.push(Series::line_points(format!("{name}, published"), theirs).published_for(*name));
    }
    let linear = processors[processors.len() - 1] as f64 / processors[0] as f64;
    let mut comparison = Comparison::new();
    comparison.add("small polygons: near linear", last[0] / linear, 0.85, 0.2);
    comparison.claim("large polygons: speed-up is less", last[1] < last[0]);
    let plot = Plot {
        name: "speed-up".into(),
        title: "Speed-up over the smallest partition".into(),
        x: Axis::log2("processors"),
        y: Axis::log2("speed-up"),
        series,
    };
    Ok(Findings {
        tables: vec![table],
        plots: vec![plot],
        remarks: vec![
            "Steps of both loops, each taken to last as long as another; the document times frames. The data sets are lost: \
             random triangles of 5 x 5 pixels in the published number stand for the small polygons, the same with eight \
             squares of more than 3/4 of the picture for the large ones. Published are the slowest rows."
                .into(),
            format!("The buffer holds {BUFFER} segments; the document does not give its size."),
        ],
        verdict: comparison.qualitative("The data sets are lost, and the document does not say how large its buffer is."),
    })
}
