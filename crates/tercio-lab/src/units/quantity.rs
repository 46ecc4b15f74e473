//! The quantities themselves.

use std::fmt;
use std::iter::Sum;
use std::ops::{Add, Div, Mul, Sub};
use std::str::FromStr;

use super::parse::{self, UnitError};

/// The values that a quantity can have; NaN and the infinities are never among them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Domain {
    /// Zero or more.
    NonNegative,
    /// More than zero.
    Positive,
    /// 0, 1, 2, ...
    Whole,
}

impl Domain {
    /// Whether `value` is in the domain.
    pub fn holds(self, value: f64) -> bool {
        value.is_finite()
            && match self {
                Self::NonNegative => value >= 0.0,
                Self::Positive => value > 0.0,
                Self::Whole => value >= 0.0 && value.fract() == 0.0,
            }
    }

    /// The domain in words that complete "expected ...".
    pub fn describe(self) -> &'static str {
        match self {
            Self::NonNegative => "a number not below zero",
            Self::Positive => "a number above zero",
            Self::Whole => "a whole number not below zero",
        }
    }
}

/// A number with a unit.
pub trait Quantity: Copy + fmt::Debug + fmt::Display + FromStr<Err = UnitError> {
    /// What is measured, as messages name it: "clock rate".
    const NAME: &'static str;
    /// The base unit's symbol; empty for a plain ratio.
    const UNIT: &'static str;
    /// The valid values.
    const DOMAIN: Domain;

    /// The quantity of `value` base units. The domain is checked where texts and arguments are read, not here.
    fn new(value: f64) -> Self;

    /// The value in base units.
    fn get(self) -> f64;

    /// The quantity of `value` base units, if it is valid.
    ///
    /// # Errors
    /// [`UnitError::Domain`] if the value is outside of [`Self::DOMAIN`].
    fn checked(value: f64) -> Result<Self, UnitError> {
        if Self::DOMAIN.holds(value) {
            Ok(Self::new(value))
        } else {
            Err(UnitError::Domain { name: Self::NAME, expected: Self::DOMAIN.describe(), found: value })
        }
    }
}

macro_rules! quantities {
    ($($(#[$doc:meta])* $type:ident, $name:literal, $unit:literal, $domain:ident;)*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
        pub struct $type(f64);

        impl $type {
            /// The quantity of `value` base units.
            pub const fn new(value: f64) -> Self {
                Self(value)
            }

            /// The value in base units.
            pub const fn get(self) -> f64 {
                self.0
            }
        }

        impl Quantity for $type {
            const NAME: &'static str = $name;
            const UNIT: &'static str = $unit;
            const DOMAIN: Domain = Domain::$domain;

            fn new(value: f64) -> Self {
                Self(value)
            }

            fn get(self) -> f64 {
                self.0
            }
        }

        impl Add for $type {
            type Output = Self;
            fn add(self, other: Self) -> Self {
                Self(self.0 + other.0)
            }
        }

        impl Sub for $type {
            type Output = Self;
            fn sub(self, other: Self) -> Self {
                Self(self.0 - other.0)
            }
        }

        impl Mul<f64> for $type {
            type Output = Self;
            fn mul(self, factor: f64) -> Self {
                Self(self.0 * factor)
            }
        }

        impl Div<f64> for $type {
            type Output = Self;
            fn div(self, divisor: f64) -> Self {
                Self(self.0 / divisor)
            }
        }

        impl Div for $type {
            type Output = f64;
            fn div(self, other: Self) -> f64 {
                self.0 / other.0
            }
        }

        impl Sum for $type {
            fn sum<I: Iterator<Item = Self>>(items: I) -> Self {
                items.fold(Self(0.0), Add::add)
            }
        }

        impl fmt::Display for $type {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                // The number alone takes width and precision from the format.
                fmt::Display::fmt(&self.0, f)?;
                if !$unit.is_empty() {
                    write!(f, " {}", $unit)?;
                }
                Ok(())
            }
        }

        impl FromStr for $type {
            type Err = UnitError;
            fn from_str(text: &str) -> Result<Self, UnitError> {
                parse::quantity(text)
            }
        }

        impl<'de> serde::Deserialize<'de> for $type {
            fn deserialize<D: serde::Deserializer<'de>>(source: D) -> Result<Self, D::Error> {
                source.deserialize_any(parse::QuantityVisitor::<Self>::new())
            }
        }

        impl serde::Serialize for $type {
            fn serialize<S: serde::Serializer>(&self, target: S) -> Result<S::Ok, S::Error> {
                target.serialize_f64(self.0)
            }
        }
    )*};
}

quantities! {
    /// A ratio of two quantities of the same kind, a factor, a share.
    Ratio, "ratio", "", NonNegative;
    /// A ratio in hundredths, where a document uses percent.
    Percent, "percentage", "%", NonNegative;
    /// A number of things.
    Count, "count", "", Whole;
    /// Processors; also positions on a ring and hops between neighbours. Optima of formulas need not be whole.
    Processors, "number of processors", "processor", Positive;
    /// Polygons or triangles; means need not be whole.
    Polygons, "number of polygons", "polygon", NonNegative;
    /// Vertices.
    Vertices, "number of vertices", "vertex", NonNegative;
    /// Segments: the horizontal runs of pixels of a polygon, one a scan line.
    Segments, "number of segments", "segment", NonNegative;
    /// Pixels as a number, which is an area.
    Pixels, "number of pixels", "pixel", NonNegative;
    /// A length on the screen, in pixels' sides.
    Length, "length on the screen", "px", NonNegative;
    /// Words of a machine's own word size.
    Words, "number of words", "word", NonNegative;
    /// Executed instructions.
    Instructions, "number of instructions", "instr", NonNegative;
    /// Clock or memory cycles.
    Cycles, "number of cycles", "cycle", NonNegative;
    /// Time.
    Seconds, "time", "s", NonNegative;
    /// Clock rate.
    Hertz, "clock rate", "Hz", Positive;
    /// Memory, message and file sizes.
    Bytes, "size", "B", NonNegative;
    /// Widths of buses and fields.
    Bits, "width", "bit", NonNegative;
    /// Bandwidth.
    BytesPerSecond, "bandwidth", "B/s", Positive;
    /// Pictures a second.
    FrameRate, "frame rate", "frame/s", Positive;
    /// Scan lines a second.
    LineRate, "line rate", "line/s", Positive;
    /// Polygons a second.
    PolygonRate, "polygon rate", "polygon/s", NonNegative;
    /// Pixels a second.
    PixelRate, "pixel rate", "pixel/s", NonNegative;
    /// Instructions a second.
    InstructionRate, "instruction rate", "instr/s", NonNegative;
    /// Arithmetic operations a second.
    OperationRate, "operation rate", "op/s", NonNegative;
    /// Area of silicon, in the unit of document 003.
    SquareInches, "chip area", "in2", NonNegative;
    /// Area.
    SquareMetres, "area", "m2", NonNegative;
    /// Electric current.
    Amperes, "current", "A", NonNegative;
    /// Voltage.
    Volts, "tension", "V", NonNegative;
    /// Power.
    Watts, "power", "W", NonNegative;
}
