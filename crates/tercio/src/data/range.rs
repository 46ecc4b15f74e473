//! The range of values that triangles use.

use tercio_mesh::loops::prelude::*;
use tercio_mesh::{AttributeDomain, ClusteredMesh};
use tercio_scene::DataReader;

/// An end of the range that colours cover.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum RangeEnd {
    /// The least or the greatest finite value; on a logarithmic scale, of those above 0.
    #[default]
    OfData,
    /// A value.
    At(f64),
    /// The value that this share of the values, 0 to 1, is at most.
    Percentile(f64),
}

/// Both ends of a range.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ends {
    /// The lower one.
    pub low: RangeEnd,
    /// The upper one.
    pub high: RangeEnd,
}

/// Values of a surface, and of what else is drawn in the same colours.
pub(super) struct Values<'a> {
    pub surface: Option<(DataReader, &'a ClusteredMesh)>,
    pub others: &'a [f32],
    /// What all of them are less.
    pub offset: f64,
}

/// Values of others in a piece.
const PIECE: usize = 1 << 13;

impl Values<'_> {
    /// Clusters of the surface, then pieces of the others.
    fn pieces(&self) -> usize {
        self.clusters() + self.others.len().div_ceil(PIECE)
    }

    fn clusters(&self) -> usize {
        self.surface.as_ref().map_or(0, |(_, mesh)| mesh.clusters().len())
    }

    /// Calls `see` with every value of a piece.
    fn each(&self, piece: usize, mut see: impl FnMut(f32)) {
        match (&self.surface, piece.checked_sub(self.clusters())) {
            (Some((reader, mesh)), None) => reader.each(mesh, piece, see),
            (_, piece) => {
                let others = self.others.chunks(PIECE).nth(piece.unwrap_or(0)).unwrap_or_default();
                others.iter().for_each(|&value| see(value));
            }
        }
    }

    /// As [`Values::each`] of a cluster of the surface, with what the value belongs to: the position of a vertex, or the number of a
    /// face.
    fn each_of_surface(&self, cluster: usize, mut see: impl FnMut([u32; 3], f32)) {
        let Some((reader, mesh)) = &self.surface else { return };
        let view = mesh.cluster(cluster);
        let is_of_vertices = reader.domain(mesh) == AttributeDomain::Vertex;
        let (mut vertices, mut faces) = (0..view.vertices(), mesh.faces(cluster));
        reader.each(mesh, cluster, |value| {
            let of = match is_of_vertices {
                true => vertices.next().map(|vertex| view.position(vertex).map(f32::to_bits)),
                false => faces.next().map(|face| [face, 0, 0]),
            };
            see(of.unwrap_or_default(), value);
        });
    }
}

/// What is known of some values.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Statistics {
    /// The least and the greatest finite value; `None` if there is none.
    pub finite: Option<[f64; 2]>,
    /// Of those above 0.
    pub positive: Option<[f64; 2]>,
}

impl Statistics {
    /// Of some values.
    pub(super) fn of(values: &Values) -> Self {
        let add = |mut all: Self, piece: usize| {
            values.each(piece, |value| all = all.and(Self::of_value(values.offset + f64::from(value))));
            all
        };
        let pieces = (0..values.pieces()).into_par_iter().with_min_len(64);
        pieces.fold(Self::default, add).reduce(Self::default, Self::and)
    }

    fn of_value(value: f64) -> Self {
        let finite = value.is_finite().then_some([value; 2]);
        Self { finite, positive: finite.filter(|_| value > 0.0) }
    }

    /// Those of two sets together.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        let both = |a: Option<[f64; 2]>, b: Option<[f64; 2]>| match (a, b) {
            (Some(a), Some(b)) => Some([a[0].min(b[0]), a[1].max(b[1])]),
            (a, b) => a.or(b),
        };
        Self { finite: both(self.finite, other.finite), positive: both(self.positive, other.positive) }
    }
}

/// A number that sorts as the value does.
pub fn sort_key(value: f32) -> u32 {
    let bits = value.to_bits();
    if bits >> 31 == 1 { !bits } else { bits | 1 << 31 }
}

fn value(key: u32) -> f32 {
    f32::from_bits(if key >> 31 == 1 { key & !(1 << 31) } else { !key })
}

/// The value that this share of the finite values is at most (the nearest one: no mean of two); of those above 0 if `positive`. 0 if
/// there is none. A vertex counts once, however many clusters have it, and a face once, however many triangles it has. Vertices
/// with one position and one value are one.
pub(super) fn percentile(values: &Values, share: f64, positive: bool) -> f64 {
    let is_counted = |value: f32| value.is_finite() && (!positive || values.offset + f64::from(value) > 0.0);
    let of_surface = |cluster: usize| {
        let mut counted = Vec::new();
        values.each_of_surface(cluster, |[a, b, c], value| {
            // -0 is 0.
            counted.extend(is_counted(value).then(|| [a, b, c, sort_key(value + 0.0)]));
        });
        counted
    };
    let mut once: Vec<[u32; 4]> = (0..values.clusters()).into_par_iter().flat_map_iter(of_surface).collect();
    once.par_sort_unstable();
    once.dedup();
    let others = values.others.iter().filter(|value| is_counted(**value)).map(|value| sort_key(value + 0.0));
    let mut keys: Vec<u32> = once.into_iter().map(|[.., key]| key).chain(others).collect();
    if keys.is_empty() {
        return 0.0;
    }
    let rank = (share.clamp(0.0, 1.0) * (keys.len() - 1) as f64 + 0.5) as usize;
    let (_, key, _) = keys.select_nth_unstable(rank);
    values.offset + f64::from(value(*key))
}

/// What values are best less when they become colours of a range: `of_values`, which the values are less; 0 where rounding full
/// numbers to `f32` cannot be seen; the lower end of a range that `f32` does not hold or that is far from the values.
pub(super) fn offset_of_colors([low, high]: [f64; 2], of_values: f64, is_linear: bool) -> f64 {
    // Logarithms are even enough only in a range that is narrower still.
    let wide = if is_linear { 1.0 / 512.0 } else { 1.0 / 4096.0 };
    if !(high - low < low.abs().max(high.abs()) * wide) {
        return 0.0;
    }
    if of_values == 0.0 {
        // Values that f32 holds, in a range that it may not: that of other steps, or a given one.
        let rounding = [low, high].map(|end| (end - f64::from(end as f32)).abs());
        return if rounding[0].max(rounding[1]) > (high - low) / 65536.0 { low } else { 0.0 };
    }
    // A narrow range that is far from the values.
    if (low - of_values) as f32 == (high - of_values) as f32 { low } else { of_values }
}

/// The different values, unsorted; `None` if there are more than `most`. What is not a number is left out.
pub(super) fn different(values: &Values, most: usize) -> Option<Vec<f32>> {
    let merge = |mut a: Vec<u32>, b: &[u32]| {
        a.extend(b);
        a.sort_unstable();
        a.dedup();
        (a.len() <= most).then_some(a)
    };
    let of_piece = |piece: usize| {
        let mut keys = Vec::new();
        values.each(piece, |value| keys.extend((!value.is_nan()).then(|| sort_key(value + 0.0))));
        keys.sort_unstable();
        keys.dedup();
        keys
    };
    let pieces = (0..values.pieces()).into_par_iter().with_min_len(64);
    let all = pieces
        .fold(|| Some(Vec::new()), |all, piece| all.and_then(|all| merge(all, &of_piece(piece))))
        .reduce(|| Some(Vec::new()), |a, b| merge(a?, &b?))?;
    Some(all.into_iter().map(value).collect())
}

/// What the components of colours are multiplied by: 1 if none is above 1, else 1/255.
pub(super) fn color_scale<'a>(components: impl IntoIterator<Item = Values<'a>>) -> f32 {
    let of = |values: Values| Statistics::of(&values).finite;
    let most = components.into_iter().filter_map(of).map(|[_, high]| high).fold(0.0, f64::max);
    if most > 1.0 { 1.0 / 255.0 } else { 1.0 }
}
