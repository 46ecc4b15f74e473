//! The table of published numbers, and its parser.

use serde::{Deserialize, Serialize};

use super::ToleranceSource;
use crate::models::registry::{Arguments, Value};

/// A row: one published number.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Number {
    /// Its name, the same as in the list of all numbers of the five documents.
    pub id: String,
    /// The number of the document, as `000`.
    #[serde(skip)]
    pub document: String,
    /// Chapter, equation, table or figure.
    pub place: String,
    /// The result of a correct computation, in `unit`; an illegible cell is NaN.
    pub expected: Value,
    /// The unit of `expected`, `tolerance` and `printed`; without it, the base unit of the formula.
    #[serde(default)]
    pub unit: Option<String>,
    /// Largest absolute difference from `expected`, and from what is printed.
    pub tolerance: f64,
    /// Where a tolerance comes from that the digits of the print do not explain.
    #[serde(default)]
    pub tolerance_from: Option<ToleranceSource>,
    /// On which side of the print ours has to lie, if the words say it: over, almost, no more than.
    #[serde(default)]
    pub side: Option<Side>,
    /// The number in the document, if it is legible.
    #[serde(default)]
    pub printed: Option<Value>,
    /// What the equation gives as it is printed, if no number is printed and the equation is wrong.
    #[serde(default)]
    pub as_printed: Option<Value>,
    /// Whether the equation that computes it is wrong, as it is printed or as it was meant: its value is not ours, and makes no
    /// print agree.
    #[serde(default)]
    pub wrong_equation: bool,
    /// Our reading of why the print is contradicted, why nothing is printed, or what the number stands for.
    #[serde(default)]
    pub why: Option<String>,
    /// The row that has the same print: one number of the document, computed in another form or from other inputs.
    #[serde(default)]
    pub same_print_as: Option<String>,
    /// How the printed number relates to the expected one.
    pub standing: Standing,
    /// How the value is obtained.
    #[serde(default)]
    pub basis: Basis,
    /// The entry of the registry that computes it.
    pub model: String,
    /// The arguments of that entry; others have their defaults.
    #[serde(default)]
    pub given: Arguments,
}

/// A side of a printed number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Side {
    /// Not above it: "almost", "nearly", "no more than".
    Below,
    /// Not below it: "over".
    Above,
}

/// How a printed number relates to the formula that it belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Standing {
    /// It is the formula's value in the digits printed, or the formula is correct and nothing is printed.
    Exact,
    /// It is stated approximately in the text, or off by a small amount that is stated.
    Rounded,
    /// Formula or cell is damaged in the scan and was restored.
    Restored,
    /// It contradicts the author's own formula or another of his numbers.
    Contradicted,
}

/// How a value is obtained.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Basis {
    /// The document's own formula computes it.
    #[default]
    Computed,
    /// Something else than the document's formula computes it: it is counted, listed or simulated.
    Counted,
    /// It was measured on a scene that is lost; it is read from the scan, and the reading is checked against the cost
    /// model.
    Read,
}

/// A mistake in the table of published numbers.
#[derive(Debug, thiserror::Error)]
#[error("published numbers of document {document}: {source}")]
pub struct TableError {
    /// The document's number.
    pub document: &'static str,
    /// The line, and what was expected.
    #[source]
    pub source: toml::de::Error,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    document: String,
    number: Vec<Number>,
}

const FILES: [(&str, &str); 5] = [
    ("000", include_str!("../../data/published/eldridge.toml")),
    ("001", include_str!("../../data/published/hybris.toml")),
    ("002", include_str!("../../data/published/parks.toml")),
    ("003", include_str!("../../data/published/mcmanus.toml")),
    ("004", include_str!("../../data/published/ortega.toml")),
];

/// All published numbers, in the order of the documents.
///
/// # Errors
/// The table has a mistake, reported with its line.
pub fn numbers() -> Result<Vec<Number>, TableError> {
    let mut all = Vec::new();
    for (document, text) in FILES {
        let file: File = toml::from_str(text).map_err(|source| TableError { document, source })?;
        all.extend(file.number.into_iter().map(|n| Number { document: file.document.clone(), ..n }));
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::models::registry;

    #[test]
    fn every_row_names_a_formula_and_no_row_is_there_twice() {
        let all = numbers().unwrap();
        assert_eq!(all.len(), 551);
        let ids: BTreeSet<_> = all.iter().map(|n| &n.id).collect();
        assert_eq!(ids.len(), all.len());
        for number in &all {
            registry::find(&number.model).unwrap_or_else(|e| panic!("{}: {e}", number.id));
        }
    }

    #[test]
    fn rows_of_one_print_print_the_same_and_a_contradiction_belongs_to_the_row_that_agrees() {
        let all = numbers().unwrap();
        for number in all.iter().filter(|n| n.same_print_as.is_some()) {
            let of = all.iter().find(|n| Some(&n.id) == number.same_print_as.as_ref());
            let of = of.unwrap_or_else(|| panic!("{}: no row for its print", number.id));
            assert!(of.same_print_as.is_none() && of.document == number.document, "{}", number.id);
            assert!(number.printed.is_some() && number.printed == of.printed, "{}", number.id);
        }
        // 84 is also the size of a descriptor, 16 the best array of other images, 2 a factor of other sections.
        const BY_CHANCE: [&str; 4] = ["E6.5", "M-fig7-true", "E4.sf-sm", "E4.sf-sm-corrected"];
        let print = |n: &Number| n.printed.clone().map(|printed| (n.document.clone(), printed.to_string()));
        for number in all.iter().filter(|n| n.standing == Standing::Contradicted && n.printed.is_some()) {
            let is_other = |n: &&Number| n.id != number.id && print(n) == print(number);
            for other in all.iter().filter(is_other) {
                let key = |n: &Number| n.same_print_as.clone().unwrap_or_else(|| n.id.clone());
                let together = key(other) == key(number) || BY_CHANCE.contains(&number.id.as_str());
                assert!(together, "{} and {} print the same", number.id, other.id);
            }
        }
    }

    #[test]
    fn a_wrong_equation_has_a_corrected_form_of_its_print() {
        let all = numbers().unwrap();
        for number in &all {
            assert!(number.wrong_equation || !number.model.ends_with("-as-printed"), "{}", number.id);
        }
        // Those that print nothing have no other row to be the correct one.
        for number in all.iter().filter(|n| n.wrong_equation && n.printed.is_some()) {
            let print = |n: &Number| n.same_print_as.clone().unwrap_or_else(|| n.id.clone());
            let is_other = |n: &Number| !n.wrong_equation && print(n) == print(number);
            assert!(number.why.is_some() && all.iter().any(is_other), "{}", number.id);
        }
    }

    /// Other forms of listed prints, which the list of all numbers does not have.
    const OTHER_FORMS: [&str; 2] = ["E4.sf-sm-4.9", "E4.sf-sm-corrected"];

    /// Rows whose printed number differs from the list of all numbers, because the document prints none there.
    const NOT_IN_PRINT: [&str; 15] = [
        "EA-fig2",
        "E3.8-C",
        "E3.14-C",
        "E8.T1-",
        "H2.10-general",
        "P-45-4",
        "P-45-16",
        "P-fig19",
        "M-C-",
        "M-C49",
        "M-eq11-wrong",
        "M-fig7-true",
        "M-brute-8-2",
        "M-brute-5-16",
        "M-brute-20-8",
    ];

    #[test]
    fn what_is_printed_is_what_the_list_of_all_numbers_says() {
        let Some(data) = tercio_testkit::require_shared("published numbers") else { return };
        let list: Vec<serde_json::Value> =
            serde_json::from_str(&std::fs::read_to_string(data.join("../seeds/published.json")).unwrap())
                .unwrap();
        for number in numbers().unwrap() {
            let Some(listed) = list.iter().find(|l| l["id"] == number.id.as_str()) else {
                // Cells of table 8.1 that the list has as arguments.
                let known = number.place.contains("table 8.1") || OTHER_FORMS.contains(&number.id.as_str());
                assert!(known, "{} is not listed", number.id);
                continue;
            };
            let same = match (&number.printed, &listed["printed"]) {
                (None, printed) => printed.is_null(),
                (Some(printed), listed) => {
                    let listed: Value =
                        serde_json::from_str(&listed.to_string().replace("null", "\"?\"")).unwrap();
                    printed.to_string().replace('?', "\"?\"") == listed.to_string().replace('?', "\"?\"")
                }
            };
            let corrected = NOT_IN_PRINT.iter().any(|id| number.id.starts_with(id));
            assert_eq!(same, !corrected, "{}: {:?}, listed {}", number.id, number.printed, listed["printed"]);
        }
    }
}
