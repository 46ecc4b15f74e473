//! The vertex attributes of one cluster as tables that fit into vector registers, for shading its winners.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16};
use tercio_mesh::cluster::{ClusterView, MAX_TRIANGLES, MAX_VERTICES};
use tercio_scene::Instance;

use super::corners::{ColorSource, Colored, Corners, material_number, scaled, unit_normal};
use super::light::Vec3x16;
use super::shade::Facing;
use crate::context::FrameContext;
use crate::conventions::SMALL_EXTENT;
use crate::projection::{CornerNumbers, CornerTable, LocalVertices};
use crate::simd::{LANES, dot, each3, load, lookup, splat};
use crate::view::ObjectView;

/// Positions, normals and colours of the vertices of a cluster.
#[derive(Debug)]
pub struct ClusterTable {
    /// Positions as the bits of an `f32`, by axis and vertex; valid only if the shading needs positions.
    position: [[i32; MAX_VERTICES]; 3],
    /// Normals after [`unit_normal`] and [`scaled`], likewise; valid only if the mesh has normals.
    normal: [[i32; MAX_VERTICES]; 3],
    /// What is known about all normals interpolated in the cluster; nothing if the cluster is wide.
    pub facing: Facing,
    /// Linear colours, likewise; valid only if the mesh has vertex colours. With [`ColorSource::Data`], values of vertices in the first
    /// array, or of triangles in the first two.
    color: [[i32; MAX_VERTICES]; 3],
    /// Alpha of the colours, likewise.
    alpha: [i32; MAX_VERTICES],
    /// Texture coordinates, likewise.
    uv: [[i32; MAX_VERTICES]; 2],
}

impl Default for ClusterTable {
    fn default() -> Self {
        let zero = [[0; MAX_VERTICES]; 3];
        let (facing, alpha, uv) = (Facing::default(), zero[0], [zero[0]; 2]);
        Self { position: zero, normal: zero, facing, color: zero, alpha, uv }
    }
}

impl ClusterTable {
    /// Loads the normals of a cluster, if it has any. Precondition: its vertices are projected.
    #[inline(always)]
    pub fn load_normals<S: Simd>(
        &mut self,
        simd: S,
        context: &FrameContext,
        object: &ObjectView,
        cluster: &ClusterView,
        vertices: &LocalVertices,
    ) {
        self.facing = Facing::default();
        let Some(normals) = cluster.normals() else { return };
        let sight = &context.lights.sight;
        // Wide clusters, too, are less than twice as wide as the others.
        let squares = if vertices.is_wide { 2 } else { 1 };
        let spread = sight.spread * squares as f32;
        let from_middle = vertices.offset_from_middle(sight).map(|c| c + squares * SMALL_EXTENT / 2);
        let to_viewer = sight.at(from_middle);
        let to_viewer = each3!(K => splat(simd, to_viewer[K]));
        let (mut not_towards, mut not_away) = (0, 0);
        let mut first = 0;
        while first < normals.len() {
            let mut packed = [0; LANES];
            for (to, from) in packed.iter_mut().zip(&normals[first..first + LANES]) {
                *to = from.0 as i32;
            }
            let scale = if object.perspective {
                vertices.depths_of_16(simd, first) * object.weight
            } else {
                splat(simd, 1.0)
            };
            let n = unit_normal(simd, context, object, i32x16::load_array(simd, packed));
            let towards = dot(n, to_viewer);
            not_towards |= !towards.simd_gt(splat(simd, spread)).to_bitmask() as u32 & 0xffff;
            not_away |= !towards.simd_lt(splat(simd, -spread)).to_bitmask() as u32 & 0xffff;
            let n = scaled(simd, n, scale);
            for (to, axis) in self.normal.iter_mut().zip(n) {
                axis.bitcast::<i32x16<S>>().store_slice(&mut to[first..first + LANES]);
            }
            first += LANES;
        }
        self.facing = Facing { viewer: not_towards == 0, away: not_away == 0 };
    }

    /// Loads the positions of a cluster.
    #[inline(always)]
    pub fn load_positions<S: Simd>(&mut self, simd: S, cluster: &ClusterView) {
        for (axis, values) in cluster.positions().into_iter().enumerate() {
            let mut first = 0;
            while first < values.len() {
                load(simd, &values[first..])
                    .bitcast::<i32x16<S>>()
                    .store_slice(&mut self.position[axis][first..first + LANES]);
                first += LANES;
            }
        }
    }

    /// Looks up the corners of 16 triangles, given by their numbers in the cluster, without positions and colours.
    #[inline(always)]
    pub fn look_up<S: Simd>(
        &self,
        simd: S,
        vertices: &LocalVertices,
        corners: &CornerTable,
        triangles: &[u8; LANES],
    ) -> (CornerNumbers, Corners<S>) {
        let numbers = corners.look_up(simd, triangles);
        let mut found = Corners::new(simd);
        [found.x, found.y] = vertices.coordinates(simd, &numbers);
        found.d = vertices.depths(simd, &numbers);
        found.normal = self.look_up_normals(simd, &numbers);
        found.are_near = !vertices.has_wide_triangles;
        (numbers, found)
    }

    /// Looks up the normals of the corners of 16 triangles.
    #[inline(always)]
    pub fn look_up_normals<S: Simd>(&self, simd: S, numbers: &CornerNumbers) -> [Vec3x16<S>; 3] {
        each3!(K => each3!(A => lookup(simd, &self.normal[A], &numbers[K]).bitcast()))
    }

    /// Looks up the positions of the corners of 16 triangles. Precondition: positions are loaded.
    #[inline(always)]
    pub fn look_up_positions<S: Simd>(&self, simd: S, numbers: &CornerNumbers, found: &mut Corners<S>) {
        found.position = each3!(K => each3!(A => {
            let p: f32x16<S> = lookup(simd, &self.position[A], &numbers[K]).bitcast();
            p
        }));
    }

    /// Loads the vertex colours of a cluster, or the values of data at its vertices, if they are needed.
    #[inline(always)]
    pub fn load_colors(&mut self, of: &Colored, colors: ColorSource) {
        match (colors, of.data) {
            (ColorSource::Vertex, _) => {
                for v in 0..of.cluster.vertices() {
                    let color = of.vertex_color(v);
                    for k in 0..3 {
                        self.color[k][v % MAX_VERTICES] = color[k].to_bits() as i32;
                    }
                    self.alpha[v % MAX_VERTICES] = color[3].to_bits() as i32;
                }
            }
            (ColorSource::Data, Some(data)) => {
                let values: &mut [f32] = bytemuck::cast_slice_mut(self.color.as_flattened_mut());
                if let Some(values) = values.first_chunk_mut() {
                    data.read(&of.instance.mesh, of.number, &of.cluster, values);
                }
            }
            _ => {}
        }
    }

    /// Loads the texture coordinates of a cluster, if it has any.
    #[inline(always)]
    pub fn load_texcoords<S: Simd>(&mut self, simd: S, cluster: &ClusterView) {
        for (to, values) in self.uv.iter_mut().zip(cluster.texcoords().into_iter().flatten()) {
            let mut first = 0;
            while first < values.len() {
                let sixteen = load(simd, &values[first..]).bitcast::<i32x16<S>>();
                sixteen.store_slice(&mut to[first..first + LANES]);
                first += LANES;
            }
        }
    }

    /// Looks up texture coordinates and materials of 16 triangles, given by their numbers in the cluster and the vertex
    /// numbers of their corners. Precondition: the instance has materials, and its texture coordinates are loaded.
    #[inline(always)]
    pub fn look_up_materials<S: Simd>(
        &self,
        simd: S,
        instance: &Instance,
        cluster: &ClusterView,
        triangles: &[u8; LANES],
        numbers: &CornerNumbers,
        found: &mut Corners<S>,
    ) {
        found.material = triangles.map(|triangle| material_number(instance, cluster, usize::from(triangle)));
        found.has_uv = cluster.texcoords().is_some();
        if found.has_uv {
            found.uv = each3!(K => [
                lookup(simd, &self.uv[0], &numbers[K]).bitcast(),
                lookup(simd, &self.uv[1], &numbers[K]).bitcast(),
            ]);
        }
    }

    /// Looks up the colours of the corners of 16 triangles, or values of data there, given by their numbers in the cluster and
    /// the vertex numbers of their corners. Precondition: what is at vertices is loaded.
    #[inline(always)]
    pub fn look_up_colors<S: Simd>(
        &self,
        simd: S,
        of: &Colored,
        triangles: &[u8; LANES],
        numbers: &CornerNumbers,
        colors: ColorSource,
        found: &mut Corners<S>,
    ) {
        match colors {
            ColorSource::Base => {}
            ColorSource::Vertex => {
                found.color = each3!(K => each3!(C => lookup(simd, &self.color[C], &numbers[K]).bitcast()));
                if of.has_alpha() {
                    found.alpha = each3!(K => lookup(simd, &self.alpha, &numbers[K]).bitcast());
                }
            }
            ColorSource::Triangle => {
                let mut colors = [[0.0; LANES]; 4];
                for lane in 0..LANES {
                    let color = of.triangle_color(usize::from(triangles[lane]));
                    for k in 0..4 {
                        colors[k][lane] = color[k];
                    }
                }
                found.color = [each3!(C => load(simd, &colors[C])); 3];
                found.alpha = [load(simd, &colors[3]); 3];
            }
            ColorSource::Data => {
                let Some(data) = of.data else { return };
                let values: [f32x16<S>; 3] = match data.is_at_triangles() {
                    false => each3!(K => lookup(simd, &self.color[0], &numbers[K]).bitcast()),
                    true => {
                        let (of_triangles, mut values) = (self.color.as_flattened(), [0.0; LANES]);
                        for lane in 0..LANES {
                            let bits = of_triangles[usize::from(triangles[lane]) % MAX_TRIANGLES];
                            values[lane] = f32::from_bits(bits as u32);
                        }
                        [load(simd, &values); 3]
                    }
                };
                each3!(K => found.color[K][0] = values[K]);
            }
        }
    }
}
