//! From the options to a scene and its cameras.

use std::sync::Arc;

use anyhow::{Context as _, Result, bail};
use tercio::annotate::ScalarBar;
use tercio::glam::DVec3;
use tercio::mesh::Aabb;
use tercio::mesh::io::ReadReport;
use tercio::mesh::strokes::Strokes;
use tercio::parallel::Communicator;
use tercio::parallel::parts::share_materials;
use tercio::raster::Outputs;
use tercio::raster::frame::FragmentLayout;
use tercio::scene::{Background, DataColors, Instance, Light, Scene, scene::Share};
use tercio::{LoadOptions, LoadedPart, band_bytes};

use super::annotate::Annotated;
use super::members::{self, OfModel};
use super::strokes::Drawable;
use super::subject::Subject;
use super::{Job, Loaded, Render};
use crate::args::annotation;
use crate::args::ranks::Drawers;
use crate::args::textures::TextureLimits;
use crate::output::{Plan, frame_bytes};
use crate::progress::Display;
use crate::series::pattern::{self, Names};
use crate::{ending, memory};

/// Do two scalar bars show the same?
fn is_same(a: &ScalarBar, b: &ScalarBar) -> bool {
    // What values are stored less is not seen.
    let drawn = |bar: &ScalarBar| DataColors { offset: 0.0, ..bar.colors.clone() };
    let words =
        |bar: &ScalarBar| (bar.title.clone(), bar.format, bar.place, bar.is_upright, bar.marks.clone());
    drawn(a) == drawn(b) && words(a) == words(b)
}

/// A model that was read, perhaps for several models of the picture.
pub(super) struct Opened {
    /// What was read, and how.
    key: String,
    pub loaded: tercio::Loaded,
    share: Option<Share>,
    strokes: Arc<Strokes>,
}

impl Render {
    /// Loads the models, or this rank's part of the one if there are `parts`, the ranks that load the others.
    pub(super) fn load(
        &self,
        job: &Job,
        display: &Display,
        mut parts: Option<&mut impl Communicator>,
    ) -> Result<Loaded> {
        let writing = &job.writing;
        // First, because it is read quickly: what is wrong with it should be known at once.
        if self.environment.is_given() {
            display.stage("reading the environment");
        }
        let panorama = match self.is_measured {
            false => self.environment.read(self.running.memory_limit())?,
            true => None,
        };
        let picture = self.picture_bytes(job);
        let (mut files, mut file_of) = (Vec::<Opened>::new(), Vec::new());
        let mut taken = 0u64;
        for member in self.members() {
            let key = member.key(job);
            let number = files.iter().position(|file| file.key == key);
            file_of.push(number.unwrap_or(files.len()));
            if number.is_none() {
                let opened = member.open(job, display, parts.as_deref_mut(), (key, taken))?;
                taken = taken.saturating_add(opened.loaded.report.mesh.bytes);
                member.check_memory(picture, taken)?;
                files.push(opened);
            }
        }
        // The first model says where up is.
        let camera = self.camera.for_format(&files[0].loaded.report.read.format);
        let mut scene = Scene { lights: Light::studio(), ..Scene::default() };
        let place = |panorama| self.environment.place(&panorama, camera.front());
        scene.environment = panorama.map(place).transpose()?;
        self.drawing.dress(&mut scene);
        self.members().for_each(|member| member.strokes.dress_background(&mut scene.background));
        let background = scene.background;
        if self.needs_transparency() {
            scene.background = Background::Solid([0.0; 4]);
        }
        let shadows = self.drawing.shadow_bytes(&scene);
        let up = camera.front().up;
        let is_drawing = job.writing.plan.drawing.is_some();
        let strokes = self.members().zip(&file_of).map(|(member, &number)| {
            let file = &files[number];
            member.strokes_of(file.loaded.whole.as_ref(), Arc::clone(&file.strokes))
        });
        let strokes = strokes.collect::<Result<Vec<_>>>()?;
        let colors = self.shared_colors((&files, &file_of), &strokes, up)?;
        let (mut models, mut bars): (Vec<OfModel>, Vec<ScalarBar>) = (Vec::new(), Vec::new());
        let drawn = self.members().zip(&file_of).zip(strokes).zip(&colors);
        for (((member, &number), strokes), colors) in drawn {
            let file = &files[number];
            let place = member.place.transform();
            let begin = scene.instances.len();
            let mut instance = Instance::new(Arc::clone(&file.loaded.mesh));
            instance.share = file.share;
            (instance.world_from_object, instance.surface) = (place, member.drawing.surface());
            let mut report = file.loaded.report.clone();
            let of_another = member.model.moment.and_then(|moment| self.series.other_time(moment));
            report.read.warnings.extend(of_another);
            let (mut data, notes) = match self.is_measured {
                false => {
                    let data = colors.apply(&mut instance, up, &strokes, parts.as_deref_mut());
                    data.with_context(|| member.model.name())?
                }
                true => Default::default(),
            };
            report.read.warnings.extend(notes);
            if instance.data.is_some() && !member.strokes.shows_data(is_drawing, !strokes.is_empty()) {
                (instance.data, data) = (None, None);
                report
                    .read
                    .warnings
                    .push("nothing shows the data of --color-by: edges have one colour in SVG and PDF, and with --edge-color".into());
            }
            member.strokes.dress_surface(&mut instance.surface, &background);
            member.dress_contours(&mut instance, is_drawing);
            let shows_nan = || colors.explains_others(&instance, data.as_ref(), parts.is_some());
            if let Some(mut bar) = member.annotation.bar(&instance, shows_nan) {
                if !std::ptr::eq(member, self) {
                    // Those of the first model may change from picture to picture.
                    let names = member.names_in(&Names::default());
                    bar.title = pattern::expand_text(&bar.title, &names, false).unwrap_or(bar.title);
                }
                match bars.iter_mut().find(|other| is_same(other, &bar)) {
                    Some(other) => other.shows_nan |= bar.shows_nan,
                    None => bars.push(bar),
                }
            }
            scene.instances.push(instance);
            // Layers of what is not opaque need memory, too.
            let left = |limit: u64| {
                limit.saturating_sub(picture.saturating_add(taken).saturating_add(shadows)) / 4 * 3
            };
            let limits = TextureLimits {
                memory: self.running.memory_limit().map(left),
                progress: &display.progress,
                specular: member.drawing.specular(),
                is_unlit: self.drawing.is_unlit(),
            };
            let textures = match self.is_measured {
                false => member.textures.load((&mut scene, begin), &member.model.model, &report, &limits),
                true => None,
            };
            if let Some(textures) = &textures {
                // They are not always where the model says.
                writing.files.check_companions(&member.model.name(), &textures.files)?;
                taken = taken.saturating_add(textures.bytes);
            }
            if scene.instances[begin].data.is_some() && member.placements.iter().any(|p| p.color.is_some()) {
                let text = "the colour of an instance has no effect: it has the colours of the model's data (color-by)";
                report.read.warnings.push(text.into());
            }
            let caps = member.clip.caps(&scene.instances[begin], file.loaded.caps.clone());
            scene.instances.extend(caps);
            let own = scene.instances[begin..].to_vec();
            for placement in &member.placements {
                let copies = own.iter().enumerate().map(|(k, instance)| placement.of(instance, k == 0));
                scene.instances.extend(copies);
            }
            let others = member.placements.iter().map(|placement| placement.place.transform() * place);
            models.push(OfModel {
                report,
                textures,
                shares_with: file_of[..models.len()].iter().position(|&other| other == number),
                places: std::iter::once(place).chain(others).collect(),
                instances: begin..scene.instances.len(),
                drawable: Drawable::of_file(strokes, data, &member.placements),
            });
        }
        if let Some(comm) = &mut parts {
            share_materials(*comm, &mut scene)?;
        }
        self.check_memory(picture.saturating_add(shadows), taken)?;
        for model in &mut models {
            let own = &scene.instances[model.instances.clone()];
            model.report.read.warnings.extend(self.drawing.shadow_warning(&scene, own));
        }
        for (member, model) in self.members().zip(&mut models) {
            let instance = &scene.instances[model.instances.start];
            member.find_strokes(
                &mut model.drawable,
                instance,
                &model.places,
                (is_drawing, picture.saturating_add(taken)),
            )?;
            if !is_drawing {
                member.put_edges_on(&mut scene.instances[model.instances.clone()], &mut model.drawable);
            }
        }
        let annotation = self.annotation.annotation(bars, &background);
        let mut subject = Subject::default();
        for ((model, &number), member) in models.iter().zip(&file_of).zip(self.members()) {
            let file = &files[number];
            let of_file = (file.loaded.whole.as_ref(), &*file.strokes);
            model.frame_in(&mut subject, &scene, of_file, &member.strokes);
        }
        let outline = self.is_measured.then(|| subject.outline());
        if let Some(outline) = &self.outline {
            subject.add_outline(outline);
        }
        let names = if annotation::has_braces(&annotation) { writing.names.clone() } else { Vec::new() };
        let mut annotated = Annotated { annotation, names, shot: 0, bounds: [DVec3::ZERO; 2], up: DVec3::Y };
        let cameras = self.cameras(
            &job.motion,
            &camera,
            (&scene, &subject),
            &annotated.of_picture(),
            parts.as_deref_mut(),
        )?;
        drop(subject);
        if self.annotation.is_behind() {
            let mut bounds = Aabb::EMPTY;
            for model in &models {
                bounds = bounds.union(model.model_box(&scene, &mut parts)?);
            }
            annotated.bounds = [bounds.min, bounds.max];
        }
        annotated.up = up;
        let mut look = self.drawing.look(&scene, &background, &self.environment, &self.effects);
        look["data"] = self.data.json(scene.instances.first());
        if let Some(camera) = cameras.first().and_then(|cameras| cameras.views.first()) {
            let laid_out = self.lay_out(&annotated, camera)?;
            look["annotation"] = annotation::json(&laid_out);
            let left_out = laid_out.left_out.iter().map(|what| format!("no room in the picture for: {what}"));
            models[0].report.read.warnings.extend(left_out);
        }
        let reports = self.model_reports(&models, &scene);
        let together = members::together(&models, &scene);
        Ok(Loaded { scene, models, outline, reports, together, background, look, annotated, cameras })
    }

    /// Whether two models are one that is loaded once.
    fn key(&self, job: &Job) -> String {
        let options = self.load_options(job, 0);
        let LoadOptions { normals, clip, make, step, .. } = options;
        format!("{:?} {normals:?} {clip:?} {make:?} {step:?}", self.model.model)
    }

    /// Options for loading when so many bytes are taken.
    fn load_options(&self, job: &Job, taken: u64) -> LoadOptions<'_> {
        LoadOptions {
            memory_limit: self.running.memory_limit().map(|limit| limit.saturating_sub(taken)),
            normals: self
                .data
                .normals(self.drawing.normals(job.writing.plan.outputs), self.strokes.glyph_vector()),
            clip: self.clip.clipping(),
            make: self.data.made(),
            step: self.model.moment.map(|moment| moment.number),
            ..LoadOptions::default()
        }
    }

    /// Reads this model.
    fn open(
        &self,
        job: &Job,
        display: &Display,
        parts: Option<&mut impl Communicator>,
        (key, taken): (String, u64),
    ) -> Result<Opened> {
        if taken > 0 {
            ending::name_model(self.model.name());
        }
        let options = LoadOptions { progress: Some(&display.progress), ..self.load_options(job, taken) };
        let plan = &job.writing.plan;
        let check = |read: &ReadReport| -> Result<()> {
            job.writing.files.check_companions(&self.model.name(), &read.companions)?;
            // Before the work on the mesh begins.
            Ok(self.check_surface(plan, read.faces > 0)?)
        };
        let (mut loaded, share) = match parts {
            None => (options.load_if(&self.model.model, check)?, None),
            Some(comm) => {
                let LoadedPart { loaded, share, .. } = options.load_part(comm, &self.model.model)?;
                check(&loaded.report.read)?;
                (loaded, Some(share))
            }
        };
        // Not all that has one counts its faces.
        self.check_surface(plan, !loaded.mesh.clusters().is_empty())?;
        let strokes = Arc::new(std::mem::take(&mut loaded.strokes));
        Ok(Opened { key, loaded, share, strokes })
    }

    /// Bytes of all pictures that are in memory at a time.
    fn picture_bytes(&self, job: &Job) -> u64 {
        let bytes = self.frame_bytes(&job.writing.plan, job.drawers);
        let waiting = if job.writing.is_series && !self.is_in_bands(&job.writing.plan, job.drawers) {
            bytes.saturating_mul(self.room(job) as u64)
        } else {
            0
        };
        bytes.saturating_add(waiting)
    }

    /// Bytes of the pictures of this process; with their keys if there are ranks. Ranks that composite samples keep
    /// fragments, too: how many is known only when they are drawn, but a full picture has one in each pixel. Ranks that send all
    /// pixels have them packed, and as many of others.
    pub(super) fn frame_bytes(&self, plan: &Plan, drawers: Drawers) -> u64 {
        if self.is_in_bands(plan, drawers) {
            return band_bytes(&self.drawing.settings(&self.tuning, &self.sampling, plan.outputs));
        }
        let (frames, keys) = drawers.frames();
        let packets = if drawers.sends_all() { 2 } else { 0 };
        let bytes = frame_bytes(Outputs { keys, ..plan.outputs }, self.drawing.size) * (1 + packets);
        let count = self.sampling.sampling().pattern.count();
        let mut fragments = 0;
        if count > 1 && drawers.composites() {
            let (width, height) = self.drawing.size;
            let pixels = u64::from(width) * u64::from(height);
            fragments = pixels.saturating_mul(FragmentLayout::new(&plan.outputs, false).bytes(count) as u64);
        }
        let further =
            frame_bytes(plan.outputs, self.drawing.size).saturating_mul(self.stereo.further_frames());
        let effects = self.effects.bytes(self.drawing.size);
        let bytes = bytes.saturating_mul(frames as u64).saturating_add(fragments);
        bytes.saturating_add(further).saturating_add(effects)
    }

    pub(super) fn check_memory(&self, picture: u64, model: u64) -> Result<()> {
        match self.running.memory_limit() {
            Some(limit) if picture.saturating_add(model) > limit => bail!(
                "{}: the picture needs {picture} bytes (with its shadow maps and effects) besides {model} for the model (with its textures), the limit is {limit} bytes ({})",
                self.model.name(),
                memory::limit_source()
            ),
            _ => Ok(()),
        }
    }
}
