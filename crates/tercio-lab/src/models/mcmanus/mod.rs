//! Document 003: D. McManus, C. Beckmann, Optimal Static 2-Dimensional Screen Subdivision for Parallel
//! Rasterization Architectures.
//!
//! `A` is the side of the array of pixel processors, which is the side of a screen region; `N` the mean area of a
//! polygon's bounding box in pixels, with sqrt N as its side; `T` raster cycles a second, one cycle rasterizing one
//! polygon in one region. The overlap formula itself is [`super::overlap::pixel_boxes`].

pub(crate) mod glossary;
pub mod optimum;

use crate::models;
use crate::models::overlap;
use crate::models::registry::Model;
use crate::units::{
    Count, Cycles, Hertz, Length, Pixels, PolygonRate, Polygons, Ratio, Seconds, SquareInches,
};

/// Area of one pixel processor, square inches (equation 1).
pub(crate) const PIXEL_PROCESSOR: f64 = 0.000_871;
/// Area of the geometry engine per polygon a second, square inches (equation 1).
pub(crate) const GEOMETRY_SLOPE: f64 = 7.4645e-7;
/// Area of the geometry engine without performance, square inches (equation 1).
pub(crate) const GEOMETRY_BASE: f64 = 1.3673;
/// Raster cycles a second of the tables.
pub(super) const CYCLES: f64 = 1e6;

/// Measured overlap: raster cycles per polygon (table 1).
pub fn measured_overlap(cycles: Cycles, polygons: Polygons) -> Ratio {
    Ratio::new(cycles.get() / polygons.get())
}

/// Polygons a second of one array that takes `cycles` for `polygons` (table 2).
pub fn measured_rate(cycles: Cycles, polygons: Polygons, per_second: Hertz) -> PolygonRate {
    PolygonRate::new(per_second.get() * polygons.get() / cycles.get())
}

/// Area of the geometry engine for `rate` (equation 1).
pub fn geometry_area(rate: PolygonRate) -> SquareInches {
    SquareInches::new(GEOMETRY_SLOPE * rate.get() + GEOMETRY_BASE)
}

/// Area of an array of side `side` (equation 1).
pub fn array_area(side: Length) -> SquareInches {
    SquareInches::new(PIXEL_PROCESSOR * side.get() * side.get())
}

/// Equation 1: area of a renderer, array and geometry engine.
pub fn renderer_area(side: Length, rate: PolygonRate) -> SquareInches {
    array_area(side) + geometry_area(rate)
}

/// Equations 2 to 6: C(A), regions per polygon for boxes of `area` pixels. With equation 4 corrected they collapse to
/// ((sqrt N + A - 1) / A)^2.
pub fn overlap_of_area(side: Length, area: Pixels) -> Ratio {
    overlap::pixel_boxes(side, Length::new(area.get().sqrt()))
}

/// Equations 2 to 5 for a box of `width` pixels: [i, alpha, beta, gamma], the regions on a side and the numbers of
/// places with i^2, i^2 + i and (i + 1)^2 regions. Equation 4 must have + 1 where the document prints - 1, which
/// contradicts its own figure 5 (1, 2, 1 for A = 2 and a box of 8).
pub fn places(side: Length, width: Length) -> [f64; 4] {
    let (a, w) = (side.get(), width.get());
    let i = (w / a).ceil();
    let alpha = (i * a - w + 1.0).powi(2);
    let gamma = (w - ((i - 1.0) * a + 1.0)).powi(2);
    [i, alpha, a * a - alpha - gamma, gamma]
}

/// The numbers of places with i^2, i^2 + i and (i + 1)^2 regions: [`places`] without i (figure 5).
pub fn placements(side: Length, width: Length) -> [f64; 3] {
    let [_, alpha, beta, gamma] = places(side, width);
    [alpha, beta, gamma]
}

/// [`placements`] with equation 4 as it is printed: gamma is (sqrt N - ((i - 1) A - 1))^2, and beta the rest of A^2,
/// which may be negative.
pub fn placements_as_printed(side: Length, width: Length) -> [f64; 3] {
    let (a, w) = (side.get(), width.get());
    let [i, alpha, ..] = places(side, width);
    let gamma = (w - ((i - 1.0) * a - 1.0)).powi(2);
    [alpha, a * a - alpha - gamma, gamma]
}

/// Equation 6 from [`places`].
pub fn overlap_of_places(side: Length, width: Length) -> Ratio {
    let [i, alpha, beta, gamma] = places(side, width);
    let sum = i * i * alpha + (i * i + i) * beta + (i + 1.0) * (i + 1.0) * gamma;
    Ratio::new(sum / (side.get() * side.get()))
}

/// Equation 7: P(A), polygons a second of an array.
pub fn rate(side: Length, area: Pixels, per_second: Hertz) -> PolygonRate {
    PolygonRate::new(per_second.get() / overlap_of_area(side, area).get())
}

/// Equation 14, corrected: polygons a second of `processors` arranged as X / A^2 arrays of side `side`. The document
/// divides by X / A; the condition must be A^2 <= X.
///
/// # Errors
/// An array larger than the machine.
pub fn general_purpose_rate(
    processors: Count,
    side: Length,
    area: Pixels,
    per_second: Hertz,
) -> Result<PolygonRate, String> {
    let arrays = processors.get() / (side.get() * side.get());
    if arrays < 1.0 {
        return Err(format!("A: expected at most the root of X = {processors}, found {side}"));
    }
    Ok(rate(side, area, per_second) * arrays)
}

/// Equation 14 as it is printed: equation 7 over X / A, for A <= X.
///
/// # Errors
/// An array of more than `processors` on a side.
pub fn general_purpose_rate_as_printed(
    processors: Count,
    side: Length,
    area: Pixels,
    per_second: Hertz,
) -> Result<PolygonRate, String> {
    if side.get() > processors.get() {
        return Err(format!("A: expected at most X = {processors}, found {side}"));
    }
    Ok(rate(side, area, per_second) / (processors.get() / side.get()))
}

/// Time of a frame of `cycles` on `renderers` perfectly balanced arrays (3).
pub fn frame_time(cycles: Cycles, renderers: Count, cycle: Seconds) -> Seconds {
    cycle * (cycles.get() / renderers.get())
}

/// Pixel processors if every raster cycle has an array of its own (3).
pub fn processors_for_one_cycle(cycles: Cycles, side: Length) -> Pixels {
    Pixels::new(cycles.get() * side.get() * side.get())
}

/// The largest deviation of the rate by equation 7 from the measured one, over sides and measured raster cycles (6).
///
/// # Errors
/// Lists of different lengths.
pub fn largest_deviation(
    sides: Vec<Length>,
    cycles: Vec<Cycles>,
    polygons: Polygons,
    area: Pixels,
) -> Result<Ratio, String> {
    if sides.len() != cycles.len() {
        return Err(format!("expected as many cycles as sides, found {} and {}", cycles.len(), sides.len()));
    }
    let off =
        |(a, c): (&Length, &Cycles)| (overlap_of_area(*a, area) / measured_overlap(*c, polygons) - 1.0).abs();
    Ok(Ratio::new(sides.iter().zip(&cycles).map(off).fold(0.0, f64::max)))
}

/// Areas of memory per microprocessor and of the controller chip that are implied by the published line: points
/// [polygons a second, die area, microprocessors] whose least-squares line has the slope and base of equation 1 (5.1;
/// the paper prints neither area).
///
/// # Errors
/// Fewer than two different rates, or one number of microprocessors everywhere.
pub fn implied_areas(points: Vec<[f64; 3]>) -> Result<[SquareInches; 2], String> {
    let line = |column: usize| least_squares(points.iter().map(|p| (p[0], p[column])));
    let ((die_slope, die_base), (count_slope, count_base)) = (line(1)?, line(2)?);
    // A fit is linear in its ordinates: die + memory * number + controller is fitted by the sum of the fits.
    if count_slope == 0.0 {
        return Err("points: expected different numbers of microprocessors".into());
    }
    let memory = (GEOMETRY_SLOPE - die_slope) / count_slope;
    let controller = GEOMETRY_BASE - die_base - memory * count_base;
    Ok([SquareInches::new(memory), SquareInches::new(controller)])
}

/// Slope and base of the line through points.
fn least_squares(points: impl Iterator<Item = (f64, f64)> + Clone) -> Result<(f64, f64), String> {
    let number = points.clone().count() as f64;
    let mean = |of: fn((f64, f64)) -> f64| points.clone().map(of).sum::<f64>() / number;
    let (x, y) = (mean(|p| p.0), mean(|p| p.1));
    let spread: f64 = points.clone().map(|p| (p.0 - x).powi(2)).sum();
    if !(spread > 0.0) {
        return Err("points: expected at least two different rates".into());
    }
    let slope = points.map(|p| (p.0 - x) * (p.1 - y)).sum::<f64>() / spread;
    Ok((slope, y - slope * x))
}

pub(crate) const MODELS: &[Model] = models! {
    "mcmanus.measured-overlap", "table 1", "regions per polygon from raster cycles":
        measured_overlap["R_A": Cycles, "polygons": Polygons] -> Ratio;
    "mcmanus.measured-rate", "table 2", "polygons a second from raster cycles":
        measured_rate["R_A": Cycles, "polygons": Polygons, "T": Hertz = CYCLES] -> PolygonRate;
    "mcmanus.geometry-area", "eq 1", "area of a geometry engine":
        geometry_area["P": PolygonRate] -> SquareInches;
    "mcmanus.array-area", "eq 1", "area of an array of pixel processors":
        array_area["A": Length where 1.0] -> SquareInches;
    "mcmanus.1", "eq 1", "area of a renderer":
        renderer_area["A": Length where 1.0, "P": PolygonRate] -> SquareInches;
    "mcmanus.6", "eq 2 to 6", "C(A), regions per polygon; printed with a wrong sign in 4":
        overlap_of_area["A": Length where 1.0, "N": Pixels where 1.0] -> Ratio;
    "mcmanus.places", "eq 2 to 5", "[i, alpha, beta, gamma] for a box w pixels wide":
        places["A": Length where 1.0, "w": Length where 1.0] -> [f64; 4];
    "mcmanus.placements", "fig 5", "[alpha, beta, gamma] of these":
        placements["A": Length where 1.0, "w": Length where 1.0] -> [f64; 3];
    "mcmanus.4-as-printed", "eq 4", "the same with equation 4 as printed; contradicts figure 5":
        placements_as_printed["A": Length where 1.0, "w": Length where 1.0] -> [f64; 3];
    "mcmanus.6-of-places", "eq 6", "regions per polygon from these":
        overlap_of_places["A": Length where 1.0, "w": Length where 1.0] -> Ratio;
    "mcmanus.7", "eq 7", "P(A), polygons a second of an array":
        rate["A": Length where 1.0, "N": Pixels where 1.0, "T": Hertz = CYCLES] -> PolygonRate;
    "mcmanus.14", "eq 14", "polygons a second of X processors as arrays of side A; printed with X / A, divided":
        general_purpose_rate["X": Count, "A": Length where 1.0, "N": Pixels where 1.0, "T": Hertz = CYCLES]
            -> Result<PolygonRate, String>;
    "mcmanus.14-as-printed", "eq 14", "the same as printed, divided by X / A":
        general_purpose_rate_as_printed["X": Count, "A": Length where 1.0, "N": Pixels where 1.0, "T": Hertz = CYCLES]
            -> Result<PolygonRate, String>;
    "mcmanus.frame-time", "3", "time of a frame":
        frame_time["R_A": Cycles, "renderers": Count, "cycle": Seconds = 1e-6] -> Seconds;
    "mcmanus.processors-for-one-cycle", "3", "pixel processors with an array for every raster cycle":
        processors_for_one_cycle["R_A": Cycles, "A": Length where 1.0] -> Pixels;
    "mcmanus.largest-deviation", "6", "largest deviation of equation 7 from measured cycles":
        largest_deviation["A": Vec<Length>, "R_A": Vec<Cycles>, "polygons": Polygons, "N": Pixels where 1.0]
            -> Result<Ratio, String>;
    "mcmanus.implied-areas", "5.1", "areas of memory and controller implied by equation 1, from [rate, die, number]":
        implied_areas["points": Vec<[f64; 3]>] -> Result<[SquareInches; 2], String>;
};

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        /// Equations 2 to 6 equal the closed form for every size, also if the box is no whole number of pixels.
        #[test]
        fn the_equations_collapse(a in 1.0f64..600.0, w in 1.0f64..600.0) {
            let (side, width) = (Length::new(a), Length::new(w));
            let closed = overlap::pixel_boxes(side, width).get();
            prop_assert!((overlap_of_places(side, width).get() / closed - 1.0).abs() < 1e-9);
        }
    }

    /// Figure 5 has one place with 16 regions, two with 20 and one with 25; the corrected equation 4 gives that, the
    /// printed one a negative number of places.
    #[test]
    fn figure_5_decides_equation_4() {
        let (two, eight) = (Length::new(2.0), Length::new(8.0));
        assert_eq!(placements(two, eight), [1.0, 2.0, 1.0]);
        assert_eq!(placements_as_printed(two, eight), [1.0, -6.0, 9.0]);
    }

    #[test]
    fn small_arrays_win_without_overhead() {
        let of = |a: f64| {
            general_purpose_rate(Count::new(65536.0), Length::new(a), Pixels::new(23.91), Hertz::new(1e6))
        };
        let rates: Vec<_> = [1.0, 4.0, 16.0, 256.0].iter().map(|a| of(*a).unwrap().get()).collect();
        assert!(rates.windows(2).all(|w| w[0] > w[1]), "{rates:?}");
        assert!(of(257.0).is_err());
        let printed = general_purpose_rate_as_printed(
            Count::new(16.0),
            Length::new(17.0),
            Pixels::new(23.91),
            Hertz::new(1e6),
        );
        assert!(printed.is_err());
    }

    #[test]
    fn fixed_points_of_the_fit_are_recovered() {
        // Die areas made from the published line with memory 0.5 and a controller of 0.25.
        let point = |rate: f64, number: f64| {
            [rate, GEOMETRY_SLOPE * rate + GEOMETRY_BASE - 0.25 - 0.5 * number, number]
        };
        let found =
            implied_areas(vec![point(4e5, 1.0), point(9e5, 2.0), point(2e6, 1.0), point(1e6, 2.0)]).unwrap();
        assert!((found[0].get() - 0.5).abs() < 1e-9 && (found[1].get() - 0.25).abs() < 1e-9);
    }
}
