//! Titles and captions.

use crate::layout::{Layout, Place, Rect, TextBlock};

/// Text at the left or right of the model takes at most this share of the picture's width, if it can.
const BESIDE: f64 = 0.35;

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

    /// Adds it to a picture. Returns its box; `None` if there is no room.
    pub fn add(&self, layout: &mut Layout) -> Option<Rect> {
        let block = self.block(layout);
        let what = self.what();
        let is_empty = block.lines.iter().all(crate::font::Line::is_empty);
        let rect = layout.find(block.size, self.place).filter(|_| !is_empty)?;
        layout.draw_text(&block, [rect[0], rect[1]], self.place.x, layout.color);
        layout.keep(&what, rect);
        if let Some(missing) = block.missing(&what) {
            layout.leave_out(&missing);
        }
        Some(rect)
    }

    /// Its lines: beside the model they are short, unless they would be cut off.
    fn block(&self, layout: &Layout) -> TextBlock {
        let [left, top, right, bottom] = layout.area();
        let em = layout.em * self.size;
        let most_lines = ((bottom - top) * 0.5 / (em * crate::font::LINE)).max(1.0) as usize;
        let fit = |width: f64| TextBlock::fit(&self.text, em, width, most_lines);
        let Place { x, y } = self.place;
        let is_beside = (x == 0.0 || x == 1.0) && y != 0.0 && y != 1.0;
        let narrow = is_beside.then(|| fit((right - left) * BESIDE)).filter(|block| !block.is_cut);
        narrow.unwrap_or_else(|| fit(right - left))
    }
}
