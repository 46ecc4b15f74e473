//! Document 000, chapters 4 to 6: the figures from its simulator.

mod appendix_a;
mod distribution;
mod duplication;
mod line_locked;
mod load;
mod sort_last;
mod sort_twice;

use super::super::sweep::{pairs, sweep};
use super::super::{Cell, Document, Experiment, ExperimentError, Table};
use crate::simulators::ring::{Algorithm, Machine, RingRun, simulate};
use crate::workloads::synthetic::{Distribution, Spread};
use crate::workloads::{BoxScene, ScreenMap};

/// The document's screen.
const SCREEN: (u32, u32) = (768, 512);

/// Where the second curve falls below the first, interpolated between scenes.
fn crossover(points: &[(f64, f64, f64)]) -> Option<f64> {
    points.windows(2).find(|w| w[0].2 >= w[0].1 && w[1].2 < w[1].1).map(|w| {
        let (before, after) = (w[0].2 - w[0].1, w[1].1 - w[1].2);
        w[0].0 + (w[1].0 - w[0].0) * before / (before + after)
    })
}

const fn experiment(
    id: &'static str,
    place: &'static str,
    title: &'static str,
    run: fn() -> Result<super::super::Findings, ExperimentError>,
) -> Experiment {
    Experiment { id, document: Document::Eldridge, place, title, run }
}

pub(in crate::experiments) const EXPERIMENTS: &[Experiment] = &[
    experiment("eldridge-fig-4-1", "figure 4-1", "Sort-first: polygons on each processor", load::sort_first),
    experiment("eldridge-fig-4-2", "figure 4-2", "Sort-middle: shifts for each polygon", load::shifts),
    experiment(
        "eldridge-fig-4-3-pixels",
        "section 4.4.2, figure 4-3",
        "Sparse sort-last on the ring, pixel by pixel, against dense",
        sort_last::sparse_and_dense,
    ),
    experiment(
        "eldridge-fig-5-3",
        "figure 5-3",
        "Sparse against dense network",
        distribution::sparse_and_dense,
    ),
    experiment("eldridge-fig-5-5", "figure 5-5", "Distribution by strides", distribution::strides),
    experiment("eldridge-fig-5-6", "figure 5-6", "Polygons kept by several processors", duplication::copies),
    experiment("eldridge-fig-5-7", "figure 5-7", "Duplication unbalances geometry", duplication::imbalance),
    experiment("eldridge-fig-5-8", "figure 5-8", "Duplication and strides together", duplication::surface),
    experiment(
        "eldridge-fig-5-9",
        "figure 5-9",
        "Temporal locality: visible polygons by column",
        load::locality,
    ),
    experiment(
        "eldridge-fig-6-6",
        "figure 6-6",
        "Sort-twice against sort-middle: communication",
        sort_twice::communication,
    ),
    experiment(
        "eldridge-fig-6-7",
        "figure 6-7",
        "Sort-twice against sort-middle: whole frames",
        sort_twice::frames,
    ),
    experiment(
        "eldridge-chapter-7",
        "chapter 7, section 8.2",
        "The line-locked renderer: lines of a picture and whole video frames",
        line_locked::renderer,
    ),
    experiment(
        "eldridge-fig-7-1",
        "figures 7-1 to 7-4",
        "Four pictures: rates and busiest processors",
        line_locked::pictures,
    ),
    experiment("eldridge-fig-a-2", "figure A-2", "A screen map for four processors", appendix_a::screen_map),
    experiment(
        "eldridge-fig-a-6",
        "figure A-6",
        "A polygon's way in strides of 4 and 1",
        appendix_a::strides,
    ),
    experiment("eldridge-fig-a-7", "figure A-7", "Destinations with groups", appendix_a::groups),
];

/// The remark about all scenes here.
const SCENES: &str = "The document's scenes are lost. The teapot is tercio's, drawn as large as the screen allows; \
    the other three have the document's numbers of polygons, its share of visible ones and its mean width of 3.8 \
    columns (figure 4-1), with columns normally distributed round the middle. Deviations of 25 and 30 columns give \
    the clumping of figure 4-1, where the busiest processor has 16.9 times the mean.";

/// The scenes, with the document's numbers of polygons (figures 3-2 to 3-4).
fn scenes() -> Result<Vec<(&'static str, BoxScene)>, ExperimentError> {
    Ok(vec![
        ("teapot", super::model_boxes("builtin:teapot@9408", SCREEN)?),
        ("like the teapot", clumped(9_408, 6_294, 25.0).boxes()),
        ("like the crocodile", clumped(34_404, 25_270, 30.0).boxes()),
        ("like Beethoven", clumped(5_030, 4_021, 30.0).boxes()),
    ])
}

/// Deviations of the columns that are tried: the document's scenes are lost, and how far their polygons are clumped is not
/// stated.
const DEVIATIONS: [f64; 9] = [8.0, 12.0, 16.0, 20.0, 25.0, 30.0, 40.0, 60.0, 100.0];

/// The document's scenes as (name, polygons, visible ones), with what is called their clumping.
const DOCUMENTED: [(&str, u32, u32, &str); 3] = [
    ("like the teapot", 9_408, 6_294, "deviation of the teapot's columns"),
    ("like the crocodile", 34_404, 25_270, "deviation of the crocodile's columns"),
    ("like Beethoven", 5_030, 4_021, "deviation of Beethoven's columns"),
];

/// A quantity of one of the document's scenes by its clumping.
fn by_clumping(
    polygons: u32,
    visible: u32,
    quantity: impl Fn(&BoxScene) -> Result<f64, ExperimentError> + Sync,
) -> Result<Vec<(f64, f64)>, ExperimentError> {
    sweep(&DEVIATIONS, |&deviation| {
        Ok((deviation, quantity(&clumped(polygons, visible, deviation).boxes())?))
    })
}

/// Adds the points of a sweep to a table.
fn record(table: &mut Table, scene: &str, points: &[(f64, f64)]) {
    points.iter().for_each(|p| table.push([scene.into(), p.0.into(), p.1.into()]));
}

fn clumped(polygons: u32, visible: u32, deviation: f64) -> Distribution {
    Distribution {
        width: SCREEN.0,
        height: SCREEN.1,
        polygons,
        visible: f64::from(visible) / f64::from(polygons),
        size: [3.8, 12.0],
        spread: [Spread::Normal { deviation }, Spread::Uniform],
        seed: 1995,
    }
}

/// A frame of the Princeton Engine with `processors` processors and a column each.
fn frame(
    scene: &BoxScene,
    processors: u32,
    change: impl FnOnce(&mut Algorithm),
) -> Result<RingRun, ExperimentError> {
    let machine = Machine { processors, ..Machine::princeton_engine() };
    let mut algorithm = Algorithm::sort_middle(&machine);
    change(&mut algorithm);
    let map = ScreenMap::columns(SCREEN.0, SCREEN.1, algorithm.group);
    let run = simulate(&machine, &algorithm, &map, scene)?;
    if run.checks.passed() {
        Ok(run)
    } else {
        Err(format!("the checks of appendix A.3 fail: {:?}", run.checks).into())
    }
}

/// Instructions of communication for each visible polygon.
fn communication(run: &RingRun) -> f64 {
    run.communication() as f64 / run.visible.max(1) as f64
}

/// A scene's name and its points.
type Curve = (&'static str, Vec<(f64, f64)>);

/// A quantity of each scene as a function of a parameter with the values `values`.
fn curves(
    scenes: &[(&'static str, BoxScene)],
    values: &[u32],
    quantity: impl Fn(&BoxScene, u32) -> Result<f64, ExperimentError> + Sync,
) -> Result<Vec<Curve>, ExperimentError> {
    let points = sweep(&pairs(scenes, values), |((_, scene), value)| {
        Ok((f64::from(*value), quantity(scene, *value)?))
    })?;
    let names = scenes.iter().map(|s| s.0);
    Ok(names.zip(points.chunks(values.len().max(1)).map(<[_]>::to_vec)).collect())
}

/// The point with the least quantity, the first of equal ones.
fn least(points: &[(f64, f64)]) -> (f64, f64) {
    points.iter().copied().fold((1.0, f64::MAX), |a, b| if b.1 < a.1 { b } else { a })
}

/// One number per processor or column: rows of a table whose first cell is `name`, and the points of a curve.
fn profile(
    table: &mut Table,
    name: impl Into<Cell> + Copy,
    numbers: impl Iterator<Item = u32>,
) -> Vec<(f64, f64)> {
    let points: Vec<_> = numbers.enumerate().map(|(place, n)| (place as f64, f64::from(n))).collect();
    points.iter().for_each(|&(place, n)| table.push([name.into(), place.into(), n.into()]));
    points
}

/// The first stage's stride, and the stage of stride 1 with which every distribution ends.
fn strides(first: u32) -> Vec<u32> {
    if first == 1 { vec![1] } else { vec![first, 1] }
}
