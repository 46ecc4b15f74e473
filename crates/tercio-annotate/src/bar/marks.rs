//! Which numbers a bar is marked with.

use tercio_scene::color_map::Scale;

use super::ScalarBar;
use crate::number::{self, NumberFormat, exponent_of};
use crate::ticks::{self, Tick};

impl ScalarBar {
    /// The marks, of which at most `most` have labels: the borders of bands if there are few enough, round numbers otherwise.
    pub(super) fn ticks(&self, most: usize) -> Vec<Tick> {
        let most = most.max(2);
        let borders = self.colors.boundaries();
        if !borders.is_empty() && borders.len() <= most {
            return self.of_borders(&borders);
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
        borders.iter().map(|&value| Tick { value, label: print(value) }).collect()
    }
}
