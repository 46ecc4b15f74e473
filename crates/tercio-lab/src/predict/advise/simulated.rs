//! The search of the simulator of the sorting classes: which plans are simulated. What it says of them is in [`words`].
//!
//! Each class is searched by itself, on a ladder of numbers of processors: every number up to [`EVERY`], powers of two, and as many as
//! there may be.
//!
//! 1. [`Search::few`] plans on every number, the same ones on each.
//! 2. From the fastest of these on each number, all divisions of the screen, and all groups.
//! 3. Between a number of the ladder that was the fastest so far and its neighbours, other numbers.
//!
//! The second and third are left out where the work alone, shared evenly, takes longer than the best that is known of the class. What
//! else is simulated does not depend on how many processors there may be, so a larger power of two gives no worse an answer.

use serde::Serialize;
use tercio_mesh::loops::prelude::*;

use super::splits::EVERY;
use crate::machines::{Control, Machine, Topology};
use crate::predict::PredictError;
use crate::predict::counts::Counters;
use crate::predict::ranks::simulated::SimulatedFrame;
use crate::predict::ranks::{Plan, simulate};
use crate::simulators::sorting::{Assignment, Organisation, Regions};
use crate::workloads::{BoxScene, PixelBox};
use words::name;
pub use words::{describe, describe_with_processors};

mod words;

/// A class is given up when its time has risen from one power of two to the next so many times in a row,
const RISES: u32 = 3;

/// to more than so many times its shortest.
const HOPELESS: f64 = 4.0;

/// Between two powers of two numbers are in steps of this part of the smaller one, or of 1.
const STEPS: usize = 32;

/// Pixels along the edges of regions, besides the largest of which every owner has one.
const EDGES: [u32; 8] = [1, 2, 4, 8, 16, 32, 64, 128];

/// Those of the few plans on every number.
const FEW: u32 = 32;

/// Smaller regions than these are left out of pictures and scenes that have very many of them.
const ALWAYS: u32 = 16;

/// So many are very many, if they are more than two a polygon, too.
const MANY_PARTS: u64 = 1 << 22;

const ASSIGNMENTS: [Assignment; 2] = [Assignment::Interleaved, Assignment::Blocks];

/// What the search found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Found {
    /// The fastest first. Plans with equal times stay in the order in which they were simulated, simple classes first.
    pub frames: Vec<SimulatedFrame>,
    /// Numbers of processors on which every class was simulated, unless it was given up.
    pub numbers: Vec<usize>,
    /// Pixels along the edges of regions.
    pub edges: Vec<u32>,
    /// Classes that were given up, and the number of processors after which.
    pub given_up: Vec<(&'static str, usize)>,
}

/// The picture to simulate on a machine.
struct Search<'a> {
    machine: &'a Machine,
    topology: Option<Topology>,
    counters: &'a Counters,
    boxes: &'a BoxScene,
    size: (u32, u32),
    /// Pixels along the edges of regions.
    edges: Vec<u32>,
}

/// A class of organisations, of which sort-twice has a member for each size of groups.
type Class = fn(usize) -> Organisation;
const CLASSES: [Class; 4] = [
    |_| Organisation::SortFirst,
    |_| Organisation::SortMiddle,
    |_| Organisation::SortLast,
    Organisation::SortTwice,
];

/// The fastest of the few plans on a number of processors.
struct Start {
    seconds: f64,
    plan: Plan,
    /// Faster than on all smaller numbers.
    is_record: bool,
}

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
    let search = Search { machine, topology, counters, boxes, size, edges: edges(boxes, size) };
    let few = 1..=EVERY;
    let powers = (0..usize::BITS).map(|bit| 1usize << bit).filter(|&power| power > EVERY);
    let numbers: Vec<usize> =
        few.chain(powers).take_while(|&number| number < processors).chain([processors]).collect();
    let work = search.work()?;
    let of_classes: Result<Vec<_>, _> =
        CLASSES.par_iter().map(|&class| search.class(class, &numbers, work)).collect();
    let (mut frames, mut given_up) = (Vec::new(), Vec::new());
    for (class, (of_class, last)) in CLASSES.into_iter().zip(of_classes?) {
        frames.extend(of_class);
        given_up.extend(last.map(|last| (name(class(2)), last)));
    }
    frames.sort_by(|a, b| a.total().total_cmp(&b.total()));
    Ok(Found { frames, numbers, edges: search.edges, given_up })
}

/// Edges of regions that do not cut the picture or the polygons' boxes into too many parts. Of those that are no smaller than
/// the picture, the first.
fn edges(boxes: &BoxScene, (width, height): (u32, u32)) -> Vec<u32> {
    let screen = PixelBox::screen(width, height);
    let are_few = |edge: u32| {
        let pieces = |pixels: PixelBox| {
            let along = |first: i32, last: i32| {
                u64::from((last / edge as i32 - first / edge as i32).unsigned_abs()) + 1
            };
            along(pixels.x0, pixels.x1) * along(pixels.y0, pixels.y1)
        };
        let visible = boxes.boxes.iter().filter(|polygon| polygon.visible);
        let of_boxes: u64 =
            visible.filter_map(|polygon| polygon.pixels.intersection(&screen)).map(pieces).sum();
        of_boxes.max(pieces(screen)) <= MANY_PARTS.max(2 * boxes.boxes.len() as u64)
    };
    let different = EDGES.into_iter().filter(|edge| edge / 2 < width.max(height));
    different.filter(|&edge| edge >= ALWAYS || are_few(edge)).collect()
}

/// The fastest of some frames, of equal ones the first.
fn fastest<'a>(frames: impl Iterator<Item = &'a SimulatedFrame>) -> Option<(f64, Plan)> {
    let times = frames.map(|frame| (frame.total(), frame.plan));
    times.min_by(|a, b| a.0.total_cmp(&b.0))
}

impl Search<'_> {
    /// The frames of a class, and the number of processors after which it was given up, if it was. On n processors nothing is
    /// faster than an n-th of `work`.
    fn class(
        &self,
        class: Class,
        numbers: &[usize],
        work: f64,
    ) -> Result<(Vec<SimulatedFrame>, Option<usize>), PredictError> {
        let mut frames = Vec::new();
        let (mut starts, given_up) = self.starts(class, numbers, &mut frames)?;
        let mut best = fastest(frames.iter()).map_or(f64::INFINITY, |found| found.0);
        let may_be_faster = |ranks: usize, best: f64| work / (ranks as f64) < best;
        let ladder: Vec<(usize, usize)> = starts
            .windows(2)
            .filter(|pair| pair[0].is_record || pair[1].is_record)
            .map(|pair| (pair[0].plan.ranks, pair[1].plan.ranks))
            .collect();
        starts.sort_by(|a, b| a.seconds.total_cmp(&b.seconds));
        for start in starts {
            if may_be_faster(start.plan.ranks, best) {
                best = best.min(self.descend(&mut frames, (start.seconds, start.plan), &[])?);
            }
        }
        for (low, high) in ladder {
            let step = (low / STEPS).max(1);
            let between: Vec<usize> = (low + 1..high).filter(|number| number.is_multiple_of(step)).collect();
            let start = fastest(frames.iter().filter(|frame| frame.plan.ranks == high));
            if let Some(start) = start.filter(|_| !between.is_empty() && may_be_faster(high, best)) {
                best = best.min(self.descend(&mut frames, start, &between)?);
            }
        }
        Ok((frames, given_up))
    }

    /// Simulates the few plans on every number until the class is given up.
    fn starts(
        &self,
        class: Class,
        numbers: &[usize],
        frames: &mut Vec<SimulatedFrame>,
    ) -> Result<(Vec<Start>, Option<usize>), PredictError> {
        let mut starts = Vec::new();
        let (mut best, mut before, mut rises) = (f64::INFINITY, f64::INFINITY, 0);
        for (k, &ranks) in numbers.iter().enumerate() {
            let Some((seconds, plan)) = self.fastest_of(frames, &self.few(class, ranks))? else { continue };
            starts.push(Start { seconds, plan, is_record: seconds < best });
            best = best.min(seconds);
            if !ranks.is_power_of_two() {
                continue;
            }
            rises = if seconds > before { rises + 1 } else { 0 };
            before = seconds;
            if rises >= RISES && seconds > HOPELESS * best && k + 1 < numbers.len() {
                return Ok((starts, Some(ranks)));
            }
        }
        Ok((starts, None))
    }

    /// From a plan to the fastest one that differs in its number of processors only, then in how it divides the screen, then in
    /// its groups, and again until none is faster. Its seconds.
    fn descend(
        &self,
        frames: &mut Vec<SimulatedFrame>,
        (mut seconds, mut plan): (f64, Plan),
        between: &[usize],
    ) -> Result<f64, PredictError> {
        loop {
            let before = seconds;
            for axis in [Self::other_numbers, Self::other_divisions, Self::other_groups] {
                if let Some(found) = self.fastest_of(frames, &axis(self, &plan, between))?
                    && found.0 < seconds
                {
                    (seconds, plan) = found;
                }
            }
            if seconds >= before {
                return Ok(seconds);
            }
        }
    }

    /// The fastest of some plans, after those that were not yet simulated have been.
    fn fastest_of(
        &self,
        frames: &mut Vec<SimulatedFrame>,
        plans: &[Plan],
    ) -> Result<Option<(f64, Plan)>, PredictError> {
        let is_new = |plan: &&Plan| !frames.iter().any(|frame| frame.plan == **plan);
        let new: Vec<Plan> = plans.iter().filter(is_new).copied().collect();
        frames.extend(self.simulate(&new)?);
        Ok(fastest(frames.iter().filter(|frame| plans.contains(&frame.plan))))
    }

    fn simulate(&self, plans: &[Plan]) -> Result<Vec<SimulatedFrame>, PredictError> {
        let Self { machine, counters, boxes, size, .. } = *self;
        plans.par_iter().map(|plan| simulate(machine, counters, boxes, size, plan)).collect()
    }

    /// Seconds of the geometry work and of rasterization without overlap, on one processor: on n no class has less than an n-th of it.
    /// Sort-first may have less than the others, where polygons beside the screen are sent nowhere.
    fn work(&self) -> Result<f64, PredictError> {
        let alone = |organisation| -> Result<f64, PredictError> {
            let plans = [self.plan(organisation, 1, (None, Assignment::Interleaved))];
            let sorting = self.simulate(&plans)?.into_iter().map(|frame| frame.sorting);
            Ok(sorting.map(|sorting| sorting.geometry.mean + sorting.raster.mean).sum())
        };
        let least = alone(Organisation::SortFirst)?.min(alone(Organisation::SortMiddle)?);
        // Sums of many numbers are rounded.
        Ok(least * (1.0 - 1e-9))
    }

    fn plan(
        &self,
        organisation: Organisation,
        ranks: usize,
        (region, assignment): (Option<u32>, Assignment),
    ) -> Plan {
        Plan { organisation, ranks, threads: 1, region, assignment, topology: self.topology }
    }

    /// Sizes of groups: powers of two that are less than the number of processors, and of a SIMD machine divide it.
    fn groups(&self, ranks: usize) -> impl Iterator<Item = usize> {
        let any = self.machine.processors.control == Control::Mimd;
        let powers = (1..usize::BITS).map(|bit| 1usize << bit).take_while(move |&group| group < ranks);
        powers.filter(move |&group| any || ranks.is_multiple_of(group))
    }

    /// All different ways to divide the screen among those who share a picture.
    fn divisions(&self, organisation: Organisation, ranks: usize) -> Vec<(Option<u32>, Assignment)> {
        let owners = match organisation {
            Organisation::SortFirst | Organisation::SortMiddle => ranks,
            Organisation::SortLast => 1,
            Organisation::SortTwice(group) => group,
        };
        if owners == 1 {
            return vec![(None, Assignment::Interleaved)];
        }
        let (width, height) = self.size;
        let largest = Regions::fitting(width, height, owners, Assignment::Interleaved);
        // A smaller last group divides the screen in its own way, and a SIMD machine may have columns.
        let alike = self.machine.processors.control == Control::Mimd && ranks.is_multiple_of(owners);
        let sizes = self.edges.iter().filter(|&&edge| !alike || edge != largest.edge).map(|&edge| Some(edge));
        let with_assignments = |edge: Option<u32>| {
            let regions = Regions { edge: edge.unwrap_or(largest.edge), ..largest }.count();
            let different = if alike && (regions == 1 || regions == owners as u64) { 1 } else { 2 };
            ASSIGNMENTS.into_iter().take(different).map(move |assignment| (edge, assignment))
        };
        std::iter::once(None).chain(sizes).flat_map(with_assignments).collect()
    }

    /// Plans of a class that are simulated on every number of processors: all groups, interleaved, with the largest regions and
    /// those of [`FEW`] pixels.
    fn few(&self, class: Class, ranks: usize) -> Vec<Plan> {
        let groups = if matches!(class(2), Organisation::SortTwice(_)) {
            self.groups(ranks).collect()
        } else {
            vec![2]
        };
        let of_group = |group: usize| {
            let all = self.divisions(class(group), ranks).into_iter();
            let few = all.filter(|d| d.1 == Assignment::Interleaved && d.0.is_none_or(|edge| edge == FEW));
            few.map(move |division| self.plan(class(group), ranks, division))
        };
        groups.into_iter().flat_map(of_group).collect()
    }

    /// The same plan on some other numbers of processors that may have its groups.
    fn other_numbers(&self, plan: &Plan, between: &[usize]) -> Vec<Plan> {
        let may = |ranks: usize| match plan.organisation {
            Organisation::SortTwice(group) => self.groups(ranks).any(|size| size == group),
            _ => true,
        };
        between.iter().filter(|&&ranks| may(ranks)).map(|&ranks| Plan { ranks, ..*plan }).collect()
    }

    fn other_divisions(&self, plan: &Plan, _: &[usize]) -> Vec<Plan> {
        let all = self.divisions(plan.organisation, plan.ranks).into_iter();
        all.map(|division| self.plan(plan.organisation, plan.ranks, division)).collect()
    }

    fn other_groups(&self, plan: &Plan, _: &[usize]) -> Vec<Plan> {
        match plan.organisation {
            Organisation::SortTwice(_) => {
                let sizes = self.groups(plan.ranks);
                sizes.map(|group| Plan { organisation: Organisation::SortTwice(group), ..*plan }).collect()
            }
            _ => Vec::new(),
        }
    }
}

#[cfg(test)]
mod tests;
