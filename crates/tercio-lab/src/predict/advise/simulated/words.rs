//! What the search of the simulator found, in words.

use super::super::explain::{Line, longest, milliseconds, others};
use super::{ALWAYS, EDGES, EVERY, FEW, Found, HOPELESS, RISES, STEPS};
use crate::predict::ranks::Plan;
use crate::predict::ranks::simulated::SimulatedFrame;
use crate::simulators::sorting::{Assignment, Organisation};
use crate::words::counted;

impl Found {
    /// Why the first one is the fastest, what was compared, and what limits the best of each other class.
    pub fn explanation(&self) -> Vec<String> {
        let Some(best) = self.frames.first() else { return Vec::new() };
        let line = |s: &SimulatedFrame| Line {
            class: name(s.plan.organisation),
            seconds: s.total(),
            is_estimate: false,
            words: describe_with_processors(&s.plan),
        };
        let lines: Vec<Line> = self.frames.iter().map(line).collect();
        let mut all = vec![why(best), self.searched()];
        all.extend(others(&lines, |k| self.frames[k].phases().to_vec()));
        all
    }

    /// What was compared, and what was not.
    fn searched(&self) -> String {
        let most = self.numbers.last().copied().unwrap_or(1);
        let numbers = match most {
            1 => "1 processor".to_owned(),
            2..=EVERY => format!("1 to {most} processors"),
            _ if most.is_power_of_two() => format!("1 to {EVERY} processors and powers of two up to {most}"),
            _ => format!("1 to {EVERY} processors, powers of two and {most}"),
        };
        let edges: Vec<String> = self.edges.iter().map(u32::to_string).collect();
        let mut text = format!("the simulator compares {numbers}");
        if most > 1 {
            text += &format!(
                ", with regions as large as possible and of {} pixels, interleaved and in blocks",
                edges.join(", ")
            );
        }
        if most > 2 {
            text += &format!(
                "; of sort-twice on each number all groups that are powers of two with the largest regions and those of {FEW} pixels, \
                 interleaved, and from the fastest of them all other regions and all other groups in turn, until none is faster"
            );
        }
        if most > EVERY {
            text += &format!(
                "; where a number was faster, with the regions first compared, than all smaller ones, the numbers up to the next one \
                 compared and down to the one before, too, in steps of 1, or of the smaller one over {STEPS}, with the best plan on the \
                 larger one and from there likewise; not compared are other numbers"
            );
        }
        if most > 1 {
            text += "; on numbers that cannot be the best of a class, because the work alone, shared evenly, takes longer, only the \
                     regions first compared";
        }
        let left_out: Vec<String> =
            EDGES.iter().filter(|e| **e < ALWAYS && !self.edges.contains(e)).map(u32::to_string).collect();
        if most > 1 && !left_out.is_empty() {
            text += &format!(
                "; not compared are regions of {} pixel{}, into very many of which polygons or picture would be cut",
                left_out.join(", "),
                if left_out.len() == 1 && self.edges.contains(&2) { "" } else { "s" }
            );
        }
        for (class, last) in &self.given_up {
            text += &format!(
                "; {class} on more than {last} processors: its time on powers of two, with those regions first compared, has risen \
                 {RISES} times in a row, to more than {HOPELESS} times its shortest"
            );
        }
        text
    }
}

fn why(best: &SimulatedFrame) -> String {
    let (name, seconds) = longest(&best.phases());
    format!(
        "{} is fastest of the classes simulated, {} a frame: its longest phase is {name} with {}; busiest over mean rank {:.2} in geometry \
         and {:.2} in rasterization",
        describe_with_processors(&best.plan),
        milliseconds(best.total()),
        milliseconds(seconds),
        best.sorting.geometry.imbalance(),
        best.sorting.raster.imbalance(),
    )
}

/// The class of an organisation.
pub(super) fn name(organisation: Organisation) -> &'static str {
    organisation.class().name()
}

/// A plan of the simulator in words.
pub fn describe(plan: &Plan) -> String {
    let mut text = name(plan.organisation).to_string();
    if let Organisation::SortTwice(group) = plan.organisation {
        text += &format!(" in groups of {group}");
    }
    if plan.organisation != Organisation::SortLast {
        let regions = plan.region.map_or("as large as possible".into(), |e| format!("of {e} pixels"));
        let assignment = match plan.assignment {
            Assignment::Interleaved => "interleaved",
            Assignment::Blocks => "in blocks",
        };
        text += &format!(", regions {regions} {assignment}");
    }
    text
}

/// A plan of the simulator in words, with its number of processors.
pub fn describe_with_processors(plan: &Plan) -> String {
    format!("{}, {}", describe(plan), counted(plan.ranks as u64, "processor", "processors"))
}
