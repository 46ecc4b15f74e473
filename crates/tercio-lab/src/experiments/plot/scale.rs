//! Axes: positions of values and ticks.

use super::Scale;

/// Approximate number of ticks on an axis.
const TICKS: f64 = 8.0;
/// Up to this many powers of ten, an axis has ticks between them.
const FEW_DECADES: f64 = 2.5;

impl Scale {
    /// Position of a value on the axis (its logarithm on a logarithmic scale).
    pub(super) fn place(self, value: f64) -> f64 {
        match self {
            Self::Linear => value,
            Self::Log2 => value.log2(),
            Self::Log10 => value.log10(),
        }
    }

    /// The ends of the axis and its ticks, for positions between `low` and `high`.
    fn ticks(self, low: f64, high: f64) -> (f64, f64, Vec<f64>) {
        if self == Self::Log10 && high - low <= FEW_DECADES {
            return few_decades(low, high);
        }
        let step = match self {
            Self::Linear => {
                let rough = ((high - low) / TICKS).max(f64::MIN_POSITIVE);
                let power = 10f64.powf(rough.log10().floor());
                [1.0, 2.0, 5.0, 10.0].into_iter().map(|s| s * power).find(|s| *s >= rough).unwrap_or(rough)
            }
            Self::Log2 | Self::Log10 => ((high - low) / TICKS).ceil().max(1.0),
        };
        let (first, last) = ((low / step).floor(), (high / step).ceil().max((low / step).floor() + 1.0));
        let count = (last - first) as u32;
        (first * step, last * step, (0..=count).map(|i| (first + f64::from(i)) * step).collect())
    }

    fn tick_label(self, place: f64) -> String {
        match self {
            Self::Linear => grouped(place),
            Self::Log2 => grouped(place.exp2()),
            Self::Log10 => grouped(10f64.powf(place)),
        }
    }
}

/// Ends and ticks at 1, 2, 5, 10, 20, 50, ... for an axis that covers few powers of ten.
fn few_decades(low: f64, high: f64) -> (f64, f64, Vec<f64>) {
    let decades = low.floor() as i32 - 1..=high.ceil() as i32 + 1;
    let steps: Vec<f64> =
        decades.flat_map(|d| [1.0f64, 2.0, 5.0].map(|s| f64::from(d) + s.log10())).collect();
    let first = steps.iter().rposition(|&s| s <= low).unwrap_or(0);
    let last = steps.iter().position(|&s| s >= high && s > steps[first]).unwrap_or(steps.len() - 1);
    (steps[first], steps[last], steps[first..=last].to_vec())
}

/// A number with six digits, at most twelve of them behind the point, and all before it; without zeros at the end.
pub(in crate::experiments) fn six_digits(number: f64) -> String {
    let digits =
        if number == 0.0 { 0 } else { (5 - number.abs().log10().floor() as i32).clamp(0, 12) as usize };
    let text = format!("{number:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// A whole number in raised digits.
fn superscript(number: f64) -> String {
    format!("{number:.0}")
        .chars()
        .map(|c| "⁰¹²³⁴⁵⁶⁷⁸⁹".chars().nth((c as usize).wrapping_sub('0' as usize)).unwrap_or('⁻'))
        .collect()
}

/// The division of an axis: its ends, and ticks between them.
pub(super) struct Division {
    /// The ends, as positions.
    pub low: f64,
    pub high: f64,
    pub ticks: Vec<f64>,
    scale: Scale,
}

impl Division {
    /// The axis for `places`. A linear one starts at zero if `from_zero`, or if zero is close to the values.
    pub fn new(scale: Scale, from_zero: bool, places: impl Iterator<Item = f64>) -> Self {
        let (low, high) = places.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
        let (low, high) = if low > high { (0.0, 1.0) } else { (low, high) };
        let to_zero = scale == Scale::Linear && (from_zero || low < 0.5 * high);
        let (low, high, ticks) = scale.ticks(if to_zero { low.min(0.0) } else { low }, high);
        Self { low, high, ticks, scale }
    }

    /// An axis of categories, which has names instead of ticks.
    pub fn of_categories(low: f64, high: f64) -> Self {
        Self { low, high, ticks: Vec::new(), scale: Scale::Linear }
    }

    /// Where a position is between the ends: 0 to 1.
    pub fn share(&self, place: f64) -> f64 {
        (place - self.low) / (self.high - self.low)
    }

    /// What is written at a tick: a power of ten if the axis has many of them.
    pub fn label(&self, tick: f64) -> String {
        let wide = self.high >= 6.0 || self.low <= -5.0;
        if self.scale == Scale::Log10 && wide && self.ticks.iter().all(|t| t.fract() == 0.0) {
            return format!("10{}", superscript(tick));
        }
        self.scale.tick_label(tick)
    }
}

/// A number with thousands separators.
fn grouped(number: f64) -> String {
    let text = six_digits(number);
    let (sign, text) = text.strip_prefix('-').map_or(("", text.as_str()), |rest| ("-", rest));
    let (whole, fraction) = text.split_once('.').map_or((text, String::new()), |(w, f)| (w, format!(".{f}")));
    let mut separated = String::new();
    for (i, digit) in whole.chars().enumerate() {
        if i > 0 && (whole.len() - i).is_multiple_of(3) {
            separated.push(',');
        }
        separated.push(digit);
    }
    format!("{sign}{separated}{fraction}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_hold_the_values() {
        assert_eq!(
            Scale::Linear.ticks(0.0, 7.3),
            (0.0, 8.0, vec![0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0])
        );
        assert_eq!(Scale::Log2.ticks(0.0, 10.0).2, [0.0, 2.0, 4.0, 6.0, 8.0, 10.0]);
        let (low, high, _) = Scale::Log10.ticks(1.5, 1.6);
        assert!(low <= 1.5 && high >= 1.6);
        let (low, high, ticks) = Scale::Log10.ticks(0.1, 0.9);
        assert_eq!((low, high, ticks.len()), (0.0, 1.0, 4));
        assert_eq!(Scale::Log10.tick_label(5.0), "100,000");
        let wide = Division::new(Scale::Log10, false, [-5.0, 12.0].into_iter());
        assert_eq!((wide.label(12.0), wide.label(-5.0)), ("10¹²".into(), "10⁻⁵".into()));
        assert_eq!(grouped(-1234.5), "-1,234.5");
        assert_eq!(grouped(0.0025), "0.0025");
    }

    #[test]
    fn an_axis_begins_at_zero_where_that_is_near() {
        let low =
            |from_zero, places: [f64; 2]| Division::new(Scale::Linear, from_zero, places.into_iter()).low;
        assert_eq!(low(false, [16.0, 25.0]), 16.0);
        assert_eq!(low(true, [16.0, 25.0]), 0.0);
        assert_eq!(low(false, [2.0, 25.0]), 0.0);
    }
}
