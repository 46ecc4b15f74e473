//! Text on a page, in Helvetica: one of the fonts that every reader of PDF has, whose widths other systems' Arial and Liberation
//! Sans share.

use glam::DVec2;

/// A line of text.
#[derive(Clone, Debug, PartialEq)]
pub struct Text {
    /// sRGB and alpha.
    pub color: [u8; 4],
    /// Height of the font in pixels.
    pub size: f64,
    /// Start, middle or end of the base line, in pixels from the upper left corner.
    pub at: DVec2,
    /// Which of them.
    pub anchor: Anchor,
    /// Read upwards instead of to the right.
    pub upwards: bool,
    /// The characters. A PDF shows those of Latin-1, and '?' for others.
    pub text: String,
}

/// The place of a line of text that its coordinates give.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    /// Where it begins.
    Start,
    /// Halfway.
    Middle,
    /// Where it ends.
    End,
}

impl Anchor {
    /// The share of the line before that place.
    pub fn share(self) -> f64 {
        match self {
            Self::Start => 0.0,
            Self::Middle => 0.5,
            Self::End => 1.0,
        }
    }
}

/// Widths of the characters from ' ' to '~' in thousandths of the font's height: Adobe's metrics of Helvetica.
const WIDTHS: [u16; 95] = [
    278, 278, 355, 556, 556, 889, 667, 191, 333, 333, 389, 584, 278, 333, 278, 278, 556, 556, 556, 556, 556,
    556, 556, 556, 556, 556, 278, 278, 584, 584, 584, 556, 1015, 667, 667, 722, 722, 667, 611, 778, 722, 278,
    500, 667, 556, 833, 722, 778, 667, 778, 722, 667, 611, 722, 667, 944, 667, 667, 611, 278, 278, 278, 469,
    556, 333, 556, 556, 500, 556, 556, 278, 556, 556, 222, 222, 500, 222, 833, 556, 556, 556, 556, 333, 500,
    278, 556, 500, 722, 500, 500, 500, 334, 260, 334, 584,
];

/// Width of a line of text in pixels, for a font of height `size`. Characters outside ASCII count as wide as a digit.
pub fn text_width(text: &str, size: f64) -> f64 {
    let width = |c: char| {
        let place = (c as usize).checked_sub(usize::from(b' '));
        f64::from(place.and_then(|place| WIDTHS.get(place)).copied().unwrap_or(556))
    };
    text.chars().map(width).sum::<f64>() * size / 1000.0
}

impl Text {
    /// Where the line begins.
    pub(super) fn start(&self) -> DVec2 {
        let along = if self.upwards { DVec2::NEG_Y } else { DVec2::X };
        self.at - along * (self.anchor.share() * text_width(&self.text, self.size))
    }

    /// The characters, with a question mark for those for control, which neither format can hold.
    pub(super) fn characters(&self) -> impl Iterator<Item = char> {
        self.text.chars().map(|c| if c.is_control() { '?' } else { c })
    }
}
