//! Chapters 8 and 9: benchmarks and accounting of the renderer on the Princeton Engine. It works in step with the video
//! output: a whole number of polygons, passes or pixels per scan line.

use super::{CLOCK, LINE_BUDGET, LINE_RATE, PROCESSORS};
use crate::models;
use crate::models::registry::Model;
use crate::units::{
    Count, FrameRate, Hertz, InstructionRate, Instructions, LineRate, OperationRate, Percent, PixelRate,
    Pixels, PolygonRate, Polygons, Processors, Ratio,
};

/// Processors that have a column of the screen (8.1.3).
const COLUMNS: f64 = 768.0;

/// Scan lines a second (7.6).
pub fn line_rate(lines: Count, fps: FrameRate) -> LineRate {
    LineRate::new(lines.get() * fps.get())
}

/// Pixels a second of the video signal (8.1.3).
pub fn video_pixel_rate(columns: Pixels, lines: Count, fps: FrameRate) -> PixelRate {
    columns * line_rate(lines, fps)
}

/// Equations 8.1 and 8.2: polygons transformed a second, one in `lines_per_polygon` scan lines on every processor.
pub fn geometry_rate(n: Processors, lines_per_polygon: Count, lines: LineRate) -> PolygonRate {
    PolygonRate::new(n.get() / lines_per_polygon.get() * lines.get())
}

/// Equation 8.3: passes from neighbour to neighbour per second.
pub fn pass_rate(n: Processors, passes: Count, lines: LineRate) -> PolygonRate {
    PolygonRate::new(n.get() * passes.get() * lines.get())
}

/// Equation 8.4: polygons communicated a second if each travels `distance` passes.
pub fn communication_rate(
    n: Processors,
    passes: Count,
    lines: LineRate,
    distance: Processors,
) -> PolygonRate {
    pass_rate(n, passes, lines) / distance.get()
}

/// Equations 8.5 and 8.6: pixels a second, `pixels` of them a line on every processor with a column.
pub fn line_fill_rate(columns: Processors, pixels: Pixels, lines: LineRate) -> PixelRate {
    pixels * lines * columns.get()
}

/// Equations 8.7 and 8.8: pixels a second if work need not align with scan lines.
pub fn fill_rate(n: Processors, clock: Hertz, per_pixel: Instructions) -> PixelRate {
    PixelRate::new(n.get() * clock.get() / per_pixel.get())
}

/// Equations 8.9 and 8.10: polygons of `area` pixels a second, where the share `efficiency` of the pixels tested lies
/// inside.
pub fn raster_rate(
    columns: Processors,
    pixels: Pixels,
    lines: LineRate,
    efficiency: Ratio,
    area: Pixels,
) -> PolygonRate {
    PolygonRate::new(line_fill_rate(columns, pixels, lines).get() * efficiency.get() / area.get())
}

/// Fill rate over the pixel rate of the video signal (8.1.3).
pub fn fill_to_video(columns: Processors, pixels: Pixels, line_count: Count, fps: FrameRate) -> Ratio {
    let lines = line_rate(line_count, fps);
    Ratio::new(
        line_fill_rate(columns, pixels, lines)
            / video_pixel_rate(Pixels::new(columns.get()), line_count, fps),
    )
}

/// Equation 8.11: instructions of geometry per polygon.
pub fn geometry_instructions(budget: Instructions, lines_per_polygon: Count) -> Instructions {
    budget * lines_per_polygon.get()
}

/// Equation 8.13: instructions of a pass, all processors together.
pub fn machine_pass(budget: Instructions, passes: Count, n: Processors) -> Instructions {
    budget / passes.get() * n.get()
}

/// Equation 8.14: instructions of communication per polygon, for `passes_per_polygon` passes of the whole ring.
pub fn communication_instructions(
    budget: Instructions,
    passes: Count,
    n: Processors,
    passes_per_polygon: Ratio,
) -> Instructions {
    machine_pass(budget, passes, n) * passes_per_polygon.get()
}

/// Equations 8.12 and 8.15: instructions a second that `polygons` a frame take.
pub fn work_rate(polygons: Polygons, per_polygon: Instructions, fps: FrameRate) -> InstructionRate {
    per_polygon * polygons.get() * fps
}

/// Equation 8.16: instructions to rasterize a slice: half a line to fetch the polygon, then `height` pixels.
pub fn slice_instructions(
    budget: Instructions,
    fetch: Ratio,
    height: Pixels,
    pixels: Pixels,
) -> Instructions {
    budget * (fetch.get() + height / pixels)
}

/// Equation 8.17: instructions a second of rasterization, where the fullest processor has `slices` a frame and all
/// others wait. Only 360 closes the accounting; the text before it has 460, the captions 364 and 370.
pub fn raster_work_rate(
    slices: Count,
    per_slice: Instructions,
    n: Processors,
    fps: FrameRate,
) -> InstructionRate {
    per_slice * (slices.get() * n.get()) * fps
}

/// The accounting of section 8.2: the sum of the three stages as printed, in billions with two decimals.
pub fn accounted_rate(
    geometry: InstructionRate,
    communication: InstructionRate,
    raster: InstructionRate,
) -> InstructionRate {
    let printed = |rate: InstructionRate| InstructionRate::new((rate.get() / 1e7).round() * 1e7);
    printed(geometry) + printed(communication) + printed(raster)
}

/// `rate` as a share of all instructions between scan lines (8.2).
pub fn share_of_line_time(
    rate: InstructionRate,
    n: Processors,
    budget: Instructions,
    lines: LineRate,
) -> Ratio {
    Ratio::new(rate / (budget * n.get() * lines))
}

/// A row of table 8.1: visible polygons a frame, and the sum of the phases' percentages.
pub fn table_row(rate: PolygonRate, fps: FrameRate, phases: Vec<Percent>) -> [f64; 2] {
    [(rate / fps).get(), phases.into_iter().sum::<Percent>().get()]
}

/// The share of rasterization in table 8.1: what the other two phases leave of a frame, idling included.
pub fn rest(geometry: Percent, communication: Percent) -> Percent {
    Percent::new(100.0) - geometry - communication
}

/// Operations a second of all processors, `per_line` on each between two scan lines (8.3).
pub fn operation_rate(per_line: Count, n: Processors, lines: LineRate) -> OperationRate {
    OperationRate::new(per_line.get() * n.get() * lines.get())
}

/// Instructions between scan lines per pixel drawn in them (8.3).
pub fn line_instructions_per_pixel(budget: Instructions, pixels: Pixels) -> Instructions {
    budget / pixels.get()
}

pub(crate) const MODELS: &[Model] = models! {
    "eldridge.line-rate", "7.6", "scan lines a second":
        line_rate["lines": Count = 525.0, "fps": FrameRate = 30.0] -> LineRate;
    "eldridge.video-pixel-rate", "8.1.3", "pixels a second of the video signal":
        video_pixel_rate["columns": Pixels = COLUMNS, "lines": Count = 525.0, "fps": FrameRate = 30.0] -> PixelRate;
    "eldridge.8.1", "eq 8.1, 8.2", "polygons transformed a second":
        geometry_rate["n": Processors = PROCESSORS, "lines_per_polygon": Count = 7.0, "lines": LineRate = LINE_RATE]
            -> PolygonRate;
    "eldridge.8.3", "eq 8.3", "polygon passes a second":
        pass_rate["n": Processors = PROCESSORS, "passes": Count = 5.0, "lines": LineRate = LINE_RATE] -> PolygonRate;
    "eldridge.8.4", "eq 8.4", "polygons communicated a second":
        communication_rate["n": Processors = PROCESSORS, "passes": Count = 5.0, "lines": LineRate = LINE_RATE,
            "distance": Processors = 512.0] -> PolygonRate;
    "eldridge.8.5", "eq 8.5, 8.6", "pixels a second, bound to scan lines":
        line_fill_rate["columns": Processors = COLUMNS, "pixels": Pixels, "lines": LineRate = LINE_RATE] -> PixelRate;
    "eldridge.8.7", "eq 8.7, 8.8", "pixels a second, not bound to scan lines":
        fill_rate["n": Processors = PROCESSORS, "clock": Hertz = CLOCK, "R": Instructions] -> PixelRate;
    "eldridge.8.9", "eq 8.9, 8.10", "polygons rasterized a second":
        raster_rate["columns": Processors = COLUMNS, "pixels": Pixels, "lines": LineRate = LINE_RATE,
            "efficiency": Ratio = 0.5, "A": Pixels = super::AREA] -> PolygonRate;
    "eldridge.fill-to-video", "8.1.3", "fill rate over the video signal's pixel rate":
        fill_to_video["columns": Processors = COLUMNS, "pixels": Pixels = 8.0, "line_count": Count = 525.0,
            "fps": FrameRate = 30.0] -> Ratio;
    "eldridge.8.11", "eq 8.11", "instructions of geometry per polygon":
        geometry_instructions["budget": Instructions = LINE_BUDGET, "lines_per_polygon": Count = 11.0] -> Instructions;
    "eldridge.8.12", "eq 8.12, 8.15", "instructions a second for the polygons of a frame":
        work_rate["polygons": Polygons, "per_polygon": Instructions, "fps": FrameRate = 6.0] -> InstructionRate;
    "eldridge.8.13", "eq 8.13", "instructions of a pass, whole machine":
        machine_pass["budget": Instructions = LINE_BUDGET, "passes": Count = 5.0, "n": Processors = PROCESSORS]
            -> Instructions;
    "eldridge.8.14", "eq 8.14", "instructions of communication per polygon":
        communication_instructions["budget": Instructions = LINE_BUDGET, "passes": Count = 5.0,
            "n": Processors = PROCESSORS, "passes_per_polygon": Ratio = 0.6] -> Instructions;
    "eldridge.8.16", "eq 8.16", "instructions to rasterize a slice":
        slice_instructions["budget": Instructions = LINE_BUDGET, "fetch": Ratio = 0.5, "height": Pixels = 4.0,
            "pixels": Pixels = 4.0] -> Instructions;
    "eldridge.8.17", "eq 8.17", "instructions a second of rasterization":
        raster_work_rate["slices": Count = 360.0, "per_slice": Instructions = 1365.0, "n": Processors = PROCESSORS,
            "fps": FrameRate = 6.0] -> InstructionRate;
    "eldridge.accounted-rate", "8.2", "sum of the three stages as printed":
        accounted_rate["geometry": InstructionRate, "communication": InstructionRate, "raster": InstructionRate]
            -> InstructionRate;
    "eldridge.share-of-line-time", "8.2", "share of all instructions between scan lines":
        share_of_line_time["rate": InstructionRate, "n": Processors = PROCESSORS,
            "budget": Instructions = LINE_BUDGET, "lines": LineRate = LINE_RATE] -> Ratio;
    "eldridge.table-8.1-row", "table 8.1", "visible polygons a frame, and the sum of the percentages":
        table_row["rate": PolygonRate, "fps": FrameRate, "phases": Vec<Percent>] -> [f64; 2];
    "eldridge.table-8.1-rest", "table 8.1", "percent of a frame that geometry and communication leave":
        rest["geometry": Percent, "communication": Percent] -> Percent;
    "eldridge.operation-rate", "8.3", "operations a second of all processors":
        operation_rate["per_line": Count = 2.0, "n": Processors = PROCESSORS, "lines": LineRate = LINE_RATE]
            -> OperationRate;
    "eldridge.instructions-per-pixel", "8.3", "instructions between scan lines per pixel":
        line_instructions_per_pixel["budget": Instructions = LINE_BUDGET, "pixels": Pixels = 8.0] -> Instructions;
};
