//! The bar of values that are names: a list of colours.

use super::{NO_DATA, ScalarBar, linear};
use crate::font::{CAP_HEIGHT, Direction};
use crate::layout::{Layout, Rect, SHRINK, TextBlock};
use crate::overlay::Paint;

impl ScalarBar {
    /// A list of colours with their names, the first above; as many as there is room for.
    pub(super) fn add_list(&self, layout: &mut Layout, name: &str) -> Option<Rect> {
        let [left, top, right, bottom] = layout.area();
        let mut entries: Vec<(&str, [f32; 4])> =
            self.colors.categories.iter().map(|c| (&*c.label, linear(c.color))).collect();
        if self.shows_nan {
            entries.push((NO_DATA, linear(self.colors.nan)));
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
        let swatch = (em * 1.15).round().max(2.0);
        let step = (em * 1.5).ceil();
        let (text_left, left_out) = (swatch + em * 0.5, entries.len() - most);
        let title =
            (!self.title.trim().is_empty()).then(|| TextBlock::fit(self.title.trim(), em, room[0], 2));
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
        let color = layout.color;
        if let Some(title) = &title {
            layout.draw_text(title, [rect[0], rect[1]], 0.0, color);
            title.missing(&format!("the title of {name}")).iter().for_each(|what| layout.leave_out(what));
        }
        for (number, label) in labels.iter().chain(&more).enumerate() {
            let middle = rect[1] + above + step * (number as f64 + 0.5);
            if let Some((_, fill)) = entries[..most].get(number) {
                let y = (middle - swatch * 0.5).round();
                let square = [rect[0], y, rect[0] + swatch, y + swatch];
                layout.overlay.rectangle(square, Paint::Solid(*fill));
                layout.frame(square, color);
            }
            let at = [rect[0] + text_left, middle + label.em * CAP_HEIGHT * 0.5].map(f64::round);
            layout.overlay.text(&label.lines[0], at, label.em, Direction::Right, color);
        }
        if labels.iter().any(|label| label.is_cut) {
            layout.leave_out(&format!("the ends of labels of {name}"));
        }
        Some(rect)
    }
}
