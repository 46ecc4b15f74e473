//! A processor's statistics as text, in the form of document 002, appendix C.

use std::fmt::Write;

use super::{Costs, Distribution, ProcessorRun};

/// Writes the statistics of one processor.
pub fn listing(run: &ProcessorRun, costs: &Costs) -> String {
    let mut text = String::new();
    let lists = [
        ("v", &run.vertices_per_polygon),
        ("y", &run.segments_per_polygon),
        ("l", &run.pixels_per_segment),
        ("D", &run.polygons_per_pixel),
    ];
    for (name, distribution) in lists {
        let _ = writeln!(text, "{name} data\n{} data points", distribution.points());
        let _ = writeln!(text, "{}\ndistribution", moments(distribution, "avg"));
        let counts: Vec<String> = distribution.counts().map(|(v, n)| format!("[{v}]={n}")).collect();
        for line in counts.chunks(10) {
            let _ = writeln!(text, " {}", line.join(" "));
        }
        text.push('\n');
    }
    let area = &run.pixels_per_polygon;
    let _ = writeln!(text, "area stats\nnumber of points {}\n{}\n", area.points(), moments(area, "mean"));

    let polygons = run.polygons().max(1) as f64;
    let parts = [
        ("vertex time", run.vertices() as f64 * costs.vertex / polygons),
        ("segment time", run.charged_segments() as f64 * costs.segment / polygons),
        ("pixel time", run.pixels() as f64 * costs.pixel / polygons),
        ("poly overhead", if run.polygons() > 0 { costs.polygon } else { 0.0 }),
    ];
    let sum: f64 = parts.iter().map(|p| p.1).sum();
    for (name, cycles) in parts {
        let share = if sum > 0.0 { 100.0 * cycles / sum } else { 0.0 };
        let _ = writeln!(text, "{name} {cycles:.6} ({share:.6}%)");
    }
    let _ = writeln!(text, "avg poly time {sum:.6}\ntotal scene time {:.6}", costs.total(run));
    text
}

fn moments(distribution: &Distribution, mean: &str) -> String {
    let (deviation, variance) = (distribution.deviation(), distribution.variance());
    format!("{mean}={:.6}, std.dev={deviation:.6}, var={variance:.6}", distribution.mean())
}
