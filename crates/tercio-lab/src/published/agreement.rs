//! How computed numbers relate to the print: four classes, found by comparing.

use serde::Serialize;

use super::tolerance::last_digit;
use super::{Basis, Check, Side, ToleranceSource};
use crate::models::registry::Value;

/// How a computed number relates to the document.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Agreement {
    /// It is the printed number, within the tolerance.
    AgreesWithPrint,
    /// The document prints no number here; ours is compared with an independent computation.
    NotPrinted,
    /// It is not the printed number, or only a wrong equation gives that; the row says why, in our reading.
    ContradictsPrint,
    /// It is a reading of the damaged scan, not a computation.
    Read,
    /// It is neither the printed number nor the corrected one, or the difference is not explained: a mistake of ours.
    Unexplained,
}

impl Agreement {
    /// All classes, in the order of a summary.
    pub const ALL: [Self; 5] =
        [Self::AgreesWithPrint, Self::NotPrinted, Self::ContradictsPrint, Self::Read, Self::Unexplained];

    /// The class in words.
    pub fn text(self) -> &'static str {
        match self {
            Self::AgreesWithPrint => "agrees with print",
            Self::NotPrinted => "not printed",
            Self::ContradictsPrint => "contradicts print",
            Self::Read => "read from the scan, not computed",
            Self::Unexplained => "unexplained",
        }
    }
}

impl Check {
    /// How the computed number relates to the print. Nothing but the numbers decides, except whether a value is a
    /// reading, or an equation wrong.
    pub fn agreement(&self) -> Agreement {
        let number = &self.number;
        let Ok(ours) = &self.ours else { return Agreement::Unexplained };
        if !self.holds {
            return Agreement::Unexplained;
        }
        if number.basis == Basis::Read {
            return Agreement::Read;
        }
        let Some(print) = self.print() else { return Agreement::NotPrinted };
        if self.gives_print() {
            match (number.wrong_equation, &number.why) {
                (false, _) => Agreement::AgreesWithPrint,
                (true, Some(_)) => Agreement::ContradictsPrint,
                (true, None) => Agreement::Unexplained,
            }
        } else if number.why.is_some() && (number.tolerance_from.is_some() || is_beyond_rounding(ours, print))
        {
            Agreement::ContradictsPrint
        } else {
            Agreement::Unexplained
        }
    }

    /// Whether ours is what is printed, on the side that its words name: within the tolerance, or anywhere if it is a bound.
    /// False if nothing is printed.
    pub fn gives_print(&self) -> bool {
        let (Ok(ours), Some(print)) = (&self.ours, self.print()) else { return false };
        let on_side = match (self.number.side, ours.as_number(), print.as_number()) {
            (None, ..) => true,
            (Some(Side::Below), Some(ours), Some(print)) => ours <= print,
            (Some(Side::Above), Some(ours), Some(print)) => ours >= print,
            _ => false,
        };
        let is_bound =
            self.number.tolerance_from == Some(ToleranceSource::Bound) && self.number.side.is_some();
        on_side && (is_bound || ours.agrees_with(print, self.number.tolerance))
    }

    /// The printed number, or what the printed equation gives.
    pub fn print(&self) -> Option<&Value> {
        self.number.printed.as_ref().or(self.number.as_printed.as_ref())
    }

    /// What is printed, in words.
    pub fn print_text(&self) -> String {
        match (&self.number.printed, &self.number.as_printed) {
            (Some(printed), _) => printed.to_string(),
            (None, Some(value)) => format!("the equation gives {value}"),
            (None, None) => "nothing".into(),
        }
    }

    /// What is computed, in words and `unit`: nothing if the row is a reading.
    pub fn ours_text(&self, unit: &str) -> String {
        match &self.ours {
            Ok(_) if self.number.basis == Basis::Read => "not computed".into(),
            Ok(ours) => format!("{ours}{unit}"),
            Err(error) => error.to_string(),
        }
    }

    /// How far a reading may be off, in words; None if the row is computed. What is read is digits: the last one may be rounded,
    /// and some may be read otherwise than the scan shows them.
    pub fn reading_error(&self) -> Option<String> {
        if self.number.basis != Basis::Read {
            return None;
        }
        let list = |value: &Value| match value {
            Value::List(items) => items.clone(),
            _ => Vec::new(),
        };
        let scanned = self.number.given.get("cells").map(list).unwrap_or_default();
        let mut otherwise = Vec::new();
        let mut open = 0;
        for (cell, read) in scanned.iter().zip(list(&self.number.expected)) {
            let (Value::Text(cell), Some(read)) = (cell, read.as_number()) else { continue };
            if read.is_nan() {
                open += 1;
            } else if cell.parse() != Ok(read) {
                otherwise.push(format!("{cell} read as {read}"));
            }
        }
        let mut parts = vec!["half of each last digit".to_owned()];
        parts.extend((!otherwise.is_empty()).then(|| otherwise.join(", ")));
        parts.extend((open > 0).then(|| format!("{open} of {} cells open", scanned.len())));
        Some(parts.join("; "))
    }

    /// Where the tolerance comes from: what the row says, or else how the print was made from ours.
    pub fn tolerance_source(&self) -> Option<ToleranceSource> {
        if self.number.basis == Basis::Read {
            return Some(ToleranceSource::Scan);
        }
        let source = self.number.tolerance_source()?;
        let digits = self.ours.as_ref().ok().zip(self.print()).and_then(|(ours, print)| digits(ours, print));
        let (ToleranceSource::LastDigit, Some([ours, print, digit])) = (source, digits) else {
            return Some(source);
        };
        // Decimal fractions are rounded in binary.
        const BINARY: f64 = 1e-6;
        Some(if (ours - print).abs() <= (0.5 + BINARY) * digit {
            ToleranceSource::LastDigit
        } else if ((ours / digit + BINARY).trunc() - print / digit).abs() < 0.5 {
            ToleranceSource::CutOff
        } else {
            ToleranceSource::LastDigitOff
        })
    }

    /// The tolerance, or the error of a reading, and where it comes from, in words.
    pub fn tolerance_text(&self) -> String {
        let source = self.tolerance_source().map_or("not explained", ToleranceSource::text);
        let size =
            self.reading_error().unwrap_or_else(|| match (self.tolerance_source(), self.number.side) {
                (Some(ToleranceSource::Bound), Some(Side::Below)) => "not above".into(),
                (Some(ToleranceSource::Bound), Some(Side::Above)) => "not below".into(),
                (_, Some(Side::Below)) => format!("{} below", self.number.tolerance),
                (_, Some(Side::Above)) => format!("{} above", self.number.tolerance),
                (_, None) => self.number.tolerance.to_string(),
            });
        format!("{size} ({source})")
    }
}

/// How many checks are of each class, classes without any left out.
pub fn summary(checks: &[Check]) -> Vec<(Agreement, usize)> {
    let count = |class| checks.iter().filter(|c| c.agreement() == class).count();
    Agreement::ALL.map(|class| (class, count(class))).into_iter().filter(|c| c.1 > 0).collect()
}

/// Whether a number is farther from the print than rounding of its last digit explains.
fn is_beyond_rounding(ours: &Value, print: &Value) -> bool {
    digits(ours, print).map_or(ours != print, |[ours, print, digit]| (ours - print).abs() > 0.5 * digit)
}

/// Two numbers, and the unit of the last digit of the second one.
fn digits(ours: &Value, print: &Value) -> Option<[f64; 3]> {
    Some([ours.as_number()?, print.as_number()?, last_digit(print)?])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::published::{Standing, check, check_all, numbers};

    fn row(id: &str) -> super::super::Number {
        numbers().unwrap().into_iter().find(|n| n.id == id).unwrap()
    }

    #[test]
    fn every_number_has_one_of_the_four_classes() {
        let checks = check_all().unwrap();
        let of = |class| checks.iter().filter(|c| c.agreement() == class).collect::<Vec<_>>();
        let ids = |class| of(class).iter().map(|c| c.number.id.clone()).collect::<Vec<_>>();
        assert!(ids(Agreement::Unexplained).is_empty(), "{:?}", ids(Agreement::Unexplained));
        let sizes = Agreement::ALL.map(|class| of(class).len());
        assert_eq!(sizes, [376, 132, 33, 10, 0]);
        assert_eq!(sizes.iter().sum::<usize>(), checks.len());
        for check in &checks {
            let contradicted = check.agreement() == Agreement::ContradictsPrint;
            let number = &check.number;
            let of_wrong = number.wrong_equation && number.printed.is_some();
            let marked = number.standing == Standing::Contradicted || number.as_printed.is_some() || of_wrong;
            assert_eq!(contradicted, marked, "{}", check.number.id);
        }
    }

    #[test]
    fn a_contradiction_is_found_not_declared() {
        // If the document had printed 24, the same row would agree, whatever its standing says.
        let mut number = row("E4.2-sl-dense");
        assert_eq!(check(number.clone()).agreement(), Agreement::ContradictsPrint);
        number.printed = Some(Value::Number(24.0));
        assert_eq!(check(number.clone()).agreement(), Agreement::AgreesWithPrint);
        number.printed = None;
        assert_eq!(check(number).agreement(), Agreement::NotPrinted);
    }

    #[test]
    fn a_difference_without_a_reason_is_unexplained() {
        let mut number = row("E4.2-sl-dense");
        number.why = None;
        assert_eq!(check(number).agreement(), Agreement::Unexplained);
        let mut misprinted = row("E5.6");
        misprinted.printed = Some(Value::Number(27.9));
        assert_eq!(check(misprinted).agreement(), Agreement::Unexplained);
    }

    #[test]
    fn a_difference_that_rounding_explains_is_no_contradiction() {
        let beyond = |ours, print| is_beyond_rounding(&Value::Number(ours), &Value::Number(print));
        assert!(!beyond(27.3552, 27.36) && beyond(27.3452, 27.36));
    }

    #[test]
    fn a_print_in_words_is_contradicted_beyond_what_its_words_allow() {
        // "About a factor 2": rounding alone would take 1.64 for 2.
        let number = row("E4.sf-sm-corrected");
        assert_eq!(check(number.clone()).agreement(), Agreement::ContradictsPrint);
        let wider = super::super::Number { tolerance: 0.5, ..number };
        assert_eq!(check(wider).agreement(), Agreement::AgreesWithPrint);
    }

    #[test]
    fn a_wrong_equation_makes_no_print_agree() {
        let all = check_all().unwrap();
        let giving: Vec<_> = all.iter().filter(|c| c.number.wrong_equation && c.gives_print()).collect();
        assert_eq!(giving.iter().map(|c| c.number.id.as_str()).collect::<Vec<_>>(), ["M-fig7-eq11"]);
        assert_eq!(giving[0].agreement(), Agreement::ContradictsPrint);
        let without = super::super::Number { why: None, ..row("M-fig7-eq11") };
        assert_eq!(check(without).agreement(), Agreement::Unexplained);
        let right = super::super::Number { wrong_equation: false, ..row("M-fig7-eq11") };
        assert_eq!(check(right).agreement(), Agreement::AgreesWithPrint);
    }

    #[test]
    fn words_that_name_a_side_are_taken_at_their_word() {
        let printing = |id, print| {
            let number = super::super::Number { printed: Some(Value::Number(print)), ..row(id) };
            check(number).gives_print()
        };
        // 28.63 is almost 30, and neither almost 28 nor almost 31; 115 is over 100, and over 114, but not over 116.
        assert_eq!([30.0, 28.0, 31.0].map(|print| printing("E5.9fig", print)), [true, false, false]);
        assert_eq!([100.0, 114.0, 116.0].map(|print| printing("H4-100M", print)), [true, true, false]);
        assert_eq!([0.078, 0.072].map(|print| printing("M-dev", print)), [true, false]);
        assert_eq!(check(row("E5.9fig")).tolerance_text(), "1.5 below (stated in words)");
        assert_eq!(check(row("H4-100M")).tolerance_text(), "not below (stated as a bound)");
    }

    #[test]
    fn the_last_digit_is_rounded_cut_off_or_off_by_one() {
        let source = |id: &str| check(row(id)).tolerance_source();
        assert_eq!(source("E5.6"), Some(ToleranceSource::LastDigit));
        // 1,179,648 printed as 1.17 million, 0.6875 as 0.68.
        assert_eq!(source("E6-1.17"), Some(ToleranceSource::CutOff));
        assert_eq!(source("H3-68"), Some(ToleranceSource::CutOff));
        // 41,827.47 printed as 41,828.
        assert_eq!(source("M-T2P-1"), Some(ToleranceSource::LastDigitOff));
    }

    #[test]
    fn a_reading_is_never_called_computed() {
        let of = |id| check(row(id));
        assert_eq!(of("P-fig16").agreement(), Agreement::Read);
        assert_eq!(of("P-fig16").ours_text(" Mcycle"), "not computed");
        assert_eq!(of("P-fig16").tolerance_text(), "half of each last digit (reading of the scan)");
        let nineteen = "half of each last digit; 1.57 read as 1.37; 1 of 6 cells open (reading of the scan)";
        assert_eq!(of("P-fig19").tolerance_text(), nineteen);
        assert_eq!(of("E5.6").reading_error(), None);
        assert_eq!(of("E4.2-sl-dense").ours_text(" instr"), "24 instr");
        // Nor is a cell that the scan does not show a reading.
        let cells = row("P-fig19").expected;
        let Value::List(cells) = cells else { panic!("a list") };
        assert!(cells[2].as_number().is_some_and(f64::is_nan));
    }
}
