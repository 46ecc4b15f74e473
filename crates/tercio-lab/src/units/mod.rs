//! Quantities as types: a number with its unit, its range, and its notation.
//!
//! Every quantity holds an `f64` in its base unit ([`Quantity::UNIT`]): 14 MHz is `Hertz::new(14e6)`. Only equal
//! quantities can be added, dividing two of the same gives a plain number, and the few meaningful products (cycles by
//! clock give time) are in `products`. Texts such as `14 MHz`, `64 KiB` or `0.3 us` are parsed by [`str::parse`] and by
//! `serde` (which also accepts a plain number in the base unit); a text with the wrong unit or a value outside of the
//! quantity's [`Domain`] is an error that says what was expected.

mod parse;
mod products;
mod quantity;

pub use parse::{UnitError, scale};
pub use quantity::{
    Amperes, Bits, Bytes, BytesPerSecond, Count, Cycles, Domain, FrameRate, Hertz, InstructionRate,
    Instructions, Length, LineRate, OperationRate, Percent, PixelRate, Pixels, PolygonRate, Polygons,
    Processors, Quantity, Ratio, Seconds, Segments, SquareInches, SquareMetres, Vertices, Volts, Watts,
    Words,
};
