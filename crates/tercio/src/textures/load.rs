//! Loads the textures of a mesh and gives its instance materials.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use rayon::prelude::*;
use tercio_mesh::{FileMaterial, FileTexture, Progress, TextureRole};
use tercio_scene::texture::Encoding;
use tercio_scene::{AlphaMode, InstanceMaterials, Scene, Texture};

use super::TextureError;
use super::decode::{self, Needs};
use super::find::Finder;
use super::material::{self, Maps};
use super::picture::Picture;

/// How materials and textures are loaded.
#[derive(Clone, Copy, Debug, Default)]
pub struct TextureOptions<'a> {
    /// Most bytes that textures and their decoding may take; `None` for no limit. Those that do not fit are left out.
    pub memory_limit: Option<u64>,
    /// Receives the progress of loading.
    pub progress: Option<&'a Progress>,
    /// What the alpha of textures means. [`AlphaMode::Opaque`] ignores it, and textures of the opacity, too; not the
    /// opacity of the material itself.
    pub alpha_mode: AlphaMode,
    /// Strength of all highlights, in place of those that the materials state.
    pub specular: Option<f32>,
}

/// What was loaded.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct TextureReport {
    /// Materials that were made: none if those of the mesh are plain colours.
    pub materials: u64,
    /// Textures that were made.
    pub textures: u64,
    /// Bytes of memory that they take.
    pub bytes: u64,
    /// The picture files that were found. An output must not overwrite any of them.
    pub files: Vec<PathBuf>,
    /// What is not drawn or drawn otherwise than stated, one sentence each, ready to be shown after "warning: MODEL: ".
    pub warnings: Vec<String>,
    /// Wall time in milliseconds.
    pub milliseconds: f64,
}

impl TextureOptions<'_> {
    /// Gives an instance of a scene the materials that its mesh names, with their textures, which are looked for in
    /// `folders` (see [`texture_folders`](crate::texture_folders)). What the materials do not state is taken from the
    /// instance's surface. The instance stays as it is if the materials of its mesh are nothing but plain colours.
    ///
    /// A picture is looked for by the path that the model names, relative to the file that names it; then, by its last
    /// component, there, beside the model, and in folders beside it that are called textures, texture, tex, maps or
    /// images, in upper or lower case; at last with another extension. Absolute paths are those of other machines: only the
    /// last component is used. Formats are PNG, JPEG, GIF, BMP, TGA, WebP and TIFF.
    ///
    /// A picture that is missing, broken or too large is reported, and the material drawn without it.
    ///
    /// ```
    /// let model = tercio::load("builtin:teapot@1k")?;
    /// let folders = tercio::texture_folders("builtin:teapot@1k", &model.report);
    /// let mut scene = tercio::Scene::from_mesh(model.mesh);
    /// let report = tercio::TextureOptions::default().load(&mut scene, 0, &folders);
    /// assert_eq!((report.materials, report.warnings.len()), (0, 0));
    /// # Ok::<(), tercio::Error>(())
    /// ```
    ///
    /// # Panics
    /// If the scene has no such instance.
    pub fn load(&self, scene: &mut Scene, instance: usize, folders: &[PathBuf]) -> TextureReport {
        let start = Instant::now();
        let mut report = TextureReport::default();
        let mesh = Arc::clone(&scene.instances[instance].mesh);
        // Textures are nowhere on a mesh without texture coordinates; `NotDrawn` counts them.
        let has_textures = mesh.layout().texcoords;
        let wanted = if has_textures { self.wanted(&mesh.materials, &mut report) } else { Wanted::default() };
        let loaded = self.pictures(&wanted, folders, &mut report);
        let stated = mesh.materials.iter().any(material::states_more_than_a_colour);
        if stated || !loaded.is_empty() {
            let first_texture = scene.textures.len();
            let mut textures = Textures { wanted: &wanted, loaded: &loaded, numbers: HashMap::new(), scene };
            let surface = textures.scene.instances[instance].surface;
            let mut of_mesh = Vec::with_capacity(mesh.materials.len());
            for file in &mesh.materials {
                let maps = if has_textures { textures.maps(file) } else { Maps::default() };
                let material = material::convert(file, &maps, &surface, self);
                of_mesh.push(textures.scene.materials.len() as u32);
                textures.scene.materials.push(material);
            }
            (report.materials, report.textures) = (of_mesh.len() as u64, textures.numbers.len() as u64);
            report.bytes = scene.textures[first_texture..].iter().map(|texture| texture.bytes() as u64).sum();
            let materials = InstanceMaterials::new(&mesh, of_mesh, scene);
            scene.instances[instance].materials = Some(materials);
        }
        report.milliseconds = start.elapsed().as_secs_f64() * 1e3;
        report
    }

    fn ignores_alpha(&self) -> bool {
        self.alpha_mode == AlphaMode::Opaque
    }

    /// The pictures that the materials need.
    fn wanted(&self, materials: &[FileMaterial], report: &mut TextureReport) -> Wanted {
        let mut wanted = Wanted::default();
        let mut hidden_bumps = 0;
        for material in materials {
            for (role, texture) in material.textures.iter() {
                let normals = material.textures.normal.as_ref();
                match role {
                    TextureRole::Opacity if self.ignores_alpha() => {}
                    TextureRole::Bump if normals.is_some() => {
                        hidden_bumps += u64::from(normals.is_some_and(|n| n.file != texture.file));
                    }
                    _ => wanted.add(material, texture, role),
                }
            }
        }
        if hidden_bumps > 0 {
            let materials = counted(hidden_bumps, "material");
            report
                .warnings
                .push(format!("did not draw the bumps of {materials} with normals, which replace them"));
        }
        wanted
    }

    /// Finds and decodes the pictures. Returns, for each name that was found, its textures; all that went wrong is
    /// reported.
    fn pictures(&self, wanted: &Wanted, folders: &[PathBuf], report: &mut TextureReport) -> Loaded {
        let mut loaded = Loaded::new();
        if wanted.names.is_empty() {
            return loaded;
        }
        if folders.is_empty() {
            let count = counted(wanted.names.len() as u64, "texture");
            report.warnings.push(format!("did not look for {count}: the model comes without a folder"));
            return loaded;
        }
        let (mut failed, mut substitutes) = (Vec::new(), Vec::new());
        // Several names may lead to the same file.
        let mut files: Vec<Job> = Vec::new();
        let mut by_path: HashMap<PathBuf, usize> = HashMap::new();
        let mut finder = Finder::new(folders);
        for (number, name) in wanted.names.iter().enumerate() {
            match finder.find(&name.folder, &name.file) {
                Ok(found) => {
                    if found.is_substitute {
                        let instead =
                            found.path.file_name().unwrap_or_default().to_string_lossy().into_owned();
                        substitutes.push(format!(
                            "\"{}\" for \"{}\"",
                            shortened(&instead),
                            shortened(&name.file)
                        ));
                    }
                    let index = *by_path.entry(found.path.clone()).or_insert_with(|| {
                        files.push(Job { path: found.path, names: Vec::new(), roles: Vec::new() });
                        files.len() - 1
                    });
                    files[index].names.push(number);
                    name.roles.iter().for_each(|&role| files[index].add(role));
                }
                Err(error) => failed.push((number, error)),
            }
        }
        report.files = files.iter().map(|job| job.path.clone()).collect();
        if let Some(progress) = self.progress {
            progress.begin("reading textures", files.len() as u64);
        }
        let mut invisible = Vec::new();
        for batch in self.batches(files, &mut failed) {
            let done: Vec<_> = batch.par_iter().map(|(job, needs)| self.decode(job, needs)).collect();
            for ((job, _), result) in batch.into_iter().zip(done) {
                match result {
                    Ok(made) => {
                        let name = &wanted.names[job.names[0]].file;
                        invisible.extend(made.was_invisible.then(|| format!("\"{}\"", shortened(name))));
                        job.names
                            .iter()
                            .for_each(|&number| drop(loaded.insert(number, made.textures.clone())));
                    }
                    Err(error) => failed.push((job.names[0], error)),
                }
            }
        }
        failed.sort_by_key(|(number, _)| *number);
        let failed: Vec<String> = failed
            .into_iter()
            .map(|(number, error)| format!("\"{}\" ({error})", shortened(&wanted.names[number].file)))
            .collect();
        warn(report, "did not draw", &failed);
        warn(report, "took textures with another extension than is named:", &substitutes);
        warn(report, "ignored the alpha, which is 0 everywhere, of", &invisible);
        loaded
    }

    /// Groups of pictures that may be decoded at the same time without exceeding the memory limit; pictures that would exceed
    /// it alone are left out. This depends on the pictures and their order, not on the number of threads.
    fn batches(&self, files: Vec<Job>, failed: &mut Vec<(usize, TextureError)>) -> Vec<Vec<(Job, Needs)>> {
        let mut batches: Vec<Vec<(Job, Needs)>> = Vec::new();
        let (mut kept, mut in_batch) = (0, 0);
        for job in files {
            let needs = decode::needs_of_file(&job.path).map(|needs| needs.of_textures(job.most_textures()));
            let needs = needs.and_then(|needs| needs.check(kept, self.memory_limit).map(|()| needs));
            match needs {
                Ok(needs) => {
                    let left = self.memory_limit.map_or(u64::MAX, |limit| limit.saturating_sub(kept));
                    match batches
                        .last_mut()
                        .filter(|_| in_batch + needs.decoding_bytes <= left - needs.texture_bytes)
                    {
                        Some(batch) => batch.push((job, needs)),
                        None => {
                            batches.push(vec![(job, needs)]);
                            in_batch = 0;
                        }
                    }
                    in_batch += needs.decoding_bytes;
                    kept += needs.texture_bytes;
                }
                Err(error) => {
                    self.advance();
                    failed.push((job.names[0], error));
                }
            }
        }
        batches
    }

    fn decode(&self, job: &Job, needs: &Needs) -> Result<Made, TextureError> {
        let picture = decode::decode_file(&job.path, needs);
        self.advance();
        Ok(job.make(picture?, self.ignores_alpha()))
    }

    fn advance(&self) {
        if let Some(progress) = self.progress {
            progress.advance(1);
        }
    }
}

/// The textures of each name that was found.
type Loaded = HashMap<usize, Vec<(Vec<TextureRole>, Arc<Texture>)>>;

/// A picture that materials name.
#[derive(Debug)]
struct Name {
    folder: String,
    file: String,
    roles: Vec<TextureRole>,
}

/// The pictures that materials name, each once.
#[derive(Debug, Default)]
struct Wanted {
    names: Vec<Name>,
    numbers: HashMap<(String, String), usize>,
}

impl Wanted {
    fn add(&mut self, material: &FileMaterial, texture: &FileTexture, role: TextureRole) {
        let number =
            *self.numbers.entry((material.folder.clone(), texture.file.clone())).or_insert_with(|| {
                self.names.push(Name {
                    folder: material.folder.clone(),
                    file: texture.file.clone(),
                    roles: Vec::new(),
                });
                self.names.len() - 1
            });
        let roles = &mut self.names[number].roles;
        if !roles.contains(&role) {
            roles.push(role);
        }
    }

    fn number(&self, material: &FileMaterial, texture: &FileTexture) -> Option<usize> {
        self.numbers.get(&(material.folder.clone(), texture.file.clone())).copied()
    }
}

/// A picture file, and what it is needed for.
#[derive(Debug)]
struct Job {
    path: PathBuf,
    /// The names that lead to it.
    names: Vec<usize>,
    roles: Vec<TextureRole>,
}

/// The textures of a picture.
struct Made {
    /// With the roles of each.
    textures: Vec<(Vec<TextureRole>, Arc<Texture>)>,
    /// Whether an alpha that is 0 everywhere was ignored.
    was_invisible: bool,
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

impl Job {
    fn add(&mut self, role: TextureRole) {
        if !self.roles.contains(&role) {
            self.roles.push(role);
        }
    }

    /// The number of textures that are made of the picture, at most.
    fn most_textures(&self) -> u64 {
        let has = |roles: &[TextureRole]| u64::from(self.roles.iter().any(|role| roles.contains(role)));
        has(&[TextureRole::Diffuse])
            + has(&[TextureRole::Specular, TextureRole::Emissive])
            + has(&[TextureRole::Normal, TextureRole::Roughness, TextureRole::Metallic])
            + has(&[TextureRole::Opacity])
            + has(&[TextureRole::Bump])
    }

    /// Each content that a role needs becomes one texture.
    fn make(&self, picture: Picture, ignores_alpha: bool) -> Made {
        let is_diffuse = self.roles.contains(&TextureRole::Diffuse);
        let was_invisible = is_diffuse && !ignores_alpha && picture.is_invisible();
        let has_alpha = !ignores_alpha && !picture.is_opaque() && !was_invisible;
        let content = |role| match role {
            TextureRole::Diffuse if has_alpha => Content::Colors,
            TextureRole::Diffuse | TextureRole::Specular | TextureRole::Emissive => Content::OpaqueColors,
            TextureRole::Opacity if picture.has_opacity_in_alpha() => Content::Alpha,
            TextureRole::Bump if !picture.holds_normals() => Content::NormalsOfHeights,
            _ => Content::Numbers,
        };
        let mut contents: Vec<(Content, Vec<TextureRole>)> = Vec::new();
        for &role in &self.roles {
            match contents.iter_mut().find(|(known, _)| *known == content(role)) {
                Some((_, roles)) => roles.push(role),
                None => contents.push((content(role), vec![role])),
            }
        }
        // The alpha is removed last.
        contents.sort_by_key(|(content, _)| *content == Content::OpaqueColors);
        let mut picture = picture;
        let mut textures = Vec::new();
        for (content, roles) in contents {
            let texture = match content {
                Content::Colors => picture.texture(Encoding::Srgb),
                Content::Numbers => picture.texture(Encoding::Linear),
                Content::Alpha => picture.texture_of_alpha(),
                Content::NormalsOfHeights => picture.normals_of_heights(),
                Content::OpaqueColors => {
                    picture = picture.into_opaque();
                    picture.texture(Encoding::Srgb)
                }
            };
            textures.push((roles, Arc::new(texture)));
        }
        Made { textures, was_invisible }
    }
}

/// Puts textures into a scene, each once, when a material uses it.
struct Textures<'a> {
    wanted: &'a Wanted,
    loaded: &'a Loaded,
    /// Numbers in the scene, by address.
    numbers: HashMap<*const Texture, u32>,
    scene: &'a mut Scene,
}

impl Textures<'_> {
    fn texture(&self, file: &FileMaterial, role: TextureRole) -> Option<&Arc<Texture>> {
        let texture = file.textures.get(role)?;
        let made = self.loaded.get(&self.wanted.number(file, texture)?)?;
        made.iter().find(|(roles, _)| roles.contains(&role)).map(|(_, texture)| texture)
    }

    /// The textures of a material.
    fn maps(&mut self, file: &FileMaterial) -> Maps {
        let mut maps = Maps::default();
        let diffuse_has_alpha =
            self.texture(file, TextureRole::Diffuse).is_some_and(|texture| !texture.is_opaque());
        for (role, stated) in file.textures.iter() {
            let is_hidden = match role {
                // Exporters name the diffuse texture once more when they mean its alpha, which is drawn already if it has
                // one; its colours are no opacity.
                TextureRole::Opacity => {
                    file.textures.diffuse.as_ref().is_some_and(|diffuse| diffuse.file == stated.file)
                }
                TextureRole::Bump => file.textures.normal.is_some(),
                _ => false,
            };
            let Some(texture) = self.texture(file, role).filter(|_| !is_hidden).cloned() else { continue };
            let next = self.scene.textures.len() as u32;
            let number = *self.numbers.entry(Arc::as_ptr(&texture)).or_insert(next);
            if number == next {
                self.scene.textures.push(texture);
            }
            maps.set(role, number);
        }
        maps.has_alpha = diffuse_has_alpha || maps.get(TextureRole::Opacity).is_some();
        maps
    }
}

/// Adds one warning for all of a list, which names the first few.
fn warn(report: &mut TextureReport, what: &str, list: &[String]) {
    const SHOWN: usize = 3;
    if list.is_empty() {
        return;
    }
    let dots = if list.len() > SHOWN { ", …" } else { "" };
    let first = list[..list.len().min(SHOWN)].join(", ");
    let textures = counted(list.len() as u64, "texture");
    report.warnings.push(if what.ends_with(':') {
        format!("{what} {first}{dots}")
    } else {
        format!("{what} {textures}: {first}{dots}")
    });
}

/// "1 texture", "2 textures".
fn counted(count: u64, what: &str) -> String {
    if count == 1 { format!("1 {what}") } else { format!("{count} {what}s") }
}

/// A name for a message.
fn shortened(name: &str) -> String {
    const MOST: usize = 100;
    match name.char_indices().nth(MOST) {
        Some((at, _)) => format!("{}…", &name[..at]),
        None => name.into(),
    }
}

#[cfg(test)]
mod tests;
