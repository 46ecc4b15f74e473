//! Arithmetic that several documents share.

use std::iter::Sum;
use std::ops::Mul;

use crate::models;
use crate::models::registry::{Glossary, Model};
use crate::units::{
    Amperes, Bits, Bytes, BytesPerSecond, Count, FrameRate, Hertz, Length, PixelRate, Pixels, PolygonRate,
    Polygons, Quantity, Ratio, Seconds, SquareMetres, Volts, Watts,
};

/// Bandwidth of a bus or memory `width` bits wide that transfers `transfers` times a clock.
pub fn bandwidth(width: Bits, clock: Hertz, transfers: Count) -> BytesPerSecond {
    BytesPerSecond::new(Bytes::from(width).get() * clock.get() * transfers.get())
}

/// Triangles a second through a bus of [`bandwidth`], `item` bytes each.
pub fn bus_polygon_rate(width: Bits, clock: Hertz, transfers: Count, item: Bytes) -> PolygonRate {
    bandwidth(width, clock, transfers) / item
}

/// Triangles a second at a `bandwidth`, `item` bytes each.
pub fn polygons_by_bandwidth(bandwidth: BytesPerSecond, item: Bytes) -> PolygonRate {
    bandwidth / item
}

/// Bandwidth that `rate` triangles a second take, `item` bytes each.
pub fn traffic(rate: PolygonRate, item: Bytes) -> BytesPerSecond {
    rate * item
}

/// Clock at which a bus of `width` bits carries `rate` triangles a second, `item` bytes each.
pub fn bus_clock(rate: PolygonRate, item: Bytes, width: Bits) -> Hertz {
    Hertz::new((rate * item).get() / Bytes::from(width).get())
}

/// Clock rate of a period.
pub fn clock_of_period(period: Seconds) -> Hertz {
    Hertz::new(1.0 / period.get())
}

/// Time of `clocks` periods of a clock.
pub fn time_of_clocks(clocks: Count, clock: Hertz) -> Seconds {
    Seconds::new(clocks.get() / clock.get())
}

/// Time to send `size` at a `bandwidth`.
pub fn transfer_time(size: Bytes, bandwidth: BytesPerSecond) -> Seconds {
    size / bandwidth
}

/// Polygons a second at a frame rate.
pub fn polygon_rate(polygons: Polygons, fps: FrameRate) -> PolygonRate {
    polygons * fps
}

/// Pixels a second of a screen at a frame rate.
pub fn pixel_rate(width: Length, height: Length, fps: FrameRate) -> PixelRate {
    Pixels::new(width.get() * height.get()) * fps
}

/// A part over the whole, or any quantity over another of its kind.
pub fn share(part: Ratio, whole: Ratio) -> Ratio {
    Ratio::new(part / whole)
}

/// The share of `before` that is saved if `after` remains.
pub fn saving(before: Ratio, after: Ratio) -> Ratio {
    Ratio::new(1.0 - after / before)
}

/// The increase from `before` to `after`, relative to `before`.
pub fn increase(before: Ratio, after: Ratio) -> Ratio {
    Ratio::new(after / before - 1.0)
}

/// `before` over `after`.
pub fn speed_up(before: Ratio, after: Ratio) -> Ratio {
    Ratio::new(before / after)
}

/// `part` of `whole` in percent, truncated as chip tools print it.
pub fn percent_cut_off(part: Ratio, whole: Ratio) -> Ratio {
    Ratio::new((100.0 * part.get() / whole.get()).floor() / 100.0)
}

/// A linear function A x + B y + C of the screen.
pub fn linear([a, b, c]: [f64; 3], at: [f64; 2]) -> f64 {
    a * at[0] + b * at[1] + c
}

/// The sum of `times[i]` items of `each[i]`: fields of a record, instructions of a listing.
///
/// # Errors
/// Lists of different lengths.
pub fn total<Q: Quantity + Sum + Mul<f64, Output = Q>>(times: Vec<Count>, each: Vec<Q>) -> Result<Q, String> {
    if times.len() != each.len() {
        return Err(format!(
            "times, each: expected lists of the same length, found {} and {}",
            times.len(),
            each.len()
        ));
    }
    Ok(times.into_iter().zip(each).map(|(t, e)| e * t.get()).sum())
}

/// Electric power.
pub fn power(current: Amperes, tension: Volts) -> Watts {
    current * tension
}

/// Thousandths of a millionth of an acre, an area for chips.
pub fn nanoacres(number: Ratio) -> SquareMetres {
    /// Square metres of the international acre.
    const ACRE: f64 = 4_046.856_422_4;
    SquareMetres::new(number.get() * 1e-9 * ACRE)
}

pub(crate) const GLOSSARY: Glossary = Glossary {
    group: "common",
    document: None,
    symbols: &[
        ("after", "what is left, or the time afterwards"),
        ("bandwidth", "bandwidth"),
        ("before", "what there was, or the time before"),
        ("clock", "clock rate"),
        ("clocks", "periods of the clock"),
        ("current", "electric current"),
        ("each", "size of a field of each kind"),
        ("fps", "pictures a second"),
        ("height", "height of the screen"),
        ("item", "bytes of a triangle"),
        ("number", "nanoacres"),
        ("part", "the part"),
        ("period", "time of one period"),
        ("polygons", "polygons of a picture"),
        ("rate", "triangles a second"),
        ("size", "bytes to send"),
        ("tension", "voltage"),
        ("times", "fields of each kind"),
        ("transfers", "transfers in a clock"),
        ("whole", "the whole"),
        ("width", "width of the bus"),
        ("common.pixel-rate/width", "width of the screen"),
    ],
    assumptions: &[],
};

pub(crate) const MODELS: &[Model] = models! {
    "common.bandwidth", "all", "bandwidth of a bus":
        bandwidth["width": Bits, "clock": Hertz, "transfers": Count = 1.0] -> BytesPerSecond;
    "common.bus-polygon-rate", "001 4.6", "triangles a second through a bus":
        bus_polygon_rate["width": Bits, "clock": Hertz, "transfers": Count = 1.0, "item": Bytes = 64.0] -> PolygonRate;
    "common.polygons-by-bandwidth", "001 6.2", "triangles a second at a bandwidth":
        polygons_by_bandwidth["bandwidth": BytesPerSecond, "item": Bytes = 64.0] -> PolygonRate;
    "common.traffic", "001 3.2.11", "bandwidth that triangles a second take":
        traffic["rate": PolygonRate, "item": Bytes] -> BytesPerSecond;
    "common.bus-clock", "001 4.6", "clock at which a bus carries a number of triangles a second":
        bus_clock["rate": PolygonRate, "item": Bytes = 64.0, "width": Bits = 64.0] -> Hertz;
    "common.clock-of-period", "001 fig 4.11", "clock rate of a period":
        clock_of_period["period": Seconds] -> Hertz;
    "common.time-of-clocks", "001 4.5.2", "time of a number of clocks":
        time_of_clocks["clocks": Count, "clock": Hertz] -> Seconds;
    "common.transfer-time", "004 1", "time to send a number of bytes":
        transfer_time["size": Bytes, "bandwidth": BytesPerSecond] -> Seconds;
    "common.polygon-rate", "all", "polygons a second":
        polygon_rate["polygons": Polygons, "fps": FrameRate] -> PolygonRate;
    "common.pixel-rate", "002 1.1", "pixels a second of a screen":
        pixel_rate["width": Length, "height": Length, "fps": FrameRate] -> PixelRate;
    "common.share", "all", "a part over the whole":
        share["part": Ratio, "whole": Ratio] -> Ratio;
    "common.saving", "all", "share that is saved":
        saving["before": Ratio, "after": Ratio] -> Ratio;
    "common.increase", "all", "share that is added":
        increase["before": Ratio, "after": Ratio] -> Ratio;
    "common.speed-up", "all", "before over after":
        speed_up["before": Ratio, "after": Ratio] -> Ratio;
    "common.percent-cut-off", "001 fig 4.11", "share in whole percents, truncated":
        percent_cut_off["part": Ratio, "whole": Ratio] -> Ratio;
    "common.record-bytes", "all", "bytes of a record with a number of fields of each size":
        total["times": Vec<Count>, "each": Vec<Bytes>] -> Result<Bytes, String>;
    "common.record-bits", "all", "bits of a record with a number of fields of each width":
        total["times": Vec<Count>, "each": Vec<Bits>] -> Result<Bits, String>;
    "common.power", "001 4.2.1", "electric power":
        power["current": Amperes, "tension": Volts] -> Watts;
    "common.nanoacres", "001 1.1", "area of a number of nanoacres":
        nanoacres["number": Ratio = 1.0] -> SquareMetres;
};
