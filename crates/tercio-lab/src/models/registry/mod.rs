//! The registry: every formula and simulation that can be evaluated by name.
//!
//! A module declares its entries with [`models!`](crate::models!), apart from the plain functions that compute, and
//! [`all`] chains the modules. `tercio lab eval` and the table of published numbers both use the registry, so a number
//! of the table is computed by the same code as the user's.

mod argument;
mod glossary;
mod value;

use std::collections::BTreeMap;

pub use argument::{Argument, Outcome};
pub use glossary::Glossary;
pub use value::Value;

/// Arguments of a formula: values by parameter name.
pub type Arguments = BTreeMap<String, Value>;

/// A formula or a simulation that can be evaluated by name.
#[derive(Debug)]
pub struct Model {
    /// The name: document or subject, a dot, the equation's number or a word.
    pub id: &'static str,
    /// The place in the document.
    pub place: &'static str,
    /// What it computes, under which assumptions.
    pub what: &'static str,
    /// Its parameters.
    pub parameters: &'static [Parameter],
    /// The base unit of the outcome; empty for ratios, counts and lists.
    pub unit: &'static str,
    /// Reads the arguments and computes. Called by [`Model::evaluate`], which checks the names before.
    pub compute: fn(&Reader<'_>) -> Result<Value, ModelError>,
}

/// A parameter of a formula.
#[derive(Debug)]
pub struct Parameter {
    /// The symbol of the document.
    pub name: &'static str,
    /// The base unit.
    pub unit: &'static str,
    /// The syntax of a value, from [`Argument::form`].
    pub form: fn() -> String,
    /// The minimum in base units, if it is above that of the unit.
    pub at_least: Option<f64>,
    /// The default value in base units.
    pub default: Option<f64>,
}

/// Why a formula has no result.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ModelError {
    /// No such entry.
    #[error("no formula is called '{id}'{}", nearest(.near))]
    UnknownModel {
        /// The requested name.
        id: String,
        /// Similar names.
        near: Vec<&'static str>,
    },
    /// No such parameter.
    #[error("{id} has no parameter '{name}': it takes {takes}")]
    UnknownParameter {
        /// The formula.
        id: &'static str,
        /// The name given.
        name: String,
        /// The names that exist.
        takes: String,
    },
    /// A value is missing and has no default.
    #[error("{id} needs a value for '{name}', {meaning} ({form})")]
    Missing {
        /// The formula.
        id: &'static str,
        /// The parameter.
        name: &'static str,
        /// What it means.
        meaning: &'static str,
        /// The syntax of a value.
        form: String,
    },
    /// A value that is invalid for the parameter.
    #[error("{id}: {name}: {reason}")]
    Argument {
        /// The formula.
        id: &'static str,
        /// The parameter.
        name: &'static str,
        /// What was expected and what was found.
        reason: String,
    },
    /// The formula is not defined for these values.
    #[error("{id}: {reason}")]
    Undefined {
        /// The formula.
        id: &'static str,
        /// Why.
        reason: String,
    },
}

fn nearest(near: &[&str]) -> String {
    if near.is_empty() { String::new() } else { format!("; near it: {}", near.join(", ")) }
}

/// Provides the arguments by name and type.
#[derive(Debug)]
pub struct Reader<'a> {
    model: &'static Model,
    arguments: &'a Arguments,
}

impl Reader<'_> {
    /// The argument `name`, or the parameter's default.
    ///
    /// # Errors
    /// [`ModelError::Missing`] without value and default, [`ModelError::Argument`] for an invalid value.
    pub fn get<T: Argument>(&self, name: &'static str) -> Result<T, ModelError> {
        let id = self.model.id;
        let parameter = self.model.parameters.iter().find(|p| p.name == name);
        let value = match (self.arguments.get(name), parameter.and_then(|p| p.default)) {
            (Some(value), _) => value.clone(),
            (None, Some(default)) => Value::Number(default),
            (None, None) => {
                let meaning = self.model.meaning(name);
                return Err(ModelError::Missing { id, name, meaning, form: T::form() });
            }
        };
        let impossible = |reason| ModelError::Argument { id, name, reason };
        let argument = T::from_value(&value).map_err(impossible)?;
        match (argument.number(), parameter.and_then(|p| p.at_least)) {
            (Some(number), Some(least)) if number < least => Err(impossible(format!(
                "{}: expected at least {least}, found {number}",
                self.model.meaning(name)
            ))),
            _ => Ok(argument),
        }
    }

    /// The outcome of the formula, in base units.
    ///
    /// # Errors
    /// [`ModelError::Undefined`] if the formula refuses.
    pub fn outcome(&self, outcome: impl Outcome) -> Result<Value, ModelError> {
        let zeros = self.arguments.iter().filter(|a| *a.1 == Value::Number(0.0)).map(|a| a.0.as_str());
        let zeros: Vec<_> = zeros.collect();
        outcome.into_value().map_err(|mut reason| {
            if !zeros.is_empty() {
                reason += &format!("; note that 0 is given for {}", zeros.join(", "));
            }
            ModelError::Undefined { id: self.model.id, reason }
        })
    }
}

impl Model {
    fn glossary(&self) -> Option<&'static Glossary> {
        super::GLOSSARIES.iter().find(|g| self.id.split('.').next() == Some(g.group)).copied()
    }

    /// The meaning of a parameter, in words.
    pub fn meaning(&self, parameter: &str) -> &'static str {
        self.glossary().and_then(|g| g.meaning(self.id, parameter)).unwrap_or_default()
    }

    /// The assumptions.
    pub fn assumptions(&self) -> impl Iterator<Item = &'static str> {
        let id = self.id;
        self.glossary().into_iter().flat_map(move |g| g.assumptions(id))
    }

    /// Document and place in it: `000 eq 5.6`.
    pub fn source(&self) -> String {
        match self.glossary().and_then(|g| g.document) {
            Some(document) => format!("{document} {}", self.place),
            None => self.place.into(),
        }
    }

    /// Computes the outcome, in base units.
    ///
    /// # Errors
    /// Unknown names, missing and invalid values, and values for which the formula has no finite result.
    pub fn evaluate(&'static self, arguments: &Arguments) -> Result<Value, ModelError> {
        if let Some(name) = arguments.keys().find(|n| self.parameters.iter().all(|p| p.name != n.as_str())) {
            let names: Vec<_> = self.parameters.iter().map(|p| p.name).collect();
            let takes = if names.is_empty() { "none".into() } else { names.join(", ") };
            return Err(ModelError::UnknownParameter { id: self.id, name: name.clone(), takes });
        }
        (self.compute)(&Reader { model: self, arguments })
    }
}

/// Declares a module's entries, one per formula:
///
/// ```text
/// models! {
///     "eldridge.5.6", "eq 5.6", "stride of the first stage that costs least":
///         optimal_stride["n": Processors = 1024.0, "a": Words = 42.0, "b": Instructions = 30.0] -> Processors;
/// }
/// ```
///
/// The names are the documents' symbols, in the order of the function's parameters; a default is in base units, and so
/// is the least value that `"m": Ratio where 1.0` allows.
#[macro_export]
macro_rules! models {
    ($($id:literal, $place:literal, $what:literal:
        $function:path[$($name:literal: $type:ty $(where $least:literal)? $(= $default:expr)?),* $(,)?] -> $outcome:ty;)*) => {
        &[$($crate::models::registry::Model {
            id: $id,
            place: $place,
            what: $what,
            parameters: &[$($crate::models::registry::Parameter {
                name: $name,
                unit: <$type as $crate::models::registry::Argument>::UNIT,
                form: <$type as $crate::models::registry::Argument>::form,
                at_least: $crate::models!(@default $($least)?),
                default: $crate::models!(@default $($default)?),
            }),*],
            unit: $crate::models!(@unit $outcome),
            compute: |_reader| {
                let outcome: $outcome = $function($(_reader.get::<$type>($name)?),*);
                _reader.outcome(outcome)
            },
        }),*]
    };
    (@default) => { None };
    (@default $default:expr) => { Some($default) };
    (@unit $outcome:ty) => { <$outcome as $crate::models::registry::Outcome>::UNIT };
}

/// Every entry, in the order of the documents.
pub fn all() -> impl Iterator<Item = &'static Model> {
    super::MODULES.iter().flat_map(|module| module.iter())
}

/// The entry called `id`.
///
/// # Errors
/// [`ModelError::UnknownModel`], with similar names.
pub fn find(id: &str) -> Result<&'static Model, ModelError> {
    all().find(|m| m.id == id).ok_or_else(|| ModelError::UnknownModel { id: id.into(), near: near(id) })
}

/// Names that a user may have meant, the most similar first.
fn near(id: &str) -> Vec<&'static str> {
    /// Names with less similarity than this are unrelated.
    const LIKE: f64 = 0.75;
    let likeness = |m: &'static Model| {
        let contained = if !id.is_empty() && m.id.contains(id) { 1.0 } else { 0.0 };
        (contained + strsim::jaro_winkler(id, m.id), m.id)
    };
    let mut all: Vec<_> = all().map(likeness).filter(|(like, _)| *like >= LIKE).collect();
    // Names of equal similarity stay in the order of the documents.
    all.sort_by(|a, b| b.0.total_cmp(&a.0));
    all.into_iter().map(|(_, id)| id).take(8).collect()
}

/// The entries whose name begins with `text` or, if there are none, whose name, place or description contains it,
/// ignoring case.
pub fn search(text: &str) -> Vec<&'static Model> {
    let by_name: Vec<_> = all().filter(|m| m.id.starts_with(text)).collect();
    if !by_name.is_empty() {
        return by_name;
    }
    let text = text.to_lowercase();
    let parts = |m: &Model| [m.id.to_lowercase(), m.source().to_lowercase(), m.what.to_lowercase()];
    all().filter(|m| parts(m).iter().any(|part| part.contains(&text))).collect()
}

/// Computes the outcome of the entry called `id`, in base units.
///
/// # Errors
/// As [`find`] and [`Model::evaluate`].
pub fn evaluate(id: &str, arguments: &Arguments) -> Result<Value, ModelError> {
    find(id)?.evaluate(arguments)
}

#[cfg(test)]
mod tests;
