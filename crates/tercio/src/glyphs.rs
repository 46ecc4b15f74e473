//! Glyphs: arrows and other bodies that show a vector at places of a model.
//!
//! ```
//! use tercio::glyphs::GlyphOptions;
//!
//! let model = tercio::load("builtin:sphere@2k")?;
//! let instance = tercio::scene::Instance::new(model.mesh);
//! let glyphs = GlyphOptions::new("@normal").glyphs(&instance, &model.strokes, None)?;
//! assert!(glyphs.list.len() > 100);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::collections::HashSet;

use glam::{DAffine3, DVec3};
use tercio_mesh::loops::prelude::*;
use tercio_mesh::strokes::Strokes;
use tercio_mesh::{Aabb, AttributeDomain};
use tercio_scene::{DataReader, Instance, SurfaceData};

use crate::data::{DataError, StrokeData, direction, stroke_layout};
use crate::strokes::is_shown;
pub use crate::strokes::{GlyphShape, glyphs as draw};

/// Which vectors are shown, and how.
#[derive(Clone, Debug, PartialEq)]
pub struct GlyphOptions {
    /// The name of an attribute of two or three components, as in [`DataOptions::by`](crate::data::DataOptions::by), or `@normal`.
    pub by: String,
    /// Their form.
    pub shape: GlyphShape,
    /// World units per unit of the vectors; `None` so that the longest one is about as long as they are apart.
    pub scale: Option<f64>,
    /// One glyph for so many places, spread evenly in space; `None` for at most [`ENOUGH`] of them.
    pub every: Option<u32>,
    /// Their colour where there are no data.
    pub color: Option<[u8; 4]>,
}

/// Glyphs that are drawn unless more are requested.
pub const ENOUGH: usize = 2000;

/// A vector at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Glyph {
    /// In world space.
    pub place: DVec3,
    /// In world space, as long as the glyph.
    pub vector: DVec3,
    /// sRGB and linear alpha.
    pub color: Option<[u8; 4]>,
}

/// Glyphs of a model.
#[derive(Clone, Debug, Default)]
pub struct Glyphs {
    /// All that are drawn.
    pub list: Vec<Glyph>,
    /// Their form.
    pub shape: GlyphShape,
    /// What their colours show, in the order of the list.
    pub data: Option<StrokeData>,
    /// Places with a vector of these kinds, which have no glyph: with length 0, and with something that is not a number.
    pub zero: usize,
    /// As `zero`.
    pub not_finite: usize,
    /// Places with vectors that have a glyph, or could have one.
    pub places: usize,
    /// World units per unit of the vectors.
    pub scale: f64,
}

impl Glyphs {
    /// Bounds of all places and ends.
    pub fn bounds(&self) -> Aabb {
        let mut bounds = Aabb::EMPTY;
        for glyph in &self.list {
            bounds.add(glyph.place);
            bounds.add(glyph.place + glyph.vector);
        }
        bounds
    }
}

/// A place with a vector, and where its colour is from.
#[derive(Clone, Copy)]
struct Candidate {
    place: DVec3,
    vector: DVec3,
    value: f32,
    color: Option<[u8; 4]>,
}

impl GlyphOptions {
    /// Arrows of a usual length.
    pub fn new(by: &str) -> Self {
        Self { by: by.into(), shape: GlyphShape::default(), scale: None, every: None, color: None }
    }

    /// The glyphs of a model's surface, or of its lines and points where only these have the vector. Those of triangles are at their
    /// centroids. Where the surface (its [data](Instance::data)) or the strokes (`data`) show data at the same places, glyphs do,
    /// too, unless they have a colour.
    ///
    /// # Errors
    /// [`DataError::NoVector`], which lists what there is.
    pub fn glyphs(
        &self,
        instance: &Instance,
        strokes: &Strokes,
        data: Option<&StrokeData>,
    ) -> Result<Glyphs, DataError> {
        let is_cloud = instance.mesh.clusters().is_empty();
        let of_surface = if is_cloud { None } else { Some(self.of_surface(instance)) };
        let on_strokes = || {
            let numbers = direction(&self.by, &stroke_layout(strokes))?;
            Ok(self.of_strokes((strokes, &instance.world_from_object), &numbers, data))
        };
        let (all, colors) = match of_surface {
            Some(Ok(found)) => found,
            Some(Err(error)) if strokes.is_empty() => return Err(error),
            Some(Err(error)) => on_strokes().map_err(|_: DataError| error)?,
            None => on_strokes()?,
        };
        let mut glyphs = Glyphs { shape: self.shape, ..Glyphs::default() };
        glyphs.zero = all.iter().filter(|c| c.vector == DVec3::ZERO).count();
        let all: Vec<Candidate> = {
            let count = all.len();
            let shown: Vec<Candidate> =
                all.into_iter().filter(|c| c.vector == DVec3::ZERO || is_shown(c.vector)).collect();
            glyphs.not_finite = count - shown.len();
            shown.into_iter().filter(|c| is_shown(c.vector) && c.place.is_finite()).collect()
        };
        let all = distinct(all);
        glyphs.places = all.len();
        let wanted = match self.every {
            Some(every) => all.len().div_ceil(every.max(1) as usize),
            None => all.len().min(ENOUGH),
        };
        let chosen = spread(all, wanted);
        let longest = chosen.iter().map(|c| c.vector.length()).fold(0.0, f64::max);
        let mut bounds = Aabb::EMPTY;
        chosen.iter().for_each(|c| bounds.add(c.place));
        let diagonal = if chosen.is_empty() { 0.0 } else { bounds.size().length() };
        let apart = (1.5 * diagonal / (chosen.len().max(1) as f64).sqrt()).min(0.15 * diagonal);
        let automatic = if apart > 0.0 && longest > 0.0 { apart / longest } else { 1.0 };
        glyphs.scale = self.scale.unwrap_or(automatic);
        let scaled = |c: &Candidate| Glyph {
            place: c.place,
            vector: c.vector * glyphs.scale,
            color: self.color.or(c.color),
        };
        glyphs.list = chosen.iter().map(scaled).filter(|glyph| is_shown(glyph.vector)).collect();
        if self.color.is_none() {
            glyphs.data = colors.map(|colors| {
                let is_drawn = |c: &&Candidate| is_shown(c.vector * glyphs.scale);
                let values = chosen.iter().filter(is_drawn).map(|c| c.value).collect();
                StrokeData::Mapped { values, colors }
            });
        }
        Ok(glyphs)
    }

    fn of_surface(&self, instance: &Instance) -> Result<Found, DataError> {
        let (mesh, to_world) = (&*instance.mesh, &instance.world_from_object);
        let layout = mesh.layout();
        let is_normal = self.by == "@normal";
        if is_normal && !layout.normals {
            return Err(DataError::NoNormals);
        }
        let numbers = if is_normal { Vec::new() } else { direction(&self.by, layout)? };
        let domain = numbers.first().map_or(AttributeDomain::Vertex, |&n| layout.attributes[n].1);
        let data = instance.data.as_deref().filter(|data| data.domain(layout) == domain);
        let (reader, colors) = match data {
            Some(SurfaceData::Mapped { source, colors }) => {
                let colors = tercio_scene::DataColors { isolines: None, ..(**colors).clone() };
                (Some(DataReader::new(source, instance, colors.offset)), Some(colors.into()))
            }
            _ => (None, None),
        };
        let normals = to_world.matrix3.inverse().transpose();
        let of_cluster = |number: usize| -> Vec<Candidate> {
            let cluster = mesh.cluster(number);
            let vector = |element: usize| {
                let full = |n: usize| layout.offset(n) + f64::from(cluster.attribute(n)[element]);
                let of = |k: usize| numbers.get(k).map_or(0.0, |&n| full(n));
                to_world.matrix3 * DVec3::new(of(0), of(1), of(2))
            };
            let at = |v: usize| mesh.position(&cluster, v);
            match domain {
                AttributeDomain::Vertex => (0..cluster.vertices())
                    .map(|v| Candidate {
                        place: to_world.transform_point3(at(v)),
                        vector: match cluster.normals().filter(|_| is_normal) {
                            Some(all) => {
                                (normals * DVec3::from(all[v].decode().map(f64::from))).normalize_or_zero()
                            }
                            None => vector(v),
                        },
                        value: reader.as_ref().map_or(f32::NAN, |reader| reader.vertex(&cluster, v)),
                        color: None,
                    })
                    .collect(),
                AttributeDomain::Triangle => (0..cluster.triangles())
                    .map(|t| {
                        let corners = cluster.corners_of(t).map(|v| at(v as usize));
                        let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
                        let value = |reader: &DataReader| reader.triangle(mesh, number, &cluster, t);
                        Candidate {
                            place: to_world.transform_point3(middle),
                            vector: vector(t),
                            value: reader.as_ref().map_or(f32::NAN, value),
                            color: None,
                        }
                    })
                    .collect(),
            }
        };
        let clusters = (0..mesh.clusters().len()).into_par_iter().with_min_len(64);
        Ok((clusters.flat_map_iter(of_cluster).collect(), colors))
    }

    /// Of strokes at a place in the world.
    fn of_strokes(
        &self,
        (strokes, to_world): (&Strokes, &DAffine3),
        numbers: &[usize],
        data: Option<&StrokeData>,
    ) -> Found {
        let candidate = |v: usize| {
            let full = |a: &tercio_mesh::Attribute| a.full(a.values[v]);
            let of = |k: usize| numbers.get(k).map_or(0.0, |&n| full(&strokes.attributes[n]));
            let (value, color) = match data {
                Some(StrokeData::Mapped { values, .. }) => (values[v], None),
                Some(StrokeData::Direct(colors)) => (f32::NAN, Some(colors[v])),
                None => (f32::NAN, strokes.color(v as u32)),
            };
            Candidate {
                place: to_world.transform_point3(strokes.position(v as u32)),
                vector: to_world.matrix3 * DVec3::new(of(0), of(1), of(2)),
                value,
                color,
            }
        };
        let colors = match data {
            Some(StrokeData::Mapped { colors, .. }) => Some(std::sync::Arc::clone(colors)),
            _ => None,
        };
        ((0..strokes.positions.len()).map(candidate).collect(), colors)
    }
}

type Found = (Vec<Candidate>, Option<std::sync::Arc<tercio_scene::DataColors>>);

/// Sorts places by their coordinates and drops those that are there again with the same vector: vertices are in several clusters.
/// So nothing depends on the partition.
fn distinct(mut all: Vec<Candidate>) -> Vec<Candidate> {
    let key = |c: &Candidate| {
        let bits = |v: DVec3| v.to_array().map(|c| (c + 0.0).to_bits());
        (bits(c.place), bits(c.vector), c.value.to_bits(), c.color)
    };
    all.par_sort_unstable_by_key(key);
    all.dedup_by_key(|c| key(c));
    all
}

/// About so many of the candidates, spread evenly: one in each cell of a grid, the one next to its middle.
fn spread(all: Vec<Candidate>, wanted: usize) -> Vec<Candidate> {
    if wanted >= all.len() {
        return all;
    }
    let mut bounds = Aabb::EMPTY;
    all.iter().for_each(|c| bounds.add(c.place));
    let extent = bounds.size().max_element().max(f64::MIN_POSITIVE);
    let cell_of = |place: DVec3, cells: f64| {
        let at = (place - bounds.min) / extent * cells;
        at.to_array().map(|c| c as u32)
    };
    // Are there more occupied cells than are wanted?
    let is_too_fine = |cells: f64| {
        let mut seen = HashSet::new();
        all.iter().any(|c| {
            seen.insert(cell_of(c.place, cells));
            seen.len() > wanted
        })
    };
    let (mut coarse, mut fine) = (0.5f64, 2f64);
    while !is_too_fine(fine) && fine < 1e6 {
        (coarse, fine) = (fine, fine * 2.0);
    }
    for _ in 0..8 {
        let middle = (coarse * fine).sqrt();
        *(if is_too_fine(middle) { &mut fine } else { &mut coarse }) = middle;
    }
    let mut cells: Vec<([u32; 3], u64, usize)> = all
        .iter()
        .enumerate()
        .map(|(number, c)| {
            let cell = cell_of(c.place, coarse);
            let middle = bounds.min + (DVec3::from(cell.map(f64::from)) + 0.5) * (extent / coarse);
            (cell, c.place.distance_squared(middle).to_bits(), number)
        })
        .collect();
    cells.par_sort_unstable();
    cells.dedup_by_key(|(cell, ..)| *cell);
    cells.into_iter().map(|(.., number)| all[number]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_subset_is_spread_evenly_and_has_no_place_twice() {
        let at = |i: usize| DVec3::new((i % 100) as f64, (i / 100) as f64, 0.0);
        let candidate =
            |i: usize| Candidate { place: at(i % 10_000), vector: DVec3::X, value: 0.0, color: None };
        let all = distinct((0..20_000).map(candidate).collect());
        assert_eq!(all.len(), 10_000);
        for wanted in [1, 10, 100, 1000, 9999] {
            let some = spread(all.clone(), wanted);
            assert!(some.len() <= wanted && some.len() * 3 >= wanted.min(2000), "{} of {wanted}", some.len());
            if wanted == 100 {
                // The farthest place from all that are chosen is not far from one.
                let far =
                    all.iter().map(|c| some.iter().map(|s| s.place.distance(c.place)).fold(1e9, f64::min));
                let farthest = far.fold(0.0, f64::max);
                assert!(farthest < 20.0, "{farthest}");
            }
        }
    }
}
