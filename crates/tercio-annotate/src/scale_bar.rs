//! A line of a round length, in the units of the model.

use crate::font::{ASCENT, DESCENT, Direction, Line};
use crate::layout::{Layout, Place};
use crate::number;
use crate::overlay::Paint;
use crate::project::Projector;

/// The longest line, as a share of the picture's width.
const LONGEST: f64 = 0.25;

/// The length of a scale bar and its pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScaleLength {
    /// In units of the model: 1, 2 or 5 times a power of ten.
    pub units: f64,
    /// In the picture.
    pub pixels: f64,
}

/// The longest round length that has at most so many pixels; `None` if there is none.
pub fn round_length(pixels_per_unit: f64, most: f64) -> Option<ScaleLength> {
    let longest = most / pixels_per_unit;
    if !(longest.is_normal() && longest > 0.0) {
        return None;
    }
    let exponent = number::exponent_of(longest);
    let lengths = [(5, exponent), (2, exponent), (1, exponent), (5, exponent - 1)];
    let length = |(digit, exponent): (i32, i32)| format!("{digit}e{exponent}").parse().ok();
    let units =
        lengths.into_iter().filter_map(length).find(|&length: &f64| length <= longest && length > 0.0)?;
    Some(ScaleLength { units, pixels: units * pixels_per_unit })
}

/// Adds a scale bar; `unit` is written behind the number. Returns the length, which is true everywhere for an orthographic camera, and
/// for one with perspective in the plane through its target.
pub fn add(layout: &mut Layout, projector: &Projector, unit: &str, place: Place) -> Option<ScaleLength> {
    let (em, w) = (layout.em, layout.line);
    let length = round_length(projector.pixels_per_unit(), layout.size[0] * LONGEST);
    let found = length.and_then(|length| {
        let text = format!("{} {unit}", number::general(length.units, 6));
        let line = Line::new(text.trim_end());
        let width = (length.pixels + w).max(line.width * em).ceil();
        let height = (em * (ASCENT + DESCENT + 0.65)).ceil();
        layout.find([width, height], place).map(|rect| (length, line, rect))
    });
    let Some((length, line, rect)) = found else {
        layout.leave_out("scale bar");
        return None;
    };
    layout.keep("scale bar", rect);
    let color = layout.color;
    let middle = (rect[0] + rect[2]) * 0.5;
    let baseline = rect[1] + em * ASCENT;
    let at = [middle - line.width * em * 0.5, baseline].map(f64::round);
    layout.overlay.text(&line, at, em, Direction::Right, color);
    // Not rounded: its length is what it is for.
    let (left, right) = (middle - length.pixels * 0.5, middle + length.pixels * 0.5);
    let y = (rect[3] - em * 0.28).round();
    let thick = (em * 0.14).round().max(w);
    layout.overlay.rectangle([left, y - thick * 0.5, right, y + thick * 0.5], Paint::Solid(color));
    let tick = (em * 0.27).round();
    for x in [left, right - w] {
        layout.overlay.rectangle([x, y - tick, x + w, y + tick], Paint::Solid(color));
    }
    Some(length)
}
