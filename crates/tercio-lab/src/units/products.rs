//! Products and quotients of different quantities.

use std::ops::{Div, Mul};

use super::{
    Amperes, Bits, Bytes, BytesPerSecond, Cycles, FrameRate, Hertz, InstructionRate, Instructions, LineRate,
    PixelRate, Pixels, PolygonRate, Polygons, Seconds, Volts, Watts,
};

/// Lines `left * right = product` (and `right * left`) and `left / right = quotient`.
macro_rules! relations {
    ($($left:ident $operation:tt $right:ident = $result:ident;)*) => {
        $(relations!(@one $left $operation $right = $result);)*
    };
    (@one $left:ident * $right:ident = $result:ident) => {
        impl Mul<$right> for $left {
            type Output = $result;
            fn mul(self, other: $right) -> $result {
                $result::new(self.get() * other.get())
            }
        }

        impl Mul<$left> for $right {
            type Output = $result;
            fn mul(self, other: $left) -> $result {
                $result::new(self.get() * other.get())
            }
        }
    };
    (@one $left:ident / $right:ident = $result:ident) => {
        impl Div<$right> for $left {
            type Output = $result;
            fn div(self, other: $right) -> $result {
                $result::new(self.get() / other.get())
            }
        }
    };
}

relations! {
    Cycles / Hertz = Seconds;
    Instructions / Hertz = Seconds;
    Instructions / InstructionRate = Seconds;
    Bytes / BytesPerSecond = Seconds;
    Bytes / Seconds = BytesPerSecond;
    Bytes * FrameRate = BytesPerSecond;
    Bytes * PolygonRate = BytesPerSecond;
    BytesPerSecond / Bytes = PolygonRate;
    Pixels * FrameRate = PixelRate;
    Pixels * LineRate = PixelRate;
    Pixels / Seconds = PixelRate;
    Polygons * FrameRate = PolygonRate;
    Polygons * LineRate = PolygonRate;
    Polygons / Seconds = PolygonRate;
    PolygonRate / FrameRate = Polygons;
    Instructions * FrameRate = InstructionRate;
    Instructions * LineRate = InstructionRate;
    Amperes * Volts = Watts;
}

impl From<Bits> for Bytes {
    fn from(bits: Bits) -> Self {
        Self::new(bits.get() / 8.0)
    }
}

impl From<FrameRate> for Seconds {
    /// The time of one frame.
    fn from(rate: FrameRate) -> Self {
        Self::new(1.0 / rate.get())
    }
}
