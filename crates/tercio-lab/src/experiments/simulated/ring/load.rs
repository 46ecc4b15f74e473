//! Distribution of polygons over processors: figures 4-1, 4-2, 5-9.

use super::super::super::{Axis, Comparison, ExperimentError, Findings, Plot, Series, Table};
use super::{SCENES, SCREEN, curves, frame, profile, scenes};

/// Figure 4-1.
pub fn sort_first() -> Result<Findings, ExperimentError> {
    let mut table = Table::new("processors", &[("scene", ""), ("processor", ""), ("polygons", "")]);
    let mut summary =
        Table::new("summary", &[("scene", ""), ("most", ""), ("mean", ""), ("most over mean", "")]);
    let (mut series, mut comparison) = (Vec::new(), Comparison::new());
    for (name, scene) in scenes()? {
        let run = frame(&scene, 1024, |_| ())?;
        let most = run.received.iter().copied().max().unwrap_or(0);
        let mean = run.copies as f64 / run.received.len() as f64;
        summary.push([name.into(), f64::from(most).into(), mean.into(), run.asymmetry().into()]);
        series.push(Series::line(name, profile(&mut table, name, run.received.iter().copied())));
        if name == "like the teapot" {
            // The scene has the document's number of polygons and width; its deviation is fitted, so only the mean is a
            // test, and the maximum shows that one deviation explains both.
            comparison.add("mean polygons on a processor", mean, 23.3, 0.5);
            comparison.add("most polygons on a processor", f64::from(most), 394.0, 40.0);
        }
    }
    let plot = Plot {
        name: "load".into(),
        title: "Polygons that each processor rasterizes".into(),
        x: Axis::linear("processor"),
        y: Axis::linear("polygons"),
        series,
    };
    Ok(Findings {
        tables: vec![summary, table],
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

/// Figure 4-2.
pub fn shifts() -> Result<Findings, ExperimentError> {
    let mut table = Table::new(
        "shifts",
        &[("scene", ""), ("processors", ""), ("passes", ""), ("shifts per polygon", "")],
    );
    let (mut series, mut comparison) = (Vec::new(), Comparison::new());
    let scenes = scenes()?;
    let passes =
        curves(&scenes, &[768, 1024, 1536, 2048], |scene, n| Ok(frame(scene, n, |_| ())?.passes() as f64))?;
    for ((name, passes), (_, scene)) in passes.into_iter().zip(&scenes) {
        let per_polygon = passes.iter().map(|p| (p.0, p.1 / scene.visible() as f64));
        let points: Vec<_> = per_polygon.collect();
        for (p, shifts) in passes.iter().zip(&points) {
            table.push([name.into(), p.0.into(), p.1.into(), shifts.1.into()]);
        }
        let (least, most) = points.iter().fold((f64::MAX, 0f64), |(l, m), p| (l.min(p.1), m.max(p.1)));
        comparison.add(format!("{name}: shifts at 1,024 processors"), points[1].1, 1.0, 0.25);
        comparison.add(format!("{name}: largest over least"), most / least, 1.0, 0.35);
        series.push(Series::line_points(name, points));
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
        tables: vec![table],
        plots: vec![plot],
        remarks: vec![SCENES.into()],
        verdict: comparison.qualitative("The scenes are lost."),
    })
}

/// Figure 5-9.
pub fn locality() -> Result<Findings, ExperimentError> {
    let mut table = Table::new("columns", &[("scene", ""), ("column", ""), ("visible polygons", "")]);
    let mut summary = Table::new(
        "summary",
        &[("scene", ""), ("most", ""), ("mean over 1,024", ""), ("most over mean", "")],
    );
    let (mut series, mut comparison) = (Vec::new(), Comparison::new());
    for (name, scene) in scenes()? {
        // A polygon stays on the processor that rasterizes it first: that of its left column.
        let mut columns = vec![0u32; SCREEN.0 as usize];
        for b in scene.boxes.iter().filter(|b| b.visible) {
            columns[b.pixels.x0.clamp(0, SCREEN.0 as i32 - 1) as usize] += 1;
        }
        let most = f64::from(columns.iter().copied().max().unwrap_or(0));
        let mean = scene.visible() as f64 / 1024.0;
        summary.push([name.into(), most.into(), mean.into(), (most / mean).into()]);
        series.push(Series::line(name, profile(&mut table, name, columns.into_iter())));
        comparison.claim(format!("{name}: at least 3 times the mean"), most >= 3.0 * mean);
    }
    let plot = Plot {
        name: "locality".into(),
        title: "Polygons whose geometry a processor computes if they stay where they are drawn".into(),
        x: Axis::linear("column"),
        y: Axis::linear("visible polygons"),
        series,
    };
    Ok(Findings {
        tables: vec![summary, table],
        plots: vec![plot],
        remarks: vec![
            SCENES.into(),
            "The document's busiest processor has 176 polygons, 28.6 times the mean; its figure shows the greatest of \
             eight neighbours."
                .into(),
        ],
        verdict: comparison.qualitative("The teapot's polygons and its view are lost."),
    })
}
