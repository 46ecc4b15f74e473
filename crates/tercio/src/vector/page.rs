//! A drawing: lines, dots and areas on a page.

use std::io::{self, Write};

use glam::DVec2;

use super::text::Text;

/// How a line ends, and what a line of one point is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Cap {
    /// Round ends; a disc.
    Round,
    /// Straight ends, half of the width beyond the last point; a square.
    Square,
}

/// How lines look.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Style {
    /// sRGB and alpha.
    pub color: [u8; 4],
    /// In pixels.
    pub width: f64,
    /// Ends.
    pub cap: Cap,
}

/// Something on a page, before everything that precedes it.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// Lines of one style, each with one or more points, in pixels from the upper left corner, y downwards. A line that ends where
    /// it begins is closed.
    Lines {
        /// How they look.
        style: Style,
        /// Their points.
        lines: Vec<Vec<DVec2>>,
    },
    /// What polygons enclose; those in the opposite direction are holes.
    Area {
        /// sRGB and alpha.
        color: [u8; 4],
        /// Their corners, in pixels.
        polygons: Vec<Vec<DVec2>>,
    },
    /// A line of text.
    Text(Text),
}

/// A drawing.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Page {
    /// Width and height in pixels, of which a PDF has 96 an inch.
    pub size: [f64; 2],
    /// sRGB and alpha of what is behind everything, if there is something.
    pub background: Option<[u8; 4]>,
    /// From the back to the front.
    pub shapes: Vec<Shape>,
}

impl Page {
    /// Is nothing on it besides its background?
    pub fn is_empty(&self) -> bool {
        self.shapes.is_empty()
    }

    /// How many lines there are, dots included.
    pub fn line_count(&self) -> usize {
        let count = |shape: &Shape| match shape {
            Shape::Lines { lines, .. } => lines.len(),
            Shape::Area { .. } | Shape::Text(_) => 0,
        };
        self.shapes.iter().map(count).sum()
    }
}

/// A coordinate in ten-thousandths of a pixel: what files contain.
pub(super) fn fixed(c: f64) -> i64 {
    (c * 1e4).round() as i64
}

/// Appends ten-thousandths as a decimal number.
pub(super) fn push_fixed(out: &mut String, number: i64) {
    use std::fmt::Write as _;
    let (whole, rest) = (number.unsigned_abs() / 10_000, number.unsigned_abs() % 10_000);
    let sign = if number < 0 { "-" } else { "" };
    // Writing to a string cannot fail.
    let _ = match rest {
        0 => write!(out, "{sign}{whole}"),
        _ => {
            let digits = format!("{rest:04}");
            write!(out, "{sign}{whole}.{}", digits.trim_end_matches('0'))
        }
    };
}

/// A decimal number with at most four decimals.
pub(super) fn number(value: f64) -> String {
    let mut text = String::new();
    push_fixed(&mut text, fixed(value));
    text
}

/// Does a line end where it begins?
pub(super) fn is_closed(line: &[DVec2]) -> bool {
    line.len() > 3 && line.first() == line.last()
}

/// Text that is collected before it is written.
const BUFFER: usize = 1 << 16;

/// Writes text that has become long.
pub(super) fn flush(text: &mut String, out: &mut dyn Write) -> io::Result<()> {
    if text.len() >= BUFFER {
        out.write_all(text.as_bytes())?;
        text.clear();
    }
    Ok(())
}
