//! The scene: mesh instances, lights, background.

use std::sync::Arc;

use glam::{DAffine3, DVec3};
use tercio_mesh::{Aabb, ClusteredMesh};

use crate::{Environment, InstanceMaterials, Light, Material, SurfaceData, SurfaceEdges, Texture};

/// Everything that is drawn.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// Meshes and their transforms. Primitive numbers of the picture run through the instances in order.
    pub instances: Vec<Instance>,
    /// The lights.
    pub lights: Vec<Light>,
    /// Light from all around, besides the lights.
    pub environment: Option<Arc<Environment>>,
    /// Background colours.
    pub background: Background,
    /// Materials of all instances.
    pub materials: Vec<Material>,
    /// Textures of all materials.
    pub textures: Vec<Arc<Texture>>,
}

/// A mesh and its transform.
#[derive(Clone, Debug)]
pub struct Instance {
    /// The mesh; several instances may share it.
    pub mesh: Arc<ClusteredMesh>,
    /// Transform to world space; applied after the mesh's own origin is added.
    pub world_from_object: DAffine3,
    /// How its surface reflects light where it has no materials.
    pub surface: Surface,
    /// Materials and textures; without them, the materials of the mesh are plain colours. Unused if
    /// [`Surface::use_mesh_colors`] is not set.
    pub materials: Option<Arc<InstanceMaterials>>,
    /// Data that its colours show, in place of those of the mesh, of materials and of textures.
    pub data: Option<Arc<SurfaceData>>,
    /// Lines along the sides of its triangles.
    pub edges: Option<Arc<SurfaceEdges>>,
    /// Where the mesh lies in its model, if it is a [part](ClusteredMesh::as_part_of) of one that several ranks hold.
    pub share: Option<Share>,
}

/// A rank's share of a model that several ranks hold. The shares are ranges of the model's triangles in the order of the ranks;
/// they may be empty.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Share {
    /// Number in the whole model of the mesh's primitive 0: the triangles that the ranks before this one have.
    pub first_triangle: u64,
    /// Triangles of the whole model.
    pub triangles: u64,
    /// Number in the whole model of the mesh's input face 0.
    pub first_face: u64,
    /// Input faces of the whole model.
    pub faces: u64,
    /// Numbers in the picture of the whole model's first triangle and first input face; `None`: they follow those of the instances
    /// before.
    pub base: Option<[u64; 2]>,
    /// Primitives and faces have the numbers of the whole model in the mesh already, as in a part of a prepared model: they need
    /// not be a range then, and `first_triangle` and `first_face` are 0.
    pub has_whole_numbers: bool,
}

impl Instance {
    /// The mesh at the position given by its file.
    pub fn new(mesh: impl Into<Arc<ClusteredMesh>>) -> Self {
        let (world_from_object, surface) = (DAffine3::IDENTITY, Surface::default());
        let (materials, data, edges, share) = (None, None, None, None);
        Self { mesh: mesh.into(), world_from_object, surface, materials, data, edges, share }
    }

    /// World-space bounds; of the whole model if the mesh is a part of one.
    pub fn bounds(&self) -> Aabb {
        let own = self.mesh.bounds;
        if own.is_empty() || self.world_from_object == DAffine3::IDENTITY {
            return own;
        }
        let mut bounds = Aabb::EMPTY;
        own.corners().into_iter().for_each(|c| bounds.add(self.world_from_object.transform_point3(c)));
        bounds
    }

    /// Is any triangle not certainly opaque? Of the whole model if the mesh, and the materials, are a part of one.
    pub fn is_translucent(&self) -> bool {
        let of_materials = || self.materials.as_ref().is_some_and(|m| m.is_translucent());
        self.surface.opacity < 1.0
            || self.colors_are_translucent(self.mesh.is_translucent() || of_materials())
    }

    /// Is it drawn in the colours of its mesh, materials and textures?
    #[inline(always)]
    pub fn uses_mesh_colors(&self) -> bool {
        self.surface.use_mesh_colors && self.data.is_none()
    }

    /// May the colours that it is drawn in be less than opaque, if those of its mesh and materials are `of_mesh`?
    #[inline(always)]
    pub fn colors_are_translucent(&self, of_mesh: bool) -> bool {
        match &self.data {
            Some(data) => data.is_translucent(),
            None => self.surface.use_mesh_colors && of_mesh,
        }
    }

    /// Support function of the vertices: the largest `direction . (p - from)` of all world-space vertices `p`; minus
    /// infinity if there are none. The same however the mesh is split into clusters; of a model in parts, the largest of those
    /// of its parts.
    pub fn reach(&self, direction: DVec3, from: DVec3) -> f64 {
        let mesh = &*self.mesh;
        let d = self.world_from_object.matrix3.transpose() * direction;
        let origin = self.world_from_object.transform_point3(mesh.origin) - from;
        direction.dot(origin) + mesh.farthest(d) * mesh.unit()
    }

    /// A vertex, in world space, that reaches farthest in a direction; none if there are none.
    pub fn farthest(&self, direction: DVec3) -> Option<DVec3> {
        let mesh = &*self.mesh;
        let vertex = mesh.farthest_vertex(self.world_from_object.matrix3.transpose() * direction)?;
        let position = mesh.origin + DVec3::from(vertex.map(f64::from)) * mesh.unit();
        Some(self.world_from_object.transform_point3(position))
    }
}

/// How a surface reflects light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// Linear RGB for a mesh without colours of its own.
    pub base_color: [f32; 3],
    /// False draws everything in `base_color`, whatever colours the mesh has.
    pub use_mesh_colors: bool,
    /// Opacity, 0 to 1; multiplied by the alpha of the mesh's colours if these are used.
    pub opacity: f32,
    /// Strength of the highlight in Phong shading, 0 for none.
    pub specular: f32,
    /// log2 of the highlight's exponent, 0 to 10: 5 means 32.
    pub shininess_log2: u32,
    /// Roughness in physically based shading, 0 for a mirror to 1.
    pub roughness: f32,
    /// 0 for dielectrics to 1 for metals, in physically based shading.
    pub metallic: f32,
    /// Shows its plain colours, whatever the light and the shading of the picture; they are not tone-mapped either.
    pub unlit: bool,
}

impl Default for Surface {
    fn default() -> Self {
        // A light clay: bright enough to show form, below white so that highlights are visible.
        let base_color = [0.578, 0.497, 0.392];
        let (specular, shininess_log2, roughness, metallic) = (0.2, 5, 0.5, 0.0);
        Self {
            base_color,
            use_mesh_colors: true,
            opacity: 1.0,
            specular,
            shininess_log2,
            roughness,
            metallic,
            unlit: false,
        }
    }
}

/// Colours of pixels where nothing is drawn; sRGB, 0 to 1, alpha linear.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Background {
    /// One colour.
    Solid([f32; 4]),
    /// From the upper border to the lower one.
    Gradient {
        /// At the upper border.
        top: [f32; 4],
        /// At the lower border.
        bottom: [f32; 4],
    },
}

impl Default for Background {
    fn default() -> Self {
        Self::Gradient { top: [0.93, 0.94, 0.96, 1.0], bottom: [0.70, 0.73, 0.78, 1.0] }
    }
}

impl Background {
    /// The colour, or that between both of a transition.
    pub fn middle(&self) -> [f32; 4] {
        match *self {
            Self::Solid(color) => color,
            Self::Gradient { top, bottom } => [0, 1, 2, 3].map(|k| 0.5 * (top[k] + bottom[k])),
        }
    }
}

impl Scene {
    /// One mesh at the position given by its file, under [`Light::studio`], on the default background.
    pub fn from_mesh(mesh: impl Into<Arc<ClusteredMesh>>) -> Self {
        Self { instances: vec![Instance::new(mesh)], lights: Light::studio(), ..Self::default() }
    }

    /// World-space bounds of all instances.
    pub fn bounds(&self) -> Aabb {
        self.instances.iter().fold(Aabb::EMPTY, |b, i| b.union(i.bounds()))
    }

    /// Number of clusters of all instances, which are numbered in the order of the instances.
    pub fn cluster_count(&self) -> usize {
        self.instances.iter().map(|i| i.mesh.clusters().len()).sum()
    }

    /// Support function of the vertices of all instances; see [`Instance::reach`].
    pub fn reach(&self, direction: DVec3, from: DVec3) -> f64 {
        self.instances.iter().map(|i| i.reach(direction, from)).fold(f64::NEG_INFINITY, f64::max)
    }

    /// Is any mesh a part of a model that several ranks hold?
    pub fn is_in_parts(&self) -> bool {
        self.instances.iter().any(|i| i.share.is_some())
    }
}
