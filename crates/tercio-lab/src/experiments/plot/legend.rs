//! The legend, beside the data.

use glam::{DVec2, dvec2};
use tercio::vector::{Anchor, Shape};

use super::label::{self, LABEL, LINE};
use super::look::Look;
use super::{Plot, Role, Series};

/// Width of the sample of a series.
const SAMPLE: f64 = 30.0;
/// Width at which labels are broken.
const WIDEST: f64 = 140.0;
/// What a question mark stands for.
const UNKNOWN: &str = "? not known";
/// What the looks of published values and of ours stand for: with bars, and with lines and points.
const ORIGINS: [[&str; 2]; 2] =
    [["hatched: published", "filled: computed"], ["hollow, dashed: published", "filled, solid: computed"]];

/// What the legend says.
pub(super) struct Legend {
    /// Lines of text of every series.
    labels: Vec<Vec<String>>,
    /// Lines below them: what the looks of published values stand for, and question marks.
    notes: Vec<String>,
}

impl Legend {
    /// The legend of a plot. A single series has no label.
    pub fn of(plot: &Plot, has_gaps: bool) -> Self {
        let is_shown = plot.series.len() > 1;
        let label = |s: &Series| label::wrapped(&s.label, LABEL, WIDEST);
        let labels = if is_shown { plot.series.iter().map(label).collect() } else { Vec::new() };
        let has = |role| plot.series.iter().any(|s| s.role == role);
        let [theirs, ours] = ORIGINS[usize::from(plot.x.categories.is_none())];
        let notes = [
            has(Role::Published).then_some(theirs),
            (has(Role::Published) && has(Role::Ours)).then_some(ours),
            has_gaps.then_some(UNKNOWN),
        ];
        let wrapped = |note| label::wrapped(note, LABEL, SAMPLE + WIDEST);
        Self { labels, notes: notes.into_iter().flatten().flat_map(wrapped).collect() }
    }

    /// Width and height, both zero if nothing is said.
    pub fn size(&self) -> DVec2 {
        let widest = |lines: &mut dyn Iterator<Item = &String>| {
            lines.map(|line| label::width(line, LABEL)).fold(0.0, f64::max)
        };
        let labels = widest(&mut self.labels.iter().flatten());
        let labels = if labels > 0.0 { SAMPLE + 8.0 + labels } else { 0.0 };
        let lines: f64 = self.labels.iter().map(|l| l.len() as f64 * LINE + 5.0).sum();
        dvec2(labels.max(widest(&mut self.notes.iter())), lines + self.notes.len() as f64 * LINE)
    }

    /// Draws it with its upper left corner at `corner`.
    pub fn push(&self, shapes: &mut Vec<Shape>, corner: DVec2, looks: &[Look<'_>]) {
        let mut at = corner;
        for (lines, look) in self.labels.iter().zip(looks) {
            look.push_sample(shapes, at + dvec2(0.0, 0.5 * LINE), SAMPLE);
            for line in lines {
                at.y += LINE;
                label::push(
                    shapes,
                    line,
                    LABEL,
                    at + dvec2(SAMPLE + 8.0, -0.25 * LINE),
                    Anchor::Start,
                    false,
                );
            }
            at.y += 5.0;
        }
        for note in &self.notes {
            at.y += LINE;
            label::push(shapes, note, LABEL, at - dvec2(0.0, 0.25 * LINE), Anchor::Start, false);
        }
    }
}
