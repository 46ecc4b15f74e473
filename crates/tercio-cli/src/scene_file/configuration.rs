//! The configuration: defaults for all pictures, and for models by the pattern of their names.

use std::env;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result};
use tercio::scene_file::{Configuration, Setting};

use super::Member;
use super::definition::{Class, Definition};
use super::layers::{Given, Settings};
use super::tables::{Source, bytes};
use crate::commands::render::models::matches;

/// What a configuration says.
#[derive(Debug)]
pub struct Defaults {
    pub path: PathBuf,
    settings: Settings,
    /// Patterns, in the order of the file.
    patterns: Vec<(String, Settings)>,
}

/// The file that is read, and whether it has to be there.
fn place(config: Option<Given>) -> Option<(PathBuf, bool)> {
    let named = config.map(|given| given.texts().into_iter().next().unwrap_or_default());
    let named = named.or_else(|| env::var("TERCIO_CONFIG").ok().filter(|name| !name.is_empty()));
    if let Some(named) = named {
        return (named != "none").then(|| (named.into(), true));
    }
    let folder = |variable: &str| env::var_os(variable).map(PathBuf::from).filter(|path| path.is_absolute());
    let folder = folder("XDG_CONFIG_HOME").or_else(|| folder("HOME").map(|home| home.join(".config")))?;
    Some((folder.join("tercio/config.toml"), false))
}

/// Whether there is a configuration if the command line does not say so.
pub fn is_there() -> bool {
    place(None).is_some_and(|(path, is_named)| is_named || path.is_file())
}

impl Defaults {
    /// Reads the configuration, if there is one.
    ///
    /// # Errors
    /// What is wrong, with file and line.
    pub fn read(config: Option<Given>, definition: &mut Definition) -> Result<Option<Self>> {
        let Some((path, is_named)) = place(config) else { return Ok(None) };
        if !is_named && !path.is_file() {
            return Ok(None);
        }
        let source = Source { path: &path };
        let read = Configuration::read(&bytes(&path)?).with_context(|| path.display().to_string())?;
        let mut all = |settings: &[Setting]| -> Result<Settings> {
            let mut own = Settings::default();
            for setting in settings {
                // What is written where is said for every picture.
                if setting.key.starts_with("output") && definition.class(&setting.key).is_some() {
                    return Err(source.wrong(setting, "is said on the command line, or in a scene file"));
                }
                source.add_any(setting, &mut own, definition, &["pattern"])?;
            }
            Ok(own)
        };
        let settings = all(&read.settings)?;
        let patterns =
            read.patterns.iter().map(|(pattern, table)| Ok((pattern.clone(), all(&table.settings)?)));
        let patterns = patterns.collect::<Result<_>>()?;
        Ok(Some(Self { path, settings, patterns }))
    }

    /// Whether it may say something else of another model.
    pub fn has_patterns(&self) -> bool {
        !self.patterns.is_empty()
    }

    /// Adds the defaults that have an effect to the options of a picture and its models; those that need an option that
    /// is not given, or contradict one that is, are left out. Returns what is said about that.
    pub fn apply(
        &self,
        picture: &mut Settings,
        members: &mut [Member],
        definition: &mut Definition,
    ) -> Vec<String> {
        let mut notes = Vec::new();
        for (number, member) in members.iter_mut().enumerate() {
            let model = member.files.first().cloned().unwrap_or_default();
            // Patterns say more than what is said of all, and later ones more than earlier ones.
            let patterns = self.patterns.iter().rev().filter(|(pattern, _)| is_match(pattern, &model));
            let sources = patterns.map(|(_, settings)| settings).chain([&self.settings]);
            let mut open: Vec<(String, Given)> = Vec::new();
            for (name, given) in sources.flat_map(Settings::iter) {
                let is_of_model = definition.class(name) == Some(Class::Model);
                let is_said = |settings: &Settings| settings.get(name).is_some();
                let is_open = !is_said(picture) && !is_said(&member.settings);
                if is_open && (is_of_model || number == 0) && open.iter().all(|(other, _)| other != name) {
                    open.push((name.into(), given.clone()));
                }
            }
            let mut used = Vec::new();
            let starts = |picture: &Settings, of_model: &Settings, definition: &mut Definition| {
                let all = of_model.clone().over(picture, definition);
                let render = definition.parse(&all.arguments(&member.files, definition)).ok()?;
                render.check_options().is_ok().then(|| render.can_start())
            };
            // If it cannot start without defaults, that is reported when it does.
            let can_start = starts(picture, &member.settings, definition) == Some(true);
            // One may need another one that comes later.
            loop {
                let before = open.len();
                open.retain(|(name, given)| {
                    let is_of_model = definition.class(name) == Some(Class::Model);
                    let (mut of_picture, mut of_model) = (picture.clone(), member.settings.clone());
                    let to = if is_of_model { &mut of_model } else { &mut of_picture };
                    to.set(name, given.clone());
                    let started = starts(&of_picture, &of_model, definition);
                    let has_effect = started.is_some_and(|starts| starts || !can_start);
                    if has_effect {
                        (*picture, member.settings) = (of_picture, of_model);
                        used.push(name.clone());
                    }
                    !has_effect
                });
                if open.len() == before {
                    break;
                }
            }
            let list = |names: &[String]| if names.is_empty() { "nothing".into() } else { names.join(", ") };
            let open: Vec<String> = open.into_iter().map(|(name, _)| name).collect();
            let without = if open.is_empty() {
                String::new()
            } else {
                format!("; without effect here: {}", list(&open))
            };
            notes.push(format!("{}: {} from {}{without}", model.display(), list(&used), self.path.display()));
        }
        notes
    }
}

/// Whether a pattern matches the last part of a name; one with a slash, all of it.
fn is_match(pattern: &str, model: &Path) -> bool {
    let name = if pattern.contains('/') { Some(model.as_os_str()) } else { model.file_name() };
    name.is_some_and(|name| matches(pattern, &name.to_string_lossy()))
}
