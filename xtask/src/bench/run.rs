//! One turn of one program, and statistics over turns.

use std::path::PathBuf;

use anyhow::{Context as _, Result, ensure};
use serde_json::{Map, Value};

use super::programs::Program;

/// What is drawn.
#[derive(Clone, Debug)]
pub struct Task {
    /// Its name in the tables.
    pub title: String,
    /// Binary PLY with normals.
    pub model: PathBuf,
    /// Pixels across and down.
    pub size: (u32, u32),
    /// Number of views.
    pub frames: u32,
    /// Samples per pixel.
    pub samples: u32,
    /// Opacity of the model, up to 1.
    pub opacity: f64,
    /// Further arguments of `tercio bench`: position of the camera, number of copies. The other programs use the
    /// cameras that it reports.
    pub arguments: Vec<String>,
}

/// The report of one turn of a program.
#[derive(Clone, Debug)]
pub struct Run {
    /// Median of the frames.
    pub median_ms: f64,
    /// Pixels that show the model: the number of the view, and the count.
    pub pixels: Vec<(usize, u64)>,
    /// Everything that the program printed, as JSON.
    pub output: Value,
}

impl Run {
    /// From JSON with `views`, each of which has `milliseconds` and `pixels`.
    pub fn of_views(output: Value) -> Result<Self> {
        let views = output["views"].as_array().context("no \"views\"")?;
        let times = views.iter().map(|v| v["milliseconds"].as_f64()).collect::<Option<Vec<_>>>();
        let pixels = views.iter().map(|v| v["pixels"].as_u64()).collect::<Option<Vec<_>>>();
        let median_ms = median(times.context("a view without \"milliseconds\"")?);
        let pixels = pixels.context("a view without \"pixels\"")?.into_iter().enumerate().collect();
        Ok(Self { median_ms, pixels, output })
    }

    /// The part of the turn that is recorded: the time of each frame in milliseconds, and all scalar values.
    pub fn kept(&self) -> Value {
        let facts = self.output.as_object().into_iter().flatten();
        let mut kept: Map<_, _> = facts
            // The path of the model is specific to this run; the subject of the run names it.
            .filter(|(k, v)| *k != "model" && !v.is_array() && !v.is_object())
            .map(|(k, v)| (k.clone(), short(v)))
            .collect();
        if let Some(views) = self.output["views"].as_array() {
            kept.insert("frame_ms".into(), views.iter().map(|view| short(&view["milliseconds"])).collect());
        }
        Value::Object(kept)
    }

    /// The number of this name in the program's output.
    pub fn number(&self, name: &str) -> Result<f64> {
        self.output[name].as_f64().with_context(|| format!("no number \"{name}\""))
    }

    /// Fails unless both have drawn about the same: the numbers of pixels may differ by one part in a hundred, or by
    /// four, as the rules for edges differ.
    pub fn check_same_picture(&self, other: &Self) -> Result<()> {
        for &(view, pixels) in &self.pixels {
            let Some(&(_, theirs)) = other.pixels.iter().find(|(v, _)| *v == view) else { continue };
            let allowed = (pixels.max(theirs) / 100).max(4);
            ensure!(
                pixels.abs_diff(theirs) <= allowed,
                "in view {view} the model covers {pixels} pixels, and {theirs} as tercio draws it"
            );
        }
        Ok(())
    }
}

/// A number without digits beyond the precision of a clock; anything else as it is.
fn short(value: &Value) -> Value {
    match value.as_f64() {
        Some(number) if value.is_f64() => ((number * 1e4).round() / 1e4).into(),
        _ => value.clone(),
    }
}

/// Name and version of each program that reports its version.
pub fn versions<'a>(programs: &[Program], runs: impl IntoIterator<Item = &'a Run>) -> String {
    let version = |(program, run): (&Program, &Run)| {
        Some(format!("{}: {}", program.name(), run.output["version"].as_str()?))
    };
    let versions: Vec<_> = programs.iter().zip(runs).filter_map(version).collect();
    if versions.is_empty() { String::new() } else { format!("Versions: {}.", versions.join("; ")) }
}

/// The middle one, or the upper of the two in the middle.
///
/// # Panics
/// If there is none.
pub fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Median time of one program over the turns, in milliseconds.
pub fn median_ms(turns: &[Run]) -> f64 {
    median(turns.iter().map(|run| run.median_ms).collect())
}

/// Median over the turns of the time of `slow` divided by that of `fast` in the same turn.
pub fn ratio(slow: &[Run], fast: &[Run]) -> f64 {
    median(slow.iter().zip(fast).map(|(s, f)| s.median_ms / f.median_ms).collect())
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn run(milliseconds: f64, pixels: u64) -> Run {
        Run::of_views(json!({ "views": [{ "milliseconds": milliseconds, "pixels": pixels }] })).unwrap()
    }

    #[test]
    fn ratios_are_taken_inside_a_turn() {
        // The machine was ten times slower in the second turn: no ratio may mix the turns.
        let (slow, fast) =
            ([run(2.0, 9), run(30.0, 9), run(2.0, 9)], [run(1.0, 9), run(10.0, 9), run(1.0, 9)]);
        assert_eq!(ratio(&slow, &fast), 2.0);
        assert_eq!(median_ms(&slow), 2.0);
    }

    #[test]
    fn other_pictures_are_refused() {
        assert!(run(1.0, 10_000).check_same_picture(&run(1.0, 10_090)).is_ok());
        assert!(run(1.0, 10_000).check_same_picture(&run(1.0, 10_200)).is_err());
        assert!(run(1.0, 20).check_same_picture(&run(1.0, 23)).is_ok());
        assert!(run(1.0, 20).check_same_picture(&run(1.0, 0)).is_err());
    }

    #[test]
    fn times_and_facts_are_kept() {
        let views = json!([{ "milliseconds": 1.23456789, "pixels": 9, "camera": { "near": null } }]);
        let output = json!({ "version": "1", "triangles": 7, "last_frame": {}, "views": views });
        let kept = json!({ "version": "1", "triangles": 7, "frame_ms": [1.2346] });
        assert_eq!(Run::of_views(output).unwrap().kept(), kept);
    }

    #[test]
    fn incomplete_reports_are_refused() {
        for output in
            [json!({}), json!({ "views": [{ "pixels": 1 }] }), json!({ "views": [{ "milliseconds": 1 }] })]
        {
            assert!(Run::of_views(output).is_err());
        }
    }
}
