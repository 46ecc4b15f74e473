//! Numbers with a unit and a source, as they stand in a description.

use std::fmt;
use std::marker::PhantomData;

use serde::de::{self, Deserializer, Visitor};
use serde::{Deserialize, Serialize};

/// What a number measures: its base unit and the units in which it may be written.
pub trait Quantity {
    /// What it is, for messages: "a frequency".
    const WHAT: &'static str;
    /// Units by name with their size in base units; the first is the base unit.
    const UNITS: &'static [(&'static str, f64)];
    /// True if only whole numbers make sense.
    const WHOLE: bool = false;
}

/// Declares a quantity.
macro_rules! quantity {
    ($(#[$doc:meta])* $name:ident, $what:literal, [$(($unit:literal, $size:expr)),+], $whole:literal) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub enum $name {}
        impl Quantity for $name {
            const WHAT: &'static str = $what;
            const UNITS: &'static [(&'static str, f64)] = &[$(($unit, $size)),+];
            const WHOLE: bool = $whole;
        }
    };
}

quantity!(
    /// A number of things.
    Count, "a number without a unit", [("", 1.0)], true);
quantity!(
    /// A time.
    Seconds, "a time", [("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9), ("ps", 1e-12)], false);
quantity!(
    /// A clock.
    Hertz, "a frequency", [("Hz", 1.0), ("kHz", 1e3), ("MHz", 1e6), ("GHz", 1e9)], false);
quantity!(
    /// A size of memory or of a message; `kB` is 1000 and `KiB` is 1024 bytes.
    Bytes, "a size in bytes", [("B", 1.0), ("kB", 1e3), ("MB", 1e6), ("GB", 1e9), ("KiB", 1024.0),
        ("MiB", 1_048_576.0), ("GiB", 1_073_741_824.0), ("bit", 0.125)], false);
quantity!(
    /// A bandwidth.
    BytesPerSecond, "a bandwidth", [("B/s", 1.0), ("kB/s", 1e3), ("MB/s", 1e6), ("GB/s", 1e9),
        ("Mbit/s", 1.25e5), ("Gbit/s", 1.25e8)], false);
quantity!(
    /// A rate of things done.
    PerSecond, "a rate", [("/s", 1.0), ("k/s", 1e3), ("M/s", 1e6), ("G/s", 1e9)], false);
quantity!(
    /// A part of a whole.
    Share, "a share", [("", 1.0), ("%", 0.01)], false);

/// What one operation costs: cycles of the machine's clock, or a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cost {
    /// Cycles of the processors' clock.
    Cycles(f64),
    /// Seconds.
    Seconds(f64),
}

/// A number in base units, and where it comes from.
#[derive(Debug)]
pub struct Sourced<Q> {
    /// The number in base units.
    pub value: f64,
    /// The number as it was written.
    pub text: String,
    /// Document and place, data sheet, or what it was fitted to.
    pub source: String,
    quantity: PhantomData<Q>,
}

impl<Q> Clone for Sourced<Q> {
    fn clone(&self) -> Self {
        Self::new(self.value, self.text.clone(), self.source.clone())
    }
}

impl<Q> PartialEq for Sourced<Q> {
    fn eq(&self, o: &Self) -> bool {
        self.value == o.value && self.text == o.text && self.source == o.source
    }
}

impl<Q> Sourced<Q> {
    /// A number in base units with the text that shows it.
    pub fn new(value: f64, text: String, source: String) -> Self {
        Self { value, text, source, quantity: PhantomData }
    }
}

/// As the file has it, before the unit is understood.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Written<T> {
    pub value: T,
    pub source: Source,
}

/// Where a number comes from; never empty.
pub(super) struct Source(pub String);

impl<'de> Deserialize<'de> for Source {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        let text = String::deserialize(d)?;
        if text.trim().is_empty() {
            return Err(de::Error::custom("expected where the number comes from, found nothing"));
        }
        Ok(Self(text))
    }
}

/// A number, with or without a unit, as text.
struct NumberText(String);

impl<'de> Deserialize<'de> for NumberText {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        struct Any;
        impl Visitor<'_> for Any {
            type Value = NumberText;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a number, or text with a number and a unit")
            }

            fn visit_i64<E: de::Error>(self, v: i64) -> Result<NumberText, E> {
                Ok(NumberText(v.to_string()))
            }

            fn visit_f64<E: de::Error>(self, v: f64) -> Result<NumberText, E> {
                Ok(NumberText(v.to_string()))
            }

            fn visit_str<E: de::Error>(self, v: &str) -> Result<NumberText, E> {
                Ok(NumberText(v.to_string()))
            }
        }
        d.deserialize_any(Any)
    }
}

/// A number of one quantity; errors are made here, where the place in the file is known.
pub(super) struct Value<Q> {
    number: f64,
    text: String,
    quantity: PhantomData<Q>,
}

impl<'de, Q: Quantity> Deserialize<'de> for Value<Q> {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        let NumberText(text) = NumberText::deserialize(d)?;
        let number = in_base_units(&text, Q::WHAT, Q::UNITS).map_err(de::Error::custom)?;
        if Q::WHOLE && number.fract() != 0.0 {
            return Err(de::Error::custom(format!("expected a whole number, found \"{text}\"")));
        }
        Ok(Self { number, text, quantity: PhantomData })
    }
}

impl<'de, Q: Quantity> Deserialize<'de> for Sourced<Q> {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        let w = Written::<Value<Q>>::deserialize(d)?;
        Ok(Self::new(w.value.number, w.value.text, w.source.0))
    }
}

impl<'de> Deserialize<'de> for Sourced<Cost> {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        struct CostUnits;
        impl Quantity for CostUnits {
            const WHAT: &'static str = "a cost";
            const UNITS: &'static [(&'static str, f64)] =
                &[("cycles", 1.0), ("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9), ("ps", 1e-12)];
        }
        let w = Written::<Value<CostUnits>>::deserialize(d)?;
        Ok(Self::new(w.value.number, w.value.text, w.source.0))
    }
}

impl Sourced<Cost> {
    /// Cycles or seconds, by the unit that it was written in.
    pub fn cost(&self) -> Cost {
        if self.text.trim_end().ends_with("cycles") { Cost::Cycles(self.value) } else { Cost::Seconds(self.value) }
    }
}

impl<Q: Quantity> Sourced<Q> {
    /// The number rounded to a whole one.
    pub fn whole(&self) -> u64 {
        self.value.round() as u64
    }
}

impl<Q> Serialize for Sourced<Q> {
    fn serialize<S: serde::Serializer>(&self, s: S) -> Result<S::Ok, S::Error> {
        use serde::ser::SerializeStruct;
        let mut fields = s.serialize_struct("Sourced", 2)?;
        fields.serialize_field("value", &self.text)?;
        fields.serialize_field("source", &self.source)?;
        fields.end()
    }
}

impl<Q> fmt::Display for Sourced<Q> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

/// "14 MHz" in base units; finite and not negative.
fn in_base_units(text: &str, what: &str, units: &[(&str, f64)]) -> Result<f64, String> {
    let text = text.trim();
    let end = text.find(|c: char| !(c.is_ascii_digit() || ".+-eE_".contains(c))).unwrap_or(text.len());
    // An exponent needs digits: what remains of "3 e" belongs to the unit.
    let (number, unit) = (text[..end].replace('_', ""), text[end..].trim());
    let names = || units.iter().map(|u| if u.0.is_empty() { "no unit" } else { u.0 }).collect::<Vec<_>>().join(", ");
    let Ok(number) = number.parse::<f64>() else {
        return Err(format!("expected {what} ({}), found \"{text}\"", names()));
    };
    if !number.is_finite() || number < 0.0 {
        return Err(format!("expected {what}, 0 or more, found \"{text}\""));
    }
    match units.iter().find(|u| u.0 == unit) {
        Some(u) => Ok(number * u.1),
        None => {
            let found = if unit.is_empty() { "no unit".into() } else { format!("unit \"{unit}\"") };
            Err(format!("expected {what} in one of {}, found {found} in \"{text}\"", names()))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read<Q: Quantity>(text: &str) -> Result<f64, String> {
        in_base_units(text, Q::WHAT, Q::UNITS)
    }

    #[test]
    fn units_scale() {
        assert_eq!(read::<Hertz>("14 MHz"), Ok(14e6));
        assert_eq!(read::<Bytes>("640 KiB"), Ok(655_360.0));
        assert_eq!(read::<Bytes>("348bit"), Ok(43.5));
        assert_eq!(read::<Count>("1024"), Ok(1024.0));
        assert_eq!(read::<BytesPerSecond>("33.8 Gbit/s"), Ok(33.8 * 1.25e8));
        assert_eq!(read::<Seconds>("1e-3 s"), Ok(1e-3));
        assert_eq!(read::<Seconds>("300 ns"), Ok(300.0 * 1e-9));
    }

    #[test]
    fn wrong_units_and_numbers_are_told() {
        let error = read::<Hertz>("14 MB").unwrap_err();
        assert!(error.contains("a frequency") && error.contains("MHz") && error.contains("\"MB\""), "{error}");
        assert!(read::<Hertz>("14").unwrap_err().contains("no unit"));
        assert!(read::<Bytes>("-1 B").unwrap_err().contains("0 or more"));
        assert!(read::<Bytes>("lots").unwrap_err().contains("found \"lots\""));
        assert!(read::<Bytes>("").is_err());
        assert!(read::<Bytes>("1e999 B").is_err());
    }
}
