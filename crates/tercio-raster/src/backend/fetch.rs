//! What 16 visible pixels need to know of their triangles.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16, u32x16};
use tercio_mesh::cluster::{Cluster, MAX_VERTICES};
use tercio_mesh::{ClusteredMesh, Mesh};
use tercio_scene::Surface;

use super::visibility::TileMemory;
use crate::color::DECODE;
use crate::context::FrameContext;
use crate::frontend::transform::CornerTable;
use crate::simd::{LANES, load, lookup};

/// 16 pixels of one instance on their way through the shading kernel.
#[derive(Debug, Default)]
pub struct Fragments {
    /// Lanes that hold a pixel; the others repeat the first.
    pub count: usize,
    /// Pixel columns in the picture.
    pub x: [i32; LANES],
    /// Pixel rows in the picture.
    pub y: [i32; LANES],
    /// Places in the tile's planes.
    pub place: [u32; LANES],
    /// Triangles.
    pub slot: [u32; LANES],
    /// Depths.
    pub depth: [f32; LANES],
}

impl Fragments {
    /// Adds a pixel; tells whether all lanes are taken.
    #[inline(always)]
    pub fn push(&mut self, x: i32, y: i32, place: u32, slot: u32, depth: f32) -> bool {
        let lane = self.count % LANES;
        self.x[lane] = x;
        self.y[lane] = y;
        self.place[lane] = place;
        self.slot[lane] = slot;
        self.depth[lane] = depth;
        self.count = lane + 1;
        self.count == LANES
    }

    /// Takes pixels and places of 16 samples of a tile, given by their places in the tile memory.
    #[inline(always)]
    pub fn of_winners<S: Simd>(&mut self, simd: S, memory: &TileMemory, places: &[i32], width: usize) {
        let [x, y] = memory.column_and_row(i32x16::from_slice(simd, &places[..LANES]));
        (x + memory.corner[0]).store_slice(&mut self.x);
        (y + memory.corner[1]).store_slice(&mut self.y);
        (y * width as i32 + x).bitcast::<u32x16<S>>().store_slice(&mut self.place);
    }

    /// Repeats the first pixel in the lanes that hold none.
    pub fn fill_up(&mut self) {
        for lane in self.count..LANES {
            self.x[lane] = self.x[0];
            self.y[lane] = self.y[0];
            self.place[lane] = self.place[0];
            self.slot[lane] = self.slot[0];
            self.depth[lane] = self.depth[0];
        }
    }
}

/// Where a mesh's colour comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ColorSource {
    /// The surface's one colour.
    Base,
    /// One a vertex.
    Vertex,
    /// One a triangle: its own or its material's.
    Triangle,
}

impl ColorSource {
    /// What a mesh offers and its surface takes.
    pub fn of(mesh: &ClusteredMesh, surface: &Surface) -> Self {
        if !surface.use_mesh_colors {
            Self::Base
        } else if mesh.face_colors.is_some() {
            Self::Triangle
        } else if mesh.vertex_colors.is_some() {
            Self::Vertex
        } else if mesh.triangle_materials.is_some() && !mesh.materials.is_empty() {
            Self::Triangle
        } else {
            Self::Base
        }
    }
}

/// Linear colour of a triangle that has one of its own, from its place in the mesh's triangle arrays.
pub fn triangle_color(mesh: &ClusteredMesh, surface: &Surface, triangle: usize) -> [f32; 3] {
    if let Some(colors) = &mesh.face_colors {
        return linear(colors[triangle]);
    }
    let material = mesh.triangle_materials.as_ref().map_or(Mesh::NO_MATERIAL, |m| m[triangle]);
    match mesh.materials.get(material as usize) {
        Some(m) => {
            let level = |k: usize| (m.diffuse[k].clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
            linear([level(0), level(1), level(2), 255])
        }
        None => surface.base_color,
    }
}

/// Linear light of an sRGB colour; alpha is left out.
pub fn linear(color: [u8; 4]) -> [f32; 3] {
    [0, 1, 2].map(|k| DECODE[usize::from(color[k])])
}

/// What shading needs of one cluster, as tables that fit into vector registers.
#[derive(Debug)]
pub struct ClusterTable {
    /// Positions, as the bits of `f32`: axis, vertex.
    position: [[i32; MAX_VERTICES]; 3],
    /// Packed normals; of no use where the mesh has none.
    normal: [i32; MAX_VERTICES],
    first_vertex: usize,
    first_triangle: usize,
}

impl Default for ClusterTable {
    fn default() -> Self {
        let zero = [0; MAX_VERTICES];
        Self { position: [zero; 3], normal: zero, first_vertex: 0, first_triangle: 0 }
    }
}

impl ClusterTable {
    /// Copies a cluster.
    #[inline(always)]
    pub fn load<S: Simd>(&mut self, simd: S, mesh: &ClusteredMesh, cluster: &Cluster) {
        self.first_vertex = cluster.first_vertex as usize;
        self.first_triangle = cluster.first_triangle as usize;
        let mut first = 0;
        while first < usize::from(cluster.vertices) {
            let from = self.first_vertex + first;
            let to = first..first + LANES;
            for (axis, values) in [&mesh.x, &mesh.y, &mesh.z].into_iter().enumerate() {
                load(simd, &values[from..from + LANES])
                    .bitcast::<i32x16<S>>()
                    .store_slice(&mut self.position[axis][to.clone()]);
            }
            if let Some(normals) = &mesh.normals {
                for (to, from) in self.normal[to].iter_mut().zip(&normals[from..from + LANES]) {
                    *to = from.0 as i32;
                }
            }
            first += LANES;
        }
    }
}

/// The corners of the triangles of 16 pixels, lane by lane.
#[derive(Debug, Default)]
pub struct CornerLanes {
    /// Position: corner, axis, lane.
    pub position: [[[f32; LANES]; 3]; 3],
    /// Packed normal: corner, lane.
    pub normal: [[u32; LANES]; 3],
    /// Linear colour: corner, component, lane; only where the mesh has colours.
    pub color: [[[f32; LANES]; 3]; 3],
}

impl CornerLanes {
    /// Looks up the corners of 16 triangles of one cluster, given by their numbers in it.
    #[inline(always)]
    pub fn look_up<S: Simd>(
        &mut self,
        simd: S,
        mesh: &ClusteredMesh,
        surface: &Surface,
        table: &ClusterTable,
        corners: &CornerTable,
        triangles: &[u8; LANES],
        colors: ColorSource,
    ) {
        let numbers = corners.look_up(simd, triangles);
        for k in 0..3 {
            for axis in 0..3 {
                let p = lookup(simd, &table.position[axis], &numbers[k]);
                p.bitcast::<f32x16<S>>().store_slice(&mut self.position[k][axis]);
            }
            lookup(simd, &table.normal, &numbers[k]).bitcast::<u32x16<S>>().store_slice(&mut self.normal[k]);
        }
        match (colors, &mesh.vertex_colors) {
            (ColorSource::Base, _) => {}
            (ColorSource::Vertex, Some(of_vertices)) => {
                for (k, lane) in (0..3).flat_map(|k| (0..LANES).map(move |lane| (k, lane))) {
                    let vertex = table.first_vertex + usize::from(numbers[k][lane] & 63);
                    self.set_color(k, lane, linear(of_vertices[vertex]));
                }
            }
            _ => {
                for lane in 0..LANES {
                    let triangle = table.first_triangle + usize::from(triangles[lane]);
                    let color = triangle_color(mesh, surface, triangle);
                    (0..3).for_each(|k| self.set_color(k, lane, color));
                }
            }
        }
    }

    /// Fetches the corners of all lanes; all slots belong to `instance`.
    pub fn fetch(
        &mut self,
        context: &FrameContext,
        instance: usize,
        slots: &[u32; LANES],
        colors: ColorSource,
    ) {
        let scene_instance = &context.scene.instances[instance];
        let mesh = &*scene_instance.mesh;
        let mut before = None;
        for lane in 0..LANES {
            let slot = slots[lane];
            if before == Some(slot) {
                self.repeat(lane, colors);
                continue;
            }
            before = Some(slot);
            let (_, cluster, triangle) = context.locate_slot(slot);
            let first = mesh.clusters[cluster].first_vertex as usize;
            for k in 0..3 {
                let v = first + usize::from(mesh.corners[k][triangle]);
                self.position[k][0][lane] = mesh.x[v];
                self.position[k][1][lane] = mesh.y[v];
                self.position[k][2][lane] = mesh.z[v];
                if let Some(normals) = &mesh.normals {
                    self.normal[k][lane] = normals[v].0;
                }
                if let (ColorSource::Vertex, Some(c)) = (colors, &mesh.vertex_colors) {
                    self.set_color(k, lane, linear(c[v]));
                }
            }
            if colors == ColorSource::Triangle {
                let color = triangle_color(mesh, &scene_instance.surface, triangle);
                (0..3).for_each(|k| self.set_color(k, lane, color));
            }
        }
    }

    fn set_color(&mut self, corner: usize, lane: usize, color: [f32; 3]) {
        (0..3).for_each(|c| self.color[corner][c][lane] = color[c]);
    }

    /// Copies the lane before: neighbouring pixels mostly show the same triangle.
    #[inline(always)]
    fn repeat(&mut self, lane: usize, colors: ColorSource) {
        for k in 0..3 {
            (0..3).for_each(|axis| self.position[k][axis][lane] = self.position[k][axis][lane - 1]);
            self.normal[k][lane] = self.normal[k][lane - 1];
            if colors != ColorSource::Base {
                (0..3).for_each(|c| self.color[k][c][lane] = self.color[k][c][lane - 1]);
            }
        }
    }
}
