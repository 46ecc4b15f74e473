//! How the data of an instance become colours: a table that reference and kernels look up.

use tercio_mesh::cluster::{ClusterView, MAX_TRIANGLES};
use tercio_mesh::{AttributeDomain, ClusteredMesh};
use tercio_scene::color::srgb_to_linear;
use tercio_scene::color_map::Scale;
use tercio_scene::{DataColors, DataReader, Instance, Scene, SurfaceData};

use crate::error::RenderError;

/// Intervals of a smooth colour map: so many that half of one is less than a level of 8 bits, in gist_earth and gist_stern, which have
/// steep places, less than two.
pub const INTERVALS: usize = 4080;

/// Most lines of equal value of an instance: each of them is looked at in every pixel.
pub const MOST_ISOLINES: usize = 256;

/// Most categories and bands of an instance.
pub const MOST_STEPS: usize = 1 << 16;

/// The data of an instance, and how they become colours.
#[derive(Clone, Debug)]
pub struct DataTable {
    /// Where values come from: one for values that are mapped, else those of the components of colours.
    readers: Vec<DataReader>,
    is_at_triangles: bool,
    /// Factor and offset of components of colours.
    direct: [f32; 2],
    /// How values are mapped.
    pub mapping: Mapping,
}

/// From a value to a colour. Values beyond the range are moved to its ends first.
#[derive(Clone, Debug)]
pub struct Mapping {
    /// The range of values.
    pub range: [f32; 2],
    /// How it is spread.
    pub spread: Spread,
    /// [`spread`] of the lower end, and the difference to that of the upper one.
    pub start: f32,
    pub length: f32,
    /// The entry of a position is the integer part of it times the first of these, plus the second.
    pub index: [f32; 2],
    /// The last of the entries that positions have.
    pub last: i32,
    /// The entries of what is not a number, below the range, and above it.
    pub special: [i32; 3],
    /// Linear colours and alpha.
    pub entries: Vec<[f32; 4]>,
    /// Values of categories, ascending; entry i is that of category i.
    pub categories: Vec<f32>,
    /// Values of lines.
    pub isolines: Vec<f32>,
    /// Linear colour and alpha of the lines.
    pub line: [f32; 4],
    /// Half of their width, in pixels.
    pub half_width: f32,
}

/// A [`Scale`] in `f32`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Spread {
    Linear,
    Log,
    SymmetricLog { threshold: f32 },
}

/// The linear part of a symmetric logarithm on one side, in powers of two: 10/9 decades.
pub const LINEAR_PART: f32 = (std::f64::consts::LOG2_10 / 0.9) as f32;

/// log2 of a normal number above 0, with an error below 1e-7 of it, or of 1 if it is less: the same operations as those of the
/// kernels.
pub fn log2(x: f32) -> f32 {
    let bits = x.to_bits() as i32;
    let (mut exponent, mut m) =
        (((bits >> 23) - 127) as f32, f32::from_bits(((bits & 0x7f_ffff) | (127 << 23)) as u32));
    if m > std::f32::consts::SQRT_2 {
        (exponent, m) = (exponent + 1.0, m * 0.5);
    }
    let s = (m - 1.0) / (m + 1.0);
    let s2 = s * s;
    exponent
        + (s * LOG2_SERIES[0]) * (1.0 + s2 * (LOG2_SERIES[1] + s2 * (LOG2_SERIES[2] + s2 * LOG2_SERIES[3])))
}

/// 2 log2(e), and 1/3, 1/5, 1/7 of the series of artanh.
pub const LOG2_SERIES: [f32; 4] = [2.0 * std::f32::consts::LOG2_E, 1.0 / 3.0, 0.2, 1.0 / 7.0];

/// The number that is spread evenly.
pub fn spread(spread: Spread, value: f32) -> f32 {
    match spread {
        Spread::Linear => value,
        Spread::Log => log2(value),
        Spread::SymmetricLog { threshold } => {
            let size = value.abs() / threshold;
            let size = if size > 1.0 { LINEAR_PART + log2(size) } else { LINEAR_PART * size };
            if value < 0.0 { -size } else { size }
        }
    }
}

impl DataTable {
    /// Of an instance, if it shows data. Precondition: [`check_data`].
    pub fn of(instance: &Instance) -> Option<Self> {
        let data = instance.data.as_deref()?;
        let is_at_triangles = data.domain(instance.mesh.layout()) == AttributeDomain::Triangle;
        Some(match data {
            SurfaceData::Mapped { source, colors } => Self {
                readers: vec![DataReader::new(source, instance, colors.offset)],
                is_at_triangles,
                direct: [1.0, 0.0],
                mapping: Mapping::new(colors),
            },
            SurfaceData::Direct { components, scale, offset } => Self {
                readers: components.iter().map(|source| DataReader::new(source, instance, 0.0)).collect(),
                is_at_triangles,
                direct: [*scale, *offset],
                mapping: Mapping::none(),
            },
        })
    }

    /// Are values at triangles, not at vertices?
    #[inline(always)]
    pub fn is_at_triangles(&self) -> bool {
        self.is_at_triangles
    }

    /// Are values colours themselves?
    pub fn is_direct(&self) -> bool {
        self.mapping.entries.is_empty()
    }

    /// The reader of a value, or of a component of colours.
    pub fn reader(&self, component: usize) -> &DataReader {
        &self.readers[component]
    }

    /// Reads the values at the vertices or at the triangles of a cluster, which has this number in the mesh.
    #[inline(never)]
    pub fn read(
        &self,
        mesh: &ClusteredMesh,
        number: usize,
        cluster: &ClusterView,
        to: &mut [f32; MAX_TRIANGLES],
    ) {
        match self.is_at_triangles {
            true => self.readers[0].read_triangles(mesh, number, cluster, to),
            false => self.readers[0].read_vertices(cluster, to),
        }
    }

    /// The value at a vertex of a triangle of a cluster, given by their numbers in the cluster, which has this number in the mesh.
    #[inline(never)]
    pub fn value(
        &self,
        mesh: &ClusteredMesh,
        number: usize,
        cluster: &ClusterView,
        triangle: usize,
        v: usize,
    ) -> f32 {
        match self.is_at_triangles {
            true => self.readers[0].triangle(mesh, number, cluster, triangle),
            false => self.readers[0].vertex(cluster, v),
        }
    }

    /// The linear colour and alpha at a vertex of a cluster.
    #[inline(never)]
    pub fn vertex_color(&self, cluster: &ClusterView, v: usize) -> [f32; 4] {
        self.color(|component| self.readers[component].vertex(cluster, v))
    }

    /// The linear colour and alpha of a triangle of a cluster, given by their numbers in the cluster and in the mesh.
    #[inline(never)]
    pub fn triangle_color(
        &self,
        mesh: &ClusteredMesh,
        number: usize,
        cluster: &ClusterView,
        triangle: usize,
    ) -> [f32; 4] {
        self.color(|component| self.readers[component].triangle(mesh, number, cluster, triangle))
    }

    /// The linear colour and alpha with these components. What is not a number is 0.
    pub fn color(&self, component: impl Fn(usize) -> f32) -> [f32; 4] {
        let [scale, offset] = self.direct;
        let part = |k: usize| {
            let c = component(k) * scale + offset;
            if c > 0.0 { c.min(1.0) } else { 0.0 }
        };
        let linear = |k: usize| srgb_to_linear(f64::from(part(k))) as f32;
        [linear(0), linear(1), linear(2), if self.readers.len() > 3 { part(3) } else { 1.0 }]
    }
}

impl Mapping {
    /// No mapping.
    fn none() -> Self {
        Self {
            range: [0.0, 1.0],
            spread: Spread::Linear,
            start: 0.0,
            length: 1.0,
            index: [0.0; 2],
            last: 0,
            special: [0; 3],
            entries: Vec::new(),
            categories: Vec::new(),
            isolines: Vec::new(),
            line: [0.0; 4],
            half_width: 0.0,
        }
    }

    fn new(colors: &DataColors) -> Self {
        let mut mapping = Self::none();
        let stored = |value: f64| (value - colors.offset) as f32;
        let of_8_bits = |c: [u8; 4]| linear(c.map(|c| f64::from(c) / 255.0));
        if colors.categories.is_empty() {
            mapping.spread = match colors.scale {
                _ if colors.offset != 0.0 => Spread::Linear,
                Scale::Linear => Spread::Linear,
                Scale::Log => Spread::Log,
                Scale::SymmetricLog { threshold } => Spread::SymmetricLog { threshold: threshold as f32 },
            };
            mapping.range = colors.range.map(stored);
            let [low, high] = mapping.range.map(|end| spread(mapping.spread, end));
            (mapping.start, mapping.length) = (low, high - low);
            let at = |place: f64| {
                let [r, g, b] = colors.map.at(place);
                linear([r, g, b, colors.opacity_at(place)])
            };
            mapping.entries = match colors.steps() {
                Some(bands) => {
                    mapping.index = [bands as f32, 0.0];
                    (0..bands).map(|band| at(colors.band_color_place(f64::from(band), bands))).collect()
                }
                None => {
                    mapping.index = [INTERVALS as f32, 0.5];
                    let place = colors.color_places();
                    (0..=INTERVALS).map(|i| at(place(i as f64 / INTERVALS as f64))).collect()
                }
            };
        } else {
            mapping.categories = colors.categories.iter().map(|category| stored(category.value)).collect();
            mapping.entries = colors.categories.iter().map(|category| of_8_bits(category.color)).collect();
        }
        mapping.last = mapping.entries.len() as i32 - 1;
        let mut special = |color: Option<[u8; 4]>, instead: i32| match color {
            Some(color) => {
                mapping.entries.push(of_8_bits(color));
                mapping.entries.len() as i32 - 1
            }
            None => instead,
        };
        mapping.special =
            [special(Some(colors.nan), 0), special(colors.below, 0), special(colors.above, mapping.last)];
        if let Some(lines) = colors.isolines.as_ref().filter(|lines| lines.width > 0.0)
            && colors.categories.is_empty()
        {
            mapping.isolines = lines.values.iter().map(|&value| stored(value)).collect();
            (mapping.line, mapping.half_width) = (of_8_bits(lines.color), lines.width * 0.5);
            // A line thinner than a pixel covers a part of it.
            mapping.line[3] *= lines.width.min(1.0);
        }
        mapping
    }
}

/// Linear light of sRGB, and alpha.
fn linear([r, g, b, a]: [f64; 4]) -> [f32; 4] {
    let [r, g, b] = [r, g, b].map(|c| srgb_to_linear(c) as f32);
    [r, g, b, a as f32]
}

/// Fails if the data of an instance are not there, or their colours not complete.
///
/// # Errors
/// [`RenderError::Setting`].
pub fn check_data(scene: &Scene) -> Result<(), RenderError> {
    let fail =
        |what, range: &str, value: String| Err(RenderError::Setting { what, range: range.into(), value });
    for instance in &scene.instances {
        let layout = instance.mesh.layout();
        let Some(data) = instance.data.as_deref() else { continue };
        let sources = match data {
            SurfaceData::Mapped { source, .. } => std::slice::from_ref(source),
            SurfaceData::Direct { components, scale, offset } => {
                if !(3..=4).contains(&components.len()) {
                    return fail("number of components of a colour", "3 or 4", components.len().to_string());
                }
                if !scale.is_finite() || !offset.is_finite() {
                    return fail("scale of colours", "finite", format!("{scale} and {offset}"));
                }
                components
            }
        };
        if let Some(source) = sources.iter().find(|source| !source.fits(layout)) {
            return fail("data of an instance", "in its mesh", format!("{source:?}"));
        }
        if sources.iter().any(|source| source.domain(layout) != sources[0].domain(layout)) {
            return fail(
                "data of an instance",
                "all at vertices, or all at triangles",
                format!("{sources:?}"),
            );
        }
        let SurfaceData::Mapped { colors, .. } = data else { continue };
        let stored = |value: f64| (value - colors.offset) as f32;
        if !colors.offset.is_finite() {
            return fail("offset of data", "finite", colors.offset.to_string());
        }
        let [low, high] = colors.range.map(stored);
        let is_range = low < high && high - low < f32::INFINITY;
        if !colors.categories.is_empty() {
            let is_sorted =
                colors.categories.windows(2).all(|pair| stored(pair[0].value) < stored(pair[1].value));
            if !is_sorted || colors.categories.len() > MOST_STEPS {
                return fail("categories of data", "at most 65536, with ascending values", "others".into());
            }
        } else if !is_range {
            return fail(
                "range of data",
                "two numbers that ascend, in 32 bits",
                format!("{:?}", colors.range),
            );
        } else if colors.scale == Scale::Log && colors.range[0] < f64::from(f32::MIN_POSITIVE) {
            return fail("range of data on a logarithmic scale", "above 0", format!("{:?}", colors.range));
        }
        if let Scale::SymmetricLog { threshold } = colors.scale
            && !(f64::from(f32::MIN_POSITIVE)..f64::from(f32::MAX)).contains(&threshold)
        {
            return fail("threshold of a symmetric logarithm", "a number above 0", threshold.to_string());
        }
        if colors.bands.is_some_and(|bands| bands == 0 || bands as usize > MOST_STEPS) {
            return fail("number of bands", "1 to 65536", format!("{:?}", colors.bands));
        }
        if colors.opacities.iter().any(|o| !(0.0..=1.0).contains(o)) {
            return fail("opacity of data", "0 to 1", format!("{:?}", colors.opacities));
        }
        if let Some(lines) = &colors.isolines {
            if lines.values.len() > MOST_ISOLINES || lines.values.iter().any(|v| !stored(*v).is_finite()) {
                return fail("isolines", "at most 256 numbers", format!("{} numbers", lines.values.len()));
            }
            if !(0.0..=1000.0).contains(&lines.width) {
                return fail("width of isolines", "0 to 1000 pixels", lines.width.to_string());
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn logarithms_are_close() {
        for bits in (f32::MIN_POSITIVE.to_bits()..f32::MAX.to_bits()).step_by(99_991) {
            let x = f32::from_bits(bits);
            let exact = f64::from(x).log2();
            assert!((f64::from(log2(x)) - exact).abs() <= 1.3e-7 * exact.abs().max(1.0), "{x}");
        }
        assert_eq!([log2(1.0), log2(0.125), log2(1024.0)], [0.0, -3.0, 10.0]);
    }

    #[test]
    fn every_map_is_fine_enough() {
        use tercio_scene::ColorMap;
        for name in ColorMap::names() {
            let map = ColorMap::named(name).expect("a listed name");
            if map.is_categorical() {
                continue;
            }
            for i in 0..20_000 {
                let t = (f64::from(i) + 0.5) / 20_000.0;
                let nearest = (t * INTERVALS as f64 + 0.5).floor() / INTERVALS as f64;
                let (a, b) = (map.at(t), map.at(nearest));
                let worst = (0..3).map(|k| (a[k] - b[k]).abs() * 255.0).fold(0.0, f64::max);
                assert!(
                    worst < if name.starts_with("gist_") { 2.0 } else { 0.6 },
                    "{name} at {t}: {worst} levels"
                );
            }
        }
    }
}
