//! The search of the simulator of the sorting classes, and what it says of what it finds.
//!
//! Each class is simulated on 1, 2, 4 ... processors and on as many as there may be: roughly on every number, and with all regions on the
//! numbers that were the fastest so far. What is simulated on a number does not depend on how many processors there may be, so
//! a larger power of two never gives a worse answer than a smaller one.

use rayon::prelude::*;
use serde::Serialize;

use super::explain::{Line, longest, milliseconds, others};
use crate::machines::{Control, Machine, Topology};
use crate::predict::PredictError;
use crate::predict::counts::Counters;
use crate::predict::ranks::simulated::SimulatedFrame;
use crate::predict::ranks::{Plan, simulate};
use crate::simulators::sorting::{Assignment, Organisation};
use crate::words::counted;
use crate::workloads::BoxScene;

/// On more processors only the largest regions are simulated. Each exchange of pixels takes as many steps as there are processors, and a
/// plan has up to as many exchanges as their logarithm.
const ALL_REGIONS: usize = 1 << 16;

/// On more processors few plans of sort-twice are simulated at first: there are as many sizes of groups as the logarithm.
const ALL_GROUPS: usize = 1 << 10;

/// A class is given up when its time has risen with the number of processors so many times in a row,
const RISES: u32 = 3;

/// to more than so many times its shortest.
const HOPELESS: f64 = 4.0;

const ASSIGNMENTS: [Assignment; 2] = [Assignment::Interleaved, Assignment::Blocks];
const REGIONS: [Option<u32>; 5] = [None, Some(16), Some(32), Some(64), Some(128)];

/// What the search found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Found {
    /// The fastest first. Plans with equal times stay in the order in which they were simulated, simple classes first.
    pub frames: Vec<SimulatedFrame>,
    /// Numbers of processors.
    pub numbers: Vec<usize>,
    /// Classes that were given up, and the number of processors after which.
    pub given_up: Vec<(&'static str, usize)>,
}

/// The picture to simulate on a machine.
#[derive(Clone, Copy)]
struct Search<'a> {
    machine: &'a Machine,
    topology: Option<Topology>,
    counters: &'a Counters,
    boxes: &'a BoxScene,
    size: (u32, u32),
}

/// A class of organisations, of which sort-twice has a member for each size of groups.
type Class = fn(usize) -> Organisation;
const CLASSES: [Class; 4] = [
    |_| Organisation::SortFirst,
    |_| Organisation::SortMiddle,
    |_| Organisation::SortLast,
    Organisation::SortTwice,
];

/// Simulates the four classes on up to so many processors.
///
/// # Errors
/// As [`simulate`].
pub fn search(
    machine: &Machine,
    counters: &Counters,
    boxes: &BoxScene,
    size: (u32, u32),
    topology: Option<Topology>,
    processors: usize,
) -> Result<Found, PredictError> {
    let search = Search { machine, topology, counters, boxes, size };
    let powers = (0..usize::BITS).map(|bit| 1usize << bit).take_while(|&power| power < processors);
    let numbers: Vec<usize> = powers.chain([processors]).collect();
    let of_classes: Result<Vec<_>, _> =
        CLASSES.par_iter().map(|&class| search.class(class, &numbers)).collect();
    let (mut frames, mut given_up) = (Vec::new(), Vec::new());
    for (class, (of_class, last)) in CLASSES.into_iter().zip(of_classes?) {
        frames.extend(of_class);
        given_up.extend(last.map(|last| (name(class(2)), last)));
    }
    frames.sort_by(|a, b| a.total().total_cmp(&b.total()));
    Ok(Found { frames, numbers, given_up })
}

impl Search<'_> {
    /// The frames of a class, and the number of processors after which it was given up, if it was.
    fn class(
        &self,
        class: Class,
        numbers: &[usize],
    ) -> Result<(Vec<SimulatedFrame>, Option<usize>), PredictError> {
        let (mut frames, mut given_up) = (Vec::new(), None);
        // The plans that were the fastest on their numbers of processors, each faster than all on fewer.
        let mut records: Vec<Plan> = Vec::new();
        let (mut best, mut before, mut rises) = (f64::INFINITY, f64::INFINITY, 0);
        for (k, &ranks) in numbers.iter().enumerate() {
            let rough = self.simulate(&self.rough(class, ranks))?;
            let fastest = rough.iter().min_by(|a, b| a.total().total_cmp(&b.total()));
            let Some((time, plan)) = fastest.map(|frame| (frame.total(), frame.plan)) else { continue };
            frames.extend(rough);
            if time < best {
                best = time;
                records.push(plan);
            }
            rises = if time > before { rises + 1 } else { 0 };
            before = time;
            if rises >= RISES && time > HOPELESS * best && k + 1 < numbers.len() {
                given_up = Some(ranks);
                break;
            }
        }
        let work = self.work()?;
        for plan in records.iter().rev() {
            // Not even if all its work were shared evenly and nothing were sent.
            if work / plan.ranks as f64 >= best {
                continue;
            }
            let fine = self.simulate(&self.fine(class, plan))?;
            best = fine.iter().map(SimulatedFrame::total).fold(best, f64::min);
            frames.extend(fine);
        }
        Ok((frames, given_up))
    }

    fn simulate(&self, plans: &[Plan]) -> Result<Vec<SimulatedFrame>, PredictError> {
        let Self { machine, counters, boxes, size, .. } = *self;
        plans.par_iter().map(|plan| simulate(machine, counters, boxes, size, plan)).collect()
    }

    /// Seconds of the geometry work and of rasterization without overlap, on one processor: on n no class has less than an n-th of it.
    /// Sort-first may have less than the others, where polygons beside the screen are sent nowhere.
    fn work(&self) -> Result<f64, PredictError> {
        let Self { machine, counters, boxes, size, .. } = *self;
        let alone = |organisation| -> Result<f64, PredictError> {
            let plan = self.plan(organisation, 1, None, Assignment::Interleaved);
            let sorting = simulate(machine, counters, boxes, size, &plan)?.sorting;
            Ok(sorting.geometry.mean + sorting.raster.mean)
        };
        let least = alone(Organisation::SortFirst)?.min(alone(Organisation::SortMiddle)?);
        // Sums of many numbers are rounded.
        Ok(least * (1.0 - 1e-9))
    }

    fn plan(
        &self,
        organisation: Organisation,
        ranks: usize,
        region: Option<u32>,
        assignment: Assignment,
    ) -> Plan {
        Plan { organisation, ranks, threads: 1, region, assignment, topology: self.topology }
    }

    /// Sizes of groups: powers of two that are less than the number of processors, and of a SIMD machine divide it.
    fn groups(&self, ranks: usize) -> impl Iterator<Item = usize> {
        let any = self.machine.processors.control == Control::Mimd;
        let powers = (1..usize::BITS).map(|bit| 1usize << bit).take_while(move |&group| group < ranks);
        powers.filter(move |&group| any || ranks.is_multiple_of(group))
    }

    /// Plans of a class on a number of processors: all, but of sort-twice above [`ALL_GROUPS`] few, interleaved, with few regions and
    /// every second size of groups.
    fn rough(&self, class: Class, ranks: usize) -> Vec<Plan> {
        let (groups, regions): (Vec<usize>, &[Option<u32>]) = match class(2) {
            // An owner of the whole picture needs no regions.
            Organisation::SortLast => (vec![2], &[None]),
            Organisation::SortTwice(_) if ranks > ALL_GROUPS => {
                (self.groups(ranks).step_by(2).collect(), &[None, Some(32)])
            }
            Organisation::SortTwice(_) => (self.groups(ranks).collect(), &REGIONS),
            Organisation::SortFirst | Organisation::SortMiddle => (vec![2], &REGIONS),
        };
        let regions = if ranks > ALL_REGIONS { &regions[..1] } else { regions };
        let of_group =
            |&group: &usize| regions.iter().map(move |&region| (group, region)).collect::<Vec<_>>();
        let all = groups.iter().flat_map(of_group);
        let few = match class(2) {
            Organisation::SortLast => true,
            Organisation::SortTwice(_) => ranks > ALL_GROUPS,
            _ => ranks > ALL_REGIONS,
        };
        let assignments = if few { &ASSIGNMENTS[..1] } else { &ASSIGNMENTS[..] };
        let plans = |(group, region)| {
            assignments.iter().map(move |&a| self.plan(class(group), ranks, region, a)).collect::<Vec<_>>()
        };
        all.flat_map(plans).collect()
    }

    /// The other plans beside the fastest of the few ones: all regions and assignments; groups of this size, half and twice as many.
    fn fine(&self, class: Class, best: &Plan) -> Vec<Plan> {
        let groups: Vec<usize> = match best.organisation {
            Organisation::SortTwice(group) => {
                let near = [group / 2, group, 2 * group];
                self.groups(best.ranks).filter(|size| near.contains(size)).collect()
            }
            _ => Vec::new(),
        };
        if best.ranks > ALL_REGIONS {
            return Vec::new();
        }
        let rough = self.rough(class, best.ranks);
        let mut plans = Vec::new();
        for group in groups {
            for region in REGIONS {
                let all =
                    ASSIGNMENTS.map(|assignment| self.plan(class(group), best.ranks, region, assignment));
                plans.extend(all.into_iter().filter(|plan| !rough.contains(plan)));
            }
        }
        plans
    }
}

impl Found {
    /// Why the first one is the fastest, what was compared, and what limits the best of each other class.
    pub fn explanation(&self) -> Vec<String> {
        let Some(best) = self.frames.first() else { return Vec::new() };
        let line = |s: &SimulatedFrame| Line {
            class: name(s.plan.organisation),
            seconds: s.total(),
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
        let all = if most.is_power_of_two() {
            "powers of two".to_owned()
        } else {
            format!("powers of two, and {most}")
        };
        let mut text = format!(
            "the simulator compares {all} processors, with regions as large as possible and of 16 to 128 pixels, interleaved and in blocks; of \
             sort-twice on more than {ALL_GROUPS} of them only groups of 2, 8, 32 ... with the largest regions and those of 32 pixels, interleaved, and the others, \
             with groups of half and twice the best size, on those numbers of processors that are faster than all smaller ones; not \
             compared are other numbers of processors, other groups and other regions"
        );
        if self.frames.iter().any(|frame| frame.plan.ranks > ALL_REGIONS) {
            text += &format!("; of more than {ALL_REGIONS} processors other regions than the largest");
        }
        for (class, last) in &self.given_up {
            text += &format!(
                "; {class} on more than {last} processors: its time has risen {RISES} times in a row, to more than {HOPELESS} times its shortest"
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
fn name(organisation: Organisation) -> &'static str {
    match organisation {
        Organisation::SortFirst => "sort-first",
        Organisation::SortMiddle => "sort-middle",
        Organisation::SortLast => "sort-last",
        Organisation::SortTwice(_) => "sort-twice",
    }
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

#[cfg(test)]
mod tests;
