//! Document 003: raster cycles, silicon, and the best array for our own scenes.

use super::super::{
    Axis, Comparison, Document, Experiment, ExperimentError, Findings, Plot, Scale, Series, Table,
};
use super::model_boxes;
use crate::models::mcmanus::{self, optimum::optimal_side};
use crate::published::ToleranceSource;
use crate::simulators::mcmanus::{AreaModel, RasterCycles, raster_cycles, renderers, silicon};
use crate::units::{Length, Pixels};
use crate::workloads::BoxScene;
use crate::workloads::synthetic::{Distribution, Spread};

const SIZE: (u32, u32) = (512, 512);
/// Raster cycles a second (section 5.1).
const RATE: f64 = 1e6;

pub(in crate::experiments) const EXPERIMENTS: &[Experiment] = &[
    Experiment {
        id: "mcmanus-table-1-scenes",
        document: Document::McManus,
        place: "table 1, equation 6",
        title: "Raster cycles of our scenes, counted and predicted",
        run: table_1,
    },
    Experiment {
        id: "mcmanus-fig-3-scenes",
        document: Document::McManus,
        place: "figure 3",
        title: "Time against silicon for a terrain",
        run: figure_3,
    },
    Experiment {
        id: "mcmanus-table-3-scenes",
        document: Document::McManus,
        place: "table 3",
        title: "The best array of our scenes",
        run: table_3,
    },
];

fn sides() -> impl Iterator<Item = u32> {
    (0..10).map(|k| 1 << k)
}

/// Scenes from very small to large polygons.
fn scenes() -> Result<Vec<(&'static str, BoxScene)>, ExperimentError> {
    let random = |polygons, side| Distribution {
        width: SIZE.0,
        height: SIZE.1,
        polygons,
        visible: 1.0,
        size: [side, side],
        spread: [Spread::Uniform; 2],
        seed: 3,
    };
    Ok(vec![
        ("terrain", model_boxes("builtin:terrain@100k", SIZE)?),
        ("teapot", model_boxes("builtin:teapot@10k", SIZE)?),
        ("gyroid", model_boxes("builtin:gyroid@50k", SIZE)?),
        // The mean boxes of table 3: Frame20, ShuttleB, Room.
        ("squares of 23.91 pixels", random(50_041, 4.89).boxes()),
        ("squares of 367 pixels", random(5_000, 19.17).boxes()),
        ("squares of 23,236 pixels", random(200, 152.4).boxes()),
    ])
}

/// N: the mean number of pixels of the visible boxes on the screen.
fn mean_area(scene: &BoxScene) -> f64 {
    let one = raster_cycles(scene, SIZE, 1);
    one.overlap()
}

/// Equation 6.
fn predicted(area: f64, side: f64) -> f64 {
    mcmanus::overlap_of_area(Length::new(side), Pixels::new(area)).get()
}

fn cycles(scene: &BoxScene) -> Vec<RasterCycles> {
    sides().map(|side| raster_cycles(scene, SIZE, side)).collect()
}

fn table_1() -> Result<Findings, ExperimentError> {
    let columns = [
        ("scene", ""),
        ("region", "pixels a side"),
        ("raster cycles", ""),
        ("overlap", ""),
        ("overlap by equation 6", ""),
        ("fullest bin", "polygons"),
    ];
    let mut table = Table::new("cycles", &columns);
    let (mut series, mut comparison) = (Vec::new(), Comparison::new());
    for (name, scene) in scenes()? {
        let area = mean_area(&scene);
        let runs = cycles(&scene);
        let mut worst = 0.0;
        for run in &runs {
            let side = f64::from(run.side);
            let formula = predicted(area, side);
            table.push([
                name.into(),
                side.into(),
                (run.cycles as f64).into(),
                run.overlap().into(),
                formula.into(),
                (run.fullest as f64).into(),
            ]);
            // The formula ignores the border: where box and region together are half a screen, boxes that stay inside
            // meet fewer regions than it predicts.
            if area.sqrt() + side <= 0.5 * f64::from(SIZE.0) {
                worst = f64::max(worst, (run.overlap() / formula - 1.0).abs());
            }
        }
        // What the document finds for its own image.
        comparison.claim(
            format!("{name}: at most {:.1} % from equation 6, the document's 7.8 % or less", 100.0 * worst),
            worst <= 0.078,
        );
        series.push(Series::points(name, runs.iter().map(|r| (f64::from(r.side), r.overlap())).collect()));
        let (label, ends) = (format!("{name}, equation 6"), [1.0, 512.0]);
        series.push(Series::formula(label, Scale::Log2, ends, |side| predicted(area, side)).like(name));
    }
    let published = [23.91, 8.36, 3.64, 2.06, 1.46, 1.21, 1.09, 1.04, 1.01, 1.00];
    let points = sides().map(f64::from).zip(published).collect();
    series.push(Series::points("Frame20 of the document", points).published());
    let plot = Plot {
        name: "overlap".into(),
        title: "Regions that a bounding box meets".into(),
        x: Axis::log2("side of a region (pixels)"),
        y: Axis::log10("overlap factor"),
        series,
    };
    Ok(Findings {
        tables: vec![table],
        plots: vec![plot],
        remarks: vec![
            "The scenes of figure 8 are lost; these are ours. Equation 6 knows the mean area of the boxes only: for squares of \
             one size it agrees with counting as long as box and region together are at most half as wide as the screen, whose \
             border it does not know; for models with boxes of many sizes and shapes it does not have to."
                .into(),
        ],
        verdict: comparison.qualitative(
            "The scenes are lost; the bound is that of the document for its own.",
        ),
    })
}

fn figure_3() -> Result<Findings, ExperimentError> {
    let scene = model_boxes("builtin:terrain@100k", SIZE)?;
    let runs = cycles(&scene);
    let renderers = renderers(&runs, &AreaModel::PUBLISHED, RATE);
    let columns =
        [("region", "pixels a side"), ("renderers", ""), ("silicon", "square inches"), ("time", "s")];
    let mut table = Table::new("points", &columns);
    let mut series = Vec::new();
    for (run, renderer) in runs.iter().zip(&renderers) {
        let mut points = Vec::new();
        for count in [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000] {
            let [area, time] = renderer.point(run, count, 1.0 / RATE);
            table.push([f64::from(run.side).into(), (count as f64).into(), area.into(), time.into()]);
            points.push((area, time));
        }
        series.push(Series::line_points(format!("{0}x{0}", run.side), points));
    }
    let best = silicon::best(&renderers).map_or(0, |r| r.side);
    let mut comparison = Comparison::new();
    comparison.claim("best array is neither the smallest nor the largest", (4..=64).contains(&best));
    let plot = Plot {
        name: "silicon".into(),
        title: "Time of a frame against silicon".into(),
        x: Axis::log10("silicon (square inches)"),
        y: Axis::log10("time (s)"),
        series,
    };
    Ok(Findings {
        tables: vec![table],
        plots: vec![plot],
        remarks: vec![
            "A terrain of 100,000 triangles stands for the document's, figure 8a. Perfect balance between the renderers, as in \
             the document."
                .into(),
            format!("The best array here is {best}x{best}; in the document it is 16x16."),
        ],
        verdict: comparison.qualitative("The scene is lost."),
    })
}

fn table_3() -> Result<Findings, ExperimentError> {
    let columns = [
        ("scene", ""),
        ("mean box", "pixels"),
        ("best array counted", "pixels a side"),
        ("best array by equation 13", "pixels a side"),
    ];
    let mut table = Table::new("arrays", &columns);
    let mut comparison = Comparison::new();
    let published = [
        ("squares of 23.91 pixels", 16.0),
        ("squares of 367 pixels", 32.0),
        ("squares of 23,236 pixels", 64.0),
    ];
    for (name, scene) in scenes()? {
        let area = mean_area(&scene);
        let best =
            silicon::best(&renderers(&cycles(&scene), &AreaModel::PUBLISHED, RATE)).map_or(0, |r| r.side);
        let formula = optimal_side(Pixels::new(area)).get();
        table.push([name.into(), area.into(), f64::from(best).into(), formula.into()]);
        if let Some((_, side)) = published.iter().find(|p| p.0 == name) {
            comparison.add(name, f64::from(best), *side, 0.0, ToleranceSource::Exact);
        }
    }
    Ok(Findings {
        tables: vec![table],
        plots: Vec::new(),
        remarks: vec![
            "Squares with the mean boxes of Frame20, ShuttleB and Room give the document's best arrays; our models are \
             listed beside them."
                .into(),
        ],
        verdict: comparison.qualitative("The scenes are lost; squares with their mean boxes stand for them."),
    })
}
