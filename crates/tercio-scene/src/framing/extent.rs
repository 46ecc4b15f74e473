//! The extent of a model that is not in the scene, or not whole.

use glam::DVec3;
use tercio_mesh::loops::prelude::*;
use tercio_mesh::strokes::Strokes;
use tercio_mesh::{Aabb, Mesh};

/// The vertices of a model, for a camera that frames all of it although a part is drawn.
#[derive(Clone, Debug)]
pub struct Extent {
    origin: DVec3,
    unit: f64,
    points: Vec<[f32; 3]>,
    bounds: Aabb,
}

impl Extent {
    /// The vertices of a mesh that triangles use. They are copied: 12 bytes each.
    ///
    /// # Panics
    /// If a triangle's vertex does not exist.
    pub fn of_mesh(mesh: &Mesh) -> Self {
        let mut used = vec![false; mesh.positions.len()];
        mesh.triangles.as_flattened().iter().for_each(|&v| used[v as usize] = true);
        let all = mesh.positions.iter().zip(used);
        let positions = all.filter(|(_, is_used)| *is_used).map(|(p, _)| *p).collect();
        let points = Mesh { origin: mesh.origin, exponent: mesh.exponent, positions, ..Mesh::default() };
        let bounds = points.bounds();
        Self { origin: mesh.origin, unit: mesh.unit(), points: points.positions, bounds }
    }

    /// The finite vertices of lines and points.
    ///
    /// # Panics
    /// If a vertex of them does not exist.
    pub fn of_strokes(strokes: &Strokes) -> Self {
        let used = strokes.segments.as_flattened().iter().chain(&strokes.points);
        let points: Vec<[f32; 3]> = used
            .map(|&v| strokes.positions[v as usize])
            .filter(|p| p.iter().all(|c| c.is_finite()))
            .collect();
        let mesh = Mesh { origin: strokes.origin, positions: points, ..Mesh::default() };
        Self { origin: strokes.origin, unit: 1.0, bounds: mesh.bounds(), points: mesh.positions }
    }

    /// World-space bounds; empty if no triangle uses a vertex.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// The vertices sorted into cells, to find the farthest in many directions.
    pub fn cells(&self) -> Cells {
        const SIDE: usize = 24;
        // Rounded: a vertex beside the box is in the outermost cell.
        let min = (self.bounds.min - self.origin) / self.unit;
        let size = (self.bounds.size() / self.unit).max(DVec3::splat(f64::MIN_POSITIVE));
        let cell_of = |p: &[f32; 3]| {
            let at = (DVec3::from(p.map(f64::from)) - min) / size * SIDE as f64;
            let [x, y, z] = at.to_array().map(|c| (c as usize).min(SIDE - 1));
            (x * SIDE + y) * SIDE + z
        };
        let mut cells = vec![Vec::new(); SIDE.pow(3)];
        for p in &self.points {
            cells[cell_of(p)].push(*p);
        }
        cells.retain(|cell| !cell.is_empty());
        let bounds = |cell: &Vec<[f32; 3]>| {
            let (mut min, mut max) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
            for p in cell {
                min = std::array::from_fn(|k| min[k].min(p[k]));
                max = std::array::from_fn(|k| max[k].max(p[k]));
            }
            [min, max]
        };
        let boxes = cells.iter().map(bounds).collect();
        Cells { origin: self.origin, unit: self.unit, boxes, cells }
    }

    /// As [`Instance::reach`](crate::Instance::reach), with the same bits.
    pub fn reach(&self, direction: DVec3, from: DVec3) -> f64 {
        let d = direction;
        let along = |p: &[f32; 3]| {
            let p = p.map(f64::from);
            d[0] * p[0] + d[1] * p[1] + d[2] * p[2]
        };
        let points = self.points.par_iter().with_min_len(1 << 14).map(along);
        direction.dot(self.origin - from) + points.reduce(|| f64::NEG_INFINITY, f64::max) * self.unit
    }
}

/// Vertices sorted into cells of space.
pub struct Cells {
    origin: DVec3,
    unit: f64,
    boxes: Vec<[[f32; 3]; 2]>,
    cells: Vec<Vec<[f32; 3]>>,
}

impl Cells {
    /// A vertex, at the position given by its file, that reaches farthest in a direction; none if there are none.
    pub fn farthest(&self, direction: DVec3) -> Option<DVec3> {
        let along = |p: [f32; 3]| direction.dot(DVec3::from(p.map(f64::from)));
        let of_box = |[min, max]: &[[f32; 3]; 2]| {
            along(std::array::from_fn(|k| if direction[k] < 0.0 { min[k] } else { max[k] }))
        };
        let mut order: Vec<(f64, usize)> = self.boxes.iter().map(of_box).zip(0..).collect();
        order.sort_unstable_by(|a, b| b.0.total_cmp(&a.0));
        let mut best: Option<(f64, [f32; 3])> = None;
        for (bound, number) in order {
            if best.is_some_and(|(most, _)| bound < most) {
                break;
            }
            for &p in &self.cells[number] {
                let reached = along(p);
                if best.is_none_or(|(most, _)| reached > most) {
                    best = Some((reached, p));
                }
            }
        }
        let (_, vertex) = best?;
        Some(self.origin + DVec3::from(vertex.map(f64::from)) * self.unit)
    }
}
