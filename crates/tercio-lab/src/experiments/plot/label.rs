//! Text of a plot: lines of limited width, and raised exponents.

use glam::{DVec2, dvec2};
use tercio::vector::{Anchor, Shape, Text, text_width};

/// Height of the font of ticks, axes and legend, and of a line of it.
pub(super) const LABEL: f64 = 12.0;
pub(super) const LINE: f64 = 15.0;
/// Dark grey.
pub(super) const INK: [u8; 4] = [25, 25, 25, 255];
/// Height of raised digits over that of others.
const RAISED: f64 = 0.72;

/// Text as lines of at most `width` pixels, broken at blanks. A word that is wider has a line of its own.
pub(super) fn wrapped(text: &str, size: f64, width: f64) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if text_width(&format!("{line} {word}"), size) <= width => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.into()),
        }
    }
    lines
}

/// The parts of a text, and whether each is raised: `10^6` and `10⁶` have an exponent.
fn parts(text: &str) -> Vec<(bool, String)> {
    const RAISED_DIGITS: &str = "⁰¹²³⁴⁵⁶⁷⁸⁹⁻";
    let mut parts: Vec<(bool, String)> = Vec::new();
    let mut after_caret = false;
    for character in text.chars() {
        let raised =
            RAISED_DIGITS.chars().zip(('0'..='9').chain(['-'])).find(|d| d.0 == character).map(|d| d.1);
        if character == '^' {
            after_caret = true;
            continue;
        }
        after_caret &= character.is_ascii_digit();
        let is_raised = raised.is_some() || after_caret;
        let character = raised.unwrap_or(character);
        match parts.last_mut() {
            Some((up, part)) if *up == is_raised => part.push(character),
            _ => parts.push((is_raised, character.into())),
        }
    }
    parts
}

fn width_of(parts: &[(bool, String)], size: f64) -> f64 {
    parts.iter().map(|(up, part)| text_width(part, if *up { RAISED * size } else { size })).sum()
}

/// The width of a text with its exponents.
pub(super) fn width(text: &str, size: f64) -> f64 {
    width_of(&parts(text), size)
}

/// A line of text.
pub(super) fn push(shapes: &mut Vec<Shape>, text: &str, size: f64, at: DVec2, anchor: Anchor, upwards: bool) {
    let parts = parts(text);
    if let [(false, whole)] = &parts[..] {
        let text = Text { color: INK, size, at, anchor, upwards, text: whole.clone() };
        return shapes.push(Shape::Text(text));
    }
    let (along, up) =
        if upwards { (dvec2(0.0, -1.0), dvec2(-1.0, 0.0)) } else { (dvec2(1.0, 0.0), dvec2(0.0, -1.0)) };
    let mut start = at - along * anchor.share() * width_of(&parts, size);
    for (is_raised, text) in parts {
        // A blank at the start of an element of text is not drawn.
        let blank = text.len() - text.trim_start().len();
        start += along * text_width(&text[..blank], size);
        let text = text[blank..].to_owned();
        let (size, at) = if is_raised { (RAISED * size, start + 0.4 * size * up) } else { (size, start) };
        start += along * text_width(&text, size);
        shapes.push(Shape::Text(Text { color: INK, size, at, anchor: Anchor::Start, upwards, text }));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_broken_at_blanks_and_exponents_are_raised() {
        let lines = wrapped("the greatest of eight neighbours", 10.0, 80.0);
        assert!(lines.len() > 1 && lines.iter().all(|l| text_width(l, 10.0) <= 80.0), "{lines:?}");
        assert_eq!(lines.join(" "), "the greatest of eight neighbours");
        let (plain, raised) = (|t: &str| (false, t.to_owned()), |t: &str| (true, t.to_owned()));
        assert_eq!(
            parts("10¹² and 10^6 cycles"),
            [plain("10"), raised("12"), plain(" and 10"), raised("6"), plain(" cycles")]
        );
    }
}
