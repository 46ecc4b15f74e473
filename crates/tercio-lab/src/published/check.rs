//! Compares computed values with the expected ones.

use super::Number;
use crate::models::registry::{self, ModelError, Value};
use crate::units::scale;

/// A published number with the computed value.
#[derive(Debug)]
pub struct Check {
    /// The row of the table.
    pub number: Number,
    /// The result of the formula or simulation, in the row's unit.
    pub ours: Result<Value, ModelError>,
    /// Whether the computed value is within the tolerance.
    pub holds: bool,
}

/// Computes one number and compares.
pub fn check(number: Number) -> Check {
    let ours = compute(&number);
    let holds = ours.as_ref().is_ok_and(|ours| ours.agrees_with(&number.expected, number.tolerance));
    Check { number, ours, holds }
}

/// Computes all of them.
///
/// # Errors
/// The table has a mistake.
pub fn check_all() -> Result<Vec<Check>, super::TableError> {
    Ok(super::numbers()?.into_iter().map(check).collect())
}

fn compute(number: &Number) -> Result<Value, ModelError> {
    let model = registry::find(&number.model)?;
    let ours = model.evaluate(&number.given)?;
    let Some(unit) = &number.unit else { return Ok(ours) };
    let reason = || format!("the table asks for '{unit}', the formula gives '{}'", model.unit);
    let factor =
        scale(unit, model.unit).ok_or_else(|| ModelError::Undefined { id: model.id, reason: reason() })?;
    Ok(ours.divided_by(factor))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_published_number_holds() {
        let failed: Vec<_> = check_all().unwrap().into_iter().filter(|c| !c.holds).collect();
        let message =
            |c: &Check| format!("{}: expected {}, ours {:?}", c.number.id, c.number.expected, c.ours);
        assert!(failed.is_empty(), "{:#?}", failed.iter().map(message).collect::<Vec<_>>());
    }

    #[test]
    fn a_wrong_expectation_does_not_hold() {
        let mut number = super::super::numbers().unwrap().remove(0);
        number.expected = Value::Number(29.0);
        assert!(!check(number).holds);
    }

    #[test]
    fn a_wrong_unit_is_an_error() {
        let mut number = super::super::numbers().unwrap().remove(0);
        number.unit = Some("Mpixel/s".into());
        let check = check(number);
        assert!(!check.holds && check.ours.is_err());
    }
}
