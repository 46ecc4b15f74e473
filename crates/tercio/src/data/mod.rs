//! Surfaces coloured by their data: from the name of an attribute to [`SurfaceData`].

mod edges;
mod made;
mod name;
mod own;
mod range;
mod strokes;

use std::sync::Arc;

use glam::DVec3;
use tercio_mesh::AttributeDomain;
use tercio_mesh::strokes::Strokes;
use tercio_scene::color_map::{Annotation, Category, ColorMap, DataColors, Isolines, Scale};
use tercio_scene::{DataReader, DataSource, Instance, SurfaceData};

pub use edges::{of_edges, of_edges_at};
pub use made::Made;
pub use name::{available, direction, needs_normals};
use range::Values;
pub(crate) use range::sort_key;
pub use range::{Ends, RangeEnd, Statistics};
pub(crate) use strokes::layout as stroke_layout;
pub use strokes::{ModelData, StrokeData};

/// How a surface is coloured by its data.
///
/// ```
/// use tercio::data::DataOptions;
///
/// let model = tercio::load("builtin:terrain@1k")?;
/// let mut scene = tercio::Scene::from_mesh(model.mesh);
/// let data = DataOptions::new("@elevation").data(&scene.instances[0])?;
/// scene.instances[0].data = Some(data);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct DataOptions {
    /// The name of an attribute (of the components of a vector: its magnitude), `NAME:COMPONENT`, `NAME:magnitude`, or `NAME:rgb`
    /// for colours; or what is made: `@elevation`, `@normal`, `@normal:x`, `@normal:y`, `@normal:z`, `@face`; or what a mesh holds in a
    /// form of its own: `@x`, `@y`, `@z` (the coordinates of the file, whatever the place of the instance), `@color` (colours), `@color:red`,
    /// `green`, `blue`, `alpha` (0 to 255), `@texcoord:u`, `@texcoord:v`, which names of files such as `x`, `nx`, `red` and `u` mean, too,
    /// where no attribute has that name; with [`LoadOptions::make`](crate::LoadOptions::make)
    /// `@curvature` and `@component`, whose colours are those of categories. `NAME@point` and `NAME@cell` are attributes of vertices and
    /// of triangles alone; where both have the name, it means that of the vertices.
    pub by: String,
    /// The colours; `None` for viridis, or Set1 or tab20 for categories.
    pub map: Option<ColorMap>,
    /// The ends of the range.
    pub range: Ends,
    /// How it is spread over the colours.
    pub scale: ScaleOption,
    /// Bands of one colour each.
    pub bands: Option<u32>,
    /// Lines of equal value.
    pub isolines: Option<IsolineOptions>,
    /// The colour of what is not a number.
    pub nan: [u8; 4],
    /// The colours beyond the range; `None` for those of its ends.
    pub below: Option<[u8; 4]>,
    /// As `below`.
    pub above: Option<[u8; 4]>,
    /// Opacities, spread evenly over the colours.
    pub opacities: Vec<f32>,
    /// Values are categories; some of them have labels.
    pub categories: Option<Vec<(f64, String)>>,
    /// Where up is, for `@elevation`.
    pub up: DVec3,
}

/// A [`Scale`] whose parameters may follow from the data.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum ScaleOption {
    /// Even.
    #[default]
    Linear,
    /// By logarithms.
    Log,
    /// By logarithms beyond a threshold; `None` for a thousandth of the largest absolute value of the range.
    SymmetricLog(Option<f64>),
}

/// Which lines of equal value are drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct IsolineOptions {
    /// Their values; or this many, spread evenly over the range, without its ends.
    pub at: Result<Vec<f64>, u32>,
    /// Their colour.
    pub color: [u8; 4],
    /// Their width in pixels.
    pub width: f32,
}

/// Why a surface cannot be coloured so.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DataError {
    /// No such attribute.
    #[error("there is no attribute \"{name}\"; there are {}", list(available))]
    Unknown {
        /// The name.
        name: String,
        /// What there is.
        available: Vec<String>,
    },
    /// An attribute without that component.
    #[error("\"{name}\" has no component \"{component}\"; it has {}", list(available))]
    Component {
        /// The name of the attribute.
        name: String,
        /// That of the component.
        component: String,
        /// What there is.
        available: Vec<String>,
    },
    /// A name of several values, none of which is more than the others.
    #[error("\"{name}\" is several values: name one of {}", list(available))]
    WhichComponent {
        /// The name.
        name: String,
        /// What there is.
        available: Vec<String>,
    },
    /// No such vector.
    #[error("there is no vector \"{name}\" of two or three components; there are {}", list(available))]
    NoVector {
        /// The name.
        name: String,
        /// What there is.
        available: Vec<String>,
    },
    /// No normals for `@normal`.
    #[error("the model has no normals for @normal")]
    NoNormals,
    /// Not made while the model was read.
    #[error("{0} is made when a whole model is read: not of a prepared one, and not of parts")]
    NotMade(String),
    /// No numbers.
    #[error("\"{0}\" has no finite value, so its colours have no range (--range MIN,MAX gives one)")]
    NoNumbers(String),
    /// A range that is none.
    #[error("the range of \"{name}\" would be {low} to {high}, and has to ascend")]
    Range {
        /// The name of the data.
        name: String,
        /// The lower end.
        low: f64,
        /// The upper end.
        high: f64,
    },
    /// A logarithm of what is not above 0.
    #[error(
        "a logarithmic scale needs a range above 0, \"{name}\" has {low} to {high} (--symlog has both signs)"
    )]
    NotPositive {
        /// The name of the data.
        name: String,
        /// The lower end.
        low: f64,
        /// The upper end.
        high: f64,
    },
    /// Too many categories.
    #[error("\"{0}\" has more than {MOST_CATEGORIES} different values, too many for categories")]
    TooManyCategories(String),
    /// Lines on something constant.
    #[error("isolines need values at vertices of a surface, those of \"{0}\" are elsewhere")]
    ConstantIsolines(String),
}

/// Different values that may be categories.
pub const MOST_CATEGORIES: usize = 1 << 12;

fn list(names: &[String]) -> String {
    if names.is_empty() { "none".into() } else { names.join(", ") }
}

impl DataOptions {
    /// Viridis over the range of the finite values.
    pub fn new(by: &str) -> Self {
        Self {
            by: by.into(),
            map: None,
            range: Ends::default(),
            scale: ScaleOption::default(),
            bands: None,
            isolines: None,
            nan: DataColors::NAN,
            below: None,
            above: None,
            opacities: Vec::new(),
            categories: None,
            up: DVec3::Y,
        }
    }

    /// The data of an instance, for [`Instance::data`].
    ///
    /// # Errors
    /// [`DataError`], which lists what there is.
    pub fn data(&self, instance: &Instance) -> Result<Arc<SurfaceData>, DataError> {
        self.data_with(instance, Ok)
    }

    /// As [`DataOptions::data`], with statistics that `of_all` makes from those of this instance: of a model in parts, those of all
    /// parts.
    ///
    /// # Errors
    /// [`DataError`], and those of `of_all`.
    pub fn data_with<E: From<DataError>>(
        &self,
        instance: &Instance,
        of_all: impl FnOnce(Statistics) -> Result<Statistics, E>,
    ) -> Result<Arc<SurfaceData>, E> {
        let data = self.data_of_model(instance, &Strokes::default(), of_all)?;
        data.surface.ok_or_else(|| DataError::NoNumbers(self.by.clone()).into())
    }

    /// The data of a model's surface and of the lines and points of its file, in the same colours. The range is that of all of them.
    /// One of both may be without these data; then it keeps colours of its own.
    ///
    /// # Errors
    /// [`DataError`], and those of `of_all`.
    pub fn data_of_model<E: From<DataError>>(
        &self,
        instance: &Instance,
        strokes: &Strokes,
        of_all: impl FnOnce(Statistics) -> Result<Statistics, E>,
    ) -> Result<ModelData, E> {
        let layout = instance.mesh.layout();
        // A surface without triangles counts only where there is nothing else.
        let is_cloud = !strokes.is_empty() && instance.mesh.clusters().is_empty();
        let on_strokes = strokes::find(&self.by, strokes, is_cloud, self.up);
        let on_surface = match name::find(&self.by, layout, self.up) {
            Ok(found) if !is_cloud => Some(found),
            _ if on_strokes.is_some() => None,
            Err(error) if !is_cloud => return Err(strokes::list_those_of(error, strokes, false).into()),
            _ => {
                let error = DataError::Unknown { name: self.by.clone(), available: Vec::new() };
                return Err(strokes::list_those_of(error, strokes, true).into());
            }
        };
        let reader =
            |source: &DataSource, offset| (DataReader::new(source, instance, offset), &*instance.mesh);
        let source = match (&on_surface, &on_strokes) {
            (Some(name::Found::Colors { .. }), _) | (None, Some(name::Found::Colors { .. })) => {
                return Ok(self.direct(instance, strokes, on_surface, on_strokes));
            }
            (Some(name::Found::Values(source)), _) => Some(source.clone()),
            (None, _) => None,
        };
        let offset = match (&source, &on_strokes) {
            // Of two vectors that differ by little the lengths may not come back from full numbers exactly.
            (Some(DataSource::Magnitude(_)), _) if self.categories.is_some() => 0.0,
            (Some(source), _) => {
                own::offset(source, instance.mesh.origin).unwrap_or_else(|| source.offset(layout))
            }
            (None, Some(name::Found::Values(source))) => own::offset(source, strokes.origin)
                .unwrap_or_else(|| source.offset(&strokes::layout(strokes))),
            (None, _) => 0.0,
        };
        // Categories are compared with those of other steps: what is not whole is rounded alike in all of them.
        let offset = if self.categories.is_some() && offset.fract() != 0.0 { 0.0 } else { offset };
        let mut others = match &on_strokes {
            Some(name::Found::Values(source)) => {
                Some(strokes::values(source, strokes, &instance.world_from_object, offset))
            }
            _ => None,
        };
        let values = Values {
            surface: source.as_ref().map(|source| reader(source, offset)),
            others: others.as_deref().unwrap_or_default(),
            offset,
        };
        let statistics = of_all(Statistics::of(&values))?;
        let is_constant = |source: &DataSource| source.domain(layout) == AttributeDomain::Triangle;
        if self.isolines.is_some() && source.as_ref().is_none_or(is_constant) {
            return Err(DataError::ConstantIsolines(self.by.clone()).into());
        }
        let is_plain = self.range == Ends::default() && self.bands.is_none();
        let colors = match &self.categories {
            Some(labels) => self.category_colors(labels, &values)?,
            None if self.by == Made::Component.name() && is_plain => {
                let few = self.category_colors(&[], &values);
                few.or_else(|_| self.range_colors(&statistics, &values))?
            }
            None => self.range_colors(&statistics, &values)?,
        };
        if colors.offset != offset {
            let stored = |value: &mut f32| *value = (offset + f64::from(*value) - colors.offset) as f32;
            others.iter_mut().flatten().for_each(stored);
        }
        let of_strokes = others.map(|values| StrokeData::Mapped {
            values,
            colors: Arc::new(DataColors { isolines: None, ..colors.clone() }),
        });
        // The bar shows the colours of the surface, also where it has no triangles.
        let source = source.or_else(|| is_cloud.then_some(DataSource::Along(self.up)));
        let colors = Arc::new(colors);
        let surface = source.map(|source| Arc::new(SurfaceData::Mapped { source, colors }));
        Ok(ModelData { surface, strokes: of_strokes })
    }

    /// Colours themselves.
    fn direct(
        &self,
        instance: &Instance,
        strokes: &Strokes,
        on_surface: Option<name::Found>,
        on_strokes: Option<name::Found>,
    ) -> ModelData {
        let colors = |found: Option<name::Found>| match found {
            Some(name::Found::Colors { components, kind }) => Some((components, kind)),
            _ => None,
        };
        let (on_surface, on_strokes) = (colors(on_surface), colors(on_strokes));
        let kind_of_strokes = on_strokes.as_ref().map(|(_, kind)| *kind);
        let of_strokes: Option<Vec<Vec<f32>>> = on_strokes.map(|(components, _)| {
            let values = |source| strokes::values(source, strokes, &instance.world_from_object, 0.0);
            components.iter().map(values).collect()
        });
        let of_surface = on_surface.iter().flat_map(|(components, _)| components).map(|source| Values {
            surface: Some((DataReader::new(source, instance, 0.0), &*instance.mesh)),
            others: &[],
            offset: 0.0,
        });
        let others = of_strokes.iter().flatten().map(|others| Values { surface: None, others, offset: 0.0 });
        let kind = on_surface.as_ref().map(|(_, kind)| *kind).or(kind_of_strokes);
        let (scale, offset) = match kind {
            Some(name::ColorKind::Signed) => (0.5, 0.5),
            Some(name::ColorKind::Bytes) => (1.0 / 255.0, 0.0),
            Some(name::ColorKind::OfData) | None => (range::color_scale(of_surface.chain(others)), 0.0),
        };
        let surface =
            on_surface.map(|(components, _)| Arc::new(SurfaceData::Direct { components, scale, offset }));
        let strokes = of_strokes.map(|components| strokes::direct(&components, scale, offset));
        ModelData { surface, strokes }
    }

    fn range_colors(&self, s: &Statistics, values: &Values) -> Result<DataColors, DataError> {
        let is_log = self.scale == ScaleOption::Log;
        let automatic = if is_log { s.positive } else { s.finite };
        let given = |end: RangeEnd| matches!(end, RangeEnd::At(_));
        let is_given = given(self.range.low) && given(self.range.high);
        let finite = match automatic.or(s.finite) {
            Some(finite) => finite,
            None if is_given => [0.0; 2],
            None => return Err(DataError::NoNumbers(self.by.clone())),
        };
        let end = |end: RangeEnd, of_data: f64| match end {
            RangeEnd::OfData => of_data,
            RangeEnd::At(value) => value,
            RangeEnd::Percentile(share) => range::percentile(values, share, is_log),
        };
        let [mut low, mut high] = [end(self.range.low, finite[0]), end(self.range.high, finite[1])];
        let name = || self.by.clone();
        if is_log && !(low > 0.0 && high > 0.0) {
            return Err(DataError::NotPositive { name: name(), low, high });
        }
        if low == high && !is_given {
            // All values are the same: it gets the middle colour of a range so narrow that it is the value that a bar shows.
            let half = if low == 0.0 { 0.01 } else { low.abs() * 0.01 };
            (low, high) = (low - half, high + half);
        }
        let offset = range::offset_of_colors([low, high], values.offset, self.scale == ScaleOption::Linear);
        if !(((low - offset) as f32) < (high - offset) as f32) {
            return Err(DataError::Range { name: name(), low, high });
        }
        let map = self.map.clone().unwrap_or_else(|| known("viridis"));
        let mut colors = DataColors::new(&self.by, map, [low, high]);
        colors.scale = match self.scale {
            ScaleOption::Linear => Scale::Linear,
            ScaleOption::Log => Scale::Log,
            ScaleOption::SymmetricLog(threshold) => {
                let threshold = threshold.unwrap_or_else(|| low.abs().max(high.abs()) * 1e-3);
                Scale::SymmetricLog { threshold }
            }
        };
        (colors.bands, colors.nan, colors.below, colors.above) =
            (self.bands, self.nan, self.below, self.above);
        colors.offset = offset;
        colors.opacities.clone_from(&self.opacities);
        colors.isolines = self.isolines.as_ref().map(|lines| {
            let values = match &lines.at {
                Ok(values) => values.clone(),
                Err(count) => {
                    let intervals = f64::from(*count) + 1.0;
                    (1..=*count).map(|i| colors.value_at(f64::from(i) / intervals)).collect()
                }
            };
            Isolines { values, color: lines.color, width: lines.width }
        });
        Ok(colors)
    }

    fn category_colors(&self, labels: &[(f64, String)], values: &Values) -> Result<DataColors, DataError> {
        let offset = values.offset;
        let found = range::different(values, MOST_CATEGORIES);
        // A map may say which of its colours are for which values: others have the colour of NaN.
        let named = self.map.as_ref().filter(|map| map.names_values()).map(|map| {
            let values = map.annotations().iter().filter_map(|annotation| annotation.value);
            values
                .map(|value| (value - offset) as f32)
                .filter(|value| value.is_finite())
                .collect::<Vec<f32>>()
        });
        let mut values = match (found, named) {
            (Some(mut found), Some(named)) => {
                found.retain(|value| named.contains(value));
                if found.is_empty() && labels.is_empty() { named } else { found }
            }
            (Some(found), None) => found,
            // A few of the values may be named.
            (None, Some(named)) => named,
            (None, None) => return Err(DataError::TooManyCategories(self.by.clone())),
        };
        if values.len() > MOST_CATEGORIES {
            return Err(DataError::TooManyCategories(self.by.clone()));
        }
        let labels: Vec<(f32, &String)> =
            labels.iter().map(|(of, label)| ((of - offset) as f32, label)).collect();
        values.extend(labels.iter().map(|(value, _)| *value));
        // -0 is 0.
        values.iter_mut().for_each(|value| *value += 0.0);
        values.sort_by(f32::total_cmp);
        values.dedup();
        let default = || known(if values.len() <= 9 { "Set1" } else { "tab20" });
        let map = self.map.clone().unwrap_or_else(default);
        // Values that have labels here and no colour there have the colours behind those.
        let mut others = if map.names_values() { map.annotations().len() } else { 0 }..;
        let is_for = |annotation: &Annotation, value: f32| {
            annotation.value.is_some_and(|of| (of - offset) as f32 + 0.0 == value)
        };
        let category = |&value: &f32| {
            let number = map.annotations().iter().position(|annotation| is_for(annotation, value));
            let annotated = number.map(|number| map.annotations()[number].label.clone());
            let number = number.or_else(|| others.next()).unwrap_or(0);
            let label = labels.iter().find(|(of, _)| *of == value).map(|(_, label)| (*label).clone());
            let label = label.or(annotated.filter(|label| !label.is_empty()));
            let [r, g, b] = map.category(number).map(|c| (c * 255.0 + 0.5) as u8);
            let label = label.unwrap_or_else(|| printed(value, offset));
            Category { value: offset + f64::from(value), label, color: [r, g, b, 255] }
        };
        let categories: Vec<Category> = values.iter().map(category).collect();
        let ends = [categories.first(), categories.last()].map(|category| category.map_or(0.0, |c| c.value));
        let mut colors = DataColors::new(&self.by, map, [ends[0], ends[1].max(ends[0] + 1.0)]);
        (colors.categories, colors.nan, colors.offset) = (categories, self.nan, offset);
        if colors.categories.is_empty() {
            return Err(DataError::NoNumbers(self.by.clone()));
        }
        Ok(colors)
    }
}

/// A value as the file has it, in the fewest digits that mean it: one stored less an [offset](tercio_mesh::Attribute::offset).
pub fn printed(value: f32, offset: f64) -> String {
    // -0 is 0.
    let value = value + 0.0;
    let full = offset + f64::from(value);
    if offset == 0.0 {
        return value.to_string();
    }
    if full.fract() == 0.0 || !full.is_finite() {
        return full.to_string();
    }
    // As many digits after the point as those of the offset, and seven of the stored value; 15 in all, which f64 has for certain.
    let after = |text: String| text.split_once('.').map_or(0, |(_, digits)| digits.len());
    let short: f64 = format!("{value:.6e}").parse().unwrap_or_default();
    let before = format!("{:.0}", full.abs().trunc()).len();
    let places = after(offset.to_string()).max(after(short.to_string())).min(15usize.saturating_sub(before));
    let text = format!("{full:.places$}");
    if places == 0 { text } else { text.trim_end_matches('0').trim_end_matches('.').to_owned() }
}

/// A colour map that is always there.
fn known(name: &str) -> ColorMap {
    ColorMap::named(name).unwrap_or_else(|| unreachable!("{name} is a known map"))
}

#[cfg(test)]
mod tests;
