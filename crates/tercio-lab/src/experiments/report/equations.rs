//! The documents' equations, typeset. A test evaluates each beside the formula of the registry.

use super::expression::Expression;
use crate::experiments::Document;
use crate::models::registry::{self, Model};

/// The formula that evaluates an equation, what it gives as the document calls it, and the equation.
type Equation = (&'static str, &'static str, &'static str);

/// Equations that the experiments use, corrected where the document or the scan is wrong.
const EQUATIONS: [(Document, &[Equation]); 4] = [
    (
        Document::Eldridge,
        &[
            ("eldridge.4.1", "t", "p / n * (G + A * R)"),
            ("eldridge.4.2", "t", "f * p / n * (o * G + A * R)"),
            ("eldridge.4.3", "t", "p / n * (G + n * C + f * A * R)"),
            ("eldridge.4.4", "t", "p / n * (G + A * R) + Q * C"),
            ("eldridge.4.5", "t", "p / n * (G + A * R) + p * A * C"),
            ("eldridge.4.6", "C", "3 * a + b"),
            ("eldridge.4.10", "f o", "1 + n * C / G"),
            ("eldridge.4.11", "p", "C_dense * Q / (C_sparse * A)"),
            ("eldridge.4.12", "p", "C_dense * Q / (C_sm + (f - 1) * A * R / n)"),
            ("eldridge.5.1", "c", "n * C / (n * C + G + f * A * R)"),
            ("eldridge.5.3", "t", "p / n * (n / (2 * d)) * ((2 + d) * a + b)"),
            ("eldridge.5.4", "t", "p / n * (d / 2) * (3 * a + b)"),
            ("eldridge.5.6", "d", "sqrt((2 * a + b) * n / (3 * a + b))"),
            ("eldridge.5.7", "t", "p * (sqrt((3 * a + b) * (2 * a + b) / n) + a / 2)"),
            ("eldridge.5.8", "t", "p * (m * Gi / n + Gf / (2 * n) + (3 * a + b) / (4 * m))"),
            ("eldridge.5.9", "m", "sqrt(n * (3 * a + b) / (4 * Gi))"),
            ("eldridge.6.1", "t", "p / n * (G + g * C + f * A * R)"),
            ("eldridge.6.2", "s", "P * (1 / g - 1 / n)"),
            ("eldridge.6.3", "t", "P * (1 / g - 1 / n) * ((2 + g) * a + b)"),
            ("eldridge.6.4", "t", "a + (2 * a + b) / g"),
            ("eldridge.6.5", "t", "K * p * g / n"),
            ("eldridge.6.6", "t", "P * (a + (2 * a + b) / g)"),
            ("eldridge.6.7", "g", "sqrt((2 * a + b) * P * n / (K * p))"),
        ],
    ),
    (
        Document::Hybris,
        &[
            ("overlap.2.1", "O", "(1 + w / W) * (1 + h / H)"),
            ("overlap.2.3", "O", "(1 + w / S) * (1 + h / S)"),
            ("overlap.2.4", "O", "(1 + sqrt(rho * a) / S) ^ 2"),
            ("overlap.2.7", "O", "3 + 1 / rho"),
            ("overlap.2.8", "O", "1 + 2 * s / S + s ^ 2 / (rho * S ^ 2)"),
            ("overlap.2.9", "O", "1 + 2 * sqrt(rho * a) / S + a / S ^ 2"),
            ("overlap.2.11", "O", "(rho - 1) * a / S ^ 2"),
            ("hybris.4.1", "B", "w * h * d * f"),
        ],
    ),
    (
        Document::Parks,
        &[
            ("parks.scene", "t", "139 * N + 319.3 * V + 158 * S + 21 * P"),
            ("parks.interlace", "t", "139 * N + 319.3 * V + 158 * S / k + 21 * P / k ^ 2"),
        ],
    ),
    (
        Document::McManus,
        &[
            ("mcmanus.1", "R", "0.000871 * A ^ 2 + 0.00000074645 * P + 1.3673"),
            ("mcmanus.6", "C", "((sqrt(N) + A - 1) / A) ^ 2"),
            ("mcmanus.7", "P", "T * (A / (sqrt(N) + A - 1)) ^ 2"),
            ("mcmanus.13", "A", "cbrt((sqrt(N) - 1) * 1.3673 / 0.000871)"),
        ],
    ),
];

/// An equation for a page.
pub(super) struct Typeset {
    /// Its number, and what it gives.
    pub text: String,
    /// The equation as MathML.
    pub math: String,
    /// The equation as text.
    pub source: String,
    /// The symbols with their meanings.
    pub symbols: String,
}

/// The equations of a document.
pub(super) fn of(document: Document) -> Vec<Typeset> {
    let equations = EQUATIONS.iter().find(|e| e.0 == document).map_or(&[][..], |e| e.1);
    equations.iter().filter_map(typeset).collect()
}

fn typeset(&(id, left, right): &Equation) -> Option<Typeset> {
    let model = registry::find(id).ok()?;
    let expression = Expression::read(right).ok()?;
    let left_side: String = left.split(' ').map(|symbol| format!("<mi>{symbol}</mi>")).collect();
    Some(Typeset {
        text: format!("{}: {}, {id}", model.place, model.what),
        math: format!(
            "<math display=\"block\"><mrow>{left_side}<mo>=</mo>{}</mrow></math>",
            expression.to_math_ml()
        ),
        source: format!("{left} = {right}"),
        symbols: symbols(model),
    })
}

fn symbols(model: &'static Model) -> String {
    let meaning = |p: &registry::Parameter| format!("{} {}", p.name, model.meaning(p.name));
    model.parameters.iter().map(meaning).collect::<Vec<_>>().join("; ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::models::registry::{Arguments, Value};

    #[test]
    fn what_is_typeset_is_what_is_computed() {
        for (id, _, right) in EQUATIONS.iter().flat_map(|e| e.1) {
            let model = registry::find(id).unwrap();
            let expression = Expression::read(right).unwrap_or_else(|e| panic!("{id}: {e}"));
            for round in 0..3u32 {
                // Different numbers for each symbol, within what the formulas take.
                let number = |i: usize| 3.0 + 2.0 * i as f64 + 5.0 * f64::from(round);
                let names = || model.parameters.iter().map(|p| p.name);
                let given: Arguments =
                    names().enumerate().map(|(i, name)| (name.into(), Value::Number(number(i)))).collect();
                let of = |name: &str| given.get(name).and_then(Value::as_number);
                let typeset =
                    expression.value(&of).unwrap_or_else(|| panic!("{id} has other symbols: {right}"));
                let computed = model.evaluate(&given).unwrap_or_else(|e| panic!("{id}: {e}"));
                let computed = computed.as_number().unwrap();
                assert!(
                    (typeset / computed - 1.0).abs() < 1e-9,
                    "{id}: {typeset} typeset, {computed} computed"
                );
            }
            let words: Vec<_> = right.split(|c: char| !(c.is_alphanumeric() || c == '_')).collect();
            let missing: Vec<_> = model.parameters.iter().filter(|p| !words.contains(&p.name)).collect();
            assert!(missing.is_empty(), "{id}: {missing:?}");
        }
    }
}
