//! Attributes that are made of a mesh when it is read: they need to know which triangles are neighbours.

use glam::DVec3;
use tercio_mesh::{Attribute, AttributeDomain, Mesh};

/// An attribute that is made when a model is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Made {
    /// `@curvature`: the mean curvature at each vertex, in reciprocal lengths of the model; above 0 where the surface bends like the
    /// outside of a sphere. NaN at the border of a surface. The discrete operator of Meyer, Desbrun, Schröder and Barr,
    /// "Discrete differential-geometry operators for triangulated 2-manifolds" (2003), with a third of the triangles' areas.
    Curvature,
    /// `@component`: the number of the connected part that a triangle belongs to, in the order of their first triangles.
    Component,
}

impl Made {
    /// The one that a name asks for.
    pub fn of_name(name: &str) -> Option<Self> {
        [Self::Curvature, Self::Component].into_iter().find(|made| made.name() == name)
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Curvature => "@curvature",
            Self::Component => "@component",
        }
    }

    /// Bytes that are taken while it is made.
    pub(crate) fn needed_bytes(self, mesh: &Mesh) -> u64 {
        let (vertices, triangles) = (mesh.positions.len() as u64, mesh.triangles.len() as u64);
        match self {
            // Places in order, their vectors, areas and open edges.
            Self::Curvature => 60 * vertices + 36 * triangles,
            Self::Component => 16 * vertices + 4 * triangles,
        }
    }

    /// Adds it to a mesh.
    pub(crate) fn add_to(self, mesh: &mut Mesh) {
        let (domain, values) = match self {
            Self::Curvature => (AttributeDomain::Vertex, curvature(mesh)),
            Self::Component => (AttributeDomain::Triangle, components(mesh)),
        };
        mesh.attributes.push(Attribute {
            name: self.name().into(),
            domain,
            values,
            offset: 0.0,
            component: None,
        });
    }
}

/// For each vertex, the first of those at the same position: surfaces are connected there, whatever other data their vertices have.
fn joined(mesh: &Mesh) -> Vec<u32> {
    let key = |v: u32| mesh.positions[v as usize].map(|c| (c + 0.0).to_bits());
    let mut order: Vec<u32> = (0..mesh.positions.len() as u32).collect();
    order.sort_unstable_by_key(|&v| (key(v), v));
    let mut joined = vec![0; order.len()];
    let mut first = 0;
    for (i, &v) in order.iter().enumerate() {
        if i == 0 || key(order[i - 1]) != key(v) {
            first = v;
        }
        joined[v as usize] = first;
    }
    joined
}

fn components(mesh: &Mesh) -> Vec<f32> {
    // Every vertex is, or leads to, the representative of its part.
    let mut parent = joined(mesh);
    fn find(parent: &mut [u32], mut v: u32) -> u32 {
        while parent[v as usize] != v {
            parent[v as usize] = parent[parent[v as usize] as usize];
            v = parent[v as usize];
        }
        v
    }
    for &[a, b, c] in &mesh.triangles {
        for (a, b) in [(a, b), (b, c)] {
            let (a, b) = (find(&mut parent, a), find(&mut parent, b));
            // The lower number stays, so that parts do not depend on anything else.
            parent[a.max(b) as usize] = a.min(b);
        }
    }
    const NONE: u32 = u32::MAX;
    let (mut numbers, mut next) = (vec![NONE; parent.len()], 0);
    let number = |t: &[u32; 3]| {
        let number = &mut numbers[find(&mut parent, t[0]) as usize];
        if *number == NONE {
            (*number, next) = (next, next + 1);
        }
        *number as f32
    };
    mesh.triangles.iter().map(number).collect()
}

fn curvature(mesh: &Mesh) -> Vec<f32> {
    let joined = joined(mesh);
    let point = |v: u32| DVec3::from(mesh.positions[v as usize].map(f64::from));
    let count = joined.len();
    // Of each place: the sum of cotangents times edges, that of the normals times areas, and that of the areas.
    let (mut bends, mut normals, mut areas) =
        (vec![DVec3::ZERO; count], vec![DVec3::ZERO; count], vec![0.0; count]);
    let mut edges: Vec<u64> = Vec::with_capacity(3 * mesh.triangles.len());
    for triangle in &mesh.triangles {
        let t = triangle.map(|v| joined[v as usize]);
        let p = t.map(point);
        let normal = (p[1] - p[0]).cross(p[2] - p[0]);
        let double_area = normal.length();
        if !(double_area > 0.0) {
            continue;
        }
        for k in 0..3 {
            let (a, b, opposite) = (k, (k + 1) % 3, p[(k + 2) % 3]);
            let cotangent = (p[a] - opposite).dot(p[b] - opposite) / double_area;
            let edge = (p[a] - p[b]) * cotangent;
            bends[t[a] as usize] += edge;
            bends[t[b] as usize] -= edge;
            normals[t[k] as usize] += normal;
            areas[t[k] as usize] += double_area / 6.0;
            edges.push(u64::from(t[a].min(t[b])) << 32 | u64::from(t[a].max(t[b])));
        }
    }
    edges.sort_unstable();
    let mut is_open = vec![false; count];
    for edge in edges.chunk_by(|a, b| a == b).filter(|edge| edge.len() == 1) {
        is_open[(edge[0] >> 32) as usize] = true;
        is_open[(edge[0] & 0xffff_ffff) as usize] = true;
    }
    let of_place = |place: usize| {
        if is_open[place] || !(areas[place] > 0.0) {
            return f32::NAN;
        }
        // The sum is 4 H n times the area.
        let size = bends[place].length() / (4.0 * areas[place]) / mesh.unit();
        (if bends[place].dot(normals[place]) < 0.0 { -size } else { size }) as f32
    };
    joined.iter().map(|&place| of_place(place as usize)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use tercio_mesh::builtin;

    #[test]
    fn a_sphere_is_bent_by_its_radius_and_turned_around_the_other_way() {
        let mut mesh = builtin::make("builtin:sphere@20k").expect("a model");
        let radius = mesh.bounds().size().x / 2.0;
        for sign in [1.0, -1.0] {
            let values = curvature(&mesh);
            let mut off: Vec<f64> =
                values.iter().map(|&h| (f64::from(h) * radius * sign - 1.0).abs()).collect();
            off.sort_by(f64::total_cmp);
            // Where six triangles do not meet, the operator is less exact.
            assert!(
                off[off.len() / 2] < 0.02 && off[off.len() * 99 / 100] < 0.1,
                "{} {}",
                off[off.len() / 2],
                off[off.len() * 99 / 100]
            );
            mesh.triangles.iter_mut().for_each(|t| t.swap(0, 1));
        }
    }

    #[test]
    fn the_border_of_a_surface_has_no_curvature_and_a_plane_none_within() {
        let side = 9u32;
        let positions = (0..side * side).map(|i| [(i % side) as f32, (i / side) as f32, 3.0]).collect();
        let quads = (0..(side - 1) * (side - 1)).map(|q| q / (side - 1) * side + q % (side - 1));
        let triangles = quads.flat_map(|v| [[v, v + 1, v + side], [v + 1, v + side + 1, v + side]]).collect();
        let mesh = Mesh { positions, triangles, ..Mesh::default() };
        for (v, h) in curvature(&mesh).iter().enumerate() {
            let (x, y) = (v as u32 % side, v as u32 / side);
            let is_border = x == 0 || y == 0 || x == side - 1 || y == side - 1;
            assert_eq!(h.is_nan(), is_border, "{v}");
            assert!(is_border || h.abs() < 1e-6, "{v}: {h}");
        }
    }

    #[test]
    fn parts_are_numbered_by_their_first_triangles() {
        // Two triangles that share a place, not a vertex; one by itself between them.
        let positions = [
            [0., 0., 0.],
            [1., 0., 0.],
            [0., 1., 0.],
            [5., 5., 5.],
            [6., 5., 5.],
            [5., 6., 5.],
            [0., 0., 0.],
            [-1., 0., 0.],
            [0., -1., 0.],
        ];
        let triangles = vec![[3, 4, 5], [0, 1, 2], [6, 7, 8], [5, 4, 3]];
        let mesh = Mesh { positions: positions.to_vec(), triangles, ..Mesh::default() };
        assert_eq!(components(&mesh), [0.0, 1.0, 1.0, 0.0]);
    }
}
