//! Sort-twice against sort-middle: figures 6-6 and 6-7.

use tercio_mesh::loops::prelude::*;

use super::super::super::hidden::short;
use super::super::super::sweep::sweep;
use super::super::super::{Axis, Comparison, ExperimentError, Findings, Fit, Plot, Series, Table};
use super::{SCREEN, crossover};
use crate::models::eldridge::distribution::two_stages;
use crate::models::eldridge::sort_twice::{self, optimal_group};
use crate::published::ToleranceSource;
use crate::simulators::ring::{Algorithm, Machine, RingRun, simulate};
use crate::units::{Instructions, Pixels, Polygons, Processors, Words};
use crate::workloads::synthetic::{Distribution, Spread};
use crate::workloads::{BoxScene, ScreenMap};

/// Polygons of the scenes, culled ones included.
const SIZES: [u32; 8] = [10_000, 20_000, 40_000, 80_000, 160_000, 320_000, 640_000, 1_280_000];
/// Instructions for a pixel textured at once, and for one with deferred texturing (section 6.5).
const TEXTURED: u64 = 202;
const DEFERRED: u64 = 98;

/// A scene with both organisations.
struct Pair {
    /// All polygons; about half of them are visible.
    polygons: f64,
    visible: f64,
    group: u32,
    middle: RingRun,
    twice: RingRun,
}

/// Why the figures cannot be reproduced exactly.
const WHY: &str = "The size of the random polygons is not given.";
/// The names of the curves.
const SORT_MIDDLE: &str = "sort-middle, strides 16 and 1";
const SORT_TWICE: &str = "sort-twice";
/// The first stride of sort-middle.
const FIRST_STRIDE: u32 = 16;

/// A screen of as many pixels with a column for each of the 1,024 processors; the document's leaves 256 without one.
const WIDE: (u32, u32) = (1024, 384);

/// The side of the polygons of figure 6-6 in pixels: the document gives no size.
const SIDE: f64 = 10.0;

/// Random polygons all over a screen, half of them visible, squares of `side` pixels.
fn scene_of((width, height): (u32, u32), polygons: u32, side: f64) -> BoxScene {
    let spread = [Spread::Uniform; 2];
    let size = [side, side];
    Distribution { width, height, polygons, visible: 0.5, size, spread, seed: 66 }.boxes()
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

/// A frame with one of the two organisations.
fn run_one(screen: (u32, u32), scene: &BoxScene, twice: bool) -> Result<RingRun, ExperimentError> {
    let raster_pixel = if twice { DEFERRED } else { TEXTURED };
    let machine = Machine { raster_pixel, ..Machine::princeton_engine() };
    let mut algorithm = Algorithm::sort_middle(&machine);
    if twice {
        algorithm.group = group(scene.visible() as f64);
    } else {
        algorithm.strides = super::strides(FIRST_STRIDE);
    }
    let map = ScreenMap::columns(screen.0, screen.1, algorithm.group);
    Ok(simulate(&machine, &algorithm, &map, scene)?)
}

fn pairs(side: f64) -> Result<Vec<Pair>, ExperimentError> {
    let scenes: Vec<_> = SIZES.par_iter().map(|&polygons| scene_of(SCREEN, polygons, side)).collect();
    // The largest scenes take longest, so they start first; each run is a task of its own.
    let tasks: Vec<_> = scenes.iter().rev().flat_map(|scene| [(scene, false), (scene, true)]).collect();
    let mut runs = sweep(&tasks, |&(scene, twice)| run_one(SCREEN, scene, twice))?;
    let pair = |scene: &BoxScene| {
        let visible = scene.visible() as f64;
        // Taken from the end: the smallest scene first, and for each scene sort-twice before sort-middle.
        let (twice, middle) = (runs.pop()?, runs.pop()?);
        Some(Pair { polygons: scene.boxes.len() as f64, visible, group: group(visible), middle, twice })
    };
    Ok(scenes.iter().map_while(pair).collect())
}

/// Equations 6.5 (with 78 for 84) and 6.3: instructions of sort-twice's communication.
fn predicted_twice(pair: &Pair) -> f64 {
    let (n, g) = (Processors::new(1024.0), Processors::new(f64::from(pair.group)));
    let screen = Pixels::new(f64::from(SCREEN.0 * SCREEN.1));
    let half_pass = sort_twice::grouped_pass(Words::new(42.0), Instructions::new(30.0), Processors::new(1.0));
    let middle = sort_twice::sort_middle_stage(Polygons::new(pair.visible), n, g, half_pass);
    let last = sort_twice::composite(screen, g, n, Words::new(3.0), Instructions::new(15.0));
    (middle + last).get()
}

/// Equation 5.5 with the first stride of the simulation: instructions of sort-middle's communication.
fn predicted_middle(visible: f64) -> f64 {
    let [n, d] = [1024, FIRST_STRIDE].map(|n| Processors::new(f64::from(n)));
    two_stages(Polygons::new(visible), n, d, Words::new(42.0), Instructions::new(30.0)).get()
}

/// Sides of the boxes that are tried.
const SIDES: [f64; 10] = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0];

/// Visible polygons from which sort-twice is cheaper, by `cost`, for boxes of `side` pixels; NaN if there are none among the
/// scenes that are tried.
fn crossing(screen: (u32, u32), side: f64, cost: impl Fn(&RingRun) -> u64) -> Result<f64, ExperimentError> {
    let mut points = Vec::new();
    for polygons in [20_000, 40_000, 80_000, 160_000] {
        let scene = scene_of(screen, polygons, side);
        let (twice, middle) = (run_one(screen, &scene, true)?, run_one(screen, &scene, false)?);
        points.push((scene.visible() as f64, cost(&middle) as f64, cost(&twice) as f64));
    }
    Ok(crossover(&points).unwrap_or(f64::NAN))
}

fn findings(
    (pairs, side): (&[Pair], f64),
    cost: impl Fn(&RingRun) -> u64,
    title: &str,
    remark: &str,
) -> Result<(Findings, Comparison), ExperimentError> {
    let columns = [
        ("visible polygons", ""),
        ("sort-middle", "instructions"),
        ("sort-twice", "instructions"),
        ("group", "processors"),
    ];
    let mut table = Table::new("instructions", &columns);
    let mut points = Vec::new();
    for pair in pairs {
        let (middle, twice) = (cost(&pair.middle) as f64, cost(&pair.twice) as f64);
        table.push([pair.visible.into(), middle.into(), twice.into(), f64::from(pair.group).into()]);
        points.push((pair.visible, middle, twice));
    }
    let mut comparison = Comparison::new();
    let last = points[points.len() - 1];
    comparison.claim("sort-twice wins the largest scene", last.2 < last.1);
    comparison.claim("sort-middle wins the smallest scene", points[0].1 < points[0].2);
    let plot = Plot {
        name: "instructions".into(),
        title: title.into(),
        x: Axis::log10("visible polygons"),
        y: Axis::log10("instructions"),
        series: vec![
            Series::line_points(SORT_MIDDLE, points.iter().map(|p| (p.0, p.1)).collect()),
            Series::line_points(SORT_TWICE, points.iter().map(|p| (p.0, p.2)).collect()),
        ],
    };
    let crossing = crossover(&points).map_or("Sort-twice never falls below sort-middle.".to_owned(), |p| {
        format!("Sort-twice is cheaper from about {p:.0} visible polygons on.")
    });
    let remarks = vec![
        format!(
            "Scenes as the document describes them: random polygons all over the screen, half of them visible. Their size is not \
             given; here they are squares of {} pixels.",
            short(side)
        ),
        remark.into(),
        crossing,
    ];
    let verdict = comparison.qualitative(WHY);
    Ok((Findings { tables: vec![table], plots: vec![plot], remarks, verdict }, comparison))
}

/// Sort-middle's instructions over those of equation 5.5, and the crossing with sort-twice, by the side of the polygons.
fn by_side(screen: (u32, u32)) -> Result<Vec<[f64; 3]>, ExperimentError> {
    sweep(&[1.0, 2.0, 3.0, 4.0, 6.0, 10.0], |&side| {
        let scene = scene_of(screen, 320_000, side);
        let run = run_one(screen, &scene, false)?;
        let ratio = run.communication() as f64 / predicted_middle(scene.visible() as f64);
        Ok([side, ratio, crossing(screen, side, RingRun::communication)?])
    })
}

/// What "closely matches" says of sort-middle: within the same 5 % as sort-twice, on the document's screen. The wider one shows what
/// the difference comes from. Also where the curves cross, in words.
fn compare_sides(comparison: &mut Comparison) -> Result<(Table, String), ExperimentError> {
    let columns = [
        ("columns of the screen", ""),
        ("side of a box", "px"),
        ("sort-middle over equation 5.5", ""),
        ("crossing, visible polygons", ""),
    ];
    let mut table = Table::new("sides", &columns);
    let mut crossings = Vec::new();
    for screen in [SCREEN, WIDE] {
        let sides = by_side(screen)?;
        for &[side, ratio, crossing] in &sides {
            table.push([f64::from(screen.0).into(), side.into(), ratio.into(), crossing.into()]);
        }
        if screen == SCREEN {
            // "Closely matches" is no number: 1.0 stands for 0.95 to 1.05.
            comparison.fit(Fit::new(
                "sort-middle over equation 5.5 within 5 %",
                "side of the boxes in pixels",
                "1.0",
                sides.iter().map(|s| (s[0], s[1])).collect(),
            ));
        }
        crossings.push(format!("with {} columns {}", screen.0, crossings_of(&sides)));
    }
    Ok((table, format!("Sort-twice and sort-middle cross, {}.", crossings.join("; "))))
}

/// Where the curves cross by the sides of the boxes, and for which they do not.
fn crossings_of(sides: &[[f64; 3]]) -> String {
    let (found, not): (Vec<&[f64; 3]>, Vec<&[f64; 3]>) = sides.iter().partition(|side| side[2].is_finite());
    let ends = |of: fn(f64, f64) -> f64| found.iter().map(|side| side[2]).reduce(of);
    let never = not.iter().map(|side| side[0].to_string()).collect::<Vec<_>>().join(", ");
    let never = if never.is_empty() { never } else { format!("not with boxes of {never} pixels") };
    match (ends(f64::min), ends(f64::max)) {
        (Some(least), Some(most)) => {
            let comma = if never.is_empty() { "" } else { ", and " };
            format!("at {least:.0} to {most:.0} visible polygons with boxes of 1 to 10 pixels{comma}{never}")
        }
        _ => never,
    }
}

/// Figure 6-6.
pub fn communication() -> Result<Findings, ExperimentError> {
    let remark = "The document predicts 50,503 visible polygons for the crossing, with a slip in equation 6.8; \
        without it the formula gives 62,647.";
    let pairs = pairs(SIDE)?;
    let title = "Instructions of communication";
    let (mut findings, mut comparison) = findings((&pairs, SIDE), RingRun::communication, title, remark)?;
    for pair in &pairs {
        let ratio = pair.twice.communication() as f64 / predicted_twice(pair);
        // "Closely matches": within the 5 % that a plot of this kind can show.
        let name = format!("sort-twice over its equations, {} polygons", pair.visible);
        comparison.add(name, ratio, 1.0, 0.05, ToleranceSource::Words);
    }
    let equations = |of: &dyn Fn(&Pair) -> f64| pairs.iter().map(|p| (p.visible, of(p))).collect();
    let middle =
        Series::line_points("sort-middle, equation 5.5", equations(&|p| predicted_middle(p.visible)));
    let twice = Series::line_points("sort-twice, equations 6.5 and 6.3", equations(&predicted_twice));
    // The document's curves are lost; it says that they match its equations, and where they cross.
    findings.plots[0].series.extend([
        middle.like(SORT_MIDDLE),
        twice.like(SORT_TWICE),
        Series::printed_places("crossing in print", [50_503.0]),
    ]);
    let (sides, crossings) = compare_sides(&mut comparison)?;
    findings.tables.extend([sides, comparison.intervals()]);
    findings.remarks.push(crossings);
    findings.remarks.push(
        "The figure's curves are lost; its caption says that both simulated times closely match the prediction. Sort-twice does \
         so in every scene, with 78 for the 84 of equation 6.5, whatever the size of the polygons. Sort-middle takes a \
         quarter more than equation 5.5 on the document's screen of 768 columns, even with polygons of a pixel: 256 of the \
         1,024 processors have no column, and the ring is busiest where the columns begin. On a screen with a column for \
         each processor what is left is that equation 5.5 counts one destination a polygon, and a polygon has as many as \
         it has columns."
            .into(),
    );
    findings.verdict = comparison.qualitative(WHY);
    Ok(findings)
}

/// Figure 6-7.
pub fn frames() -> Result<Findings, ExperimentError> {
    let remark = "With geometry and rasterization, all polygons textured: 202 instructions a pixel for sort-middle, 98 for \
        sort-twice, which defers textures. The document has sort-twice ahead beyond 64,000 polygons.";
    let mut swept =
        Table::new("crossings", &[("side of a box", "px"), ("visible polygons", ""), ("all polygons", "")]);
    let crossings = sweep(&SIDES, |&side| Ok((side, crossing(SCREEN, side, RingRun::instructions)?)))?;
    crossings.iter().for_each(|&(side, p)| swept.push([side.into(), p.into(), (2.0 * p).into()]));
    let input = "side of the boxes in pixels";
    let all = crossings.iter().map(|&(side, p)| (side, 2.0 * p)).collect();
    let of_all = Fit::new("64,000 as all polygons, half of them visible", input, "64000", all);
    // The curves are those of boxes with which they cross as in print, if there are such boxes.
    let side = of_all.intervals().first().map_or(SIDE, |[from, to]| 0.5 * (from + to));
    let pairs = pairs(side)?;
    let title = "Instructions of a frame";
    let (mut findings, mut comparison) = findings((&pairs, side), RingRun::instructions, title, remark)?;
    comparison.fit_one_of(vec![Fit::new("64,000 as visible polygons", input, "64000", crossings), of_all]);
    findings.tables.extend([swept, comparison.intervals()]);
    findings.verdict = comparison.qualitative(
        "The size of the random polygons is not given, nor whether the axis counts all of them.",
    );
    // The document's curves are lost but for the place where they cross, which fits as a number of all polygons.
    let plot = &mut findings.plots[0];
    plot.x = Axis::log10("polygons, half of them visible");
    for series in &mut plot.series {
        series.points.iter_mut().zip(&pairs).for_each(|(point, pair)| point.0 = pair.polygons);
    }
    plot.series.push(Series::printed_places("crossing in print, as all polygons", [64e3]));
    Ok(findings)
}
