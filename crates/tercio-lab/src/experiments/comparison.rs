//! Computed beside published numbers, and the verdict that follows.

mod printed;

pub(super) use printed::named;

use super::hidden::{Fit, common, in_words, number_and_half_digit, union};
use super::{Cell, Table, Verdict, unstated};
use crate::published::ToleranceSource;

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
/// derived from them: by what there is, never by how much of it.
#[derive(Clone, Debug, Default)]
pub struct Comparison {
    pairs: Vec<Pair>,
    claims: Vec<(String, bool)>,
    /// Alternatives: of the sweeps of one group at least one has to meet print.
    fits: Vec<Vec<Fit>>,
    /// Printed numbers that a correct computation contradicts, each once, with our reading of why.
    contradicted: Vec<String>,
    /// Other forms of printed numbers that agree: an equation as it is printed, another input.
    other_forms: Vec<String>,
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

    /// Adds printed numbers that are measurements, read and not computed.
    pub fn add_read(&mut self, numbers: usize) {
        self.read += numbers;
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

    /// Whether nothing disagrees: all numbers are within their tolerances, no print is contradicted, all claims hold and all
    /// sweeps meet print; false if there is nothing to compare.
    pub fn agrees(&self) -> bool {
        let numbers = self.pairs.len() + self.not_printed + self.read;
        numbers + self.claims.len() + self.fits.len() > 0 && self.failing().is_empty()
    }

    /// The swept inputs, how many numbers each has to explain, and the intervals in which it explains all of them, a
    /// number with several meanings in one of them. Numbers that no value of the input gives are not among them.
    fn inputs(&self) -> Vec<(&'static str, usize, Vec<[f64; 2]>)> {
        let mut all: Vec<(&'static str, usize, Vec<[f64; 2]>)> = Vec::new();
        for readings in self.fits.iter().filter(|readings| readings.iter().any(Fit::meets)) {
            let Some(input) = input_of(readings) else { continue };
            let intervals = union(readings.iter().map(Fit::intervals));
            match all.iter_mut().find(|i| i.0 == input) {
                Some(known) => {
                    known.1 += 1;
                    known.2 = common(&known.2, &intervals);
                }
                None => all.push((input, 1, intervals)),
            }
        }
        all
    }

    /// The intervals of all sweeps as a table, from which the report joins those of all figures: a row for each interval of
    /// a reading, without numbers if no value gives it.
    pub fn intervals(&self) -> Table {
        let mut table = Table::new(
            unstated::INTERVALS,
            &[("print", ""), ("input", ""), ("number", ""), ("from", ""), ("to", "")],
        );
        for (print, readings) in self.fits.iter().enumerate() {
            for fit in readings {
                let row = |from: Cell, to: Cell| {
                    [((print + 1) as f64).into(), fit.input.into(), fit.number.as_str().into(), from, to]
                };
                let intervals = fit.intervals();
                intervals.iter().for_each(|&[from, to]| table.push(row(from.into(), to.into())));
                if intervals.is_empty() {
                    table.push(row(Cell::Empty, Cell::Empty));
                }
            }
        }
        table
    }

    /// The verdict. Whatever does not agree makes it contradicted, or contradicted in part if a printed number agrees;
    /// otherwise it follows from what was compared.
    pub fn verdict(&self) -> Verdict {
        let has = |evidence| self.pairs.iter().any(|p| p.evidence == evidence);
        if !self.agrees() {
            return self.contradicted();
        }
        let found = self.found();
        if let Some(correction) = &self.correction {
            return Verdict::ReproducedAfterCorrection { found, correction: correction.clone() };
        }
        if !self.fits.is_empty() {
            return self.qualitative("Inputs are not stated.");
        }
        // A verdict is no better than the weakest of its numbers.
        if has(Evidence::Formula) {
            Verdict::Restated { found }
        } else if has(Evidence::Independent) {
            Verdict::Reproduced { found }
        } else if has(Evidence::Input) {
            Verdict::ByConstruction { found }
        } else if !self.claims.is_empty() {
            self.qualitative("What is said or drawn is compared, and no number.")
        } else {
            let beside = format!("{} numbers that the document does not print.", self.not_printed);
            Verdict::None { why: "Nothing that is printed is computed here.".into(), beside }
        }
    }

    /// Qualitative, for the reason `why`, if everything agrees; otherwise contradicted.
    pub fn qualitative(&self, why: impl Into<String>) -> Verdict {
        if self.agrees() { self.of_our_model(why) } else { self.contradicted() }
    }

    /// Qualitative, for the reason `why`, whatever fails: what is compared is no print, but a model of ours.
    pub fn of_our_model(&self, why: impl Into<String>) -> Verdict {
        Verdict::Qualitative { why: why.into(), found: self.found() }
    }

    /// Contradicted, in part if a printed number agrees that is not an input's choice. Shapes that agree, and sweeps, do not
    /// soften it.
    fn contradicted(&self) -> Verdict {
        let some = self.pairs.iter().any(|p| p.agrees() && p.evidence != Evidence::Input);
        let found = self.found();
        if found.is_empty() {
            Verdict::Contradicted { found: "Nothing was compared.".into() }
        } else if some {
            Verdict::ContradictedInPart { found }
        } else {
            Verdict::Contradicted { found }
        }
    }

    /// Everything that was found, under what it is: what does not agree first, and nothing under two heads.
    fn found(&self) -> String {
        let numbers = |count: usize| match count {
            0 => Vec::new(),
            1 => vec!["1 number".to_owned()],
            _ => vec![format!("{count} numbers")],
        };
        let parts = [
            ("Does not agree", self.failing()),
            ("Agrees", self.agreeing()),
            ("Does not give print in another form or reading", self.others()),
            ("Not printed", numbers(self.not_printed)),
            ("Read from the scan, not computed", numbers(self.read)),
        ];
        let said = parts.iter().filter(|part| !part.1.is_empty());
        let said: Vec<_> = said.map(|(head, part)| format!("{head}: {}.", part.join("; "))).collect();
        said.join(" ")
    }

    /// What fails: claims that do not hold, numbers beyond their tolerances, prints that are contradicted, sweeps that do not
    /// meet print.
    fn failing(&self) -> Vec<String> {
        let mut parts: Vec<_> = self.claims.iter().filter(|c| !c.1).map(|c| c.0.clone()).collect();
        parts.extend(self.pairs.iter().filter(|p| !p.agrees()).map(Pair::miss));
        parts.extend(self.contradicted.iter().cloned());
        let misses = |readings: &&Vec<Fit>| readings.iter().all(|fit| !fit.meets());
        parts.extend(self.fits.iter().filter(misses).flatten().map(Fit::text));
        for (input, numbers, intervals) in self.inputs() {
            if numbers > 1 && intervals.is_empty() {
                let of = self.fits.iter().filter(|readings| input_of(readings) == Some(input));
                let each: Vec<_> = of.filter_map(|readings| met_in_words(readings)).collect();
                parts.push(format!(
                    "no {input} gives {} ({})",
                    self.all_of(input, numbers),
                    each.join(", but ")
                ));
            }
        }
        parts
    }

    /// How many numbers an input gives: all, or all but those that none of its values gives.
    fn all_of(&self, input: &str, numbers: usize) -> String {
        let misses =
            |readings: &Vec<Fit>| input_of(readings) == Some(input) && !readings.iter().any(Fit::meets);
        let other = if self.fits.iter().any(misses) { "other " } else { "" };
        format!("all {numbers} {other}numbers")
    }

    /// What holds.
    fn agreeing(&self) -> Vec<String> {
        let mut parts = self.words_of_numbers();
        let inputs = self.inputs();
        let alone = |input| {
            inputs.iter().any(|(i, numbers, common)| *i == input && *numbers > 1 && common.is_empty())
        };
        // Where numbers have no input in common, none of them is met.
        let met = |readings: &&Vec<Fit>| !input_of(readings).is_some_and(alone);
        parts.extend(self.fits.iter().filter(met).filter_map(|readings| met_in_words(readings)));
        for (input, numbers, intervals) in &inputs {
            if *numbers > 1 && !intervals.is_empty() {
                parts.push(format!(
                    "{input} of {} gives {}",
                    in_words(intervals),
                    self.all_of(input, *numbers)
                ));
            }
        }
        parts.extend(self.claims.iter().filter(|c| c.1).map(|c| c.0.clone()));
        parts
    }

    /// Forms and readings that do not give a print which another one gives.
    fn others(&self) -> Vec<String> {
        let of_met = self.fits.iter().filter(|readings| readings.iter().any(Fit::meets)).flatten();
        let sweeps = of_met.filter(|fit| !fit.meets()).map(Fit::text);
        self.other_forms.iter().cloned().chain(sweeps).collect()
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
            format!("{kinds} (largest deviation {off:.2} % at {at}; tolerances: {sources})")
        });
        words.into_iter().collect()
    }
}

/// The input of all readings of a print; None if they have several.
fn input_of(readings: &[Fit]) -> Option<&'static str> {
    let first = readings.first()?.input;
    readings.iter().all(|fit| fit.input == first).then_some(first)
}

/// The readings of a print that some value gives, as alternatives; None if none does.
fn met_in_words(readings: &[Fit]) -> Option<String> {
    let met: Vec<_> = readings.iter().filter(|fit| fit.meets()).map(Fit::text).collect();
    match &met[..] {
        [] => None,
        [one] => Some(one.clone()),
        _ => Some(format!("one of {} readings of a print: either {}", met.len(), met.join(", or "))),
    }
}

/// Whether a number has one of `names`. A name is taken whole, part by part between its dashes; `*` stands for any one
/// part, `#` for the digits of one: `H2.15-*-32-#`, `E5.5-d#`. So no name takes a longer one.
pub(super) fn is_named(id: &str, names: &[&str]) -> bool {
    names.iter().any(|name| {
        let [parts, own] = [*name, id].map(|text| text.split('-').collect::<Vec<_>>());
        parts.len() == own.len() && parts.iter().zip(own).all(|(part, own)| is_part(part, own))
    })
}

fn is_part(part: &str, own: &str) -> bool {
    let Some((before, after)) = part.split_once('#') else {
        return part == own || part == "*" && !own.is_empty();
    };
    let digits = own.strip_prefix(before).and_then(|rest| rest.strip_suffix(after));
    digits.is_some_and(|digits| !digits.is_empty() && digits.bytes().all(|digit| digit.is_ascii_digit()))
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

#[cfg(test)]
mod tests;
