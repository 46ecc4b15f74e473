//! The documents' equations, typeset. A test evaluates each beside the formula of the registry.

mod written;

use self::written::{EQUATIONS, Equation, NOT_TYPESET};
use super::expression::Expression;
use crate::experiments::Document;
use crate::models::registry::{self, Model};

/// An equation for a page.
pub(super) struct Typeset {
    /// Its number, and what it gives.
    pub text: String,
    /// The equation as MathML, an element `math` for each of its lines.
    pub math: String,
    /// The equation as text.
    pub source: &'static str,
    /// The symbols with their meanings.
    pub symbols: String,
}

/// The equations of a document.
pub(super) fn of(document: Document) -> Vec<Typeset> {
    let equations = EQUATIONS.iter().find(|e| e.0 == document).map_or(&[][..], |e| e.1);
    equations.iter().filter_map(typeset).collect()
}

/// The numbered equations of a document that are not typeset, each with the reason.
pub(super) fn left_out(document: Document) -> Vec<String> {
    let of_document = NOT_TYPESET.iter().filter(|e| e.0 == document);
    of_document.map(|(_, id, why)| format!("{id} ({why})")).collect()
}

fn typeset(&(id, source): &Equation) -> Option<Typeset> {
    let model = registry::find(id).ok()?;
    let line = |(left, right): (Expression, Expression)| {
        let (left, right) = (left.to_math_ml(), right.to_math_ml());
        format!("<math display=\"block\"><mrow>{left}<mo>=</mo>{right}</mrow></math>")
    };
    Some(Typeset {
        text: format!("{}: {}, {id}", model.place, model.what),
        math: lines(source).ok()?.into_iter().map(line).collect(),
        source,
        symbols: symbols(model),
    })
}

/// The lines of an equation: left and right sides.
fn lines(source: &str) -> Result<Vec<(Expression, Expression)>, String> {
    let line = |text: &str| {
        let (left, right) =
            text.split_once('=').ok_or_else(|| format!("expected an equation, found \"{text}\""))?;
        Ok((Expression::read(left)?, Expression::read(right)?))
    };
    source.split(';').map(line).collect()
}

fn symbols(model: &'static Model) -> String {
    let meaning = |p: &registry::Parameter| format!("{} {}", p.name, model.meaning(p.name));
    model.parameters.iter().map(meaning).collect::<Vec<_>>().join("; ")
}

#[cfg(test)]
mod tests;
