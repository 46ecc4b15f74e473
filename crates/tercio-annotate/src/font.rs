//! The font inside the program, and lines of text set in it.
//!
//! Inter (Medium, SIL Open Font License, see `font/LICENSE.txt`), reduced to Latin, Greek, punctuation, mathematics, arrows,
//! superscripts and subscripts, with figures of one width. Pairs are kerned, and combining marks are placed where the font places
//! them on their base (x̄); the font has no script that needs more of a shaper than that.

use std::sync::LazyLock;

use ttf_parser::gpos::{PairAdjustment, PositioningSubtable};
use ttf_parser::opentype_layout::Lookup;
use ttf_parser::{Face, GlyphId, OutlineBuilder, Tag};

use crate::outline::Outline;

static FONT: LazyLock<Font> = LazyLock::new(|| {
    let face =
        Face::parse(include_bytes!("../font/Inter-Medium.ttf"), 0).expect("the font inside the program");
    Font { kerning: lookups(&face, b"kern"), marks: lookups(&face, b"mark"), face }
});

struct Font {
    face: Face<'static>,
    kerning: Vec<Lookup<'static>>,
    marks: Vec<Lookup<'static>>,
}

/// The lookups of a feature, of all scripts together.
fn lookups(face: &Face<'static>, tag: &[u8; 4]) -> Vec<Lookup<'static>> {
    let Some(table) = face.tables().gpos else { return Vec::new() };
    let features = table.features.into_iter().filter(|feature| feature.tag == Tag::from_bytes(tag));
    let mut numbers: Vec<u16> = features.flat_map(|feature| feature.lookup_indices).collect();
    numbers.sort_unstable();
    numbers.dedup();
    numbers.into_iter().filter_map(|number| table.lookups.get(number)).collect()
}

/// From the baseline to the top of capitals and figures, in ems.
pub const CAP_HEIGHT: f64 = 1490.0 / 2048.0;
/// From the baseline to the top of what is highest in usual text, in ems.
pub const ASCENT: f64 = 0.78;
/// From the baseline to the bottom of what is lowest in usual text, in ems.
pub const DESCENT: f64 = 0.22;
/// From baseline to baseline, in ems.
pub const LINE: f64 = 1.25;

/// A line of text: glyphs with their places, in ems from the beginning of the baseline, y upwards.
#[derive(Clone, Debug, Default)]
pub struct Line {
    glyphs: Vec<(GlyphId, [f64; 2])>,
    /// Its width in ems.
    pub width: f64,
}

impl Line {
    /// Sets a text. Characters that the font does not have become boxes; control characters are left out.
    pub fn new(text: &str) -> Self {
        FONT.line(text)
    }

    /// Whether nothing is in it.
    pub fn is_empty(&self) -> bool {
        self.glyphs.is_empty()
    }

    /// The outlines of all glyphs, with so many pixels an em; the baseline begins at `at` in the picture.
    pub fn outline(&self, at: [f64; 2], em: f64, direction: Direction) -> Outline {
        let mut outline = Outline::default();
        for &(glyph, place) in &self.glyphs {
            let mut pen = Pen { outline: &mut outline, place, at, em, direction };
            FONT.face.outline_glyph(glyph, &mut pen);
        }
        outline
    }
}

/// Where a line of text runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Direction {
    /// To the right.
    #[default]
    Right,
    /// Upwards.
    Up,
}

/// Whether the font has all characters of a text, or the first that it does not have.
///
/// # Errors
/// That character.
pub fn covers(text: &str) -> Result<(), char> {
    match text.chars().find(|c| !c.is_control() && FONT.face.glyph_index(*c).is_none()) {
        Some(missing) => Err(missing),
        None => Ok(()),
    }
}

impl Font {
    fn line(&self, text: &str) -> Line {
        let units = f64::from(self.face.units_per_em());
        let mut glyphs: Vec<(GlyphId, [f64; 2])> = Vec::new();
        let mut x = 0i32;
        // The last glyph that is no mark, and where it is.
        let mut base: Option<(GlyphId, i32)> = None;
        for character in text.chars().filter(|c| !c.is_control()) {
            let glyph = self.face.glyph_index(character).unwrap_or(GlyphId(0));
            if let Some((base_glyph, base_x)) = base
                && let Some([mark_x, mark_y]) = self.mark_on(base_glyph, glyph)
            {
                glyphs.push((glyph, [f64::from(base_x + mark_x) / units, f64::from(mark_y) / units]));
                continue;
            }
            if let Some((before, _)) = base {
                x += self.kerning(before, glyph);
            }
            base = Some((glyph, x));
            glyphs.push((glyph, [f64::from(x) / units, 0.0]));
            x += i32::from(self.face.glyph_hor_advance(glyph).unwrap_or(0));
        }
        Line { glyphs, width: f64::from(x) / units }
    }

    /// By how much the second of two glyphs is moved.
    fn kerning(&self, first: GlyphId, second: GlyphId) -> i32 {
        self.kerning.iter().map(|lookup| i32::from(of_pair(lookup, first, second).unwrap_or(0))).sum()
    }

    /// Where a mark is placed relative to its base; `None` if it is no mark.
    fn mark_on(&self, base: GlyphId, mark: GlyphId) -> Option<[i32; 2]> {
        self.marks.iter().find_map(|lookup| {
            lookup.subtables.into_iter::<PositioningSubtable>().find_map(|subtable| {
                let PositioningSubtable::MarkToBase(table) = subtable else { return None };
                let (class, of_mark) = table.marks.get(table.mark_coverage.get(mark)?)?;
                let of_base = table.anchors.get(table.base_coverage.get(base)?, class)?;
                let [x, y] = [of_base.x - of_mark.x, of_base.y - of_mark.y];
                Some([i32::from(x), i32::from(y)])
            })
        })
    }
}

fn of_pair(lookup: &Lookup, first: GlyphId, second: GlyphId) -> Option<i16> {
    lookup.subtables.into_iter::<PositioningSubtable>().find_map(|subtable| match subtable {
        PositioningSubtable::Pair(PairAdjustment::Format1 { coverage, sets }) => {
            sets.get(coverage.get(first)?)?.get(second).map(|(value, _)| value.x_advance)
        }
        PositioningSubtable::Pair(PairAdjustment::Format2 { coverage, classes, matrix }) => {
            coverage.get(first)?;
            let class = (classes.0.get(first), classes.1.get(second));
            matrix.get(class).map(|(value, _)| value.x_advance)
        }
        _ => None,
    })
}

/// Adds a glyph's outline to that of a line.
struct Pen<'a> {
    outline: &'a mut Outline,
    place: [f64; 2],
    at: [f64; 2],
    em: f64,
    direction: Direction,
}

impl Pen<'_> {
    fn place(&self, x: f32, y: f32) -> [f64; 2] {
        let units = f64::from(FONT.face.units_per_em());
        let right = (f64::from(x) / units + self.place[0]) * self.em;
        let up = (f64::from(y) / units + self.place[1]) * self.em;
        match self.direction {
            Direction::Right => [self.at[0] + right, self.at[1] - up],
            Direction::Up => [self.at[0] - up, self.at[1] - right],
        }
    }
}

impl OutlineBuilder for Pen<'_> {
    fn move_to(&mut self, x: f32, y: f32) {
        let to = self.place(x, y);
        self.outline.begin(to);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        let to = self.place(x, y);
        self.outline.line(to);
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        let (control, to) = (self.place(x1, y1), self.place(x, y));
        self.outline.curve(control, to);
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        // The font has no cubic curves.
        let controls = [self.place(x1, y1), self.place(x2, y2)];
        let to = self.place(x, y);
        controls.into_iter().chain([to]).for_each(|point| self.outline.line(point));
    }

    fn close(&mut self) {}
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_have_one_width_and_pairs_are_kerned() {
        let width = |text: &str| Line::new(text).width;
        for figure in '1'..='9' {
            assert_eq!(width(&figure.to_string()), width("0"), "{figure}");
        }
        assert!(width("AV") < width("A") + width("V") - 0.02, "AV is a pair");
        assert_eq!(width("a\u{7}b"), width("ab"), "control characters are left out");
        assert_eq!(width(""), 0.0);
    }

    #[test]
    fn marks_stand_on_their_base() {
        let (plain, marked) = (Line::new("x"), Line::new("x\u{304}"));
        assert_eq!(plain.width, marked.width);
        assert_eq!(marked.glyphs.len(), 2);
        let top = |line: &Line| line.outline([0.0; 2], 1.0, Direction::Right).bounds().expect("ink")[1];
        assert!(top(&marked) < top(&plain) - 0.05, "the macron is above");
        let of = |line: &Line| line.outline([0.0; 2], 1.0, Direction::Right).bounds().expect("ink");
        let ([left, _, right, _], [l, _, r, _]) = (of(&plain), of(&marked));
        assert!(l >= left - 0.05 && r <= right + 0.05, "and not beside");
    }

    #[test]
    fn the_font_has_what_science_writes() {
        let text = "ÄéßŁΑΩαβµΔ∂∑∫√∞≤≥≠≈±×·÷°′″⁰¹²³⁴⁵⁶⁷⁸⁹⁺⁻⁼⁽⁾ⁿ₀₁₂₃₄₅₆₇₈₉₊₋−–—…“”‘’€Ω℃ℓ←↑→↓½";
        assert_eq!(covers(text), Ok(()));
        assert_eq!(covers("a\n漢"), Err('漢'));
    }
}
