//! The bar of values that are names: a list of colours.

use super::{NO_DATA, ScalarBar, linear};
use crate::font::{CAP_HEIGHT, Direction};
use crate::layout::{Layout, Rect, SHRINK, TextBlock};
use crate::overlay::Paint;

impl ScalarBar {
    /// A list of colours with their names, the first above or at the left; as many as there is room for.
    pub(super) fn add_list(&self, layout: &mut Layout, name: &str) -> Option<Rect> {
        let [left, top, right, bottom] = layout.area();
        let mut entries: Vec<(&str, [f32; 4])> =
            self.colors.categories.iter().map(|c| (&*c.label, linear(c.color))).collect();
        if self.shows_nan {
            // Values that a map does not name are no categories.
            let label = if self.colors.map.names_values() { OTHER } else { NO_DATA };
            entries.push((label, linear(self.colors.nan)));
        }
        // Across the border at a side of the picture, lines would take the room of the model.
        if !self.is_upright && !self.is_across() {
            let of_size = |shrink| self.level_list(layout, name, &entries, shrink);
            let found = [1.0, 0.85, SHRINK].into_iter().find_map(of_size);
            if found.is_some() {
                return found;
            }
        }
        let room = [(right - left) * 0.66, bottom - top];
        for shrink in [1.0, 0.85, SHRINK] {
            for most in (1..=entries.len()).rev() {
                // All of them in smaller text, rather than some in larger.
                if most < entries.len() && shrink > SHRINK {
                    break;
                }
                if let Some(rect) = self.list_of(layout, name, &entries, most, layout.em * shrink, room) {
                    return Some(rect);
                }
            }
        }
        None
    }

    fn list_of(
        &self,
        layout: &mut Layout,
        name: &str,
        entries: &[(&str, [f32; 4])],
        most: usize,
        em: f64,
        room: [f64; 2],
    ) -> Option<Rect> {
        let step = (em * 1.5).ceil();
        let (text_left, left_out) = (swatch(em) + em * 0.5, entries.len() - most);
        let title = (!self.title.trim().is_empty())
            .then(|| TextBlock::fit_with_unit(self.title.trim(), em, room[0], 2));
        let above = title.as_ref().map_or(0.0, |title| title.size[1] + em * 0.5).ceil();
        let more = format!("and {left_out} more");
        let rows = most + usize::from(left_out > 0);
        let height = above + step * rows as f64;
        if height > room[1] {
            return None;
        }
        let fit = |text: &str| TextBlock::fit(text, em, room[0] - text_left, 1);
        let labels: Vec<TextBlock> = entries[..most].iter().map(|(label, _)| fit(label)).collect();
        let more = (left_out > 0).then(|| fit(&more));
        let widest = labels.iter().chain(&more).fold(0.0f64, |width, label| width.max(label.size[0]));
        let width = (text_left + widest).max(title.as_ref().map_or(0.0, |title| title.size[0])).ceil();
        let rect = self.find(layout, [width, height])?;
        if let Some(title) = &title {
            layout.draw_text(title, [rect[0], rect[1]], 0.0, layout.color);
            title.missing(&format!("the title of {name}")).iter().for_each(|what| layout.leave_out(what));
        }
        for (number, label) in labels.iter().chain(&more).enumerate() {
            let at = [rect[0], rect[1] + above + step * (number as f64 + 0.5)];
            draw_entry(layout, at, em, entries[..most].get(number).map(|(_, fill)| *fill), label);
        }
        if labels.iter().any(|label| label.is_cut) {
            layout.leave_out(&format!("the ends of labels of {name}"));
        }
        Some(rect)
    }

    /// The entries beside each other, in as many lines as they need; only in the smallest text some of them are left out.
    fn level_list(
        &self,
        layout: &mut Layout,
        name: &str,
        entries: &[(&str, [f32; 4])],
        shrink: f64,
    ) -> Option<Rect> {
        let [left, top, right, bottom] = layout.area();
        let em = layout.em * shrink;
        let room = (right - left) * if self.place.x == 0.5 { 1.0 } else { 0.66 };
        let (step, text_left) = ((em * 1.5).ceil(), swatch(em) + em * 0.5);
        let title = self.title.trim();
        let title = (!title.is_empty()).then(|| TextBlock::fit_with_unit(title, em, room, 2));
        let above = title.as_ref().map_or(0.0, |title| title.size[1] + em * 0.3).ceil();
        let most_lines = (((bottom - top) * LEVEL - above) / step) as usize;
        let fit = |text: &str| TextBlock::fit(text, em, room - text_left, 1);
        let mut labels: Vec<TextBlock> = entries.iter().map(|(label, _)| fit(label)).collect();
        // The line of each, where it begins there, and where it ends.
        let places = |labels: &[TextBlock]| -> Vec<(usize, [f64; 2])> {
            let (mut line, mut x) = (0, 0.0);
            let place = |label: &TextBlock| {
                let width = text_left + label.size[0];
                if x > 0.0 && x + width > room {
                    (line, x) = (line + 1, 0.0);
                }
                let begin = x;
                x += width + em * BETWEEN;
                (line, [begin, begin + width])
            };
            labels.iter().map(place).collect()
        };
        let fits = |labels: &[TextBlock]| places(labels).last().is_some_and(|(line, _)| *line < most_lines);
        let mut most = entries.len();
        if !fits(&labels) {
            let there = places(&labels).iter().filter(|(line, _)| *line < most_lines).count();
            let with_rest = |most: usize| {
                let more = fit(&format!("and {} more", entries.len() - most));
                labels[..most].iter().cloned().chain([more]).collect::<Vec<_>>()
            };
            most = (1..=there).rev().find(|&most| shrink <= SHRINK && fits(&with_rest(most)))?;
            labels = with_rest(most);
        }
        let places = places(&labels);
        let lines = places.last().map_or(0, |(line, _)| line + 1);
        let width_of = |line: usize| places.iter().filter(|p| p.0 == line).fold(0.0f64, |w, p| w.max(p.1[1]));
        let widest = (0..lines).map(width_of).fold(0.0f64, f64::max);
        let width = widest.max(title.as_ref().map_or(0.0, |title| title.size[0])).ceil();
        let rect = self.find(layout, [width, (above + step * lines as f64).ceil()])?;
        if let Some(title) = &title {
            let x = rect[0] + (width - title.size[0]) * self.place.x;
            layout.draw_text(title, [x, rect[1]], self.place.x, layout.color);
            title.missing(&format!("the title of {name}")).iter().for_each(|what| layout.leave_out(what));
        }
        for (number, (label, (line, [x, _]))) in labels.iter().zip(&places).enumerate() {
            let begin = rect[0] + (width - width_of(*line)) * self.place.x;
            let at = [begin + x, rect[1] + above + step * (*line as f64 + 0.5)];
            draw_entry(layout, at, em, entries[..most].get(number).map(|(_, fill)| *fill), label);
        }
        if labels.iter().any(|label| label.is_cut) {
            layout.leave_out(&format!("the ends of labels of {name}"));
        }
        Some(rect)
    }
}

/// What is written beside the colour of what is no category.
const OTHER: &str = "other";
/// The most of a picture's height that lines of entries take, with their title.
const LEVEL: f64 = 0.4;
/// From the end of an entry to the next one in its line, in ems.
const BETWEEN: f64 = 1.2;

/// The side of the square of a colour.
fn swatch(em: f64) -> f64 {
    (em * 1.15).round().max(2.0)
}

/// Draws a label with the square of its colour, if it has one, from its left border and the middle of its line.
fn draw_entry(
    layout: &mut Layout,
    [x, middle]: [f64; 2],
    em: f64,
    fill: Option<[f32; 4]>,
    label: &TextBlock,
) {
    let (swatch, color) = (swatch(em), layout.color);
    if let Some(fill) = fill {
        let (x, y) = (x.round(), (middle - swatch * 0.5).round());
        let square = [x, y, x + swatch, y + swatch];
        layout.overlay.rectangle(square, Paint::Solid(fill));
        layout.frame(square, color);
    }
    let at = [x + swatch + em * 0.5, middle + label.em * CAP_HEIGHT * 0.5].map(f64::round);
    layout.overlay.text(&label.lines[0], at, label.em, Direction::Right, color);
}
