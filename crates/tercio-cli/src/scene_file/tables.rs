//! Scene files.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, anyhow, bail};
use tercio::scene_file::{ModelTable, SceneFile, Setting, Table, Value};

use super::definition::{Class, Definition};
use super::layers::Settings;
use super::{Member, paths};
use crate::args::values;
use crate::commands::render::members::Placement;

/// The largest scene file or configuration.
const LARGEST: u64 = 64 << 20;

/// What a scene file says.
pub struct Scene {
    /// Those of the picture, and those for all models.
    pub settings: Settings,
    pub members: Vec<Member>,
}

/// The bytes of a file of settings.
///
/// # Errors
/// One that cannot be read, or is too large.
pub fn bytes(path: &Path) -> Result<Vec<u8>> {
    let name = || path.display().to_string();
    let length = std::fs::metadata(path).with_context(name)?.len();
    if length > LARGEST {
        bail!("{}: {length} bytes are no file of settings, the limit is {LARGEST}", name());
    }
    std::fs::read(path).with_context(name)
}

/// Where the tables of a file are from, for messages and for the names of files in them.
#[derive(Clone, Copy)]
pub struct Source<'a> {
    pub path: &'a Path,
}

impl Source<'_> {
    /// An error at a line.
    pub fn wrong(&self, Setting { line, key, .. }: &Setting, reason: &str) -> anyhow::Error {
        anyhow!("{}: line {line}: {key}: {reason}", self.path.display())
    }

    /// The folder that names of files are relative to.
    pub fn folder(&self) -> &Path {
        self.path.parent().unwrap_or(Path::new(""))
    }

    /// Adds a setting to others; two names of one option are a mistake.
    pub fn add(&self, setting: &Setting, to: &mut Settings, definition: &mut Definition) -> Result<()> {
        let value = paths::resolved(&setting.key, &setting.value, self.folder(), definition);
        let given = definition.given(&setting.key, &value);
        let (name, given) = given.map_err(|reason| self.wrong(setting, &reason))?;
        if to.get(&name).is_some() {
            return Err(self.wrong(setting, &format!("{name} is said twice")));
        }
        to.set(&name, given);
        Ok(())
    }

    /// Adds a setting of a picture or of all its models; `others` are keys that are no options.
    ///
    /// # Errors
    /// As [`Source::add`]; a setting that no file has.
    pub fn add_any(
        &self,
        setting: &Setting,
        to: &mut Settings,
        definition: &mut Definition,
        others: &[&str],
    ) -> Result<()> {
        let class = definition.class_or_like(&setting.key, others);
        if class.map_err(|reason| self.wrong(setting, &reason))? == Class::CommandLine {
            return Err(self.wrong(setting, "is said on the command line only"));
        }
        self.add(setting, to, definition)
    }
}

/// Reads a scene file.
///
/// # Errors
/// What is wrong, with file and line.
pub fn read(path: &Path, definition: &mut Definition) -> Result<Scene> {
    let source = Source { path };
    let scene = SceneFile::read(&bytes(path)?).with_context(|| path.display().to_string())?;
    let mut settings = Settings::default();
    let mut members = Vec::new();
    for setting in &scene.settings {
        if setting.key == "models" {
            if !scene.models.is_empty() {
                return Err(
                    source.wrong(setting, "there are [[model]] tables, too: the files of a batch or a series are files = [...] in the first of them")
                );
            }
            let files = names(&source, setting)?;
            members.push(Member { files, ..Member::default() });
            continue;
        }
        source.add_any(setting, &mut settings, definition, &["models", "model"])?;
    }
    for (number, table) in scene.models.iter().enumerate() {
        members.push(member(&source, table, number == 0, definition)?);
    }
    Ok(Scene { settings, members })
}

/// One name of a file, or several.
fn names(source: &Source, setting: &Setting) -> Result<Vec<PathBuf>> {
    let one = |value: &Value| match value {
        Value::Text(name) if !name.is_empty() => Ok(paths::model(name, source.folder())),
        _ => Err(source.wrong(setting, "expected names of files in quotation marks")),
    };
    match &setting.value {
        Value::List(values) if !values.is_empty() => values.iter().map(one).collect(),
        value => Ok(vec![one(value)?]),
    }
}

fn member(
    source: &Source,
    table: &ModelTable,
    is_first: bool,
    definition: &mut Definition,
) -> Result<Member> {
    let mut member = Member::default();
    for setting in &table.settings {
        if let key @ ("file" | "files") = setting.key.as_str() {
            let files = names(source, setting)?;
            if key == "file" && files.len() > 1 {
                let text = "expected one file: each model has a table of its own, and the files of a batch or a series are files = [...]";
                return Err(source.wrong(setting, text));
            }
            if key == "files" && !is_first {
                let text = "a batch or a series is that of the first [[model]]: the others are in each of its pictures, and have one file";
                return Err(source.wrong(setting, text));
            }
            if !member.files.is_empty() {
                return Err(source.wrong(setting, "the model has a file already"));
            }
            member.files = files;
            continue;
        }
        let class = definition.class_or_like(&setting.key, &["file", "files", "instance"]);
        if class.map_err(|reason| source.wrong(setting, &reason))? != Class::Model {
            let text = "is an option of the whole picture: it belongs before the first [[model]]";
            return Err(source.wrong(setting, text));
        }
        source.add(setting, &mut member.settings, definition)?;
    }
    if member.files.is_empty() {
        bail!("{}: line {}: [[model]]: expected a file = \"...\"", source.path.display(), table.line);
    }
    let placements = table.instances.iter().map(|table| placement(source, table, definition));
    member.placements = placements.collect::<Result<_>>()?;
    Ok(member)
}

/// A further place of a model.
fn placement(source: &Source, table: &Table, definition: &Definition) -> Result<Placement> {
    let mut placement = Placement::default();
    for setting in &table.settings {
        let text = setting.value.text();
        let wrong = |reason: String| source.wrong(setting, &reason);
        if let Some(text) = &text
            && let Some(set) = placement.place.set(&setting.key, text)
        {
            set.map_err(wrong)?;
            continue;
        }
        match (setting.key.as_str(), text, &setting.value) {
            ("color", Some(text), _) => {
                placement.color = Some(values::linear_color(&text).map_err(wrong)?);
            }
            ("opacity", Some(text), _) => placement.opacity = Some(values::opacity(&text).map_err(wrong)?),
            ("no-mesh-colors", None, Value::Flag(flag)) => placement.no_mesh_colors = *flag,
            ("translate" | "rotate" | "scale" | "matrix" | "color" | "opacity", ..) => {
                return Err(wrong("expected a value".into()));
            }
            ("no-mesh-colors", ..) => return Err(wrong("expected true or false".into())),
            (key, ..) => {
                let known =
                    "an instance has translate, rotate, scale, matrix, color, opacity and no-mesh-colors";
                let text = match definition.class(key) {
                    Some(_) => format!("is no option of an instance: {known}"),
                    None => format!("there is no such option: {known}"),
                };
                return Err(wrong(text));
            }
        }
    }
    if placement.place.is_twice() {
        let line = table.line;
        bail!(
            "{}: line {line}: [[model.instance]]: matrix excludes translate, rotate and scale",
            source.path.display()
        );
    }
    Ok(placement)
}
