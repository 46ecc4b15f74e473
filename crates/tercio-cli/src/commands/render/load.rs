//! From the options to a scene and its cameras.

use anyhow::{Context as _, Result, bail};
use tercio::mesh::io::ReadReport;
use tercio::parallel::Communicator;
use tercio::parallel::parts::share_materials;
use tercio::raster::Outputs;
use tercio::raster::frame::fragments::fragment_bytes;
use tercio::scene::framing::Extent;
use tercio::scene::{Background, Scene};
use tercio::{LoadOptions, LoadedPart, band_bytes};

use super::annotate::Annotated;
use super::{Job, Loaded, Render};
use crate::args::annotation;
use crate::args::ranks::Drawers;
use crate::args::textures::TextureLimits;
use crate::memory;
use crate::output::{Plan, frame_bytes};
use crate::progress::Display;

impl Render {
    /// Loads the model, or this rank's part of it if there are `parts`, the ranks that load the others.
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
        let panorama = self.environment.read(self.running.memory_limit())?;
        let options = LoadOptions {
            memory_limit: self.running.memory_limit(),
            progress: Some(&display.progress),
            normals: self
                .data
                .normals(self.drawing.normals(writing.plan.outputs), self.strokes.glyph_vector()),
            clip: self.clip.clipping(),
            make: self.data.made(),
            ..LoadOptions::default()
        };
        let check = |read: &ReadReport| -> Result<()> {
            Ok(writing.files.check_companions(&self.model.name(), &read.companions)?)
        };
        let (loaded, share) = match &mut parts {
            None => (options.load_if(&self.model.model, check)?, None),
            Some(comm) => {
                let LoadedPart { loaded, share, .. } = options.load_part(*comm, &self.model.model)?;
                check(&loaded.report.read)?;
                (loaded, Some(share))
            }
        };
        let mut report = loaded.report;
        let picture = self.picture_bytes(job);
        self.check_memory(picture, report.mesh.bytes)?;
        let mut scene = Scene::from_mesh(loaded.mesh);
        scene.instances[0].share = share;
        let camera = self.camera.for_format(&report.read.format);
        let place = |panorama| self.environment.place(&panorama, camera.front());
        scene.environment = panorama.map(place).transpose()?;
        self.drawing.dress(&mut scene);
        let up = camera.front().up;
        let file = self.strokes_of(&mut report, loaded.strokes);
        let data = self.data.apply(&mut scene, up, &file, parts.as_deref_mut());
        let data = data.with_context(|| self.model.name())?;
        self.strokes.dress(&mut scene);
        let background = scene.background;
        if self.needs_transparency() {
            scene.background = Background::Solid([0.0; 4]);
        }
        // Layers of what is not opaque need memory, too.
        let shadows = self.drawing.shadow_bytes(&scene);
        let taken = picture.saturating_add(report.mesh.bytes).saturating_add(shadows);
        let left = |limit: u64| limit.saturating_sub(taken) / 4 * 3;
        let limits = TextureLimits {
            memory: self.running.memory_limit().map(left),
            progress: &display.progress,
            specular: self.drawing.specular(),
            is_unlit: self.drawing.is_unlit(),
        };
        let textures = self.textures.load(&mut scene, &self.model.model, &report, &limits);
        if let Some(textures) = &textures {
            // They are not always where the model says.
            writing.files.check_companions(&self.model.name(), &textures.files)?;
        }
        if let Some(comm) = &mut parts {
            share_materials(*comm, &mut scene)?;
        }
        let taken = report.mesh.bytes.saturating_add(textures.as_ref().map_or(0, |textures| textures.bytes));
        self.check_memory(picture.saturating_add(shadows), taken)?;
        self.clip.add_caps(&mut scene, loaded.caps);
        report.read.warnings.extend(self.drawing.shadow_warning(&scene));
        let annotation = self.annotation.annotation(&scene, &background);
        let whole = loaded.whole.as_ref();
        let drawable = self.drawable(&scene, (file, data), picture.saturating_add(taken))?;
        let framed = drawable.framed();
        let cameras = self.cameras(&job.motion, &camera, (&scene, &framed), whole, &annotation, parts)?;
        let bounds = scene.bounds().union(Extent::of_strokes(&framed).bounds());
        drop(framed);
        let up = (0..3).find(|&axis| up[axis] > 0.5).unwrap_or(1);
        let annotated = Annotated { annotation, bounds: [bounds.min, bounds.max], up };
        let mut look = self.drawing.look(&scene, &background, &self.environment, &self.effects);
        look["data"] = self.data.json(&scene);
        if let Some(camera) = cameras.first().and_then(|cameras| cameras.views.first()) {
            let laid_out = self.lay_out(&annotated, camera)?;
            look["annotation"] = annotation::json(&laid_out);
            let left_out = laid_out.left_out.iter().map(|what| format!("no room in the picture for: {what}"));
            report.read.warnings.extend(left_out);
        }
        Ok(Loaded { report, textures, scene, drawable, background, look, annotated, cameras })
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
    /// fragments, too: how many is known only when they are drawn, but a full picture has one in each pixel.
    pub(super) fn frame_bytes(&self, plan: &Plan, drawers: Drawers) -> u64 {
        if self.is_in_bands(plan, drawers) {
            return band_bytes(&self.drawing.settings(&self.tuning, &self.sampling, plan.outputs));
        }
        let (frames, keys) = drawers.frames();
        let bytes = frame_bytes(Outputs { keys, ..plan.outputs }, self.drawing.size);
        let count = self.sampling.sampling().pattern.count();
        let mut fragments = 0;
        if count > 1 && drawers.composites() {
            let (width, height) = self.drawing.size;
            let pixels = u64::from(width) * u64::from(height);
            fragments = pixels.saturating_mul(fragment_bytes(&plan.outputs, count) as u64);
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
