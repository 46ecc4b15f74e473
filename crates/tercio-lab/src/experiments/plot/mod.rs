//! Plots for print, as SVG and PDF: our values as solid lines and full symbols, published ones as dashed lines and hollow
//! symbols, bars for categories, the legend beside the data, and gaps where a value is not known. Symbols are only where a value is:
//! a closed formula is a line without any, of so many points that no corner can be seen. Series differ in colour and
//! symbol or dashes (bars in colour and hatching), colours also in lightness; one that lies under another is drawn wider.

mod bars;
mod draw;
mod label;
mod legend;
mod look;
mod palette;
mod scale;
mod symbols;

pub(super) use scale::six_digits;

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
    /// What is on a horizontal axis of categories, instead of numbers. The vertical one is then linear: bars stand on zero.
    pub categories: Option<Categories>,
}

/// Categories: the values of the axis are their numbers, and series are drawn as bars.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Categories {
    /// The number of the first.
    pub first: u32,
    /// Their names.
    pub names: Vec<String>,
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
    /// The label of the series whose colour and symbol this one has, too, if it can be told apart from it all the same: published
    /// values beside ours, a line beside points.
    pub like: Option<String>,
    /// The points. Those that are not finite, or not positive on a logarithmic axis, are gaps.
    pub points: Vec<(f64, f64)>,
}

/// The origin of a series. Values of a document's equations are ours: we evaluate them. The document's are only numbers that it
/// prints, or that are read from its figures.
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
    /// A line, of a formula or of values that lie close together.
    Line,
    /// Points.
    Points,
    /// Points joined by a line.
    LinePoints,
    /// Upright lines at places of the horizontal axis: of a number that is printed without the other one. Heights are not shown.
    Upright,
}

impl Axis {
    /// An axis with a linear scale.
    pub fn linear(label: impl Into<String>) -> Self {
        Self { label: label.into(), scale: Scale::Linear, categories: None }
    }

    /// An axis of categories, which are numbered from `first`.
    pub fn categories<N: Into<String>>(
        label: impl Into<String>,
        first: u32,
        names: impl IntoIterator<Item = N>,
    ) -> Self {
        let names = names.into_iter().map(Into::into).collect();
        Self { categories: Some(Categories { first, names }), ..Self::linear(label) }
    }

    /// An axis with a scale of powers of two.
    pub fn log2(label: impl Into<String>) -> Self {
        Self { label: label.into(), scale: Scale::Log2, categories: None }
    }

    /// An axis with a scale of powers of ten.
    pub fn log10(label: impl Into<String>) -> Self {
        Self { label: label.into(), scale: Scale::Log10, categories: None }
    }
}

impl Series {
    /// Our values as a line.
    pub fn line(label: impl Into<String>, points: Vec<(f64, f64)>) -> Self {
        Self { label: label.into(), role: Role::Ours, mark: Mark::Line, like: None, points }
    }

    /// Our values as points.
    pub fn points(label: impl Into<String>, points: Vec<(f64, f64)>) -> Self {
        Self { mark: Mark::Points, ..Self::line(label, points) }
    }

    /// Our values as points joined by a line.
    pub fn line_points(label: impl Into<String>, points: Vec<(f64, f64)>) -> Self {
        Self { mark: Mark::LinePoints, ..Self::line(label, points) }
    }

    /// A closed formula between two places on the horizontal axis, as a line that bends where the formula does.
    pub fn formula(
        label: impl Into<String>,
        scale: Scale,
        [low, high]: [f64; 2],
        of: impl Fn(f64) -> f64,
    ) -> Self {
        /// A step is about two pixels wide.
        const STEPS: u32 = 256;
        let place = |share: f64| match scale {
            Scale::Linear => low + share * (high - low),
            Scale::Log2 | Scale::Log10 => low * (high / low).powf(share),
        };
        let places = (0..=STEPS).map(|step| place(f64::from(step) / f64::from(STEPS)));
        Self::line(label, places.map(|x| (x, of(x))).collect())
    }

    /// Places on the horizontal axis that a document prints, without heights.
    pub fn printed_places(label: impl Into<String>, places: impl IntoIterator<Item = f64>) -> Self {
        let points = places.into_iter().map(|x| (x, f64::NAN)).collect();
        Self { mark: Mark::Upright, ..Self::line(label, points) }.published()
    }

    /// Marks the series as the document's.
    #[must_use]
    pub fn published(self) -> Self {
        Self { role: Role::Published, ..self }
    }

    /// Gives the series the colour and symbol of the series `label`.
    #[must_use]
    pub fn like(self, label: impl Into<String>) -> Self {
        Self { like: Some(label.into()), ..self }
    }

    /// Marks the series as the document's values of what the series `label` has as ours.
    #[must_use]
    pub fn published_for(self, label: impl Into<String>) -> Self {
        self.published().like(label)
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
