//! Computed beside published numbers, and the verdict that follows.

use super::Verdict;
use super::hidden::{Fit, common, in_words, number_and_half_digit};
use crate::published::{self, Agreement, Basis, Standing, TableError, ToleranceSource};

/// Where a computed number comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Evidence {
    /// A simulation, a count, another derivation than the document's.
    Independent,
    /// The document's own formula with its own inputs.
    Formula,
    /// An input was chosen so that it comes out.
    Input,
}

/// Pairs of computed and published numbers, claims about shapes, and sweeps of inputs that are not stated. The verdict is
/// derived from them.
#[derive(Clone, Debug, Default)]
pub struct Comparison {
    pairs: Vec<Pair>,
    claims: Vec<(String, bool)>,
    /// Alternatives: of the sweeps of one group at least one has to meet print.
    fits: Vec<Vec<Fit>>,
    /// Printed numbers that a correct computation contradicts, with our reading of why.
    contradicted: Vec<String>,
    /// Numbers without a print.
    not_printed: usize,
    /// Readings of the scan.
    read: usize,
    correction: Option<String>,
}

#[derive(Clone, Debug)]
struct Pair {
    name: String,
    ours: f64,
    published: f64,
    tolerance: f64,
    from: ToleranceSource,
    evidence: Evidence,
}

impl Comparison {
    /// An empty comparison.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a number that is simulated or counted, and the published one as it is printed: its last digit is the
    /// tolerance.
    pub fn add_printed(&mut self, name: impl Into<String>, ours: f64, printed: &str) {
        let (published, half) = number_and_half_digit(printed);
        self.add(name, ours, published, half, ToleranceSource::LastDigit);
    }

    /// Adds a number that is simulated or counted, and the published one; `tolerance` is absolute, and comes `from`
    /// somewhere.
    pub fn add(
        &mut self,
        name: impl Into<String>,
        ours: f64,
        published: f64,
        tolerance: f64,
        from: ToleranceSource,
    ) {
        self.push(name.into(), [ours, published, tolerance], from, Evidence::Independent);
    }

    /// Adds a number that an input was chosen to give.
    pub fn add_constructed(
        &mut self,
        name: impl Into<String>,
        ours: f64,
        published: f64,
        tolerance: f64,
        from: ToleranceSource,
    ) {
        self.push(name.into(), [ours, published, tolerance], from, Evidence::Input);
    }

    fn push(&mut self, name: String, numbers: [f64; 3], from: ToleranceSource, evidence: Evidence) {
        let [ours, published, tolerance] = numbers;
        self.pairs.push(Pair { name, ours, published, tolerance, from, evidence });
    }

    /// Adds a property of the shape that the document states or draws, and whether our result has it.
    pub fn claim(&mut self, what: impl Into<String>, holds: bool) {
        self.claims.push((what.into(), holds));
    }

    /// Adds a printed number that depends on an input that is not stated. Sweeps of the same input have to meet print
    /// for a value that they have in common.
    pub fn fit(&mut self, fit: Fit) {
        self.fits.push(vec![fit]);
    }

    /// Adds a printed number that may mean one of several things; one of them has to meet print.
    pub fn fit_one_of(&mut self, readings: Vec<Fit>) {
        self.fits.push(readings);
    }

    /// Says what was corrected. `needed`: whether the numbers are wrong without it; a correction that changes nothing is
    /// none.
    pub fn correct(&mut self, correction: impl Into<String>, needed: bool) {
        if needed {
            self.correction = Some(correction.into());
        }
    }

    /// Whether all numbers are within their tolerances, all claims hold and all sweeps meet print; false if there is
    /// nothing to compare.
    pub fn agrees(&self) -> bool {
        let numbers = self.pairs.len() + self.not_printed + self.read + self.contradicted.len();
        let some = numbers + self.claims.len() + self.fits.len() > 0;
        some && self.pairs.iter().all(Pair::agrees)
            && self.claims.iter().all(|c| c.1)
            && self.fits.iter().all(|readings| readings.iter().any(|f| !f.intervals().is_empty()))
            && self.inputs().iter().all(|(_, numbers, intervals)| *numbers < 2 || !intervals.is_empty())
    }

    /// The swept inputs, how many numbers each has to explain, and the intervals in which it explains all of them.
    /// Numbers with several meanings stand for themselves.
    fn inputs(&self) -> Vec<(&'static str, usize, Vec<[f64; 2]>)> {
        let mut all: Vec<(&'static str, usize, Vec<[f64; 2]>)> = Vec::new();
        for fit in self.fits.iter().filter(|readings| readings.len() == 1).flatten() {
            let intervals = fit.intervals();
            match all.iter_mut().find(|i| i.0 == fit.input) {
                Some(known) => {
                    known.1 += 1;
                    known.2 = common(&known.2, &intervals);
                }
                None => all.push((fit.input, 1, intervals)),
            }
        }
        all
    }

    /// The verdict: contradicted if something does not agree, or if no fewer printed numbers are contradicted than agree;
    /// otherwise by what was compared.
    pub fn verdict(&self) -> Verdict {
        let has = |evidence| self.pairs.iter().any(|p| p.evidence == evidence);
        if !self.agrees() || self.is_outnumbered() {
            return self.contradicted();
        }
        let within = self.within();
        if let Some(correction) = &self.correction {
            return Verdict::ReproducedAfterCorrection { within, correction: correction.clone() };
        }
        if !self.fits.is_empty() {
            return self.qualitative("Inputs are not stated.");
        }
        // A verdict is no better than the weakest of its numbers.
        if has(Evidence::Formula) {
            Verdict::Restated { within }
        } else if has(Evidence::Independent) {
            Verdict::Reproduced { within }
        } else if has(Evidence::Input) {
            Verdict::ByConstruction { within }
        } else {
            self.qualitative("No numbers are printed.")
        }
    }

    /// Qualitative, for the reason `why`, if everything agrees; otherwise contradicted.
    pub fn qualitative(&self, why: impl Into<String>) -> Verdict {
        if self.agrees() { self.of_our_model(why) } else { self.contradicted() }
    }

    /// Qualitative, for the reason `why`, whatever fails: what is compared is no print, but a model of ours.
    pub fn of_our_model(&self, why: impl Into<String>) -> Verdict {
        let (agrees, fails) = (self.within(), sentence(&self.failing()));
        Verdict::Qualitative { why: why.into(), agrees, fails }
    }

    /// Contradicted: what fails comes first.
    fn contradicted(&self) -> Verdict {
        let parts =
            [("not so: ", self.failing()), ("", self.contradicting()), ("what agrees: ", self.agreeing())];
        let said = parts.iter().filter(|part| !part.1.is_empty());
        let said: Vec<_> = said.map(|(head, part)| format!("{head}{}", part.join("; "))).collect();
        let why = if said.is_empty() { "Nothing was compared.".into() } else { sentence(&said) };
        Verdict::Contradicted { why }
    }

    /// What holds, printed numbers that are contradicted included.
    fn within(&self) -> String {
        sentence(&[self.agreeing(), self.contradicting()].concat())
    }

    /// Whether no fewer printed numbers are contradicted than agree.
    fn is_outnumbered(&self) -> bool {
        !self.contradicted.is_empty() && self.contradicted.len() >= self.pairs.len()
    }

    /// What fails: claims that do not hold, numbers beyond their tolerances, sweeps that do not meet print.
    fn failing(&self) -> Vec<String> {
        let mut parts: Vec<_> = self.claims.iter().filter(|c| !c.1).map(|c| c.0.clone()).collect();
        let missing: Vec<_> = self.pairs.iter().filter(|p| !p.agrees()).map(Pair::miss).collect();
        if !missing.is_empty() {
            let all = self.pairs.len();
            parts.push(format!("{} of {all} numbers miss: {}", missing.len(), missing.join("; ")));
        }
        let misses = |readings: &&Vec<Fit>| readings.iter().all(|fit| fit.intervals().is_empty());
        parts.extend(self.fits.iter().filter(misses).flatten().map(Fit::text));
        for (input, numbers, intervals) in self.inputs() {
            if numbers > 1 && intervals.is_empty() {
                parts.push(format!("no {input} gives all {numbers} numbers"));
            }
        }
        parts
    }

    /// The printed numbers that a correct computation contradicts.
    fn contradicting(&self) -> Vec<String> {
        let all = self.contradicted.join(" ");
        let words = || format!("printed numbers that are contradicted: {}", all.trim_end_matches('.'));
        if self.contradicted.is_empty() { Vec::new() } else { vec![words()] }
    }

    /// What holds.
    fn agreeing(&self) -> Vec<String> {
        let mut parts = self.words_of_numbers();
        for (count, what) in
            [(self.not_printed, "not printed"), (self.read, "read from the scan, not computed")]
        {
            if count > 0 {
                parts.push(format!("{count} numbers are {what}"));
            }
        }
        let meets = |readings: &&Vec<Fit>| readings.iter().any(|fit| !fit.intervals().is_empty());
        parts.extend(self.fits.iter().filter(meets).flatten().map(Fit::text));
        for (input, numbers, intervals) in self.inputs() {
            if numbers > 1 && !intervals.is_empty() {
                parts.push(format!("{input} of {} gives all {numbers} numbers", in_words(&intervals)));
            }
        }
        parts.extend(self.claims.iter().filter(|c| c.1).map(|c| c.0.clone()));
        parts
    }

    /// The pairs that agree, by evidence, their largest deviation, and where their tolerances come from; empty if none does.
    fn words_of_numbers(&self) -> Vec<String> {
        let agreeing: Vec<_> = self.pairs.iter().filter(|p| p.agrees()).collect();
        let count = |evidence| agreeing.iter().filter(|p| p.evidence == evidence).count();
        let kinds = [
            (count(Evidence::Independent), "simulated or counted"),
            (count(Evidence::Formula), "by the document's formula"),
            (count(Evidence::Input), "by construction"),
        ];
        let kinds: Vec<_> =
            kinds.iter().filter(|k| k.0 > 0).map(|(count, kind)| format!("{count} {kind}")).collect();
        let relative = |p: &Pair| if p.published == 0.0 { 0.0 } else { (p.ours / p.published - 1.0).abs() };
        let worst = agreeing.iter().max_by(|a, b| relative(a).total_cmp(&relative(b)));
        let mut sources: Vec<_> = agreeing.iter().map(|p| p.from.text()).collect();
        sources.sort_unstable();
        sources.dedup();
        let words = worst.map(|worst| {
            let (off, at) = (100.0 * relative(worst), &worst.name);
            let (kinds, sources) = (kinds.join(", "), sources.join(", "));
            format!("{kinds} numbers agree; largest deviation {off:.2} % at {at}; tolerances: {sources}")
        });
        words.into_iter().collect()
    }

    /// Compares the published numbers whose names begin with one of `prefixes`, or are `E5.9` for `E5.9=`: printed ones
    /// with the print, ours counting as the document's formula unless the row is counted or simulated; contradicted ones
    /// and those without a print are listed.
    ///
    /// # Errors
    /// The table has a mistake.
    pub fn of_published(prefixes: &[&str]) -> Result<Self, TableError> {
        let mut comparison = Self::new();
        for number in published::numbers()?.into_iter().filter(|n| is_named(&n.id, prefixes)) {
            let check = published::check(number);
            let number = &check.number;
            let id = number.id.clone();
            match check.agreement() {
                Agreement::NotPrinted => comparison.not_printed += 1,
                Agreement::Read => comparison.read += 1,
                Agreement::Unexplained => comparison.claim(id, false),
                Agreement::ContradictsPrint => {
                    let why = number.why.as_deref().unwrap_or_default();
                    comparison.contradicted.push(format!("{id}: {why}"));
                }
                Agreement::AgreesWithPrint => {
                    let evidence = if number.basis == Basis::Counted {
                        Evidence::Independent
                    } else {
                        Evidence::Formula
                    };
                    // Lists agree as a whole, and stand for one number.
                    let of = |value: Option<&crate::models::registry::Value>| {
                        value.and_then(crate::models::registry::Value::as_number).unwrap_or(0.0)
                    };
                    let numbers = [of(check.ours.as_ref().ok()), of(check.print()), number.tolerance];
                    let from = number.tolerance_source().unwrap_or(ToleranceSource::Exact);
                    comparison.push(id, numbers, from, evidence);
                }
            }
        }
        Ok(comparison)
    }

    /// The verdict for [`Comparison::of_published`]: after `correction` if one of the numbers had to be restored or is
    /// contradicted by its own document.
    ///
    /// # Errors
    /// The table has a mistake.
    pub fn verdict_of_published(prefixes: &[&str], correction: &str) -> Result<Verdict, TableError> {
        let mut comparison = Self::of_published(prefixes)?;
        let corrected = published::numbers()?.into_iter().any(|n| {
            is_named(&n.id, prefixes) && matches!(n.standing, Standing::Restored | Standing::Contradicted)
        });
        comparison.correct(correction, corrected);
        Ok(comparison.verdict())
    }
}

/// Whether a number's name begins with one of `prefixes`; one that ends with `=` is the whole name.
pub(super) fn is_named(id: &str, prefixes: &[&str]) -> bool {
    prefixes.iter().any(|p| p.strip_suffix('=').map_or_else(|| id.starts_with(p), |whole| id == whole))
}

impl Pair {
    fn agrees(&self) -> bool {
        // As in the published table: rounding in binary must not decide at the edge of the tolerance.
        let rounding = if self.tolerance > 0.0 { 4.0 * f64::EPSILON * self.published.abs() } else { 0.0 };
        (self.ours - self.published).abs() <= self.tolerance + rounding
    }

    /// Both numbers and the tolerance, in words.
    fn miss(&self) -> String {
        let Self { name, ours, published, tolerance, from, .. } = self;
        format!("{name}: ours {ours}, published {published} ± {tolerance} ({})", from.text())
    }
}

/// Parts of a sentence; empty if there are none.
fn sentence(parts: &[String]) -> String {
    if parts.is_empty() { String::new() } else { format!("{}.", parts.join("; ")) }
}

#[cfg(test)]
mod tests;
