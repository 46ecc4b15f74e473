//! Where the tolerance of a published number comes from.

use serde::{Deserialize, Serialize};

use super::Number;
use crate::models::registry::Value;

/// Why a computed number may differ from the printed one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ToleranceSource {
    /// The print is exact; only binary fractions are rounded.
    Exact,
    /// The print is rounded after its last digit.
    LastDigit,
    /// The print is cut off after its last digit.
    CutOff,
    /// The last digit of the print is neither rounded nor cut off: it is off by one.
    LastDigitOff,
    /// The document says it in words: about, nearly, a factor of. They allow no more than a twentieth of the number, less where the
    /// list of all numbers has less, the same words the same, and one side where they name one.
    Words,
    /// The document states a bound, not the value: over, no more than. There is no tolerance.
    Bound,
    /// An argument of the formula is itself a rounded print.
    RoundedInput,
    /// The authors' program added in single precision.
    SinglePrecision,
    /// The number compared with is a mean of random samples, or ours is.
    Sampling,
    /// The number compared with is read from a plot or a damaged cell.
    Scan,
    /// Nothing is printed; what is compared with has this many digits.
    ExpectedDigits,
}

impl ToleranceSource {
    /// The source in words.
    pub fn text(self) -> &'static str {
        match self {
            Self::Exact => "none: exact but for binary rounding",
            Self::LastDigit => "rounding of the print",
            Self::CutOff => "cut off in print",
            Self::LastDigitOff => "last digit of the print off by one",
            Self::Words => "stated in words",
            Self::Bound => "stated as a bound",
            Self::RoundedInput => "an input is rounded in print",
            Self::SinglePrecision => "summed in single precision",
            Self::Sampling => "mean of random samples",
            Self::Scan => "reading of the scan",
            Self::ExpectedDigits => "digits of the number compared with",
        }
    }
}

impl Number {
    /// Where the row's tolerance comes from: what the row says, or else what the digits of the print explain. None if
    /// the tolerance is wider than that.
    pub fn tolerance_source(&self) -> Option<ToleranceSource> {
        if self.tolerance_from.is_some() {
            return self.tolerance_from;
        }
        let magnitude = largest(&self.expected);
        if self.tolerance <= 1e-6 * magnitude.max(1e-3) {
            return Some(ToleranceSource::Exact);
        }
        let digit = last_digit(self.printed.as_ref()?)?;
        // Cut prints are a whole unit off at most.
        (self.tolerance <= 1.11 * digit).then_some(ToleranceSource::LastDigit)
    }
}

/// The largest magnitude of a value.
fn largest(value: &Value) -> f64 {
    match value {
        Value::Number(number) => number.abs(),
        Value::Text(_) => 0.0,
        Value::List(items) => items.iter().map(largest).fold(0.0, f64::max),
    }
}

/// The unit of the last printed digit: 0.01 of 27.36. Zeros at the end of a whole number count as digits, except in
/// numbers from 10,000 on, which documents round to thousands or more (1.17 million). None for lists and texts.
pub(super) fn last_digit(value: &Value) -> Option<f64> {
    let number = value.as_number().filter(|n| n.is_finite())?;
    let text = number.abs().to_string();
    if let Some((_, fraction)) = text.split_once('.') {
        return Some(10f64.powi(-(i32::try_from(fraction.len()).ok()?)));
    }
    let zeros = text.len() - text.trim_end_matches('0').len();
    if text.len() < 5 || zeros < 2 { Some(1.0) } else { Some(10f64.powi(i32::try_from(zeros).ok()?)) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::published::numbers;

    #[test]
    fn the_last_digit_is_that_of_the_print() {
        let digit = |n: f64| last_digit(&Value::Number(n)).unwrap();
        assert!((digit(27.36) - 0.01).abs() < 1e-12);
        assert_eq!([60_123.0, 910.0, 30.0, 1_170_000.0].map(digit), [1.0, 1.0, 1.0, 10_000.0]);
    }

    #[test]
    fn words_allow_a_twentieth_and_the_same_words_the_same() {
        let all = numbers().unwrap();
        let of_words = |n: &&Number| n.tolerance_from == Some(ToleranceSource::Words);
        for number in all.iter().filter(of_words) {
            let print = number.printed.as_ref().and_then(Value::as_number).unwrap();
            assert!(number.tolerance <= 0.05 * print * (1.0 + 1e-9), "{}: {}", number.id, number.tolerance);
        }
        let factors = all.iter().filter(of_words).filter(|n| n.printed == Some(Value::Number(2.0)));
        let factors: Vec<_> = factors.map(|n| n.tolerance).collect();
        assert_eq!(factors, [0.1; 4], "a factor of 2");
        let bounds = all.iter().filter(|n| n.tolerance_from == Some(ToleranceSource::Bound));
        let has_side: Vec<_> = bounds.map(|n| n.side.is_some()).collect();
        assert_eq!(has_side, [true; 2]);
    }

    #[test]
    fn every_tolerance_has_a_source_and_a_wider_one_has_none() {
        let all = numbers().unwrap();
        let without: Vec<_> = all.iter().filter(|n| n.tolerance_source().is_none()).map(|n| &n.id).collect();
        assert!(without.is_empty(), "{without:?}");
        let mut wider = all.into_iter().find(|n| n.id == "E5.6").unwrap();
        assert_eq!(wider.tolerance_source(), Some(ToleranceSource::LastDigit));
        wider.tolerance *= 10.0;
        assert_eq!(wider.tolerance_source(), None);
    }
}
