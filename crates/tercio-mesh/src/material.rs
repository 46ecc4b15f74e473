//! Materials as model files state them.

use serde::{Deserialize, Serialize};

/// A material as a model file states it. What the file does not state is `None` or the default.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FileMaterial {
    /// The name in the file.
    pub name: String,
    /// Folder of the file that states it, relative to the folder of the model; empty if it is the same. Names of textures
    /// are relative to it.
    pub folder: String,
    /// Diffuse colour as in the file, taken as sRGB, 0 to 1.
    pub diffuse: [f32; 3],
    /// Whether the file states the diffuse colour.
    pub states_diffuse: bool,
    /// Opacity, 0 to 1.
    pub opacity: f32,
    /// Colour of highlights (`Ks`), taken as sRGB, 0 to 1.
    pub specular: Option<[f32; 3]>,
    /// Exponent of highlights (`Ns`), not negative.
    pub shininess: Option<f32>,
    /// Colour of emitted light (`Ke`), taken as sRGB, not negative; above 1 for light sources.
    pub emissive: [f32; 3],
    /// Roughness (`Pr`), 0 to 1.
    pub roughness: Option<f32>,
    /// 0 for dielectrics to 1 for metals (`Pm`).
    pub metallic: Option<f32>,
    /// Illumination model (`illum`), 0 to 10: 0 is a colour without light, 1 has no highlights.
    pub illumination: Option<u8>,
    /// The textures that are drawn.
    pub textures: FileTextures,
    /// File names of all other textures, as in the file: they are not drawn.
    pub other_textures: Vec<String>,
}

impl FileMaterial {
    /// sRGB colour and linear alpha where there is neither light nor texture.
    pub fn flat_color(&self) -> [u8; 4] {
        let [r, g, b] = self.diffuse;
        [r, g, b, self.opacity].map(|level| (level * 255.0).round() as u8)
    }
}

impl Default for FileMaterial {
    fn default() -> Self {
        Self {
            name: String::new(),
            folder: String::new(),
            diffuse: [0.8; 3],
            states_diffuse: false,
            opacity: 1.0,
            specular: None,
            shininess: None,
            emissive: [0.0; 3],
            roughness: None,
            metallic: None,
            illumination: None,
            textures: FileTextures::default(),
            other_textures: Vec::new(),
        }
    }
}

impl FileMaterial {
    /// The names of all its texture files, drawn or not, as in the file.
    pub fn texture_files(&self) -> impl Iterator<Item = &String> {
        self.textures.iter().map(|(_, texture)| &texture.file).chain(&self.other_textures)
    }
}

/// A texture as a model file states it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FileTexture {
    /// File name, as in the file.
    pub file: String,
    /// Whether the texels at the edge continue beyond it (`-clamp on`); otherwise the picture is repeated.
    pub clamp: bool,
    /// Added to the texture coordinates after scaling (`-o`); finite.
    pub offset: [f32; 2],
    /// Factors of the texture coordinates (`-s`); finite.
    pub scale: [f32; 2],
    /// Factor of heights (`-bm`); finite.
    pub bump_multiplier: f32,
    /// Added to the numbers of the picture after multiplying them by `gain` (`-mm`); finite.
    pub base: f32,
    /// Factor of the numbers of the picture (`-mm`); finite.
    pub gain: f32,
    /// Which number of a texel is meant (`-imfchan`), where a texture is a single number.
    pub channel: Option<TextureChannel>,
}

/// A number of a texel (`-imfchan`).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum TextureChannel {
    /// Red.
    Red,
    /// Green.
    Green,
    /// Blue.
    Blue,
    /// Opacity, which the manual calls matte.
    Alpha,
    /// The mean of red, green and blue.
    Luminance,
}

impl TextureChannel {
    /// The name in JSON, in lower case.
    pub fn name(self) -> &'static str {
        match self {
            Self::Red => "red",
            Self::Green => "green",
            Self::Blue => "blue",
            Self::Alpha => "alpha",
            Self::Luminance => "luminance",
        }
    }
}

impl FileTexture {
    /// A repeated texture at the texture coordinates of the mesh.
    pub fn new(file: impl Into<String>) -> Self {
        Self {
            file: file.into(),
            clamp: false,
            offset: [0.0; 2],
            scale: [1.0; 2],
            bump_multiplier: 1.0,
            base: 0.0,
            gain: 1.0,
            channel: None,
        }
    }
}

/// What a texture of a material means.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum TextureRole {
    /// Diffuse colour (`map_Kd`).
    Diffuse,
    /// Opacity (`map_d`).
    Opacity,
    /// Colour of highlights (`map_Ks`).
    Specular,
    /// Emitted light (`map_Ke`).
    Emissive,
    /// Heights (`map_Bump`, `bump`).
    Bump,
    /// Normals in tangent space (`norm`).
    Normal,
    /// Roughness (`map_Pr`).
    Roughness,
    /// Metallicity (`map_Pm`).
    Metallic,
}

impl TextureRole {
    /// All, in the order of the fields of [`FileTextures`].
    pub const ALL: [Self; 8] = [
        Self::Diffuse,
        Self::Opacity,
        Self::Specular,
        Self::Emissive,
        Self::Bump,
        Self::Normal,
        Self::Roughness,
        Self::Metallic,
    ];

    /// Is it a single number, not a colour or a direction?
    pub fn is_number(self) -> bool {
        matches!(self, Self::Opacity | Self::Bump | Self::Roughness | Self::Metallic)
    }

    /// The name in messages and in JSON, in lower case.
    pub fn name(self) -> &'static str {
        match self {
            Self::Diffuse => "diffuse",
            Self::Opacity => "opacity",
            Self::Specular => "specular",
            Self::Emissive => "emissive",
            Self::Bump => "bump",
            Self::Normal => "normal",
            Self::Roughness => "roughness",
            Self::Metallic => "metallic",
        }
    }
}

/// The textures of a material that are drawn, at most one for each role.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FileTextures {
    /// Diffuse colour.
    pub diffuse: Option<FileTexture>,
    /// Opacity.
    pub opacity: Option<FileTexture>,
    /// Colour of highlights.
    pub specular: Option<FileTexture>,
    /// Emitted light.
    pub emissive: Option<FileTexture>,
    /// Heights, in practice often normals.
    pub bump: Option<FileTexture>,
    /// Normals in tangent space.
    pub normal: Option<FileTexture>,
    /// Roughness.
    pub roughness: Option<FileTexture>,
    /// Metallicity.
    pub metallic: Option<FileTexture>,
}

impl FileTextures {
    /// The texture of a role.
    pub fn get(&self, role: TextureRole) -> Option<&FileTexture> {
        match role {
            TextureRole::Diffuse => &self.diffuse,
            TextureRole::Opacity => &self.opacity,
            TextureRole::Specular => &self.specular,
            TextureRole::Emissive => &self.emissive,
            TextureRole::Bump => &self.bump,
            TextureRole::Normal => &self.normal,
            TextureRole::Roughness => &self.roughness,
            TextureRole::Metallic => &self.metallic,
        }
        .as_ref()
    }

    /// The place of the texture of a role.
    pub fn get_mut(&mut self, role: TextureRole) -> &mut Option<FileTexture> {
        match role {
            TextureRole::Diffuse => &mut self.diffuse,
            TextureRole::Opacity => &mut self.opacity,
            TextureRole::Specular => &mut self.specular,
            TextureRole::Emissive => &mut self.emissive,
            TextureRole::Bump => &mut self.bump,
            TextureRole::Normal => &mut self.normal,
            TextureRole::Roughness => &mut self.roughness,
            TextureRole::Metallic => &mut self.metallic,
        }
    }

    /// All textures with their roles, in the order of [`TextureRole::ALL`].
    pub fn iter(&self) -> impl Iterator<Item = (TextureRole, &FileTexture)> {
        TextureRole::ALL.into_iter().filter_map(|role| Some((role, self.get(role)?)))
    }
}
