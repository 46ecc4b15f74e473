//! Where things are in a picture: boxes that do not overlap and do not leave it.

use crate::font::{ASCENT, DESCENT, Direction, LINE, Line};
use crate::overlay::{Overlay, Paint};

/// Left, upper, right and lower border, in pixels from the upper left corner of the picture.
pub type Rect = [f64; 4];

/// A place for something in the picture, as shares of the room that is left beside it: 0 at the left or upper margin, 1 at the
/// right or lower one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// From left to right.
    pub x: f64,
    /// From top to bottom.
    pub y: f64,
}

/// The names of places.
const PLACES: [(&str, [f64; 2]); 9] = [
    ("top-left", [0.0, 0.0]),
    ("top", [0.5, 0.0]),
    ("top-right", [1.0, 0.0]),
    ("left", [0.0, 0.5]),
    ("center", [0.5, 0.5]),
    ("right", [1.0, 0.5]),
    ("bottom-left", [0.0, 1.0]),
    ("bottom", [0.5, 1.0]),
    ("bottom-right", [1.0, 1.0]),
];

impl Place {
    /// The place of a name, or of two shares with a comma between them.
    pub fn named(text: &str) -> Option<Self> {
        let place = |[x, y]: [f64; 2]| Self { x, y };
        if let Some((_, at)) = PLACES.iter().find(|(name, _)| *name == text) {
            return Some(place(*at));
        }
        let (x, y) = text.split_once(',')?;
        let share = |text: &str| text.trim().parse().ok().filter(|v| (0.0..=1.0).contains(v));
        Some(place([share(x)?, share(y)?]))
    }

    /// The names.
    pub fn names() -> impl Iterator<Item = &'static str> {
        PLACES.iter().map(|(name, _)| *name)
    }
}

/// Something that was drawn, and its box.
#[derive(Clone, Debug, PartialEq)]
pub struct Placed {
    /// What it is.
    pub what: String,
    /// Where it is.
    pub rect: Rect,
}

/// A picture that is being annotated.
pub struct Layout {
    /// Width and height in pixels.
    pub size: [f64; 2],
    /// Size of usual text, pixels an em.
    pub em: f64,
    /// Width of lines, whole pixels.
    pub line: f64,
    /// Distance from the border, and between things.
    pub margin: f64,
    /// The colour of text and lines: linear, not multiplied by its alpha.
    pub color: [f32; 4],
    /// What is drawn onto the picture.
    pub overlay: Overlay,
    /// The boxes of what is drawn.
    pub placed: Vec<Placed>,
    /// What there was no room for.
    pub left_out: Vec<String>,
}

/// Text is this share of the shorter side of a picture.
const TEXT: f64 = 1.0 / 46.0;
/// Smaller text cannot be read: pictures of less than about 500 pixels have text of this size.
const SMALLEST: f64 = 11.0;
/// But never more than this share of the shorter side.
const LARGEST: f64 = 1.0 / 7.0;
/// Letters of fewer pixels an em are hard to read.
const LEGIBLE: f64 = 7.0;
/// Text is made smaller by at most this factor where there is no room.
pub const SHRINK: f64 = 0.7;

impl Layout {
    /// Begins with an empty picture. `scale` makes text larger or smaller.
    pub fn new(width: u32, height: u32, scale: f64, color: [f32; 4]) -> Self {
        let size = [width, height].map(f64::from);
        let short = size[0].min(size[1]);
        let em = scale * (short * TEXT).max(SMALLEST.min(short * LARGEST));
        Self {
            size,
            em,
            line: (em / 13.0).round().max(1.0),
            margin: (em * 0.7).round().max(1.0),
            color,
            overlay: Overlay::default(),
            placed: Vec::new(),
            left_out: Vec::new(),
        }
    }

    /// The picture without its margin.
    pub fn area(&self) -> Rect {
        let [width, height] = self.size;
        [self.margin, self.margin, width - self.margin, height - self.margin]
    }

    /// Finds room for a box: at its place, or above or below what is there already. `None` if there is none.
    pub fn find(&self, [width, height]: [f64; 2], place: Place) -> Option<Rect> {
        let [left, top, right, bottom] = self.area();
        let [x, y] = [left + (right - left - width) * place.x, top + (bottom - top - height) * place.y]
            .map(f64::round);
        if x < left - 0.5 || x + width > right + 0.5 {
            return None;
        }
        // Towards the middle of the picture first.
        let down = place.y <= 0.5;
        [down, !down].into_iter().find_map(|down| {
            let mut y = y;
            loop {
                let rect = [x, y, x + width, y + height];
                if rect[1] < top - 0.5 || rect[3] > bottom + 0.5 {
                    return None;
                }
                let Some(other) =
                    self.placed.iter().find(|other| overlap(&other.rect, &rect, self.margin * 0.5))
                else {
                    return Some(rect);
                };
                let gap = self.margin * 0.5 + 1.0;
                y = if down { other.rect[3] + gap } else { other.rect[1] - gap - height };
            }
        })
    }

    /// Finds room for a box beside what is at its place already, in the nearer half of the picture. `None` if there is none.
    pub fn find_beside(&self, [width, height]: [f64; 2], place: Place) -> Option<Rect> {
        let [left, top, right, bottom] = self.area();
        let [mut x, y] = [left + (right - left - width) * place.x, top + (bottom - top - height) * place.y]
            .map(f64::round);
        let middle = (left + right) * 0.5;
        let to_the_left = place.x > 0.5;
        let is_in_half =
            |x: f64| if to_the_left { x >= middle } else { place.x == 0.5 || x + width <= middle };
        if y < top - 0.5 || y + height > bottom + 0.5 {
            return None;
        }
        loop {
            let rect = [x, y, x + width, y + height];
            if x < left - 0.5 || x + width > right + 0.5 || !is_in_half(x) {
                return None;
            }
            // Titles side by side would read as one.
            let gap = self.em.ceil();
            let Some(other) = self.placed.iter().find(|other| overlap(&other.rect, &rect, self.margin * 0.5))
            else {
                return Some(rect);
            };
            x = if to_the_left { other.rect[0] - gap - width } else { other.rect[2] + gap };
        }
    }

    /// Keeps a box for something.
    pub fn keep(&mut self, what: &str, rect: Rect) {
        self.placed.push(Placed { what: what.to_owned(), rect });
    }

    /// Notes that there was no room for something.
    pub fn leave_out(&mut self, what: &str) {
        self.left_out.push(what.to_owned());
    }

    /// Draws lines of text, each in the middle, at the left or at the right of a box of their size (`align` from 0 to 1).
    pub fn draw_text(&mut self, text: &TextBlock, [left, top]: [f64; 2], align: f64, color: [f32; 4]) {
        for (number, line) in text.lines.iter().enumerate() {
            let x = left + (text.size[0] - line.width * text.em) * align;
            let y = top + text.em * (ASCENT + LINE * number as f64);
            self.overlay.text(line, [x.round(), y.round()], text.em, Direction::Right, color);
        }
    }

    /// A rectangle's border, drawn on its inner side.
    pub fn frame(&mut self, [left, top, right, bottom]: Rect, color: [f32; 4]) {
        let w = self.line;
        for rect in [
            [left, top, right, top + w],
            [left, bottom - w, right, bottom],
            [left, top + w, left + w, bottom - w],
            [right - w, top + w, right, bottom - w],
        ] {
            self.overlay.rectangle(rect, Paint::Solid(color));
        }
    }
}

/// Whether two boxes overlap, or are closer than `gap`.
pub fn overlap(a: &Rect, b: &Rect, gap: f64) -> bool {
    a[0] < b[2] + gap && b[0] < a[2] + gap && a[1] < b[3] + gap && b[1] < a[3] + gap
}

/// Lines of text with one size.
#[derive(Clone, Debug)]
pub struct TextBlock {
    /// The lines.
    pub lines: Vec<Line>,
    /// Pixels an em.
    pub em: f64,
    /// Width and height of its box.
    pub size: [f64; 2],
    /// Its end is left out, or what is before its unit.
    pub is_cut: bool,
    /// It was cut off before its unit.
    pub has_unit: bool,
    /// It had to be made so small that it is hard to read.
    pub is_tiny: bool,
}

impl TextBlock {
    /// One line of text as it is.
    pub fn line(text: &str, em: f64) -> Self {
        Self::of(vec![Line::new(text)], em)
    }

    fn of(lines: Vec<Line>, em: f64) -> Self {
        let width = lines.iter().fold(0.0f64, |width, line| width.max(line.width * em)).ceil();
        let height = em * (ASCENT + DESCENT + LINE * (lines.len().max(1) - 1) as f64);
        Self { lines, em, size: [width, height.ceil()], is_cut: false, has_unit: false, is_tiny: false }
    }

    /// A text in at most this width and this number of lines: broken between words, then smaller, then cut off with an ellipsis.
    pub fn fit(text: &str, em: f64, width: f64, most_lines: usize) -> Self {
        let broken =
            |em: f64| -> Vec<String> { text.lines().flat_map(|line| break_line(line, width / em)).collect() };
        let fits = |lines: &[String], em: f64| {
            lines.len() <= most_lines && lines.iter().all(|line| Line::new(line).width * em <= width)
        };
        let mut size = em;
        let mut lines = broken(em);
        while !fits(&lines, size) && size > em * SHRINK {
            size = (size * 0.95).max(em * SHRINK);
            lines = broken(size);
        }
        let is_cut = lines.len() > most_lines;
        lines.truncate(most_lines);
        if let (true, Some(last)) = (is_cut, lines.last_mut()) {
            last.push('…');
        }
        let whole = |line: &str| Line::new(line).width * size <= width;
        let is_cut = is_cut || !lines.iter().all(|line| whole(line));
        let block = Self::of(lines.iter().map(|line| cut(line, width / size)).collect(), size);
        Self { is_cut, is_tiny: size < em && size < LEGIBLE, ..block }
    }

    /// As [`TextBlock::fit`], but a unit in parentheses at the end stays: the words before it are cut off.
    pub fn fit_with_unit(text: &str, em: f64, width: f64, most_lines: usize) -> Self {
        let whole = Self::fit(text, em, width, most_lines);
        let unit = text.rfind(" (").filter(|_| whole.is_cut && text.ends_with(')'));
        let Some((name, unit)) = unit.map(|at| text.split_at(at)) else { return whole };
        let characters: Vec<char> = name.chars().collect();
        let with = |kept: usize| {
            let name: String = characters[..kept].iter().collect();
            Self::fit(&format!("{}…{unit}", name.trim_end()), em, width, most_lines)
        };
        // The longest beginning that fits: what is longer does not, either.
        let (mut fits, mut too_many) = (0, characters.len());
        while too_many - fits > 1 {
            let middle = (fits + too_many) / 2;
            if with(middle).is_cut { too_many = middle } else { fits = middle }
        }
        if fits == 0 { whole } else { Self { is_cut: true, has_unit: true, ..with(fits) } }
    }

    /// What is missing of it, if it is called `what`.
    pub fn missing(&self, what: &str) -> Option<String> {
        match (self.is_cut, self.is_tiny) {
            (true, _) if self.has_unit => Some(format!("a part of {what}")),
            (true, _) => Some(format!("the end of {what}")),
            (false, true) => Some(format!("legible letters of {what}")),
            (false, false) => None,
        }
    }
}

/// Breaks a line between words.
fn break_line(text: &str, width: f64) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split(' ') {
        let last = lines.last_mut().expect("a line");
        let longer = if last.is_empty() { word.to_owned() } else { format!("{last} {word}") };
        if last.is_empty() || Line::new(&longer).width <= width {
            *last = longer;
        } else {
            lines.push(word.to_owned());
        }
    }
    lines
}

/// As much of a line as fits, with an ellipsis if that is not all.
fn cut(text: &str, width: f64) -> Line {
    let whole = Line::new(text);
    if whole.width <= width {
        return whole;
    }
    let characters: Vec<char> = text.trim_end_matches('…').chars().collect();
    let cut = (0..characters.len()).rev().map(|count| {
        let kept: String = characters[..count].iter().collect();
        Line::new(&format!("{}…", kept.trim_end()))
    });
    cut.into_iter().find(|line| line.width <= width).unwrap_or_default()
}
