//! The pictures that materials name, and the textures that are made of them.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;

use tercio_mesh::{FileMaterial, FileTexture, TextureChannel, TextureRole};
use tercio_scene::Texture;
use tercio_scene::texture::Encoding;

use super::picture::Picture;

/// The textures of each name that was found.
pub type Loaded = HashMap<usize, Vec<(Vec<Use>, Arc<Texture>)>>;

/// Most uses of a picture that differ: each may need a texture of its own, and a model can state any number of them.
pub const MOST_USES: usize = 64;

/// What a picture is needed for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Use {
    role: TextureRole,
    /// What the numbers of the picture are multiplied by, and what is added then.
    gain: f32,
    base: f32,
    channel: Option<TextureChannel>,
}

impl Use {
    fn new(texture: &FileTexture, role: TextureRole) -> Self {
        let (gain, base) = match role {
            // The slope is scaled instead (`material::convert`), so that no height is cut off; what is added to all heights
            // does not change it.
            TextureRole::Bump | TextureRole::Normal => (1.0, 0.0),
            _ => (texture.gain, texture.base),
        };
        Self { role, gain, base, channel: texture.channel }
    }

    fn adjusts(&self) -> bool {
        self.channel.is_some() || (self.gain, self.base) != (1.0, 0.0)
    }
}

/// A picture that materials name.
#[derive(Debug)]
pub struct Name {
    pub folder: String,
    pub file: String,
    pub uses: Vec<Use>,
}

/// The pictures that materials name, each once.
#[derive(Debug, Default)]
pub struct Wanted {
    pub names: Vec<Name>,
    numbers: HashMap<(String, String), usize>,
}

impl Wanted {
    pub fn add(&mut self, material: &FileMaterial, texture: &FileTexture, role: TextureRole) {
        let number =
            *self.numbers.entry((material.folder.clone(), texture.file.clone())).or_insert_with(|| {
                self.names.push(Name {
                    folder: material.folder.clone(),
                    file: texture.file.clone(),
                    uses: Vec::new(),
                });
                self.names.len() - 1
            });
        let uses = &mut self.names[number].uses;
        let needed = Use::new(texture, role);
        // One more than a picture may have, so that the others are reported.
        if uses.len() <= MOST_USES && !uses.contains(&needed) {
            uses.push(needed);
        }
    }

    fn number(&self, material: &FileMaterial, texture: &FileTexture) -> Option<usize> {
        self.numbers.get(&(material.folder.clone(), texture.file.clone())).copied()
    }
}

/// The textures that were made of the pictures that were wanted.
#[derive(Debug)]
pub struct Stock {
    pub wanted: Wanted,
    pub loaded: Loaded,
}

impl Stock {
    pub fn texture(
        &self,
        material: &FileMaterial,
        texture: &FileTexture,
        role: TextureRole,
    ) -> Option<&Arc<Texture>> {
        let made = self.loaded.get(&self.wanted.number(material, texture)?)?;
        let needed = Use::new(texture, role);
        made.iter().find(|(uses, _)| uses.contains(&needed)).map(|(_, texture)| texture)
    }
}

/// A picture file, and what it is needed for.
#[derive(Debug)]
pub struct Job {
    pub path: PathBuf,
    /// The names that lead to it.
    pub names: Vec<usize>,
    pub uses: Vec<Use>,
}

/// The textures of a picture.
pub struct Made {
    /// With the uses of each.
    pub textures: Vec<(Vec<Use>, Arc<Texture>)>,
    /// Whether an alpha that is 0 everywhere was ignored.
    pub was_invisible: bool,
    /// Whether the file ends early.
    pub ends_early: bool,
}

/// What is made of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Content {
    Colors,
    OpaqueColors,
    Numbers,
    Alpha,
    NormalsOfHeights,
}

/// What is made of a picture: the content, gain, base and channel.
type Kind = (Content, f32, f32, Option<TextureChannel>);

impl Job {
    /// Adds a use; false if there are too many.
    pub fn add(&mut self, needed: Use) -> bool {
        if self.uses.contains(&needed) {
            return true;
        }
        let has_room = self.uses.len() < MOST_USES;
        self.uses.extend(has_room.then_some(needed));
        has_room
    }

    /// Is a changed copy of the picture made?
    pub fn adjusts(&self) -> bool {
        self.uses.iter().any(Use::adjusts)
    }

    /// The number of textures that are made of the picture, at most.
    pub fn most_textures(&self) -> u64 {
        // Roles of one group need the same content.
        let group = |role| match role {
            TextureRole::Diffuse => 0,
            TextureRole::Specular | TextureRole::Emissive => 1,
            TextureRole::Normal | TextureRole::Roughness | TextureRole::Metallic => 2,
            TextureRole::Opacity => 3,
            TextureRole::Bump => 4,
        };
        let kind = |u: &Use| (group(u.role), u.gain, u.base, u.channel);
        let is_first = |(i, u): (usize, &Use)| !self.uses[..i].iter().any(|v| kind(v) == kind(u));
        self.uses.iter().enumerate().filter(|&of| is_first(of)).count() as u64
    }

    /// Each content that a use needs becomes one texture.
    pub fn make(&self, picture: Picture, ignores_alpha: bool) -> Made {
        let is_diffuse = self.uses.iter().any(|u| u.role == TextureRole::Diffuse);
        let ends_early = picture.ends_early;
        let was_invisible = is_diffuse && !ignores_alpha && picture.is_invisible();
        let has_alpha = !ignores_alpha && !picture.is_opaque() && !was_invisible;
        let content = |u: Use| match u.role {
            TextureRole::Diffuse if has_alpha => Content::Colors,
            TextureRole::Diffuse | TextureRole::Specular | TextureRole::Emissive => Content::OpaqueColors,
            TextureRole::Opacity if u.channel.is_none() && picture.has_opacity_in_alpha() => Content::Alpha,
            // Directions are not in a single channel.
            TextureRole::Bump if u.channel.is_some() || !picture.holds_normals() => Content::NormalsOfHeights,
            _ => Content::Numbers,
        };
        let mut kinds: Vec<(Kind, Vec<Use>)> = Vec::new();
        for &u in &self.uses {
            let kind = (content(u), u.gain, u.base, u.channel);
            match kinds.iter_mut().find(|(known, _)| *known == kind) {
                Some((_, uses)) => uses.push(u),
                None => kinds.push((kind, vec![u])),
            }
        }
        // The alpha is removed last, and changed copies are made before.
        kinds.sort_by_key(|((content, ..), uses)| *content == Content::OpaqueColors && !uses[0].adjusts());
        let mut picture = picture;
        let mut textures = Vec::new();
        for ((content, gain, base, channel), uses) in kinds {
            let texture = if uses[0].adjusts() {
                // The copy has the alpha as numbers.
                let (source, content) = match content {
                    Content::Alpha => (Some(TextureChannel::Alpha), Content::Numbers),
                    _ => (channel, content),
                };
                made(&picture.adjusted(source, gain, base), content)
            } else if content == Content::OpaqueColors {
                picture = picture.into_opaque();
                picture.texture(Encoding::Srgb)
            } else {
                made(&picture, content)
            };
            textures.push((uses, Arc::new(texture)));
        }
        Made { textures, was_invisible, ends_early }
    }
}

/// A texture of a picture.
fn made(picture: &Picture, content: Content) -> Texture {
    match content {
        Content::Colors => picture.texture(Encoding::Srgb),
        Content::OpaqueColors => picture.clone().into_opaque().texture(Encoding::Srgb),
        Content::Numbers => picture.texture(Encoding::Linear),
        Content::Alpha => picture.texture_of_alpha(),
        Content::NormalsOfHeights => picture.normals_of_heights(),
    }
}
