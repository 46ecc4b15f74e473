//! Rates of buses, video and back ends (chapter 4).

use super::NODE;
use crate::models;
use crate::models::registry::Model;
use crate::units::{
    Bytes, BytesPerSecond, Count, FrameRate, Hertz, Length, LineRate, PolygonRate, Polygons, Ratio, Seconds,
};

/// Equation 4.1: bandwidth of the video output, `depth` bytes a pixel.
pub fn video_bandwidth(width: Length, height: Length, depth: Bytes, fps: FrameRate) -> BytesPerSecond {
    depth * (width.get() * height.get()) * fps
}

/// Lines a second at a pixel clock, `clocks` a line with blanking (4.5.2).
pub fn line_rate(clock: Hertz, clocks: Count) -> LineRate {
    LineRate::new(clock.get() / clocks.get())
}

/// Pictures a second at a pixel clock, with blanking (4.5.2).
pub fn frame_rate(clock: Hertz, clocks: Count, lines: Count) -> FrameRate {
    FrameRate::new(line_rate(clock, clocks).get() / lines.get())
}

/// A frame rate at another clock (4.6).
pub fn scaled_frame_rate(fps: FrameRate, clock: Hertz, from: Hertz) -> FrameRate {
    fps * (clock / from)
}

/// A triangle rate at another clock (4.6).
pub fn scaled_polygon_rate(rate: PolygonRate, clock: Hertz, from: Hertz) -> PolygonRate {
    rate * (clock / from)
}

/// The share of a model's triangles that reaches the back end (4.6).
pub fn back_end_share(rate: PolygonRate, fps: FrameRate, triangles: Polygons) -> Ratio {
    Ratio::new(rate / fps / triangles)
}

/// The fixed time of a transfer, if blocks of `block` bytes have the bandwidth `observed` and very long ones `peak`: a
/// transfer takes `fixed + bytes / peak` (4.5.1 gives the two bandwidths; the model is inferred).
///
/// # Errors
/// An observed bandwidth above the peak.
pub fn transfer_overhead(
    block: Bytes,
    observed: BytesPerSecond,
    peak: BytesPerSecond,
) -> Result<Seconds, String> {
    if observed.get() > peak.get() {
        return Err(format!("observed: expected at most the peak of {peak}, found {observed}"));
    }
    Ok(block / observed - block / peak)
}

/// Bandwidth of blocks of `block` bytes by the same model.
pub fn block_bandwidth(block: Bytes, overhead: Seconds, peak: BytesPerSecond) -> BytesPerSecond {
    block / (overhead + block / peak)
}

pub(crate) const MODELS: &[Model] = models! {
    "hybris.4.1", "eq 4.1", "bandwidth of the video output":
        video_bandwidth["w": Length, "h": Length, "d": Bytes, "f": FrameRate] -> BytesPerSecond;
    "hybris.line-rate", "4.5.2", "lines a second at a pixel clock":
        line_rate["clock": Hertz = 25.175e6, "clocks": Count = 800.0] -> LineRate;
    "hybris.frame-rate", "4.5.2", "pictures a second at a pixel clock":
        frame_rate["clock": Hertz = 25.175e6, "clocks": Count = 800.0, "lines": Count = 525.0] -> FrameRate;
    "hybris.scaled-frame-rate", "4.6", "a frame rate at another clock":
        scaled_frame_rate["fps": FrameRate = 16.0, "clock": Hertz = 100e6, "from": Hertz = 27e6] -> FrameRate;
    "hybris.scaled-polygon-rate", "4.6", "a triangle rate at another clock":
        scaled_polygon_rate["rate": PolygonRate = 4.2e6, "clock": Hertz = 100e6, "from": Hertz = 27e6] -> PolygonRate;
    "hybris.back-end-share", "4.6", "share of the triangles that reaches the back end":
        back_end_share["rate": PolygonRate = 4.2e6, "fps": FrameRate = 16.0, "triangles": Polygons] -> Ratio;
    "hybris.transfer-overhead", "4.5.1", "fixed time of a transfer":
        transfer_overhead["block": Bytes = 4096.0, "observed": BytesPerSecond, "peak": BytesPerSecond]
            -> Result<Seconds, String>;
    "hybris.block-bandwidth", "4.5.1", "bandwidth of transfers with a fixed time each":
        block_bandwidth["block": Bytes = NODE * 64.0, "overhead": Seconds, "peak": BytesPerSecond] -> BytesPerSecond;
};
