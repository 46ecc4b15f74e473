//! Inputs that documents do not state, joined over all figures: whether one value gives all that is printed.

use super::hidden::{common, in_words, union};
use super::{Cell, Outcome};

/// The name of the table in which an experiment has the intervals of its sweeps.
pub(super) const INTERVALS: &str = "intervals";
/// The heading of the joined table.
pub(super) const HEADING: &str = "Inputs that are not stated";
/// How the report of an experiment refers to it.
pub(super) const REFERENCE: &str =
    "What other figures ask of the same inputs is joined under 'Inputs that are not stated'.";

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

/// The inputs of some experiments. A number that two figures compare is listed once.
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
        // The most intervals meet where one of them begins; there may be several such places.
        let holds = |at: f64, list: &Vec<[f64; 2]>| list.iter().any(|i| (i[0]..=i[1]).contains(&at));
        let given = |at: f64| all.iter().filter(|list| holds(at, list)).collect::<Vec<_>>();
        let begins: Vec<_> = all.iter().flatten().map(|interval| interval[0]).collect();
        let most = begins.iter().map(|&at| given(at).len()).max().unwrap_or(0);
        let meeting = |at: f64| {
            let meet = given(at).iter().fold(vec![[f64::MIN, f64::MAX]], |known, list| common(&known, list));
            meet.into_iter().filter(|i| (i[0]..=i[1]).contains(&at)).collect()
        };
        let places = union(begins.into_iter().filter(|&at| given(at).len() == most).map(meeting));
        let none = all.iter().filter(|list| list.is_empty()).count();
        let none = if none == 0 { String::new() } else { format!("; {none} of them is given by none") };
        Some(if most == 0 {
            format!("{name}: no value gives any of {numbers} numbers.")
        } else {
            format!(
                "{name}: no value gives all {numbers} numbers{none}; the most that one gives are {most}, with {}.",
                in_words(&places)
            )
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
        // Every place where the most meet is said, and none where fewer do.
        let some =
            of(&[&[&[[1.0, 3.0], [20.0, 21.0]]], &[&[[2.0, 4.0], [8.0, 9.0]]], &[&[[8.5, 9.5]]]]).unwrap();
        assert!(some.ends_with("the most that one gives are 2, with 2 to 3 or 8.5 to 9."), "{some}");
        // A reading is enough.
        let some = of(&[&[&[[1.0, 2.0]], &[[5.0, 6.0]]], &[&[[5.5, 7.0]]]]);
        assert_eq!(some.unwrap(), "x: 5.5 to 6 gives all 2 numbers.");
        let some = of(&[&[&[]], &[&[[5.5, 7.0]]]]).unwrap();
        assert!(some.contains("1 of them is given by none; the most that one gives are 1"), "{some}");
        assert_eq!(of(&[&[&[]], &[&[]]]).unwrap(), "x: no value gives any of 2 numbers.");
    }

    proptest::proptest! {
        /// Beside counting at every half of a whole number: intervals begin and end at whole ones.
        #[test]
        fn the_most_numbers_are_given_where_counting_finds_them(
            lists in proptest::collection::vec(proptest::collection::vec((0u8..30, 0u8..6), 0..4), 2..6),
        ) {
            let interval = |&(from, length): &(u8, u8)| [f64::from(from), f64::from(from + length)];
            let lists: Vec<Vec<_>> = lists.iter().map(|list| list.iter().map(interval).collect()).collect();
            let counted = |half: u8| {
                let at = f64::from(half) / 2.0;
                let holds = |list: &&Vec<[f64; 2]>| list.iter().any(|i| i[0] <= at && at <= i[1]);
                (lists.iter().filter(holds).count(), at)
            };
            let most = (0..80).map(counted).map(|c| c.0).max().unwrap();
            let prints = lists.iter().map(|list| Print {
                place: String::new(),
                readings: vec![Reading { number: String::new(), intervals: list.clone() }],
            });
            let text = Input { name: "x".into(), prints: prints.collect() }.conclusion().unwrap();
            let said = text.trim_end_matches('.').trim_end_matches(&format!(" gives all {most} numbers")).to_owned();
            let said = said.rsplit_once("with ").or(said.rsplit_once("x: ")).unwrap().1;
            let ends = |part: &str| {
                let (from, to) = part.split_once(" to ").unwrap_or((part, part));
                Some([from.parse::<f64>().ok()?, to.parse().ok()?])
            };
            let said: Vec<_> = said.split(" or ").filter_map(ends).collect();
            for (count, at) in (0..80).map(counted) {
                let is_said = said.iter().any(|i| i[0] <= at && at <= i[1]);
                proptest::prop_assert_eq!(is_said, most > 0 && count == most, "{}: {}", at, text);
            }
        }
    }
}
