//! Several processors hold the same polygons: figures 5-6, 5-7, 5-8.

use super::super::super::sweep::{pairs, sweep};
use super::super::super::{Axis, Cell, Comparison, ExperimentError, Findings, Fit, Plot, Series, Table};
use super::{
    DEVIATIONS, DOCUMENTED, SCENES, by_clumping, clumped, curves, frame, least, profile, record, scenes,
    strides,
};
use crate::simulators::ring::RingRun;
use crate::words::counted;
use crate::workloads::BoxScene;

/// Instructions of geometry and communication for each visible polygon.
fn cost(run: &RingRun) -> f64 {
    (run.geometry.instructions + run.communication()) as f64 / run.visible.max(1) as f64
}

/// Numbers of copies.
const COPIES: [u32; 7] = [1, 2, 4, 8, 16, 32, 64];

fn in_words(copies: u32) -> String {
    counted(copies.into(), "copy", "copies")
}

/// Figure 5-6.
pub fn copies() -> Result<Findings, ExperimentError> {
    let mut table = Table::new("copies", &[("scene", ""), ("copies", ""), ("instructions per polygon", "")]);
    let mut best = Table::new(
        "best",
        &[("scene", ""), ("best copies", ""), ("instructions", ""), ("instructions with one copy", "")],
    );
    // 153 and 132 are said to be a fifth apart.
    let (mut series, mut comparison) = (Vec::new(), Comparison::of_published(&["E5.4-20pc"])?);
    let mut all = scenes()?;
    all.push(("less clumped", clumped(9_408, 6_294, 50.0).boxes()));
    let by_copies = curves(&all, &COPIES, |scene, m| Ok(cost(&frame(scene, 1024, |a| a.duplication = m)?)))?;
    for (name, points) in by_copies {
        points.iter().for_each(|p| table.push([name.into(), p.0.into(), p.1.into()]));
        let least = least(&points);
        best.push([name.into(), least.0.into(), least.1.into(), points[0].1.into()]);
        series.push(Series::line_points(name, points));
    }
    // The document's teapot: 153 without and 132 with the best number of copies, 16.
    let (name, polygons, visible, clumping) = DOCUMENTED[0];
    let mut swept = Table::new("swept", &[("copies", ""), ("deviation", "column"), ("instructions", "")]);
    let costs = |m: u32| {
        by_clumping(polygons, visible, move |scene| Ok(cost(&frame(scene, 1024, |a| a.duplication = m)?)))
    };
    let all_costs = COPIES.into_iter().map(costs).collect::<Result<Vec<_>, _>>()?;
    for (m, points) in COPIES.into_iter().zip(&all_costs) {
        record(&mut swept, &format!("{name}, {}", in_words(m)), points);
    }
    comparison.fit(Fit::new("153 instructions with one copy", clumping, "153", all_costs[0].clone()));
    comparison.fit(Fit::new("132 instructions with 16 copies", clumping, "132", all_costs[4].clone()));
    let best_copies = |at: usize| {
        let costs = COPIES.into_iter().zip(&all_costs).map(|(m, points)| (m, points[at].1));
        costs.fold((1, f64::MAX), |a, b| if b.1 < a.1 { b } else { a }).0
    };
    let sixteen = (0..all_costs[0].len()).filter(|&at| best_copies(at) == 16);
    let sixteen: Vec<_> = sixteen.map(|at| all_costs[0][at].0.to_string()).collect();
    comparison.claim(
        format!("16 copies are best for deviations of {} columns of those tried", sixteen.join(", ")),
        !sixteen.is_empty(),
    );
    series.push(Series::points("teapot of the document", vec![(1.0, 153.0), (16.0, 132.0)]).published());
    let plot = Plot {
        name: "copies".into(),
        title: "Instructions of geometry and communication".into(),
        x: Axis::log2("copies of each polygon"),
        y: Axis::linear("instructions per visible polygon"),
        series,
    };
    Ok(Findings {
        tables: vec![best, table, swept, comparison.intervals()],
        plots: vec![plot],
        remarks: vec![
            SCENES.into(),
            "The document: 153 instructions a visible polygon without duplication, 132 with 16 copies. Whether copies pay \
             depends on how far the polygons are clumped: the more they are, the more geometry falls on few processors. \
             With columns that are normally distributed no deviation gives both numbers."
                .into(),
        ],
        verdict: comparison.qualitative("The scenes are lost."),
    })
}

/// Numbers of copies whose imbalance is looked at.
const IMBALANCE: [u32; 3] = [4, 16, 64];

/// Figure 5-7.
pub fn imbalance() -> Result<Findings, ExperimentError> {
    let scene = super::super::model_boxes("builtin:teapot@9408", super::SCREEN)?;
    let mut table = Table::new("sent", &[("copies", ""), ("processor", ""), ("polygons sent", "")]);
    let (mut series, mut most) = (Vec::new(), Vec::new());
    for m in [1].into_iter().chain(IMBALANCE) {
        let run = frame(&scene, 1024, |a| a.duplication = m)?;
        most.push(f64::from(run.sent.iter().copied().max().unwrap_or(0)));
        let sent = profile(&mut table, f64::from(m), run.sent.iter().copied());
        // As in the document: the maximum of eight neighbours.
        let groups = sent.chunks(8).map(|group| (group[0].0, group.iter().map(|p| p.1).fold(0.0, f64::max)));
        series.push(Series::line(in_words(m), groups.collect()));
    }
    let mut comparison = Comparison::new();
    let rising = most.windows(2).all(|w| w[0] < w[1]);
    comparison.claim("on tercio's teapot the busiest processor's polygons grow with every step", rising);
    // "Clumping of the geometry work on approximately one fourth of the processors, so the geometry stage was 4 times more
    // expensive"; with how many copies is not said. A factor that is rounded to 4 is one from 3.5 to 4.5.
    let columns = [
        ("copies", ""),
        ("deviation", "column"),
        ("polygons of the busiest", ""),
        ("share with polygons", ""),
    ];
    let mut swept = Table::new("swept", &columns);
    let (_, polygons, visible, clumping) = DOCUMENTED[0];
    let runs = sweep(
        &pairs(&DEVIATIONS, &[1].into_iter().chain(IMBALANCE).collect::<Vec<_>>()),
        |&(&deviation, m)| {
            let sent =
                frame(&clumped(polygons, visible, deviation).boxes(), 1024, |a| a.duplication = m)?.sent;
            let busy = sent.iter().filter(|&&polygons| polygons > 0).count();
            Ok((
                deviation,
                m,
                f64::from(sent.iter().copied().max().unwrap_or(0)),
                busy as f64 / sent.len() as f64,
            ))
        },
    )?;
    for &(deviation, m, most, share) in &runs {
        swept.push([f64::from(m).into(), deviation.into(), most.into(), share.into()]);
    }
    let steps = runs.chunks(1 + IMBALANCE.len()).map(|all| {
        let least = all.windows(2).map(|w| w[1].2 / w[0].2).fold(f64::MAX, f64::min);
        (all[0].0, least)
    });
    let more = [1.0 + f64::EPSILON, f64::INFINITY];
    comparison.fit(Fit::within(
        "more polygons on the busiest processor with every step",
        clumping,
        more,
        steps.collect(),
    ));
    let readings = IMBALANCE.map(|copies| {
        let points = runs.iter().filter(|run| run.1 == copies).map(|run| (run.0, run.3)).collect();
        let what =
            format!("a fourth of the processors (1 in 3.5 to 4.5, rounded) with geometry, {copies} copies");
        Fit::within(what, clumping, [1.0 / 4.5, 1.0 / 3.5], points)
    });
    comparison.fit_one_of(readings.to_vec());
    let plot = Plot {
        name: "sent".into(),
        title: "Visible polygons whose geometry a processor computes".into(),
        x: Axis::linear("processor"),
        y: Axis::linear("polygons, the greatest of 8 neighbours"),
        series,
    };
    Ok(Findings {
        tables: vec![table, swept, comparison.intervals()],
        plots: vec![plot],
        remarks: vec![
            "tercio's teapot, drawn as large as the screen allows, stands for the document's.".into(),
        ],
        verdict: comparison.qualitative("The teapot's polygons and its view are lost."),
    })
}

/// First strides of figure 5-8.
const STRIDES: [u32; 6] = [1, 4, 8, 16, 32, 64];

/// The best point of figure 5-8 as copies and stride; and, as shares of the cost of the printed optimum, the least cost of the
/// other points, and that of other numbers of copies than 8 without strides.
fn margins(scene: &BoxScene) -> Result<([u32; 2], [f64; 2]), ExperimentError> {
    let points = pairs(&COPIES, &STRIDES);
    let costs = points.iter().map(|&(&m, stride)| {
        Ok(([m, stride], cost(&frame(scene, 1024, |a| (a.duplication, a.strides) = (m, strides(stride)))?)))
    });
    let costs = costs.collect::<Result<Vec<_>, ExperimentError>>()?;
    let least = |of: &dyn Fn([u32; 2]) -> bool| {
        let all = costs.iter().filter(|c| of(c.0));
        all.fold(([0, 0], f64::MAX), |a, b| if b.1 < a.1 { *b } else { a })
    };
    let best = least(&|_| true).0;
    let point = least(&|p| p != [1, 16]).1 / least(&|p| p == [1, 16]).1;
    let copies = least(&|p| p[1] == 1 && p[0] != 8).1 / least(&|p| p == [8, 1]).1;
    Ok((best, [point, copies]))
}

/// Figure 5-8.
pub fn surface() -> Result<Findings, ExperimentError> {
    let (_, polygons, visible, clumping) = DOCUMENTED[1];
    let scene = clumped(polygons, visible, 30.0).boxes();
    let mut columns = vec![("copies", "")];
    let names: Vec<String> = STRIDES.iter().map(|d| format!("stride {d}")).collect();
    columns.extend(names.iter().map(|n| (n.as_str(), "instructions per polygon")));
    let mut table = Table::new("surface", &columns);
    let mut series = Vec::new();
    let mut least = (0, 0, f64::MAX);
    let costs = sweep(&pairs(&COPIES, &STRIDES), |&(&m, stride)| {
        Ok(cost(&frame(&scene, 1024, |a| (a.duplication, a.strides) = (m, strides(stride)))?))
    })?;
    for (m, costs) in COPIES.into_iter().zip(costs.chunks(STRIDES.len())) {
        let (mut points, mut row) = (Vec::new(), vec![Cell::from(f64::from(m))]);
        for (stride, &cost) in STRIDES.into_iter().zip(costs) {
            least = if cost < least.2 { (m, stride, cost) } else { least };
            points.push((f64::from(stride), cost));
            row.push(cost.into());
        }
        table.push_row(row);
        series.push(Series::line_points(in_words(m), points));
    }
    let mut comparison = Comparison::new();
    let margins = sweep(&DEVIATIONS, |&deviation| margins(&clumped(polygons, visible, deviation).boxes()))?;
    let mut swept = Table::new(
        "swept",
        &[
            ("deviation", "column"),
            ("best copies", ""),
            ("best stride", "processors"),
            ("others over one copy and stride 16", ""),
            ("other copies over 8, without strides", ""),
        ],
    );
    for (deviation, (best, [point, copies])) in DEVIATIONS.into_iter().zip(&margins) {
        let [m, stride] = best.map(|b| f64::from(b).into());
        swept.push([deviation.into(), m, stride, (*point).into(), (*copies).into()]);
    }
    for (k, what) in [
        "one copy and a stride of 16 the best point, others over it at least 1",
        "8 copies the best without strides, other numbers over it at least 1",
    ]
    .into_iter()
    .enumerate()
    {
        let points = DEVIATIONS.into_iter().zip(margins.iter().map(|m| m.1[k])).collect();
        comparison.fit(Fit::within(what, clumping, [1.0, f64::INFINITY], points));
    }
    let plot = Plot {
        name: "surface".into(),
        title: "Instructions of geometry and communication".into(),
        x: Axis::log2("first stride (processors)"),
        y: Axis::linear("instructions per visible polygon"),
        series,
    };
    Ok(Findings {
        tables: vec![table, swept, comparison.intervals()],
        plots: vec![plot],
        remarks: vec![
            "The plotted scene has the crocodile's number of polygons and a normal distribution of columns (deviation 30).".into(),
            format!("Least cost: {:.1} instructions with {} and stride {}.", least.2, in_words(least.0), least.1),
        ],
        verdict: comparison.qualitative("The crocodile is lost, and how far it is clumped is not stated."),
    })
}
