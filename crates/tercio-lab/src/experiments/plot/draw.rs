//! Drawing a plot as a page of lines, areas and text.

use glam::{DVec2, dvec2};
use tercio::vector::{Anchor, Cap, Page, Shape, Style, VectorFormat};

use super::bars::{FILLED, push_bar, push_gap};
use super::label::{self, INK, LABEL, LINE};
use super::legend::Legend;
use super::look::Look;
use super::scale::Division;
use super::{Mark, Plot, Series};

/// Width of a plot, and its height if the legend needs no more, in pixels of which 96 are an inch.
const SIZE: DVec2 = dvec2(640.0, 420.0);
const MARGIN: f64 = 14.0;
const TITLE: f64 = 16.0;
/// From an axis to its numbers: more than the radius of a symbol at the origin.
const GAP: f64 = 12.0;

/// The rectangle of the data, and the axes along it.
struct Frame {
    low: DVec2,
    high: DVec2,
    x: Division,
    y: Division,
}

impl Plot {
    /// The points of a series in axis coordinates; nothing where a point cannot be drawn.
    fn placed(&self, series: &Series) -> Vec<Option<DVec2>> {
        let place = |&(x, y): &(f64, f64)| {
            let place = dvec2(self.x.scale.place(x), self.y.scale.place(y));
            place.is_finite().then_some(place)
        };
        series.points.iter().map(place).collect()
    }

    /// The places of upright lines along the horizontal axis.
    fn upright(&self, series: &Series) -> Vec<f64> {
        let places = if series.mark == Mark::Upright { &series.points[..] } else { &[] };
        places.iter().map(|p| self.x.scale.place(p.0)).filter(|x| x.is_finite()).collect()
    }

    /// The looks of all series: each has its own, but published values that of the series they belong to, and a line that of points.
    fn looks(&self) -> Vec<Look<'_>> {
        let mut looks: Vec<Look<'_>> = Vec::new();
        let mut next = 0;
        for series in &self.series {
            let is_apart = |other: &Series| {
                let marks = [other.mark, series.mark];
                other.role != series.role
                    || marks == [Mark::Points, Mark::Line]
                    || marks == [Mark::Line, Mark::Points]
            };
            let is_like =
                |look: &&Look<'_>| series.like.as_ref() == Some(&look.series.label) && is_apart(look.series);
            let other = looks.iter().find(is_like).map(|look| look.number);
            let number = other.unwrap_or(next);
            next += usize::from(other.is_none());
            looks.push(Look { series, number, as_bars: self.x.categories.is_some(), hidden_by: 0 });
        }
        looks
    }

    /// The plot as a file.
    pub fn to_file(&self, format: VectorFormat) -> Vec<u8> {
        self.page().to_bytes(format)
    }

    /// The plot as a page.
    pub(super) fn page(&self) -> Page {
        let placed: Vec<_> = self.series.iter().map(|s| self.placed(s)).collect();
        let has_gaps = self.x.categories.is_some() && placed.iter().flatten().any(Option::is_none);
        let legend = Legend::of(self, has_gaps);
        let title = label::wrapped(&self.title, TITLE, SIZE.x - 2.0 * MARGIN);
        let known = || placed.iter().flatten().flatten();
        let x = match &self.x.categories {
            Some(names) => {
                let first = f64::from(names.first) - 0.5;
                Division::of_categories(first, first + names.names.len() as f64)
            }
            None => {
                let upright = self.series.iter().flat_map(|series| self.upright(series));
                Division::new(self.x.scale, false, known().map(|p| p.x).chain(upright))
            }
        };
        // The vertical axis starts at zero, so that heights can be compared.
        let y = Division::new(self.y.scale, true, known().map(|p| p.y));

        let widest = y.ticks.iter().map(|&t| label::width(&y.label(t), LABEL)).fold(0.0, f64::max);
        let left = MARGIN + LINE + 8.0 + widest + GAP;
        let top = MARGIN + title.len() as f64 * (TITLE + 4.0) + 10.0;
        let beside = legend.size();
        let right = SIZE.x - MARGIN - if beside.x > 0.0 { beside.x + 16.0 } else { 14.0 };
        let names = Names::of(self, (right - left) / (x.high - x.low));
        let below = names.height() + LINE + 20.0;
        let height = SIZE.y.max(top + beside.y + below + MARGIN);
        let frame = Frame { low: dvec2(left, height - MARGIN - below), high: dvec2(right, top), x, y };

        let mut page = Page { size: [SIZE.x, height], background: Some([255; 4]), shapes: Vec::new() };
        let shapes = &mut page.shapes;
        for (i, line) in title.iter().enumerate() {
            let at = dvec2(MARGIN, MARGIN + TITLE + i as f64 * (TITLE + 4.0));
            label::push(shapes, line, TITLE, at, Anchor::Start, false);
        }
        self.push_axes(shapes, &frame, &names);
        let mut looks = self.looks();
        if self.x.categories.is_some() {
            push_all_bars(shapes, &frame, &looks, &placed);
        } else {
            let on_page =
                |points: &Vec<Option<DVec2>>| points.iter().map(|p| p.map(|p| frame.at(p))).collect();
            let points: Vec<Vec<_>> = placed.iter().map(on_page).collect();
            for i in 0..looks.len() {
                let hides = |j: &usize| looks[i].is_hidden_by(&points[i], &looks[*j], &points[*j]);
                looks[i].hidden_by = (i + 1..looks.len()).filter(hides).count() as u32;
            }
            for (look, points) in looks.iter().zip(&points) {
                for x in self.upright(look.series) {
                    let foot = frame.at(dvec2(x, frame.y.low));
                    look.push_upright(shapes, foot, dvec2(foot.x, frame.high.y));
                }
                look.push_line(shapes, points);
            }
        }
        legend.push(shapes, dvec2(right + 16.0, top), &looks);
        page
    }

    fn push_axes(&self, shapes: &mut Vec<Shape>, frame: &Frame, names: &Names) {
        let Frame { low, high, x, y } = frame;
        let style = |alpha, width| Style { color: [INK[0], INK[1], INK[2], alpha], width, cap: Cap::Square };
        let mut grid = Vec::new();
        for &tick in &y.ticks {
            let at = frame.at(dvec2(x.low, tick));
            grid.push(vec![at, dvec2(high.x, at.y)]);
            let text = at + dvec2(-GAP, 0.36 * LABEL);
            label::push(shapes, &y.label(tick), LABEL, text, Anchor::End, false);
        }
        let foot = low.y + LINE + 6.0;
        if names.lines.is_empty() {
            let labels: Vec<_> = x.ticks.iter().map(|&t| (frame.at(dvec2(t, y.low)), x.label(t))).collect();
            let every = sparse(&labels);
            for (i, (at, text)) in labels.into_iter().enumerate() {
                grid.push(vec![at, dvec2(at.x, high.y)]);
                if i % every == 0 {
                    label::push(shapes, &text, LABEL, dvec2(at.x, foot), Anchor::Middle, false);
                }
            }
        }
        for (i, lines) in names.lines.iter().enumerate() {
            let at = frame.at(dvec2(x.low + 0.5 + i as f64, y.low));
            for (k, line) in lines.iter().enumerate() {
                if names.upwards {
                    let at = at + dvec2(0.36 * LABEL, 6.0);
                    label::push(shapes, line, LABEL, at, Anchor::End, true);
                } else {
                    let at = dvec2(at.x, foot + k as f64 * LINE);
                    label::push(shapes, line, LABEL, at, Anchor::Middle, false);
                }
            }
        }
        shapes.push(Shape::Lines { style: style(34, 1.0), lines: grid });
        let axes = vec![vec![dvec2(low.x, high.y), *low, dvec2(high.x, low.y)]];
        shapes.push(Shape::Lines { style: style(255, 1.0), lines: axes });
        let middle = 0.5 * (*low + *high);
        let at = dvec2(middle.x, foot + names.height() + 4.0);
        label::push(shapes, &self.x.label, LABEL, at, Anchor::Middle, false);
        label::push(shapes, &self.y.label, LABEL, dvec2(MARGIN + LABEL, middle.y), Anchor::Middle, true);
    }
}

/// What is written below the horizontal axis.
struct Names {
    /// Lines of text of every category.
    lines: Vec<Vec<String>>,
    /// Are they read upwards, because a word is wider than a category?
    upwards: bool,
}

impl Names {
    fn of(plot: &Plot, width: f64) -> Self {
        let names = || plot.x.categories.iter().flat_map(|c| &c.names);
        let lines: Vec<_> = names().map(|name| label::wrapped(name, LABEL, width - 6.0)).collect();
        if lines.iter().flatten().all(|line| label::width(line, LABEL) <= width - 6.0) {
            return Self { lines, upwards: false };
        }
        Self { lines: names().map(|name| vec![name.clone()]).collect(), upwards: true }
    }

    /// In pixels; that of ticks if there are no names.
    fn height(&self) -> f64 {
        if self.upwards {
            return self.lines.iter().flatten().map(|line| label::width(line, LABEL)).fold(0.0, f64::max);
        }
        self.lines.iter().map(Vec::len).max().unwrap_or(1) as f64 * LINE
    }
}

/// Of how many ticks one has a label, so that labels do not touch.
fn sparse(labels: &[(DVec2, String)]) -> usize {
    let fits = |every: &usize| {
        let shown: Vec<_> = labels.iter().step_by(*every).collect();
        shown.windows(2).all(|pair| {
            let half = |label: &(DVec2, String)| 0.5 * label::width(&label.1, LABEL);
            pair[1].0.x - pair[0].0.x > half(pair[0]) + half(pair[1]) + 6.0
        })
    };
    (1..=labels.len().max(1)).find(fits).unwrap_or(1)
}

fn push_all_bars(shapes: &mut Vec<Shape>, frame: &Frame, looks: &[Look<'_>], placed: &[Vec<Option<DVec2>>]) {
    let width = FILLED / looks.len() as f64;
    for (i, (look, points)) in looks.iter().zip(placed).enumerate() {
        for (point, &(x, _)) in points.iter().zip(&look.series.points) {
            let left = x - 0.5 * FILLED + i as f64 * width;
            let foot = |x| frame.at(dvec2(x, frame.y.low));
            let Some(point) = point else {
                let size = (1.6 * (foot(left + width).x - foot(left).x)).clamp(9.0, LABEL);
                push_gap(shapes, size, foot(left + 0.5 * width));
                continue;
            };
            let high = frame.at(dvec2(left + 0.94 * width, point.y));
            push_bar(shapes, look.number, look.color(), look.is_published(), foot(left), high);
        }
    }
}

impl Frame {
    fn at(&self, place: DVec2) -> DVec2 {
        let share = dvec2(self.x.share(place.x), self.y.share(place.y));
        self.low + (self.high - self.low) * share
    }
}

#[cfg(test)]
mod tests;
