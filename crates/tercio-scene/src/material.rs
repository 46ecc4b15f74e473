//! Materials: how surfaces reflect light, with textures.

use std::sync::Arc;

use tercio_mesh::{ClusteredMesh, Mesh};

use crate::{Scene, Surface};

/// How a texture continues beyond its edges.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Wrap {
    /// The picture is repeated.
    #[default]
    Repeat,
    /// The picture is repeated, every other one mirrored.
    Mirror,
    /// The texels at the edge are repeated.
    Clamp,
}

/// A texture, and where it lies on a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureMap {
    /// Index in [`Scene::textures`].
    pub texture: u32,
    /// How it continues beyond its left and right edge, and beyond its lower and upper one.
    pub wrap: [Wrap; 2],
    /// Factors of the texture coordinates of the mesh; finite.
    pub scale: [f32; 2],
    /// What is added then; finite.
    pub offset: [f32; 2],
}

impl TextureMap {
    /// A repeated texture at the texture coordinates of the mesh.
    pub fn new(texture: u32) -> Self {
        Self { texture, wrap: [Wrap::Repeat; 2], scale: [1.0; 2], offset: [0.0; 2] }
    }
}

/// What the opacity of a material means.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum AlphaMode {
    /// What is behind shines through.
    #[default]
    Blend,
    /// What is at least this opaque is opaque, everything else is invisible.
    Cutout(f32),
    /// It is ignored.
    Opaque,
}

/// How a surface reflects light. Colours are linear. A texture multiplies the number or colour beside it.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Diffuse colour; that of metals is the colour of their reflection.
    pub base_color: [f32; 3],
    /// Texture of the diffuse colour, in sRGB. Its alpha multiplies the opacity.
    pub base_color_map: Option<TextureMap>,
    /// 0 to 1.
    pub opacity: f32,
    /// Texture of the opacity: its red channel, linear.
    pub opacity_map: Option<TextureMap>,
    /// What opacity means.
    pub alpha_mode: AlphaMode,
    /// Colour of the highlight in Phong shading; see [`crate::Surface::specular`].
    pub specular: [f32; 3],
    /// Texture of the highlight's colour, in sRGB.
    pub specular_map: Option<TextureMap>,
    /// log2 of the highlight's exponent in Phong shading, 0 to 10.
    pub shininess_log2: u32,
    /// Roughness in physically based shading, 0 to 1.
    pub roughness: f32,
    /// Texture of roughness: its green channel, linear.
    pub roughness_map: Option<TextureMap>,
    /// 0 for dielectrics to 1 for metals, in physically based shading.
    pub metallic: f32,
    /// Texture of metallicity: its blue channel, linear.
    pub metallic_map: Option<TextureMap>,
    /// Light that the surface emits.
    pub emissive: [f32; 3],
    /// Texture of the emitted light, in sRGB.
    pub emissive_map: Option<TextureMap>,
    /// Texture of normals in tangent space, linear: x along u, y along v, z towards the side that is seen, from -1 to 1. So
    /// bumps are raised on both sides.
    pub normal_map: Option<TextureMap>,
    /// Factor of x and y of the normals.
    pub normal_scale: f32,
    /// Texture of the share of ambient and wide light that reaches the surface: its red channel, linear.
    pub occlusion_map: Option<TextureMap>,
}

impl Default for Material {
    fn default() -> Self {
        Self { base_color: [1.0; 3], ..Self::of_surface(&Surface::default()) }
    }
}

impl Material {
    /// The material of a surface without textures. Its opacity is 1: that of the surface is applied to all materials.
    pub fn of_surface(surface: &Surface) -> Self {
        Self {
            base_color: surface.base_color,
            base_color_map: None,
            opacity: 1.0,
            opacity_map: None,
            alpha_mode: AlphaMode::default(),
            specular: [surface.specular; 3],
            specular_map: None,
            shininess_log2: surface.shininess_log2,
            roughness: surface.roughness,
            roughness_map: None,
            metallic: surface.metallic,
            metallic_map: None,
            emissive: [0.0; 3],
            emissive_map: None,
            normal_map: None,
            normal_scale: 1.0,
            occlusion_map: None,
        }
    }

    /// All its textures.
    pub fn maps(&self) -> impl Iterator<Item = &TextureMap> {
        let maps = [
            &self.base_color_map,
            &self.opacity_map,
            &self.specular_map,
            &self.roughness_map,
            &self.metallic_map,
            &self.emissive_map,
            &self.normal_map,
            &self.occlusion_map,
        ];
        maps.into_iter().flatten()
    }

    /// May it be less than opaque anywhere?
    fn is_translucent(&self, scene: &Scene) -> bool {
        let is_opaque = |map: &TextureMap| scene.textures[map.texture as usize].is_opaque();
        self.alpha_mode != AlphaMode::Opaque
            && (self.opacity < 1.0
                || self.opacity_map.is_some()
                || self.base_color_map.as_ref().is_some_and(|map| !is_opaque(map)))
    }
}

/// The materials of an instance, made once for its mesh.
#[derive(Debug)]
pub struct InstanceMaterials {
    /// For each material of the mesh, its index in [`Scene::materials`].
    of_mesh: Vec<u32>,
    /// For each cluster, whether any of its triangles has a material that may be less than opaque.
    translucent: Vec<bool>,
    is_translucent: bool,
}

impl InstanceMaterials {
    /// `of_mesh` holds the index in [`Scene::materials`] for each material of the mesh. The scene's materials and textures
    /// must not change afterwards.
    ///
    /// # Panics
    /// If an index is too large.
    pub fn new(mesh: &ClusteredMesh, of_mesh: Vec<u32>, scene: &Scene) -> Arc<Self> {
        let is_translucent: Vec<bool> =
            of_mesh.iter().map(|&m| scene.materials[m as usize].is_translucent(scene)).collect();
        let any = is_translucent.contains(&true);
        let of_cluster = |number| {
            let materials = mesh.cluster(number).triangle_materials();
            let is_translucent = |m: &u32| is_translucent.get(*m as usize).copied().unwrap_or(false);
            any && materials.is_some_and(|m| m.iter().any(is_translucent))
        };
        let translucent: Vec<bool> = (0..mesh.clusters().len()).map(of_cluster).collect();
        let is_translucent = translucent.contains(&true);
        Arc::new(Self { of_mesh, translucent, is_translucent })
    }

    /// The same materials for another part of the model that the instance's mesh is a part of. `is_translucent`: may any triangle
    /// of the whole model be less than opaque?
    pub fn for_part(&self, mesh: &ClusteredMesh, scene: &Scene, is_translucent: bool) -> Arc<Self> {
        // Indices that are too large are found when the scene is drawn.
        let is_there = self.of_mesh.iter().all(|&m| (m as usize) < scene.materials.len());
        let of_part = is_there.then(|| Self::new(mesh, self.of_mesh.clone(), scene));
        let translucent = of_part.map_or_else(Vec::new, |of_part| of_part.translucent.clone());
        Arc::new(Self { of_mesh: self.of_mesh.clone(), translucent, is_translucent })
    }

    /// Are they made for this mesh, and are their materials in this scene?
    pub fn fit(&self, mesh: &ClusteredMesh, scene: &Scene) -> bool {
        let is_there = |material: &u32| (*material as usize) < scene.materials.len();
        self.translucent.len() == mesh.clusters().len() && self.of_mesh.iter().all(is_there)
    }

    /// The index in [`Scene::materials`] for a triangle's material in the mesh; `None` for [`Mesh::NO_MATERIAL`].
    #[inline]
    pub fn of_triangle(&self, material: u32) -> Option<u32> {
        if material == Mesh::NO_MATERIAL { None } else { self.of_mesh.get(material as usize).copied() }
    }

    /// May a triangle of this cluster be less than opaque?
    pub fn is_cluster_translucent(&self, cluster: usize) -> bool {
        self.translucent[cluster]
    }

    /// May any triangle be less than opaque? Of the whole model if they are [for a part](Self::for_part) of one.
    pub fn is_translucent(&self) -> bool {
        self.is_translucent
    }
}
