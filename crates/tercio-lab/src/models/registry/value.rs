//! Arguments and results of models: numbers, texts, and lists of them.

use std::fmt;

use serde::{Deserialize, Serialize};

/// A number in base units, a text (a number with its unit), or a list.
///
/// In files an illegible cell is the number NaN.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Value {
    /// A number in base units.
    Number(f64),
    /// A number with its unit, as `14 MHz`.
    Text(String),
    /// A list: points, distributions, rows of a table.
    List(Vec<Self>),
}

impl Value {
    /// Parses a command-line argument: JSON for lists (`[1, 2, [3, 4]]`), everything else as it is.
    ///
    /// # Errors
    /// A text that begins like a list and is not one.
    pub fn from_argument(text: &str) -> Result<Self, String> {
        let text = text.trim();
        if text.starts_with('[') {
            return serde_json::from_str(text)
                .map_err(|e| format!("expected a list as in [1, 2], found '{text}': {e}"));
        }
        Ok(text.parse().map_or_else(|_| Self::Text(text.into()), Self::Number))
    }

    /// Every number divided by `divisor`: from base units to the unit of `divisor` base units.
    #[must_use]
    pub fn divided_by(&self, divisor: f64) -> Self {
        match self {
            Self::Number(number) => Self::Number(number / divisor),
            Self::Text(text) => Self::Text(text.clone()),
            Self::List(items) => Self::List(items.iter().map(|i| i.divided_by(divisor)).collect()),
        }
    }

    /// The number, if it is one.
    pub fn as_number(&self) -> Option<f64> {
        if let Self::Number(number) = self { Some(*number) } else { None }
    }

    /// Whether both have the same shape and no number differs from its counterpart by more than `tolerance`. An
    /// illegible cell (NaN) agrees only with another one.
    pub fn agrees_with(&self, other: &Self, tolerance: f64) -> bool {
        /// If the tolerance is half of the last digit and the distance exactly that, the rounding of the two binary
        /// numbers must not decide.
        const ROUNDING: f64 = 4.0 * f64::EPSILON;
        match (self, other) {
            (Self::Number(a), Self::Number(b)) => {
                let rounding = if tolerance > 0.0 { ROUNDING * a.abs().max(b.abs()) } else { 0.0 };
                (a - b).abs() <= tolerance + rounding || (a.is_nan() && b.is_nan())
            }
            (Self::List(a), Self::List(b)) => {
                a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.agrees_with(b, tolerance))
            }
            (Self::Text(a), Self::Text(b)) => a == b,
            _ => false,
        }
    }
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(number) if number.is_nan() => f.write_str("?"),
            // Ten digits: more than any document prints, and no trace of binary fractions.
            Self::Number(number) => {
                let short: f64 = format!("{number:.9e}").parse().unwrap_or(*number);
                write!(f, "{short}")
            }
            Self::Text(text) => f.write_str(text),
            Self::List(items) => {
                f.write_str("[")?;
                for (i, item) in items.iter().enumerate() {
                    let comma = if i == 0 { "" } else { ", " };
                    write!(f, "{comma}{item}")?;
                }
                f.write_str("]")
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_and_numbers_of_the_command_line() {
        let list = Value::from_argument("[1, [2.5, 3]]").unwrap();
        assert_eq!(list.to_string(), "[1, [2.5, 3]]");
        assert_eq!(Value::from_argument("1e3"), Ok(Value::Number(1000.0)));
        assert_eq!(Value::from_argument("14 MHz"), Ok(Value::Text("14 MHz".into())));
        assert!(Value::from_argument("[1, 2").is_err());
    }

    #[test]
    fn agreement_needs_shape_and_nearness() {
        let list = |items: &[f64]| Value::List(items.iter().map(|&n| Value::Number(n)).collect());
        assert!(list(&[1.0, 2.0]).agrees_with(&list(&[1.0, 2.1]), 0.11));
        assert!(!list(&[1.0, 2.0]).agrees_with(&list(&[1.0, 2.1]), 0.09));
        assert!(!list(&[1.0, 2.0]).agrees_with(&list(&[1.0]), 9.0));
        assert!(list(&[f64::NAN]).agrees_with(&list(&[f64::NAN]), 0.0));
        assert!(!list(&[f64::NAN]).agrees_with(&list(&[1.0]), 9.0));
    }
}
