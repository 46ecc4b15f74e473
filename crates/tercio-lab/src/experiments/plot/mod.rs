//! Plots for print: few colours, our values as solid lines, published points hollow, ticks at round numbers.

mod draw;
mod scale;

/// A plot of series over two axes.
#[derive(Clone, Debug)]
pub struct Plot {
    /// The file's name without extension.
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
    /// The quantity, with its unit.
    pub label: String,
    /// Its scale.
    pub scale: Scale,
}

/// The scale of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Evenly.
    Linear,
    /// By powers of two.
    Log2,
    /// By powers of ten.
    Log10,
}

/// A series of points.
#[derive(Clone, Debug)]
pub struct Series {
    /// Its name in the legend.
    pub label: String,
    /// The origin of the numbers.
    pub role: Role,
    /// How they are drawn.
    pub mark: Mark,
    /// The points; those that are not finite, or not positive on a logarithmic axis, are skipped.
    pub points: Vec<(f64, f64)>,
}

/// The origin of a series.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Computed by us: full marks.
    Ours,
    /// From the document: hollow marks, dashed lines.
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
    /// An axis with a linear scale.
    pub fn linear(label: impl Into<String>) -> Self {
        Self { label: label.into(), scale: Scale::Linear }
    }

    /// An axis with a scale of powers of two.
    pub fn log2(label: impl Into<String>) -> Self {
        Self { label: label.into(), scale: Scale::Log2 }
    }

    /// An axis with a scale of powers of ten.
    pub fn log10(label: impl Into<String>) -> Self {
        Self { label: label.into(), scale: Scale::Log10 }
    }
}

impl Series {
    /// Our values as a line.
    pub fn line(label: impl Into<String>, points: Vec<(f64, f64)>) -> Self {
        Self { label: label.into(), role: Role::Ours, mark: Mark::Line, points }
    }

    /// Our values as points.
    pub fn points(label: impl Into<String>, points: Vec<(f64, f64)>) -> Self {
        Self { mark: Mark::Points, ..Self::line(label, points) }
    }

    /// Our values as points joined by a line.
    pub fn line_points(label: impl Into<String>, points: Vec<(f64, f64)>) -> Self {
        Self { mark: Mark::LinePoints, ..Self::line(label, points) }
    }

    /// Marks the series as the document's.
    #[must_use]
    pub fn published(self) -> Self {
        Self { role: Role::Published, ..self }
    }
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
}
