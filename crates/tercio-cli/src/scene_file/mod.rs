//! Where options come from besides the command line: scene files, `--with`, and the configuration.
//!
//! All of them say the same things as the command line, in its words. Their settings are turned into arguments, and what was
//! parsed from these is what is drawn; so the definition of the options is the only one.

mod configuration;
mod definition;
mod layers;
mod paths;
mod save;
mod tables;
mod with;

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Result, bail};

use self::configuration::Defaults;
use self::definition::Definition;
use self::layers::{Given, Settings};
use crate::commands::render::Render;
use crate::commands::render::members::Placement;
use crate::commands::render::models::expanded;
use crate::named_files::NamedFiles;
use crate::output::UsageError;

/// Where the options of a picture come from.
#[derive(Clone, Debug, Default)]
pub struct Origin {
    /// The arguments, if other sources were read.
    pub arguments: Vec<OsString>,
    /// What `-v` says about the sources.
    pub notes: Vec<String>,
    /// The scene file and the configuration.
    files: Vec<(&'static str, PathBuf)>,
    /// The text for `--save-scene`.
    pub saved: Option<String>,
    /// What was said before the configuration, whose patterns may say something else of each model of a batch.
    sources: Option<Arc<Sources>>,
}

/// What was said elsewhere than in the configuration, and the configuration.
#[derive(Debug)]
struct Sources {
    picture: Settings,
    members: Vec<Member>,
    defaults: Defaults,
}

impl Origin {
    /// Adds the files that were read.
    pub fn named_files(&self, files: NamedFiles) -> NamedFiles {
        self.files.iter().fold(files, |files, (what, path)| files.reads(what, path))
    }

    /// The options for one model of several that have a picture each; `None` if they are the same for all.
    ///
    /// # Errors
    /// As [`render`].
    pub fn for_model(&self, model: &Path) -> Result<Option<Render>> {
        let Some(sources) = &self.sources else { return Ok(None) };
        let mut definition = Definition::new();
        let (mut picture, mut members) = (sources.picture.clone(), sources.members.clone());
        members[0].files = vec![model.to_path_buf()];
        let notes = sources.defaults.apply(&mut picture, &mut members, &mut definition);
        let origin = Self { notes, sources: None, ..self.clone() };
        parsed(&picture, &members, origin, &mut definition).map(Some)
    }

    /// The scene file, if there is one.
    pub fn scene_file(&self) -> Option<&Path> {
        self.files.iter().find(|(what, _)| *what == SCENE).map(|(_, path)| path.as_path())
    }
}

const SCENE: &str = "the scene";
const CONFIGURATION: &str = "the configuration";

/// A model of the picture, before its options are parsed.
#[derive(Clone, Debug, Default)]
struct Member {
    /// Its file; of the first one, all models of a batch or series.
    files: Vec<PathBuf>,
    settings: Settings,
    placements: Vec<Placement>,
}

/// Is it the name of a scene file?
pub fn is_scene(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml"))
}

/// Whether options may come from elsewhere, at a glance: as a rule they do not, and the definition is made only once.
fn may_have_other_sources(arguments: &[OsString]) -> bool {
    const OPTIONS: [&str; 4] = ["--with", "--together", "--save-scene", "--config"];
    let means_other = |argument: &OsString| {
        is_scene(Path::new(argument))
            || OPTIONS.iter().any(|option| argument.to_string_lossy().starts_with(option))
    };
    arguments.iter().any(means_other) || configuration::is_there()
}

/// The command that the arguments of `tercio render` mean if there are other sources of options; `None` if there are none,
/// or if the arguments are wrong, which their usual parser reports.
///
/// # Errors
/// A file that cannot be read or is wrong; settings that contradict each other.
pub fn render(arguments: &[OsString]) -> Result<Option<Render>> {
    if arguments.get(1).is_none_or(|command| command != "render") {
        return Ok(None);
    }
    if !may_have_other_sources(arguments) {
        return Ok(None);
    }
    let mut definition = Definition::new();
    let Some((mut own, models)) = definition.command_line(&arguments[1..]) else { return Ok(None) };
    let with = own.take("with");
    let is_together = own.take("together").is_some();
    let config = own.take("config");
    let is_saved = own.get("save-scene").is_some();
    let has_scene = models.iter().any(|model| is_scene(model));
    if !has_scene && definition.parse(&arguments[1..]).is_err() {
        return Ok(None);
    }
    let defaults = Defaults::read(config, &mut definition)?;
    if !(has_scene || is_together || is_saved || with.is_some() || defaults.is_some()) {
        return Ok(None);
    }
    let mut origin = Origin { arguments: arguments.to_vec(), ..Origin::default() };
    origin.files.extend(defaults.iter().map(|defaults| (CONFIGURATION, defaults.path.clone())));

    let (own_model, own_picture) = own.split(&definition);
    let mut picture = own_picture;
    let mut members: Vec<Member>;
    let mut is_together = is_together;
    if has_scene {
        let [file] = &models[..] else {
            return Err(
                UsageError("a scene file (.toml) names its models itself: name it alone".into()).into()
            );
        };
        origin.files.push((SCENE, file.clone()));
        let scene = tables::read(file, &mut definition)?;
        let mut of_scene = scene.settings;
        is_together |= of_scene.take("together").is_some_and(|given| given != Given::Off);
        let (of_models, of_picture) = of_scene.split(&definition);
        picture = picture.over(&of_picture, &definition);
        members = scene.members;
        if members.is_empty() {
            bail!(
                "{}: there are no models: expected [[model]] tables, or models = [\"a.ply\"]",
                file.display()
            );
        }
        for member in &mut members {
            let table = std::mem::take(&mut member.settings);
            member.settings = own_model.clone().over(&table, &definition).over(&of_models, &definition);
        }
    } else {
        members = vec![Member { files: models, settings: own_model, placements: Vec::new() }];
    }
    if is_together {
        members = apart(&members)?;
        color(&mut members);
    }
    for text in with.iter().flat_map(Given::texts) {
        members.push(with::read(&text, &mut definition)?);
    }
    if let Some(defaults) = defaults {
        let sources = Sources { picture: picture.clone(), members: members.clone(), defaults };
        origin.notes = sources.defaults.apply(&mut picture, &mut members, &mut definition);
        origin.sources = sources.defaults.has_patterns().then(|| Arc::new(sources));
    }
    if is_saved {
        let to = own_path(&picture);
        if !is_scene(&to) {
            let text = format!("--save-scene {}: the name of a scene file ends with .toml", to.display());
            return Err(UsageError(text).into());
        }
        origin.saved = Some(save::text(&picture, &members, &to)?);
    }
    parsed(&picture, &members, origin, &mut definition).map(Some)
}

/// The command of the settings of a picture and of its models.
fn parsed(
    picture: &Settings,
    members: &[Member],
    origin: Origin,
    definition: &mut Definition,
) -> Result<Render> {
    let scene = origin.scene_file().map(Path::to_path_buf);
    let mut parsed = Vec::new();
    for member in members {
        let all = member.settings.clone().over(picture, definition);
        let arguments = all.arguments(&member.files, definition);
        let mut render = definition.parse(&arguments).map_err(|error| {
            let model = member.files.first().filter(|_| members.len() > 1).or(scene.as_ref());
            let text = definition::sentence(&error);
            UsageError(model.map_or(text.clone(), |model| format!("{}: {text}", model.display())))
        })?;
        render.placements.clone_from(&member.placements);
        parsed.push(render);
    }
    let mut parsed = parsed.into_iter();
    let Some(mut first) = parsed.next() else { bail!("there is no model") };
    (first.others, first.origin) = (parsed.collect(), origin);
    Ok(first)
}

/// Where the scene is saved.
fn own_path(picture: &Settings) -> PathBuf {
    let given = picture.get("save-scene").map(Given::texts).unwrap_or_default();
    given.first().map(PathBuf::from).unwrap_or_default()
}

/// Models that are named together, each for itself.
fn apart(members: &[Member]) -> Result<Vec<Member>> {
    let mut all = Vec::new();
    for member in members {
        for file in &member.files {
            let found = expanded(file)?.unwrap_or_else(|| vec![file.clone()]);
            all.extend(found.into_iter().map(|file| Member { files: vec![file], ..member.clone() }));
        }
    }
    Ok(all)
}

/// Colours that are well told apart, on bright and on dark backgrounds and by people who do not see all colours.
const PALETTE: [&str; 10] = [
    "#6f9fd8", "#e8a33d", "#5fb88a", "#d9705f", "#9d86cf", "#c9c04a", "#d98cc0", "#58b9c4", "#a8805c",
    "#a9b0b8",
];

/// Gives each model that has no other colour one of its own.
fn color(members: &mut [Member]) {
    for (member, color) in members.iter_mut().zip(PALETTE.iter().cycle()) {
        if member.settings.get("color").is_none() {
            member.settings.set("color", Given::Values(vec![(*color).into()]));
        }
    }
}
