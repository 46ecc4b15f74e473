//! Cones of the normals beside groups of edges (Shirmun and Abi-Ezzi, 1993), by which a viewer finds silhouettes without looking at
//! every edge: nearly all groups of a smooth surface are seen from one side.

use glam::{DVec3, Vec3};

use super::{Edge, Edges, normals_beside};
use crate::blocks::interleave;
use crate::loops::prelude::*;
use crate::trig::sin_cos;

/// From where, or in which direction, a viewer looks, in the space of [`Edges::positions`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sight {
    /// The eye of a perspective camera.
    From(DVec3),
    /// The direction of sight of an orthographic camera.
    Along(DVec3),
}

/// Triangles that are seen at a smaller angle, in radians, may be seen edge-on. It is far more than what is rounded.
const LEAST_ANGLE: f64 = 0.011;
/// Triangles whose heights over their edges are at most this many times the diagonal of the model have no certain direction.
const LEAST_HEIGHT: f64 = 1e-6;
/// Cells along each axis of the grid by which edges are grouped.
const CELLS: f32 = 1024.0;

/// Groups of edges that are near each other, with their cones.
#[derive(Clone, Debug)]
pub struct Cones {
    /// The box of the vertices, in the space of [`Edges::positions`]; empty if there are none.
    pub bounds: [Vec3; 2],
    /// The numbers of the edges, group by group.
    order: Vec<u32>,
    list: Vec<Cone>,
}

/// The cone of a group.
#[derive(Clone, Copy, Debug)]
struct Cone {
    /// A sphere that holds the first ends of all edges.
    center: Vec3,
    radius: f32,
    /// The direction of the middle. The normals of both triangles at each edge, or the opposite ones of both, are in the cone.
    axis: Vec3,
    /// Sine and cosine of the angle between the axis and the surface of the cone, plus [`LEAST_ANGLE`].
    sin: f32,
    cos: f32,
}

impl Cones {
    /// Edges in a group; the last one may be smaller.
    const SIZE: usize = 8;

    pub(super) fn new(edges: &Edges) -> Self {
        let (mut min, mut max) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for &p in &edges.positions {
            (min, max) = (min.min(p.into()), max.max(p.into()));
        }
        let least_height = LEAST_HEIGHT * (max - min).as_dvec3().length();
        let at = |v: u32| DVec3::from(edges.positions[v as usize].map(f64::from));
        let scale = CELLS / (max - min).max_element();
        let cell = |p: [f32; 3]| ((Vec3::from(p) - min) * scale).min(Vec3::splat(CELLS - 1.0)).as_uvec3();
        let keyed = |number: u32| {
            let first = edges.positions[edges.list[number as usize].ends[0] as usize];
            (interleave(cell(first).to_array()), number)
        };
        let mut order: Vec<(u32, u32)> = (0..edges.list.len() as u32).into_par_iter().map(keyed).collect();
        order.par_sort_unstable();
        let order: Vec<u32> = order.into_par_iter().map(|(_, number)| number).collect();
        let cone = |numbers: &[u32]| {
            let group = numbers.iter().map(|&number| &edges.list[number as usize]);
            Cone::new(group, at, least_height)
        };
        let list = order.par_chunks(Self::SIZE).with_min_len(256).map(cone).collect();
        Self { bounds: [min, max], order, list }
    }

    /// The numbers of the edges for which `is_on` holds, in order. Only edges that may be on the silhouette are looked at: in the
    /// picture, all others lie between their two triangles.
    pub fn silhouettes(&self, sight: Sight, is_on: impl Fn(u32) -> bool + Sync) -> Vec<u32> {
        let groups = self.order.par_chunks(Self::SIZE).zip(&self.list).with_min_len(256);
        let candidates = groups.filter(|(_, cone)| !cone.is_seen_from_one_side(sight));
        let mut found: Vec<u32> =
            candidates.flat_map_iter(|(numbers, _)| numbers.iter().copied().filter(|&n| is_on(n))).collect();
        found.par_sort_unstable();
        found
    }
}

impl Cone {
    fn new<'a>(
        edges: impl ExactSizeIterator<Item = &'a Edge> + Clone,
        at: impl Fn(u32) -> DVec3,
        least_height: f64,
    ) -> Self {
        let count = edges.len();
        let first_ends = || edges.clone().map(|edge| at(edge.ends[0]));
        let (min, max) = first_ends()
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(min, max), p| (min.min(p), max.max(p)));
        let center = ((min + max) * 0.5).as_vec3();
        let radius = first_ends().map(|p| p.distance(center.as_dvec3())).fold(0.0, f64::max);
        let anything = Self { center, radius: radius as f32, axis: Vec3::X, sin: 1.0, cos: 0.0 };

        let mut normals = [[DVec3::ZERO; 2]; Cones::SIZE];
        let mut sum = DVec3::ZERO;
        for (pair, edge) in normals.iter_mut().zip(edges.clone()) {
            let [from, to] = edge.ends.map(&at);
            let [a, b] = edge.apexes;
            if b == Edge::NONE {
                return anything;
            }
            let both = normals_beside(from, to, [at(a), at(b)]);
            let least = least_height * from.distance(to);
            if both.iter().any(|normal| !(normal.length() > least && normal.is_finite())) {
                return anything;
            }
            let both = both.map(DVec3::normalize);
            // Triangles may be wound either way.
            let turned = sum.dot(both[0] + both[1]) < 0.0;
            *pair = if turned { both.map(|normal| -normal) } else { both };
            sum += pair[0] + pair[1];
        }
        let axis = sum.normalize_or_zero().as_vec3();
        let used = normals[..count].as_flattened();
        let cos = used.iter().map(|normal| normal.dot(axis.as_dvec3())).fold(1.0, f64::min);
        if cos <= 0.0 {
            return anything;
        }
        let ((sin_more, cos_more), sin) = (sin_cos(LEAST_ANGLE), (1.0 - cos * cos).max(0.0).sqrt());
        let (sin, cos) = (sin * cos_more + cos * sin_more, cos * cos_more - sin * sin_more);
        Self { axis, sin: sin as f32, cos: cos as f32, ..anything }
    }

    /// Does the viewer see the same side of all triangles, and none of them nearly edge-on?
    fn is_seen_from_one_side(&self, sight: Sight) -> bool {
        let (towards, radius) = match sight {
            Sight::From(eye) => (self.center.as_dvec3() - eye, f64::from(self.radius)),
            Sight::Along(direction) => (direction, 0.0),
        };
        // The tangents of the sphere through the eye are as long, and the sine of the angle between them and the line to the
        // middle is the radius over its length. With a and b the angles of this cone and of the normals, and c that between
        // their axes: |cos c| > sin(a + b), which is below a right angle, times that length.
        let tangent2 = towards.length_squared() - radius * radius;
        let (tangent, sin, cos) = (tangent2.max(0.0).sqrt(), f64::from(self.sin), f64::from(self.cos));
        let is_acute = tangent2 > 0.0 && cos * tangent > sin * radius;
        is_acute && self.axis.as_dvec3().dot(towards).abs() > sin * tangent + cos * radius
    }
}
