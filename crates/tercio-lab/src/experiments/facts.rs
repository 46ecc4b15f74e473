//! The published numbers that experiments start from and compare with, by name.

use std::collections::BTreeMap;

use super::ExperimentError;
use crate::models::registry::Value;
use crate::published::{self, Number};

/// The table of published numbers, by name.
#[derive(Debug)]
pub struct Facts(BTreeMap<String, Number>);

impl Facts {
    /// Reads the table.
    ///
    /// # Errors
    /// The table has a mistake.
    pub fn load() -> Result<Self, ExperimentError> {
        Ok(Self(published::numbers()?.into_iter().map(|n| (n.id.clone(), n)).collect()))
    }

    /// The row called `id`.
    ///
    /// # Errors
    /// No such row.
    pub fn number(&self, id: &str) -> Result<&Number, ExperimentError> {
        self.0.get(id).ok_or_else(|| format!("there is no published number '{id}'").into())
    }

    /// The number printed in the document, in the row's unit; NaN if illegible.
    ///
    /// # Errors
    /// No such row, or a list.
    pub fn printed(&self, id: &str) -> Result<f64, ExperimentError> {
        match &self.number(id)?.printed {
            None => Ok(f64::NAN),
            Some(value) => value.as_number().ok_or_else(|| format!("'{id}' is a list").into()),
        }
    }

    /// The number `name` that the row is computed from.
    ///
    /// # Errors
    /// No such row, no such name, or no number there.
    pub fn given(&self, id: &str, name: &str) -> Result<f64, ExperimentError> {
        let value = self.number(id)?.given.get(name).and_then(Value::as_number);
        value.ok_or_else(|| format!("'{id}' has no number '{name}'").into())
    }

    /// The cells of a row whose value is a list, as expected, in the row's unit; NaN where illegible.
    ///
    /// # Errors
    /// No such row, or no list of numbers.
    pub fn cells(&self, id: &str) -> Result<Vec<f64>, ExperimentError> {
        let Value::List(items) = &self.number(id)?.expected else {
            return Err(format!("'{id}' is no list").into());
        };
        items
            .iter()
            .map(|i| i.as_number().ok_or_else(|| format!("'{id}' is no list of numbers").into()))
            .collect()
    }
}
