//! Where a scale is marked: round numbers.

use crate::number::{self, NumberFormat, exponent_of};

/// A mark of a scale.
#[derive(Clone, Debug, PartialEq)]
pub struct Tick {
    /// The number there.
    pub value: f64,
    /// What is written there; empty for a small mark between two labels.
    pub label: String,
}

/// Numbers of which the relative distance is less than this cannot be marked with round numbers in `f64`.
const FINEST: f64 = 1e-13;

/// Ends of a range may be the numbers of a file in `f32`, or sums of them: this much relative to a number is rounding.
const ROUNDING: f64 = 1e-6;
/// A number is nowhere farther than this share of a range outside of it, so that nobody sees that it is drawn at the end.
const MOST_OUTSIDE: f64 = 1e-3;

/// Whether a number is in a range, or only through rounding outside of it: 0.1 is the lower end of data of which the lowest value is
/// 0.1 in `f32`, which is a little more. On a linear scale, rounding is that of the range, on others that of the number itself.
pub(crate) fn is_within(value: f64, [low, high]: [f64; 2], is_linear: bool) -> bool {
    let half = high * 0.5 - low * 0.5;
    let most = half * MOST_OUTSIDE * 2.0;
    let slack = if is_linear {
        // Far from 0, numbers of a small range are rounded more than the range says.
        let of_numbers = low.abs().max(high.abs()) * f64::from(f32::EPSILON);
        (half * ROUNDING * 2.0).max(of_numbers).min(most)
    } else {
        (value.abs() * ROUNDING).min(most)
    };
    // Of the largest numbers, the sum is infinite.
    value.is_finite() && low - slack <= value && value <= high + slack
}

/// Marks that are outside of a range through rounding, at its ends.
fn at_ends(mut ticks: Vec<Tick>, [low, high]: [f64; 2]) -> Vec<Tick> {
    ticks.iter_mut().for_each(|tick| tick.value = tick.value.clamp(low, high));
    ticks
}

/// Round numbers at an even distance (1, 2 or 5 times a power of ten) in a range, at most `most`, but at least two: the ends of
/// the range where there are no round numbers.
///
/// # Panics
/// If the range is not finite or empty.
pub fn linear([low, high]: [f64; 2], most: usize, format: NumberFormat) -> Vec<Tick> {
    assert!(low.is_finite() && high.is_finite() && low < high, "a range: {low} to {high}");
    let most = most.max(2);
    let largest = low.abs().max(high.abs());
    // Halves, because the difference of the largest numbers is infinite.
    let half = high * 0.5 - low * 0.5;
    if half / largest < FINEST {
        return ends([low, high], format);
    }
    // The exponent of a step that is certainly too small, in halves; then larger ones until there are few enough.
    let mut exponent = exponent_of(half) - 3;
    loop {
        for digit in [1i64, 2, 5] {
            if let Some(ticks) = multiples([low, high], digit, exponent, most, format) {
                return if ticks.len() < 2 { ends([low, high], format) } else { ticks };
            }
        }
        exponent += 1;
    }
}

/// The multiples of `digit` times a power of ten in a range, unless there are more than `most`.
fn multiples(
    [low, high]: [f64; 2],
    digit: i64,
    exponent: i32,
    most: usize,
    format: NumberFormat,
) -> Option<Vec<Tick>> {
    let number = |count: i64| -> f64 {
        let text = format!("{}e{exponent}", i128::from(count) * i128::from(digit));
        text.parse().unwrap_or(f64::NAN)
    };
    let step = number(1);
    let count = (high * 0.5 - low * 0.5) / step * 2.0;
    if !(step > 0.0 && count <= (most + 2) as f64) {
        return None;
    }
    let first = (low / step).floor() as i64 - 1;
    let is_inside = |v: &f64| is_within(*v, [low, high], true);
    let inside = (first..).map(number).skip_while(|v| *v < low && !is_inside(v)).take_while(is_inside);
    let values: Vec<f64> = inside.take(most + 1).map(|v| v + 0.0).collect();
    (values.len() <= most).then(|| at_ends(labelled(values, exponent, [low, high], format), [low, high]))
}

/// Both ends of a range, with as many digits as it takes to tell them apart.
pub(crate) fn ends([low, high]: [f64; 2], format: NumberFormat) -> Vec<Tick> {
    let digits = (3..=17).find(|&digits| {
        let distance =
            |v: f64| number::parse(&number::general(v, digits)).map_or(f64::INFINITY, |p| (p - v).abs());
        distance(low).max(distance(high)) <= (high - low) * 0.01
    });
    let print = |value| match format {
        NumberFormat::Auto => number::general(value, digits.unwrap_or(17)),
        format => format.print(value),
    };
    [low, high].map(|value| Tick { value, label: print(value) }).into()
}

/// Whether numbers of a range are so different that a mantissa of a few digits and a power of ten tell them apart: coordinates far from
/// 0 are written out. It depends on the range alone, so that an axis and a bar write its numbers alike, however many they have.
pub(crate) fn is_wide([low, high]: [f64; 2]) -> bool {
    let exponent = exponent_of(low.abs().max(high.abs()));
    exponent <= exponent_of(high * 0.5 - low * 0.5) + 2 || exponent >= 15
}

/// Numbers with their labels, all with the same power of ten and the same digits after the point.
fn labelled(values: Vec<f64>, step_exponent: i32, range: [f64; 2], format: NumberFormat) -> Vec<Tick> {
    let largest = values.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    let exponent = exponent_of(largest);
    let needs_power = exponent >= 6 && step_exponent > 0 && is_wide(range) || exponent < -3;
    let print = |value: f64| match format {
        NumberFormat::Auto if value == 0.0 => "0".to_owned(),
        NumberFormat::Auto if needs_power => {
            let digits = (exponent - step_exponent).max(0) as usize;
            scaled(value, exponent, digits)
        }
        NumberFormat::Auto => number::fixed(value, (-step_exponent).max(0) as usize),
        format => format.print(value),
    };
    values.into_iter().map(|value| Tick { value, label: print(value) }).collect()
}

/// A number as a multiple of a power of ten.
fn scaled(value: f64, exponent: i32, digits: usize) -> String {
    // By moving the point of its decimal digits, which is exact.
    let own = exponent_of(value);
    let significant = (digits as i32 + own - exponent).max(0) as usize;
    let (mantissa, own) = number::scientific(value, significant);
    let moved: f64 = format!("{mantissa}e{}", own - exponent).parse().unwrap_or(0.0);
    number::with_power(&format!("{moved:.digits$}"), exponent)
}

/// Powers of ten in a range of numbers above 0, or every second, third ... of them if there are more than `most`; with 2 and 5
/// times powers of ten where the range has few; or [`linear`] marks if it has still fewer than two. Unlabelled marks are the
/// multiples between.
///
/// # Panics
/// If the range is empty, not finite or not above 0.
pub fn logarithmic([low, high]: [f64; 2], most: usize, format: NumberFormat) -> Vec<Tick> {
    assert!(low > 0.0 && low < high && high.is_finite(), "a range above 0: {low} to {high}");
    let most = most.max(2);
    let (first, last) = (exponent_of(low), last_exponent(high));
    let within = |value: &f64| is_within(*value, [low, high], false);
    let power = |digit: i32, exponent: i32| format!("{digit}e{exponent}").parse().unwrap_or(f64::NAN);
    let powers: Vec<i32> = (first..=last).filter(|&e| within(&power(1, e))).collect();
    let (mut ticks, is_plain) = (Vec::new(), is_plain(first, last));
    if powers.len() >= 3 || powers.len() == 2 && most < 4 {
        let every = powers.len().div_ceil(most) as i32;
        let is_labelled = |e: i32| e.rem_euclid(every) == 0;
        // A range may have no power that is a multiple; then the first is labelled, and so on from there.
        let from = if powers.iter().filter(|e| is_labelled(**e)).count() < 2 { powers[0] } else { 0 };
        for &e in &powers {
            let label =
                if (e - from).rem_euclid(every) == 0 { of_power(e, is_plain, format) } else { String::new() };
            ticks.push(Tick { value: power(1, e), label });
        }
    } else {
        for digits in [&[1, 2, 5][..], &[1, 3], &[1]] {
            let marks = (first..=last).flat_map(|e| digits.iter().map(move |&d| (d, e)));
            let values: Vec<f64> = marks.map(|(d, e)| power(d, e)).filter(within).collect();
            if (2..=most).contains(&values.len()) {
                let label = |value| Tick { value, label: of_digit(value, is_plain, format) };
                ticks = values.into_iter().map(label).collect();
                break;
            }
        }
        if ticks.len() < 2 {
            return linear([low, high], most, format);
        }
    }
    if last - first <= 8 {
        let between = (first..=last).flat_map(|e| (2..=9).map(move |d| power(d, e))).filter(within);
        let small = between.filter(|v| ticks.iter().all(|t| t.value != *v)).collect::<Vec<_>>();
        ticks.extend(small.into_iter().map(|value| Tick { value, label: String::new() }));
        ticks.sort_by(|a, b| a.value.total_cmp(&b.value));
    }
    at_ends(ticks, [low, high])
}

/// The last power of ten that may be in a range up to a number: that above it, if it is less only through rounding.
fn last_exponent(high: f64) -> i32 {
    let rounded = high * (1.0 + ROUNDING);
    exponent_of(if rounded.is_finite() { rounded } else { high })
}

/// Whether all powers of ten from one to another one are better written out.
fn is_plain(first: i32, last: i32) -> bool {
    first >= -3 && last <= 4
}

fn of_power(exponent: i32, is_plain: bool, format: NumberFormat) -> String {
    match format {
        NumberFormat::Auto if is_plain => number::general(tens(exponent), 6),
        NumberFormat::Auto => number::power_of_ten(exponent),
        format => format.print(tens(exponent)),
    }
}

fn of_digit(value: f64, is_plain: bool, format: NumberFormat) -> String {
    match format {
        NumberFormat::Auto if is_plain => number::general(value, 6),
        NumberFormat::Auto => {
            let exponent = exponent_of(value);
            scaled(value, exponent, 0)
        }
        format => format.print(value),
    }
}

/// Whether a number is a power of ten.
pub(crate) fn is_power_of_ten(value: f64) -> bool {
    value == tens(exponent_of(value))
}

/// A power of ten, or minus one, written as that; `None` for other numbers. That of a file may be rounded to `f32`.
pub(crate) fn near_power(value: f64) -> Option<String> {
    let exponent = value.abs().log10().round();
    let is_near = exponent.is_finite() && (value.abs() / tens(exponent as i32) - 1.0).abs() <= 1e-6;
    let sign = if value < 0.0 { "−" } else { "" };
    is_near.then(|| format!("{sign}{}", number::power_of_ten(exponent as i32)))
}

fn tens(exponent: i32) -> f64 {
    format!("1e{exponent}").parse().unwrap_or(f64::NAN)
}

/// Marks of a scale that is logarithmic on both sides of 0 and linear between minus and plus `threshold`: 0, and powers of ten
/// from the threshold on.
///
/// # Panics
/// If the range is empty or not finite, or the threshold not above 0.
pub fn symmetric([low, high]: [f64; 2], threshold: f64, most: usize, format: NumberFormat) -> Vec<Tick> {
    assert!(low.is_finite() && high.is_finite() && low < high && threshold > 0.0, "a range: {low} to {high}");
    let largest = low.abs().max(high.abs());
    if !(largest > threshold) {
        return linear([low, high], most, format);
    }
    let first = exponent_of(threshold) + i32::from(tens(exponent_of(threshold)) < threshold);
    let last = last_exponent(largest);
    let exponents: Vec<i32> = (first..=last).collect();
    let within = |v: f64| is_within(v, [low, high], false);
    let is_plain = is_plain(first, last);
    for every in 1..=exponents.len().max(1) {
        // From the largest down, so that those near the ends are kept.
        let chosen = exponents.iter().rev().step_by(every).copied();
        let mut values: Vec<(f64, String)> = chosen
            .flat_map(|e| {
                let label = of_power(e, is_plain, format);
                [(tens(e), label.clone()), (-tens(e), format!("−{label}"))]
            })
            .collect();
        let zero = if format == NumberFormat::Auto { "0".to_owned() } else { format.print(0.0) };
        values.push((0.0, zero));
        values.retain(|(v, _)| within(*v));
        values.sort_by(|a, b| a.0.total_cmp(&b.0));
        if values.len() <= most.max(2) {
            if values.len() < 2 {
                break;
            }
            let ticks = values.into_iter().map(|(value, label)| Tick { value, label }).collect();
            return at_ends(ticks, [low, high]);
        }
    }
    linear([low, high], most, format)
}

#[cfg(test)]
mod tests;
