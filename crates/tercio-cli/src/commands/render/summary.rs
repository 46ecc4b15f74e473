//! What a run says about itself: messages and `--stats`.

use std::time::Instant;

use anyhow::Result;
use serde_json::{Value, json};
use tercio::raster::FrameStats;
use tercio::scene::UpAxis;

use super::members::ModelReport;
use super::{Done, Job, Render, Shot};
use crate::{memory, messages, organisation, output, report, stereo};

impl Render {
    pub(super) fn print_summary(&self, done: &Done) {
        if self.running.quiet {
            return;
        }
        self.print_warnings(&done.models);
        self.print_views(done);
    }

    /// Warnings about the models.
    pub(super) fn print_warnings(&self, models: &[ModelReport]) {
        if !self.running.quiet {
            self.members().zip(models).for_each(|(member, of_model)| member.print_warnings_of(of_model));
        }
    }

    fn print_warnings_of(&self, ModelReport { report: of_model, textures, .. }: &ModelReport) {
        let model = self.model.name();
        let of_textures = textures.iter().flat_map(|textures| textures.warnings.clone());
        for warning in report::warnings(of_model).into_iter().chain(of_textures) {
            messages::warning(&format!("{model}: {warning}"));
        }
        // For a model without triangles, the error lists its other content.
        let left = report::left(of_model);
        if let Some(list) = report::not_drawn(&left)
            && (of_model.mesh.triangles > 0 || of_model.lines + of_model.points > 0)
        {
            let drawn = report::drawn(of_model, &left);
            messages::warning(&format!("{model}: not drawn: {list} ({drawn})"));
        }
        if let Some(why) = report::unused_crease_angle(self.drawing.crease_angle, of_model) {
            messages::warning(&format!("{model}: {why}"));
        }
    }

    /// Warnings about pictures, and details.
    pub(super) fn print_views(&self, done: &Done) {
        if self.running.quiet {
            return;
        }
        let model = self.model.name();
        if let Some(reason) = done.empty.as_ref().filter(|_| self.writing.allow_empty) {
            messages::warning(&format!("{model}: {reason}"));
        }
        let blind = done.shots.iter().find_map(|shot| Some((shot.number, stereo::blind_eye(&shot.views)?)));
        if let Some((number, eye)) = blind {
            let place = if done.shots.len() > 1 { format!(" in picture {number}") } else { String::new() };
            messages::warning(&format!("{model}: the {eye} eye sees nothing of the model{place}"));
        }
        let empty: Vec<&Shot> = done.shots.iter().filter(|shot| shot.empty.is_some()).collect();
        if let (Some(first), None) = (empty.first(), &done.empty) {
            let (number, count, all) = (first.number, empty.len(), done.shots.len());
            let reason = first.empty.as_deref().unwrap_or_default();
            messages::warning(&format!(
                "{model}: {count} of {all} pictures show nothing of the model, picture {number} is the first: {reason}"
            ));
        }
        if self.running.verbose {
            if !self.camera.has_up_axis()
                && self.camera.for_format(&done.models[0].report.read.format).up_axis() == UpAxis::Z
            {
                messages::note("z is up, as in other programs for models of this format (--up-axis)");
            }
            self.origin.notes.iter().for_each(|note| messages::note(note));
            self.members().zip(&done.models).for_each(|(member, of_model)| {
                print_loading(of_model, (!self.others.is_empty()).then(|| member.model.name()));
            });
            print_details(done);
        }
    }

    /// The counts and times of a run. A series has those of all pictures together, and `pictures` with those of each.
    pub(super) fn stats(&self, job: &Job, done: &Done, threads: usize, start: Instant) -> Result<Value> {
        let frame = done.frames();
        let (width, height) = self.written_size();
        let only = done.shots.first().filter(|_| !job.writing.is_series);
        // Those of eyes are with the eyes.
        let parallel = only.filter(|shot| shot.cameras.stereo.is_none()).and_then(|shot| shot.views.first());
        let mut stats = json!({
            "tercio_version": env!("CARGO_PKG_VERSION"),
            "load": report::load_json(&self.model.name(), &done.models[0].report),
            "textures": done.models[0].textures.as_ref().map(report::textures_json),
            "models": done.models.iter().map(|model| &model.json).collect::<Vec<_>>(),
            "camera": only.map(|shot| report::camera_json(&shot.cameras.middle)),
            "stereo": only.map(|shot| stereo::json(self.stereo.layout(), &shot.cameras, &shot.views)),
            "picture": {
                "width": width,
                "height": height,
                "anti_aliasing": self.sampling.json(),
            },
            "look": done.look,
            "strokes": self.strokes.json(),
            "frame": serde_json::to_value(&frame)?,
            "parallel": parallel.map(|view| &view.parallel),
            "choice": done.choice.as_ref().map(organisation::json),
            "threads": threads,
            "simd": frame.simd,
            "effect_milliseconds": done.shots.iter().map(|shot| shot.effect_milliseconds).sum::<f64>(),
            "output_milliseconds": done.output_milliseconds,
            "total_milliseconds": start.elapsed().as_secs_f64() * 1e3,
            "peak_memory_bytes": memory::peak_bytes(),
        });
        if job.writing.is_series {
            let pictures = done.shots.iter().map(|shot| self.shot_json(job, shot));
            stats["pictures"] = pictures.collect();
            stats["pictures_found"] = done.found.into();
        }
        Ok(stats)
    }

    /// One picture of a series.
    fn shot_json(&self, job: &Job, shot: &Shot) -> Value {
        let plan = &job.writing.pictures[shot.number];
        let parallel = shot.views.first().filter(|_| shot.cameras.stereo.is_none());
        json!({
            "number": shot.number,
            "files": plan.files().map(|(_, file)| output::name(file)).collect::<Vec<_>>(),
            "empty": shot.empty,
            "camera": report::camera_json(&shot.cameras.middle),
            "stereo": stereo::json(self.stereo.layout(), &shot.cameras, &shot.views),
            "frame": stereo::together(&shot.views),
            "parallel": parallel.map(|view| &view.parallel),
            "effect_milliseconds": shot.effect_milliseconds,
        })
    }

    /// Width and height of a picture that is written.
    pub(super) fn written_size(&self) -> (u32, u32) {
        self.stereo.picture_size(self.drawing.size).unwrap_or(self.drawing.size)
    }
}

impl Done {
    /// Counts and times of all frames together.
    fn frames(&self) -> FrameStats {
        let all = self.shots.iter().map(|shot| stereo::together(&shot.views));
        all.reduce(|all, stats| all.plus(&stats)).unwrap_or_default()
    }
}

/// What was loaded of a model; with its name, if there are several.
fn print_loading(ModelReport { report, textures, .. }: &ModelReport, name: Option<String>) {
    let times = &report.times;
    messages::note(&format!(
        "{}{}: {}, {}; read {:.1} ms, clean {:.1}, weld {:.1}, normals {:.1}, clusters {:.1}",
        name.map_or_else(String::new, |name| format!("{name}: ")),
        report.read.format,
        report::counted(report.mesh.triangles, "triangle"),
        report::counted(report.mesh.vertices, "vertex"),
        times.read,
        times.clean,
        times.weld,
        times.normals,
        times.partition,
    ));
    report::repairs(report).iter().for_each(|r| messages::note(r));
    if let Some(textures) = textures.as_ref().filter(|textures| textures.textures > 0) {
        messages::note(&format!(
            "{} in {} read in {:.1} ms",
            report::counted(textures.textures, "texture"),
            report::size(textures.bytes),
            textures.milliseconds
        ));
    }
    report::clipped(report).iter().for_each(|c| messages::note(c));
}

fn print_details(done: &Done) {
    let Done { shots, output_milliseconds, .. } = done;
    done.choice.iter().for_each(organisation::print);
    // Those of the first picture stand for all of a series.
    let first = shots.first().map_or(&[][..], |shot| &shot.views);
    for frame in first.iter().flat_map(|view| &view.parallel) {
        messages::note(&format!(
            "{} ranks, {}, sent {} with {} bytes",
            frame.ranks.len(),
            frame.organisation,
            report::counted(frame.messages, "message"),
            report::grouped(frame.bytes)
        ));
        let tables = report::table_of_ranks(frame).into_iter().chain(report::tables_of_partners(frame));
        tables.for_each(|line| messages::note(&line));
    }
    let stats = &done.frames();
    if shots.len() > 1 {
        messages::note(&format!(
            "{} drawn, {} found",
            report::counted(shots.len() as u64, "picture"),
            done.found
        ));
    }
    // Drawings of lines have no pixels, and nothing was rasterized.
    if stats.simd.is_empty() {
        messages::note(&format!(
            "drawn in {:.1} ms ({}), written in {output_milliseconds:.1} ms",
            stats.milliseconds.total,
            report::counted(stats.threads as u64, "thread"),
        ));
        return;
    }
    messages::note(&format!(
        "drawn in {:.1} ms ({}, {}): {} set up (counted once a tile and once a clipped \
         piece), {} covered, overdraw {:.2}; written in {output_milliseconds:.1} ms",
        stats.milliseconds.total,
        report::counted(stats.threads as u64, "thread"),
        stats.simd,
        report::counted(stats.frontend.triangles_out + stats.backend.triangles_drawn, "triangle"),
        report::counted(stats.backend.pixels_visible, "pixel"),
        stats.backend.overdraw,
    ));
}
