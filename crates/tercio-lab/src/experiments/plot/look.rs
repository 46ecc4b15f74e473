//! How a series looks: colour, line, symbols, bars.

use glam::{DVec2, dvec2};
use tercio::vector::{Cap, Shape, Style};

use super::bars::push_bar;
use super::palette::{COLORS, DASHES};
use super::symbols::{dashed, symbol};
use super::{Mark, Role, Series};

const RADIUS: f64 = 3.6;
/// Hollow symbols are larger, so that white is left between them and full ones inside.
const HOLLOW: f64 = 6.2;
/// What a line and a symbol grow by for each line above that hides them.
const RIM: f64 = 1.6;

/// How a series looks.
pub(super) struct Look<'a> {
    pub series: &'a Series,
    /// The number of its colour and symbol.
    pub number: usize,
    pub as_bars: bool,
    /// How many of the series drawn later lie on this one, which is drawn wider, so that a rim of it remains.
    pub hidden_by: u32,
}

impl Look<'_> {
    pub fn color(&self) -> [u8; 4] {
        let [r, g, b] = COLORS[self.number % COLORS.len()];
        [r, g, b, 255]
    }

    pub fn is_published(&self) -> bool {
        self.series.role == Role::Published
    }

    fn push_stroke(&self, shapes: &mut Vec<Shape>, line: &[DVec2]) {
        let (cap, lines) = if self.is_published() {
            (Cap::Square, dashed(line, DASHES[self.number % DASHES.len()]))
        } else {
            (Cap::Round, vec![line.to_vec()])
        };
        let width = 1.8 + 2.0 * self.rim();
        shapes.push(Shape::Lines { style: Style { color: self.color(), width, cap }, lines });
    }

    fn rim(&self) -> f64 {
        f64::from(self.hidden_by) * RIM
    }

    fn push_symbol(&self, shapes: &mut Vec<Shape>, at: DVec2) {
        let radius = if self.is_published() { HOLLOW } else { RADIUS };
        let outline = symbol(kind(self.number), at, radius + self.rim());
        if self.is_published() {
            // Not filled, so that what is below can be seen.
            let closed = outline.iter().copied().chain(outline.first().copied()).collect();
            let style = Style { color: self.color(), width: 1.4, cap: Cap::Round };
            shapes.push(Shape::Lines { style, lines: vec![closed] });
        } else {
            shapes.push(Shape::Area { color: self.color(), polygons: vec![outline] });
        }
    }

    /// Do most points of this series lie under those of another one? Hollow symbols hide nothing.
    pub fn is_hidden_by(&self, points: &[Option<DVec2>], other: &Self, others: &[Option<DVec2>]) -> bool {
        /// In pixels.
        const NEAR: f64 = 2.0;
        if self.is_published()
            || other.is_published()
            || other.series.mark != self.series.mark
            || self.as_bars
        {
            return false;
        }
        let known = || points.iter().flatten();
        let is_met = |p: &&DVec2| others.iter().flatten().any(|q| q.distance(**p) < NEAR);
        known().count() > 1 && 2 * known().filter(is_met).count() > known().count()
    }

    /// The line and the symbols of a series; lines have gaps where there is no point.
    pub fn push_line(&self, shapes: &mut Vec<Shape>, points: &[Option<DVec2>]) {
        let runs: Vec<Vec<DVec2>> =
            points.split(Option::is_none).map(|run| run.iter().flatten().copied().collect()).collect();
        if self.series.mark != Mark::Points {
            runs.iter().filter(|run| run.len() > 1).for_each(|run| self.push_stroke(shapes, run));
        }
        if self.has_symbols() {
            runs.iter().flatten().for_each(|&at| self.push_symbol(shapes, at));
        }
    }

    /// Are there symbols at its values?
    fn has_symbols(&self) -> bool {
        matches!(self.series.mark, Mark::Points | Mark::LinePoints)
    }

    /// A line from the foot of the plot to its top.
    pub fn push_upright(&self, shapes: &mut Vec<Shape>, foot: DVec2, top: DVec2) {
        self.push_stroke(shapes, &[foot, top]);
    }

    /// What distinguishes it from others: the numbers of its colour, symbol and dashes, and whether it is published.
    #[cfg(test)]
    pub fn traits(&self) -> (usize, Option<usize>, Option<usize>, bool) {
        let symbol = self.has_symbols().then(|| kind(self.number));
        let dashes = (self.series.mark != Mark::Points)
            .then(|| if self.is_published() { 1 + self.number % DASHES.len() } else { 0 });
        (self.number % COLORS.len(), symbol, dashes, self.is_published())
    }

    /// The sample of the legend, whose left end is at `at`: line and symbol as they are drawn.
    pub fn push_sample(&self, shapes: &mut Vec<Shape>, at: DVec2, width: f64) {
        if self.as_bars {
            let (low, high) = (at + dvec2(6.0, 5.0), at + dvec2(width, -5.0));
            return push_bar(shapes, self.number, self.color(), self.is_published(), low, high);
        }
        if self.series.mark != Mark::Points {
            self.push_stroke(shapes, &[at, at + dvec2(width, 0.0)]);
        }
        if self.has_symbols() {
            self.push_symbol(shapes, at + dvec2(0.5 * width, 0.0));
        }
    }
}

/// The symbol of a look: of an eleventh one, whose colour is that of the first, the second.
fn kind(number: usize) -> usize {
    number + number / COLORS.len()
}
