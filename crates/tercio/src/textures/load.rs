//! Loads the textures of a mesh and gives its instance materials.

use std::collections::{HashMap, HashSet};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use tercio_mesh::loops::prelude::*;
use tercio_mesh::{FileMaterial, FileTexture, Progress, TextureRole};
use tercio_scene::{AlphaMode, InstanceMaterials, Scene, Texture};

use super::TextureError;
use super::decode::{self, Needs};
use super::find::Finder;
use super::material::{self, Maps};
use super::wanted::{Job, Loaded, MOST_USES, Made, Stock, Wanted};

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
    /// Whether the scene is drawn unlit, so that all materials show their diffuse colour. Otherwise, those that state that
    /// they are not lit (`illum 0`) emit it.
    pub is_unlit: bool,
    /// Whether materials have their plain colours and opacities alone: no textures are loaded, and what else they state is ignored.
    pub is_plain: bool,
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
        let layout = mesh.layout();
        let has_textures = layout.texcoords && !self.is_plain;
        let stock = if has_textures { self.stock(&mesh.materials, folders, &mut report) } else { Vec::new() };
        let has_own_colors = layout.vertex_colors || layout.face_colors;
        // Colours of the mesh override those of materials, not their opacity.
        let states_more = |file| {
            !self.is_plain && material::states_more_than_a_colour(file)
                || has_own_colors && file.opacity < 1.0
        };
        let stated = mesh.materials.iter().any(states_more);
        if stated || stock.iter().any(|stock| !stock.loaded.is_empty()) {
            let first_texture = scene.textures.len();
            let mut textures = Textures { stock: &stock, numbers: HashMap::new(), options: self, scene };
            let surface = textures.scene.instances[instance].surface;
            let mut of_mesh = Vec::with_capacity(mesh.materials.len());
            let mut lit_nevertheless = 0;
            for file in &mesh.materials {
                let file = if self.is_plain { &material::plain(file) } else { file };
                let mut maps = textures.maps(file);
                // Colours of the mesh take the place of the material's, and are always lit.
                if maps.is_unlit && has_own_colors && maps.get(TextureRole::Diffuse).is_none() {
                    maps.is_unlit = false;
                    lit_nevertheless += 1;
                }
                let material = material::convert(file, &maps, &surface, self);
                of_mesh.push(textures.scene.materials.len() as u32);
                textures.scene.materials.push(material);
            }
            if lit_nevertheless > 0 {
                let materials = counted(lit_nevertheless, "material");
                report.warnings.push(format!(
                    "drew {materials} without light (illum 0) with the lit colours of the model"
                ));
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

    /// The pictures that the materials need, in the order in which a texture is looked for in them.
    fn stock(
        &self,
        materials: &[FileMaterial],
        folders: &[PathBuf],
        report: &mut TextureReport,
    ) -> Vec<Stock> {
        let mut problems = Problems::default();
        let mut wanted = Wanted::default();
        for material in materials {
            for role in TextureRole::ALL {
                let is_replaced = match role {
                    TextureRole::Opacity => self.ignores_alpha(),
                    TextureRole::Bump => material.textures.normal.is_some(),
                    _ => false,
                };
                if !is_replaced && let Some(texture) = self.texture(material, role) {
                    wanted.add(material, texture, role);
                }
            }
        }
        let loaded = self.pictures(&wanted, folders, report, &mut problems);
        let all = Stock { wanted, loaded };
        // Bumps are needed where there are no normals after all.
        let mut bumps = Wanted::default();
        let mut hidden_bumps = 0;
        for material in materials {
            let normals = self.texture(material, TextureRole::Normal);
            let (Some(normals), Some(bump)) = (normals, self.texture(material, TextureRole::Bump)) else {
                continue;
            };
            if all.texture(material, normals, TextureRole::Normal).is_none() {
                bumps.add(material, bump, TextureRole::Bump);
            } else if bump.file != normals.file {
                hidden_bumps += 1;
            }
        }
        if hidden_bumps > 0 {
            let materials = counted(hidden_bumps, "material");
            report
                .warnings
                .push(format!("did not draw the bumps of {materials} with normals, which replace them"));
        }
        let loaded = self.pictures(&bumps, folders, report, &mut problems);
        problems.warn(report);
        vec![all, Stock { wanted: bumps, loaded }]
    }

    /// The texture of a material in a role.
    fn texture<'m>(&self, material: &'m FileMaterial, role: TextureRole) -> Option<&'m FileTexture> {
        material::texture(material, role, self)
    }

    /// Finds and decodes the pictures. Returns, for each name that was found, its textures.
    fn pictures(
        &self,
        wanted: &Wanted,
        folders: &[PathBuf],
        report: &mut TextureReport,
        problems: &mut Problems,
    ) -> Loaded {
        let mut loaded = Loaded::new();
        if wanted.names.is_empty() {
            return loaded;
        }
        if folders.is_empty() {
            problems.not_looked_for += wanted.names.len() as u64;
            return loaded;
        }
        let mut failed = Vec::new();
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
                        problems.substitutes.push(format!(
                            "\"{}\" for \"{}\"",
                            shortened(&instead),
                            shortened(&name.file)
                        ));
                    }
                    let index = *by_path.entry(found.path.clone()).or_insert_with(|| {
                        files.push(Job { path: found.path, names: Vec::new(), uses: Vec::new() });
                        files.len() - 1
                    });
                    files[index].names.push(number);
                    if !name.uses.iter().all(|&needed| files[index].add(needed)) {
                        failed.push((number, TextureError::TooManyReadings { most: MOST_USES }));
                    }
                }
                Err(error) => failed.push((number, error)),
            }
        }
        let known: HashSet<PathBuf> = report.files.iter().cloned().collect();
        report.files.extend(files.iter().map(|job| job.path.clone()).filter(|path| !known.contains(path)));
        if let Some(progress) = self.progress {
            progress.begin("reading textures", files.len() as u64);
        }
        for batch in self.batches(files, &mut problems.kept_bytes, &mut failed) {
            let done: Vec<_> = batch.par_iter().map(|(job, needs)| self.decode(job, needs)).collect();
            for ((job, _), result) in batch.into_iter().zip(done) {
                match result {
                    Ok(made) => {
                        let name = &wanted.names[job.names[0]].file;
                        problems
                            .invisible
                            .extend(made.was_invisible.then(|| format!("\"{}\"", shortened(name))));
                        problems.short.extend(made.ends_early.then(|| format!("\"{}\"", shortened(name))));
                        job.names
                            .iter()
                            .for_each(|&number| drop(loaded.insert(number, made.textures.clone())));
                    }
                    Err(error) => failed.push((job.names[0], error)),
                }
            }
        }
        failed.sort_by_key(|(number, _)| *number);
        problems.failed.extend(
            failed
                .into_iter()
                .map(|(number, error)| format!("\"{}\" ({error})", shortened(&wanted.names[number].file))),
        );
        loaded
    }

    /// Groups of pictures that may be decoded at the same time without exceeding the memory limit; pictures that would exceed
    /// it alone are left out. This depends on the pictures and their order, not on the number of threads.
    /// `kept` are the bytes of textures, to which theirs are added.
    fn batches(
        &self,
        files: Vec<Job>,
        kept: &mut u64,
        failed: &mut Vec<(usize, TextureError)>,
    ) -> Vec<Vec<(Job, Needs)>> {
        let mut batches: Vec<Vec<(Job, Needs)>> = Vec::new();
        let mut in_batch = 0;
        for job in files {
            let needs = decode::needs_of_file(&job.path)
                .map(|needs| needs.of_textures(job.most_textures(), job.adjusts()));
            let needs = needs.and_then(|needs| needs.check(*kept, self.memory_limit).map(|()| needs));
            match needs {
                Ok(needs) => {
                    let left = self.memory_limit.map_or(u64::MAX, |limit| limit.saturating_sub(*kept));
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
                    *kept += needs.texture_bytes;
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

/// Puts textures into a scene, each once, when a material uses it.
struct Textures<'a> {
    stock: &'a [Stock],
    /// Numbers in the scene, by address.
    numbers: HashMap<*const Texture, u32>,
    options: &'a TextureOptions<'a>,
    scene: &'a mut Scene,
}

impl Textures<'_> {
    fn texture(&self, file: &FileMaterial, role: TextureRole) -> Option<&Arc<Texture>> {
        let stated = self.options.texture(file, role)?;
        self.stock.iter().find_map(|stock| stock.texture(file, stated, role))
    }

    /// The textures of a material.
    fn maps(&mut self, file: &FileMaterial) -> Maps {
        let mut maps = Maps::default();
        maps.is_unlit = material::is_unlit(file, self.options);
        let diffuse = file.textures.diffuse.as_ref();
        let diffuse_has_alpha =
            self.texture(file, TextureRole::Diffuse).is_some_and(|texture| !texture.is_opaque());
        for role in TextureRole::ALL {
            let is_hidden = match role {
                // Exporters name the diffuse texture once more when they mean its alpha, which is drawn already if it has
                // one; its colours are no opacity, unless one of them is named.
                TextureRole::Opacity => file.textures.opacity.as_ref().is_some_and(|stated| {
                    stated.channel.is_none() && diffuse.is_some_and(|d| d.file == stated.file)
                }),
                TextureRole::Bump => self.texture(file, TextureRole::Normal).is_some(),
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

/// What is wrong with the pictures of a model.
#[derive(Debug, Default)]
struct Problems {
    not_looked_for: u64,
    failed: Vec<String>,
    substitutes: Vec<String>,
    invisible: Vec<String>,
    short: Vec<String>,
    /// Bytes of the textures made so far.
    kept_bytes: u64,
}

impl Problems {
    fn warn(&self, report: &mut TextureReport) {
        if self.not_looked_for > 0 {
            let count = counted(self.not_looked_for, "texture");
            report.warnings.push(format!("did not look for {count}: the model comes without a folder"));
        }
        warn(report, "did not draw", &self.failed);
        warn(report, "took textures with another extension than is named:", &self.substitutes);
        warn(report, "drew what there is of textures whose files end early:", &self.short);
        warn(report, "ignored the alpha, which is 0 everywhere, of", &self.invisible);
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
