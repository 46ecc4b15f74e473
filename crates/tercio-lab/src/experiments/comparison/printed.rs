//! The published numbers of an experiment, each print compared once.

use super::{Comparison, Evidence, is_named};
use crate::experiments::{ExperimentError, Verdict};
use crate::models::registry::{self, Value};
use crate::published::{self, Agreement, Basis, Check, Number, Standing, ToleranceSource};

impl Comparison {
    /// Compares the published numbers that have one of `names`, in which `*` stands for a part between dashes and `#` for
    /// digits (`H2.15-*-32-#`): printed ones with the print, ours counting as the document's formula unless the row is counted
    /// or simulated; those without a print are counted. A print is compared once, however many rows have it: it agrees if one
    /// of them gives it, and the others are other forms. A wrong equation does not make a print agree.
    ///
    /// # Errors
    /// The table has a mistake; a name that no number has.
    pub fn of_published(names: &[&str]) -> Result<Self, ExperimentError> {
        let mut comparison = Self::new();
        let mut prints: Vec<(String, Vec<Check>)> = Vec::new();
        for number in named(names)? {
            let check = published::check(number);
            let id = check.number.id.clone();
            match check.agreement() {
                Agreement::NotPrinted => comparison.not_printed += 1,
                Agreement::Read => comparison.read += 1,
                Agreement::Unexplained => comparison.claim(id, false),
                Agreement::AgreesWithPrint | Agreement::ContradictsPrint => {
                    let print = check.number.same_print_as.clone().unwrap_or(id);
                    match prints.iter_mut().find(|p| p.0 == print) {
                        Some(known) => known.1.push(check),
                        None => prints.push((print, vec![check])),
                    }
                }
            }
        }
        for (_, checks) in prints {
            let gives = |c: &&Check| c.agreement() == Agreement::AgreesWithPrint;
            let agreeing = checks.iter().find(gives);
            let against = checks.iter().filter(|c| !gives(c)).map(contradiction);
            if let Some(check) = agreeing {
                comparison.other_forms.extend(against);
                comparison.push_check(check);
            } else {
                comparison.contradicted.push(against.collect::<Vec<_>>().join(" / "));
            }
        }
        Ok(comparison)
    }

    /// A published number that agrees.
    fn push_check(&mut self, check: &Check) {
        let number = &check.number;
        let counted = number.basis == Basis::Counted;
        let evidence = if counted { Evidence::Independent } else { Evidence::Formula };
        // Lists agree as a whole, and stand for one number.
        let of = |value: Option<&Value>| value.and_then(Value::as_number).unwrap_or(0.0);
        let from = check.tolerance_source().unwrap_or(ToleranceSource::Exact);
        let ours = of(check.ours.as_ref().ok());
        // Ours is as far from a bound that it keeps as it may be, which is no deviation.
        let print = if from == ToleranceSource::Bound { ours } else { of(check.print()) };
        let numbers = [ours, print, number.tolerance];
        self.push(number.id.clone(), numbers, from, evidence);
    }

    /// The verdict for [`Comparison::of_published`]: after `correction` if a printed number agrees only with a formula that had
    /// to be restored or corrected.
    ///
    /// # Errors
    /// The table has a mistake; a name that no number has.
    pub fn verdict_of_published(names: &[&str], correction: &str) -> Result<Verdict, ExperimentError> {
        let mut comparison = Self::of_published(names)?;
        comparison.correct(correction, named(names)?.iter().any(needs_correction));
        Ok(comparison.verdict())
    }
}

/// The published numbers that have one of `names`.
///
/// # Errors
/// The table has a mistake; a name that no number has.
pub(in crate::experiments) fn named(names: &[&str]) -> Result<Vec<Number>, ExperimentError> {
    let mut numbers = published::numbers()?;
    let is_no_number = |name: &&&str| !numbers.iter().any(|n| is_named(&n.id, &[**name]));
    if let Some(name) = names.iter().find(is_no_number) {
        return Err(format!("no published number is called '{name}'").into());
    }
    numbers.retain(|n| is_named(&n.id, names));
    Ok(numbers)
}

/// Whether a printed number comes out, but not from its formula as it is printed, or only from one that was restored.
fn needs_correction(number: &Number) -> bool {
    let (Some(printed), Agreement::AgreesWithPrint) =
        (&number.printed, published::check(number.clone()).agreement())
    else {
        return false;
    };
    let as_printed = registry::evaluate(&format!("{}-as-printed", number.model), &number.given);
    number.standing == Standing::Restored
        || as_printed.is_ok_and(|value| !value.agrees_with(printed, number.tolerance))
}

/// A number that contradicts its print: both, and our reading of why.
fn contradiction(check: &Check) -> String {
    let number = &check.number;
    let unit = number.unit.as_deref().map_or(String::new(), |unit| format!(" {unit}"));
    let ours = check.ours.as_ref().map_or_else(ToString::to_string, |value| match value.as_number() {
        Some(number) => format!("{number:.5e}").parse::<f64>().unwrap_or(number).to_string(),
        None => value.to_string(),
    });
    let why = number.why.as_deref().unwrap_or_default().trim_end_matches('.');
    let by = if check.gives_print() { ", but by a wrong equation" } else { "" };
    format!("{}: printed {}{unit}, ours {ours}{unit}{by} ({why})", number.id, check.print_text())
}
