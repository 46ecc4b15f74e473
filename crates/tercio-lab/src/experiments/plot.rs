//! Plots for a paper: few colours, ours as full lines, published points hollow, ticks at round numbers.

use std::ops::Range;

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};
use plotters::prelude::*;

/// Width and height of a plot in SVG units. Places are rounded to whole units, so a plot is drawn large and shown
/// smaller.
const SIZE: (u32, u32) = (1280, 880);
const TITLE_SIZE: u32 = 30;
const LABEL_SIZE: u32 = 26;
/// The palette of Okabe and Ito, told apart by colour-blind readers, too.
const COLORS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(0, 0, 0),
];
/// Ticks on an axis, about.
const TICKS: f64 = 8.0;

/// A plot of series over two axes.
#[derive(Clone, Debug)]
pub struct Plot {
    /// The file's name without its ending.
    pub name: String,
    /// What is shown.
    pub title: String,
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// The series, drawn in order.
    pub series: Vec<Series>,
}

/// An axis.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Axis {
    /// What it shows, with the unit.
    pub label: String,
    /// How it is divided.
    pub scale: Scale,
}

/// How an axis is divided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Evenly, from zero or below.
    Linear,
    /// By powers of two.
    Log2,
    /// By powers of ten.
    Log10,
}

/// Points that belong together.
#[derive(Clone, Debug)]
pub struct Series {
    /// Its name in the legend.
    pub label: String,
    /// Whose numbers they are.
    pub role: Role,
    /// How they are drawn.
    pub mark: Mark,
    /// The points; those that are not finite, or not positive on a logarithmic axis, are left out.
    pub points: Vec<(f64, f64)>,
}

/// Whose numbers a series has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Ours: full marks.
    Ours,
    /// The document's: hollow marks, dashed lines.
    Published,
}

/// How a series is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// A line.
    Line,
    /// Points.
    Points,
    /// Points joined by a line.
    LinePoints,
}

impl Axis {
    /// An axis divided evenly.
    pub fn linear(label: impl Into<String>) -> Self {
        Self { label: label.into(), scale: Scale::Linear }
    }

    /// An axis divided by powers of two.
    pub fn log2(label: impl Into<String>) -> Self {
        Self { label: label.into(), scale: Scale::Log2 }
    }

    /// An axis divided by powers of ten.
    pub fn log10(label: impl Into<String>) -> Self {
        Self { label: label.into(), scale: Scale::Log10 }
    }
}

impl Series {
    /// Ours as a line.
    pub fn line(label: impl Into<String>, points: Vec<(f64, f64)>) -> Self {
        Self { label: label.into(), role: Role::Ours, mark: Mark::Line, points }
    }

    /// Ours as points.
    pub fn points(label: impl Into<String>, points: Vec<(f64, f64)>) -> Self {
        Self { mark: Mark::Points, ..Self::line(label, points) }
    }

    /// Ours as points joined by a line.
    pub fn line_points(label: impl Into<String>, points: Vec<(f64, f64)>) -> Self {
        Self { mark: Mark::LinePoints, ..Self::line(label, points) }
    }

    /// The same as the document's.
    #[must_use]
    pub fn published(self) -> Self {
        Self { role: Role::Published, ..self }
    }
}

impl Scale {
    /// Where a value lies on the axis, evenly divided.
    fn place(self, value: f64) -> f64 {
        match self {
            Self::Linear => value,
            Self::Log2 => value.log2(),
            Self::Log10 => value.log10(),
        }
    }

    /// The ends of the axis and its ticks, for values between `low` and `high` as placed.
    fn ticks(self, low: f64, high: f64) -> (f64, f64, Vec<f64>) {
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

/// An axis as the plotting library wants it: values as placed, ticks where we put them.
struct Division {
    low: f64,
    high: f64,
    ticks: Vec<f64>,
    scale: Scale,
}

impl Ranged for Division {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        let share = (value - self.low) / (self.high - self.low);
        limit.0 + (share * f64::from(limit.1 - limit.0)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, _hint: Hint) -> Vec<f64> {
        self.ticks.clone()
    }

    fn range(&self) -> Range<f64> {
        self.low..self.high
    }
}

impl ValueFormatter<f64> for Division {
    fn format_ext(&self, place: &f64) -> String {
        self.scale.tick_label(*place)
    }
}

/// A number with at most six digits, thousands parted.
fn grouped(number: f64) -> String {
    let digits =
        if number == 0.0 { 0 } else { (5 - number.abs().log10().floor() as i32).clamp(0, 9) as usize };
    let text = format!("{number:.digits$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    let (sign, text) = text.strip_prefix('-').map_or(("", text), |rest| ("-", rest));
    let (whole, fraction) = text.split_once('.').map_or((text, String::new()), |(w, f)| (w, format!(".{f}")));
    let mut parted = String::new();
    for (i, digit) in whole.chars().enumerate() {
        if i > 0 && (whole.len() - i).is_multiple_of(3) {
            parted.push(',');
        }
        parted.push(digit);
    }
    format!("{sign}{parted}{fraction}")
}

impl Plot {
    /// An empty plot.
    pub fn new(name: impl Into<String>, title: impl Into<String>, x: Axis, y: Axis) -> Self {
        Self { name: name.into(), title: title.into(), x, y, series: Vec::new() }
    }

    /// The plot with one more series.
    #[must_use]
    pub fn with(mut self, series: Series) -> Self {
        self.series.push(series);
        self
    }

    /// The points of a series as placed, without those that have no place.
    fn placed(&self, series: &Series) -> Vec<(f64, f64)> {
        let place = |&(x, y): &(f64, f64)| (self.x.scale.place(x), self.y.scale.place(y));
        series.points.iter().map(place).filter(|(x, y)| x.is_finite() && y.is_finite()).collect()
    }

    /// The axis for places on it.
    fn division(scale: Scale, places: impl Iterator<Item = f64>) -> Division {
        let (low, high) = places.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
        let (low, high) = if low > high { (0.0, 1.0) } else { (low, high) };
        // Quantities are compared by their height above zero.
        let low = if scale == Scale::Linear { low.min(0.0) } else { low };
        let (low, high, ticks) = scale.ticks(low, high);
        Division { low, high, ticks, scale }
    }

    /// The plot as SVG.
    ///
    /// # Errors
    /// What the plotting library cannot draw.
    pub fn to_svg(&self) -> Result<String, String> {
        let mut svg = String::new();
        self.draw(&mut svg).map_err(|e| format!("plot {}: {e}", self.name))?;
        // Shown as wide as its frame, not in the units it is drawn in.
        let fixed = format!("width=\"{}\" height=\"{}\" ", SIZE.0, SIZE.1);
        Ok(svg.replacen(&fixed, "", 1))
    }

    fn draw(&self, svg: &mut String) -> Result<(), Box<dyn std::error::Error>> {
        let placed: Vec<_> = self.series.iter().map(|s| self.placed(s)).collect();
        let x = Self::division(self.x.scale, placed.iter().flatten().map(|p| p.0));
        let y = Self::division(self.y.scale, placed.iter().flatten().map(|p| p.1));
        let middle = (0.5 * (x.low + x.high), 0.5 * (y.low + y.high));
        let root = SVGBackend::with_string(svg, SIZE).into_drawing_area();
        root.fill(&WHITE)?;
        let mut chart = ChartBuilder::on(&root)
            .caption(&self.title, ("sans-serif", TITLE_SIZE))
            .margin(24)
            .x_label_area_size(80)
            .y_label_area_size(120)
            .build_cartesian_2d(x, y)?;
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(BLACK.mix(0.12))
            .x_desc(&self.x.label)
            .y_desc(&self.y.label)
            .axis_desc_style(("sans-serif", LABEL_SIZE))
            .label_style(("sans-serif", LABEL_SIZE - 4))
            .draw()?;
        for (i, (series, points)) in self.series.iter().zip(placed).enumerate() {
            let color = COLORS[i % COLORS.len()];
            let published = series.role == Role::Published;
            let mut labelled = false;
            if series.mark != Mark::Points {
                let style = color.stroke_width(3);
                let drawn = if published {
                    chart.draw_series(DashedLineSeries::new(points.iter().copied(), 10, 8, style))?
                } else {
                    chart.draw_series(LineSeries::new(points.iter().copied(), style))?
                };
                drawn.label(&series.label).legend(move |(x, y)| {
                    let end = if published { x + 14 } else { x + 30 };
                    PathElement::new(vec![(x, y), (end, y)], color.stroke_width(3))
                });
                labelled = true;
            }
            if series.mark != Mark::Line {
                let style = if published { color.stroke_width(3) } else { color.filled() };
                let drawn = chart.draw_series(points.iter().map(|&p| Circle::new(p, 7, style)))?;
                if !labelled {
                    drawn.label(&series.label).legend(move |(x, y)| Circle::new((x + 15, y), 7, style));
                }
            }
        }
        if self.series.len() > 1 {
            chart
                .configure_series_labels()
                .position(self.empty_corner(middle))
                .label_font(("sans-serif", LABEL_SIZE - 4))
                .background_style(WHITE.mix(0.85))
                .border_style(BLACK.mix(0.3))
                .draw()?;
        }
        root.present()?;
        Ok(())
    }

    /// The corner with fewest points, for the legend.
    fn empty_corner(&self, (x_half, y_half): (f64, f64)) -> SeriesLabelPosition {
        let points: Vec<_> = self.series.iter().flat_map(|s| self.placed(s)).collect();
        let within = |right: bool, upper: bool| {
            points.iter().filter(|p| (p.0 > x_half) == right && (p.1 > y_half) == upper).count()
        };
        let corners = [
            (within(true, true), SeriesLabelPosition::UpperRight),
            (within(false, true), SeriesLabelPosition::UpperLeft),
            (within(true, false), SeriesLabelPosition::LowerRight),
            (within(false, false), SeriesLabelPosition::LowerLeft),
        ];
        let best = corners.into_iter().min_by_key(|c| c.0);
        best.map_or(SeriesLabelPosition::UpperRight, |c| c.1)
    }
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
        assert_eq!(Scale::Log10.tick_label(6.0), "1,000,000");
        assert_eq!(grouped(-1234.5), "-1,234.5");
        assert_eq!(grouped(0.0025), "0.0025");
    }

    #[test]
    fn a_plot_has_its_labels_and_is_the_same_each_time() {
        let plot = || {
            Plot::new("p", "Passes < all", Axis::log2("d"), Axis::linear("instructions"))
                .with(Series::line("ours", vec![(1.0, 2.0), (4.0, 8.0)]))
                .with(Series::points("printed", vec![(2.0, 4.0), (f64::NAN, 1.0), (0.0, 1.0)]).published())
        };
        let svg = plot().to_svg().unwrap();
        assert!(svg.contains("Passes &lt; all") && svg.contains("printed") && svg.contains("viewBox"));
        assert_eq!(svg, plot().to_svg().unwrap());
    }

    #[test]
    fn a_plot_without_points_is_drawn() {
        assert!(Plot::new("p", "t", Axis::log10("x"), Axis::linear("y")).to_svg().is_ok());
    }
}
