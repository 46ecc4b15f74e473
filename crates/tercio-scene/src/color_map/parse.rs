//! Colour maps from files.

use super::{Annotation, ColorMap, Special, rounded};

/// What is wrong with a colour map.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ColorMapError {
    /// Nothing in it.
    #[error("there is no colour in it")]
    Empty,
    /// Too much in it.
    #[error("there are more than {MOST} colours in it")]
    TooMany,
    /// A component out of range.
    #[error("colours have components of 0 to 1, not {0:?}")]
    Component([f64; 3]),
    /// Points are not in order.
    #[error("the positions of its colours do not ascend, or are not finite")]
    Order,
    /// A line that is no colour.
    #[error(
        "line {line}: expected a colour such as `#1f77b4`, `31 119 180` or `0.12 0.47 0.71`, or a position before one, found `{found}`"
    )]
    Line {
        /// Counted from 1.
        line: usize,
        /// What is there, shortened.
        found: String,
    },
    /// A text in JSON that is not a colour map of ParaView.
    #[error("expected a colour map in ParaView's JSON, an object with `RGBPoints` or `IndexedColors`: {0}")]
    Json(String),
    /// Not text.
    #[error("it is not text")]
    NotText,
}

/// Colours in a file.
const MOST: usize = 1 << 16;

/// One line of a list.
struct Line {
    position: Option<f64>,
    color: [f64; 3],
    /// Components may be 8-bit: whole numbers.
    is_hex: bool,
}

impl ColorMap {
    /// Reads a colour map: a list of colours, one a line, `#rrggbb`, or three numbers of 0 to 1, or of 0 to 255 if any of the list
    /// is above 1, with spaces, tabs, commas or semicolons between; four numbers are a position and a colour. Lines that begin with
    /// `#` and are no colour, `//` or a letter in the first line (a header) are skipped. Or ParaView's JSON (`RGBPoints`,
    /// `NanColor`, and the colours beyond the range that it uses; or `IndexedColors` and `Annotations`, which make a categorical map).
    ///
    /// # Errors
    /// If the text is anything else.
    pub fn parse(name: &str, text: &[u8]) -> Result<Self, ColorMapError> {
        let text = std::str::from_utf8(text).map_err(|_| ColorMapError::NotText)?;
        let text = text.strip_prefix('\u{feff}').unwrap_or(text).trim();
        if text.starts_with(['[', '{']) {
            return json(name, text);
        }
        let mut lines: Vec<Line> = Vec::new();
        for (i, line) in text.lines().enumerate() {
            let line = line.trim();
            match color(line) {
                Some(_) if lines.len() == MOST => return Err(ColorMapError::TooMany),
                Some(color) => lines.push(color),
                None if line.is_empty() || line.starts_with(['#', '%', '!']) || line.starts_with("//") => {}
                None if lines.is_empty() && line.starts_with(|c: char| c.is_alphabetic() || c == '"') => {}
                None => {
                    let found = line.chars().take(40).collect();
                    return Err(ColorMapError::Line { line: i + 1, found });
                }
            }
        }
        let is_byte = lines.iter().any(|line| !line.is_hex && line.color.iter().any(|&c| c > 1.0));
        for line in lines.iter_mut().filter(|line| is_byte && !line.is_hex) {
            line.color = line.color.map(|c| c / 255.0);
        }
        let has_positions = !lines.is_empty() && lines.iter().all(|line| line.position.is_some());
        let place = |(i, line): (usize, &Line)| match line.position {
            Some(position) if has_positions => (position, line.color),
            _ => (i as f64, line.color),
        };
        let points: Vec<_> = lines.iter().enumerate().map(place).collect();
        Self::from_points(name, &points)
    }
}

/// The colour in a line of text.
fn color(line: &str) -> Option<Line> {
    let digits = line.trim_matches(['"', '\'', ',']).strip_prefix('#');
    if let Some(digits) = digits.filter(|d| d.len() == 6 && d.bytes().all(|b| b.is_ascii_hexdigit())) {
        let part = |i: usize| u8::from_str_radix(&digits[i..i + 2], 16).ok();
        let color = [part(0)?, part(2)?, part(4)?].map(|c| f64::from(c) / 255.0);
        return Some(Line { position: None, color, is_hex: true });
    }
    let words = line.split([' ', '\t', ',', ';']).filter(|word| !word.is_empty());
    let numbers: Option<Vec<f64>> =
        words.take(5).map(|word| word.parse().ok().filter(|v: &f64| v.is_finite())).collect();
    match numbers?[..] {
        [r, g, b] => Some(Line { position: None, color: [r, g, b], is_hex: false }),
        [at, r, g, b] => Some(Line { position: Some(at), color: [r, g, b], is_hex: false }),
        _ => None,
    }
}

/// The first map of a file of ParaView: `[{"RGBPoints": [x, r, g, b, ...]}]`, or `[{"IndexedColors": [r, g, b, ...]}]` of categories.
fn json(name: &str, text: &str) -> Result<ColorMap, ColorMapError> {
    let value: serde_json::Value =
        serde_json::from_str(text).map_err(|error| ColorMapError::Json(error.to_string()))?;
    let map = value.get(0).unwrap_or(&value);
    let wrong = |what: &str| ColorMapError::Json(what.to_owned());
    let list = |key: &str| map.get(key).and_then(|all| all.as_array()).filter(|all| !all.is_empty());
    let numbers = |all: &[serde_json::Value]| -> Result<Vec<f64>, ColorMapError> {
        let all: Option<Vec<f64>> = all.iter().map(serde_json::Value::as_f64).collect();
        all.ok_or_else(|| wrong("they are not all numbers"))
    };
    // Of a map that has both, it says which counts.
    let colors =
        list("IndexedColors").filter(|_| is_used(map, "IndexedLookup") || list("RGBPoints").is_none());
    let (points, width): (Vec<_>, _) = match (colors, list("RGBPoints")) {
        (Some(colors), _) => {
            let colors = numbers(colors)?;
            let (colors, rest) = colors.as_chunks::<3>();
            let points = colors.iter().enumerate().map(|(i, &color)| (i as f64, color));
            (points.collect(), rest.is_empty().then_some(()).ok_or("three"))
        }
        (None, Some(points)) => {
            let points = numbers(points)?;
            let (points, rest) = points.as_chunks::<4>();
            let points = points.iter().map(|&[at, r, g, b]| (at, [r, g, b]));
            (points.collect(), rest.is_empty().then_some(()).ok_or("four"))
        }
        (None, None) => return Err(wrong("there are none")),
    };
    width.map_err(|count| wrong(&format!("there are not {count} numbers for each colour")))?;
    if points.len() > MOST {
        return Err(ColorMapError::TooMany);
    }
    let mut read = ColorMap { special: special(map)?, ..ColorMap::from_points(name, &points)? };
    if colors.is_some() {
        read.is_categorical = true;
        read.annotations = annotations(map)?;
        if read.annotations.len() > MOST {
            return Err(ColorMapError::TooMany);
        }
    }
    Ok(read)
}

/// The values and labels of a categorical map, `["0", "bone", "1", "skin"]`; none if it has none.
fn annotations(map: &serde_json::Value) -> Result<Vec<Annotation>, ColorMapError> {
    let wrong = || ColorMapError::Json("Annotations are not pairs of values and labels".to_owned());
    let Some(all) = map.get("Annotations") else { return Ok(Vec::new()) };
    let all = all.as_array().ok_or_else(wrong)?;
    let text = |value: &serde_json::Value| match value {
        serde_json::Value::String(text) => Some(text.clone()),
        serde_json::Value::Number(number) => Some(number.to_string()),
        _ => None,
    };
    let (pairs, rest) = all.as_chunks::<2>();
    let pair = |[value, label]: &[serde_json::Value; 2]| {
        let value = text(value)?.trim().parse().ok().filter(|value: &f64| value.is_finite());
        Some(Annotation { value, label: text(label)? })
    };
    pairs.iter().map(pair).collect::<Option<_>>().filter(|_| rest.is_empty()).ok_or_else(wrong)
}

/// Whether a switch is on: ParaView writes 0 and 1.
fn is_used(map: &serde_json::Value, key: &str) -> bool {
    map.get(key).is_some_and(|value| value.as_bool().unwrap_or(value.as_f64() > Some(0.0)))
}

/// The colours of what is not in the range. Those beyond it count only if the map says that they are used.
fn special(map: &serde_json::Value) -> Result<Special, ColorMapError> {
    let color = |key: &str, opacity: &str| -> Result<Option<[u8; 4]>, ColorMapError> {
        let Some(value) = map.get(key) else { return Ok(None) };
        let numbers: Option<Vec<f64>> =
            value.as_array().and_then(|all| all.iter().map(serde_json::Value::as_f64).collect());
        let color: [f64; 3] = numbers
            .and_then(|numbers| numbers.try_into().ok())
            .ok_or_else(|| ColorMapError::Json(format!("{key} is not three numbers")))?;
        if !color.iter().all(|c| (0.0..=1.0).contains(c)) {
            return Err(ColorMapError::Component(color));
        }
        let [r, g, b] = rounded(color);
        let opacity = map.get(opacity).and_then(serde_json::Value::as_f64).unwrap_or(1.0);
        Ok(Some([r, g, b, (opacity.clamp(0.0, 1.0) * 255.0 + 0.5) as u8]))
    };
    let beyond = |used: &str, key: &str, opacity: &str| {
        if is_used(map, used) { color(key, opacity) } else { Ok(None) }
    };
    Ok(Special {
        nan: color("NanColor", "NanOpacity")?,
        below: beyond("UseBelowRangeColor", "BelowRangeColor", "BelowRangeOpacity")?,
        above: beyond("UseAboveRangeColor", "AboveRangeColor", "AboveRangeOpacity")?,
    })
}
