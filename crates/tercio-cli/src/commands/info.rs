//! `tercio info`: describes a model file.

use std::fmt::Write;
use std::process::ExitCode;

use anyhow::Result;
use clap::Args;
use serde_json::{Value, json};
use tercio::glam::DVec3;
use tercio::image::Destination;
use tercio::mesh::topology::Topology;
use tercio::mesh::{Aabb, AttributeDomain, FileMaterial, FileTexture, TextureChannel, TextureRole};
use tercio::{AttributeSummary, Inspection, LoadOptions, LoadReport, Normals};

use crate::args::{ModelArgs, RunningArgs};
use crate::commands::render::models::time_of_file;
use crate::named_files::NamedFiles;
use crate::output::write_text;
use crate::progress::Display;
use crate::report::{self, grouped};
use crate::{ending, memory, messages};

/// What is described, and how.
type Row = (&'static str, String);

/// Describes what a model file contains.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  tercio info scan.ply.gz
  tercio info builtin:gyroid@100k --json

Exit code: 0 success, 1 error, 2 wrong usage.")]
pub struct Info {
    #[command(flatten)]
    model: ModelArgs,
    /// Writes JSON with stable keys.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    running: RunningArgs,
}

impl Info {
    /// Runs the command.
    ///
    /// # Errors
    /// What went wrong.
    pub fn run(&self) -> Result<ExitCode> {
        self.model.check_is_no_scene()?;
        let files = NamedFiles::default().reads_model(&self.model.model).prints();
        files.ready()?;
        ending::name_model(self.model.name());
        let pool = self.running.pool()?;
        // First, and in the same thread: what it takes is free again when the model is read.
        let (time, loaded) = pool.install(|| {
            let time = time_of_file(&self.model.model, self.running.memory_limit());
            (time.filter(|time| time.is_finite()), self.load())
        });
        let loaded = loaded?;
        let model = self.model.name();
        files.check_companions(&model, &loaded.report.read.companions)?;
        if !self.running.quiet {
            for warning in report::warnings(&loaded.report) {
                messages::warning(&format!("{model}: {warning}"));
            }
        }
        let text = if self.json {
            let mut value = json(&model, &loaded);
            value["time"] = time.into();
            format!("{value:#}\n")
        } else {
            text(&model, &loaded, time)
        };
        write_text(&Destination::Stdout, &text)?;
        Ok(ExitCode::SUCCESS)
    }

    fn load(&self) -> Result<Inspection> {
        let display = Display::new(self.running.progress_mode());
        let options = LoadOptions {
            memory_limit: self.running.memory_limit(),
            progress: Some(&display.progress),
            normals: Normals::File,
            details: true,
            ..LoadOptions::default()
        };
        Ok(options.inspect(&self.model.model)?)
    }
}

fn domain(domain: AttributeDomain) -> &'static str {
    match domain {
        AttributeDomain::Vertex => "vertex",
        AttributeDomain::Triangle => "triangle",
    }
}

fn texture_json(texture: &FileTexture) -> Value {
    json!({
        "file": texture.file,
        "clamp": texture.clamp,
        "offset": texture.offset,
        "scale": texture.scale,
        "bump_multiplier": texture.bump_multiplier,
        "base": texture.base,
        "gain": texture.gain,
        "channel": texture.channel.map(TextureChannel::name),
    })
}

/// The textures of a material, in words, each after a comma.
fn texture_list(material: &FileMaterial) -> String {
    let drawn = material.textures.iter().map(|(role, texture)| match role {
        TextureRole::Diffuse => format!(", texture {}", texture.file),
        _ => format!(", {} texture {}", role.name(), texture.file),
    });
    let others = material.other_textures.iter().map(|file| format!(", texture that is not drawn {file}"));
    drawn.chain(others).collect()
}

fn attributes_json(attributes: &[AttributeSummary]) -> Value {
    let attribute = |a: &AttributeSummary| {
        let full = |value: f32| match a.offset {
            0.0 => json!(value),
            offset => json!(offset + f64::from(value)),
        };
        json!({
            "name": a.name,
            "component": a.component,
            "of": domain(a.domain),
            "min": a.range.map(|r| full(r.0)),
            "max": a.range.map(|r| full(r.1)),
            "nans": a.nans,
        })
    };
    attributes.iter().map(attribute).collect()
}

fn material_json(m: &FileMaterial) -> Value {
    let textures = m.textures.iter().map(|(role, texture)| (role.name().to_owned(), texture_json(texture)));
    json!({
        "name": m.name,
        "diffuse": m.diffuse,
        "opacity": m.opacity,
        "illumination": m.illumination,
        "specular": m.specular,
        "shininess": m.shininess,
        "emissive": m.emissive,
        "roughness": m.roughness,
        "metallic": m.metallic,
        "diffuse_texture": m.textures.diffuse.as_ref().map(|t| &t.file),
        "textures": textures.collect::<serde_json::Map<_, _>>(),
        "other_textures": m.other_textures,
    })
}

fn json(model: &str, loaded: &Inspection) -> Value {
    let mut value = report::load_json(model, &loaded.report);
    value["tercio_version"] = env!("CARGO_PKG_VERSION").into();
    value["attributes"] = attributes_json(&loaded.report.attributes);
    value["lines_and_points"] = loaded.report.strokes.as_ref().map_or(Value::Null, |strokes| {
        json!({
            "bounds": report::bounds_json(&strokes.bounds),
            "colors": strokes.colors,
            "attributes": attributes_json(&strokes.attributes),
            "materials": strokes.materials.iter().map(material_json).collect::<Value>(),
        })
    });
    value["materials"] = loaded.materials.iter().map(material_json).collect();
    value["topology"] = topology(&loaded.report).map_or(Value::Null, |t| {
        json!({
            "closed": t.closed,
            "consistently_wound": t.consistently_wound,
            "boundary_edges": t.boundary_edges,
            "non_manifold_edges": t.non_manifold_edges,
            "flipped_edges": t.flipped_edges,
            "components": t.components,
        })
    });
    value["peak_memory_bytes"] = memory::peak_bytes().into();
    value
}

/// What is known about edges; `None` for a model without triangles, which has none.
fn topology(report: &LoadReport) -> Option<&Topology> {
    report.topology.as_ref().filter(|_| report.mesh.triangles > 0)
}

/// The row of an attribute.
fn attribute(a: &AttributeSummary, of: &str) -> Row {
    let print = |value| tercio::data::printed(value, a.offset);
    let range = a.range.map_or("no numbers".into(), |(min, max)| format!("{} to {}", print(min), print(max)));
    let nans = if a.nans > 0 { format!(", {} NaN", grouped(a.nans)) } else { String::new() };
    let component = a.component.iter().map(|name| format!(" \"{name}\"")).collect::<String>();
    ("attribute", format!("{}{component} ({of}): {range}{nans}", a.name))
}

/// Rows of bounds, with their names.
fn extent(bounds: &Aabb, [corners, size_of]: [&'static str; 2]) -> Vec<Row> {
    if bounds.is_empty() {
        return vec![(corners, "none".into())];
    }
    let size = bounds.size();
    let point = |p: DVec3| report::point(p, size.max_element());
    vec![(corners, format!("{} to {}", point(bounds.min), point(bounds.max))), (size_of, point(size))]
}

fn text(model: &str, loaded: &Inspection, time: Option<f64>) -> String {
    let report = &loaded.report;
    let mesh = &report.mesh;
    let mut rows: Vec<Row> = vec![
        ("model", model.to_owned()),
        ("format", report.read.format.clone()),
        ("faces", grouped(report.read.faces)),
        ("triangles", grouped(mesh.triangles)),
        ("vertices", grouped(mesh.vertices)),
    ];
    if report.read.file_bytes > 0 {
        rows.insert(2, ("file size", report::size(report.read.file_bytes)));
    }
    rows.extend(time.map(|time| ("time", time.to_string())));
    if let Some(origin) = &report.prepared {
        let size = report::size(origin.file_bytes);
        rows.insert(1, ("prepared", format!("{size}, from {} by {}", origin.model, origin.program)));
    }
    // Where there are only lines and points, theirs follow.
    if mesh.triangles > 0 || report.strokes.is_none() {
        rows.extend(extent(&mesh.bounds, ["bounds", "size"]));
        let present = [
            (mesh.normals, "normals"),
            (mesh.vertex_colors, "vertex colours"),
            (mesh.face_colors, "face colours"),
            (mesh.texcoords, "texture coordinates"),
        ];
        let present: Vec<_> = present.iter().filter(|p| p.0).map(|p| p.1).collect();
        rows.push(("holds", if present.is_empty() { "positions only".into() } else { present.join(", ") }));
    }
    for material in &loaded.materials {
        rows.push(("material", format!("{}{}", material.name, texture_list(material))));
    }
    rows.extend(report.attributes.iter().map(|a| attribute(a, domain(a.domain))));
    if let Some(list) = report::translucent(&report.read.translucent) {
        rows.push(("not opaque", list));
    }
    if let Some(list) = report::lines_and_points(report) {
        rows.push(("besides", list));
    }
    if let Some(strokes) = &report.strokes {
        rows.extend(extent(&strokes.bounds, ["bounds of lines and points", "size of lines and points"]));
        if strokes.colors {
            rows.push(("holds", "colours of lines and points".into()));
        }
        // Textures are not drawn on them.
        rows.extend(strokes.materials.iter().map(|m| ("material of lines and points", m.name.clone())));
        rows.extend(strokes.attributes.iter().map(|a| attribute(a, "lines and points")));
    }
    if let Some(list) = report::not_drawn(&report::left(report)) {
        rows.push(("not drawn", list));
    }
    if mesh.triangles == 0 {
        rows.push(("topology", "none, there are no triangles".into()));
    }
    if let Some(t) = topology(report) {
        let branching = format!("no, {} non-manifold edges", grouped(t.non_manifold_edges));
        let open = match t.boundary_edges {
            0 => branching.clone(),
            n => format!("no, {} boundary edges", grouped(n)),
        };
        rows.push(("closed", if t.closed { "yes".into() } else { open }));
        let flipped = match t.flipped_edges {
            0 => branching,
            n => format!("no, {} edges have the same direction in two triangles", grouped(n)),
        };
        rows.push(("consistently wound", if t.consistently_wound { "yes".into() } else { flipped }));
        rows.push(("non-manifold edges", grouped(t.non_manifold_edges)));
        rows.push(("components", grouped(t.components)));
    }
    rows.extend(report::repairs(report).into_iter().map(|r| ("repaired", r)));
    rows.push(("memory", report::size(mesh.bytes)));
    let t = &report.times;
    rows.push((
        "times",
        format!(
            "read {:.1} ms, clean {:.1}, weld {:.1}, topology {:.1}, in all {:.1}",
            t.read, t.clean, t.weld, t.topology, t.total
        ),
    ));
    let width = rows.iter().map(|r| r.0.len()).max().unwrap_or(0);
    rows.iter().fold(String::new(), |mut text, (key, value)| {
        // Names of a file may have line breaks, and what terminals obey. Writing into a string cannot fail.
        let _ = writeln!(text, "{key:width$}  {}", value.replace(char::is_control, "?"));
        text
    })
}
