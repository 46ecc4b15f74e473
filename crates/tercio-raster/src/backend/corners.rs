//! The corner attributes of the triangles of 16 visible pixels, fetched from the mesh.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16, mask32x16, u32x16};
use tercio_mesh::cluster::{ClusterView, MAX_TRIANGLES};
use tercio_mesh::edges::Beyond;
use tercio_mesh::{AttributeDomain, ClusteredMesh, Mesh};
use tercio_scene::{Instance, Surface, SurfaceData, SurfaceEdges};

use super::light::{Vec3x16, beside, normalize};
use super::material::{NO_MATERIAL, has_materials};
use crate::color::DECODE;
use crate::context::FrameContext;
use crate::data::DataTable;
use crate::projection::project;
use crate::simd::{LANES, each3, part, splat, splat_i};
use crate::view::ObjectView;

/// Up to 16 pixels of one instance, the input of the shading kernel.
#[derive(Debug, Default)]
pub struct Fragments {
    /// Number of lanes in use; the others repeat one of these.
    pub count: usize,
    /// Places of the pixels in the tile memory: with one sample per pixel, sample indices.
    pub place: [i32; LANES],
    /// Slots of the triangles.
    pub slot: [u32; LANES],
    /// Depths.
    pub depth: [f32; LANES],
    /// With several samples per pixel, the points that are shaded: distances from the middle of their pixel, in
    /// sub-pixels to the right and downwards.
    pub from_middle: [[i32; LANES]; 2],
    /// They are a block of 4x4, row by row.
    pub is_block: bool,
}

impl Fragments {
    /// Adds a pixel; returns whether all lanes are in use.
    #[inline(always)]
    pub fn push(&mut self, place: i32, slot: u32, depth: f32) -> bool {
        let lane = self.count % LANES;
        self.place[lane] = place;
        self.slot[lane] = slot;
        self.depth[lane] = depth;
        self.count = lane + 1;
        self.count == LANES
    }

    /// Repeats the first pixel in the unused lanes.
    pub fn fill_up(&mut self) {
        for lane in self.count..LANES {
            self.place[lane] = self.place[0];
            self.slot[lane] = self.slot[0];
            self.depth[lane] = self.depth[0];
        }
    }
}

/// Where a mesh's colour comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ColorSource {
    /// One colour for the surface.
    Base,
    /// One per vertex.
    Vertex,
    /// One per triangle: its own or its material's.
    Triangle,
    /// Of values at the corners, mapped after interpolation.
    Data,
}

impl ColorSource {
    /// The colour source that the mesh has and the surface uses. Colours of scene-wide materials are looked up apart.
    pub fn of(instance: &Instance) -> Self {
        let Instance { mesh, surface, .. } = instance;
        let layout = mesh.layout();
        if let Some(data) = &instance.data {
            match (&**data, data.domain(layout)) {
                (SurfaceData::Mapped { .. }, _) => Self::Data,
                (SurfaceData::Direct { .. }, AttributeDomain::Vertex) => Self::Vertex,
                (SurfaceData::Direct { .. }, AttributeDomain::Triangle) => Self::Triangle,
            }
        } else if !surface.use_mesh_colors {
            Self::Base
        } else if layout.face_colors {
            Self::Triangle
        } else if layout.vertex_colors {
            Self::Vertex
        } else if layout.triangle_materials && !mesh.materials.is_empty() && !has_materials(instance) {
            Self::Triangle
        } else {
            Self::Base
        }
    }
}

/// The cluster of an instance whose pixels are shaded.
#[derive(Clone, Copy)]
pub struct Colored<'a> {
    pub instance: &'a Instance,
    /// How data become colours, if the instance shows data.
    pub data: Option<&'a DataTable>,
    /// The number of the cluster in the mesh.
    pub number: usize,
    pub cluster: ClusterView<'a>,
}

impl<'a> Colored<'a> {
    /// The cluster with this number in the frame.
    #[inline(always)]
    pub fn new(context: &'a FrameContext, cluster: u32) -> Self {
        let (instance, number) = context.locate(cluster);
        let data = context.data[instance].as_ref();
        let instance = &context.scene.instances[instance];
        Self { instance, data, number, cluster: instance.mesh.cluster(number) }
    }

    /// Linear colour and alpha of a vertex with [`ColorSource::Vertex`].
    #[inline(always)]
    pub fn vertex_color(&self, vertex: usize) -> [f32; 4] {
        match (self.data, self.cluster.vertex_colors()) {
            (Some(data), _) => data.vertex_color(&self.cluster, vertex),
            (None, Some(colors)) => with_alpha(colors[vertex]),
            (None, None) => [0.0; 4],
        }
    }

    /// Linear colour and alpha of a triangle with [`ColorSource::Triangle`].
    pub fn triangle_color(&self, triangle: usize) -> [f32; 4] {
        let Instance { mesh, surface, .. } = self.instance;
        match self.data {
            Some(data) => data.triangle_color(mesh, self.number, &self.cluster, triangle),
            None => triangle_color(mesh, &self.cluster, surface, triangle),
        }
    }

    /// Have its colours an alpha?
    #[inline(always)]
    pub fn has_alpha(&self) -> bool {
        self.instance.colors_are_translucent(self.instance.mesh.is_translucent())
    }
}

/// Linear colour and alpha of a triangle of a mesh, given by its number in its cluster.
fn triangle_color(
    mesh: &ClusteredMesh,
    cluster: &ClusterView,
    surface: &Surface,
    triangle: usize,
) -> [f32; 4] {
    if let Some(colors) = cluster.face_colors() {
        return with_alpha(colors[triangle]);
    }
    let material = cluster.triangle_materials().map_or(Mesh::NO_MATERIAL, |m| m[triangle]);
    match mesh.materials.get(material as usize) {
        Some(m) => {
            let level = |k: usize| (m.diffuse[k].clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
            let [r, g, b, _] = with_alpha([level(0), level(1), level(2), 255]);
            [r, g, b, if m.opacity < 1.0 { m.opacity.max(0.0) } else { 1.0 }]
        }
        None => {
            let [r, g, b] = surface.base_color;
            [r, g, b, 1.0]
        }
    }
}

/// The scene-wide material of a triangle, given by its number in its cluster. Precondition: the instance has materials.
pub fn material_number(instance: &Instance, cluster: &ClusterView, triangle: usize) -> u32 {
    let of_mesh = cluster.triangle_materials().map_or(Mesh::NO_MATERIAL, |m| m[triangle]);
    instance.materials.as_ref().and_then(|m| m.of_triangle(of_mesh)).unwrap_or(NO_MATERIAL)
}

/// The numbers in the mesh of 16 triangles, given by those in their cluster; 0 if lines along their sides do not need them.
#[inline(always)]
pub fn numbers_for_edges(
    cluster: &ClusterView,
    instance: &Instance,
    triangles: &[u8; LANES],
) -> [u32; LANES] {
    match instance.edges.as_deref() {
        None | Some(SurfaceEdges { sides: None, beyond: Beyond::Nothing, .. }) => [0; LANES],
        Some(_) => cluster.primitives_of(triangles),
    }
}

/// Linear light of an sRGB colour, and its alpha.
pub fn with_alpha(color: [u8; 4]) -> [f32; 4] {
    let [r, g, b] = [0, 1, 2].map(|k| DECODE[usize::from(color[k])]);
    [r, g, b, f32::from(color[3]) / 255.0]
}

/// The corners of the triangles of 16 pixels.
pub struct Corners<S: Simd> {
    /// Screen coordinates, with the same origin as those of the pixels.
    pub x: [i32x16<S>; 3],
    /// Screen coordinates.
    pub y: [i32x16<S>; 3],
    /// Depths.
    pub d: [f32x16<S>; 3],
    /// Bit i is set if a corner of lane i is before the near plane or outside the guard band.
    pub beyond: u32,
    /// Positions in mesh coordinates; valid only if the shading needs them.
    pub position: [Vec3x16<S>; 3],
    /// All corners are known to be less than [`SMALL_EXTENT`](crate::conventions::SMALL_EXTENT) sub-pixels from their
    /// sample.
    pub are_near: bool,
    /// Normals after [`unit_normal`] and [`scaled`]; valid only if the mesh has normals.
    pub normal: [Vec3x16<S>; 3],
    /// Linear colours; valid only if the mesh has colours. With [`ColorSource::Data`] there are values instead: see
    /// [`Self::values`].
    pub color: [Vec3x16<S>; 3],
    /// Alpha of the colours; valid only if they have one.
    pub alpha: [f32x16<S>; 3],
    /// Texture coordinates; valid only if [`Corners::has_uv`].
    pub uv: [[f32x16<S>; 2]; 3],
    /// The mesh has texture coordinates, and the shading needs them.
    pub has_uv: bool,
    /// Scene-wide materials, or [`NO_MATERIAL`].
    pub material: [u32; LANES],
    /// The numbers of the triangles in their mesh; valid only if the instance has edges of some sides or polygons.
    pub numbers: [u32; LANES],
    /// In the clusters of all lanes, the normals agree with the winding as defined for
    /// [`Cluster::NORMALS_AGREE`](tercio_mesh::cluster::Cluster::NORMALS_AGREE).
    pub normals_agree: bool,
}

impl<S: Simd> Corners<S> {
    /// All zero.
    #[inline(always)]
    pub fn new(simd: S) -> Self {
        let (zero, zero_i) = (splat(simd, 0.0), splat_i(simd, 0));
        Self {
            x: [zero_i; 3],
            y: [zero_i; 3],
            d: [zero; 3],
            beyond: 0,
            position: [[zero; 3]; 3],
            are_near: false,
            normal: [[zero; 3]; 3],
            color: [[zero; 3]; 3],
            alpha: [zero; 3],
            uv: [[zero; 2]; 3],
            has_uv: false,
            material: [NO_MATERIAL; LANES],
            numbers: [0; LANES],
            normals_agree: false,
        }
    }

    /// Values of data. They share the memory of the colours that they are mapped to later: corners are cleared for every 16
    /// pixels.
    #[inline(always)]
    pub fn values(&self) -> [f32x16<S>; 3] {
        self.color.map(
            #[inline(always)]
            |color| color[0],
        )
    }

    /// Fetches the corners of all lanes. Precondition: all slots belong to `instance`.
    #[inline(always)]
    pub fn fetch(simd: S, context: &FrameContext, instance: usize, slots: &[u32; LANES]) -> Self {
        let scene_instance = &context.scene.instances[instance];
        let colors = ColorSource::of(scene_instance);
        let has_materials = has_materials(scene_instance);
        let slots = u32x16::load_array_ref(simd, slots);
        let mut corners = Self::new(simd);
        let mut packed = [splat_i(simd, 0); 3];
        corners.normals_agree = true;
        let mut left = 0xffff_u32;
        // Neighbouring pixels usually show the same triangle, so each triangle is fetched only once.
        while left != 0 {
            let slot = slots[left.trailing_zeros() as usize % LANES];
            let same = slots.simd_eq(u32x16::splat(simd, slot));
            left &= !(same.to_bitmask() as u32);
            let colored = Colored::new(context, slot / MAX_TRIANGLES as u32);
            let (cluster, triangle) = (colored.cluster, slot as usize % MAX_TRIANGLES);
            corners.normals_agree &= cluster.head().normals_agree();
            let numbers = cluster.corners_of(triangle);
            for k in 0..3 {
                let v = usize::from(numbers[k]);
                let p = cluster.position(v);
                let position = &mut corners.position[k];
                *position = each3!(A => same.select(splat(simd, p[A]), position[A]));
                if let Some(normals) = cluster.normals() {
                    let normal = splat_i(simd, normals[v].0 as i32);
                    packed[k] = same.select(normal, packed[k]);
                }
                if colors == ColorSource::Vertex {
                    corners.set_color(k, same, colored.vertex_color(v));
                }
                if let (ColorSource::Data, Some(data)) = (colors, colored.data) {
                    let value = data.value(&colored.instance.mesh, colored.number, &cluster, triangle, v);
                    let values = &mut corners.color[k][0];
                    *values = same.select(splat(simd, value), *values);
                }
            }
            if has_materials {
                corners.set_material(simd, scene_instance, &cluster, triangle, same);
            }
            if scene_instance.edges.is_some() {
                let (number, bits) = (cluster.primitive(triangle), same.to_bitmask());
                (0..LANES)
                    .filter(|lane| bits >> lane & 1 == 1)
                    .for_each(|lane| corners.numbers[lane] = number);
            }
            if colors == ColorSource::Triangle {
                let color = colored.triangle_color(triangle);
                (0..3).for_each(|k| corners.set_color(k, same, color));
            }
        }
        let object = &context.objects[instance];
        corners.project(simd, object);
        let one = splat(simd, 1.0);
        let beyond = mask32x16::from_bitmask(simd, u64::from(corners.beyond));
        corners.normal = each3!(K => {
            let scale = if object.perspective { beyond.select(one, corners.d[K] * object.weight) } else { one };
            scaled(simd, unit_normal(simd, context, object, packed[K]), scale)
        });
        corners
    }

    /// Projects the positions.
    #[inline(always)]
    fn project(&mut self, simd: S, object: &ObjectView) {
        let mut inside = 0xffff;
        for k in 0..3 {
            let v = project(simd, object, self.position[k]);
            (self.x[k], self.y[k], self.d[k]) = (v.x, v.y, v.d);
            inside &= v.inside.to_bitmask() as u32;
        }
        self.beyond = !inside & 0xffff;
    }

    /// Sets texture coordinates and material in some lanes.
    #[inline(always)]
    fn set_material(
        &mut self,
        simd: S,
        instance: &Instance,
        cluster: &ClusterView,
        triangle: usize,
        lanes: mask32x16<S>,
    ) {
        let bits = lanes.to_bitmask();
        let number = material_number(instance, cluster, triangle);
        for lane in (0..LANES).filter(|lane| bits >> lane & 1 == 1) {
            self.material[lane] = number;
        }
        let Some(texcoords) = cluster.texcoords() else { return };
        self.has_uv = true;
        for (uv, v) in self.uv.iter_mut().zip(cluster.corners_of(triangle)) {
            for (to, values) in uv.iter_mut().zip(texcoords) {
                *to = lanes.select(splat(simd, values[usize::from(v)]), *to);
            }
        }
    }

    /// Sets the colour of one corner in some lanes.
    #[inline(always)]
    pub fn set_color(&mut self, corner: usize, lanes: mask32x16<S>, color: [f32; 4]) {
        let simd = self.d[0].simd;
        self.alpha[corner] = lanes.select(splat(simd, color[3]), self.alpha[corner]);
        for c in 0..3 {
            self.color[corner][c] = lanes.select(splat(simd, color[c]), self.color[corner][c]);
        }
    }
}

/// Decodes packed normals into unit normals in world space. Negated in a mirror image; see
/// [`ObjectView::normal_matrix`].
#[inline(always)]
pub fn unit_normal<S: Simd>(
    simd: S,
    context: &FrameContext,
    object: &ObjectView,
    packed: i32x16<S>,
) -> Vec3x16<S> {
    let n = to_world(simd, object, decode_normal(simd, packed));
    normalize(simd, n, beside(simd, &context.lights))
}

/// Multiplies a vector by the weight of its corner in perspective interpolation, so that it can be interpolated with
/// areas on the screen.
#[inline(always)]
pub fn scaled<S: Simd>(simd: S, n: Vec3x16<S>, scale: f32x16<S>) -> Vec3x16<S> {
    part(
        simd,
        #[inline(always)]
        || each3!(A => n[A] * scale),
    )
}

/// Transforms a normal from object space to world space.
#[inline(always)]
pub fn to_world<S: Simd>(simd: S, object: &ObjectView, n: Vec3x16<S>) -> Vec3x16<S> {
    let m = &object.normal_matrix;
    part(
        simd,
        #[inline(always)]
        || each3!(K => (n[0] * m[K][0] + n[1] * m[K][1]) + n[2] * m[K][2]),
    )
}

/// [`tercio_mesh::OctNormal::decode`], lane by lane.
#[inline(always)]
fn decode_normal<S: Simd>(simd: S, packed: i32x16<S>) -> Vec3x16<S> {
    part(
        simd,
        #[inline(always)]
        || {
            let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
            let unit = splat(simd, 1.0 / 32767.0);
            let u = ((packed << 16) >> 16).to_float::<f32x16<S>>() * unit;
            let v = (packed >> 16).to_float::<f32x16<S>>() * unit;
            let z = (one - u.abs()) - v.abs();
            let fold = z.simd_lt(zero).select(-z, zero);
            let x = u.simd_ge(zero).select(u - fold, u + fold);
            let y = v.simd_ge(zero).select(v - fold, v + fold);
            [x, y, z]
        },
    )
}
