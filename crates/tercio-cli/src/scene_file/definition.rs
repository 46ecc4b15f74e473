//! What the definition of the options says: names, kinds, contradictions.

use std::ffi::OsString;
use std::path::PathBuf;

use clap::error::ErrorKind;
use clap::parser::ValueSource;
use clap::{Arg, ArgAction, Args as _, Command, FromArgMatches as _, value_parser};
use tercio::scene_file::Value;

use super::layers::{Given, Settings};
use crate::commands::render::Render;

/// What an option is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// Of one model.
    Model,
    /// Of the picture.
    Picture,
    /// Of the command line alone.
    CommandLine,
}

/// Groups of options that are of a model.
const GROUPS: [&str; 3] = ["Data", "Lines and points", "Clipping"];
/// Those of other groups.
const OF_MODEL: [&str; 21] = [
    "color",
    "no-mesh-colors",
    "opacity",
    "specular",
    "roughness",
    "metallic",
    "crease-angle",
    "no-textures",
    "texture-alpha",
    "alpha-cutoff",
    "bar",
    "no-bar",
    "bar-title",
    "bar-unit",
    "bar-format",
    "bar-ticks",
    "bar-orientation",
    "translate",
    "rotate",
    "scale",
    "matrix",
];
/// What no file says.
const OF_COMMAND_LINE: [&str; 5] = ["with", "config", "save-scene", "help", "version"];

/// The definition of the options of `render`.
pub struct Definition {
    strict: Command,
}

impl Definition {
    pub fn new() -> Self {
        let mut strict = Render::augment_args(Command::new("render"));
        strict.build();
        Self { strict }
    }

    /// The same options, with any values and in any combination.
    fn loose(&self) -> Command {
        let mut loose = Command::new("render").disable_version_flag(true);
        for option in self.strict.get_arguments() {
            if option.is_positional() {
                continue;
            }
            loose = loose.arg(loosely(option));
        }
        let models =
            Arg::new("models").num_args(0..).action(ArgAction::Append).value_parser(value_parser!(PathBuf));
        loose.disable_help_flag(true).arg(models)
    }

    /// The settings and models of a command line that begins with `render`; `None` if it is wrong, or asks for help.
    pub fn command_line(&self, arguments: &[OsString]) -> Option<(Settings, Vec<PathBuf>)> {
        let matches = self.loose().try_get_matches_from(arguments).ok()?;
        let mut settings = Settings::default();
        for option in self.strict.get_arguments() {
            let (Some(name), id) = (option.get_long(), option.get_id().as_str()) else { continue };
            if matches.try_contains_id(id).is_err()
                || matches.value_source(id) != Some(ValueSource::CommandLine)
            {
                continue;
            }
            let values: Vec<OsString> = match option.get_action() {
                ArgAction::SetTrue => Vec::new(),
                _ => matches.get_raw(id).into_iter().flatten().map(ToOwned::to_owned).collect(),
            };
            settings.set(name, if values.is_empty() { Given::Flag } else { Given::Values(values) });
        }
        let models = matches.get_many::<PathBuf>("models").into_iter().flatten().cloned().collect();
        Some((settings, models))
    }

    /// Parses arguments that begin with `render`.
    pub fn parse(&mut self, arguments: &[OsString]) -> Result<Render, clap::Error> {
        Render::from_arg_matches(&self.strict.try_get_matches_from_mut(arguments)?)
    }

    /// The option that has a name or an alias.
    pub fn find(&self, name: &str) -> Option<&Arg> {
        let is_named = |option: &&Arg| {
            option.get_long() == Some(name) || option.get_all_aliases().is_some_and(|all| all.contains(&name))
        };
        self.strict.get_arguments().find(is_named)
    }

    /// What an option is of; `None` if there is no such option.
    pub fn class(&self, name: &str) -> Option<Class> {
        let option = self.find(name)?;
        let long = option.get_long().unwrap_or_default();
        Some(if OF_COMMAND_LINE.contains(&long) {
            Class::CommandLine
        } else if OF_MODEL.contains(&long) || option.get_help_heading().is_some_and(|h| GROUPS.contains(&h)) {
            Class::Model
        } else {
            Class::Picture
        })
    }

    /// What an option of a file is of.
    ///
    /// # Errors
    /// One sentence, if there is no such option: what there is that is like it, of options and `others`.
    pub fn class_or_like(&self, name: &str, others: &[&str]) -> Result<Class, String> {
        let unknown = || format!("there is no such option{}", self.like(name, others));
        self.class(name).ok_or_else(unknown)
    }

    /// Whether two options contradict each other.
    pub fn contradict(&self, a: &str, b: &str) -> bool {
        let (Some(a), Some(b)) = (self.find(a), self.find(b)) else { return false };
        let names = |a: &Arg, b: &Arg| {
            self.strict.get_arg_conflicts_with(a).iter().any(|other| other.get_id() == b.get_id())
        };
        names(a, b) || names(b, a)
    }

    /// Names of options, or of `others`, that are like this one.
    pub fn like(&self, name: &str, others: &[&str]) -> String {
        let name = name.trim_start_matches('-').replace('_', "-");
        let options = self.strict.get_arguments().filter_map(Arg::get_long);
        let options = options.filter(|option| !OF_COMMAND_LINE.contains(option));
        let scored = options.chain(others.iter().copied()).map(|other| {
            let begins = name.len() > 2 && other.starts_with(&name);
            (if begins { 0.95 } else { strsim::jaro_winkler(&name, other) }, other)
        });
        let mut near: Vec<(f64, &str)> = scored.filter(|(likeness, _)| *likeness > 0.82).collect();
        near.sort_by(|a, b| b.0.total_cmp(&a.0));
        near.truncate(3);
        let names: Vec<&str> = near.into_iter().map(|(_, name)| name).collect();
        if names.is_empty() { String::new() } else { format!("; there is {}", names.join(", ")) }
    }

    /// What a file says about an option, with its long name.
    ///
    /// # Errors
    /// One sentence.
    pub fn given(&mut self, name: &str, value: &Value) -> Result<(String, Given), String> {
        let option =
            self.find(name).ok_or_else(|| format!("there is no such option{}", self.like(name, &[])))?;
        let long = option.get_long().unwrap_or_default().to_owned();
        let takes_value = option.get_action().takes_values();
        let needs_value = takes_value && option.get_num_args().is_none_or(|count| count.min_values() > 0);
        let repeats =
            matches!(option.get_action(), ArgAction::Append) && option.get_value_delimiter().is_none();
        let text = |value: &Value| value.text().ok_or("true and false are not part of a list");
        let given = match value {
            Value::Flag(false) => Given::Off,
            Value::Flag(true) if needs_value => return Err("expected a value, found true".into()),
            Value::Flag(true) => Given::Flag,
            _ if !takes_value => return Err("expected true or false".into()),
            Value::List(values) if repeats && !values.iter().all(|v| matches!(v, Value::Number(_))) => {
                let texts: Result<Vec<OsString>, _> =
                    values.iter().map(|value| text(value).map(OsString::from)).collect();
                Given::Values(texts?)
            }
            Value::List(values) if values.is_empty() => return Err("expected a value, found none".into()),
            _ => Given::Values(vec![text(value)?.into()]),
        };
        self.check(&long, &given)?;
        Ok((long, given))
    }

    /// Checks the values of an option for themselves.
    ///
    /// # Errors
    /// One sentence.
    pub fn check(&mut self, name: &str, given: &Given) -> Result<(), String> {
        let mut alone = Settings::default();
        alone.set(name, given.clone());
        if name != "output" {
            alone.set("output", Given::Values(vec!["x.png".into()]));
        }
        let arguments = alone.arguments(&["x".into()], self);
        match self.parse(&arguments) {
            // What is missing may be elsewhere.
            Err(error) if error.kind() != ErrorKind::MissingRequiredArgument => Err(sentence(&error)),
            _ => Ok(()),
        }
    }
}

/// An option with its name and number of values, and nothing else.
fn loosely(option: &Arg) -> Arg {
    // Names of the parser are static. They are made once a run, or whenever a watched scene changes.
    let kept = |name: &str| -> &'static str { Box::leak(name.to_owned().into_boxed_str()) };
    let mut loose =
        Arg::new(option.get_id().clone()).allow_hyphen_values(option.is_allow_hyphen_values_set());
    if let Some(long) = option.get_long() {
        loose = loose.long(kept(long));
    }
    if let Some(short) = option.get_short() {
        loose = loose.short(short);
    }
    loose = loose.aliases(option.get_all_aliases().unwrap_or_default().into_iter().map(kept));
    loose = loose.allow_negative_numbers(option.is_allow_negative_numbers_set());
    match option.get_action() {
        ArgAction::Append | ArgAction::Set => {
            let range = option.get_num_args().unwrap_or_else(|| 1.into());
            loose
                .action(option.get_action().clone())
                .num_args(range)
                .require_equals(option.is_require_equals_set())
                .value_parser(value_parser!(OsString))
        }
        action => loose.action(action.clone()),
    }
}

/// What the parser says, in one sentence.
pub fn sentence(error: &clap::Error) -> String {
    let text = error.render().to_string();
    let lines = text.lines().map(str::trim).take_while(|line| !line.starts_with("Usage:"));
    let lines = lines.filter(|line| !line.is_empty() && !line.starts_with("For more information"));
    let all = lines.collect::<Vec<_>>().join(" ");
    all.strip_prefix("error: ").unwrap_or(&all).to_owned()
}
