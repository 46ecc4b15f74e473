//! The ring of the Princeton Engine: what a pass costs (chapter 2, sections 4.4 and 5.3).

use super::{CLOCK, DESCRIPTOR, LINE_RATE, PROCESSORS};
use crate::models;
use crate::models::registry::Model;
use crate::units::{
    Bytes, Count, Hertz, InstructionRate, Instructions, LineRate, PolygonRate, Processors, Ratio, Words,
};

/// Instructions to pass a datum of `a` words over the distance `d`: write, transport, read, and `b` of overhead
/// (section 5.3).
pub fn pass(a: Words, b: Instructions, d: Processors) -> Instructions {
    Instructions::new((2.0 + d.get()) * a.get()) + b
}

/// Equation 4.6: instructions to pass a datum to the neighbour. Table 4.2 prints 29 for dense sort-last
/// (a = 3, b = 15), where this gives 24; section 6.4 of the document says 24, too.
pub fn neighbour_pass(a: Words, b: Instructions) -> Instructions {
    pass(a, b, Processors::new(1.0))
}

/// The saving of one pass over `d` compared with `d` passes to the neighbour (section 5.3).
pub fn stride_saving(a: Words, b: Instructions, d: Processors) -> Ratio {
    Ratio::new(neighbour_pass(a, b) * d.get() / pass(a, b, d))
}

/// Equation 5.2: the limit of [`stride_saving`] for far passes. The document prints the fraction upside down; its
/// value, 3.7, is this one.
pub fn stride_saving_limit(a: Words, b: Instructions) -> Ratio {
    Ratio::new(3.0 + b.get() / a.get())
}

/// Equation 5.2 as it is printed, upside down: the limit of one pass of distance d over d passes to the neighbour.
///
/// # Errors
/// A datum of no words and no overhead.
pub fn stride_saving_limit_as_printed(a: Words, b: Instructions) -> Result<Ratio, String> {
    let neighbour = neighbour_pass(a, b).get();
    if neighbour > 0.0 {
        Ok(Ratio::new(a.get() / neighbour))
    } else {
        Err("a, b: expected a pass that costs something, found 0 and 0".into())
    }
}

/// Instructions per datum for an all-to-all exchange by passing on around the ring (2.2): one word in, `2n` to pass on
/// and read, shared by n data.
pub fn all_to_all(n: Processors) -> Instructions {
    Instructions::new((1.0 + 2.0 * n.get()) / n.get())
}

/// Cost of a broadcast of `broadcast` instructions per datum relative to [`all_to_all`] (2.2).
pub fn broadcast_to_neighbour(broadcast: Instructions, n: Processors) -> Ratio {
    Ratio::new(broadcast / all_to_all(n))
}

/// Instructions a second of all processors together (2.1).
pub fn aggregate_rate(n: Processors, clock: Hertz) -> InstructionRate {
    InstructionRate::new(n.get() * clock.get())
}

/// Memory of one processor: the fast and the slow one (2.1).
pub fn processor_memory(fast: Bytes, slow: Bytes) -> Bytes {
    fast + slow
}

/// Instructions between two scan lines (2.3).
pub fn line_budget(clock: Hertz, lines: LineRate) -> Instructions {
    Instructions::new(clock.get() / lines.get())
}

/// Instructions per polygon of a machine that executes `rate` and draws `polygons` a second (8.2).
pub fn instructions_per_polygon(rate: InstructionRate, polygons: PolygonRate) -> Instructions {
    Instructions::new(rate.get() / polygons.get())
}

/// Maximum number of passes from a group to the neighbouring group that rasterizes a datum (figure 6-1).
pub fn group_passes(g: Processors) -> Count {
    Count::new(2.0 * g.get() - 1.0)
}

pub(crate) const MODELS: &[Model] = models! {
    "eldridge.pass", "5.3", "instructions of a pass over the distance d":
        pass["a": Words = DESCRIPTOR.0, "b": Instructions = DESCRIPTOR.1, "d": Processors] -> Instructions;
    "eldridge.4.6", "eq 4.6", "instructions of a pass to the neighbour":
        neighbour_pass["a": Words = DESCRIPTOR.0, "b": Instructions = DESCRIPTOR.1] -> Instructions;
    "eldridge.stride-saving", "5.3", "d passes to the neighbour over one pass of distance d":
        stride_saving["a": Words = DESCRIPTOR.0, "b": Instructions = DESCRIPTOR.1, "d": Processors] -> Ratio;
    "eldridge.5.2", "eq 5.2", "best saving by long passes; printed upside down":
        stride_saving_limit["a": Words = DESCRIPTOR.0, "b": Instructions = DESCRIPTOR.1] -> Ratio;
    "eldridge.5.2-as-printed", "eq 5.2", "the same as printed, upside down: a / (3a + b)":
        stride_saving_limit_as_printed["a": Words = DESCRIPTOR.0, "b": Instructions = DESCRIPTOR.1]
            -> Result<Ratio, String>;
    "eldridge.all-to-all", "2.2", "instructions per datum, all to all by neighbour passes":
        all_to_all["n": Processors = PROCESSORS] -> Instructions;
    "eldridge.broadcast-to-neighbour", "2.2", "cost of a broadcast over that of neighbour passes":
        broadcast_to_neighbour["broadcast": Instructions = 7.0, "n": Processors = PROCESSORS] -> Ratio;
    "eldridge.aggregate-rate", "2.1", "instructions a second of all processors":
        aggregate_rate["n": Processors = PROCESSORS, "clock": Hertz = CLOCK] -> InstructionRate;
    "eldridge.processor-memory", "2.1", "fast and slow memory of a processor":
        processor_memory["fast": Bytes, "slow": Bytes] -> Bytes;
    "eldridge.line-budget", "2.3", "instructions between two scan lines":
        line_budget["clock": Hertz = CLOCK, "lines": LineRate = LINE_RATE] -> Instructions;
    "eldridge.instructions-per-polygon", "8.2", "instructions executed per polygon drawn":
        instructions_per_polygon["rate": InstructionRate, "polygons": PolygonRate] -> Instructions;
    "eldridge.group-passes", "fig 6-1", "most passes from a group to its neighbour that rasterizes":
        group_passes["g": Processors] -> Count;
};
