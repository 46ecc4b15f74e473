//! Inputs that documents do not state, joined over all figures: whether one value gives all that is printed.

use super::hidden::{common, in_words, union};
use super::{Cell, Outcome};

/// The name of the table in which an experiment has the intervals of its sweeps.
pub(super) const INTERVALS: &str = "intervals";
/// The heading of the joined table.
pub(super) const HEADING: &str = "Inputs that are not stated";
/// How a verdict refers to it.
pub(super) const REFERENCE: &str =
    "What other figures ask of the same inputs is joined under 'Inputs that are not stated'";

/// An input, and what is printed that depends on it.
#[derive(Debug)]
pub(super) struct Input {
    pub name: String,
    pub prints: Vec<Print>,
}

/// Something printed, whose readings are alternatives.
#[derive(Debug)]
pub(super) struct Print {
    /// Figures or tables.
    pub place: String,
    pub readings: Vec<Reading>,
}

/// A reading, and the intervals of the input that give it.
#[derive(Debug, PartialEq)]
pub(super) struct Reading {
    pub number: String,
    pub intervals: Vec<[f64; 2]>,
}

/// The inputs of some experiments. A number that two figures compare stands once.
pub(super) fn joined<'a>(outcomes: impl Iterator<Item = &'a Outcome>) -> Vec<Input> {
    let mut inputs: Vec<Input> = Vec::new();
    for outcome in outcomes {
        let tables = outcome.findings.iter().flat_map(|findings| &findings.tables);
        let rows = tables.filter(|table| table.name == INTERVALS).flat_map(|table| &table.rows);
        for (input, readings) in prints(rows.map(Vec::as_slice)) {
            let prints = match inputs.iter_mut().find(|known| known.name == input) {
                Some(known) => &mut known.prints,
                None => {
                    inputs.push(Input { name: input, prints: Vec::new() });
                    let Some(last) = inputs.last_mut() else { continue };
                    &mut last.prints
                }
            };
            let place = outcome.experiment.place;
            match prints.iter_mut().find(|known| known.readings == readings) {
                Some(known) => known.place = format!("{}; {place}", known.place),
                None => prints.push(Print { place: place.into(), readings }),
            }
        }
    }
    inputs
}

/// The prints of an experiment's table, with their inputs.
fn prints<'a>(rows: impl Iterator<Item = &'a [Cell]>) -> Vec<(String, Vec<Reading>)> {
    let mut all: Vec<(f64, String, Vec<Reading>)> = Vec::new();
    for row in rows {
        let [Cell::Number(print), Cell::Text(input), Cell::Text(number), from, to] = row else { continue };
        let readings = match all.iter_mut().position(|known| known.0 == *print && known.1 == *input) {
            Some(at) => &mut all[at].2,
            None => {
                all.push((*print, input.clone(), Vec::new()));
                let Some(last) = all.last_mut() else { continue };
                &mut last.2
            }
        };
        let interval = match (from, to) {
            (Cell::Number(from), Cell::Number(to)) => Some([*from, *to]),
            _ => None,
        };
        match readings.iter_mut().find(|reading| reading.number == *number) {
            Some(known) => known.intervals.extend(interval),
            None => {
                readings.push(Reading { number: number.clone(), intervals: interval.into_iter().collect() })
            }
        }
    }
    all.into_iter().map(|(_, input, readings)| (input, readings)).collect()
}

impl Print {
    /// The intervals in which one of the readings holds.
    fn intervals(&self) -> Vec<[f64; 2]> {
        union(self.readings.iter().map(|reading| reading.intervals.clone()))
    }

    /// Readings and intervals in words.
    pub fn cells(&self) -> [String; 2] {
        let join = |of: &dyn Fn(&Reading) -> String| {
            self.readings.iter().map(of).collect::<Vec<_>>().join(", or else ")
        };
        let intervals = |reading: &Reading| match &reading.intervals[..] {
            [] => "none".to_owned(),
            some => in_words(some),
        };
        [join(&|reading| reading.number.clone()), join(&intervals)]
    }
}

impl Input {
    /// Whether one value gives all prints; otherwise most of them that one does. None if there is one print.
    pub fn conclusion(&self) -> Option<String> {
        let all: Vec<_> = self.prints.iter().map(Print::intervals).collect();
        let (name, numbers) = (&self.name, all.len());
        if numbers < 2 {
            return None;
        }
        let of_all = all.iter().skip(1).fold(all[0].clone(), |known, other| common(&known, other));
        if !of_all.is_empty() {
            return Some(format!("{name}: {} gives all {numbers} numbers.", in_words(&of_all)));
        }
        // The most intervals meet where one of them begins.
        let holds = |at: f64, list: &Vec<[f64; 2]>| list.iter().any(|i| (i[0]..=i[1]).contains(&at));
        let given = |at: f64| all.iter().filter(|list| holds(at, list)).collect::<Vec<_>>();
        let begins = all.iter().flatten().map(|interval| interval[0]);
        let most = begins.map(|at| (at, given(at))).max_by_key(|(_, given)| given.len());
        let none = all.iter().filter(|list| list.is_empty()).count();
        let none = if none == 0 { String::new() } else { format!("; {none} of them is given by none") };
        Some(match most {
            Some((at, given)) => {
                let meet = given.iter().fold(vec![[f64::MIN, f64::MAX]], |known, list| common(&known, list));
                let meet: Vec<_> = meet.into_iter().filter(|i| (i[0]..=i[1]).contains(&at)).collect();
                format!(
                    "{name}: no value gives all {numbers} numbers{none}; the most that one gives are {}, with {}.",
                    given.len(),
                    in_words(&meet)
                )
            }
            None => format!("{name}: no value gives any of {numbers} numbers."),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn input(prints: &[&[&[[f64; 2]]]]) -> Input {
        let reading = |intervals: &&[[f64; 2]]| Reading { number: "n".into(), intervals: intervals.to_vec() };
        let print = |readings: &&[&[[f64; 2]]]| Print {
            place: "figure".into(),
            readings: readings.iter().map(reading).collect(),
        };
        Input { name: "x".into(), prints: prints.iter().map(print).collect() }
    }

    #[test]
    fn one_value_gives_all_or_it_is_said_how_many_one_gives() {
        let of = |prints: &[&[&[[f64; 2]]]]| input(prints).conclusion();
        assert_eq!(of(&[&[&[[1.0, 2.0]]]]), None);
        let some = of(&[&[&[[1.0, 3.0]]], &[&[[2.0, 4.0]]]]);
        assert_eq!(some.unwrap(), "x: 2 to 3 gives all 2 numbers.");
        let some = of(&[&[&[[1.0, 3.0]]], &[&[[2.0, 4.0]]], &[&[[8.0, 9.0]]]]);
        assert_eq!(
            some.unwrap(),
            "x: no value gives all 3 numbers; the most that one gives are 2, with 2 to 3."
        );
        // A reading is enough.
        let some = of(&[&[&[[1.0, 2.0]], &[[5.0, 6.0]]], &[&[[5.5, 7.0]]]]);
        assert_eq!(some.unwrap(), "x: 5.5 to 6 gives all 2 numbers.");
        let some = of(&[&[&[]], &[&[[5.5, 7.0]]]]).unwrap();
        assert!(some.contains("1 of them is given by none; the most that one gives are 1"), "{some}");
    }
}
