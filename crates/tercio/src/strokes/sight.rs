//! Which edges are certainly not on the silhouette, found without projecting them: nearly all of them are not.

use glam::{DAffine3, DVec3};
use tercio_mesh::edges::{self, Edge, Edges};

use super::eye::Eye;

/// A triangle counts as seen from the side if its apex is nearer to the plane through the viewer and the edge than the diagonal of the
/// model times the root of this.
const EDGE_ON2: f64 = 1e-18;

/// The view of edges.
pub struct Sight<'a> {
    edges: &'a Edges,
    viewer: edges::Sight,
    /// Square of the diagonal of the model: no edge is longer.
    diagonal2: f64,
}

impl<'a> Sight<'a> {
    /// The view of edges at a place in the world.
    pub fn new(eye: &Eye, edges: &'a Edges, world_from_object: &DAffine3) -> Self {
        let object_from_world = world_from_object.inverse();
        let viewer = if eye.is_perspective() {
            let eye = object_from_world.transform_point3(eye.position());
            edges::Sight::From((eye - edges.origin) / edges.unit())
        } else {
            edges::Sight::Along(object_from_world.transform_vector3(eye.world_axes(DVec3::Z)))
        };
        let [min, max] = edges.cones().bounds.map(|corner| corner.as_dvec3());
        Self { edges, viewer, diagonal2: (max - min).length_squared() }
    }

    /// The numbers of the edges that may be on the silhouette: those that are not [`Sight::is_between`].
    pub fn silhouettes(&self) -> Vec<u32> {
        let may_be_on = |n: u32| !self.is_between(&self.edges.list[n as usize]);
        self.edges.cones().silhouettes(self.viewer, may_be_on)
    }

    /// Are the two triangles of an edge on both sides of the plane through the viewer and the edge, so that it lies between them on
    /// the picture? Not where that is uncertain.
    fn is_between(&self, edge: &Edge) -> bool {
        let [a, b] = edge.apexes;
        if b == Edge::NONE {
            return false;
        }
        let (eye, direction) = match self.viewer {
            edges::Sight::From(eye) => (eye, None),
            edges::Sight::Along(direction) => (DVec3::ZERO, Some(direction)),
        };
        let at = |v: u32| DVec3::from(self.edges.positions[v as usize].map(f64::from)) - eye;
        let from = at(edge.ends[0]);
        let plane = (at(edge.ends[1]) - from).cross(direction.unwrap_or(from));
        let [a, b] = [a, b].map(|v| plane.dot(at(v) - from));
        let limit2 = EDGE_ON2 * plane.length_squared() * self.diagonal2;
        (a < 0.0) != (b < 0.0) && a * a > limit2 && b * b > limit2
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use tercio_mesh::edges::Selection;
    use tercio_mesh::{Mesh, builtin};
    use tercio_scene::{Camera, Projection};

    use super::*;
    use crate::raster::view::View;

    fn edges(name: &str) -> Edges {
        Edges::of_mesh(&builtin::make(name).expect("a model"), Selection::All)
    }

    /// The same with every third triangle wound the other way round, and some without area.
    fn broken(name: &str) -> Edges {
        let mut mesh: Mesh = builtin::make(name).expect("a model");
        for (n, triangle) in mesh.triangles.iter_mut().enumerate() {
            match n % 3 {
                0 => triangle.swap(0, 1),
                1 if n % 7 == 0 => triangle[2] = triangle[1],
                _ => {}
            }
        }
        Edges::of_mesh(&mesh, Selection::All)
    }

    #[test]
    fn cones_leave_out_no_silhouette() {
        let mut looked_at = Vec::new();
        for (name, edges) in [
            ("teapot", edges("builtin:teapot@20k")),
            ("gyroid", edges("builtin:gyroid@20k")),
            ("terrain", edges("builtin:terrain@20k")),
            ("teapot", broken("builtin:teapot@20k")),
            ("gyroid", broken("builtin:gyroid@20k")),
        ] {
            let [min, max] = edges.cones().bounds.map(|p| edges.origin + p.as_dvec3() * edges.unit());
            let (middle, size) = ((min + max) * 0.5, (max - min).length());
            let place = DAffine3::from_scale_rotation_translation(
                DVec3::new(2.0, -3.0, 0.5),
                glam::DQuat::from_rotation_z(0.7),
                DVec3::new(5.0, 1.0, -2.0),
            );
            let bounds = tercio_mesh::Aabb { min, max };
            for (number, from) in [
                DVec3::new(0.3, -2.0, 0.8),
                DVec3::new(-0.9, 0.1, 0.4),
                DVec3::new(0.0, 0.0, 2.0),
                DVec3::new(0.1, 0.05, -0.1),
                DVec3::new(0.0, 1e5, 3e4),
            ]
            .into_iter()
            .enumerate()
            {
                let projection = match number % 2 {
                    0 => Projection::Perspective { fov_y: 0.7 },
                    _ => Projection::Orthographic { height: size },
                };
                let (eye, up) = (middle + from * size, DVec3::new(0.1, 1.0, 0.2));
                let camera = Camera { eye, target: middle, up, projection, near: None, shift: [0.0; 2] };
                let view = View::new(&camera, &bounds, 320, 240).expect("a camera");
                for place in [DAffine3::IDENTITY, place] {
                    let sight = Sight::new(&Eye::new(view.clone()), &edges, &place);
                    let all = 0..edges.list.len() as u32;
                    let expected: Vec<u32> =
                        all.filter(|&n| !sight.is_between(&edges.list[n as usize])).collect();
                    assert_eq!(sight.silhouettes(), expected, "{name}, view {number}, {place:?}");
                    let candidates = edges.cones().silhouettes(sight.viewer, |_| true).len();
                    looked_at.push(candidates as f64 / edges.list.len() as f64);
                }
            }
        }
        let least = looked_at.iter().copied().fold(1.0, f64::min);
        assert!(least < 0.3, "of a smooth surface, most edges are left out: {looked_at:?}");
    }
}
