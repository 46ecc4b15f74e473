//! Triangles that face the camera, on the way to instances of the scene.

use std::sync::Arc;

use glam::{DVec2, DVec3, Vec3};
use tercio_mesh::blocks::interleave;
use tercio_mesh::cluster::{Piece, partition_pieces};
use tercio_mesh::color::srgb_to_linear;
use tercio_mesh::loops::prelude::*;
use tercio_mesh::radix::order_of;
use tercio_mesh::{Attribute, AttributeDomain, Mesh, OctNormal};
use tercio_scene::{DataColors, DataSource, Instance, Surface, SurfaceData};

use super::eye::Eye;

/// Strokes that become one instance, by one thread: it bounds the memory of what is not yet split into clusters.
const CHUNK: usize = 1 << 13;
/// Cells along each axis of the grid by which strokes are sorted.
const CELLS: f32 = 1024.0;

/// The colour of a vertex: itself, or a value that becomes a colour when it is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ink {
    /// sRGB and linear alpha.
    pub color: [u8; 4],
    pub value: f32,
}

impl Ink {
    /// Between two, in the way of a line.
    fn lerp(self, other: Self, share: f64) -> Self {
        // Values may be infinite, or so large that the others are rounded away.
        if share <= 0.0 || share >= 1.0 {
            return if share <= 0.0 { self } else { other };
        }
        let mix = |a: f64, b: f64| a + (b - a) * share;
        let byte = |k: usize| mix(self.color[k].into(), other.color[k].into()).round() as u8;
        let value = mix(self.value.into(), other.value.into()) as f32;
        Self { color: std::array::from_fn(byte), value }
    }
}

impl From<[u8; 4]> for Ink {
    fn from(color: [u8; 4]) -> Self {
        Self { color, value: f32::NAN }
    }
}

/// How the triangles of strokes look.
#[derive(Clone, Debug)]
pub struct Look {
    pub surface: Surface,
    /// What the values of vertices mean, in place of their colours.
    pub colors: Option<Arc<DataColors>>,
}

/// Triangles with colours.
pub struct Sheet<'a> {
    eye: &'a Eye,
    /// Values are categories: there is nothing between two of them.
    is_of_categories: bool,
    positions: Vec<[f32; 3]>,
    normals: Vec<OctNormal>,
    triangles: Vec<[u32; 3]>,
    inks: Vec<Ink>,
    /// For each stroke its first vertex and its first triangle.
    starts: Vec<[u32; 2]>,
}

impl<'a> Sheet<'a> {
    fn new(eye: &'a Eye, look: &Look) -> Self {
        let (positions, normals, triangles, inks, starts) = Default::default();
        let is_of_categories = look.colors.as_ref().is_some_and(|colors| !colors.categories.is_empty());
        Self { eye, is_of_categories, positions, normals, triangles, inks, starts }
    }

    /// Begins a stroke: what is added then belongs to it.
    pub fn begin(&mut self) {
        self.starts.push([self.positions.len() as u32, self.triangles.len() as u32]);
    }

    /// The strokes in an order in which neighbours are near each other.
    fn pieces(&self) -> Vec<Piece> {
        let first = |start: &[u32; 2]| self.positions.get(start[0] as usize).map(|&p| Vec3::from(p));
        let (mut min, mut max) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for p in self.starts.iter().filter_map(first) {
            (min, max) = (min.min(p), max.max(p));
        }
        let scale = CELLS / (max - min).max_element();
        let cell = |p: Vec3| ((p - min) * scale).min(Vec3::splat(CELLS - 1.0)).as_uvec3().to_array();
        let keys: Vec<u32> =
            self.starts.iter().map(|start| first(start).map_or(0, |p| interleave(cell(p)))).collect();
        let end = [self.positions.len() as u32, self.triangles.len() as u32];
        let piece = |place: u32| {
            let [vertex, triangle] = self.starts[place as usize];
            let [vertices, triangles] = *self.starts.get(place as usize + 1).unwrap_or(&end);
            Piece { vertices: vertex..vertices, triangles: triangle..triangles }
        };
        order_of(&keys).into_iter().map(piece).collect()
    }

    /// The colour of all vertices, if they have the same and it is opaque.
    fn one_color(&self) -> Option<[u8; 3]> {
        let first @ [r, g, b, 0xff] = self.inks.first()?.color else { return None };
        self.inks.iter().all(|ink| ink.color == first).then_some([r, g, b])
    }

    /// The colour at a share of the way from one end of a stroke to the other.
    pub fn between(&self, [from, to]: [Ink; 2], share: f64) -> Ink {
        match self.is_of_categories {
            false => from.lerp(to, share),
            true if share < 0.5 => from,
            true => to,
        }
    }

    /// The camera.
    pub fn eye(&self) -> &'a Eye {
        self.eye
    }

    /// Adds a vertex at a place of the screen and a nearness; returns its number.
    pub fn vertex(&mut self, screen: DVec2, nearness: f64, ink: Ink) -> u32 {
        self.vertex_at(self.eye.place(screen, self.eye.distance(nearness)), ink)
    }

    /// Adds a vertex with a normal, in world axes relative to the origin of the eye.
    pub fn vertex_with_normal(&mut self, p: DVec3, normal: DVec3, ink: Ink) -> u32 {
        self.normals.push(OctNormal::from_vector(normal.to_array()));
        self.vertex_at(p, ink)
    }

    fn vertex_at(&mut self, p: DVec3, ink: Ink) -> u32 {
        self.positions.push(p.as_vec3().to_array());
        self.inks.push(ink);
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
    fn instance(self, look: &Look) -> Option<Instance> {
        if self.triangles.is_empty() {
            return None;
        }
        let pieces = self.pieces();
        let largest = self.positions.as_flattened().iter().fold(0.0f32, |m, c| m.max(c.abs()));
        if !largest.is_finite() {
            return None;
        }
        let mut surface = look.surface;
        // What has one colour needs none at its vertices.
        let one_color = self.one_color().filter(|_| look.colors.is_none());
        if let Some(color) = one_color {
            surface.base_color = color.map(|level| srgb_to_linear(f64::from(level) / 255.0) as f32);
            surface.use_mesh_colors = false;
        }
        let has_colors = look.colors.is_none() && one_color.is_none();
        let mut mesh = Mesh {
            origin: self.eye.origin(),
            positions: self.positions,
            triangles: self.triangles,
            vertex_colors: has_colors.then(|| self.inks.iter().map(|ink| ink.color).collect()),
            attributes: look.colors.iter().map(|colors| values(&self.inks, colors.offset)).collect(),
            normals: (!self.normals.is_empty()).then_some(self.normals),
            ..Mesh::default()
        };
        mesh.bring_into_range(largest);
        let data = look.colors.as_ref().map(|colors| {
            Arc::new(SurfaceData::Mapped { source: DataSource::Attribute(0), colors: Arc::clone(colors) })
        });
        Some(Instance { surface, data, ..Instance::new(partition_pieces(mesh, pieces)) })
    }
}

fn values(inks: &[Ink], offset: f64) -> Attribute {
    let values = inks.iter().map(|ink| ink.value).collect();
    Attribute { name: "data".into(), domain: AttributeDomain::Vertex, values, offset, component: None }
}

/// Draws strokes onto sheets, in parallel; the sheets, in order, as instances.
pub fn draw<T: Sync>(
    eye: &Eye,
    look: &Look,
    strokes: &[T],
    draw: impl Fn(&mut Sheet, &T) + Sync,
) -> Vec<Instance> {
    draw_together(eye, look, strokes, |sheet, strokes| {
        for stroke in strokes {
            sheet.begin();
            draw(sheet, stroke);
        }
    })
}

/// As [`draw`], with a function that draws several strokes, and [begins](Sheet::begin) each of them.
pub fn draw_together<T: Sync>(
    eye: &Eye,
    look: &Look,
    strokes: &[T],
    draw: impl Fn(&mut Sheet, &[T]) + Sync,
) -> Vec<Instance> {
    let chunk = |strokes: &[T]| {
        let mut sheet = Sheet::new(eye, look);
        draw(&mut sheet, strokes);
        sheet.instance(look)
    };
    strokes.par_chunks(CHUNK).filter_map(chunk).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raster::view::View;
    use crate::strokes::{Length, Segment, segments};

    /// Pictures do not depend on the order of strokes in clusters; only what they cost does.
    #[test]
    fn clusters_of_strokes_are_full_and_compact() {
        let model = crate::load("builtin:sphere@1k").expect("a model");
        let scene = crate::Scene::from_mesh(model.mesh);
        let camera = crate::Settings::new(320, 240).framing().camera_for_scene(&scene);
        let eye = Eye::new(View::new(&camera, &scene.bounds(), 320, 240).expect("a camera"));
        let (n, from, size) = (60, scene.bounds().min, scene.bounds().size());
        // A square of short lines, neighbours far from each other in the list.
        let line = |i: u32| {
            let number = i * 1009 % (n * n);
            let at = DVec3::new(f64::from(number % n), f64::from(number / n), 0.0) / f64::from(n);
            let ends = [from + at * size.x, from + (at + DVec3::X * 0.5 / f64::from(n)) * size.x];
            Segment { ends, width: Length::Pixels(1.0), color: [0, 0, 0, 255] }
        };
        let lines: Vec<Segment> = (0..n * n).map(line).collect();
        let [instance] = &segments(&eye, &lines)[..] else { panic!("one sheet") };
        let clusters = instance.mesh.clusters();
        let least = instance.mesh.vertex_count().div_ceil(64);
        assert!(clusters.len() * 10 <= least * 13, "{} clusters, at least {least}", clusters.len());
        let unit = instance.mesh.unit();
        let diagonal2 = |c: &tercio_mesh::cluster::Cluster| {
            (Vec3::from(c.max) - Vec3::from(c.min)).as_dvec3().length_squared() * unit * unit
        };
        let share = clusters.iter().map(diagonal2).sum::<f64>() / (size.x * size.x);
        assert!(share <= 12.0, "{share} times the area");
    }
}
