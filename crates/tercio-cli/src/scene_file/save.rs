//! `--save-scene`: the scene as a file.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use tercio::mesh::color::srgb_bytes;
use tercio::scene_file::{ModelTable, SceneFile, Setting, Table, Value};

use super::layers::{Given, Settings};
use super::{Member, paths};
use crate::commands::render::members::Placement;

/// The text of a scene file at `to`.
///
/// # Errors
/// Names that are no text; models from standard input.
pub fn text(picture: &Settings, members: &[Member], to: &Path) -> Result<String> {
    let folder = to.parent().unwrap_or(Path::new(""));
    let mut scene = SceneFile { settings: settings(picture, folder)?, models: Vec::new() };
    let name = |path: &Path| -> Result<Value> {
        if path == Path::new("-") {
            bail!("--save-scene: a model from standard input has no name for a file: name one");
        }
        Ok(Value::Text(utf8(paths::relative(path, folder).as_os_str())?))
    };
    let names = |files: &[PathBuf]| -> Result<Value> {
        Ok(Value::List(files.iter().map(|file| name(file)).collect::<Result<_>>()?))
    };
    match members {
        // The models of a batch or a series.
        [Member { files, settings: of_models, placements }] if files.len() > 1 && placements.is_empty() => {
            scene.settings.extend(settings(of_models, folder)?);
            scene.settings.push(setting("models", names(files)?));
        }
        _ => {
            for member in members {
                let mut table = ModelTable::default();
                table.settings.push(match &member.files[..] {
                    [file] => setting("file", name(file)?),
                    files => setting("files", names(files)?),
                });
                table.settings.extend(settings(&member.settings, folder)?);
                table.instances = member.placements.iter().map(instance).collect();
                scene.models.push(table);
            }
        }
    }
    let version = env!("CARGO_PKG_VERSION");
    let file = to.file_name().unwrap_or_default().to_string_lossy();
    Ok(format!("# Written by tercio {version}: tercio render {file} draws it again.\n{}", scene.to_toml()))
}

/// What is said about one run, not about the picture.
const OF_A_RUN: [&str; 6] = ["save-scene", "verbose", "quiet", "progress", "watch", "resume"];

fn setting(key: &str, value: Value) -> Setting {
    Setting { key: key.into(), value, line: 0 }
}

fn utf8(text: &OsStr) -> Result<String> {
    match text.to_str() {
        Some(text) => Ok(text.to_owned()),
        None => bail!("--save-scene: {} is not UTF-8, as scene files are", text.to_string_lossy()),
    }
}

fn settings(settings: &Settings, folder: &Path) -> Result<Vec<Setting>> {
    let mut all = Vec::new();
    for (name, given) in settings.iter().filter(|(name, _)| !OF_A_RUN.contains(name)) {
        let one = |text: &std::ffi::OsString| -> Result<Value> {
            let text = utf8(text)?;
            if paths::is_file(name, &text) {
                return Ok(Value::Text(utf8(paths::relative(Path::new(&text), folder).as_os_str())?));
            }
            Ok(Value::from_text(&text))
        };
        let value = match given {
            Given::Off => Value::Flag(false),
            Given::Flag => Value::Flag(true),
            Given::Values(values) => match &values[..] {
                [value] => one(value)?,
                // Numbers alone would be one value.
                values => Value::List(
                    values.iter().map(|value| Ok(Value::Text(utf8(value)?))).collect::<Result<_>>()?,
                ),
            },
        };
        all.push(setting(name, value));
    }
    Ok(all)
}

fn instance(placement: &Placement) -> Table {
    let mut settings: Vec<Setting> = Vec::new();
    for (name, text) in placement.place.texts() {
        settings.push(setting(name, Value::from_text(&text)));
    }
    if let Some(color) = placement.color {
        // Colours are read from 8 bits.
        let [r, g, b] = srgb_bytes(color);
        settings.push(setting("color", Value::Text(format!("#{r:02x}{g:02x}{b:02x}"))));
    }
    if let Some(opacity) = placement.opacity {
        settings.push(setting("opacity", Value::from_text(&opacity.to_string())));
    }
    if placement.no_mesh_colors {
        settings.push(setting("no-mesh-colors", Value::Flag(true)));
    }
    Table { settings, line: 0 }
}
