//! The registry: every formula and simulation that can be asked for by name.
//!
//! A room declares its entries with [`models!`](crate::models!), apart from the plain functions that compute, and
//! [`all`] chains the rooms. `tercio lab eval` and the table of published numbers both ask here, so a number of the
//! table comes out of the same code as the user's.

mod argument;
mod value;

use std::collections::BTreeMap;

pub use argument::{Argument, Outcome};
pub use value::Value;

/// What a formula is asked with: values by parameter name.
pub type Arguments = BTreeMap<String, Value>;

/// A formula or a simulation that can be asked for by name.
#[derive(Debug)]
pub struct Model {
    /// The name: document or subject, a dot, the equation's number or a word.
    pub id: &'static str,
    /// The place in the document.
    pub place: &'static str,
    /// What it computes, under which assumptions.
    pub what: &'static str,
    /// What it takes.
    pub parameters: &'static [Parameter],
    /// The base unit of the outcome; empty for ratios, counts and lists.
    pub unit: &'static str,
    /// Reads the arguments and computes. Called by [`Model::evaluate`], which checks the names before.
    pub compute: fn(&Reader<'_>) -> Result<Value, ModelError>,
}

/// What a formula takes.
#[derive(Debug, PartialEq)]
pub struct Parameter {
    /// The symbol of the document.
    pub name: &'static str,
    /// The base unit.
    pub unit: &'static str,
    /// The value in base units that counts if none is given.
    pub default: Option<f64>,
}

/// Why a formula has no outcome.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ModelError {
    /// No such entry.
    #[error("no formula is called '{id}'{}", nearest(.near))]
    UnknownModel {
        /// The name asked for.
        id: String,
        /// Names like it.
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
    /// A value that has no default was not given.
    #[error("{id} needs a value for '{name}'{}", unit_words(.unit))]
    Missing {
        /// The formula.
        id: &'static str,
        /// The parameter.
        name: &'static str,
        /// Its base unit.
        unit: &'static str,
    },
    /// A value that the parameter cannot have.
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

fn unit_words(unit: &str) -> String {
    if unit.is_empty() { String::new() } else { format!(" ({unit})") }
}

/// Hands the arguments out by name and type.
#[derive(Debug)]
pub struct Reader<'a> {
    model: &'static Model,
    arguments: &'a Arguments,
}

impl Reader<'_> {
    /// The argument `name`, or the parameter's default.
    ///
    /// # Errors
    /// [`ModelError::Missing`] without value and default, [`ModelError::Argument`] for an impossible value.
    pub fn get<T: Argument>(&self, name: &'static str) -> Result<T, ModelError> {
        let id = self.model.id;
        let parameter = self.model.parameters.iter().find(|p| p.name == name);
        let value = match (self.arguments.get(name), parameter.and_then(|p| p.default)) {
            (Some(value), _) => value.clone(),
            (None, Some(default)) => Value::Number(default),
            (None, None) => return Err(ModelError::Missing { id, name, unit: T::UNIT }),
        };
        T::from_value(&value).map_err(|reason| ModelError::Argument { id, name, reason })
    }

    /// The outcome of the formula, in base units.
    ///
    /// # Errors
    /// [`ModelError::Undefined`] if the formula refuses.
    pub fn outcome(&self, outcome: impl Outcome) -> Result<Value, ModelError> {
        outcome.into_value().map_err(|reason| ModelError::Undefined { id: self.model.id, reason })
    }
}

impl Model {
    /// Computes the outcome, in base units.
    ///
    /// # Errors
    /// Unknown names, missing and impossible values, and values for which the formula has no finite result.
    pub fn evaluate(&'static self, arguments: &Arguments) -> Result<Value, ModelError> {
        if let Some(name) = arguments.keys().find(|n| self.parameters.iter().all(|p| p.name != n.as_str())) {
            let names: Vec<_> = self.parameters.iter().map(|p| p.name).collect();
            let takes = if names.is_empty() { "none".into() } else { names.join(", ") };
            return Err(ModelError::UnknownParameter { id: self.id, name: name.clone(), takes });
        }
        let outcome = (self.compute)(&Reader { model: self, arguments })?;
        if outcome.is_undefined() {
            let reason = "the formula has no finite value for these arguments".into();
            return Err(ModelError::Undefined { id: self.id, reason });
        }
        Ok(outcome)
    }
}

/// Declares a room's entries, one a formula:
///
/// ```text
/// models! {
///     "eldridge.5.6", "eq 5.6", "stride of the first stage that costs least":
///         optimal_stride["n": Processors = 1024.0, "a": Words = 42.0, "b": Instructions = 30.0] -> Processors;
/// }
/// ```
///
/// The names are the documents' symbols, in the order of the function's parameters; a default is in base units.
#[macro_export]
macro_rules! models {
    ($($id:literal, $place:literal, $what:literal:
        $function:path[$($name:literal: $type:ty $(= $default:expr)?),* $(,)?] -> $outcome:ty;)*) => {
        &[$($crate::models::registry::Model {
            id: $id,
            place: $place,
            what: $what,
            parameters: &[$($crate::models::registry::Parameter {
                name: $name,
                unit: <$type as $crate::models::registry::Argument>::UNIT,
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
    super::ROOMS.iter().flat_map(|room| room.iter())
}

/// The entry called `id`.
///
/// # Errors
/// [`ModelError::UnknownModel`], with names that contain `id` or share its document and begin alike.
pub fn find(id: &str) -> Result<&'static Model, ModelError> {
    all().find(|m| m.id == id).ok_or_else(|| {
        let beginning: String = id.chars().take(id.find('.').map_or(4, |dot| dot + 2)).collect();
        let like = |m: &&Model| m.id.contains(id) || m.id.starts_with(&beginning);
        ModelError::UnknownModel { id: id.into(), near: all().filter(like).map(|m| m.id).take(8).collect() }
    })
}

/// Computes the outcome of the entry called `id`, in base units.
///
/// # Errors
/// As [`find`] and [`Model::evaluate`].
pub fn evaluate(id: &str, arguments: &Arguments) -> Result<Value, ModelError> {
    find(id)?.evaluate(arguments)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    fn given(values: &[(&str, f64)]) -> Arguments {
        values.iter().map(|(name, value)| ((*name).to_owned(), Value::Number(*value))).collect()
    }

    #[test]
    fn names_are_unique_and_defaults_are_possible() {
        let ids: BTreeSet<_> = all().map(|m| m.id).collect();
        assert_eq!(ids.len(), all().count());
        for model in all() {
            let names: BTreeSet<_> = model.parameters.iter().map(|p| p.name).collect();
            assert_eq!(names.len(), model.parameters.len(), "{}", model.id);
            // Asked for nothing, a formula computes or says what it needs.
            match model.evaluate(&Arguments::new()) {
                Ok(_) | Err(ModelError::Missing { .. }) => {}
                Err(other) => panic!("{other}"),
            }
        }
    }

    #[test]
    fn every_mistake_has_its_own_error() {
        let error = |id: &str, values: &[(&str, f64)]| evaluate(id, &given(values)).unwrap_err();
        assert!(matches!(error("eldridge.9.9", &[]), ModelError::UnknownModel { .. }));
        assert!(matches!(error("eldridge.5.6", &[("x", 1.0)]), ModelError::UnknownParameter { .. }));
        assert!(matches!(error("eldridge.5.3", &[]), ModelError::Missing { name: "d", .. }));
        assert!(matches!(error("eldridge.5.6", &[("n", -1.0)]), ModelError::Argument { name: "n", .. }));
        assert!(matches!(error("eldridge.5.6", &[("n", f64::NAN)]), ModelError::Argument { name: "n", .. }));
        assert!(matches!(error("ortega.rate", &[("N", 1.0), ("t", 0.0)]), ModelError::Undefined { .. }));
    }

    #[test]
    fn texts_with_units_are_arguments() {
        let clock = Arguments::from([("clock".to_owned(), Value::Text("28 MHz".into()))]);
        assert_eq!(evaluate("eldridge.aggregate-rate", &clock), Ok(Value::Number(1024.0 * 28e6)));
    }
}
