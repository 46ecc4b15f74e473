//! The edges of a mesh, each once: those of polygons, features, borders.
//!
//! Vertices are identified by position, as in [`topology`](crate::topology), so that a seam in the normals or texture
//! coordinates is not a border. Diagonals of triangulated polygons are no edges; sides of polygons are, also between those of one cell of
//! VTK, such as the triangles of a strip ([`Attribute::POLYGON`](crate::Attribute::POLYGON)). What is found does not depend on how the
//! mesh is split into clusters, nor on the number of threads.

mod find;
mod polygons;
mod silhouettes;
mod sources;

use std::sync::Arc;

use glam::{DVec3, Vec3};

pub use polygons::place;
pub use silhouettes::Viewer;

use crate::mesh::power_of_two;
use crate::{Aabb, ClusteredMesh, Mesh};

/// Which edges of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Selection {
    /// All edges of polygons.
    All,
    /// Edges at which the surface is bent by more than so many radians, and those of [`Selection::Boundary`].
    Feature(f64),
    /// Edges of one triangle, and those of more than two.
    Boundary,
    /// Edges that may be on the silhouette for some camera: all at which the surface is bent, and those of
    /// [`Selection::Boundary`].
    Silhouette,
}

/// What meets at an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EdgeKind {
    /// One triangle.
    Boundary,
    /// Two triangles.
    Inner,
    /// More than two triangles. Such an edge is listed once for every two of them.
    NonManifold,
}

/// An edge of a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Edge {
    /// Vertex numbers of its ends, in the order in which the first of its triangles runs along it.
    pub ends: [u32; 2],
    /// Vertex numbers of the third corners of its first two triangles; [`Edge::NONE`] where there is no second one.
    pub apexes: [u32; 2],
    /// What meets there.
    pub kind: EdgeKind,
    /// The first of its triangles: its place in the order of the triangles of the mesh, from 0, as in [`Edges::sides`].
    pub triangle: u32,
}

impl Edge {
    /// The number of a corner that does not exist.
    pub const NONE: u32 = u32::MAX;
}

/// Where an edge is, in the space of [`Edges::positions`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgeCorners {
    /// Its ends, as in [`Edge::ends`].
    pub ends: [[f32; 3]; 2],
    /// The third corners of its triangles, as in [`Edge::apexes`].
    pub apexes: [Option<[f32; 3]>; 2],
    /// What meets there.
    pub kind: EdgeKind,
}

/// The edges of polygons of several triangles that are no sides of a triangle, but begin at its corners, beyond a side of it that is no edge.
/// Numbers of corners and sides are those of the [canonical](Mesh::canonical) triangles.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Beyond {
    /// All polygons are triangles.
    #[default]
    Nothing,
    /// No polygon has more than four corners: the fourth corners of halves.
    Quadrilaterals(FourthCorners),
    /// All polygons are flat, without reflex angles: for each triangle the numbers of its sides, each opposite to the corner of that
    /// number. There is a number for each end of the side: with p the corner opposite to the side, q the next one and r the one after
    /// that, the first of two numbers a and b means the line from r on which a times the barycentric coordinate of p is minus
    /// that of q, and the second one the line from q on which b times that of p is minus that of r. The triangles between the side and
    /// the edge are turned about their common sides into the plane for that. 0 means that there is none beside the sides of the
    /// triangle.
    Polygons(Vec<[[f32; 2]; 3]>),
    /// Polygons of any form: where the edges end.
    Ends(FarEnds),
}

impl Beyond {
    /// The largest number: its line is that of the side, up to a millionth of the height of the triangle. Larger ones could overflow.
    pub const MOST: f64 = 1e6;

    /// All numbers of flat polygons, triangle by triangle.
    pub fn numbers(&self) -> &[f32] {
        match self {
            Self::Nothing | Self::Quadrilaterals(_) | Self::Ends(_) => &[],
            Self::Polygons(all) => all.as_flattened().as_flattened(),
        }
    }

    /// For how many triangles there are edges; `None` if there are none for any.
    pub fn triangles(&self) -> Option<usize> {
        match self {
            Self::Nothing => None,
            Self::Quadrilaterals(corners) => Some(corners.vertices.len()),
            Self::Polygons(all) => Some(all.len()),
            Self::Ends(ends) => Some(ends.first.len() - 1),
        }
    }
}

/// The corners of quadrilaterals that are not in a triangle.
#[derive(Clone, Debug, PartialEq)]
pub struct FourthCorners {
    /// For each triangle the vertex, or [`Edge::NONE`].
    vertices: Vec<u32>,
    positions: Arc<Vec<[f32; 3]>>,
}

impl FourthCorners {
    /// For each triangle the number of a position, or [`Edge::NONE`].
    pub fn new(vertices: Vec<u32>, positions: Arc<Vec<[f32; 3]>>) -> Self {
        Self { vertices, positions }
    }

    /// The fourth corner of the quadrilateral of which a triangle is a half, in the space of the mesh's positions: two edges from there end
    /// at the ends of its only side that is no edge.
    ///
    /// # Panics
    /// If there is no such triangle.
    #[inline]
    pub fn of(&self, triangle: usize) -> Option<[f32; 3]> {
        self.positions.get(self.vertices[triangle] as usize).copied()
    }
}

/// The other ends of edges that begin at corners of triangles.
#[derive(Clone, Debug, PartialEq)]
pub struct FarEnds {
    /// For each triangle the place of its first edge, and after that how many edges there are.
    first: Vec<u64>,
    /// For each edge the side of the triangle that it is beyond, twice, plus [`FarEnd::end`].
    sides: Vec<u8>,
    /// For each edge the vertex at its other end.
    ends: Vec<u32>,
    positions: Arc<Vec<[f32; 3]>>,
}

/// An edge that begins at a corner of a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FarEnd {
    /// The side beyond which it is, opposite to the corner of this number.
    pub side: u8,
    /// At which end of the side the edge begins: corner `side` + 1 + `end`, modulo 3.
    pub end: u8,
    /// The other end of the edge, in the space of the mesh's positions.
    pub position: [f32; 3],
}

impl FarEnds {
    /// The most edges of a triangle.
    pub const MOST: usize = 6;

    /// For each triangle its edges: [`FarEnd::side`], [`FarEnd::end`], and the number of the position of the other end.
    ///
    /// # Panics
    /// If a triangle has too many edges, or a number is too large.
    pub fn new(triangles: &[Vec<(u8, u8, u32)>], positions: Arc<Vec<[f32; 3]>>) -> Self {
        let (mut first, mut sides, mut ends) = (vec![0], Vec::new(), Vec::new());
        for edges in triangles {
            assert!(edges.len() <= Self::MOST, "more than {} edges", Self::MOST);
            for &(side, end, vertex) in edges {
                assert!(side < 3 && end < 2 && (vertex as usize) < positions.len(), "no such edge");
                sides.push(2 * side + end);
                ends.push(vertex);
            }
            first.push(ends.len() as u64);
        }
        Self { first, sides, ends, positions }
    }

    /// The edges of a triangle, at most [`FarEnds::MOST`].
    ///
    /// # Panics
    /// If there is no such triangle.
    #[inline]
    pub fn of(&self, triangle: usize) -> impl Iterator<Item = FarEnd> {
        let all = self.first[triangle] as usize..self.first[triangle + 1] as usize;
        self.sides[all.clone()].iter().zip(&self.ends[all]).map(|(code, &end)| FarEnd {
            side: code >> 1,
            end: code & 1,
            position: self.positions[end as usize],
        })
    }
}

/// Where the line of an edge of a polygon may reach over more than the triangles that it begins at.
#[derive(Clone, Debug)]
pub struct Folds {
    /// The sides of triangles at which polygons are bent, by more than a degree, which are no edges, as edges.
    pub sides: Edges,
    /// For each of these the edges that begin at its ends and are of its polygon: their numbers in the list of edges, or [`Edge::NONE`].
    pub edges: Vec<[u32; 4]>,
    /// The numbers of the edges of triangles without height.
    pub slivers: Vec<u32>,
}

/// Edges with vertices of their own.
#[derive(Clone, Debug, Default)]
pub struct Edges {
    /// Position in object space of the point that [`Edges::positions`] are relative to.
    pub origin: DVec3,
    /// log2 of the length of a unit of the positions.
    pub exponent: i32,
    /// Positions of the vertices that edges use.
    pub positions: Arc<Vec<[f32; 3]>>,
    /// The edges, in the order of their first triangles. To be changed, if at all, before the first [`Edges::silhouettes`].
    pub list: Vec<Edge>,
    /// For each triangle of the mesh, which of its sides are such edges: bit k is that of the side opposite to corner k of the
    /// [canonical](Mesh::canonical) triangle. Sides of triangles without three different corners are none.
    pub sides: Vec<u8>,
    /// If all edges are selected, where those of a polygon are, seen from each of its triangles.
    pub beyond: Beyond,
    /// Where polygons are bent by more than a degree, or have triangles without height.
    pub folds: Option<Box<Folds>>,
    /// The whole mesh is closed and consistently wound: it separates an inside from an outside, so that from outside only
    /// front faces are seen.
    pub is_solid: bool,
    /// It is solid, no edge has more than two triangles, and no part of it is turned inside out, as the wall of a cavity is: each part
    /// encloses a volume above 0. Parts that intersect themselves may have places that are turned inside out nevertheless.
    pub is_outward: bool,
    /// The box of the positions; empty without any.
    bounds: [Vec3; 2],
    /// Of the list, to find silhouettes.
    cones: silhouettes::LazyCones,
}

impl Edges {
    /// The selected edges of a mesh.
    ///
    /// # Panics
    /// If a triangle's vertex does not exist.
    pub fn of_mesh(mesh: &Mesh, selection: Selection) -> Self {
        sources::of_mesh(mesh, selection)
    }

    /// The selected edges of a mesh that was split into clusters: those of the mesh as it was before.
    pub fn of_clusters(mesh: &ClusteredMesh, selection: Selection) -> Self {
        sources::of_clusters(mesh, selection)
    }

    /// The most bytes that [`Edges::of_clusters`] takes.
    pub fn needed_bytes(mesh: &ClusteredMesh) -> u64 {
        let (vertices, triangles) = (mesh.vertex_count() as u64, mesh.triangle_count() as u64);
        // Positions, their representatives with a hash table, corners, triangles at vertices, and edges with their order:
        // of a closed mesh three for two triangles, of a soup three a triangle; sides, parts, twins, what is beyond them,
        // twice, and folds. Cones take less than what is gone then.
        vertices * (12 + 4 + 24 + 16) + triangles * (12 + 20 + 3 * 64 + 1 + 4 + 24 + 48 + 40 + 64)
    }

    /// Position of a vertex in object space.
    pub fn position(&self, vertex: u32) -> DVec3 {
        let p = DVec3::from(self.positions[vertex as usize].map(f64::from));
        self.origin + p * self.unit()
    }

    /// Calls a function for edges of the list, given by their numbers, in this order, with their corners.
    ///
    /// # Panics
    /// If there is no edge with such a number.
    pub fn for_each_corners(&self, numbers: &[u32], mut with: impl FnMut(u32, &EdgeCorners)) {
        // All of a few edges are fetched first: if nothing else is done between, the processor waits for their memory once.
        const TOGETHER: usize = 32;
        let nowhere = EdgeCorners { ends: [[0.0; 3]; 2], apexes: [None; 2], kind: EdgeKind::Inner };
        let mut fetched = [nowhere; TOGETHER];
        for numbers in numbers.chunks(TOGETHER) {
            for (corners, &number) in fetched.iter_mut().zip(numbers) {
                let edge = &self.list[number as usize];
                corners.ends = edge.ends.map(|v| self.positions[v as usize]);
                corners.apexes = edge.apexes.map(|v| self.positions.get(v as usize).copied());
                corners.kind = edge.kind;
            }
            for (corners, &number) in fetched.iter().zip(numbers) {
                with(number, corners);
            }
        }
    }

    /// The box of the vertices that edges use, in object space.
    pub fn bounds(&self) -> Aabb {
        let [min, max] = self.bounds.map(|corner| self.origin + corner.as_dvec3() * self.unit());
        if self.positions.is_empty() { Aabb::EMPTY } else { Aabb { min, max } }
    }

    /// The length of a unit of the positions.
    pub fn unit(&self) -> f64 {
        power_of_two(self.exponent)
    }

    /// How many edges there are of one kind; edges of more than two triangles are counted once for every two.
    pub fn count(&self, kind: EdgeKind) -> usize {
        self.list.iter().filter(|edge| edge.kind == kind).count()
    }
}

/// Normals of two triangles at the side between these ends, not normalized, as if both ran along it in opposite directions, however
/// they are wound.
fn normals_beside(from: DVec3, to: DVec3, [apex, other_apex]: [DVec3; 2]) -> [DVec3; 2] {
    let along = to - from;
    [along.cross(apex - from), (other_apex - from).cross(along)]
}

/// Sine and cosine of the angle between two normals, times both of their lengths; exact for small angles, too. A triangle
/// without area has no direction.
fn bend([m, n]: [DVec3; 2]) -> (f64, f64) {
    (m.cross(n).length(), m.dot(n))
}

#[cfg(test)]
mod tests;
