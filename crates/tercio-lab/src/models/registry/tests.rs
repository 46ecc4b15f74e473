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
        // Without arguments, a formula computes a result or reports a missing one.
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

#[test]
fn missing_values_are_reported_with_their_meaning() {
    let message = evaluate("eldridge.3.2", &Arguments::new()).unwrap_err().to_string();
    assert_eq!(
        message,
        "eldridge.3.2 needs a value for 'v', point [x, y, z]; for a projection in the eye's coordinates \
         ([number, number, number])"
    );
}

/// The page that lists the formula of each equation.
const PAGE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/laboratory/formulas.md");

/// The numbers of the equations under each heading of the page; chapters with their last equation.
const NUMBERED: [(&str, &[(&str, u32)]); 3] = [
    ("## 000", &[("3.", 15), ("4.", 12), ("5.", 10), ("6.", 9), ("7.", 6), ("8.", 17)]),
    ("## 001", &[("2.", 11), ("3.", 13), ("4.", 7)]),
    ("## 003", &[("", 14)]),
];

/// The cells of the table under a heading, up to the next one.
fn rows(page: &str, heading: &str) -> Vec<Vec<String>> {
    let after = page.lines().skip_while(|l| !l.starts_with(heading)).skip(1);
    let table = after.take_while(|l| !l.starts_with('#')).filter(|l| l.starts_with("| "));
    table.skip(1).map(|l| l.trim_matches('|').split('|').map(|c| c.trim().to_owned()).collect()).collect()
}

#[test]
fn every_equation_has_its_formula_on_the_page_and_every_formula_its_line() {
    let page = std::fs::read_to_string(PAGE).unwrap();
    let named: BTreeSet<_> = page.split('`').skip(1).step_by(2).filter(|id| !id.contains(' ')).collect();
    let ids: BTreeSet<_> = all().map(|m| m.id).collect();
    let other: BTreeSet<_> = ["as-printed"].into();
    let unknown: Vec<_> = named.iter().filter(|id| !ids.contains(*id) && !other.contains(*id)).collect();
    assert!(unknown.is_empty(), "no such formulas: {unknown:?}");
    let lost: Vec<_> = ids.difference(&named).collect();
    assert!(lost.is_empty(), "not on the page: {lost:?}");
    for (heading, chapters) in NUMBERED {
        let numbers =
            chapters.iter().flat_map(|(chapter, last)| (1..=*last).map(move |k| format!("{chapter}{k}")));
        let found: Vec<_> = rows(&page, heading).into_iter().map(|row| row[0].clone()).collect();
        assert_eq!(found, numbers.collect::<Vec<_>>(), "{heading}");
    }
}

#[test]
fn a_line_of_the_page_says_what_its_first_formula_says() {
    let page = std::fs::read_to_string(PAGE).unwrap();
    for line in page.lines().filter(|l| l.starts_with("| ") && l.contains('`')) {
        let id = line.split('`').nth(1).unwrap();
        let what = line.split('|').nth(2).unwrap().trim();
        assert_eq!(what, find(id).unwrap().what, "{id}");
    }
}

fn message(id: &str, values: &[(&str, f64)]) -> String {
    evaluate(id, &given(values)).map_or_else(|e| e.to_string(), |value| value.to_string())
}

#[test]
fn what_cannot_be_is_refused() {
    assert_eq!(
        message("mcmanus.6", &[("A", 2.0), ("N", 0.5)]),
        "mcmanus.6: N: mean area of the polygons' bounding boxes: expected at least 1, found 0.5"
    );
    assert_eq!(
        message("eldridge.excess", &[("worst", 1.0), ("p", 1e6)]),
        "eldridge.excess: these arguments give -976, and a count cannot be below zero"
    );
    assert_eq!(
        message("overlap.2.1", &[("W", 0.0), ("H", 3.0), ("w", 1.0), ("h", 1.0)]),
        "overlap.2.1: the formula has no finite value for these arguments; note that 0 is given for W"
    );
    // Lists of numbers have no NaN either, except those read from a table of the scan.
    assert!(message("eldridge.stage-destinations", &[("n", 0.0), ("d", 1.0)]).contains("at least 1"));
    // Arguments that would take too long are rejected.
    assert!(message("overlap.pixel-boxes-counted", &[("A", 1e9), ("w", 5.0)]).contains("at most 4096"));
    assert!(message("eldridge.copies", &[("b", 1.0), ("n", 1e12), ("m", 1e12)]).contains("at most 1048576"));
}

#[test]
fn similar_names_are_suggested() {
    let near = |id: &str| match find(id) {
        Err(ModelError::UnknownModel { near, .. }) => near,
        other => panic!("{other:?}"),
    };
    assert_eq!(near("eldrige.5.6")[0], "eldridge.5.6");
    assert_eq!(near("5.6")[0], "eldridge.5.6");
    assert_eq!(near("mcmanus.optimum")[0], "mcmanus.optimal-measured");
    assert!(near("").is_empty() && near("quaternion").is_empty());
    assert!(search("eldridge.8.").iter().all(|m| m.id.starts_with("eldridge.8.")));
    assert!(search("Sort-Twice").iter().any(|m| m.id == "eldridge.6.8"));
    assert!(search("quaternion").is_empty());
}
