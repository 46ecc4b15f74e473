//! Document 004: speed-up of the data-parallel loops.

use super::super::sweep::{pairs, sweep};
use super::super::{
    Axis, Comparison, Document, Experiment, ExperimentError, Findings, Fit, Plot, Series, Table,
};
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

/// Segments in the buffer of the plotted runs; the document gives no size.
const BUFFER: u64 = 65_536;
/// Sizes that are tried.
const BUFFERS: [u64; 6] = [1 << 10, 1 << 12, 1 << 14, 1 << 16, 1 << 18, 1 << 20];
/// Numbers of large polygons that are tried; the document has several.
const LARGE: [i32; 5] = [2, 8, 32, 64, 128];

/// As many small polygons as in the timed set; and as many with several of 3/4 of the picture (section 6).
fn scenes() -> [(&'static str, PolygonScene); 2] {
    [("small polygons", small()), ("with large polygons", with_large(8))]
}

fn random(polygons: u32) -> PolygonScene {
    let distribution = Distribution {
        width: 512,
        height: 512,
        polygons,
        visible: 0.5,
        size: [5.0, 5.0],
        spread: [Spread::Uniform; 2],
        seed: 4,
    };
    distribution.triangles()
}

fn small() -> PolygonScene {
    random(228_288)
}

/// With `number` squares of more than 3/4 of the picture.
fn with_large(number: i32) -> PolygonScene {
    let mut scene = random(217_983 - number.unsigned_abs());
    for i in 0..number {
        let i = i % 50;
        let (low, high) = (i, 512 - 60 + i);
        scene.polygons.push(ScreenPolygon::at_pixels(&[[low, low], [high, low], [high, high], [low, high]]));
    }
    scene
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
    let mut series = Vec::new();
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
        series.push(Series::line_points(*name, ours));
        series.push(Series::line_points(format!("{name}, published"), theirs).published_for(*name));
    }
    // Speed-up from the fewest to the most processors, for one scene and buffer.
    let ends = [processors[0], processors[processors.len() - 1]];
    let gain = |scene: &PolygonScene, buffer: u64| {
        let [first, last] = ends.map(|processors| {
            let run = simulate(&Machine { processors, buffer }, scene).0;
            (run.line_steps + run.pixel_steps) as f64
        });
        first / last
    };
    let mut swept = Table::new("swept", &[("large polygons", ""), ("buffer", "segment"), ("speed-up", "")]);
    let mut comparison = Comparison::new();
    let ratio = |times: &[f64]| times[0] / times[times.len() - 1];
    let print = |times: &[f64]| format!("{:.2}", ratio(times));
    let by_buffer = sweep(&BUFFERS, |&buffer| Ok((buffer as f64, gain(&scenes[0].1, buffer))))?;
    by_buffer.iter().for_each(|p| swept.push([0.0.into(), p.0.into(), p.1.into()]));
    comparison.fit(Fit::new(
        format!("speed-up {} of small polygons", print(published[0])),
        "buffer in segments",
        &print(published[0]),
        by_buffer,
    ));
    let alone = gain(&scenes[0].1, BUFFER);
    let by_number = sweep(&LARGE, |&number| Ok((f64::from(number), gain(&with_large(number), BUFFER))))?;
    let less = by_number.iter().map(|&(number, gain)| (number, gain / alone)).collect();
    by_number.iter().for_each(|p| swept.push([p.0.into(), (BUFFER as f64).into(), p.1.into()]));
    comparison.fit(Fit::new(
        format!("speed-up {} with large polygons", print(published[1])),
        "number of large polygons",
        &print(published[1]),
        by_number,
    ));
    // That it is less would hold by a hair: how much less is what the times say.
    let share = format!("{:.2}", ratio(published[1]) / ratio(published[0]));
    let number = format!("speed-up with large polygons over that of small ones {share}");
    comparison.fit(Fit::new(number, "number of large polygons", &share, less));
    let plot = Plot {
        name: "speed-up".into(),
        title: "Speed-up over the smallest partition".into(),
        x: Axis::log2("processors"),
        y: Axis::log2("speed-up"),
        series,
    };
    Ok(Findings {
        tables: vec![table, swept, comparison.intervals()],
        plots: vec![plot],
        remarks: vec![
            "Steps of both loops, each taken to last as long as another; the document times frames. The data sets are lost: \
             random triangles of 5 x 5 pixels in the published number stand for the small polygons, the same with eight \
             squares of more than 3/4 of the picture for the large ones. Published are the slowest rows."
                .into(),
            format!(
                "The plotted runs have a buffer of {BUFFER} segments and eight large polygons; the document gives \
                 neither, so both are swept."
            ),
        ],
        verdict: comparison.qualitative("The data sets are lost, and the document does not say how large its buffer is."),
    })
}
