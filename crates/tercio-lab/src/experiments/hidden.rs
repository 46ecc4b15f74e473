//! Inputs that a document does not state: swept, and not guessed.

/// A printed number that depends on an input that is not stated, with ours for a range of that input.
#[derive(Clone, Debug)]
pub struct Fit {
    /// The number: `394 polygons on the busiest processor`.
    pub number: String,
    /// The input, with its unit: `deviation of the columns`.
    pub input: &'static str,
    /// The least and the greatest number that is what is printed.
    print: [f64; 2],
    /// The swept values of the input, rising, and ours.
    points: Vec<(f64, f64)>,
}

impl Fit {
    /// A sweep: `points` are the input and ours, `printed` the number as it is printed, whose last digit is the
    /// tolerance.
    ///
    /// # Panics
    /// If `printed` is no number: a bug in the experiment.
    pub fn new(
        number: impl Into<String>,
        input: &'static str,
        printed: &str,
        points: Vec<(f64, f64)>,
    ) -> Self {
        let (print, half) = number_and_half_digit(printed);
        Self::within(number, input, [print - half, print + half], points)
    }

    /// A sweep whose print is a range: "at least", "up to twice".
    pub fn within(
        number: impl Into<String>,
        input: &'static str,
        print: [f64; 2],
        mut points: Vec<(f64, f64)>,
    ) -> Self {
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        Self { number: number.into(), input, print, points }
    }

    /// Whether some value of the input gives print.
    pub fn meets(&self) -> bool {
        !self.intervals().is_empty()
    }

    /// The intervals of the input in which ours is the printed number; straight lines between the points of the sweep.
    pub fn intervals(&self) -> Vec<[f64; 2]> {
        let [low, high] = self.print;
        let mut all: Vec<[f64; 2]> = Vec::new();
        for pair in self.points.windows(2) {
            let [(x0, y0), (x1, y1)] = [pair[0], pair[1]];
            if !(y0 + y1).is_finite() {
                continue;
            }
            // The part of the segment whose values lie between low and high, as a share of its length.
            let (from, to) = if y0 == y1 {
                if (low..=high).contains(&y0) { (0.0, 1.0) } else { continue }
            } else {
                let [a, b] = [low, high].map(|y| (y - y0) / (y1 - y0));
                (a.min(b).max(0.0), a.max(b).min(1.0))
            };
            if from > to {
                continue;
            }
            let [from, to] = [from, to].map(|share| x0 + share * (x1 - x0));
            match all.last_mut() {
                Some(last) if from - last[1] <= 1e-9 * (x1 - x0) => last[1] = to,
                _ => all.push([from, to]),
            }
        }
        all
    }

    /// The sweep's result in words.
    pub fn text(&self) -> String {
        let (first, last) = (self.points.first(), self.points.last());
        let range =
            first.zip(last).map_or(String::new(), |(f, l)| format!("{} to {}", short(f.0), short(l.0)));
        let ours = self.points.iter().map(|p| p.1).filter(|y| y.is_finite());
        let (least, most) = ours.fold((f64::MAX, f64::MIN), |(l, m), y| (l.min(y), m.max(y)));
        let intervals = self.intervals();
        if intervals.is_empty() {
            return format!(
                "{}: no {} from {range} gives it (ours {})",
                self.number,
                self.input,
                in_words(&[[least, most]])
            );
        }
        format!("{}: with {} {} of the swept {range}", self.number, self.input, in_words(&intervals))
    }
}

/// The intervals that two lists have in common.
pub fn common(a: &[[f64; 2]], b: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let pairs = a.iter().flat_map(|x| b.iter().map(move |y| [x[0].max(y[0]), x[1].min(y[1])]));
    pairs.filter(|i| i[0] <= i[1]).collect()
}

/// The intervals of several lists, those that touch as one, rising.
pub fn union(lists: impl IntoIterator<Item = Vec<[f64; 2]>>) -> Vec<[f64; 2]> {
    let mut all: Vec<_> = lists.into_iter().flatten().collect();
    all.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let mut joined: Vec<[f64; 2]> = Vec::new();
    for [from, to] in all {
        match joined.last_mut() {
            Some(last) if from <= last[1] => last[1] = last[1].max(to),
            _ => joined.push([from, to]),
        }
    }
    joined
}

/// Intervals in words.
pub fn in_words(intervals: &[[f64; 2]]) -> String {
    let one = |&[from, to]: &[f64; 2]| {
        let [a, b] = [short(from), short(to)];
        if a == b { a } else { format!("{a} to {b}") }
    };
    intervals.iter().map(one).collect::<Vec<_>>().join(" or ")
}

/// A printed number, with half a unit of its last digit: 27.36 and 0.005.
pub fn number_and_half_digit(printed: &str) -> (f64, f64) {
    let digits = printed.replace(',', "");
    let number: f64 = digits.parse().unwrap_or_else(|e| panic!("'{printed}' as a printed number: {e}"));
    let places = digits.split_once('.').map_or(0, |(_, fraction)| fraction.len());
    (number, 0.5 * 10f64.powi(-i32::try_from(places).unwrap_or(0)))
}

/// Four digits.
pub fn short(number: f64) -> String {
    let rounded: f64 = format!("{number:.3e}").parse().unwrap_or(number);
    rounded.to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_interval_is_where_the_line_meets_the_print() {
        let line = (0..=10).map(|i| (f64::from(i), 10.0 * f64::from(i))).collect();
        let fit = Fit::new("it", "slope", "42", line);
        let [[from, to]] = fit.intervals()[..] else { panic!("one interval") };
        assert!((from - 4.15).abs() < 1e-12 && (to - 4.25).abs() < 1e-12);
        assert!(fit.text().contains("4.15 to 4.25"), "{}", fit.text());
    }

    #[test]
    fn a_curve_can_meet_print_twice_or_never() {
        let bump = |printed| {
            let points = vec![(0.0, 0.0), (1.0, 10.0), (2.0, 0.0)];
            Fit::new("it", "x", printed, points)
        };
        assert_eq!(bump("5").intervals().len(), 2);
        // At the top the two halves touch.
        assert_eq!(bump("10").intervals().len(), 1);
        assert!(bump("11").intervals().is_empty());
        assert!(bump("11").text().contains("no x from 0 to 2"), "{}", bump("11").text());
    }

    #[test]
    fn a_range_may_be_open() {
        let points = vec![(0.0, 0.0), (10.0, 20.0), (20.0, 0.0), (30.0, 0.0)];
        let fit = Fit::within("it", "x", [10.0, f64::INFINITY], points.clone());
        assert_eq!(fit.intervals(), [[5.0, 15.0]]);
        assert!(!Fit::within("it", "x", [21.0, f64::INFINITY], points).meets());
    }

    #[test]
    fn the_last_digit_is_the_tolerance() {
        assert_eq!(number_and_half_digit("1.960"), (1.96, 0.0005));
        assert_eq!(number_and_half_digit("64,000"), (64_000.0, 0.5));
    }

    #[test]
    fn common_intervals() {
        assert_eq!(common(&[[0.0, 2.0], [5.0, 6.0]], &[[1.0, 5.5]]), [[1.0, 2.0], [5.0, 5.5]]);
        assert!(common(&[[0.0, 1.0]], &[[2.0, 3.0]]).is_empty());
        let lists = [vec![[5.0, 6.0], [8.0, 9.0]], vec![[0.0, 2.0], [1.0, 3.0]], Vec::new()];
        assert_eq!(union(lists), [[0.0, 3.0], [5.0, 6.0], [8.0, 9.0]]);
    }
}
