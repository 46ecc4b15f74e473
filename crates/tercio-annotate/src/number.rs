//! Numbers as people write them.

use std::fmt;
use std::str::FromStr;

/// How numbers are printed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum NumberFormat {
    /// As many digits as a scale's steps need, with a power of ten where numbers are very large or small.
    #[default]
    Auto,
    /// So many digits after the point: `.2f`.
    Fixed(usize),
    /// So many digits after the point, and a power of ten: `.2e`.
    Exponent(usize),
    /// So many significant digits, whichever of the two is shorter: `.3g`.
    General(usize),
}

/// Most digits that a format may ask for.
const MOST_DIGITS: usize = 17;

impl FromStr for NumberFormat {
    type Err = String;

    /// `auto`, or as in C and Python: `.3g`, `%.2f`, `.1e`.
    fn from_str(text: &str) -> Result<Self, String> {
        if text == "auto" {
            return Ok(Self::Auto);
        }
        let error =
            || format!("expected auto, or a format such as .3g, %.2f or .1e (at most {MOST_DIGITS} digits)");
        let format = text.strip_prefix('%').unwrap_or(text);
        let format = format.strip_prefix('.').ok_or_else(error)?;
        let kind = format.chars().last().ok_or_else(error)?;
        let digits = &format[..format.len() - kind.len_utf8()];
        let is_number = !digits.is_empty() && digits.bytes().all(|b| b.is_ascii_digit());
        let digits = digits.parse().ok().filter(|&n| is_number && n <= MOST_DIGITS).ok_or_else(error)?;
        match kind {
            'f' | 'F' => Ok(Self::Fixed(digits)),
            'e' | 'E' => Ok(Self::Exponent(digits)),
            'g' | 'G' => Ok(Self::General(digits.max(1))),
            _ => Err(error()),
        }
    }
}

impl fmt::Display for NumberFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Auto => f.write_str("auto"),
            Self::Fixed(digits) => write!(f, ".{digits}f"),
            Self::Exponent(digits) => write!(f, ".{digits}e"),
            Self::General(digits) => write!(f, ".{digits}g"),
        }
    }
}

impl NumberFormat {
    /// A number by itself. `Auto` prints up to six significant digits.
    pub fn print(self, value: f64) -> String {
        match self {
            Self::Auto => general(value, 6),
            Self::Fixed(digits) => fixed(value, digits),
            Self::Exponent(digits) => {
                let (mantissa, exponent) = scientific(value, digits);
                with_power(&mantissa, exponent)
            }
            Self::General(digits) => general(value, digits),
        }
    }
}

/// Digits and the power of ten of a number, rounded to so many digits after the point.
pub(crate) fn scientific(value: f64, digits: usize) -> (String, i32) {
    let text = format!("{value:.digits$e}");
    let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    (mantissa.to_owned(), exponent.parse().unwrap_or(0))
}

/// The power of ten of a number's first digit; 0 for 0.
pub fn exponent_of(value: f64) -> i32 {
    if value == 0.0 || !value.is_finite() {
        return 0;
    }
    // The shortest digits that mean this number: 1e23 is a little less than that.
    let text = format!("{value:e}");
    text.split_once('e').and_then(|(_, exponent)| exponent.parse().ok()).unwrap_or(0)
}

/// With so many digits after the point.
pub fn fixed(value: f64, digits: usize) -> String {
    let text = format!("{value:.digits$}");
    let is_zero = text.bytes().all(|b| matches!(b, b'-' | b'0' | b'.'));
    typographic(if is_zero { text.trim_start_matches('-') } else { &text })
}

/// So many significant digits, without zeros at the end.
pub fn general(value: f64, digits: usize) -> String {
    let (mantissa, exponent) = scientific(value, digits.max(1) - 1);
    if value == 0.0 || (-4..digits.max(6) as i32).contains(&exponent) {
        let after = (digits as i32 - 1 - exponent).max(0) as usize;
        // Rounded to significant digits first: 123456 with three of them is 123000.
        let rounded: f64 = format!("{mantissa}e{exponent}").parse().unwrap_or(value);
        return without_zeros(&fixed(rounded, after));
    }
    with_power(&without_zeros(&mantissa), exponent)
}

/// A mantissa times a power of ten.
pub fn with_power(mantissa: &str, exponent: i32) -> String {
    let mantissa = typographic(mantissa);
    if exponent == 0 { mantissa } else { format!("{mantissa}×{}", power_of_ten(exponent)) }
}

/// 10 with its exponent above.
pub fn power_of_ten(exponent: i32) -> String {
    let exponent = exponent.to_string();
    let raised = exponent.chars().map(|c| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        '0' => '⁰',
        digit => char::from_u32('⁰' as u32 + digit as u32 - '0' as u32).unwrap_or(digit),
    });
    format!("10{}", raised.collect::<String>())
}

pub(crate) fn without_zeros(text: &str) -> String {
    let short = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { text };
    short.to_owned()
}

/// Numbers with the same digits after the point, as many as the one of them that has most; those with a power of ten by themselves.
/// A 0 stays as it is.
pub(crate) fn with_equal_digits(labels: &mut [String]) {
    let digits = |label: &str| mantissa_of(label).split_once('.').map_or(0, |(_, digits)| digits.len());
    for has_power in [false, true] {
        let is_one = |label: &String| label.contains('×') == has_power && label != "0" && !label.is_empty();
        let most = labels.iter().filter(|label| is_one(label)).map(|label| digits(label)).max().unwrap_or(0);
        for label in labels.iter_mut().filter(|label| is_one(label)) {
            let (own, end) = (digits(label), mantissa_of(label).len());
            let point = if own == 0 && most > 0 { "." } else { "" };
            label.insert_str(end, &format!("{point}{}", "0".repeat(most - own)));
        }
    }
}

/// What is before the power of ten of a number.
fn mantissa_of(label: &str) -> &str {
    label.split_once('×').map_or(label, |(mantissa, _)| mantissa)
}

/// With the sign that is as wide as a plus.
fn typographic(text: &str) -> String {
    text.replace('-', "−")
}

/// The number that a printed one means; for tests and for those who read pictures by program.
pub fn parse(text: &str) -> Option<f64> {
    let plain = text.replace('−', "-");
    let (mantissa, power) = match plain.split_once('×') {
        Some((mantissa, power)) => (mantissa.to_owned(), Some(power.to_owned())),
        None if plain.starts_with("10") && plain.chars().nth(2).is_some_and(|c| !c.is_ascii()) => {
            ("1".to_owned(), Some(plain.clone()))
        }
        None if plain.starts_with("-10") && plain.chars().nth(3).is_some_and(|c| !c.is_ascii()) => {
            ("-1".to_owned(), Some(plain[1..].to_owned()))
        }
        None => (plain.clone(), None),
    };
    let Some(power) = power else { return mantissa.parse().ok() };
    let lowered = power.strip_prefix("10")?.chars().map(|c| match c {
        '⁻' => '-',
        '⁰' => '0',
        '¹' => '1',
        '²' => '2',
        '³' => '3',
        other => {
            char::from_u32((other as u32).wrapping_sub('⁰' as u32).wrapping_add('0' as u32)).unwrap_or('x')
        }
    });
    format!("{mantissa}e{}", lowered.collect::<String>()).parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_are_those_of_c() {
        for (format, value, expected) in [
            ("%.2f", -1.005, "−1.00"),
            (".0f", 2.5, "2"),
            (".3g", 0.000123456, "0.000123"),
            (".3g", 123456.0, "123000"),
            (".3g", 1.5e9, "1.5×10⁹"),
            (".3g", 100.0, "100"),
            (".2e", 12345.0, "1.23×10⁴"),
            (".1e", -0.00012, "−1.2×10⁻⁴"),
            (".2f", -0.0001, "0.00"),
            ("auto", 0.1, "0.1"),
            ("auto", 0.0, "0"),
        ] {
            let format: NumberFormat = format.parse().expect("a format");
            assert_eq!(format.print(value), expected, "{format} {value}");
        }
        for bad in ["", "%d", "2f", ".f", "%.2", ".99f", "%.2x", ".2ff", ".-1f", ".+1f", "é", ".é"] {
            assert!(bad.parse::<NumberFormat>().is_err(), "{bad}");
        }
    }

    #[test]
    fn numbers_beside_each_other_have_equal_digits() {
        let of = |labels: &[&str]| {
            let mut labels: Vec<String> = labels.iter().map(|&label| label.into()).collect();
            with_equal_digits(&mut labels);
            labels.join(" ")
        };
        assert_eq!(of(&["741.9", "692", "−642.1", "0"]), "741.9 692.0 −642.1 0");
        assert_eq!(of(&["1×10⁶", "1.5×10⁶", "200000"]), "1.0×10⁶ 1.5×10⁶ 200000");
        assert_eq!(of(&["1", "2", "30"]), "1 2 30");
        assert_eq!(of(&[]), "");
    }

    #[test]
    fn printed_numbers_are_read_back() {
        for value in [0.0, 1.0, -12.5, 3e-7, 1.25e300, -5e-324, 1e21, 10.0, 1e5] {
            let text = general(value, 17);
            assert_eq!(parse(&text), Some(value), "{text}");
        }
        assert_eq!([parse("10⁻¹²"), parse("−10³"), parse("x")], [Some(1e-12), Some(-1e3), None]);
    }
}
