//! The legend, beside the data.

use glam::{DVec2, dvec2};
use tercio::vector::{Anchor, Shape};

use super::label::{self, LABEL, LINE};
use super::look::Look;
use super::{Plot, Series};

/// Width of the sample of a series.
const SAMPLE: f64 = 30.0;
/// Width at which labels are broken.
const WIDEST: f64 = 140.0;
/// What a question mark stands for.
const UNKNOWN: &str = "? not known";

/// What the legend says.
pub(super) struct Legend {
    /// Lines of text of every series.
    labels: Vec<Vec<String>>,
    /// Are there values that are not known?
    has_gaps: bool,
}

impl Legend {
    /// The legend of a plot; a single series has none.
    pub fn of(plot: &Plot, has_gaps: bool) -> Self {
        let is_shown = plot.series.len() > 1;
        let label = |s: &Series| label::wrapped(&s.label, LABEL, WIDEST);
        let labels = if is_shown { plot.series.iter().map(label).collect() } else { Vec::new() };
        Self { labels, has_gaps }
    }

    /// Width and height, both zero if nothing is said.
    pub fn size(&self) -> DVec2 {
        let texts = self.labels.iter().flatten().map(String::as_str).chain(self.has_gaps.then_some(UNKNOWN));
        let width = texts.map(|line| label::width(line, LABEL)).fold(0.0, f64::max);
        if width == 0.0 {
            return DVec2::ZERO;
        }
        let lines: f64 = self.labels.iter().map(|l| l.len() as f64 * LINE + 5.0).sum();
        dvec2(SAMPLE + 8.0 + width, lines + if self.has_gaps { LINE } else { 0.0 })
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
        if self.has_gaps {
            let at = at + dvec2(SAMPLE + 8.0, 0.75 * LINE);
            label::push(shapes, UNKNOWN, LABEL, at, Anchor::Start, false);
        }
    }
}
