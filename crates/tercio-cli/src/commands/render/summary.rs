//! What a run says about itself: messages and `--stats`.

use std::time::Instant;

use anyhow::Result;
use serde_json::{Value, json};

use super::{Done, Render};
use crate::{memory, messages, organisation, report, stereo};

impl Render {
    pub(super) fn print_summary(&self, done: &Done) {
        if self.running.quiet {
            return;
        }
        let model = self.model.name();
        let of_textures = done.textures.iter().flat_map(|textures| textures.warnings.clone());
        for warning in report::warnings(&done.report).into_iter().chain(of_textures) {
            messages::warning(&format!("{model}: {warning}"));
        }
        // For a model without triangles, the error lists its other content.
        if let Some(list) = report::not_drawn(&report::left(&done.report))
            && (done.report.mesh.triangles > 0 || done.empty.is_none())
        {
            let drawn = report::drawn(&report::left(&done.report));
            messages::warning(&format!("{model}: not drawn: {list} ({drawn})"));
        }
        if let Some(why) = report::unused_crease_angle(self.drawing.crease_angle, &done.report) {
            messages::warning(&format!("{model}: {why}"));
        }
        if let Some(reason) = done.empty.as_ref().filter(|_| self.writing.allow_empty) {
            messages::warning(&format!("{model}: {reason}"));
        }
        if let Some(eye) = stereo::blind_eye(&done.views) {
            messages::warning(&format!("{model}: the {eye} eye sees nothing of the model"));
        }
        if self.running.verbose {
            print_details(done);
        }
    }

    pub(super) fn stats(&self, done: &Done, threads: usize, start: Instant) -> Result<Value> {
        let frame = stereo::together(&done.views);
        let (width, height) = self.stereo.picture_size(self.drawing.size).unwrap_or(self.drawing.size);
        // Those of eyes are with the eyes.
        let parallel =
            done.views.first().filter(|_| done.cameras.stereo.is_none()).map(|view| &view.parallel);
        Ok(json!({
            "tercio_version": env!("CARGO_PKG_VERSION"),
            "load": report::load_json(&self.model.name(), &done.report),
            "textures": done.textures.as_ref().map(report::textures_json),
            "camera": report::camera_json(&done.cameras.middle),
            "stereo": stereo::json(self.stereo.layout(), &done.cameras, &done.views),
            "picture": {
                "width": width,
                "height": height,
                "anti_aliasing": self.sampling.json(),
            },
            "look": done.look,
            "strokes": self.strokes.json(),
            "frame": serde_json::to_value(&frame)?,
            "parallel": parallel,
            "choice": done.choice.as_ref().map(organisation::json),
            "threads": threads,
            "simd": frame.simd,
            "effect_milliseconds": done.effect_milliseconds,
            "output_milliseconds": done.output_milliseconds,
            "total_milliseconds": start.elapsed().as_secs_f64() * 1e3,
            "peak_memory_bytes": memory::peak_bytes(),
        }))
    }
}

fn print_details(done: &Done) {
    let Done { report, textures, views, output_milliseconds, .. } = done;
    let times = &report.times;
    messages::note(&format!(
        "{}: {}, {}; read {:.1} ms, clean {:.1}, weld {:.1}, normals {:.1}, clusters {:.1}",
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
    done.choice.iter().for_each(organisation::print);
    for frame in views.iter().flat_map(|view| &view.parallel) {
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
    let stats = &stereo::together(views);
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
