//! Which numbers a bar is marked with.

use tercio_scene::color_map::Scale;

use super::{Marks, Parts, ScalarBar};
use crate::number::{self, NumberFormat, exponent_of};
use crate::ticks::{self, Tick};

/// Borders of more bands are no marks: it is hard to see them.
const MOST_BORDERS: usize = 101;

/// Marks of which only every second, third ... has a label if there are more than `most`.
fn thinned(mut ticks: Vec<Tick>, most: usize) -> Vec<Tick> {
    let every = (ticks.len() - 1).div_ceil(most.max(2) - 1).max(1);
    for (number, tick) in ticks.iter_mut().enumerate() {
        if number % every > 0 {
            tick.label.clear();
        }
    }
    ticks
}

impl ScalarBar {
    /// The marks, of which at most `most` have labels: where they are asked for, at the borders of bands, or at round numbers. Those
    /// that are not free to be elsewhere may have labels as close as `most_close` of them.
    pub(crate) fn ticks(&self, most: usize, most_close: usize) -> Vec<Tick> {
        let most = most.max(2);
        let asked = self.asked();
        if !asked.is_empty() {
            let ticks = if matches!(self.marks, Marks::At(_)) {
                self.alike(asked.iter().map(|&value| Tick { value, label: self.exactly(value) }).collect())
            } else {
                self.of_borders(&asked)
            };
            return thinned(ticks, most.max(most_close));
        }
        let borders = self.colors.boundaries();
        if !borders.is_empty() && borders.len() <= MOST_BORDERS {
            return thinned(self.of_borders(&borders), most.max(most_close));
        }
        let range = self.colors.range;
        let ticks = match self.colors.scale {
            Scale::Linear => ticks::linear(range, most, self.format),
            Scale::Log => ticks::logarithmic(range, most, self.format),
            Scale::SymmetricLog { threshold } => ticks::symmetric(range, threshold, most, self.format),
        };
        // Formats with few digits may print several numbers alike.
        let mut last = None;
        let is_new = |tick: &Tick| {
            tick.label.is_empty() || last.replace(tick.label.clone()).as_ref() != Some(&tick.label)
        };
        ticks.into_iter().filter(is_new).collect()
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
    pub(super) fn unmarked(&self, parts: &Parts, name: &str) -> Option<String> {
        if let Marks::At(values) = &self.marks
            && let Some(value) = values.iter().find(|v| !self.has(**v))
        {
            return Some(format!("the mark {value} of {name}, which is not in its range"));
        }
        let is_thinned = self.marks != Marks::Usual && parts.ticks.iter().any(|tick| tick.label.is_empty());
        is_thinned.then(|| format!("some numbers of {name}"))
    }

    /// The borders of bands, with as many digits as it takes to know them to a hundredth of a band.
    fn of_borders(&self, borders: &[f64]) -> Vec<Tick> {
        let width = borders.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min);
        let largest = borders.iter().fold(0.0f64, |largest, border| largest.max(border.abs()));
        // A border that is almost 0 is 0 beside the others.
        let after_point = 2 - exponent_of(width);
        let is_plain = (0..=9).contains(&after_point) && largest < 1e6;
        let is_close = |digits: usize| {
            let read = |v: f64| number::parse(&number::general(v, digits)).unwrap_or(f64::NAN);
            borders.iter().all(|&v| (read(v) - v).abs() <= width * 0.01)
        };
        let digits = (1..17).find(|&digits| is_close(digits)).unwrap_or(17);
        let print = |value| match self.format {
            NumberFormat::Auto if is_plain => {
                number::without_zeros(&number::fixed(value, after_point as usize))
            }
            NumberFormat::Auto => number::general(value, digits),
            format => format.print(value),
        };
        self.alike(borders.iter().map(|&value| Tick { value, label: print(value) }).collect())
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
