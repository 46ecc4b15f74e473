//! The scalar bar: which colour means which number.

mod categories;
mod marks;

use std::sync::Arc;

use tercio_mesh::color::srgb_to_linear;
use tercio_scene::color_map::DataColors;

use crate::annotation::sides_of;
use crate::font::{ASCENT, CAP_HEIGHT, DESCENT, Direction, Line};
use crate::layout::{Layout, Place, Rect, SHRINK, TextBlock};
use crate::number::NumberFormat;
use crate::outline::Outline;
use crate::overlay::Paint;
use crate::ticks::Tick;

/// What a scalar bar shows, and how.
#[derive(Clone, Debug)]
pub struct ScalarBar {
    /// The colours.
    pub colors: DataColors,
    /// What the numbers are, with their unit; nothing is written if it is empty.
    pub title: String,
    /// How numbers are printed.
    pub format: NumberFormat,
    /// Where it is.
    pub place: Place,
    /// Whether it is vertical, with the largest number above.
    pub is_upright: bool,
    /// Whether the colour of what is no number is shown.
    pub shows_nan: bool,
    /// Where it is marked.
    pub marks: Marks,
}

/// Where a scalar bar is marked with numbers.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Marks {
    /// At the borders of bands, or at round numbers.
    #[default]
    Usual,
    /// At so many places, spread evenly from one end to the other.
    Count(usize),
    /// At these values.
    At(Vec<f64>),
}

/// What is written beside the colour of what is no number.
const NO_DATA: &str = "no data";

/// The parts of a bar that has found its room.
#[derive(Debug)]
struct Parts {
    /// Size of its text.
    em: f64,
    title: Option<TextBlock>,
    /// The title is beside an upright bar, from below to above.
    is_turned: bool,
    ticks: Vec<Tick>,
    /// Length and thickness of the colours, without their ends.
    length: f64,
    thickness: f64,
    has_nan: bool,
    /// Width and height of all.
    size: [f64; 2],
}

impl ScalarBar {
    /// Adds it to a picture, where it is called `name`. Returns its box; `None` if there is no room.
    pub fn add(&self, layout: &mut Layout, name: &str) -> Option<Rect> {
        let rect = if self.colors.categories.is_empty() {
            self.add_scale(layout, name)
        } else {
            self.add_list(layout, name)
        }?;
        layout.keep(name, rect);
        Some(rect)
    }

    /// The side at which it takes its room: one that lies across its border, too, and in a corner the one along which it is.
    pub(crate) fn sides(&self) -> [Option<usize>; 2] {
        let [beside, above] = sides_of(self.place);
        if self.is_upright != self.is_across() { [beside, None] } else { [None, above] }
    }

    /// Whether it lies across the border at which it is: upright above or below the model, level beside it.
    fn is_across(&self) -> bool {
        let (at_side, at_end) = (is_border(self.place.x), is_border(self.place.y));
        if self.is_upright { at_end && !at_side } else { at_side && !at_end }
    }

    fn add_scale(&self, layout: &mut Layout, name: &str) -> Option<Rect> {
        let [left, top, right, bottom] = layout.area();
        // Smaller text first, then without the colour of no data, then without a title.
        for (has_nan, has_title) in [(self.shows_nan, true), (false, true), (false, false)] {
            for shrink in [1.0, 0.85, SHRINK] {
                // Shorter where something else is in the way.
                let shares = if self.is_across() { [0.35, 0.3, 0.25, 0.2] } else { [0.7, 0.55, 0.4, 0.95] };
                for share in shares {
                    let room = [(right - left) * 0.66, (bottom - top) * 0.66];
                    let room = if self.is_upright {
                        [room[0], (bottom - top) * share]
                    } else {
                        [(right - left) * share, room[1]]
                    };
                    let parts = self.parts(layout.em * shrink, room, has_nan, has_title);
                    let found = parts.and_then(|parts| Some((self.find(layout, parts.size)?, parts)));
                    if let Some((rect, parts)) = found {
                        self.draw(layout, &parts, rect);
                        let missing =
                            parts.title.as_ref().and_then(|t| t.missing(&format!("the title of {name}")));
                        missing
                            .into_iter()
                            .chain(self.unmarked(&parts, name))
                            .for_each(|what| layout.leave_out(&what));
                        return Some(rect);
                    }
                }
            }
        }
        None
    }

    /// Room for a box of this size at its place; beside another bar that is there.
    fn find(&self, layout: &Layout, size: [f64; 2]) -> Option<Rect> {
        let beside = || if self.is_upright { layout.find_beside(size, self.place) } else { None };
        layout.find(size, self.place).or_else(beside)
    }

    /// Lays the bar out in a room of this width and height, from its upper left corner; `None` if it does not fit.
    fn parts(&self, em: f64, room: [f64; 2], has_nan: bool, has_title: bool) -> Option<Parts> {
        let thickness = (em * 1.15).round().max(2.0);
        let ends = [self.colors.below, self.colors.above].iter().flatten().count() as f64 * thickness;
        let title = if has_title { self.title.trim() } else { "" };
        let whole = |value: f64| value.ceil();
        if self.is_upright {
            let beside = thickness + em * BESIDE;
            // Longer titles are turned.
            let width = (em * 7.0).max(beside + em * 4.0).min(room[0]);
            let lines = TextBlock::fit_with_unit(title, em, width, 2);
            let is_turned = lines.em < em || lines.lines.len() > 1 && title.len() > 24;
            let mut block = (!title.is_empty()).then_some(lines);
            let above = match &block {
                Some(title) if !is_turned => title.size[1] + em * 0.7,
                _ => em * 0.4,
            };
            let below = if has_nan { thickness + em * 1.1 } else { em * 0.4 };
            let length = (room[1] - above - below - ends).floor();
            if length < em * 2.4 {
                return None;
            }
            let places = |distance: f64| (length / (em * distance)).floor() as usize + 1;
            let ticks = self.with_room(self.ticks(places(2.8), places(CLOSE)), length, em);
            let ticks = self.without_merged(ticks, length, em);
            let mut labels = widest(&ticks, em);
            if has_nan {
                labels = labels.max(Line::new(NO_DATA).width * em);
            }
            if is_turned {
                let turned = TextBlock::fit_with_unit(title, em, length + ends, 1);
                block = Some(turned);
            }
            let title_width = match &block {
                Some(_) if is_turned => em * 1.5,
                Some(title) => (title.size[0] - beside - labels).max(0.0),
                None => 0.0,
            };
            let size = [whole(beside + labels + title_width), whole(above + below + ends + length)];
            return (size[0] <= room[0]).then_some(Parts {
                em,
                title: block,
                is_turned,
                ticks,
                length,
                thickness,
                has_nan,
                size,
            });
        }
        let nan = if has_nan { thickness + em * (1.4 + Line::new(NO_DATA).width) } else { 0.0 };
        let mut length = (room[0] - ends - nan - em).floor();
        if length < em * 3.0 {
            return None;
        }
        // As many labels as there is room for.
        let mut most = (length / (em * 3.0)).floor() as usize + 1;
        let mut ticks = loop {
            let mut ticks = self.ticks(most, most);
            if self.has_own_values() || self.marks_ends() {
                ticks = self.with_room(ticks, length, em);
            }
            if self.have_room(&ticks, length, em) {
                break ticks;
            }
            most = most.min(labelled(&ticks).count());
            if most <= 2 {
                return None;
            }
            most -= 1;
        };
        // Labels at the ends reach beyond the colours.
        let labels = widest(&ticks, em);
        let beyond = (labels * 0.5 - ends * 0.5).max(em * 0.2);
        let all = length + ends + nan + 2.0 * beyond;
        if all > room[0] {
            length -= (all - room[0]).ceil();
            if self.has_own_values() || self.marks_ends() {
                ticks = self.with_room(ticks, length, em);
            }
            if length < em * 3.0 || !self.have_room(&ticks, length, em) {
                return None;
            }
        }
        let ticks = self.without_merged(ticks, length, em);
        let title = (!title.is_empty()).then(|| TextBlock::fit_with_unit(title, em, room[0], 2));
        let above = title.as_ref().map_or(0.0, |title| title.size[1] + em * 0.3);
        let width =
            (length + ends + nan + 2.0 * beyond).max(title.as_ref().map_or(0.0, |title| title.size[0]));
        let size = [whole(width), whole(above + thickness + em * (0.5 + ASCENT + DESCENT))];
        (size[1] <= room[1]).then_some(Parts {
            em,
            title,
            is_turned: false,
            ticks,
            length,
            thickness,
            has_nan,
            size,
        })
    }

    fn draw(&self, layout: &mut Layout, parts: &Parts, rect: Rect) {
        let (em, thickness, color) = (parts.em, parts.thickness, layout.color);
        let below = if self.colors.below.is_some() { thickness } else { 0.0 };
        let above = if self.colors.above.is_some() { thickness } else { 0.0 };
        let [left, top, right, bottom] = rect;
        // From the lower to the upper end of the range.
        let body: Rect = if self.is_upright {
            let lower = bottom - if parts.has_nan { thickness + em * 1.1 } else { em * 0.4 } - below;
            [left, lower - parts.length, left + thickness, lower]
        } else {
            let all = parts.length + below + above;
            let nan = if parts.has_nan { thickness + em * (1.4 + Line::new(NO_DATA).width) } else { 0.0 };
            let x = left + ((right - left - all - nan) * 0.5).max(0.0) + nan + below;
            let y = parts.title.as_ref().map_or(top, |title| top + title.size[1] + em * 0.3);
            [x, y, x + parts.length, y + thickness]
        };
        let body = body.map(f64::round);
        self.draw_colors(layout, body);
        self.draw_ends(layout, body);
        for tick in &parts.ticks {
            self.draw_tick(layout, parts, body, tick);
        }
        if parts.has_nan {
            let swatch = if self.is_upright {
                let y = (bottom - thickness).round();
                [body[0], y, body[0] + thickness, y + thickness]
            } else {
                let x = left
                    + (body[0] - below - left - thickness - em * (1.4 + Line::new(NO_DATA).width)).max(0.0);
                [x.round(), body[1], x.round() + thickness, body[3]]
            };
            layout.overlay.rectangle(swatch, Paint::Solid(linear(self.colors.nan)));
            layout.frame(swatch, color);
            let at = [swatch[2] + em * 0.4, (swatch[1] + swatch[3] + em * CAP_HEIGHT) * 0.5];
            layout.overlay.text(&Line::new(NO_DATA), at.map(f64::round), em, Direction::Right, color);
        }
        match &parts.title {
            Some(title) if parts.is_turned => {
                let line = &title.lines[0];
                let middle = (body[1] - above + body[3] + below) * 0.5;
                let x = right - title.em * DESCENT - em * 0.1;
                let at = [x, middle + line.width * title.em * 0.5].map(f64::round);
                layout.overlay.text(line, at, title.em, Direction::Up, color);
            }
            Some(title) => {
                let align = if self.is_upright {
                    if self.place.x > 0.5 && title.size[0] >= right - left - 1.0 { 1.0 } else { 0.0 }
                } else {
                    0.5
                };
                let x = left + (right - left - title.size[0]) * align;
                layout.draw_text(title, [x, top], if self.is_upright { 0.0 } else { 0.5 }, color);
            }
            None => {}
        }
    }

    fn draw_colors(&self, layout: &mut Layout, body: Rect) {
        let colors = self.colors.clone();
        let color = Arc::new(move |t: f64| linear(colors.color_at(t)));
        let ends = if self.is_upright { [body[3], body[1]] } else { [body[0], body[2]] };
        layout.overlay.rectangle(body, Paint::Along { is_upright: self.is_upright, ends, color });
        layout.frame(body, layout.color);
    }

    /// Triangles in the colours of what is below and above the range.
    fn draw_ends(&self, layout: &mut Layout, [left, top, right, bottom]: Rect) {
        let thickness = if self.is_upright { right - left } else { bottom - top };
        let (low, high) = if self.is_upright {
            let middle = (left + right) * 0.5;
            (
                [[left, bottom], [right, bottom], [middle, bottom + thickness]],
                [[left, top], [right, top], [middle, top - thickness]],
            )
        } else {
            let middle = (top + bottom) * 0.5;
            (
                [[left, top], [left, bottom], [left - thickness, middle]],
                [[right, top], [right, bottom], [right + thickness, middle]],
            )
        };
        for (corners, color) in [(low, self.colors.below), (high, self.colors.above)] {
            let Some(color) = color else { continue };
            // The border is a larger triangle behind a smaller one, so that it does not leave the box.
            let [a, b, tip] = corners;
            let inner = |p: [f64; 2]| {
                let middle = [0, 1].map(|k| (a[k] + b[k] + tip[k]) / 3.0);
                let factor = 1.0 - 2.7 * layout.line / thickness;
                [0, 1].map(|k| middle[k] + (p[k] - middle[k]) * factor)
            };
            layout.overlay.fill(Outline::polygon(&corners), Paint::Solid(layout.color));
            layout.overlay.fill(Outline::polygon(&corners.map(inner)), Paint::Solid(linear(color)));
        }
    }

    fn draw_tick(&self, layout: &mut Layout, parts: &Parts, [left, top, right, bottom]: Rect, tick: &Tick) {
        let (em, color, w) = (parts.em, layout.color, layout.line);
        let t = self.colors.position(tick.value).clamp(0.0, 1.0);
        let length = em * if tick.label.is_empty() { 0.2 } else { 0.4 };
        let line = Line::new(&tick.label);
        if self.is_upright {
            // Inside of the border at both ends.
            let y = (bottom - (bottom - top - w) * t - w).round();
            layout.overlay.rectangle([right, y, (right + length).round(), y + w], Paint::Solid(color));
            let at = [right + em * TICK, y + w * 0.5 + em * CAP_HEIGHT * 0.5];
            layout.overlay.text(&line, at.map(f64::round), em, Direction::Right, color);
        } else {
            let x = (left + (right - left - w) * t).round();
            layout.overlay.rectangle([x, bottom, x + w, (bottom + length).round()], Paint::Solid(color));
            let at = [x + w * 0.5 - line.width * em * 0.5, bottom + em * (0.5 + ASCENT)];
            layout.overlay.text(&line, at.map(f64::round), em, Direction::Right, color);
        }
    }
}

/// The distance of labels beside an upright bar where they may stand close, in ems.
const CLOSE: f64 = 1.4;
/// From the colours of an upright bar to its labels, in ems.
const TICK: f64 = 0.55;
/// Beside the colours and the labels, with a rest for rounding.
const BESIDE: f64 = TICK + 0.1;

/// Whether a share of a picture's room is at one of its borders.
fn is_border(share: f64) -> bool {
    share == 0.0 || share == 1.0
}

fn labelled(ticks: &[Tick]) -> impl Iterator<Item = &Tick> {
    ticks.iter().filter(|tick| !tick.label.is_empty())
}

fn widest(ticks: &[Tick], em: f64) -> f64 {
    labelled(ticks).fold(0.0f64, |width, tick| width.max(Line::new(&tick.label).width * em)).ceil()
}

/// Linear light of an 8-bit colour.
pub(crate) fn linear([r, g, b, alpha]: [u8; 4]) -> [f32; 4] {
    let [r, g, b] = [r, g, b].map(|level| srgb_to_linear(f64::from(level) / 255.0) as f32);
    [r, g, b, f32::from(alpha) / 255.0]
}
