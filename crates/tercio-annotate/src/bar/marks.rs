//! Which numbers a bar is marked with.

use tercio_scene::color_map::Scale;

use super::{Marks, Parts, ScalarBar, labelled};
use crate::font::Line;
use crate::number::{self, NumberFormat, exponent_of};
use crate::ticks::{self, Tick};

/// Borders of more bands are no marks: it is hard to see them.
const MOST_BORDERS: usize = 101;

/// The least distance from the middle of a number to the next one above it, in ems.
const ABOVE: f64 = 1.2;
/// The least distance between a number and the next one beside it, in ems.
const ASIDE: f64 = 0.6;
/// The least distance of marks without numbers, in ems and in pixels: closer ones merge into an area.
const APART: (f64, f64) = (0.25, 3.0);

/// Which of so many marks have a label if at most `most` have one: every second, third ..., and both ends.
fn thinned(count: usize, most: usize) -> impl Fn(usize) -> bool {
    let last = count.saturating_sub(1);
    let least = last.div_ceil(most.max(2) - 1).max(1);
    // At even distances, unless that takes half of the labels away.
    let every = (least..2 * least).find(|every| last.is_multiple_of(*every)).unwrap_or(least);
    move |number| number == last || number.is_multiple_of(every) && last - number >= every
}

/// The end of a range may be a number of a file in `f32`: 0.3 is 0.300000012 there. Whole numbers are exact.
fn shortest(value: f64) -> f64 {
    match value as f32 {
        single if value.fract() != 0.0 && f64::from(single) == value => {
            format!("{single:e}").parse().unwrap_or(value)
        }
        _ => value,
    }
}

impl ScalarBar {
    /// The marks, of which at most `most` have labels: where they are asked for, at the borders of bands, or at round numbers. Those
    /// that are not free to be elsewhere may have labels as close as `most_close` of them.
    pub(crate) fn ticks(&self, most: usize, most_close: usize) -> Vec<Tick> {
        let most = most.max(2);
        let asked = self.asked();
        if !asked.is_empty() {
            if self.has_own_values() {
                // They may be anywhere: which of them have room is found one by one.
                let as_given = |&value: &f64| Tick { value, label: self.exactly(value) };
                return self.alike(asked.iter().map(as_given).collect());
            }
            return self.of_borders(&asked, most.max(most_close));
        }
        let borders = self.colors.boundaries();
        if !borders.is_empty() && borders.len() <= MOST_BORDERS {
            return self.of_borders(&borders, most.max(most_close));
        }
        let range = self.colors.range;
        let ticks = match self.colors.scale {
            Scale::Linear => ticks::linear(range, most, self.format),
            Scale::Log => ticks::logarithmic(range, most, self.format),
            Scale::SymmetricLog { threshold } => ticks::symmetric(range, threshold, most, self.format),
        };
        let ticks = if self.marks_ends() { self.with_ends(ticks) } else { ticks };
        // Formats with few digits may print several numbers alike.
        let mut last = None;
        let is_new = |tick: &Tick| {
            tick.label.is_empty() || last.replace(tick.label.clone()).as_ref() != Some(&tick.label)
        };
        ticks.into_iter().filter(is_new).collect()
    }

    /// Whether the values of the marks are given, and not chosen.
    pub(super) fn has_own_values(&self) -> bool {
        matches!(self.marks, Marks::At(_))
    }

    /// Whether the ends of the range have numbers beside the round ones: on a scale that is not even they do not follow from others.
    pub(super) fn marks_ends(&self) -> bool {
        self.marks == Marks::Usual
            && self.colors.scale != Scale::Linear
            && self.colors.boundaries().is_empty()
    }

    /// Marks with those of the ends of the range.
    fn with_ends(&self, mut ticks: Vec<Tick>) -> Vec<Tick> {
        let has_powers = ticks.iter().any(|tick| ticks::near_power(tick.value).as_ref() == Some(&tick.label));
        for mut end in ticks::ends(self.colors.range, self.format) {
            if self.format == NumberFormat::Auto
                && (has_powers || end.label.contains('×'))
                && let Some(power) = ticks::near_power(end.value)
            {
                end.label = power;
            }
            let is_end = |tick: &&mut Tick| (tick.value - end.value).abs() <= end.value.abs() * 1e-6;
            match ticks.iter_mut().find(is_end) {
                Some(tick) if tick.label.is_empty() => *tick = end,
                Some(tick) => tick.value = end.value,
                None => ticks.push(end),
            }
        }
        ticks.sort_by(|a, b| a.value.total_cmp(&b.value));
        ticks
    }

    /// Half of what a number takes of the bar's length, with its distance from the next one.
    fn half(&self, tick: &Tick, em: f64) -> f64 {
        em * 0.5 * if self.is_upright { ABOVE } else { Line::new(&tick.label).width + ASIDE }
    }

    /// Whether numbers do not touch each other on colours of this length.
    pub(crate) fn have_room(&self, ticks: &[Tick], length: f64, em: f64) -> bool {
        let mut end = f64::NEG_INFINITY;
        labelled(ticks).all(|tick| {
            let (middle, half) = (self.colors.position(tick.value) * length, self.half(tick, em));
            let fits = middle - half >= end;
            end = middle + half;
            fits
        })
    }

    /// Marks without those numbers that would touch the one before them; of those that are not given, the last one stays.
    pub(crate) fn with_room(&self, mut ticks: Vec<Tick>, length: f64, em: f64) -> Vec<Tick> {
        let ends = |tick: &Tick| {
            let (middle, half) = (self.colors.position(tick.value) * length, self.half(tick, em));
            [middle - half, middle + half]
        };
        let last = ticks.iter().rposition(|tick| !tick.label.is_empty()).filter(|_| !self.has_own_values());
        let most = last.map_or(f64::INFINITY, |last| ends(&ticks[last])[0]);
        let mut end = f64::NEG_INFINITY;
        for (number, tick) in ticks.iter_mut().enumerate().filter(|(_, tick)| !tick.label.is_empty()) {
            let [begin, own_end] = ends(tick);
            if begin >= end && (own_end <= most || Some(number) == last) {
                end = own_end;
            } else {
                tick.label.clear();
            }
        }
        ticks
    }

    /// Marks without those between numbers, where they are so close that they merge: powers of ten remain the longest. Marks that
    /// are asked for all remain.
    pub(crate) fn without_merged(&self, mut ticks: Vec<Tick>, length: f64, em: f64) -> Vec<Tick> {
        let least = (em * APART.0).max(APART.1);
        let is_close = |ticks: &[Tick]| {
            let at = |tick: &Tick| self.colors.position(tick.value) * length;
            ticks.windows(2).any(|pair| at(&pair[1]) - at(&pair[0]) < least)
        };
        let is_power = |tick: &Tick| ticks::is_power_of_ten(tick.value);
        let is_numbered = |tick: &Tick| !tick.label.is_empty();
        if self.marks_ends() {
            // The ends have numbers: what is close to one would merge with its mark, and not with others.
            let at = |tick: &Tick| self.colors.position(tick.value) * length;
            ticks.retain(|tick| is_numbered(tick) || (least..=length - least).contains(&at(tick)));
        }
        if self.marks == Marks::Usual && is_close(&ticks) {
            ticks.retain(|tick| is_numbered(tick) || is_power(tick));
            if is_close(&ticks) {
                ticks.retain(is_numbered);
            }
        }
        ticks
    }

    /// A number as it was given.
    fn exactly(&self, value: f64) -> String {
        if self.format != NumberFormat::Auto {
            return self.format.print(value);
        }
        let is_exact = |digits: &usize| number::parse(&number::general(value, *digits)) == Some(value);
        number::general(value, (1..17).find(is_exact).unwrap_or(17))
    }

    /// The values that marks are asked for, within the range.
    fn asked(&self) -> Vec<f64> {
        match &self.marks {
            Marks::Usual => Vec::new(),
            Marks::Count(count) => {
                let last = (*count).max(2) - 1;
                (0..=last).map(|i| self.colors.value_at(i as f64 / last as f64)).collect()
            }
            Marks::At(values) => {
                let mut values: Vec<f64> = values.iter().copied().filter(|v| self.has(*v)).collect();
                values.sort_by(f64::total_cmp);
                values.dedup();
                values
            }
        }
    }

    /// Whether a value is in the range, but for rounding.
    fn has(&self, value: f64) -> bool {
        ticks::is_within(value, self.colors.range, self.colors.scale == Scale::Linear)
    }

    /// What is missing of the marks that are asked for.
    pub(super) fn unmarked(&self, parts: &Parts, name: &str) -> impl Iterator<Item = String> {
        let outside = match &self.marks {
            Marks::At(values) => values.iter().find(|value| !self.has(**value)),
            _ => None,
        };
        let outside = outside.map(|value| format!("the mark {value} of {name}, which is not in its range"));
        let is_thinned = self.marks != Marks::Usual && parts.ticks.iter().any(|tick| tick.label.is_empty());
        outside.into_iter().chain(is_thinned.then(|| format!("some numbers of {name}")))
    }

    /// The borders of bands, of which at most `most` have numbers, with as many digits as it takes to know them to a hundredth of the
    /// distance of two numbers.
    fn of_borders(&self, values: &[f64], most: usize) -> Vec<Tick> {
        let has_number = thinned(values.len(), most);
        let shown = values.iter().enumerate().filter(|(number, _)| has_number(*number));
        let borders: Vec<f64> = shown.map(|(_, value)| shortest(*value)).collect();
        let width = borders.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min);
        let largest = borders.iter().fold(0.0f64, |largest, border| largest.max(border.abs()));
        // A border that is almost 0 is 0 beside the others.
        let after_point = 2 - exponent_of(width);
        let is_plain = match largest < 1e6 {
            true => (0..=9).contains(&after_point),
            false => after_point <= 9 && !ticks::is_wide(self.colors.range),
        };
        let is_close = |digits: usize| {
            let read = |v: f64| number::parse(&number::general(v, digits)).unwrap_or(f64::NAN);
            borders.iter().all(|&v| (read(v) - v).abs() <= width * 0.01)
        };
        let digits = (1..17).find(|&digits| is_close(digits)).unwrap_or(17);
        let is_even = self.colors.scale == Scale::Linear;
        let print = |value| match self.format {
            NumberFormat::Auto if !is_even => self.by_itself(value, &borders),
            NumberFormat::Auto if is_plain => {
                number::without_zeros(&number::fixed(value, after_point.max(0) as usize))
            }
            NumberFormat::Auto => number::general(value, digits),
            format => format.print(value),
        };
        let tick = |(number, value): (usize, &f64)| {
            let label = if has_number(number) { print(shortest(*value)) } else { String::new() };
            Tick { value: *value, label }
        };
        self.alike(values.iter().enumerate().map(tick).collect())
    }

    /// A number on a scale that is not even, in as many digits as it takes to know it to 0.1 % and to tell it from its neighbours, which may be
    /// far smaller or larger.
    fn by_itself(&self, value: f64, borders: &[f64]) -> String {
        // What is 0 but for rounding.
        let value = match self.colors.scale {
            Scale::SymmetricLog { threshold } if value.abs() < threshold * 1e-6 => 0.0,
            _ => value,
        };
        let to_next = borders.iter().map(|other| (other - value).abs()).filter(|d| *d > value.abs() * 1e-12);
        let least = to_next.fold(f64::INFINITY, f64::min) * 0.05;
        let is_close = |digits: &usize| {
            let read = number::parse(&number::general(value, *digits)).unwrap_or(f64::NAN);
            (read - value).abs() <= least.min(value.abs() * 0.001)
        };
        let digits = (1..17).find(is_close).unwrap_or(17);
        let label = number::general(value, digits);
        ticks::near_power(value).filter(|_| label.contains('×')).unwrap_or(label)
    }

    /// Marks of which all labels have the same digits after the point, unless a format says how many. On a logarithmic scale small
    /// numbers need digits that would be none beside large ones.
    fn alike(&self, mut ticks: Vec<Tick>) -> Vec<Tick> {
        if self.format == NumberFormat::Auto && self.colors.scale == Scale::Linear {
            let mut labels: Vec<String> =
                ticks.iter_mut().map(|tick| std::mem::take(&mut tick.label)).collect();
            number::with_equal_digits(&mut labels);
            ticks.iter_mut().zip(labels).for_each(|(tick, label)| tick.label = label);
        }
        ticks
    }
}
