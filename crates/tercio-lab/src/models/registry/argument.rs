//! Conversion between a [`Value`] and the arguments and results of formulas.

use super::Value;
use crate::units::Quantity;

/// A type of arguments.
pub trait Argument: Sized {
    /// The base unit's symbol, or the shape of a list.
    const UNIT: &'static str;

    /// The syntax of a value: a unit, the name of a number without one, `[px, ...]` for a list of any length, `[number,
    /// number]` for one of a given length.
    fn form() -> String;

    /// Reads the value.
    ///
    /// # Errors
    /// What was expected and what was found.
    fn from_value(value: &Value) -> Result<Self, String>;

    /// The number in base units, if it is one.
    fn number(&self) -> Option<f64> {
        None
    }
}

/// The message for results that are infinite or not a number.
const NO_VALUE: &str = "the formula has no finite value for these arguments";

/// A type of results.
pub trait Outcome {
    /// The base unit's symbol; empty for ratios, counts and lists.
    const UNIT: &'static str = "";

    /// The value in base units.
    ///
    /// # Errors
    /// Why the formula has no result for these arguments: not finite, or negative where that is impossible.
    fn into_value(self) -> Result<Value, String>;
}

impl<Q: Quantity> Argument for Q {
    const UNIT: &'static str = Q::UNIT;

    fn form() -> String {
        if Q::UNIT.is_empty() { Q::NAME.into() } else { Q::UNIT.into() }
    }

    fn from_value(value: &Value) -> Result<Self, String> {
        match value {
            Value::Number(number) => Q::checked(*number).map_err(|e| e.to_string()),
            Value::Text(text) => text.parse::<Q>().map_err(|e| e.to_string()),
            Value::List(_) => Err(format!("{}: expected one number, found a list", Q::NAME)),
        }
    }

    fn number(&self) -> Option<f64> {
        Some(self.get())
    }
}

/// A coordinate or another number that may be negative.
impl Argument for f64 {
    const UNIT: &'static str = "";

    fn form() -> String {
        "number".into()
    }

    fn from_value(value: &Value) -> Result<Self, String> {
        match value {
            Value::Number(number) if number.is_finite() => Ok(*number),
            other => Err(format!("expected a number, found {other}")),
        }
    }

    fn number(&self) -> Option<f64> {
        Some(*self)
    }
}

impl<T: Argument> Argument for Vec<T> {
    const UNIT: &'static str = "list";

    fn form() -> String {
        format!("[{}, ...]", T::form())
    }

    fn from_value(value: &Value) -> Result<Self, String> {
        match value {
            Value::List(items) => items.iter().map(T::from_value).collect(),
            other => Err(format!("expected a list, found {other}")),
        }
    }
}

impl<T: Argument, const N: usize> Argument for [T; N] {
    const UNIT: &'static str = "list";

    fn form() -> String {
        format!("[{}]", vec![T::form(); N].join(", "))
    }

    fn from_value(value: &Value) -> Result<Self, String> {
        let items = Vec::<T>::from_value(value)?;
        let found = items.len();
        items.try_into().map_err(|_| format!("expected a list of {N}, found {found}"))
    }
}

impl Argument for String {
    const UNIT: &'static str = "text";

    fn form() -> String {
        "text".into()
    }

    fn from_value(value: &Value) -> Result<Self, String> {
        match value {
            Value::Text(text) => Ok(text.clone()),
            other => Ok(other.to_string()),
        }
    }
}

impl<Q: Quantity> Outcome for Q {
    const UNIT: &'static str = Q::UNIT;

    fn into_value(self) -> Result<Value, String> {
        let value = self.get().into_value()?;
        // Means of whole things need not be whole, but no quantity is negative.
        if self.get() < 0.0 {
            return Err(format!("these arguments give {value}, and a {} cannot be below zero", Q::NAME));
        }
        Ok(value)
    }
}

impl Outcome for f64 {
    fn into_value(self) -> Result<Value, String> {
        if self.is_finite() { Ok(Value::Number(self)) } else { Err(NO_VALUE.into()) }
    }
}

impl<T: Outcome> Outcome for Vec<T> {
    const UNIT: &'static str = T::UNIT;

    fn into_value(self) -> Result<Value, String> {
        Ok(Value::List(self.into_iter().map(T::into_value).collect::<Result<_, _>>()?))
    }
}

impl<T: Outcome, const N: usize> Outcome for [T; N] {
    const UNIT: &'static str = T::UNIT;

    fn into_value(self) -> Result<Value, String> {
        Vec::from(self).into_value()
    }
}

/// The result of a partial function.
impl<T: Outcome> Outcome for Result<T, String> {
    const UNIT: &'static str = T::UNIT;

    fn into_value(self) -> Result<Value, String> {
        self?.into_value()
    }
}
