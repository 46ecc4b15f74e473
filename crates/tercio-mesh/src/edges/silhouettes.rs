//! Which edges are certainly not on the silhouette, found without projecting them: nearly all of them are not.
//!
//! Groups of edges that are near each other have the cone of the normals beside them (Shirmun and Abi-Ezzi, 1993): nearly all groups of a
//! smooth surface are seen from one side, and none of their edges is looked at. Of the others, nearly all are decided by the normals
//! of their triangles, which are stored in the order of the groups.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use glam::{DVec3, Vec3};

use super::{Edge, Edges, normals_beside};
use crate::OctNormal;
use crate::blocks::interleave;
use crate::loops::prelude::*;
use crate::radix::order_of;
use crate::trig::sin_cos;

/// A triangle counts as seen from the side if its apex is nearer to the plane through the viewer and the edge than this many times the
/// diagonal of the model.
const EDGE_ON: f64 = 1e-10;
/// The least angle, in radians, at which triangles are seen that a cone says are seen from one side.
const LEAST_ANGLE: f64 = 0.0011;
/// Normals beside edges are stored with an error of less than this angle, in radians.
const ROUNDING: f64 = 0.0001;
/// Triangles of groups with a cone, and of edges with normals, are higher over their edges than this many times the diagonal of the model.
const LEAST_HEIGHT: f64 = 1e-6;
// An apex is at least the height times the sine of the angle away from the plane. So what a cone leaves out is not `EDGE_ON`,
// even when rounded.
const _: () = assert!(LEAST_HEIGHT * LEAST_ANGLE > 10.0 * EDGE_ON);

/// Edges in a group; the last one may be smaller.
const GROUP: usize = 8;
/// Cells along each axis of the grid by which edges are grouped.
const CELLS: f32 = 1024.0;
/// So many pictures look at every edge: for less of them than that, cones do not pay.
const VIEWS_WITHOUT_CONES: u32 = 2;

/// From where, or in which direction, edges are seen, in the space of [`Edges::positions`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Viewer {
    /// The eye of a perspective camera.
    At(DVec3),
    /// The direction of sight of an orthographic camera. Neither its length nor its sign matters.
    Along(DVec3),
}

impl Edges {
    /// The numbers of the edges that may be on the silhouette, in order: all but those that lie, in the picture, certainly between their
    /// two triangles. For a viewer that is not finite, all of them.
    ///
    /// After two viewers the edges are grouped, which takes as long as three or four more, and 17 bytes an edge from then on.
    pub fn silhouettes(&self, viewer: Viewer) -> Vec<u32> {
        let edge_on = EDGE_ON * self.diagonal();
        let may_be_on = |&number: &u32| !self.is_between(&self.list[number as usize], viewer, edge_on);
        match self.cones.for_view(self) {
            None => (0..self.list.len() as u32).into_par_iter().filter(may_be_on).collect(),
            Some(cones) => {
                let found: Vec<u32> = cones.candidates(viewer, may_be_on);
                order_of(&found).into_iter().map(|place| found[place as usize]).collect()
            }
        }
    }

    /// Are the two triangles of an edge on both sides of the plane through the viewer and the edge, and their apexes farther from it than
    /// `edge_on`?
    fn is_between(&self, edge: &Edge, viewer: Viewer, edge_on: f64) -> bool {
        let [a, b] = edge.apexes;
        if b == Edge::NONE {
            return false;
        }
        let (eye, direction) = match viewer {
            Viewer::At(eye) => (eye, None),
            Viewer::Along(direction) => (DVec3::ZERO, Some(direction)),
        };
        let at = |v: u32| self.local(v) - eye;
        let from = at(edge.ends[0]);
        let plane = (at(edge.ends[1]) - from).cross(direction.unwrap_or(from));
        let [a, b] = [a, b].map(|v| plane.dot(at(v) - from));
        let limit2 = edge_on * edge_on * plane.length_squared();
        (a < 0.0) != (b < 0.0) && a * a > limit2 && b * b > limit2
    }

    /// Position of a vertex, in the space of [`Edges::positions`].
    fn local(&self, vertex: u32) -> DVec3 {
        DVec3::from(self.positions[vertex as usize].map(f64::from))
    }

    /// Length of the diagonal of the box of all vertices: no edge is longer.
    fn diagonal(&self) -> f64 {
        let [min, max] = self.bounds.map(|corner| corner.as_dvec3());
        (max - min).length()
    }
}

/// The cones of edges that are seen by several viewers.
#[derive(Clone, Debug, Default)]
pub struct LazyCones {
    views: SharedCount,
    cones: OnceLock<Cones>,
}

/// A count that is copied as it is then.
#[derive(Debug, Default)]
struct SharedCount(AtomicU32);

impl Clone for SharedCount {
    fn clone(&self) -> Self {
        Self(self.0.load(Relaxed).into())
    }
}

impl LazyCones {
    /// The cones, if it pays to have some.
    fn for_view(&self, edges: &Edges) -> Option<&Cones> {
        if self.cones.get().is_none() {
            if self.views.0.fetch_add(1, Relaxed) < VIEWS_WITHOUT_CONES {
                return None;
            }
            // Not in `get_or_init`: while this thread waits for others there, it may take up work that needs the cones, too.
            let _ = self.cones.set(Cones::new(edges));
        }
        self.cones.get()
    }
}

/// Groups of edges that are near each other, with their cones.
#[derive(Clone, Debug)]
struct Cones {
    /// The numbers of the edges, group by group.
    order: Vec<u32>,
    /// The normals beside each of them, as [`normals_beside`] has them; [`NO_NORMALS`] if it has only one triangle, or one that is not
    /// high enough.
    normals: Vec<[OctNormal; 2]>,
    list: Vec<Cone>,
}

const NO_NORMALS: [OctNormal; 2] = [OctNormal::NONE; 2];

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
    fn new(edges: &Edges) -> Self {
        let [min, max] = edges.bounds;
        let scale = CELLS / (max - min).max_element();
        let cell = |p: [f32; 3]| ((Vec3::from(p) - min) * scale).min(Vec3::splat(CELLS - 1.0)).as_uvec3();
        let key = |edge: &Edge| interleave(cell(edges.positions[edge.ends[0] as usize]).to_array());
        let keys: Vec<u32> = edges.list.par_iter().map(key).collect();
        let order = order_of(&keys);
        drop(keys);
        let (least_height, more) = (LEAST_HEIGHT * edges.diagonal(), sin_cos(LEAST_ANGLE));
        let cone = |numbers: &[u32]| Cone::new(edges, numbers, least_height, more);
        let list = order.par_chunks(GROUP).with_min_len(256).map(cone).collect();
        let encoded = |number: &u32| match normals(edges, &edges.list[*number as usize], least_height) {
            Some(both) => both.map(|normal| OctNormal::from_vector(normal.to_array())),
            None => NO_NORMALS,
        };
        let normals = order.par_iter().map(encoded).collect();
        Self { order, normals, list }
    }

    /// The numbers, in no order, for which `may_be_on` holds, of edges that are not in groups seen from one side; edges whose normals
    /// decide it are not asked for.
    fn candidates(&self, viewer: Viewer, may_be_on: impl Fn(&u32) -> bool + Sync) -> Vec<u32> {
        let edges = self.order.par_chunks(GROUP).zip(self.normals.par_chunks(GROUP));
        let (groups, may_be_on) = (edges.zip(&self.list).with_min_len(256), &may_be_on);
        let groups = groups.filter(|(_, cone)| !cone.is_seen_from_one_side(viewer));
        groups
            .flat_map_iter(|((numbers, normals), cone)| {
                let sight = cone.sight(viewer);
                let is_on = move |number: &u32, both: [OctNormal; 2]| match sight.sides(both) {
                    Some([a, b]) => a != b,
                    None => may_be_on(number),
                };
                let found = numbers.iter().zip(normals).filter(move |(number, both)| is_on(number, **both));
                found.map(|(number, _)| *number)
            })
            .collect()
    }
}

/// The normals beside an edge, normalized, unless it has only one triangle, or one that is not higher over it than this.
fn normals(edges: &Edges, edge: &Edge, least_height: f64) -> Option<[DVec3; 2]> {
    if edge.apexes[1] == Edge::NONE {
        return None;
    }
    let [from, to] = edge.ends.map(|v| edges.local(v));
    let both = normals_beside(from, to, edge.apexes.map(|v| edges.local(v)));
    let least = least_height * from.distance(to);
    let is_high = |normal: &DVec3| normal.length() > least && normal.is_finite();
    both.iter().all(is_high).then(|| both.map(DVec3::normalize))
}

/// How a viewer sees the first ends of the edges of a group.
struct Sight {
    /// From the viewer to the middle of them.
    towards: DVec3,
    /// How far from a plane through the middle the viewer is at least, if its distance from a parallel one through the first end of each
    /// edge is more than [`LEAST_ANGLE`] and [`ROUNDING`] allow.
    least: f64,
}

impl Sight {
    /// On which side of both triangles of an edge the viewer is, if it is certainly not nearly in the plane of one of them.
    fn sides(&self, normals: [OctNormal; 2]) -> Option<[bool; 2]> {
        // Not longer than 1, but possibly shorter.
        let distances = normals.map(|normal| Vec3::from(normal.decode()).as_dvec3().dot(self.towards));
        let is_certain =
            normals != NO_NORMALS && distances.iter().all(|distance| distance.abs() > self.least);
        is_certain.then(|| distances.map(|distance| distance < 0.0))
    }
}

impl Cone {
    /// `more` are sine and cosine of [`LEAST_ANGLE`].
    fn new(edges: &Edges, numbers: &[u32], least_height: f64, more: (f64, f64)) -> Self {
        let group = || numbers.iter().map(|&number| &edges.list[number as usize]);
        let first_ends = || group().map(|edge| edges.local(edge.ends[0]));
        let (min, max) = first_ends()
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(min, max), p| (min.min(p), max.max(p)));
        let center = ((min + max) * 0.5).as_vec3();
        let radius = first_ends().map(|p| p.distance(center.as_dvec3())).fold(0.0, f64::max);
        let anything = Self { center, radius: radius as f32, axis: Vec3::X, sin: 1.0, cos: 0.0 };

        let mut all = [[DVec3::ZERO; 2]; GROUP];
        let mut sum = DVec3::ZERO;
        for (pair, edge) in all.iter_mut().zip(group()) {
            let Some(both) = normals(edges, edge, least_height) else { return anything };
            // Triangles may be wound either way.
            let is_turned = sum.dot(both[0] + both[1]) < 0.0;
            *pair = if is_turned { both.map(|normal| -normal) } else { both };
            sum += pair[0] + pair[1];
        }
        let axis = sum.normalize_or_zero().as_vec3();
        let used = all[..numbers.len()].as_flattened();
        let cos = used.iter().map(|normal| normal.dot(axis.as_dvec3())).fold(1.0, f64::min);
        if cos <= 0.0 {
            return anything;
        }
        let ((sin_more, cos_more), sin) = (more, (1.0 - cos * cos).max(0.0).sqrt());
        let (sin, cos) = (sin * cos_more + cos * sin_more, cos * cos_more - sin * sin_more);
        Self { axis, sin: sin as f32, cos: cos as f32, ..anything }
    }

    /// From the viewer to the middle, and the radius around it that matters.
    fn towards(&self, viewer: Viewer) -> (DVec3, f64) {
        match viewer {
            Viewer::At(eye) => (self.center.as_dvec3() - eye, f64::from(self.radius)),
            Viewer::Along(direction) => (direction, 0.0),
        }
    }

    fn sight(&self, viewer: Viewer) -> Sight {
        let (towards, radius) = self.towards(viewer);
        Sight { towards, least: radius + (LEAST_ANGLE + ROUNDING) * (towards.length() + radius) }
    }

    /// Does the viewer see the same side of all triangles, and none of them nearly edge-on?
    fn is_seen_from_one_side(&self, viewer: Viewer) -> bool {
        let (towards, radius) = self.towards(viewer);
        // With a half the opening of the cone, b half the angle at which the eye sees the sphere (sin b = radius / |towards|, cos b =
        // tangent / |towards|), and c the angle between `towards` and the axis: all normals are on one side of all lines of sight
        // if a + b is less than a right angle and |cos c| > sin(a + b). Both sides of both conditions are multiplied by |towards|.
        let tangent2 = towards.length_squared() - radius * radius;
        let (tangent, sin, cos) = (tangent2.max(0.0).sqrt(), f64::from(self.sin), f64::from(self.cos));
        let is_acute = tangent2 > 0.0 && cos * tangent > sin * radius;
        is_acute && self.axis.as_dvec3().dot(towards).abs() > sin * tangent + cos * radius
    }
}

#[cfg(test)]
mod tests;
