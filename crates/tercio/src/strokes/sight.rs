//! Which edges are certainly not on the silhouette, found without projecting them: nearly all of them are not.

use glam::{DAffine3, DVec3, Vec3};
use tercio_mesh::edges::{Edge, Edges};
use tercio_mesh::loops::prelude::*;

use super::eye::Eye;

/// A triangle counts as seen from the side if its apex is nearer to the plane through the viewer and the edge than the diagonal of the
/// model times the root of this.
const EDGE_ON2: f64 = 1e-18;

/// Vertices of edges as the viewer sees them, in the units of their positions.
pub struct Sight {
    /// Relative to the eye of a perspective camera.
    positions: Vec<DVec3>,
    /// The direction of sight of an orthographic camera.
    direction: Option<DVec3>,
    /// Square of the diagonal of the model: no edge is longer.
    diagonal2: f64,
}

impl Sight {
    /// The view of edges at a place in the world.
    pub fn new(eye: &Eye, edges: &Edges, world_from_object: &DAffine3) -> Self {
        let object_from_world = world_from_object.inverse();
        let (mut from, mut direction) = (DVec3::ZERO, None);
        if eye.is_perspective() {
            from = (object_from_world.transform_point3(eye.position()) - edges.origin) / edges.unit();
        } else {
            direction = Some(object_from_world.transform_vector3(eye.world_axes(DVec3::Z)));
        }
        let (mut min, mut max) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for &p in &edges.positions {
            (min, max) = (min.min(p.into()), max.max(p.into()));
        }
        let diagonal2 = (max.as_dvec3() - min.as_dvec3()).length_squared();
        let relative = |p: &[f32; 3]| DVec3::from(p.map(f64::from)) - from;
        Self { positions: edges.positions.par_iter().map(relative).collect(), direction, diagonal2 }
    }

    /// Are the two triangles of an edge on both sides of the plane through the viewer and the edge, so that it lies between them on
    /// the picture? Not where that is uncertain.
    pub fn is_between(&self, edge: &Edge) -> bool {
        let [a, b] = edge.apexes;
        if b == Edge::NONE {
            return false;
        }
        let at = |v: u32| self.positions[v as usize];
        let from = at(edge.ends[0]);
        let plane = (at(edge.ends[1]) - from).cross(self.direction.unwrap_or(from));
        let [a, b] = [a, b].map(|v| plane.dot(at(v) - from));
        let limit2 = EDGE_ON2 * plane.length_squared() * self.diagonal2;
        (a < 0.0) != (b < 0.0) && a * a > limit2 && b * b > limit2
    }
}
