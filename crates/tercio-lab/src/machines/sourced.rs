//! Numbers with a unit and a source, as written in a description.

use std::fmt;
use std::marker::PhantomData;

use serde::de::{self, Deserializer, Visitor};
use serde::{Deserialize, Serialize};

use crate::units::{Cycles, Quantity, Seconds, UnitError};

/// A quantity with its source.
#[derive(Debug)]
pub struct Sourced<Q> {
    /// The number in the quantity's base unit.
    pub value: f64,
    /// The number as written.
    pub text: String,
    /// Document and place, data sheet, or what the number was fitted to.
    pub source: String,
    quantity: PhantomData<Q>,
}

/// The cost of one operation, in the unit in which it is written: cycles of the machine's clock, or a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cost {
    /// Cycles of the processors' clock.
    Cycles(Cycles),
    /// Time.
    Time(Seconds),
}

impl<Q> Sourced<Q> {
    /// A number in base units with the text that represents it.
    pub fn new(value: f64, text: String, source: String) -> Self {
        Self { value, text, source, quantity: PhantomData }
    }
}

impl<Q: Quantity> Sourced<Q> {
    /// The number with its unit.
    pub fn get(&self) -> Q {
        Q::new(self.value)
    }

    /// The number rounded to a whole one.
    pub fn whole(&self) -> u64 {
        self.value.round() as u64
    }
}

impl Sourced<Cost> {
    /// The cost by its unit.
    pub fn cost(&self) -> Cost {
        if is_in_cycles(&self.text) {
            Cost::Cycles(Cycles::new(self.value))
        } else {
            Cost::Time(Seconds::new(self.value))
        }
    }
}

fn is_in_cycles(text: &str) -> bool {
    text.trim_end().trim_end_matches('s').ends_with("cycle")
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

impl<Q> fmt::Display for Sourced<Q> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
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

impl<'de, Q: Quantity> Deserialize<'de> for Sourced<Q> {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        let Written { value, source } = Written::<Read<Q>>::deserialize(d)?;
        Ok(Self::new(value.value, value.text, source.0))
    }
}

impl<'de> Deserialize<'de> for Sourced<Cost> {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        let Written { value, source } = Written::<ReadCost>::deserialize(d)?;
        Ok(Self::new(value.0, value.1, source.0))
    }
}

/// The fields as in the file. Errors in their values are reported where their position in the file is known.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Written<T> {
    value: T,
    source: Source,
}

/// The source of a number; never empty.
struct Source(String);

impl<'de> Deserialize<'de> for Source {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        let text = String::deserialize(d)?;
        if text.trim().is_empty() {
            return Err(de::Error::custom("expected where the number comes from, found nothing"));
        }
        Ok(Self(text))
    }
}

/// A quantity with its unit, as read.
struct Read<Q> {
    value: f64,
    text: String,
    quantity: PhantomData<Q>,
}

impl<'de, Q: Quantity> Deserialize<'de> for Read<Q> {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        let NumberText(text) = NumberText::deserialize(d)?;
        let value = with_unit::<Q>(&text).map_err(de::Error::custom)?;
        Ok(Self { value, text, quantity: PhantomData })
    }
}

/// A number of cycles or seconds with its unit.
struct ReadCost(f64, String);

impl<'de> Deserialize<'de> for ReadCost {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        let NumberText(text) = NumberText::deserialize(d)?;
        let value =
            if is_in_cycles(&text) { with_unit::<Cycles>(&text) } else { with_unit::<Seconds>(&text) };
        Ok(Self(value.map_err(de::Error::custom)?, text))
    }
}

/// Reads a number that must have a unit, if its quantity has one.
fn with_unit<Q: Quantity>(text: &str) -> Result<f64, UnitError> {
    if !Q::UNIT.is_empty() && text.parse::<f64>().is_ok() {
        return Err(UnitError::Unit { name: Q::NAME, unit: Q::UNIT, found: String::new() });
    }
    Ok(text.parse::<Q>()?.get())
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::{Bytes, Count, Hertz};

    #[test]
    fn a_number_needs_the_unit_of_its_quantity() {
        assert_eq!(with_unit::<Hertz>("14 MHz"), Ok(14e6));
        assert_eq!(with_unit::<Count>("14"), Ok(14.0));
        assert!(with_unit::<Hertz>("14").unwrap_err().to_string().contains("expected Hz"));
        assert!(with_unit::<Bytes>("14 MHz").unwrap_err().to_string().contains("MHz"));
    }
}
