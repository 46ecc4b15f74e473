//! Sort-twice against sort-middle: figures 6-6 and 6-7.

use rayon::prelude::*;

use super::super::super::sweep::sweep;
use super::super::super::{Axis, Comparison, ExperimentError, Findings, Plot, Series, Table};
use super::super::truth;
use super::SCREEN;
use crate::models::eldridge::sort_twice::optimal_group;
use crate::simulators::ring::{Algorithm, Machine, RingRun, simulate};
use crate::units::{Instructions, Pixels, Polygons, Processors, Words};
use crate::workloads::synthetic::{Distribution, Spread};
use crate::workloads::{BoxScene, ScreenMap};

/// Polygons of the scenes, culled ones included.
const SIZES: [u32; 8] = [10_000, 20_000, 40_000, 80_000, 160_000, 320_000, 640_000, 1_280_000];
/// Instructions for a textured pixel drawn at once, and for one whose texture is deferred (section 6.5).
const TEXTURED: u64 = 202;
const DEFERRED: u64 = 98;

/// A scene on both organisations.
struct Pair {
    visible: f64,
    group: u32,
    middle: RingRun,
    twice: RingRun,
}

/// Random polygons all over the screen, half of them visible; 10 x 10 pixels, the document does not say how large.
fn scene(polygons: u32) -> BoxScene {
    let spread = [Spread::Uniform; 2];
    let size = [10.0, 10.0];
    Distribution { width: SCREEN.0, height: SCREEN.1, polygons, visible: 0.5, size, spread, seed: 66 }.boxes()
}

/// The largest power of two (the factors of 1,024) below the optimum of equation 6.7.
fn group(visible: f64) -> u32 {
    let best = optimal_group(
        Polygons::new(visible),
        Pixels::new(f64::from(SCREEN.0 * SCREEN.1)),
        Processors::new(1024.0),
        Instructions::new(84.0),
        Words::new(3.0),
        Instructions::new(15.0),
    );
    1 << (best.get().clamp(1.0, 1024.0).log2().floor() as u32)
}

fn pairs() -> Result<Vec<Pair>, ExperimentError> {
    let scenes: Vec<_> = SIZES.par_iter().map(|&polygons| scene(polygons)).collect();
    // The largest scenes take longest: each run is a task of its own, and they begin first.
    let tasks: Vec<_> = scenes.iter().rev().flat_map(|scene| [(scene, false), (scene, true)]).collect();
    let mut runs = sweep(&tasks, |&(scene, twice)| {
        let raster_pixel = if twice { DEFERRED } else { TEXTURED };
        let machine = Machine { raster_pixel, ..Machine::princeton_engine() };
        let mut algorithm = Algorithm::sort_middle(&machine);
        if twice {
            algorithm.group = group(scene.visible() as f64);
        } else {
            algorithm.strides = vec![16, 1];
        }
        let map = ScreenMap::columns(SCREEN.0, SCREEN.1, algorithm.group);
        Ok(simulate(&machine, &algorithm, &map, scene)?)
    })?;
    let pair = |scene: &BoxScene| {
        let visible = scene.visible() as f64;
        // From behind: the smallest scene's, and of these sort-twice before sort-middle.
        let (twice, middle) = (runs.pop()?, runs.pop()?);
        Some(Pair { visible, group: group(visible), middle, twice })
    };
    Ok(scenes.iter().map_while(pair).collect())
}

/// Where the second curve falls below the first, interpolated between scenes.
fn crossover(points: &[(f64, f64, f64)]) -> Option<f64> {
    points.windows(2).find(|w| w[0].2 >= w[0].1 && w[1].2 < w[1].1).map(|w| {
        let (before, after) = (w[0].2 - w[0].1, w[1].1 - w[1].2);
        w[0].0 + (w[1].0 - w[0].0) * before / (before + after)
    })
}

fn findings(cost: impl Fn(&RingRun) -> u64, title: &str, remark: &str) -> Result<Findings, ExperimentError> {
    let columns = [
        ("visible polygons", ""),
        ("sort-middle", "instructions"),
        ("sort-twice", "instructions"),
        ("group", "processors"),
    ];
    let mut table = Table::new("instructions", &columns);
    let mut points = Vec::new();
    for pair in pairs()? {
        let (middle, twice) = (cost(&pair.middle) as f64, cost(&pair.twice) as f64);
        table.push([pair.visible.into(), middle.into(), twice.into(), f64::from(pair.group).into()]);
        points.push((pair.visible, middle, twice));
    }
    let mut comparison = Comparison::new();
    let last = points[points.len() - 1];
    comparison.add("sort-twice wins the largest scene", truth(last.2 < last.1), 1.0, 0.0);
    comparison.add("sort-middle wins the smallest scene", truth(points[0].1 < points[0].2), 1.0, 0.0);
    let plot = Plot {
        name: "instructions".into(),
        title: title.into(),
        x: Axis::log10("visible polygons"),
        y: Axis::log10("instructions"),
        series: vec![
            Series::line_points("sort-middle, strides 16 and 1", points.iter().map(|p| (p.0, p.1)).collect()),
            Series::line_points("sort-twice", points.iter().map(|p| (p.0, p.2)).collect()),
        ],
    };
    let crossing = crossover(&points).map_or("Sort-twice never falls below sort-middle.".to_owned(), |p| {
        format!("Sort-twice is cheaper from about {p:.0} visible polygons on.")
    });
    let remarks = vec![
        "Scenes as the document describes them: random polygons all over the screen, half of them visible. Their size is \
         not given; here they are 10 x 10 pixels."
            .into(),
        remark.into(),
        crossing,
    ];
    let verdict = comparison.qualitative("The size of the random polygons is not given.");
    Ok(Findings { tables: vec![table], plots: vec![plot], remarks, verdict })
}

/// Figure 6-6.
pub fn communication() -> Result<Findings, ExperimentError> {
    let remark = "The document predicts 50,503 visible polygons for the crossing, with a slip in equation 6.8; \
        without it the formula gives 62,647.";
    findings(RingRun::communication, "Instructions of communication", remark)
}

/// Figure 6-7.
pub fn frames() -> Result<Findings, ExperimentError> {
    let remark = "With geometry and rasterization, all polygons textured: 202 instructions a pixel for sort-middle, 98 for \
        sort-twice, which defers textures. The document has sort-twice ahead beyond 64,000 polygons.";
    findings(RingRun::instructions, "Instructions of a frame", remark)
}
