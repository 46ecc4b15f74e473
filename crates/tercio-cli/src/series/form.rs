//! The form of a number in a name or a text: what is behind the colon of `{:04}` and `{time:07.2f}`, as in Python and Rust.

/// Most characters and digits that a form may ask for.
const MOST: usize = 20;

/// How the digits of a time are written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Digits {
    /// As few as mean it.
    #[default]
    Shortest,
    /// So many after the point: `.2f`.
    Fixed(usize),
    /// So many after the point, and a power of ten: `.2e`.
    Exponent(usize),
    /// So many significant ones, whichever of the two is shorter: `.3g`.
    General(usize),
}

/// How a number is written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Form {
    /// So many characters at least: zeros before it.
    width: usize,
    digits: Digits,
    /// `E` and `G`: letters are capitals.
    is_upper: bool,
}

impl Form {
    /// `04`, or of a time also `.2`, `.2f`, `.2e`, `.3g`, with a width before that: `07.2f`.
    ///
    /// A width begins with 0. Python and Rust fill others with spaces, which are sorted wrongly in names and do not align numbers in
    /// texts.
    ///
    /// # Errors
    /// What is expected, for the placeholder with this name.
    pub fn parse(text: &str, name: &str) -> Result<Self, String> {
        let is_time = name == "time";
        let expected = || match name {
            "time" => format!(
                "expected a form as in {{time:.2f}}, {{time:07.2f}}, {{time:.1e}} or {{time:.3g}}, with at most {MOST} digits"
            ),
            "name" | "view" => format!("{{{name}}} is no number: it has no form"),
            _ => format!("expected a number of digits behind the colon, at most {MOST}, as in {{{name}:04}}"),
        };
        if matches!(name, "name" | "view") {
            return Err(expected());
        }
        let number = |text: &str| {
            let is_number = !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
            text.parse().ok().filter(|&n: &usize| is_number && n <= MOST).ok_or_else(expected)
        };
        let (rest, kind) = match text.char_indices().last() {
            Some((at, kind @ ('f' | 'F' | 'e' | 'E' | 'g' | 'G'))) => (&text[..at], Some(kind)),
            _ => (text, None),
        };
        let (width, precision) = rest.split_once('.').map_or((rest, None), |(w, digits)| (w, Some(digits)));
        if !is_time && (kind.is_some() || precision.is_some()) || text.is_empty() {
            return Err(expected());
        }
        let precision = precision.map(number).transpose()?;
        let is_upper = kind.is_some_and(|kind| kind.is_ascii_uppercase());
        let digits = match (kind.map(|kind| kind.to_ascii_lowercase()), precision) {
            (None, None) => Digits::Shortest,
            // As in C and Python where there is no number.
            (Some('e'), digits) => Digits::Exponent(digits.unwrap_or(6)),
            (Some('g'), digits) => Digits::General(digits.unwrap_or(6).max(1)),
            (_, digits) => Digits::Fixed(digits.unwrap_or(6)),
        };
        let is_padded = width.is_empty() || width.starts_with('0');
        let width = if width.is_empty() { 0 } else { number(width)? };
        if !is_padded {
            return Err(format!(
                "a width begins with 0, as in {{{name}:0{text}}}: numbers are filled with zeros, not with spaces"
            ));
        }
        Ok(Self { width, digits, is_upper })
    }

    /// A number that counts.
    pub fn count(self, number: usize) -> String {
        format!("{number:0width$}", width = self.width)
    }

    /// A time.
    pub fn time(self, time: f64) -> String {
        let text = match self.digits {
            // 0.1 + 0.2 is 0.3 in most files.
            Digits::Shortest => format!("{}", format!("{time:.11e}").parse().unwrap_or(time)),
            Digits::Fixed(digits) => format!("{time:.digits$}"),
            Digits::Exponent(digits) => exponential(time, digits),
            Digits::General(digits) => general(time, digits),
        };
        let text = if self.is_upper { text.to_ascii_uppercase() } else { text };
        let (sign, number) = text.strip_prefix('-').map_or(("", &*text), |number| ("-", number));
        let width = self.width.saturating_sub(sign.len());
        // Infinity and NaN have no digits.
        if time.is_finite() { format!("{sign}{number:0>width$}") } else { text }
    }
}

/// As C and Python write it, with a sign and at least two digits in the exponent: `1.5e-07`.
fn exponential(number: f64, digits: usize) -> String {
    let text = format!("{number:.digits$e}");
    let Some((mantissa, exponent)) = text.split_once('e') else { return text };
    let (sign, exponent) = exponent.strip_prefix('-').map_or(('+', exponent), |exponent| ('-', exponent));
    format!("{mantissa}e{sign}{exponent:0>2}")
}

/// So many significant digits, without zeros at the end; with an exponent where that is below -4 or the digits do not reach the point.
fn general(number: f64, digits: usize) -> String {
    let text = exponential(number, digits - 1);
    let Some((mantissa, exponent)) = text.split_once('e') else { return text };
    let power: i32 = exponent.parse().unwrap_or(0);
    let short = |text: &str| match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text.to_owned(),
    };
    if power < -4 || power >= digits as i32 {
        return format!("{}e{exponent}", short(mantissa));
    }
    let after = (digits as i32 - 1 - power).max(0) as usize;
    short(&format!("{number:.after$}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The expected texts are those of Python's format, but for the last ones.
    #[test]
    fn times_are_written_as_python_writes_them() {
        for (form, time, expected) in [
            ("05.1f", 2.25, "002.2"),
            ("05.1F", -2.25, "-02.2"),
            (".1e", 0.25, "2.5e-01"),
            (".1E", 12345.0, "1.2E+04"),
            ("010.2e", -1.5e-120, "-1.50e-120"),
            ("e", 1.5, "1.500000e+00"),
            ("f", 1.5, "1.500000"),
            ("g", 0.0001, "0.0001"),
            (".3g", 0.000012345, "1.23e-05"),
            (".3g", 1234.0, "1.23e+03"),
            (".3g", 999.9, "1e+03"),
            (".3g", 100.0, "100"),
            (".0g", 0.0, "0"),
            ("08.3g", 0.5, "000000.5"),
            ("06", 2.5, "0002.5"),
            // Not as Python writes them: digits without a letter are those after the point, and what is no number has no zeros.
            (".2", 0.1 + 0.2, "0.30"),
            ("05.1f", f64::NAN, "NaN"),
        ] {
            assert_eq!(
                Form::parse(form, "time").map(|form| form.time(time)).as_deref(),
                Ok(expected),
                "{form} {time}"
            );
        }
        assert_eq!(Form::parse("04", "frame").map(|form| form.count(7)).as_deref(), Ok("0007"));
    }

    #[test]
    fn other_forms_are_refused_with_what_is_expected() {
        for (form, name, part) in [
            ("5.1f", "time", "{time:05.1f}"),
            ("4", "frame", "{frame:04}"),
            ("4", "", "{:04}"),
            ("12", "step", "{step:012}"),
            ("04", "name", "{name} is no number"),
            (".2f", "frame", "{frame:04}"),
            ("", "time", "{time:.2f}"),
            (".", "time", "{time:.2f}"),
            ("é", "time", "{time:.2f}"),
            (">5", "time", "{time:.2f}"),
            ("+05.1f", "time", "{time:.2f}"),
            ("021", "time", "{time:.2f}"),
            (".99f", "time", "{time:.2f}"),
            (".1x", "time", "{time:.2f}"),
        ] {
            let error = Form::parse(form, name).unwrap_err();
            assert!(error.contains(part), "{form} {name}: {error}");
        }
    }
}
