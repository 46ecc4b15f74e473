//! The indexed triangle mesh.

use std::ops::Range;

use crate::loops::prelude::*;
use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::{Aabb, FileMaterial, OctNormal};

/// The largest number of vertices or triangles: both are numbered in 32 bits, and the last number is reserved for
/// "none".
pub const MAX_ELEMENTS: u64 = u32::MAX as u64 - 1;

/// An indexed triangle mesh in object space.
///
/// A triangle's number is its index in [`Mesh::triangles`]; it decides visibility among equal depths and must not
/// depend on how the mesh is later split into clusters.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Position in object space of the point that [`Mesh::positions`] are relative to.
    pub origin: DVec3,
    /// log2 of the length of a unit of [`Mesh::positions`]: 0 except for models so large or so small that
    /// calculations with their `f32` coordinates would overflow or underflow; see [`Mesh::bring_into_range`].
    pub exponent: i32,
    /// Vertex positions relative to `origin`, in units of 2^`exponent`. All finite.
    pub positions: Vec<[f32; 3]>,
    /// Three vertex numbers per triangle, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Unit normals, one per vertex.
    pub normals: Option<Vec<OctNormal>>,
    /// sRGB colour and linear alpha, one per vertex.
    pub vertex_colors: Option<Vec<[u8; 4]>>,
    /// sRGB colour and linear alpha, one per triangle. Takes precedence over vertex colours.
    pub face_colors: Option<Vec<[u8; 4]>>,
    /// Texture coordinates, one pair per vertex, v upwards.
    pub texcoords: Option<Vec<[f32; 2]>>,
    /// All other scalars of the file.
    pub attributes: Vec<Attribute>,
    /// Materials that the file names.
    pub materials: Vec<FileMaterial>,
    /// Index into `materials`, one per triangle; [`Mesh::NO_MATERIAL`] where there is none.
    pub triangle_materials: Option<Vec<u32>>,
    /// Number of the input face (polygon) that a triangle came from; `None` where face i is triangle i.
    pub face_of_triangle: Option<Vec<u32>>,
}

/// Whether an attribute's values belong to vertices or to triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum AttributeDomain {
    /// One value per vertex.
    Vertex,
    /// One value per triangle.
    Triangle,
}

/// A named scalar array.
///
/// An array of several components, such as vectors of VTK, is one attribute a component, named `NAME:0`, `NAME:1` and
/// so on ([`Attribute::component_name`]), one after the other. Values that are not numbers stay NaN.
#[derive(Clone, Debug, PartialEq)]
pub struct Attribute {
    /// The name in the file; of components see above.
    pub name: String,
    /// Whether the values belong to vertices or to triangles.
    pub domain: AttributeDomain,
    /// One value per element, less [`Attribute::offset`].
    pub values: Vec<f32>,
    /// What is added to the values to get those of the file: not 0 only where the file has 64 bits, and its values differ by so
    /// little that `f32` would round the differences away, or are whole and would be rounded.
    pub offset: f64,
    /// What the file calls this component of an array, if it names them.
    pub component: Option<String>,
}

impl Attribute {
    /// The name of what is no data of the file: of a triangle whose input face has several polygons (a cell with a volume, a strip),
    /// the number of its polygon within the face. Edges are between polygons. Files whose faces are polygons do without.
    pub const POLYGON: &str = "@polygon";

    /// Is that an attribute of [polygons](Self::POLYGON), no data of the file?
    pub fn is_polygon(name: &str, domain: AttributeDomain) -> bool {
        name == Self::POLYGON && domain == AttributeDomain::Triangle
    }

    /// The name of a component of an array with so many: that of the array if it has one component only.
    pub fn component_name(array: &str, component: usize, of: usize) -> String {
        if of == 1 { array.into() } else { format!("{array}:{component}") }
    }

    /// Bytes that the components of an array take without their values, about: a file of a few bytes can have many, of long names.
    pub(crate) fn bytes_of_names(array: &str, components: usize) -> u64 {
        (components as u64).saturating_mul(128 + array.len() as u64)
    }
}

impl Mesh {
    /// The entry of `triangle_materials` for a triangle without a material.
    pub const NO_MATERIAL: u32 = u32::MAX;

    /// Length of a unit of [`Mesh::positions`].
    pub fn unit(&self) -> f64 {
        power_of_two(self.exponent)
    }

    /// Chooses another unit for the positions if `largest`, the largest absolute value of a coordinate of a triangle,
    /// is 2^40 or more, or less than 2^-40: then it becomes at least 1 and less than 2. Exact, because a unit is a
    /// power of two, except for coordinates so much smaller than the largest that they underflow, which become 0.
    /// Vertices that no triangle uses stay finite.
    ///
    /// Then squares, products with the size of a picture and sums of coordinates neither overflow nor underflow
    /// `f32`.
    pub fn bring_into_range(&mut self, largest: f32) {
        if SAFE_MAGNITUDES.contains(&largest) || !(largest > 0.0 && largest.is_finite()) {
            return;
        }
        // `f64` holds every `f32` as a normal number.
        let shift = exponent_of(f64::from(largest));
        let scale = power_of_two(-shift);
        self.positions
            .par_iter_mut()
            .with_min_len(1 << 14)
            .for_each(|p| *p = p.map(|c| ((f64::from(c) * scale) as f32).clamp(-f32::MAX, f32::MAX)));
        self.exponent += shift;
    }

    /// Keeps only these triangles, and what belongs to them. No vertex is removed.
    ///
    /// # Panics
    /// If there are no such triangles, or an array of the mesh is too short.
    pub fn keep_triangles(&mut self, range: Range<usize>) {
        fn keep<T>(array: &mut Vec<T>, range: &Range<usize>) {
            array.truncate(range.end);
            array.drain(..range.start);
        }
        keep(&mut self.triangles, &range);
        self.face_colors.iter_mut().for_each(|a| keep(a, &range));
        self.triangle_materials.iter_mut().for_each(|a| keep(a, &range));
        self.face_of_triangle.iter_mut().for_each(|a| keep(a, &range));
        let of_triangles = self.attributes.iter_mut().filter(|a| a.domain == AttributeDomain::Triangle);
        of_triangles.for_each(|a| keep(&mut a.values, &range));
    }

    /// World-space bounds of all vertices, used by a triangle or not.
    pub fn bounds(&self) -> Aabb {
        let (min, max) = self.positions.par_chunks(1 << 16).map(ranges).reduce(
            || ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]),
            |a, b| (lower(a.0, b.0), upper(a.1, b.1)),
        );
        if self.positions.is_empty() {
            return Aabb::EMPTY;
        }
        let unit = self.unit();
        let world = |p: [f32; 3]| self.origin + DVec3::new(p[0].into(), p[1].into(), p[2].into()) * unit;
        Aabb { min: world(min), max: world(max) }
    }

    /// The triangle rotated so that its lowest vertex number comes first.
    ///
    /// Depth and attributes are interpolated from the first corner; rotating every triangle the same way makes the
    /// picture independent of the corner at which the file happens to begin.
    #[inline]
    pub fn canonical([a, b, c]: [u32; 3]) -> [u32; 3] {
        if a <= b && a <= c {
            [a, b, c]
        } else if b <= c {
            [b, c, a]
        } else {
            [c, a, b]
        }
    }
}

/// Absolute values of the largest coordinate for which calculations in `f32` neither overflow nor underflow.
pub(crate) const SAFE_MAGNITUDES: Range<f32> = (1.0 / (1u64 << 40) as f32)..(1u64 << 40) as f32;

/// Bias of the exponent of `f64`, which is stored above the 52 bits of the fraction.
const EXPONENT_BIAS: i32 = 1023;

/// 2^`exponent`, exact, for exponents from -1022 to 1023.
pub fn power_of_two(exponent: i32) -> f64 {
    f64::from_bits(((exponent + EXPONENT_BIAS) as u64) << 52)
}

/// log2 of the largest power of two that is at most the absolute value of a normal number.
pub fn exponent_of(number: f64) -> i32 {
    ((number.to_bits() >> 52) & 0x7ff) as i32 - EXPONENT_BIAS
}

/// The least and the largest coordinates; NaN is ignored.
fn ranges(points: &[[f32; 3]]) -> ([f32; 3], [f32; 3]) {
    // Four points at a time, so that the compiler can vectorize over whole points.
    let (mut min, mut max) = ([[f32::INFINITY; 3]; 4], [[f32::NEG_INFINITY; 3]; 4]);
    let (whole, rest) = points.as_chunks::<4>();
    for points in whole {
        for i in 0..4 {
            (min[i], max[i]) = (lower(min[i], points[i]), upper(max[i], points[i]));
        }
    }
    for &p in rest {
        (min[0], max[0]) = (lower(min[0], p), upper(max[0], p));
    }
    (min.into_iter().fold(min[0], lower), max.into_iter().fold(max[0], upper))
}

/// The lower of each pair of coordinates; the first where the second is NaN.
#[inline]
fn lower([a, b, c]: [f32; 3], [x, y, z]: [f32; 3]) -> [f32; 3] {
    [if x < a { x } else { a }, if y < b { y } else { b }, if z < c { z } else { c }]
}

/// The upper of each pair of coordinates; the first where the second is NaN.
#[inline]
fn upper([a, b, c]: [f32; 3], [x, y, z]: [f32; 3]) -> [f32; 3] {
    [if x > a { x } else { a }, if y > b { y } else { b }, if z > c { z } else { c }]
}

/// The origin that keeps a model's detail when its positions become `f32`: zero where `f32` is precise enough, else
/// the centre of the model.
///
/// `bounds` are in file coordinates. A model whose coordinates are at most four times its own size loses at most two
/// bits with origin zero, so it gets that, and its positions in memory are those of the file.
pub fn choose_origin(bounds: &Aabb) -> DVec3 {
    let farthest = bounds.min.abs().max(bounds.max.abs()).max_element();
    if bounds.is_empty() || farthest <= 4.0 * bounds.size().max_element() {
        DVec3::ZERO
    } else {
        bounds.center()
    }
}

/// Positions relative to the origin of [`choose_origin`], from file coordinates. Non-finite positions do not affect
/// the choice and stay non-finite.
pub fn localize(points: &[[f64; 3]]) -> (DVec3, Vec<[f32; 3]>) {
    let (_, origin, positions) = localize_at(points, None);
    (origin, positions)
}

/// As [`localize`], relative to another origin if there is one. The bounds of the finite positions, in file coordinates, come
/// first.
pub fn localize_at(points: &[[f64; 3]], origin: Option<DVec3>) -> (Aabb, DVec3, Vec<[f32; 3]>) {
    let bounds = points
        .par_chunks(1 << 16)
        .map(|chunk| {
            let mut b = Aabb::EMPTY;
            chunk.iter().map(|&p| DVec3::from(p)).filter(|p| p.is_finite()).for_each(|p| b.add(p));
            b
        })
        .reduce(|| Aabb::EMPTY, Aabb::union);
    let origin = origin.unwrap_or_else(|| choose_origin(&bounds));
    let local = points
        .par_iter()
        .map(|&p| {
            let q = DVec3::from(p) - origin;
            [q.x as f32, q.y as f32, q.z as f32]
        })
        .collect();
    (bounds, origin, local)
}

/// As [`localize_at`], for `f32`, in place.
pub(crate) fn localize_single_at(
    mut points: Vec<[f32; 3]>,
    origin: Option<DVec3>,
) -> (Aabb, DVec3, Vec<[f32; 3]>) {
    let world = |p: &[f32; 3]| DVec3::new(p[0].into(), p[1].into(), p[2].into());
    let bounds = points
        .par_chunks(1 << 16)
        .map(|chunk| {
            let mut bounds = Aabb::EMPTY;
            chunk.iter().map(world).filter(|p| p.is_finite()).for_each(|p| bounds.add(p));
            bounds
        })
        .reduce(|| Aabb::EMPTY, Aabb::union);
    let origin = origin.unwrap_or_else(|| choose_origin(&bounds));
    if origin != DVec3::ZERO {
        points.par_iter_mut().for_each(|p| *p = (world(p) - origin).as_vec3().to_array());
    }
    (bounds, origin, points)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_hold_every_finite_coordinate() {
        let mut random = 1u32;
        let mut next = || {
            random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (random >> 8) as f32 / 1e5 - 80.0
        };
        for n in [1, 3, 4, 7, 70_000] {
            let mut positions: Vec<[f32; 3]> = (0..n).map(|_| [next(), next(), next()]).collect();
            let origin = DVec3::new(1.0, -2.0, 3.0);
            let mut expected = Aabb::EMPTY;
            positions.iter().for_each(|&p| expected.add(origin + glam::Vec3::from(p).as_dvec3()));
            positions.push([f32::NAN; 3]);
            let mesh = Mesh { origin, positions, ..Mesh::default() };
            assert_eq!(mesh.bounds(), expected, "{n}");
        }
        assert!(Mesh::default().bounds().is_empty());
    }
}
