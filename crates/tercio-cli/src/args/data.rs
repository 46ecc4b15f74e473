//! Options of colours by data.

use std::path::Path;

use anyhow::{Context, Result, bail};
use clap::{Args, ValueEnum};
use serde_json::{Value, json};
use tercio::Normals;
use tercio::data::{
    DataError, DataOptions, Ends, IsolineOptions, Made, RangeEnd, ScaleOption, Statistics, StrokeData,
    needs_normals,
};
use tercio::glam::DVec3;
use tercio::mesh::loops::prelude::*;
use tercio::mesh::strokes::Strokes;
use tercio::parallel::Communicator;
use tercio::scene::color_map::{ColorMap, Scale};
use tercio::scene::{DataColors, DataReader, Instance, SurfaceData};

use super::color_list::{color_list, what_is_wrong};
use super::values;
use crate::named_files::NamedFiles;
use crate::output::UsageError;

/// Colours by data.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Data")]
pub struct DataArgs {
    /// Colours the model, its lines and points by an attribute (tercio info lists them; of a vector, its magnitude),
    /// NAME:COMPONENT (a number, x, y, z, or what the file calls it), NAME:magnitude, or NAME:rgb for colours; NAME@point and NAME@cell where both have the name (NAME@cell:COMPONENT, too) [default: point]; or by what is made of the model: @elevation, @normal, @normal:x (y, z), @curvature,
    /// @component, @face; or by what every format has: @x, @y, @z (coordinates of the file), @color, @color:red (green, blue, alpha; 0 to 255),
    /// @texcoord:u (v), or the names that files have for them, such as x, nx, red, u.
    #[arg(long, value_name = "NAME", aliases = ["scalars", "coloring-array"])]
    color_by: Option<String>,
    /// Colours of the range, by a name that matplotlib or ParaView know (viridis, coolwarm, turbo, Set1, ...; _r reverses one),
    /// a file with a colour a line, or ParaView's JSON (colours that it names values for are those of --categories), or a list of values
    /// and colours: 0,black,0.5,red,1,white [default: viridis; of categories Set1 or tab20].
    #[arg(long, value_name = "NAME", aliases = ["cmap", "color-map", "colormap-file"], requires = "color_by")]
    colormap: Option<String>,
    /// Ends of the range: values, or percentiles such as 2%,98%; an empty one is that of the data [default: the least and the
    /// greatest finite value].
    #[arg(long, value_name = "MIN,MAX", aliases = ["clim", "coloring-range"], requires = "color_by")]
    #[arg(allow_hyphen_values = true, value_parser = ends)]
    range: Option<Ends>,
    /// Spreads the logarithms of values. Those at or below 0 have none, and are painted as values below the range.
    #[arg(long, alias = "log-scale", requires = "color_by", conflicts_with = "symlog")]
    log: bool,
    /// Spreads logarithms on both sides of 0, and what is closer to 0 than a threshold evenly [default: a thousandth of the
    /// greatest absolute value of the range].
    #[arg(long, value_name = "THRESHOLD", num_args = 0..=1, default_missing_value = "auto", require_equals = true)]
    #[arg(value_parser = threshold, requires = "color_by")]
    symlog: Option<Threshold>,
    /// Bands of one colour each, 1 to 65536, in place of a smooth transition.
    #[arg(long, aliases = ["n-colors", "colormap-discretization"], value_name = "N", requires = "color_by")]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=65536))]
    bands: Option<u32>,
    /// Lines of equal value: how many, spread evenly over the range, or their values with commas (a single one ends with a comma).
    #[arg(long, value_name = "N|V1,V2", allow_hyphen_values = true, value_parser = isolines, requires = "color_by")]
    isolines: Option<Lines>,
    /// Colour of the lines of --isolines and --mode contours [default: #000000; in SVG and PDF that of their value].
    #[arg(long, value_name = "COLOR", value_parser = values::color, requires = "color_by")]
    isoline_color: Option<[u8; 4]>,
    /// Width of the lines of --isolines and --mode contours in pixels, 0 to 1000 [default: 1.5].
    #[arg(long, value_name = "PIXELS", value_parser = width, requires = "color_by")]
    isoline_width: Option<f64>,
    /// Colour of what is not a number [default: that of the file of --colormap, or #a0a0a0].
    #[arg(long, value_name = "COLOR", value_parser = values::color, requires = "color_by")]
    nan_color: Option<[u8; 4]>,
    /// Colour of values below the range [default: that of the file of --colormap, or of the lower end].
    #[arg(long, value_name = "COLOR", value_parser = values::color, requires = "color_by")]
    below_color: Option<[u8; 4]>,
    /// Colour of values above the range [default: that of the file of --colormap, or of the upper end].
    #[arg(long, value_name = "COLOR", value_parser = values::color, requires = "color_by")]
    above_color: Option<[u8; 4]>,
    /// Opacities, 0 to 1, spread evenly over the range and linear between them, such as 0,1.
    #[arg(long, value_name = "O1,O2", value_parser = opacities, requires = "color_by")]
    opacity_map: Option<Opacities>,
    /// Values are names, not quantities, and each different one (at most 4096) has a colour; those at vertices are not
    /// interpolated. The colours of a list such as tab20 repeat after its last. Labels for the scalar bar may follow: --categories=1=bone,4=skin.
    #[arg(long, value_name = "V=LABEL", num_args = 0..=1, default_missing_value = "", require_equals = true)]
    #[arg(value_parser = labels, requires = "color_by")]
    #[arg(conflicts_with_all = ["range", "log", "symlog", "bands", "isolines", "below_color", "above_color", "opacity_map"])]
    categories: Option<Labels>,
    /// Whose values the range of a series of models covers, where it follows from the data: all of them are read before the first
    /// one is drawn, so that a colour means the same in all pictures; or only the first one; or each has its own. Likewise of
    /// the models of one picture (--together) or of a batch that are coloured alike, and of all pictures of a sheet [default: all; of
    /// a batch, each].
    #[arg(long, value_name = "STEPS", value_enum, requires = "color_by")]
    range_over: Option<RangeOver>,
    /// Of the series that the model belongs to.
    #[arg(skip)]
    of_series: Option<Statistics>,
    /// Whether a model of the series has what is no number or no category.
    #[arg(skip)]
    series_has_others: bool,
    /// Whether doubts were reported with an earlier model of the series.
    #[arg(skip)]
    are_doubts_known: bool,
}

/// `--range-over`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum RangeOver {
    /// All models.
    All,
    /// The first one.
    First,
    /// Each for itself.
    Each,
}

/// What the colours of a series of models have in common.
#[derive(Clone, Debug, Default)]
pub struct Survey {
    statistics: Statistics,
    range: Option<[f64; 2]>,
    categories: Vec<(f64, String)>,
    /// Whether they are categories because the colour map names values.
    has_names: bool,
    /// Whether something is no number, or has none of them.
    has_others: bool,
}

impl Survey {
    /// That of two sets of models together.
    #[must_use]
    pub fn and(mut self, other: Self) -> Self {
        self.statistics = self.statistics.and(other.statistics);
        self.range = match (self.range, other.range) {
            (Some(a), Some(b)) => Some([a[0].min(b[0]), a[1].max(b[1])]),
            (a, b) => a.or(b),
        };
        self.has_others |= other.has_others;
        self.has_names |= other.has_names;
        self.categories.extend(other.categories);
        self.categories.sort_by(|a, b| a.0.total_cmp(&b.0));
        self.categories.dedup_by(|a, b| a.0 == b.0);
        self
    }
}

/// `--symlog`.
#[derive(Clone, Copy, Debug)]
struct Threshold(Option<f64>);

/// `--isolines`.
#[derive(Clone, Debug)]
struct Lines(Result<Vec<f64>, u32>);

/// `--opacity-map`.
#[derive(Clone, Debug)]
struct Opacities(Vec<f32>);

/// `--categories`.
#[derive(Clone, Debug)]
struct Labels(Vec<(f64, String)>);

fn ends(text: &str) -> Result<Ends, String> {
    let expected =
        || "expected MIN,MAX: numbers, percentiles such as 2%, or nothing for those of the data".to_owned();
    let end = |text: &str| match (text.trim(), text.trim().strip_suffix('%')) {
        ("", _) => Ok(RangeEnd::OfData),
        (_, Some(percent)) => {
            let share = values::number(percent.trim()).ok().map(|p| p / 100.0);
            share.filter(|s| (0.0..=1.0).contains(s)).map(RangeEnd::Percentile).ok_or_else(expected)
        }
        (value, None) => values::number(value).map(RangeEnd::At).map_err(|_| expected()),
    };
    let (low, high) = text.split_once(',').ok_or_else(expected)?;
    let ends = Ends { low: end(low)?, high: end(high)? };
    match (ends.low, ends.high) {
        (RangeEnd::At(low), RangeEnd::At(high)) | (RangeEnd::Percentile(low), RangeEnd::Percentile(high))
            if low >= high =>
        {
            Err("expected MIN below MAX".into())
        }
        _ => Ok(ends),
    }
}

fn threshold(text: &str) -> Result<Threshold, String> {
    match text {
        "auto" => Ok(Threshold(None)),
        _ => values::positive(text).map(|value| Threshold(Some(value))),
    }
}

fn isolines(text: &str) -> Result<Lines, String> {
    const EXPECTED: &str = "expected how many, 1 to 256, or at most 256 numbers with commas between";
    if let Ok(count) = text.trim().parse::<u32>() {
        return if (1..=256).contains(&count) { Ok(Lines(Err(count))) } else { Err(EXPECTED.into()) };
    }
    let words = text.split(',').map(str::trim).filter(|word| !word.is_empty());
    let values: Result<Vec<f64>, String> = words.map(values::number).collect();
    match values {
        Ok(values) if (1..=256).contains(&values.len()) => Ok(Lines(Ok(values))),
        _ => Err(EXPECTED.into()),
    }
}

fn width(text: &str) -> Result<f64, String> {
    let width = values::number(text).ok().filter(|w| (0.0..=1000.0).contains(w));
    width.ok_or_else(|| "expected a width of 0 to 1000 pixels".into())
}

fn opacities(text: &str) -> Result<Opacities, String> {
    let all: Result<Vec<f64>, String> = text.split(',').map(|word| values::opacity(word.trim())).collect();
    all.map(|all| Opacities(all.into_iter().map(|o| o as f32).collect()))
}

fn labels(text: &str) -> Result<Labels, String> {
    let label = |word: &str| {
        let (value, label) = word.split_once('=').ok_or("expected labels such as 1=bone,4=skin")?;
        Ok((values::number(value.trim())?, label.trim().to_owned()))
    };
    let words = text.split(',').filter(|word| !word.is_empty());
    words.map(label).collect::<Result<_, String>>().map(Labels)
}

/// A colour map without a file: by its name, or a list of colours.
fn known(name: &str) -> Option<ColorMap> {
    ColorMap::named(name).or_else(|| color_list(name))
}

/// The file that the name of a colour map means, if it is not a known one.
fn file(name: &str) -> Option<&Path> {
    let looks_like_one = name.contains(['/', '.']) && !name.contains(',');
    known(name).is_none().then(|| Path::new(name)).filter(|path| path.exists() || looks_like_one)
}

impl DataArgs {
    /// Is the model coloured by data?
    pub fn is_given(&self) -> bool {
        self.color_by.is_some()
    }

    /// Names that are not known are reported as a mistake.
    ///
    /// # Errors
    /// [`UsageError`].
    pub fn check(&self) -> Result<(), UsageError> {
        match &self.colormap {
            Some(name) if known(name).is_none() && file(name).is_none() => {
                if name.contains(',') {
                    let text = format!(
                        "\"{name}\" is no list of ascending values and their colours, such as 0,black,1,white: {}",
                        what_is_wrong(name)
                    );
                    return Err(UsageError(text));
                }
                let names: Vec<&str> = ColorMap::names().collect();
                let known = names.join(", ");
                let text = format!(
                    "there is no colour map \"{name}\", and no file of that name; there are {known}; _r reverses one"
                );
                Err(UsageError(text))
            }
            _ => Ok(()),
        }
    }

    /// Options of isolines without any are reported as a mistake.
    ///
    /// # Errors
    /// One sentence.
    pub fn check_isolines(&self, is_contours: bool) -> Result<(), String> {
        let is_given = self.isoline_color.is_some() || self.isoline_width.is_some();
        if is_given && self.isolines.is_none() && !is_contours {
            return Err(
                "--isoline-color and --isoline-width have no effect without --isolines or --mode contours"
                    .into(),
            );
        }
        Ok(())
    }

    /// The colour of isolines, if it is given.
    pub fn isoline_color(&self) -> Option<[u8; 4]> {
        self.isoline_color
    }

    /// Their width in pixels, if it is given.
    pub fn isoline_width(&self) -> Option<f64> {
        self.isoline_width
    }

    /// Adds the file of the colour map to the inputs.
    pub fn named_files(&self, files: NamedFiles) -> NamedFiles {
        match self.colormap.as_deref().and_then(file) {
            Some(path) => files.reads("the colour map", path),
            None => files,
        }
    }

    /// Normals that the model shall have, if `wanted` are those for drawing, and glyphs show a vector of this name.
    pub fn normals(&self, wanted: Normals, glyphs: Option<&str>) -> Normals {
        let is_needed = self.color_by.as_deref().into_iter().chain(glyphs).any(needs_normals);
        if is_needed && wanted == Normals::File { Normals::default() } else { wanted }
    }

    /// The attribute that has to be made when the model is read.
    pub fn made(&self) -> Option<Made> {
        self.color_by.as_deref().and_then(Made::of_name)
    }

    fn map(&self) -> Result<Option<ColorMap>> {
        let Some(name) = &self.colormap else { return Ok(None) };
        if let Some(map) = known(name) {
            return Ok(Some(map));
        }
        let map = std::fs::read(name).map_err(anyhow::Error::from);
        let map = map.and_then(|text| Ok(ColorMap::parse(name, &text)?));
        map.map(Some).with_context(|| format!("{name} as a colour map"))
    }

    /// Whether an option is given that categories do not have.
    fn needs_quantities(&self) -> bool {
        self.range.is_some()
            || self.log
            || self.symlog.is_some()
            || self.bands.is_some()
            || self.isolines.is_some()
            || self.below_color.is_some()
            || self.above_color.is_some()
            || self.opacity_map.is_some()
    }

    fn changes_map(&self) -> bool {
        self.needs_quantities()
            || self.colormap.is_some()
            || self.nan_color.is_some()
            || self.categories.is_some()
    }

    /// How surfaces are coloured, where up is there.
    fn options(&self, up: DVec3) -> Result<Option<DataOptions>> {
        let Some(by) = &self.color_by else { return Ok(None) };
        let scale = match self.symlog {
            _ if self.log => ScaleOption::Log,
            Some(Threshold(threshold)) => ScaleOption::SymmetricLog(threshold),
            None => ScaleOption::Linear,
        };
        let isolines = self.isolines.as_ref().map(|lines| IsolineOptions {
            at: lines.0.clone(),
            color: self.isoline_color.unwrap_or([0, 0, 0, 255]),
            width: self.isoline_width.unwrap_or(1.5) as f32,
        });
        let map = self.map()?;
        // Those that the file of a map has.
        let special = map.as_ref().map(ColorMap::special).unwrap_or_default();
        let has_names = map.as_ref().is_some_and(ColorMap::names_values) && !self.needs_quantities();
        let labels = self.categories.as_ref().map(|labels| labels.0.clone());
        Ok(Some(DataOptions {
            map,
            range: self.range.unwrap_or_default(),
            scale,
            bands: self.bands,
            isolines,
            nan: self.nan_color.or(special.nan).unwrap_or(DataColors::NAN),
            below: self.below_color.or(special.below),
            above: self.above_color.or(special.above),
            opacities: self.opacity_map.as_ref().map_or_else(Vec::new, |map| map.0.clone()),
            categories: labels.or_else(|| has_names.then(Vec::new)),
            up,
            ..DataOptions::new(by)
        }))
    }

    /// Whose values the colours of a series depend on; `None` if on those of no model.
    pub fn range_over(&self) -> Option<RangeOver> {
        let is_given = |range: &Ends| matches!((range.low, range.high), (RangeEnd::At(_), RangeEnd::At(_)));
        let follows = self.is_given() && !self.range.as_ref().is_some_and(is_given);
        follows.then_some(self.range_over.unwrap_or(RangeOver::All))
    }

    /// The same for models that have pictures of their own: their colours depend on each other only if that is asked for.
    pub fn range_over_batch(&self) -> Option<RangeOver> {
        self.range_over.and_then(|_| self.range_over()).filter(|over| *over != RangeOver::Each)
    }

    /// What the colours of an instance, and of its lines and points, depend on.
    ///
    /// # Errors
    /// Data that are not there. Those without a finite value are none: other models of the series may have some.
    pub fn survey(&self, instance: &Instance, strokes: &Strokes, up: DVec3) -> Result<Survey> {
        let Some(options) = self.options(up)? else { return Ok(Survey::default()) };
        let mut survey = Survey::default();
        let of_all = |own: Statistics| {
            survey.statistics = own;
            Ok(own)
        };
        match options.data_of_model::<DataError>(instance, strokes, of_all) {
            Ok(data) => {
                if let Some(colors) = data.colors() {
                    survey.range = Some(colors.range);
                    let categories = colors.categories.iter();
                    survey.categories = categories.map(|c| (c.value, c.label.clone())).collect();
                }
                survey.has_names = self.categories.is_none() && options.categories.is_some();
                let surface = data.surface.as_deref();
                survey.has_others = self.looks_for_others(surface)
                    && has_others(instance, surface, data.strokes.as_ref(), true);
            }
            Err(DataError::NoNumbers(_) | DataError::NotPositive { .. } | DataError::Range { .. }) => {}
            Err(error) => return Err(error.into()),
        }
        Ok(survey)
    }

    /// Whether a series is known that the model belongs to.
    pub fn is_of_series(&self) -> bool {
        self.of_series.is_some()
    }

    /// These options for a model of a series behind the first, whose doubts are not repeated.
    #[must_use]
    pub fn behind_the_first(self) -> Self {
        Self { are_doubts_known: true, ..self }
    }

    /// These options for a model of a series of which that is known.
    #[must_use]
    pub fn of_series(&self, survey: &Survey) -> Self {
        let mut own = self.clone();
        own.of_series = Some(survey.statistics);
        own.series_has_others = survey.has_others;
        if own.categories.is_some() || survey.has_names {
            own.categories = Some(Labels(survey.categories.clone()));
        }
        if let (Some(ends), Some(range)) = (&mut own.range, survey.range) {
            // Those of all models lie between the least and the greatest of each.
            let at = |end: RangeEnd, value: f64| match end {
                RangeEnd::Percentile(_) => RangeEnd::At(value),
                end => end,
            };
            *ends = Ends { low: at(ends.low, range[0]), high: at(ends.high, range[1]) };
        }
        own
    }

    /// Colours an instance by its data, and returns the data of its lines and points, and what users should know; together with the
    /// ranks that have the other parts of it, if there are `parts`.
    ///
    /// # Errors
    /// Data that are not there, with a list of those that are.
    pub fn apply(
        &self,
        instance: &mut Instance,
        up: DVec3,
        strokes: &Strokes,
        parts: Option<&mut impl Communicator>,
    ) -> Result<(Option<StrokeData>, Vec<String>)> {
        let Some(options) = self.options(up)? else { return Ok((None, Vec::new())) };
        let is_of_part = matches!(options.range.low, RangeEnd::Percentile(_))
            || matches!(options.range.high, RangeEnd::Percentile(_))
            || options.categories.is_some();
        if parts.is_some() && is_of_part {
            let needs = "the whole model, which no rank has with --parts";
            let text = match &options.map {
                Some(map) if self.categories.is_none() && options.categories.is_some() => format!(
                    "{} has the colours of categories, which need {needs}: give --range LOW,HIGH",
                    map.name()
                ),
                _ => format!("percentiles and --categories need {needs}"),
            };
            return Err(UsageError(text).into());
        }
        let mut statistics = Statistics::default();
        let of_all = |own: Statistics| -> Result<Statistics> {
            statistics = match parts {
                Some(comm) => of_all_parts(comm, own)?,
                None => self.of_series.unwrap_or(own),
            };
            Ok(statistics)
        };
        let data = options.data_of_model::<anyhow::Error>(instance, strokes, of_all)?;
        let is_direct = matches!(data.surface.as_deref(), Some(SurfaceData::Direct { .. }))
            || matches!(data.strokes, Some(StrokeData::Direct(_)));
        if is_direct && self.changes_map() {
            let by = &options.by;
            bail!("\"{by}\" are colours: --colormap, --range and what belongs to them have no effect");
        }
        let colors = data.colors().filter(|_| !self.are_doubts_known);
        let mut notes = colors.map(|colors| doubts(&options, colors, &statistics)).unwrap_or_default();
        if let Some(colors) = colors.filter(|colors| colors.map.names_values()) {
            let (by, map) = (&options.by, colors.map.name());
            if colors.categories.is_empty() {
                notes.push(format!(
                    "{map} has the colours of categories, whose labels are left out: --range, --log or another option of quantities is given"
                ));
            } else if has_others(instance, data.surface.as_deref(), data.strokes.as_ref(), false) {
                notes.push(format!(
                    "\"{by}\" has values that {map} does not name: they have the colour of what is not a number (--nan-color)"
                ));
            }
            let mut idle = colors.map.idle_annotations();
            if let Some(first) = idle.next() {
                let count = 1 + idle.count();
                notes.push(format!(
                    "{count} of the annotations of {map} are of what is no number, or of values that have one before, and are left out: the first is \"{}\"",
                    first.label
                ));
            }
        }
        instance.data = data.surface;
        Ok((data.strokes, notes))
    }

    /// Whether the bar of an instance, or of its lines and points, explains the colour of what is no number or no category: where that is
    /// asked for, or something has it that is not gray as ever. In a series, whether that is so of any model: the bar of all pictures is
    /// the same; and on all ranks with parts of a model, so that there it is explained whenever it was chosen.
    pub fn explains_others(&self, instance: &Instance, strokes: Option<&StrokeData>, in_parts: bool) -> bool {
        let surface = instance.data.as_deref();
        if in_parts {
            return self.nan_color.is_some() || self.looks_for_others(surface);
        }
        let has_others = || self.looks_for_others(surface) && has_others(instance, surface, strokes, true);
        self.nan_color.is_some() || self.series_has_others || has_others()
    }

    /// Whether it is to be known that something is no number or no category: a list of all colours names what that has, too, and gray is
    /// not explained where nobody chose it.
    fn looks_for_others(&self, surface: Option<&SurfaceData>) -> bool {
        let of_colors = |colors: &DataColors| colors.nan != DataColors::NAN || colors.map.names_values();
        let is_special = matches!(surface, Some(SurfaceData::Mapped { colors, .. }) if of_colors(colors));
        self.categories.is_some() || is_special
    }

    /// What the colours show, for reports.
    pub fn json(&self, instance: Option<&Instance>) -> Value {
        let data = instance.and_then(|instance| instance.data.as_deref());
        let Some(SurfaceData::Mapped { colors, .. }) = data else {
            return data.map_or(Value::Null, |_| json!({ "by": self.color_by, "colors": "direct" }));
        };
        let scale = match colors.scale {
            Scale::Linear => json!("linear"),
            Scale::Log => json!("log"),
            Scale::SymmetricLog { threshold } => json!({ "symmetric_log": threshold }),
        };
        let categories: Vec<Value> = colors
            .categories
            .iter()
            .map(|c| json!({ "value": short(c.value), "label": c.label, "color": c.color }))
            .collect();
        json!({
            "by": self.color_by,
            "colormap": colors.map.name(),
            "range": colors.range,
            "scale": scale,
            "bands": colors.bands,
            "isolines": colors.isolines.as_ref().map(|lines| &lines.values),
            "categories": categories,
        })
    }
}

/// Whether any of these values is, if there are categories, none of them, or, if those count, no number.
fn has_others(
    instance: &Instance,
    surface: Option<&SurfaceData>,
    strokes: Option<&StrokeData>,
    counts_nan: bool,
) -> bool {
    let mesh = &*instance.mesh;
    let is_other = |colors: &DataColors, value: f32| {
        // -0 is 0.
        let full = colors.full(value + 0.0);
        let is_known = || colors.categories.binary_search_by(|c| c.value.total_cmp(&full)).is_ok();
        if value.is_nan() { counts_nan } else { !(colors.categories.is_empty() || is_known()) }
    };
    let on_surface = match surface {
        Some(SurfaceData::Mapped { source, colors }) => {
            let reader = DataReader::new(source, instance, colors.offset);
            let of_cluster = |cluster: usize| {
                let mut found = false;
                reader.each(mesh, cluster, |value| found |= is_other(colors, value));
                found
            };
            let clusters = (0..mesh.clusters().len()).into_par_iter().with_min_len(64);
            clusters.map(of_cluster).reduce(|| false, |a, b| a || b)
        }
        _ => false,
    };
    let on_strokes = |strokes: &StrokeData| match strokes {
        StrokeData::Mapped { values, colors } => values.iter().any(|value| is_other(colors, *value)),
        StrokeData::Direct(_) => false,
    };
    on_surface || strokes.is_some_and(on_strokes)
}

/// What of the options does not fit the data that have these statistics: it would be seen only as a picture of one colour.
fn doubts(options: &DataOptions, colors: &DataColors, statistics: &Statistics) -> Vec<String> {
    let (by, mut all) = (&options.by, Vec::new());
    if !colors.categories.is_empty() {
        let (categories, map) = (colors.categories.len(), &colors.map);
        if map.is_categorical() && categories > map.len() {
            all.push(format!(
                "{categories} categories of \"{by}\" share the {} colours of {}, which repeat (--colormap turbo, or another one that \
                 is no list of colours, has one for each)",
                map.len(),
                map.name(),
            ));
        }
        return all;
    }
    let Some([least, most]) = statistics.finite else { return all };
    let has = format!("\"{by}\" has {} to {}", words(least), words(most));
    let [low, high] = colors.range;
    let is_beside = most < low || least > high;
    if is_beside {
        all.push(format!("no value is in the range {} to {}: {has}", words(low), words(high)));
    }
    let mut lines = colors.isolines.iter().flat_map(|lines| &lines.values).peekable();
    // An end that is a number of a file in f32 is at the line of the number that it means.
    let is_end = |line: f64| [least, most].contains(&f64::from(line as f32));
    let is_within = |line: f64| (least..=most).contains(&line) || is_end(line);
    if !is_beside && lines.peek().is_some() && lines.all(|line| !is_within(*line)) {
        all.push(format!("no isoline is drawn: none of their values is among those of the data, {has}"));
    }
    // Who names the lower end, or a colour below it, knows of them.
    let is_known = options.below.is_some() || matches!(options.range.low, RangeEnd::At(_));
    if colors.scale == Scale::Log && least <= 0.0 && !is_known {
        all.push(format!(
            "values at or below 0, which have no logarithm, are painted as those below the range: {has} (--symlog has both signs)"
        ));
    }
    all
}

/// A number in as few digits as `f32` takes if it is one: 0.1 instead of 0.10000000149.
fn words(value: f64) -> String {
    if f64::from(value as f32) == value { (value as f32 + 0.0).to_string() } else { value.to_string() }
}

/// The same for reports.
fn short(value: f64) -> Value {
    if f64::from(value as f32) == value { json!(value as f32) } else { json!(value) }
}

/// The statistics of all parts of a model.
fn of_all_parts(comm: &mut impl Communicator, own: Statistics) -> Result<Statistics> {
    const NONE: f64 = f64::NEG_INFINITY;
    let ends = |range: Option<[f64; 2]>| range.map_or([NONE; 2], |[low, high]| [-low, high]);
    let ([a, b], [c, d]) = (ends(own.finite), ends(own.positive));
    let all = tercio::parallel::comm::collective::all_max(comm, [a, b, c, d])?;
    let range = |low: f64, high: f64| (high > NONE).then_some([-low, high]);
    let mut statistics = Statistics::default();
    (statistics.finite, statistics.positive) = (range(all[0], all[1]), range(all[2], all[3]));
    Ok(statistics)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges() {
        let at = RangeEnd::At;
        assert_eq!(ends("-1,2e3"), Ok(Ends { low: at(-1.0), high: at(2000.0) }));
        assert_eq!(
            ends("2%, 98%"),
            Ok(Ends { low: RangeEnd::Percentile(0.02), high: RangeEnd::Percentile(0.98) })
        );
        assert_eq!(ends("0,"), Ok(Ends { low: at(0.0), high: RangeEnd::OfData }));
        for bad in ["", "1", "2,1", "1,1", "a,b", "1,2,3", "101%,", "nan,1"] {
            assert!(ends(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn lists() {
        assert_eq!(isolines("7").map(|l| l.0), Ok(Err(7)));
        assert_eq!(isolines("7,").map(|l| l.0), Ok(Ok(vec![7.0])));
        assert_eq!(isolines("-1,0.5").map(|l| l.0), Ok(Ok(vec![-1.0, 0.5])));
        assert_eq!(labels("1=bone, 4=a=b").map(|l| l.0), Ok(vec![(1.0, "bone".into()), (4.0, "a=b".into())]));
        assert_eq!(opacities("0,1").map(|o| o.0), Ok(vec![0.0, 1.0]));
        assert!(
            isolines("0").is_err()
                && isolines("1,x").is_err()
                && labels("bone").is_err()
                && opacities("2").is_err()
        );
    }
}
