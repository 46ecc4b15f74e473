//! One turn of one program, and what many turns say.

use std::path::PathBuf;

use anyhow::{Context as _, Result, ensure};
use serde_json::{Map, Value};

use super::programs::Program;

/// What is drawn.
#[derive(Clone, Debug)]
pub struct Task {
    /// How the tables call it.
    pub title: String,
    /// Binary PLY with normals.
    pub model: PathBuf,
    /// Pixels across and down.
    pub size: (u32, u32),
    /// Number of views.
    pub frames: u32,
    /// Further arguments of `tercio bench`: where the camera stands, how many copies. The others are given its
    /// cameras.
    pub arguments: Vec<String>,
}

/// What one turn of a program told.
#[derive(Clone, Debug)]
pub struct Run {
    /// Median of the frames.
    pub median_ms: f64,
    /// Pixels that show the model: a number of the view, and how many.
    pub pixels: Vec<(usize, u64)>,
    /// All that the program wrote, as JSON.
    pub told: Value,
}

impl Run {
    /// From JSON with `views`, each of which has `milliseconds` and `pixels`.
    pub fn of_views(told: Value) -> Result<Self> {
        let views = told["views"].as_array().context("no \"views\"")?;
        let times = views.iter().map(|v| v["milliseconds"].as_f64()).collect::<Option<Vec<_>>>();
        let pixels = views.iter().map(|v| v["pixels"].as_u64()).collect::<Option<Vec<_>>>();
        let median_ms = median(times.context("a view without \"milliseconds\"")?);
        let pixels = pixels.context("a view without \"pixels\"")?.into_iter().enumerate().collect();
        Ok(Self { median_ms, pixels, told })
    }

    /// What is kept of the turn: the time of each frame in milliseconds, and every single fact that was told.
    pub fn kept(&self) -> Value {
        let facts = self.told.as_object().into_iter().flatten();
        let mut kept: Map<_, _> = facts
            // The model's place is this run's own folder; the subject of the run names it.
            .filter(|(k, v)| *k != "model" && !v.is_array() && !v.is_object())
            .map(|(k, v)| (k.clone(), short(v)))
            .collect();
        if let Some(views) = self.told["views"].as_array() {
            kept.insert("frame_ms".into(), views.iter().map(|view| short(&view["milliseconds"])).collect());
        }
        Value::Object(kept)
    }

    /// A number that the program told by this name.
    pub fn number(&self, name: &str) -> Result<f64> {
        self.told[name].as_f64().with_context(|| format!("no number \"{name}\""))
    }

    /// Fails unless both have drawn about the same: as many pixels to one part in a hundred, or four pixels, by
    /// which borders may differ.
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

/// A number without digits that no clock measures; anything else as it is.
fn short(value: &Value) -> Value {
    match value.as_f64() {
        Some(number) if value.is_f64() => ((number * 1e4).round() / 1e4).into(),
        _ => value.clone(),
    }
}

/// Name and version of each program that told its version.
pub fn versions<'a>(programs: &[Program], runs: impl IntoIterator<Item = &'a Run>) -> String {
    let version = |(program, run): (&Program, &Run)| {
        Some(format!("{}: {}", program.name(), run.told["version"].as_str()?))
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

/// Median over the turns of one program's time, in milliseconds.
pub fn median_ms(turns: &[Run]) -> f64 {
    median(turns.iter().map(|run| run.median_ms).collect())
}

/// Median over the turns of how many times as long `slow` takes as `fast` in the same turn.
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
        let told = json!({ "version": "1", "triangles": 7, "last_frame": {}, "views": views });
        let kept = json!({ "version": "1", "triangles": 7, "frame_ms": [1.2346] });
        assert_eq!(Run::of_views(told).unwrap().kept(), kept);
    }

    #[test]
    fn incomplete_reports_are_refused() {
        for told in
            [json!({}), json!({ "views": [{ "pixels": 1 }] }), json!({ "views": [{ "milliseconds": 1 }] })]
        {
            assert!(Run::of_views(told).is_err());
        }
    }
}
