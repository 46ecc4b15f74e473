use std::collections::{BTreeMap, BTreeSet};

use super::*;
use crate::models::registry::{Arguments, Value};

/// Numbers above 1 of three magnitudes, by a linear congruential sequence.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let random = self.0 >> 33;
        1.0 + (random % 240 + 1) as f64 / 4.0 * [0.0625, 1.0, 16.0][(random / 240 % 3) as usize]
    }

    /// A value of a form like `[number, [m, m]]`; lists without an end get three items.
    fn of_form(&mut self, form: &str) -> Value {
        let Some(inside) = form.strip_prefix('[').and_then(|f| f.strip_suffix(']')) else {
            return Value::Number(self.next());
        };
        let mut items = vec![""];
        let (mut depth, mut from) = (0, 0);
        for (i, c) in inside.char_indices() {
            depth += i32::from(c == '[') - i32::from(c == ']');
            if c == ',' && depth == 0 {
                items.push("");
                from = i + 1;
            }
            *items.last_mut().unwrap() = inside[from..=i].trim_matches([' ', ',']);
        }
        let items = match items[..] {
            [item, "..."] => vec![item; 3],
            _ => items,
        };
        Value::List(items.into_iter().map(|item| self.of_form(item)).collect())
    }
}

/// The list that `v` is, or a number of it: `v_x` and `M_12`.
fn given(arguments: &Arguments, name: &str) -> Option<Vec<f64>> {
    fn item(value: &Value, index: usize) -> Option<&Value> {
        if let Value::List(items) = value { items.get(index) } else { None }
    }
    let value = arguments.get(name).or_else(|| {
        let (name, index) = name.split_once('_')?;
        let value = arguments.get(name)?;
        let place = |c: char| match c {
            'x' | 'A' => Some(0),
            'y' | 'B' => Some(1),
            'z' | 'p' | 'C' => Some(2),
            digit => Some(digit.to_digit(10)?.checked_sub(1)? as usize),
        };
        index.chars().try_fold(value, |value, c| item(value, place(c)?))
    })?;
    match value {
        Value::List(items) => items.iter().map(Value::as_number).collect(),
        other => Some(vec![other.as_number()?]),
    }
}

fn numbers(value: &Value) -> Vec<f64> {
    match value {
        Value::List(items) => items.iter().flat_map(numbers).collect(),
        other => other.as_number().into_iter().collect(),
    }
}

/// The outcome of the last `count` lines.
fn evaluated(id: &str, lines: &[(Expression, Expression)], arguments: &Arguments, count: usize) -> Vec<f64> {
    let mut known: BTreeMap<String, f64> = BTreeMap::new();
    let values: Vec<_> = lines
        .iter()
        .map(|(left, right)| {
            let of = |name: &str| known.get(name).map(|v| vec![*v]).or_else(|| given(arguments, name));
            let value = right.value(&of).unwrap_or_else(|| panic!("{id} has other symbols: {right:?}"));
            if let Expression::Symbol(name) = left {
                let clash = known.insert(name.clone(), value).is_some();
                assert!(!clash, "{id}: {name} twice");
            }
            value
        })
        .collect();
    values[values.len() - count..].to_vec()
}

#[test]
fn what_is_typeset_is_what_is_computed() {
    for (id, source) in EQUATIONS.iter().flat_map(|e| e.1) {
        let model = registry::find(id).unwrap();
        let lines = lines(source).unwrap_or_else(|e| panic!("{id}: {e}"));
        let mut random = Numbers(1);
        let mut compared = 0;
        // Some numbers are refused: an area above that of its box, more polygons than fit.
        for _ in 0..20_000 {
            let arguments: Arguments =
                model.parameters.iter().map(|p| (p.name.into(), random.of_form(&(p.form)()))).collect();
            let Ok(computed) = model.evaluate(&arguments) else { continue };
            let computed = numbers(&computed);
            assert!(!computed.is_empty(), "{id}: no numbers");
            let typeset = evaluated(id, &lines, &arguments, computed.len());
            for (typeset, computed) in typeset.iter().zip(&computed) {
                let near = (typeset - computed).abs() <= 1e-9 * computed.abs().max(1e-3);
                assert!(near, "{id}: {typeset} typeset, {computed} computed of {arguments:?}");
            }
            compared += 1;
            if compared == 8 {
                break;
            }
        }
        assert_eq!(compared, 8, "{id}: hardly any arguments are taken");
        let words: Vec<_> = source.split(|c: char| !(c.is_alphanumeric() || c == '_')).collect();
        let named = |p: &registry::Parameter| {
            words
                .iter()
                .any(|w| *w == p.name || w.strip_prefix(p.name).is_some_and(|rest| rest.starts_with('_')))
        };
        let missing: Vec<_> = model.parameters.iter().filter(|p| !named(p)).collect();
        assert!(missing.is_empty(), "{id}: {missing:?}");
    }
}

#[test]
fn every_numbered_equation_is_typeset_or_has_a_reason() {
    let numbered: BTreeSet<_> =
        registry::all().filter(|m| m.source().contains("eq ")).map(|m| m.id).collect();
    let typeset: BTreeSet<_> = EQUATIONS.iter().flat_map(|e| e.1).map(|e| e.0).collect();
    let left_out: BTreeSet<_> = NOT_TYPESET.iter().map(|e| e.1).collect();
    assert!(numbered.len() > 100, "{}", numbered.len());
    let forgotten: Vec<_> =
        numbered.iter().filter(|id| !typeset.contains(*id) && !left_out.contains(*id)).collect();
    assert!(forgotten.is_empty(), "{forgotten:?}");
    assert!(left_out.is_subset(&numbered) && left_out.is_disjoint(&typeset), "{left_out:?}");
    assert!(NOT_TYPESET.iter().all(|e| !e.2.is_empty()));
    for (document, equations) in EQUATIONS {
        assert_eq!(of(document).len(), equations.len(), "{document:?}");
    }
}
