//! Settings, and which of several sources wins.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::path::PathBuf;

use super::definition::{Class, Definition};

/// What is said about one option.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Given {
    /// It is not used, whatever sources of less weight say.
    Off,
    /// It is used, without a value.
    Flag,
    /// It has these values, one for each time that it is given.
    Values(Vec<OsString>),
}

impl Given {
    /// The values as texts.
    pub fn texts(&self) -> Vec<String> {
        match self {
            Self::Values(values) => values.iter().map(|value| value.to_string_lossy().into_owned()).collect(),
            Self::Off | Self::Flag => Vec::new(),
        }
    }
}

/// Options by their long names.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Settings(BTreeMap<String, Given>);

impl Settings {
    pub fn set(&mut self, name: &str, given: Given) {
        self.0.insert(name.into(), given);
    }

    pub fn get(&self, name: &str) -> Option<&Given> {
        self.0.get(name)
    }

    pub fn take(&mut self, name: &str) -> Option<Given> {
        self.0.remove(name)
    }

    pub fn iter(&self) -> impl Iterator<Item = (&str, &Given)> {
        self.0.iter().map(|(name, given)| (name.as_str(), given))
    }

    /// Those of a model, and those of the picture.
    pub fn split(self, definition: &Definition) -> (Self, Self) {
        let (model, picture) =
            self.0.into_iter().partition(|(name, _)| definition.class(name) == Some(Class::Model));
        (Self(model), Self(picture))
    }

    /// These, and those of `lower` that they neither replace nor contradict.
    pub fn over(mut self, lower: &Self, definition: &Definition) -> Self {
        let own: Vec<String> =
            self.0.iter().filter(|(_, given)| **given != Given::Off).map(|(name, _)| name.clone()).collect();
        for (name, given) in &lower.0 {
            let is_contradicted =
                || *given != Given::Off && own.iter().any(|own| definition.contradict(own, name));
            if !self.0.contains_key(name) && !is_contradicted() {
                self.0.insert(name.clone(), given.clone());
            }
        }
        self
    }

    /// The arguments of `render` that say the same about these models.
    pub fn arguments(&self, models: &[PathBuf], definition: &Definition) -> Vec<OsString> {
        let mut arguments: Vec<OsString> = vec!["render".into()];
        for (name, given) in &self.0 {
            match given {
                Given::Off => {}
                Given::Flag => arguments.push(format!("--{name}").into()),
                Given::Values(values) => {
                    for value in values {
                        let mut argument: OsString = format!("--{name}=").into();
                        argument.push(value);
                        arguments.push(argument);
                    }
                }
            }
        }
        debug_assert!(self.0.keys().all(|name| definition.class(name).is_some()));
        arguments.push("--".into());
        arguments.extend(models.iter().map(|model| model.as_os_str().to_owned()));
        arguments
    }
}
