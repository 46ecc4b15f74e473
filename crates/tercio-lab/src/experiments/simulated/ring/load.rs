//! Distribution of polygons over processors: figures 4-1, 4-2, 5-9.

use super::super::super::{Axis, Comparison, ExperimentError, Findings, Fit, Plot, Series, Table};
use super::{DOCUMENTED, SCENES, SCREEN, by_clumping, curves, frame, profile, record, scenes};
use crate::workloads::BoxScene;

/// The most of all processors.
fn busiest(numbers: &[u32]) -> f64 {
    f64::from(numbers.iter().copied().max().unwrap_or(0))
}

/// A print that two figures are compared with.
const BUSIEST: &str = "394 polygons on the busiest processor (figure 4-1)";

/// A printed number of polygons, of no stated processor.
fn level(label: &str, polygons: f64) -> Series {
    Series::line(label, vec![(0.0, polygons), (1023.0, polygons)]).published()
}

/// Visible polygons by the processor that rasterizes them first, on which they stay: that of their left column.
fn left_columns(scene: &BoxScene) -> Vec<u32> {
    let mut columns = vec![0u32; SCREEN.0 as usize];
    for b in scene.boxes.iter().filter(|b| b.visible) {
        columns[b.pixels.x0.clamp(0, SCREEN.0 as i32 - 1) as usize] += 1;
    }
    columns
}

/// Figure 4-1.
pub fn sort_first() -> Result<Findings, ExperimentError> {
    let mut table = Table::new("processors", &[("scene", ""), ("processor", ""), ("polygons", "")]);
    let mut summary =
        Table::new("summary", &[("scene", ""), ("most", ""), ("mean", ""), ("most over mean", "")]);
    let (mut series, mut comparison) = (Vec::new(), Comparison::of_published(&["E4-avg", "E4-f"])?);
    for (name, scene) in scenes()? {
        let run = frame(&scene, 1024, |_| ())?;
        let most = run.received.iter().copied().max().unwrap_or(0);
        let mean = run.copies as f64 / run.received.len() as f64;
        summary.push([name.into(), f64::from(most).into(), mean.into(), run.asymmetry().into()]);
        series.push(Series::line(name, profile(&mut table, name, run.received.iter().copied())));
    }
    let (_, polygons, visible, clumping) = DOCUMENTED[0];
    let busiest = by_clumping(polygons, visible, |scene| Ok(busiest(&frame(scene, 1024, |_| ())?.received)))?;
    let mut swept = Table::new("swept", &[("scene", ""), ("deviation", "column"), ("most", "")]);
    record(&mut swept, "like the teapot", &busiest);
    comparison.fit(Fit::new(BUSIEST, clumping, "394", busiest));
    series.push(level("busiest in print", 394.0));
    series.push(level("mean in print", 23.3));
    let plot = Plot {
        name: "load".into(),
        title: "Polygons that each processor rasterizes".into(),
        x: Axis::linear("processor"),
        y: Axis::linear("polygons"),
        series,
    };
    Ok(Findings {
        tables: vec![summary, table, swept, comparison.intervals()],
        plots: vec![plot],
        remarks: vec![
            SCENES.into(),
            "The document gives 394 and 23.3 for its teapot. Their ratio is 16.9, not the 4.4 of its table 4.3, \
             which is 16.9 over the overlap of 3.8."
                .into(),
        ],
        verdict: comparison.qualitative("The teapot's polygons and its view are lost."),
    })
}

/// Numbers of processors of figure 4-2.
const PROCESSORS: [u32; 4] = [768, 1024, 1536, 2048];

/// Figure 4-2.
pub fn shifts() -> Result<Findings, ExperimentError> {
    let mut table = Table::new(
        "shifts",
        &[("scene", ""), ("processors", ""), ("passes", ""), ("shifts per polygon", "")],
    );
    let (mut series, mut comparison) = (Vec::new(), Comparison::new());
    let scenes = scenes()?;
    let passes = curves(&scenes, &PROCESSORS, |scene, n| Ok(frame(scene, n, |_| ())?.passes() as f64))?;
    for ((name, passes), (_, scene)) in passes.into_iter().zip(&scenes) {
        let per_polygon = passes.iter().map(|p| (p.0, p.1 / scene.visible() as f64));
        let points: Vec<_> = per_polygon.collect();
        for (p, shifts) in passes.iter().zip(&points) {
            table.push([name.into(), p.0.into(), p.1.into(), shifts.1.into()]);
        }
        series.push(Series::line_points(name, points));
    }
    // "Approximately constant at 1 shift per polygon"; how constant is not said, so the mean is compared.
    let mut swept =
        Table::new("swept", &[("scene", ""), ("deviation", "column"), ("shifts per polygon, mean", "")]);
    let mean = |scene: &BoxScene| {
        let shifts =
            PROCESSORS.map(|n| Ok(frame(scene, n, |_| ())?.passes() as f64 / scene.visible() as f64));
        let shifts = shifts.into_iter().collect::<Result<Vec<f64>, ExperimentError>>()?;
        Ok(shifts.iter().sum::<f64>() / shifts.len() as f64)
    };
    for (name, polygons, visible, clumping) in DOCUMENTED {
        let points = by_clumping(polygons, visible, mean)?;
        record(&mut swept, name, &points);
        comparison.fit(Fit::new(
            format!("1 shift a polygon, {name}, mean of 768 to 2,048 processors"),
            clumping,
            "1",
            points,
        ));
    }
    series.push(Series::line("about 1", vec![(768.0, 1.0), (2048.0, 1.0)]).published());
    let plot = Plot {
        name: "shifts".into(),
        title: "Shifts of the ring for each polygon".into(),
        x: Axis::linear("processors"),
        y: Axis::linear("shifts per visible polygon"),
        series,
    };
    Ok(Findings {
        tables: vec![table, swept, comparison.intervals()],
        plots: vec![plot],
        remarks: vec![SCENES.into()],
        verdict: comparison.qualitative("The scenes are lost."),
    })
}

/// Names of the numbers of figure 5-9 and section 5.5.
const OF_FIGURE_5_9: [&str; 5] = ["E5.9fig", "E5.5-10", "E5.5-166", "E5.5-167.8", "E5.5-158.2"];

/// Figure 5-9.
pub fn locality() -> Result<Findings, ExperimentError> {
    let mut table = Table::new("columns", &[("scene", ""), ("column", ""), ("visible polygons", "")]);
    let mut summary = Table::new(
        "summary",
        &[("scene", ""), ("most", ""), ("mean over 1,024", ""), ("most over mean", "")],
    );
    // 176 over the mean of the printed numbers.
    let (mut series, mut comparison) = (Vec::new(), Comparison::of_published(&OF_FIGURE_5_9)?);
    for (name, scene) in scenes()? {
        let columns = left_columns(&scene);
        let most = busiest(&columns);
        let mean = scene.visible() as f64 / 1024.0;
        summary.push([name.into(), most.into(), mean.into(), (most / mean).into()]);
        series.push(Series::line(name, profile(&mut table, name, columns.into_iter())));
    }
    let (_, polygons, visible, clumping) = DOCUMENTED[0];
    let mut swept = Table::new("swept", &[("scene", ""), ("deviation", "column"), ("most", "")]);
    let most = by_clumping(polygons, visible, |scene| Ok(busiest(&left_columns(scene))))?;
    record(&mut swept, "like the teapot, most in a column", &most);
    comparison.fit(Fit::new("176 visible polygons on the busiest processor", clumping, "176", most));
    let received =
        by_clumping(polygons, visible, |scene| Ok(busiest(&frame(scene, 1024, |_| ())?.received)))?;
    record(&mut swept, "like the teapot, most on a processor", &received);
    let fit = Fit::new(BUSIEST, clumping, "394", received);
    comparison.fit(fit);
    series.push(level("busiest in print", 176.0));
    let plot = Plot {
        name: "locality".into(),
        title: "Polygons whose geometry a processor computes if they stay where they are drawn".into(),
        x: Axis::linear("column"),
        y: Axis::linear("visible polygons"),
        series,
    };
    Ok(Findings {
        tables: vec![summary, table, swept, comparison.intervals()],
        plots: vec![plot],
        remarks: vec![
            SCENES.into(),
            "The document's busiest processor has 176 polygons, 28.6 times the mean; its figure shows the greatest of \
             eight neighbours."
                .into(),
            "With columns that are normally distributed no deviation gives both this number and that of figure 4-1: the \
             document's teapot is clumped otherwise than our scene."
                .into(),
        ],
        verdict: comparison.qualitative("The teapot's polygons and its view are lost."),
    })
}
