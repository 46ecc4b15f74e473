//! The array with most polygons a second for its area (sections 5.2 and 6, equations 8 to 13).

use super::{CYCLES, GEOMETRY_BASE, GEOMETRY_SLOPE, PIXEL_PROCESSOR, measured_rate, rate, renderer_area};
use crate::models;
use crate::models::registry::Model;
use crate::units::{Cycles, Hertz, Length, Pixels, PolygonRate, Polygons, SquareInches};

/// The largest array of the tables.
const LARGEST: u32 = 512;

/// Range of the search for a side.
const SMALLEST_SIDE: f64 = 1.0;
const LARGEST_SIDE: f64 = 4096.0;

/// Increase in polygons a second per pixel of side: P'(A) = 2 T A (s - 1) / (A + s - 1)^3 with s = sqrt N. This is the
/// true derivative of equation 7, which equation 11 was meant to be.
pub fn rate_slope(side: Length, area: Pixels, per_second: Hertz) -> f64 {
    let (a, s) = (side.get(), area.get().sqrt());
    2.0 * per_second.get() * a * (s - 1.0) / (a + s - 1.0).powi(3)
}

/// Equation 12: R'(A), increase in square inches per pixel of side, with the true P'.
pub fn area_slope(side: Length, area: Pixels, per_second: Hertz) -> f64 {
    area_slope_with(side, rate_slope(side, area, per_second))
}

/// Equation 9: P(R) = P(A(R)), polygons a second of one renderer with this much silicon. A(R) is found by search; it is
/// unique because R(A) increases with A.
///
/// # Errors
/// Less silicon than an array of side 1 takes, or more than one of side 4096.
pub fn rate_of_silicon(
    silicon: SquareInches,
    area: Pixels,
    per_second: Hertz,
) -> Result<PolygonRate, String> {
    let taken = |a: f64| {
        let side = Length::new(a);
        renderer_area(side, rate(side, area, per_second)).get()
    };
    let side = bisect(|a| taken(a) - silicon.get()).map_err(|_| {
        let (least, most) = (taken(SMALLEST_SIDE), taken(LARGEST_SIDE));
        format!("R: expected an area between {least:.4} and {most:.1} in2, found {silicon}")
    })?;
    Ok(rate(side, area, per_second))
}

/// Equation 8: L, polygons a second per square inch if renderers of this size are replicated.
pub fn replication_slope(side: Length, area: Pixels, per_second: Hertz) -> f64 {
    let p = rate(side, area, per_second);
    p.get() / renderer_area(side, p).get()
}

/// Equation 10: P'(A)/R'(A), increase in polygons a second per additional square inch of one renderer, with the true
/// P'.
pub fn growth_slope(side: Length, area: Pixels, per_second: Hertz) -> f64 {
    rate_slope(side, area, per_second) / area_slope(side, area, per_second)
}

fn area_slope_with(side: Length, rate_slope: f64) -> f64 {
    2.0 * PIXEL_PROCESSOR * side.get() + GEOMETRY_SLOPE * rate_slope
}

/// The solution of equation 13, P/R = P'/R', in closed form: A^3 = (sqrt N - 1) 1.3673 / 0.000871. Neither T nor the
/// slope of the geometry engine's area matters. Zero for boxes of a single pixel.
pub fn optimal_side(area: Pixels) -> Length {
    Length::new(((area.get().sqrt() - 1.0).max(0.0) * GEOMETRY_BASE / PIXEL_PROCESSOR).cbrt())
}

/// The solution of equation 13 by search, as in the document, to check [`optimal_side`].
///
/// # Errors
/// Boxes so small or so large that the optimum does not lie between 1 and 4096.
pub fn optimal_side_by_search(area: Pixels, per_second: Hertz) -> Result<Length, String> {
    bisect(|a| {
        let side = Length::new(a);
        replication_slope(side, area, per_second) - growth_slope(side, area, per_second)
    })
}

/// The side among powers of two from 1 to 512 with the least area per polygon a second, by equation 7 (table 3).
pub fn optimal_power_of_two(area: Pixels, per_second: Hertz) -> Length {
    cheapest(powers_of_two().map(|side| (side, rate(side, area, per_second).get())))
}

/// The same from measured raster cycles of the sides 1, 2, 4, ... (5.1).
///
/// # Errors
/// Not as many cycles as sides.
pub fn optimal_measured(
    cycles: Vec<Cycles>,
    polygons: Polygons,
    per_second: Hertz,
) -> Result<Length, String> {
    let sides: Vec<_> = powers_of_two().collect();
    if sides.len() != cycles.len() {
        return Err(format!("R_A: expected {} raster cycles, found {}", sides.len(), cycles.len()));
    }
    let rates = cycles.into_iter().map(|c| measured_rate(c, polygons, per_second).get());
    Ok(cheapest(sides.into_iter().zip(rates)))
}

fn powers_of_two() -> impl Iterator<Item = Length> {
    (0..=LARGEST.ilog2()).map(|power| Length::new(f64::from(1u32 << power)))
}

/// The side with the least renderer area per polygon a second; the smaller one of two equal ones.
fn cheapest(sides: impl Iterator<Item = (Length, f64)>) -> Length {
    let cost = |(side, rate): (Length, f64)| (side, renderer_area(side, PolygonRate::new(rate)).get() / rate);
    sides.map(cost).min_by(|a, b| a.1.total_cmp(&b.1)).map_or(Length::default(), |best| best.0)
}

/// The overlap that equation 11 was derived from: equation 6 with i^2 + 1 regions in sub-region II instead of
/// i^2 + i, and i = s / A + 0.5. A cubic over A^3 instead of the square that equations 2 to 6 give.
pub fn misread_overlap(side: Length, area: Pixels) -> f64 {
    let a = side.get();
    misread_cubic(a, area)[0] / (a * a * a)
}

/// D(A) = 1.25 A^3 + (1.5 s - 2) A^2 + (N - 2 s) A + 2 s, and D'(A).
fn misread_cubic(a: f64, area: Pixels) -> [f64; 2] {
    let (n, s) = (area.get(), area.get().sqrt());
    let value = 1.25 * a.powi(3) + (1.5 * s - 2.0) * a * a + (n - 2.0 * s) * a + 2.0 * s;
    [value, 3.75 * a * a + 2.0 * (1.5 * s - 2.0) * a + n - 2.0 * s]
}

/// Equation 11 with its coefficients restored: T times a quotient whose denominator is the square of the cubic of
/// [`misread_overlap`]. The document prints a = 1.5575 (1.5625), b without - 5, the tail of e as that of f, "2N = 4
/// sqrt N" for j, and 2 sqrt N (6 sqrt N) for k. It is not the derivative of equation 7: see [`rate_slope`].
pub fn misread_rate_slope(side: Length, area: Pixels, per_second: Hertz) -> f64 {
    let (n, s) = (area.get(), area.get().sqrt());
    let (a, b, f) = (1.5625, 3.75 * s - 5.0, 4.0 * n * s - 8.0 * n);
    let (j, k) = (2.0 * n - 4.0 * s, 6.0 * s);
    quotient(side, area, per_second, [a, b, f], [j, k])
}

/// Equation 11 with the coefficients as printed; the second sign of j, a minus that became "=", is read as a minus.
pub fn misread_rate_slope_as_printed(side: Length, area: Pixels, per_second: Hertz) -> f64 {
    let (n, s) = (area.get(), area.get().sqrt());
    let (a, b, f) = (1.5575, 3.75 * s, 4.0 * n * s - 8.0 * s + 10.0 * n);
    let (j, k) = (2.0 * n - 4.0 * s, 2.0 * s);
    quotient(side, area, per_second, [a, b, f], [j, k])
}

/// Equation 11 with its undisputed coefficients; the disputed ones are parameters.
fn quotient(side: Length, area: Pixels, per_second: Hertz, [a, b, f]: [f64; 3], [j, k]: [f64; 2]) -> f64 {
    let (x, n, s) = (side.get(), area.get(), area.get().sqrt());
    let c = 4.75 * n - 11.0 * s + 4.0;
    let (d, e) = (3.0 * n * s - 10.0 * n + 13.0 * s, n * n - 4.0 * n * s - 8.0 * s + 10.0 * n);
    let (g, h) = (4.0 * n, 1.5 * s - 2.0);
    let denominator = [a, b, c, d, e, f, g].into_iter().fold(0.0, |sum, coefficient| sum * x + coefficient);
    per_second.get() * x * x * (h * x * x + j * x + k) / denominator
}

/// The optimum of figure 7: equation 13 with equation 11 and the overlap it was derived from.
///
/// # Errors
/// As [`optimal_side_by_search`].
pub fn misread_optimal_side(area: Pixels, per_second: Hertz) -> Result<Length, String> {
    bisect(|a| {
        let side = Length::new(a);
        let p = PolygonRate::new(per_second.get() / misread_overlap(side, area));
        let slope = misread_rate_slope(side, area, per_second);
        p.get() / renderer_area(side, p).get() - slope / area_slope_with(side, slope)
    })
}

/// The point between 1 and 4096 where `of` increases through zero.
fn bisect(of: impl Fn(f64) -> f64) -> Result<Length, String> {
    let (mut low, mut high) = (SMALLEST_SIDE, LARGEST_SIDE);
    if !(of(low) < 0.0 && of(high) > 0.0) {
        return Err("the optimum does not lie between 1 and 4096".into());
    }
    // Halved until only neighbouring numbers are left.
    loop {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            return Ok(Length::new(middle));
        }
        if of(middle) < 0.0 { low = middle } else { high = middle }
    }
}

pub(crate) const MODELS: &[Model] = models! {
    "mcmanus.rate-slope", "eq 11", "P'(A), the true derivative of equation 7":
        rate_slope["A": Length where 1.0, "N": Pixels where 1.0, "T": Hertz = CYCLES] -> f64;
    "mcmanus.8", "eq 8", "L, polygons a second per square inch of replicated renderers":
        replication_slope["A": Length where 1.0, "N": Pixels where 1.0, "T": Hertz = CYCLES] -> f64;
    "mcmanus.9", "eq 9", "P(R), polygons a second of one renderer by its area of silicon":
        rate_of_silicon["R": SquareInches, "N": Pixels where 1.0, "T": Hertz = CYCLES] -> Result<PolygonRate, String>;
    "mcmanus.10", "eq 10", "P'/R', polygons a second more per square inch more of one renderer":
        growth_slope["A": Length where 1.0, "N": Pixels where 1.0, "T": Hertz = CYCLES] -> f64;
    "mcmanus.11", "eq 11", "equation 11 with its coefficients restored; not the derivative of equation 7":
        misread_rate_slope["A": Length where 1.0, "N": Pixels where 1.0, "T": Hertz = CYCLES] -> f64;
    "mcmanus.11-as-printed", "eq 11", "equation 11 with the coefficients as printed":
        misread_rate_slope_as_printed["A": Length where 1.0, "N": Pixels where 1.0, "T": Hertz = CYCLES] -> f64;
    "mcmanus.11-overlap", "eq 11", "the overlap that equation 11 is derived from":
        misread_overlap["A": Length where 1.0, "N": Pixels where 1.0] -> f64;
    "mcmanus.12", "eq 12", "R'(A) with the true derivative":
        area_slope["A": Length where 1.0, "N": Pixels where 1.0, "T": Hertz = CYCLES] -> f64;
    "mcmanus.13", "eq 13", "optimal side of an array, closed form":
        optimal_side["N": Pixels where 1.0] -> Length;
    "mcmanus.13-by-search", "eq 13", "optimal side of an array, by search":
        optimal_side_by_search["N": Pixels where 1.0, "T": Hertz = CYCLES] -> Result<Length, String>;
    "mcmanus.13-of-11", "fig 7", "optimal side by equation 11 and its own overlap":
        misread_optimal_side["N": Pixels where 1.0, "T": Hertz = CYCLES] -> Result<Length, String>;
    "mcmanus.optimal-power-of-two", "table 3", "best side in powers of two, by equation 7":
        optimal_power_of_two["N": Pixels where 1.0, "T": Hertz = CYCLES] -> Length;
    "mcmanus.optimal-measured", "5.1", "best side in powers of two, by measured raster cycles":
        optimal_measured["R_A": Vec<Cycles>, "polygons": Polygons, "T": Hertz = CYCLES] -> Result<Length, String>;
};

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const T: Hertz = Hertz::new(1e6);

    #[test]
    fn raster_cycles_a_second_are_a_clock_rate() {
        use crate::models::registry::{Arguments, Value, evaluate};
        let with = |t: Value| {
            let n = ("N".to_owned(), Value::Number(100.0));
            evaluate(
                "mcmanus.7",
                &Arguments::from([n, ("A".to_owned(), Value::Number(16.0)), ("T".to_owned(), t)]),
            )
        };
        let megahertz = with(Value::Text("1 MHz".into()));
        assert!(megahertz.is_ok(), "{megahertz:?}");
        assert_eq!(megahertz, with(Value::Number(1e6)));
    }

    proptest! {
        #[test]
        fn closed_form_and_search_agree(n in 2.0f64..1e5) {
            let (closed, found) = (optimal_side(Pixels::new(n)), optimal_side_by_search(Pixels::new(n), T).unwrap());
            prop_assert!((closed / found - 1.0).abs() < 1e-9);
        }

        /// The rate for an area of silicon is the rate of the array with that area.
        #[test]
        fn silicon_and_back(a in 1.5f64..2000.0, n in 2.0f64..1e5) {
            let (side, area) = (Length::new(a), Pixels::new(n));
            let p = rate(side, area, T);
            let found = rate_of_silicon(renderer_area(side, p), area, T).unwrap();
            prop_assert!((found / p - 1.0).abs() < 1e-6, "{} {}", found, p);
            prop_assert!(rate_of_silicon(SquareInches::new(0.5), area, T).unwrap_err().contains("found 0.5"));
        }

        /// Both slopes are the derivatives of their functions.
        #[test]
        fn slopes_are_derivatives(a in 2.0f64..400.0, n in 2.0f64..1e4) {
            let (side, area, step) = (Length::new(a), Pixels::new(n), 1e-5 * a);
            let of = |f: &dyn Fn(Length) -> f64| (f(Length::new(a + step)) - f(Length::new(a - step))) / (2.0 * step);
            let p = of(&|s| rate(s, area, T).get());
            let near = |a: f64, b: f64| (a - b).abs() <= 1e-4 * b.abs().max(1.0);
            prop_assert!(near(p, rate_slope(side, area, T)));
            let misread = of(&|s| T.get() / misread_overlap(s, area));
            prop_assert!(near(misread, misread_rate_slope(side, area, T)));
        }
    }
}
