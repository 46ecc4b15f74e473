//! A mesh in the arrays of a program, such as a simulation that draws what it computes.

use crate::loops::prelude::*;
use glam::DVec3;

use crate::mesh::{MAX_ELEMENTS, localize_at};
use crate::{Aabb, Mesh, OctNormal};

/// Positions in the precision of the program.
#[derive(Clone, Copy, Debug)]
pub enum Positions<'a> {
    /// Single precision.
    F32(&'a [[f32; 3]]),
    /// Double precision: detail far from the origin is kept, as [`Mesh::origin`] does.
    F64(&'a [[f64; 3]]),
}

/// A mesh in arrays that belong to somebody else, in object space. They are read, and not kept.
///
/// ```
/// use tercio_mesh::arrays::{Arrays, Positions};
///
/// let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0f32]];
/// let triangle = Arrays::new(Positions::F32(&corners), &[[0, 1, 2]]);
/// assert!(triangle.check().is_ok());
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Arrays<'a> {
    /// One position per vertex. Triangles with one that is not finite are not drawn.
    pub positions: Positions<'a>,
    /// Three vertex numbers per triangle, counter-clockwise seen from outside.
    pub triangles: &'a [[u32; 3]],
    /// One normal per vertex, of any length; they are made if there are none.
    pub normals: Option<&'a [[f32; 3]]>,
    /// sRGB colour and linear alpha, one per vertex.
    pub vertex_colors: Option<&'a [[u8; 4]]>,
}

/// Why arrays do not make a mesh.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ArraysError {
    /// An array does not have as many values as there are vertices.
    #[error("{found} {what} for {vertices} vertices: one for each is expected")]
    Length {
        /// What the array has.
        what: &'static str,
        /// Number of vertices.
        vertices: u64,
        /// Length of the array.
        found: u64,
    },
    /// A triangle has a corner that is not a vertex.
    #[error("corner {corner} of triangle {triangle} is vertex {vertex}, but there are {vertices} vertices")]
    Corner {
        /// Number of the triangle.
        triangle: u64,
        /// 0, 1 or 2.
        corner: u8,
        /// The vertex number found.
        vertex: u32,
        /// Number of vertices.
        vertices: u64,
    },
    /// More vertices or triangles than can be numbered.
    #[error("{count} {what}, at most {MAX_ELEMENTS} are supported")]
    TooMany {
        /// Vertices or triangles.
        what: &'static str,
        /// How many there are.
        count: u64,
    },
}

impl Positions<'_> {
    /// Number of vertices.
    pub fn len(&self) -> usize {
        match self {
            Self::F32(positions) => positions.len(),
            Self::F64(positions) => positions.len(),
        }
    }

    /// Are there no vertices?
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

impl<'a> Arrays<'a> {
    /// Triangles without normals and colours.
    pub fn new(positions: Positions<'a>, triangles: &'a [[u32; 3]]) -> Self {
        Self { positions, triangles, normals: None, vertex_colors: None }
    }

    /// Checks that the arrays make a mesh.
    ///
    /// # Errors
    /// [`ArraysError`] for the first thing that is wrong.
    pub fn check(&self) -> Result<(), ArraysError> {
        let vertices = self.positions.len() as u64;
        let triangles = self.triangles.len() as u64;
        for (what, count) in [("vertices", vertices), ("triangles", triangles)] {
            if count > MAX_ELEMENTS {
                return Err(ArraysError::TooMany { what, count });
            }
        }
        let lengths =
            [("normals", self.normals.map(<[_]>::len)), ("colours", self.vertex_colors.map(<[_]>::len))];
        for (what, found) in lengths {
            if let Some(found) = found.map(|n| n as u64).filter(|n| *n != vertices) {
                return Err(ArraysError::Length { what, vertices, found });
            }
        }
        let is_missing = |&vertex: &u32| u64::from(vertex) >= vertices;
        let wrong =
            self.triangles.par_iter().with_min_len(1 << 14).position_first(|t| t.iter().any(is_missing));
        let Some(triangle) = wrong else { return Ok(()) };
        let corner = self.triangles[triangle].iter().position(is_missing).unwrap_or(0);
        let vertex = self.triangles[triangle][corner];
        Err(ArraysError::Corner { triangle: triangle as u64, corner: corner as u8, vertex, vertices })
    }

    /// Bounds of the vertices with finite coordinates.
    pub fn bounds(&self) -> Aabb {
        fn of<T: Copy + Into<f64> + Sync>(positions: &[[T; 3]]) -> Aabb {
            let of_chunk = |chunk: &[[T; 3]]| {
                let points = chunk.iter().map(|p| DVec3::from(p.map(Into::into))).filter(|p| p.is_finite());
                points.fold(Aabb::EMPTY, |bounds, p| bounds.union(Aabb { min: p, max: p }))
            };
            positions.par_chunks(1 << 14).map(of_chunk).reduce(|| Aabb::EMPTY, Aabb::union)
        }
        match self.positions {
            Positions::F32(positions) => of(positions),
            Positions::F64(positions) => of(positions),
        }
    }

    /// A mesh with copies of the arrays and this [origin](Mesh::origin): not cleaned, not welded, without made normals. A normal
    /// that is zero or not finite is [`OctNormal::NONE`].
    pub fn mesh(&self, origin: DVec3) -> Mesh {
        let positions = match self.positions {
            Positions::F32(positions) if origin == DVec3::ZERO => positions.to_vec(),
            Positions::F32(positions) => {
                let local = |p: &[f32; 3]| std::array::from_fn(|k| (f64::from(p[k]) - origin[k]) as f32);
                positions.par_iter().with_min_len(1 << 14).map(local).collect()
            }
            Positions::F64(positions) => localize_at(positions, Some(origin)).2,
        };
        let normal = |n: &[f32; 3]| OctNormal::from_vector(n.map(f64::from));
        Mesh {
            origin,
            positions,
            triangles: self.triangles.to_vec(),
            normals: self.normals.map(|all| all.par_iter().with_min_len(1 << 14).map(normal).collect()),
            vertex_colors: self.vertex_colors.map(<[_]>::to_vec),
            ..Mesh::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNERS: [[f64; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [f64::NAN, 0.0, 7.0]];

    #[test]
    fn what_is_wrong_is_named() {
        let with = |triangles| Arrays::new(Positions::F64(&CORNERS), triangles);
        assert_eq!(with(&[[0, 1, 2], [3, 2, 1]]).check(), Ok(()));
        let outside = with(&[[0, 1, 2], [0, 4, 9]]).check();
        assert_eq!(outside, Err(ArraysError::Corner { triangle: 1, corner: 1, vertex: 4, vertices: 4 }));
        let colors = Arrays { vertex_colors: Some(&[[0; 4]; 3]), ..with(&[]) };
        let error = colors.check().expect_err("a colour is missing");
        assert_eq!(error.to_string(), "3 colours for 4 vertices: one for each is expected");
        let normals = Arrays { normals: Some(&[[0.0; 3]; 5]), ..with(&[]) };
        assert_eq!(normals.check(), Err(ArraysError::Length { what: "normals", vertices: 4, found: 5 }));
    }

    #[test]
    fn positions_are_relative_to_the_origin_in_both_precisions() {
        let far = DVec3::new(1e7, -2e7, 3e7);
        let shifted = CORNERS.map(|p| (DVec3::from(p) + far).to_array());
        let double = Arrays::new(Positions::F64(&shifted), &[[0, 1, 2]]);
        let bounds = double.bounds();
        assert_eq!((bounds.min, bounds.max), (far, far + DVec3::new(1.0, 1.0, 0.0)));
        assert_eq!(double.mesh(far).positions[..3], [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        let single = [[1.0f32, 2.0, 3.0], [-4.0, 5.0, 6.0]];
        let arrays = Arrays {
            normals: Some(&[[0.0, 0.0, 3.0], [0.0; 3]]),
            ..Arrays::new(Positions::F32(&single), &[])
        };
        assert_eq!(arrays.mesh(DVec3::ZERO).positions, single);
        let mesh = arrays.mesh(DVec3::new(1.0, 2.0, 3.0));
        assert_eq!(mesh.positions, [[0.0; 3], [-5.0, 3.0, 3.0]]);
        assert_eq!(mesh.normals, Some(vec![OctNormal::encode([0.0, 0.0, 1.0]), OctNormal::NONE]));
        assert_eq!(arrays.bounds().min, DVec3::new(-4.0, 2.0, 3.0));
    }
}
