//! Chapter 6: sort-twice. Descriptors are sent within groups of `g` processors (sort-middle), then the pictures of the
//! n/g groups are composited (sort-last). `p` counts visible polygons from equation 6.5 on.

use super::distribution::pass_root;
use super::ring::{neighbour_pass, pass};
use super::{
    AREA, ASYMMETRY, CLOCK, DESCRIPTOR, DESCRIPTOR_PASS, GEOMETRY, OVERLAP, PIXEL, PROCESSORS, RASTER, SCREEN,
};
use crate::models;
use crate::models::registry::Model;
use crate::units::{
    Bits, Bytes, BytesPerSecond, Count, FrameRate, Hertz, Instructions, Length, Pixels, Polygons, Processors,
    Ratio, Seconds, Words,
};

/// Equation 6.1 with the raster term f A R: sort-middle within groups.
#[expect(clippy::too_many_arguments, reason = "the symbols of the equation")]
pub fn grouped_sort_middle(
    p: Polygons,
    n: Processors,
    g: Processors,
    f: Ratio,
    geometry: Instructions,
    area: Pixels,
    raster: Instructions,
    pass: Instructions,
) -> Instructions {
    (geometry + pass * g.get() + raster * (f.get() * area.get())) * (p.get() / n.get())
}

/// Equation 6.1 as it was printed, with the raster term f A R / o; the scan has f_o for f (A/o).
#[expect(clippy::too_many_arguments, reason = "the symbols of the equation")]
pub fn grouped_sort_middle_as_printed(
    p: Polygons,
    n: Processors,
    g: Processors,
    f: Ratio,
    o: Ratio,
    geometry: Instructions,
    area: Pixels,
    raster: Instructions,
    pass: Instructions,
) -> Instructions {
    grouped_sort_middle(p, n, g, f, geometry, area / o.get(), raster, pass)
}

/// Equation 6.2: passes of the composition of `screen` pixels.
pub fn composite_passes(screen: Pixels, g: Processors, n: Processors) -> Count {
    Count::new(screen.get() * (1.0 / g.get() - 1.0 / n.get()))
}

/// Equation 6.3: instructions of the composition, each pass over a whole group.
pub fn composite(screen: Pixels, g: Processors, n: Processors, a: Words, b: Instructions) -> Instructions {
    pass(a, b, g) * composite_passes(screen, g, n).get()
}

/// Equation 6.4: [`composite`] per pixel for n much larger than g.
pub fn composite_per_pixel(g: Processors, a: Words, b: Instructions) -> Instructions {
    Instructions::new(a.get() + (2.0 * a.get() + b.get()) / g.get())
}

/// The largest possible saving per composited pixel: 3a + b over a (6.4).
pub fn composite_gain(a: Words, b: Instructions) -> Ratio {
    Ratio::new(neighbour_pass(a, b).get() / a.get())
}

/// Instructions per pixel during which a datum is in transit and the processor is idle (6.5).
pub fn idle_in_transit(g: Processors, a: Words) -> Instructions {
    Instructions::new(g.get() * a.get())
}

/// Additional instructions of a textured pixel (6.5).
pub fn texture_premium(textured: Instructions, shaded: Instructions) -> Instructions {
    textured - shaded
}

/// Instructions of the composition for n >> g >> (2a + b)/a (6.6).
pub fn composite_limit(screen: Pixels, a: Words) -> Instructions {
    Instructions::new(screen.get() * a.get())
}

/// Its time (6.6).
pub fn composite_limit_time(screen: Pixels, a: Words, clock: Hertz) -> Seconds {
    composite_limit(screen, a) / clock
}

/// Frame rate if only composition is done (6.6), on a machine `speed_up` times as fast (9.3).
pub fn composite_limit_rate(screen: Pixels, a: Words, clock: Hertz, speed_up: Ratio) -> FrameRate {
    FrameRate::new(speed_up.get() / composite_limit_time(screen, a, clock).get())
}

/// Time of a composition on the Magic-1 over that on the Princeton Engine, whose clock and communication register it
/// exceeds by these factors (9.3).
pub fn magic_1_composite_time(clock: Ratio, width: Ratio) -> Ratio {
    Ratio::new(1.0 / (clock.get() * width.get()))
}

/// The factor K of p g / n in equation 6.5: half a pass. The document prints 84 for a = 42, b = 30, d = 1, where its
/// own pass of 156 gives 78.
pub fn grouped_pass(a: Words, b: Instructions, d: Processors) -> Instructions {
    pass(a, b, d) / 2.0
}

/// Equation 6.5: instructions of the sort-middle stage, `half_pass` being [`grouped_pass`]. `p` counts visible
/// polygons.
pub fn sort_middle_stage(p: Polygons, n: Processors, g: Processors, half_pass: Instructions) -> Instructions {
    half_pass * (p.get() * g.get() / n.get())
}

/// Equation 6.6: instructions of the sort-last stage for n much larger than g.
pub fn sort_last_stage(screen: Pixels, g: Processors, a: Words, b: Instructions) -> Instructions {
    composite_per_pixel(g, a, b) * screen.get()
}

/// Equation 6.7: the size of groups at which both stages together cost least.
pub fn optimal_group(
    p: Polygons,
    screen: Pixels,
    n: Processors,
    half_pass: Instructions,
    a: Words,
    b: Instructions,
) -> Processors {
    let start = 2.0 * a.get() + b.get();
    Processors::new((start * screen.get() * n.get() / (half_pass.get() * p.get())).sqrt())
}

/// The square of the factor in equation 6.8: 4 `half_pass` (2a + b). The document prints 441, which is (2a + b)^2;
/// putting 6.7 into 6.5 and 6.6 gives 7056 with its own 84, 6552 with 78.
pub fn growth_squared(half_pass: Instructions, a: Words, b: Instructions) -> f64 {
    4.0 * half_pass.get() * (2.0 * a.get() + b.get())
}

/// Equation 6.8: instructions of sort-twice at the best group size; `growth` is the root of [`growth_squared`].
pub fn sort_twice(p: Polygons, screen: Pixels, n: Processors, a: Words, growth: f64) -> Instructions {
    composite_limit(screen, a) + Instructions::new(growth * (screen.get() * p.get() / n.get()).sqrt())
}

/// Visible polygons above which sort-twice (6.8) beats sort-middle at its best stride (6.9): a quadratic equation in
/// sqrt p. The document prints 50,503 for its growth of 21; consistent equations give 62,647.
pub fn sort_twice_crossover(
    screen: Pixels,
    n: Processors,
    growth: f64,
    a: Words,
    b: Instructions,
    pixel: Words,
) -> Polygons {
    let per_polygon = pass_root(a, b).get() / n.get().sqrt() + a.get() / 2.0;
    let slope = growth * (screen.get() / n.get()).sqrt();
    let constant = composite_limit(screen, pixel).get();
    let root = (slope + (slope * slope + 4.0 * per_polygon * constant).sqrt()) / (2.0 * per_polygon);
    Polygons::new(root * root)
}

/// Bytes a second of sparse sort-last if every pixel of the screen is sent once a frame (6.1).
pub fn sort_last_traffic(width: Length, height: Length, fps: FrameRate, sample: Bits) -> BytesPerSecond {
    Bytes::from(sample) * (width.get() * height.get()) * fps
}

pub(crate) const MODELS: &[Model] = models! {
    "eldridge.6.1", "eq 6.1", "instructions of sort-middle in groups, raster term f A R":
        grouped_sort_middle["p": Polygons, "n": Processors = PROCESSORS, "g": Processors where 1.0, "f": Ratio where 1.0 = ASYMMETRY,
            "G": Instructions = GEOMETRY, "A": Pixels = AREA, "R": Instructions = RASTER,
            "C": Instructions = DESCRIPTOR_PASS] -> Instructions;
    "eldridge.6.1-as-printed", "eq 6.1", "the same as printed, raster term f A R / o":
        grouped_sort_middle_as_printed["p": Polygons, "n": Processors = PROCESSORS, "g": Processors where 1.0,
            "f": Ratio where 1.0 = ASYMMETRY, "o": Ratio where 1.0 = OVERLAP, "G": Instructions = GEOMETRY, "A": Pixels = AREA,
            "R": Instructions = RASTER, "C": Instructions = DESCRIPTOR_PASS] -> Instructions;
    "eldridge.6.2", "eq 6.2", "passes of the composition":
        composite_passes["P": Pixels = SCREEN, "g": Processors where 1.0, "n": Processors = PROCESSORS] -> Count;
    "eldridge.6.3", "eq 6.3", "instructions of the composition":
        composite["P": Pixels = SCREEN, "g": Processors where 1.0, "n": Processors = PROCESSORS, "a": Words = PIXEL.0,
            "b": Instructions = PIXEL.1] -> Instructions;
    "eldridge.6.4", "eq 6.4", "instructions of the composition per pixel, n much larger than g":
        composite_per_pixel["g": Processors where 1.0, "a": Words = PIXEL.0, "b": Instructions = PIXEL.1] -> Instructions;
    "eldridge.composite-gain", "6.4", "most over least expensive composited pixel":
        composite_gain["a": Words = PIXEL.0, "b": Instructions = PIXEL.1] -> Ratio;
    "eldridge.idle-in-transit", "6.5", "instructions per pixel in which a datum is only in transit":
        idle_in_transit["g": Processors where 1.0, "a": Words = PIXEL.0] -> Instructions;
    "eldridge.texture-premium", "6.5", "instructions that textures add to a pixel":
        texture_premium["textured": Instructions = 202.0, "shaded": Instructions = 80.0] -> Instructions;
    "eldridge.composite-limit", "6.6", "instructions of the composition for very large groups":
        composite_limit["P": Pixels = SCREEN, "a": Words = PIXEL.0] -> Instructions;
    "eldridge.composite-limit-time", "6.6", "time of the composition for very large groups":
        composite_limit_time["P": Pixels = SCREEN, "a": Words = PIXEL.0, "clock": Hertz = CLOCK] -> Seconds;
    "eldridge.composite-limit-rate", "6.6, 9.3", "pictures a second if only composition is done":
        composite_limit_rate["P": Pixels = SCREEN, "a": Words = PIXEL.0, "clock": Hertz = CLOCK, "speed_up": Ratio = 1.0]
            -> FrameRate;
    "eldridge.magic-1-composite-time", "9.3", "time of a composition on the Magic-1 over the Princeton Engine's":
        magic_1_composite_time["clock": Ratio = 3.0, "width": Ratio = 2.0] -> Ratio;
    "eldridge.6.5-factor", "eq 6.5", "K, the factor of p g / n; printed 84":
        grouped_pass["a": Words = DESCRIPTOR.0, "b": Instructions = DESCRIPTOR.1, "d": Processors = 1.0]
            -> Instructions;
    "eldridge.6.5", "eq 6.5", "instructions of the sort-middle stage":
        sort_middle_stage["p": Polygons, "n": Processors = PROCESSORS, "g": Processors where 1.0, "K": Instructions = 78.0]
            -> Instructions;
    "eldridge.6.6", "eq 6.6", "instructions of the sort-last stage":
        sort_last_stage["P": Pixels = SCREEN, "g": Processors where 1.0, "a": Words = PIXEL.0, "b": Instructions = PIXEL.1]
            -> Instructions;
    "eldridge.6.7", "eq 6.7", "size of groups that costs least":
        optimal_group["p": Polygons, "P": Pixels = SCREEN, "n": Processors = PROCESSORS, "K": Instructions = 78.0,
            "a": Words = PIXEL.0, "b": Instructions = PIXEL.1] -> Processors;
    "eldridge.6.8-squared", "eq 6.8", "the square of the factor of sqrt(P p / n); printed 441":
        growth_squared["K": Instructions = 78.0, "a": Words = PIXEL.0, "b": Instructions = PIXEL.1] -> f64;
    "eldridge.6.8", "eq 6.8", "instructions of sort-twice at the best group size; growth is 80.94 (printed 21)":
        sort_twice["p": Polygons, "P": Pixels = SCREEN, "n": Processors = PROCESSORS, "a": Words = PIXEL.0,
            "growth": f64 = 80.944_425_379_392_24] -> Instructions;
    "eldridge.sort-twice-crossover", "6.6", "visible polygons above which sort-twice beats sort-middle":
        sort_twice_crossover["P": Pixels = SCREEN, "n": Processors = PROCESSORS, "growth": f64 = 80.944_425_379_392_24,
            "a": Words = DESCRIPTOR.0, "b": Instructions = DESCRIPTOR.1, "a_pixel": Words = PIXEL.0] -> Polygons;
    "eldridge.sort-last-traffic", "6.1", "bandwidth of sending every pixel once a frame":
        sort_last_traffic["width": Length = 768.0, "height": Length = 512.0, "fps": FrameRate = 30.0,
            "sample": Bits = 48.0] -> BytesPerSecond;
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_closed_form_is_the_sum_of_the_stages_at_the_best_group_size() {
        let (p, screen, n) = (Polygons::new(40_000.0), Pixels::new(393_216.0), Processors::new(1024.0));
        let (a, b, k) = (Words::new(3.0), Instructions::new(15.0), Instructions::new(78.0));
        let g = optimal_group(p, screen, n, k, a, b);
        let stages = sort_middle_stage(p, n, g, k) + sort_last_stage(screen, g, a, b);
        let closed = sort_twice(p, screen, n, a, growth_squared(k, a, b).sqrt());
        assert!((stages / closed - 1.0).abs() < 1e-12);
    }

    #[test]
    fn at_the_crossover_both_cost_the_same() {
        let (screen, n) = (Pixels::new(393_216.0), Processors::new(1024.0));
        let (a, b, pixel) = (Words::new(42.0), Instructions::new(30.0), Words::new(3.0));
        let p = sort_twice_crossover(screen, n, 80.9, a, b, pixel);
        let middle = super::super::distribution::two_stages_at_optimum(p, n, a, b);
        assert!((sort_twice(p, screen, n, pixel, 80.9) / middle - 1.0).abs() < 1e-12);
    }
}
