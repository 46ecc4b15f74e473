//! Triangles that face the camera, on the way to instances of the scene.

use glam::{DVec2, DVec3};
use rayon::prelude::*;
use tercio_mesh::cluster::{Order, PartitionOptions, partition};
use tercio_mesh::{Mesh, OctNormal};
use tercio_scene::{Instance, Surface};

use super::eye::Eye;

/// Strokes that become one instance: it bounds the memory of what is not yet split into clusters.
const CHUNK: usize = 1 << 15;

/// Triangles with colours.
pub struct Sheet<'a> {
    eye: &'a Eye,
    positions: Vec<[f32; 3]>,
    normals: Vec<OctNormal>,
    triangles: Vec<[u32; 3]>,
    colors: Vec<[u8; 4]>,
}

impl<'a> Sheet<'a> {
    fn new(eye: &'a Eye) -> Self {
        let (positions, normals, triangles, colors) = Default::default();
        Self { eye, positions, normals, triangles, colors }
    }

    /// The camera.
    pub fn eye(&self) -> &'a Eye {
        self.eye
    }

    /// Adds a vertex at a place of the screen and a nearness; returns its number.
    pub fn vertex(&mut self, screen: DVec2, nearness: f64, color: [u8; 4]) -> u32 {
        self.vertex_at(self.eye.place(screen, self.eye.distance(nearness)), color)
    }

    /// Adds a vertex with a normal, in world axes relative to the origin of the eye.
    pub fn vertex_with_normal(&mut self, p: DVec3, normal: DVec3, color: [u8; 4]) -> u32 {
        self.normals.push(OctNormal::from_vector(normal.to_array()));
        self.vertex_at(p, color)
    }

    fn vertex_at(&mut self, p: DVec3, color: [u8; 4]) -> u32 {
        self.positions.push(p.as_vec3().to_array());
        self.colors.push(color);
        self.positions.len() as u32 - 1
    }

    /// Adds a triangle whose corners appear clockwise on the screen, where y points downwards.
    pub fn triangle(&mut self, corners: [u32; 3]) {
        let [a, b, c] = corners;
        self.triangles.push([a, c, b]);
    }

    /// Adds a triangle whose corners appear counter-clockwise from outside.
    pub fn outward(&mut self, corners: [u32; 3]) {
        self.triangles.push(corners);
    }

    /// The mesh, unless it is empty.
    fn instance(self, surface: &Surface) -> Option<Instance> {
        if self.triangles.is_empty() {
            return None;
        }
        let largest = self.positions.as_flattened().iter().fold(0.0f32, |m, c| m.max(c.abs()));
        if !largest.is_finite() {
            return None;
        }
        let mut mesh = Mesh {
            origin: self.eye.origin(),
            positions: self.positions,
            triangles: self.triangles,
            vertex_colors: Some(self.colors),
            normals: (!self.normals.is_empty()).then_some(self.normals),
            ..Mesh::default()
        };
        mesh.bring_into_range(largest);
        let options = PartitionOptions { order: Order::Auto, ..PartitionOptions::default() };
        Some(Instance { surface: *surface, ..Instance::new(partition(mesh, &options)) })
    }
}

/// Draws strokes onto sheets, in parallel; the sheets, in order, as instances.
pub fn draw<T: Sync>(
    eye: &Eye,
    surface: &Surface,
    strokes: &[T],
    draw: impl Fn(&mut Sheet, &T) + Sync,
) -> Vec<Instance> {
    let chunk = |strokes: &[T]| {
        let mut sheet = Sheet::new(eye);
        strokes.iter().for_each(|stroke| draw(&mut sheet, stroke));
        sheet.instance(surface)
    };
    strokes.par_chunks(CHUNK).filter_map(chunk).collect()
}
