//! Reading quantities from texts and files.

use std::fmt;
use std::marker::PhantomData;

use serde::de::{Error, Visitor};

use super::Quantity;

/// Why a text is not a valid quantity.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum UnitError {
    /// No number at the beginning.
    #[error("{name}: expected a number{}, found '{found}'", unit_hint(.unit))]
    Number {
        /// The quantity.
        name: &'static str,
        /// Its base unit.
        unit: &'static str,
        /// The text.
        found: String,
    },
    /// A unit of something else, or a prefix that does not exist.
    #[error("{name}: expected {}, found the unit '{found}'", unit_words(.unit))]
    Unit {
        /// The quantity.
        name: &'static str,
        /// Its base unit.
        unit: &'static str,
        /// The unit found.
        found: String,
    },
    /// A number outside the quantity's domain.
    #[error("{name}: expected {expected}, found {found}")]
    Domain {
        /// The quantity.
        name: &'static str,
        /// The domain.
        expected: &'static str,
        /// The value found, in base units.
        found: f64,
    },
}

fn unit_hint(unit: &str) -> String {
    if unit.is_empty() { String::new() } else { format!(" and optionally a unit ({unit})") }
}

fn unit_words(unit: &str) -> String {
    if unit.is_empty() {
        "a number without a unit".into()
    } else {
        format!("{unit}, with a prefix if need be")
    }
}

/// Decimal prefixes; `u` stands for micro.
const DECIMAL: [(&str, f64); 9] = [
    ("p", 1e-12),
    ("n", 1e-9),
    ("u", 1e-6),
    ("m", 1e-3),
    ("k", 1e3),
    ("K", 1e3),
    ("M", 1e6),
    ("G", 1e9),
    ("T", 1e12),
];

/// Binary prefixes, for sizes and bandwidths.
const BINARY: [(&str, f64); 4] =
    [("Ki", 1024.0), ("Mi", 1_048_576.0), ("Gi", 1_073_741_824.0), ("Ti", 1_099_511_627_776.0)];

/// Other symbols of the same quantity: (symbol, base unit, how many base units).
const SYNONYMS: [(&str, &str, f64); 12] = [
    ("bit/s", "B/s", 0.125),
    ("%", "", 0.01),
    ("fps", "frame/s", 1.0),
    ("Hz", "frame/s", 1.0),
    ("Hz", "line/s", 1.0),
    ("triangle/s", "polygon/s", 1.0),
    ("polygons/s", "polygon/s", 1.0),
    ("triangle", "polygon", 1.0),
    ("pixels", "pixel", 1.0),
    ("cycles", "cycle", 1.0),
    ("mm2", "m2", 1e-6),
    ("flop/s", "op/s", 1.0),
];

/// How many `base` units one `unit` has: `scale("MB/s", "B/s")` is 1e6. `None` if they measure different things.
pub fn scale(unit: &str, base: &str) -> Option<f64> {
    let symbols = SYNONYMS.iter().filter(|s| s.1 == base).map(|s| (s.0, s.2));
    for (symbol, factor) in std::iter::once((base, 1.0)).chain(symbols) {
        let Some(prefix) = unit.strip_suffix(symbol) else { continue };
        if prefix.is_empty() {
            return Some(factor);
        }
        // A plain number may have a prefix, too: "10 k"; but percentages and areas may not.
        let takes_prefixes = symbol != "%" && !symbol.ends_with('2');
        let binary = if matches!(symbol, "B" | "B/s" | "bit" | "bit/s") { &BINARY[..] } else { &[] };
        let known = DECIMAL.iter().chain(binary).find(|p| p.0 == prefix);
        if let (true, Some((_, power))) = (takes_prefixes, known) {
            return Some(factor * power);
        }
    }
    None
}

/// Reads `14 MHz`, `14e6` (base units) or `64KiB`.
pub(super) fn quantity<Q: Quantity>(text: &str) -> Result<Q, UnitError> {
    let text = text.trim();
    let no_number = || UnitError::Number { name: Q::NAME, unit: Q::UNIT, found: text.into() };
    // The longest prefix that is a number: the `e` of 1e6 belongs to it, that of "1 edge" does not.
    let ends = (1..=text.len()).rev().filter(|&end| text.is_char_boundary(end));
    let (number, end) = ends
        .filter(|&end| text[..end].ends_with(|c: char| c.is_ascii_digit() || c == '.'))
        .find_map(|end| Some((text[..end].parse::<f64>().ok()?, end)))
        .ok_or_else(no_number)?;
    let unit = text[end..].trim();
    let factor = if unit.is_empty() { Some(1.0) } else { scale(unit, Q::UNIT) };
    let factor =
        factor.ok_or_else(|| UnitError::Unit { name: Q::NAME, unit: Q::UNIT, found: unit.into() })?;
    Q::checked(number * factor)
}

/// Takes a number in base units or a text with a unit.
pub(super) struct QuantityVisitor<Q>(PhantomData<Q>);

impl<Q> QuantityVisitor<Q> {
    pub(super) fn new() -> Self {
        Self(PhantomData)
    }
}

impl<Q: Quantity> Visitor<'_> for QuantityVisitor<Q> {
    type Value = Q;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "a {} as a number{} or a text", Q::NAME, unit_hint(Q::UNIT))
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<Q, E> {
        Q::checked(value).map_err(E::custom)
    }

    #[expect(clippy::cast_precision_loss, reason = "numbers of files, far below 2^53")]
    fn visit_i64<E: Error>(self, value: i64) -> Result<Q, E> {
        self.visit_f64(value as f64)
    }

    #[expect(clippy::cast_precision_loss, reason = "numbers of files, far below 2^53")]
    fn visit_u64<E: Error>(self, value: u64) -> Result<Q, E> {
        self.visit_f64(value as f64)
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<Q, E> {
        quantity(text).map_err(E::custom)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::{Bytes, BytesPerSecond, Count, Cycles, Hertz, Ratio, Seconds, SquareMetres};
    use super::*;

    #[test]
    fn prefixes_and_synonyms() {
        assert_eq!("14 MHz".parse(), Ok(Hertz::new(14e6)));
        assert_eq!("0.3us".parse::<Seconds>().unwrap().get(), 0.3e-6);
        assert_eq!("64 KiB".parse(), Ok(Bytes::new(65536.0)));
        assert_eq!("8 Gbit/s".parse(), Ok(BytesPerSecond::new(1e9)));
        assert_eq!("25 %".parse(), Ok(Ratio::new(0.25)));
        assert_eq!("4 mm2".parse(), Ok(SquareMetres::new(4e-6)));
        assert_eq!("1e3".parse(), Ok(Cycles::new(1000.0)));
        assert_eq!("1e3 kcycle".parse(), Ok(Cycles::new(1e6)));
    }

    #[test]
    fn errors_name_the_problem() {
        let message = |e: UnitError| e.to_string();
        assert_eq!(
            message("14 MB".parse::<Hertz>().unwrap_err()),
            "clock rate: expected Hz, with a prefix if need be, found the unit 'MB'"
        );
        assert_eq!(
            message("0 Hz".parse::<Hertz>().unwrap_err()),
            "clock rate: expected a number above zero, found 0"
        );
        assert_eq!(
            message("1.5".parse::<Count>().unwrap_err()),
            "count: expected a whole number not below zero, found 1.5"
        );
        assert!(message("fast".parse::<Hertz>().unwrap_err()).contains("found 'fast'"));
        assert!("inf".parse::<Ratio>().is_err() && "nan".parse::<Ratio>().is_err());
        assert!("1e999".parse::<Ratio>().is_err(), "infinity is no value");
    }

    #[test]
    fn products() {
        assert_eq!(Cycles::new(28e6) / Hertz::new(14e6), Seconds::new(2.0));
        assert_eq!(Bytes::new(100.0) / BytesPerSecond::new(50.0), Seconds::new(2.0));
    }

    proptest! {
        #[test]
        fn no_text_panics(text in "\\PC{0,12}") {
            let _ = text.parse::<Hertz>();
        }

        #[test]
        fn what_is_written_is_read(value in 1e-3f64..1e12) {
            let written = Hertz::new(value).to_string();
            prop_assert_eq!(written.parse::<Hertz>().unwrap(), Hertz::new(value));
        }
    }
}
