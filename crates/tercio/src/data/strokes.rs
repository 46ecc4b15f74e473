//! Data of lines and points.

use std::sync::Arc;

use glam::{DAffine3, DVec3};
use tercio_mesh::cluster::Layout;
use tercio_mesh::loops::prelude::*;
use tercio_mesh::strokes::Strokes;
use tercio_scene::{DataColors, DataSource, SurfaceData};

use super::name::{self, Found, available};
use super::{DataError, Made};

/// What the colours of a model show.
#[derive(Clone, Debug)]
pub struct ModelData {
    /// Those of its surface, for [`Instance::data`](tercio_scene::Instance::data).
    pub surface: Option<Arc<SurfaceData>>,
    /// Those of its lines and points, for [`crate::strokes`].
    pub strokes: Option<StrokeData>,
}

impl ModelData {
    /// The colours of values, if the data are values.
    pub fn colors(&self) -> Option<&DataColors> {
        let of_surface = match self.surface.as_deref() {
            Some(SurfaceData::Mapped { colors, .. }) => Some(&**colors),
            _ => None,
        };
        let of_strokes = match &self.strokes {
            Some(StrokeData::Mapped { colors, .. }) => Some(&**colors),
            _ => None,
        };
        of_surface.or(of_strokes)
    }
}

/// What the colours of lines and points, or of edges, show: one number or colour per vertex of the [`Strokes`], or two per edge.
#[derive(Clone, Debug)]
pub enum StrokeData {
    /// Values, interpolated along each line before they become colours.
    Mapped {
        /// The values.
        values: Vec<f32>,
        /// Their colours.
        colors: Arc<DataColors>,
    },
    /// Colours themselves: sRGB and linear alpha.
    Direct(Vec<[u8; 4]>),
}

/// What strokes store, as that of a surface.
pub fn layout(strokes: &Strokes) -> Layout {
    let attributes = strokes.attributes.iter().map(|a| (a.name.clone(), a.domain)).collect();
    Layout {
        attributes,
        offsets: Layout::offsets_of(&strokes.attributes),
        components: Layout::components_of(&strokes.attributes),
        vertex_colors: strokes.colors.is_some(),
        ..Layout::default()
    }
}

/// The data of a name; `None` if strokes do not have them. Those of a cloud have no surface that anything was made of.
pub(super) fn find(name: &str, strokes: &Strokes, is_cloud: bool, up: DVec3) -> Option<Found> {
    if strokes.is_empty() || is_cloud && Made::of_name(name).is_some() {
        return None;
    }
    let found = name::find(name, &layout(strokes), up).ok()?;
    (found != Found::Values(DataSource::Face)).then_some(found)
}

/// The error with what lines and points have, too; or theirs, if they have the attribute but not its component.
pub(super) fn list_those_of(error: DataError, strokes: &Strokes, is_cloud: bool) -> DataError {
    let DataError::Unknown { name, available: of_surface } = error else { return error };
    // Without a surface, or with one that does not have them, theirs is the attribute that has no such component.
    let of_own = name::find(&name, &layout(strokes), DVec3::Y).err();
    if let Some(error @ DataError::Component { .. }) = of_own.filter(|_| !strokes.is_empty()) {
        return error;
    }
    let is_of_surface = |name: &String| {
        let name = name.split(' ').next().unwrap_or_default();
        name == "@normal" || name == "@face" || Made::of_name(name).is_some()
    };
    let of_strokes: Vec<String> = match strokes.is_empty() {
        true => Vec::new(),
        false => available(&layout(strokes))
            .into_iter()
            .filter(|n| !is_of_surface(n) && (is_cloud || !of_surface.contains(n)))
            .collect(),
    };
    let mut all: Vec<String> =
        of_strokes.into_iter().map(|name| name.replace("(vertices", "(lines and points")).collect();
    all.extend(of_surface.into_iter().filter(|_| !is_cloud));
    DataError::Unknown { name, available: all }
}

/// The values of all vertices, at a place in the world, less an offset.
pub(super) fn values(source: &DataSource, strokes: &Strokes, place: &DAffine3, offset: f64) -> Vec<f32> {
    let count = strokes.positions.len();
    let of = |number: usize| &strokes.attributes[number];
    match source {
        DataSource::Attribute(number) => {
            let mut own = of(*number).clone();
            own.set_offset(offset);
            own.values
        }
        DataSource::Magnitude(numbers) => {
            let square = |v: usize, n: usize| of(n).full(of(n).values[v]).powi(2);
            let length = |v: usize| numbers.iter().map(|&n| square(v, n)).sum::<f64>().sqrt();
            (0..count).into_par_iter().map(|v| (length(v) - offset) as f32).collect()
        }
        DataSource::Along(up) => {
            let at = |v: usize| place.transform_point3(strokes.position(v as u32));
            (0..count).into_par_iter().map(|v| (up.dot(at(v)) - offset) as f32).collect()
        }
        DataSource::Coordinate(axis) => {
            let at = |v: usize| strokes.position(v as u32)[*axis];
            (0..count).into_par_iter().map(|v| (at(v) - offset) as f32).collect()
        }
        DataSource::Color(k, _) => {
            let component = |color: &Option<[u8; 4]>| match color {
                Some(color) => (f64::from(color[*k]) - offset) as f32,
                None => f32::NAN,
            };
            let colors = strokes.colors.iter().flatten();
            colors.map(component).chain(std::iter::repeat(f32::NAN)).take(count).collect()
        }
        DataSource::Normal(_) | DataSource::Texcoord(_) | DataSource::Face => vec![f32::NAN; count],
    }
}

/// Colours of three or four components.
pub(super) fn direct(components: &[Vec<f32>], scale: f32, offset: f32) -> StrokeData {
    let byte = |v: f32| ((v * scale + offset).clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
    let count = components.iter().map(Vec::len).min().unwrap_or(0);
    let color = |v: usize| std::array::from_fn(|k| components.get(k).map_or(255, |values| byte(values[v])));
    StrokeData::Direct((0..count).map(color).collect())
}
