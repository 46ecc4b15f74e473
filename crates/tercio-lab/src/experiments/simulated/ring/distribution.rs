//! Sparse and dense networks, and strides: figures 5-3 and 5-5.

use super::super::super::sweep::sweep;
use super::super::super::{Axis, Comparison, ExperimentError, Findings, Fit, Plot, Scale, Series, Table};
use super::{
    DEVIATIONS, DOCUMENTED, SCENES, by_clumping, clumped, communication, curves, frame, least, record, scenes,
};
use crate::models::eldridge::distribution::two_stages;
use crate::units::{Instructions, Polygons, Processors, Words};
use crate::workloads::BoxScene;

/// Figure 5-3.
pub fn sparse_and_dense() -> Result<Findings, ExperimentError> {
    let columns = [
        ("scene", ""),
        ("sparse", "instructions per polygon"),
        ("dense", "instructions per polygon"),
        ("ratio", ""),
    ];
    let mut table = Table::new("networks", &columns);
    let (mut sparse_points, mut dense_points, mut comparison) = (Vec::new(), Vec::new(), Comparison::new());
    let mut names = Vec::new();
    for (number, (name, scene)) in scenes()?.into_iter().enumerate() {
        let dense = communication(&frame(&scene, 1024, |_| ())?);
        let sparse = communication(&frame(&scene, 1024, |a| a.test_period = 1024)?);
        table.push([name.into(), sparse.into(), dense.into(), (sparse / dense).into()]);
        names.push(name);
        sparse_points.push((number as f64 + 1.0, sparse));
        dense_points.push((number as f64 + 1.0, dense));
    }
    // "Up to twice as long."
    let mut swept = Table::new("swept", &[("scene", ""), ("deviation", "column"), ("sparse over dense", "")]);
    let ratio = |scene: &BoxScene| {
        let dense = communication(&frame(scene, 1024, |_| ())?);
        Ok(communication(&frame(scene, 1024, |a| a.test_period = 1024)?) / dense)
    };
    for (name, polygons, visible, clumping) in DOCUMENTED {
        let points = by_clumping(polygons, visible, ratio)?;
        record(&mut swept, name, &points);
        comparison.fit(Fit::within(
            format!("sparse over dense from 1 to 2, {name}"),
            clumping,
            [1.0, 2.0],
            points,
        ));
    }
    let plot = Plot {
        name: "networks".into(),
        title: "Instructions of communication for each visible polygon".into(),
        x: Axis::categories("scene", 1, names),
        y: Axis::linear("instructions per visible polygon"),
        series: vec![Series::points("sparse", sparse_points), Series::points("dense", dense_points)],
    };
    Ok(Findings {
        tables: vec![table, swept, comparison.intervals()],
        plots: vec![plot],
        remarks: vec![
            SCENES.into(),
            "The document: the sparse network needs up to twice as long. Both are charged the same for a pass.".into(),
        ],
        verdict: comparison.qualitative("The scenes are lost."),
    })
}

/// The speed-up of the best stride over stride 1, and the least cost of other strides over that of 8 or 16.
fn gain(scene: &BoxScene) -> Result<[f64; 2], ExperimentError> {
    let cost = |stride: u32| -> Result<f64, ExperimentError> {
        Ok(communication(&frame(scene, 1024, |a| a.strides = super::strides(stride))?))
    };
    let least = |strides: &[u32]| -> Result<f64, ExperimentError> {
        strides.iter().try_fold(f64::MAX, |least, &stride| Ok(least.min(cost(stride)?)))
    };
    let (printed, others) = (least(&[8, 16])?, least(&[2, 4, 32, 64])?);
    Ok([cost(1)? / printed.min(others), others / printed])
}

/// Figure 5-5.
pub fn strides() -> Result<Findings, ExperimentError> {
    let mut table =
        Table::new("strides", &[("scene", ""), ("stride", "processors"), ("instructions per polygon", "")]);
    let mut best =
        Table::new("best", &[("scene", ""), ("best stride", "processors"), ("speed-up over stride 1", "")]);
    let (mut series, mut comparison) = (Vec::new(), Comparison::new());
    let first_strides: Vec<_> = (0..10).map(|k| 1u32 << k).collect();
    let by_stride = curves(&scenes()?, &first_strides, |scene, stride| {
        Ok(communication(&frame(scene, 1024, |a| a.strides = super::strides(stride))?))
    })?;
    for (name, points) in by_stride {
        points.iter().for_each(|p| table.push([name.into(), p.0.into(), p.1.into()]));
        let least = least(&points);
        let gain = points[0].1 / least.1;
        best.push([name.into(), least.0.into(), gain.into()]);
        series.push(Series::line_points(name, points));
    }
    // The speed-ups are printed in the order of figures 3-2 to 3-4: Beethoven, crocodile, teapot.
    let mut swept = Table::new(
        "swept",
        &[("scene", ""), ("deviation", "column"), ("speed-up", ""), ("other strides over 8 or 16", "")],
    );
    for ((name, polygons, visible, clumping), printed) in DOCUMENTED.into_iter().zip(["1.96", "2.40", "1.96"])
    {
        let both = sweep(&DEVIATIONS, |&deviation| gain(&clumped(polygons, visible, deviation).boxes()))?;
        let of = |gains: fn(&[f64; 2]) -> f64| {
            DEVIATIONS.into_iter().zip(both.iter().map(gains)).collect::<Vec<_>>()
        };
        for (deviation, gains) in DEVIATIONS.into_iter().zip(&both) {
            swept.push([name.into(), deviation.into(), gains[0].into(), gains[1].into()]);
        }
        comparison.fit(Fit::new(format!("speed-up {printed} {name}"), clumping, printed, of(|g| g[0])));
        let best = format!("8 or 16 the best stride {name}");
        comparison.fit(Fit::within(best, clumping, [1.0, f64::INFINITY], of(|g| g[1])));
    }
    let formula = |d: f64| {
        let (words, overhead) = (Words::new(42.0), Instructions::new(30.0));
        two_stages(Polygons::new(1.0), Processors::new(1024.0), Processors::new(d), words, overhead).get()
    };
    series.push(Series::formula("equation 5.5", Scale::Log2, [1.0, 512.0], formula));
    let plot = Plot {
        name: "strides".into(),
        title: "Instructions of communication against the first stride".into(),
        x: Axis::log2("first stride (processors)"),
        y: Axis::linear("instructions per visible polygon"),
        series,
    };
    Ok(Findings {
        tables: vec![best, table, swept, comparison.intervals()],
        plots: vec![plot],
        remarks: vec![
            SCENES.into(),
            "The document finds 8 or 16 the best stride, by simulation, and speed-ups of 1.96, 2.40 and 1.96; the \
             formula, which assumes a full ring, 27.4 and 3.10. Strides here are one step and then 1."
                .into(),
        ],
        verdict: comparison.qualitative("The scenes are lost."),
    })
}
