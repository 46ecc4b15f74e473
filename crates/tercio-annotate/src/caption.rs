//! Titles and captions.

use crate::layout::{Layout, Place, TextBlock};

/// A text in a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Caption {
    /// The text, of one line or several.
    pub text: String,
    /// Where it is.
    pub place: Place,
    /// Its size, relative to usual text.
    pub size: f64,
}

impl Caption {
    /// A title: larger, above the picture's middle.
    pub fn title(text: &str) -> Self {
        Self { text: text.to_owned(), place: Place { x: 0.5, y: 0.0 }, size: 1.35 }
    }

    /// What it is, for reports.
    pub(crate) fn what(&self) -> String {
        format!("text \"{}\"", self.text.chars().take(40).collect::<String>())
    }

    /// Adds it to a picture.
    pub fn add(&self, layout: &mut Layout) {
        let [left, top, right, bottom] = layout.area();
        let em = layout.em * self.size;
        let most_lines = ((bottom - top) * 0.5 / (em * crate::font::LINE)).max(1.0) as usize;
        let block = TextBlock::fit(&self.text, em, right - left, most_lines);
        let what = self.what();
        let is_empty = block.lines.iter().all(crate::font::Line::is_empty);
        match layout.find(block.size, self.place).filter(|_| !is_empty) {
            Some(rect) => {
                layout.draw_text(&block, [rect[0], rect[1]], self.place.x, layout.color);
                layout.keep(&what, rect);
                if let Some(missing) = block.missing(&what) {
                    layout.leave_out(&missing);
                }
            }
            None => layout.leave_out(&what),
        }
    }
}
