//! Which edges are certainly not on the silhouette, found without projecting them: nearly all of them are not.
//!
//! Groups of edges that are near each other have the cone of the normals beside them (Shirmun and Abi-Ezzi, 1993): nearly all groups of a
//! smooth surface are seen from one side, and none of their edges is looked at. Of the others, nearly all are decided by the normals
//! of their triangles, which are stored in the order of the groups.

mod cones;

use std::sync::OnceLock;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use fearless_simd::{Level, dispatch};
use glam::{DVec3, Vec3};

use self::cones::{Block, Candidates, Cone, GROUP, LANES, Sight};
use super::{Edge, EdgeCorners, EdgeKind, Edges, normals_beside};
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
        self.find_silhouettes(viewer, false)
    }

    /// Of the [silhouettes](Edges::silhouettes) those that a mesh does not hide itself, if the viewer is outside of it: where it
    /// [is outward](Edges::is_outward), those of convex edges, and all where it is not. At a concave edge the viewer, who is behind
    /// one of the triangles and in front of the other one, looks through the mesh.
    pub fn outlines(&self, viewer: Viewer) -> Vec<u32> {
        self.find_silhouettes(viewer, self.is_outward)
    }

    fn find_silhouettes(&self, viewer: Viewer, only_convex: bool) -> Vec<u32> {
        let cones = self.cones.for_view(self);
        let (mut found, looked_at) = match cones {
            None => (Vec::new(), (0..self.list.len() as u32).collect()),
            Some(cones) => cones.candidates(viewer, only_convex),
        };
        let edge_on = EDGE_ON * self.diagonal();
        let on: Vec<u32> = looked_at
            .par_chunks(1 << 10)
            .flat_map_iter(|numbers| {
                let mut on = Vec::new();
                self.for_each_corners(numbers, |number, corners| {
                    // Cones have left out concave edges already.
                    let is_hidden = only_convex && cones.is_none() && is_concave(corners, edge_on);
                    if !is_hidden && !is_between(corners, viewer, edge_on) {
                        on.push(number);
                    }
                });
                on
            })
            .collect();
        if cones.is_none() {
            return on;
        }
        found.extend(on);
        order_of(&found).into_iter().map(|place| found[place as usize]).collect()
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

/// Are the two triangles of an edge on both sides of the plane through the viewer and the edge, and their apexes farther from it than
/// `edge_on`?
fn is_between(corners: &EdgeCorners, viewer: Viewer, edge_on: f64) -> bool {
    let [Some(a), Some(b)] = corners.apexes else { return false };
    let (eye, direction) = match viewer {
        Viewer::At(eye) => (eye, None),
        Viewer::Along(direction) => (DVec3::ZERO, Some(direction)),
    };
    let at = |p: [f32; 3]| DVec3::from(p.map(f64::from)) - eye;
    let from = at(corners.ends[0]);
    let plane = (at(corners.ends[1]) - from).cross(direction.unwrap_or(from));
    let [a, b] = [a, b].map(|p| plane.dot(at(p) - from));
    let limit2 = edge_on * edge_on * plane.length_squared();
    (a < 0.0) != (b < 0.0) && a * a > limit2 && b * b > limit2
}

/// Is the second triangle in front of the first one, its apex farther than `edge_on` from its plane?
fn is_concave(corners: &EdgeCorners, edge_on: f64) -> bool {
    let (EdgeKind::Inner, [Some(a), Some(b)]) = (corners.kind, corners.apexes) else { return false };
    let [from, to, a, b] = [corners.ends[0], corners.ends[1], a, b].map(|p| DVec3::from(p.map(f64::from)));
    let normal = (to - from).cross(a - from);
    normal.dot(b - from) > edge_on * normal.length()
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
    /// The numbers of the edges, group by group; of a mesh that is outward, concave ones come last.
    order: Vec<u32>,
    /// How many others there are.
    convex: usize,
    /// The normals beside each of them, as [`normals_beside`] has them; [`NO_NORMALS`] if it has only one triangle, or one that is not
    /// high enough.
    normals: Vec<[OctNormal; 2]>,
    blocks: Vec<Block>,
}

/// Bit of the keys of concave edges, above all of a cell.
const CONCAVE: u32 = 1 << 30;

const NO_NORMALS: [OctNormal; 2] = [OctNormal::NONE; 2];

/// Blocks that one thread looks through at once, at least.
const BLOCKS: usize = 64;

impl Cones {
    fn new(edges: &Edges) -> Self {
        let [min, max] = edges.bounds;
        let scale = CELLS / (max - min).max_element();
        let cell = |p: [f32; 3]| ((Vec3::from(p) - min) * scale).min(Vec3::splat(CELLS - 1.0)).as_uvec3();
        let numbers: Vec<u32> = (0..edges.list.len() as u32).collect();
        let edge_on = EDGE_ON * edges.diagonal();
        let keys: Vec<u32> = numbers
            .par_chunks(1 << 10)
            .flat_map_iter(|numbers| {
                let mut keys = Vec::with_capacity(numbers.len());
                edges.for_each_corners(numbers, |_, corners| {
                    let last = if edges.is_outward && is_concave(corners, edge_on) { CONCAVE } else { 0 };
                    keys.push(interleave(cell(corners.ends[0]).to_array()) | last);
                });
                keys
            })
            .collect();
        drop(numbers);
        let order = order_of(&keys);
        let convex = keys.iter().filter(|&&key| key < CONCAVE).count();
        drop(keys);
        let (least_height, more) = (LEAST_HEIGHT * edges.diagonal(), sin_cos(LEAST_ANGLE));
        let cone = |numbers: &[u32]| Cone::new(edges, numbers, least_height, more);
        let block = |numbers: &[u32]| Block::new(numbers.chunks(GROUP).map(cone));
        let blocks = order.par_chunks(GROUP * LANES).with_min_len(16).map(block).collect();
        let encoded = |number: &u32| match normals(edges, &edges.list[*number as usize], least_height) {
            Some(both) => both.map(|normal| OctNormal::from_vector(normal.to_array())),
            None => NO_NORMALS,
        };
        let normals = order.par_iter().map(encoded).collect();
        Self { order, convex, normals, blocks }
    }

    /// The numbers, in no order, of edges that are on the silhouette, and of those that may be on it.
    fn candidates(&self, viewer: Viewer, only_convex: bool) -> (Vec<u32>, Vec<u32>) {
        const EDGES: usize = GROUP * LANES * BLOCKS;
        let (sight, level) = (Sight::new(viewer), Level::new());
        let all = ..if only_convex { self.convex } else { self.order.len() };
        let edges = self.order[all].par_chunks(EDGES).zip(self.normals[all].par_chunks(EDGES));
        let found: Vec<Candidates> = self
            .blocks
            .par_chunks(BLOCKS)
            .zip(edges)
            .map(|(blocks, (numbers, normals))| {
                let mut found = Candidates::default();
                dispatch!(level, _ => found.look_through(&sight, blocks, numbers, normals));
                found
            })
            .collect();
        let of = |part: fn(&Candidates) -> &[u32]| found.iter().flat_map(part).copied().collect();
        (of(|found| &found.on), of(|found| &found.unknown))
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

#[cfg(test)]
mod tests;
