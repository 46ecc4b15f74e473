//! Which edges are certainly not on the silhouette, found without projecting them: nearly all of them are not.

use glam::{DAffine3, DVec3};
use tercio_mesh::edges::{Edge, Edges};
use tercio_mesh::loops::prelude::*;

use super::eye::Eye;

/// Sine of the angle at which a triangle counts as seen from the side.
const EDGE_ON: f64 = 1e-9;

/// Vertices of edges as the viewer sees them, in the units of their positions.
pub struct Sight {
    /// Relative to the eye of a perspective camera.
    positions: Vec<DVec3>,
    /// The direction of sight of an orthographic camera.
    direction: Option<DVec3>,
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
        let relative = |p: &[f32; 3]| DVec3::from(p.map(f64::from)) - from;
        Self { positions: edges.positions.par_iter().map(relative).collect(), direction }
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
        let side = |v: u32| {
            let to = at(v) - from;
            let beside = plane.dot(to);
            if beside.abs() <= EDGE_ON * plane.length() * to.length() { 0.0 } else { beside.signum() }
        };
        side(a) * side(b) < 0.0
    }
}
