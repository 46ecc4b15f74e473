//! A line of a round length, in the units of the model.

use crate::font::{ASCENT, DESCENT, Direction, Line};
use crate::layout::{Layout, Place, Rect};
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

/// What it is called in reports.
pub(crate) const WHAT: &str = "scale bar";

/// Lengths of the longest line that are tried, as shares of the picture's width.
const SHARES: [f64; 3] = [LONGEST, 0.18, 0.12];
/// Numbers that are about as long as any other round length; where they have no room, a short one.
const NUMBERS: [&str; 3] = ["500000", "5×10⁻¹²", "50"];

/// The sizes of boxes that have room for a scale bar of any camera, the largest first.
pub(crate) fn sizes(layout: &Layout, unit: &str) -> Vec<[f64; 2]> {
    let width = |number: &&str| Line::new(format!("{number} {unit}").trim_end()).width * layout.em;
    let [long, power, short] = [0, 1, 2].map(|k| width(&NUMBERS[k]));
    let of_share = |share: f64, text: f64| (layout.size[0] * share + layout.line).max(text).ceil();
    let wide = SHARES.map(|share| of_share(share, long.max(power)));
    wide.into_iter().chain([of_share(SHARES[2], short)]).map(|width| [width, height(layout.em)]).collect()
}

fn height(em: f64) -> f64 {
    (em * (ASCENT + DESCENT + 0.65)).ceil()
}

/// Draws a scale bar in a box of one of the [`sizes`]; `unit` is written behind the number. Returns the length, which is true everywhere
/// for an orthographic camera, and for one with perspective in the plane through its target.
pub(crate) fn draw(
    layout: &mut Layout,
    projector: &Projector,
    unit: &str,
    place: Place,
    slot: Rect,
) -> Option<ScaleLength> {
    let (em, w) = (layout.em, layout.line);
    let most = (layout.size[0] * LONGEST).min(slot[2] - slot[0] - w);
    let found = round_length(projector.pixels_per_unit(), most).and_then(|length| {
        let text = format!("{} {unit}", number::general(length.units, 6));
        let line = Line::new(text.trim_end());
        let width = (length.pixels + w).max(line.width * em).ceil();
        let left = (slot[0] + (slot[2] - slot[0] - width) * place.x).round();
        (left >= slot[0]).then_some((length, line, [left, slot[1], left + width, slot[3]]))
    });
    let Some((length, line, rect)) = found else {
        layout.leave_out(WHAT);
        return None;
    };
    layout.keep(WHAT, rect);
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
