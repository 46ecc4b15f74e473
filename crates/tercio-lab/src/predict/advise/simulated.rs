//! The candidates of the simulator of the sorting classes, and what it says of them.

use rayon::prelude::*;

use super::explain::{Line, longest, milliseconds, others};
use crate::machines::{Control, Machine, Topology};
use crate::predict::PredictError;
use crate::predict::counts::Counters;
use crate::predict::ranks::simulated::SimulatedFrame;
use crate::predict::ranks::{Plan, simulate};
use crate::simulators::sorting::{Assignment, Organisation};
use crate::workloads::BoxScene;

/// Up to so many processors all plans are simulated. Each exchange of pixels takes as many steps as there are processors, and a plan has
/// up to as many exchanges as their logarithm.
pub const ALL_PLANS: usize = 1 << 16;

/// The candidates of the simulator: the four classes, groups of every power of two, regions of 16 to 128 pixels and the
/// largest possible, both assignments; above [`ALL_PLANS`] only groups of every second power of two, and the largest regions,
/// interleaved. Groups of a SIMD machine divide its processors.
pub fn plans(machine: &Machine, ranks: usize, topology: Option<Topology>) -> Vec<Plan> {
    let mut organisations = vec![Organisation::SortFirst, Organisation::SortMiddle, Organisation::SortLast];
    let divides = |g: &usize| machine.processors.control == Control::Mimd || ranks.is_multiple_of(*g);
    let is_many = ranks > ALL_PLANS;
    let bits = (1..usize::BITS).step_by(if is_many { 2 } else { 1 });
    let groups = bits.map(|bit| 1usize << bit).take_while(|g| *g < ranks).filter(divides);
    let regions = if is_many { vec![None] } else { vec![None, Some(16), Some(32), Some(64), Some(128)] };
    let assignments = if is_many {
        vec![Assignment::Interleaved]
    } else {
        vec![Assignment::Interleaved, Assignment::Blocks]
    };
    organisations.extend(groups.map(Organisation::SortTwice));
    let mut plans = Vec::new();
    for organisation in organisations {
        for &region in &regions {
            for &assignment in &assignments {
                // An owner of the whole picture needs no regions.
                let divided = organisation != Organisation::SortLast;
                if divided || (region.is_none() && assignment == Assignment::Interleaved) {
                    plans.push(Plan { organisation, ranks, threads: 1, region, assignment, topology });
                }
            }
        }
    }
    plans
}

/// Simulates plans, the fastest first. Plans with equal times stay in the order of the list, simple plans first.
///
/// # Errors
/// As [`simulate`].
pub fn simulated(
    machine: &Machine,
    counters: &Counters,
    boxes: &BoxScene,
    size: (u32, u32),
    plans: &[Plan],
) -> Result<Vec<SimulatedFrame>, PredictError> {
    let frames: Result<Vec<SimulatedFrame>, _> =
        plans.par_iter().map(|plan| simulate(machine, counters, boxes, size, plan)).collect();
    let mut frames = frames?;
    frames.sort_by(|a, b| a.total().total_cmp(&b.total()));
    Ok(frames)
}

/// Why the first one is the fastest, and what limits the best of each other class.
pub fn explanation(frames: &[SimulatedFrame]) -> Vec<String> {
    let Some(best) = frames.first() else { return Vec::new() };
    let line = |s: &SimulatedFrame| Line {
        class: class(s.plan.organisation),
        seconds: s.total(),
        words: describe(&s.plan),
    };
    let lines: Vec<Line> = frames.iter().map(line).collect();
    let mut all = vec![why_simulated(best)];
    if best.plan.ranks > ALL_PLANS {
        all.push(format!(
            "of more than {ALL_PLANS} processors the simulator compares no regions of 16, 32, 64 and 128 pixels, no regions in blocks and \
             no groups of other sizes than 2, 8, 32, 128 ... processors: it would take minutes"
        ));
    }
    all.extend(others(&lines, |k| frames[k].phases().to_vec()));
    all
}

fn why_simulated(best: &SimulatedFrame) -> String {
    let (name, seconds) = longest(&best.phases());
    format!(
        "{} is fastest of the classes simulated, {} a frame: its longest phase is {name} with {}; busiest over mean rank {:.2} in geometry \
         and {:.2} in rasterization",
        describe(&best.plan),
        milliseconds(best.total()),
        milliseconds(seconds),
        best.sorting.geometry.imbalance(),
        best.sorting.raster.imbalance(),
    )
}

fn class(organisation: Organisation) -> &'static str {
    match organisation {
        Organisation::SortFirst => "sort-first",
        Organisation::SortMiddle => "sort-middle",
        Organisation::SortLast => "sort-last",
        Organisation::SortTwice(_) => "sort-twice",
    }
}

/// A plan of the simulator in words.
pub fn describe(plan: &Plan) -> String {
    let mut text = class(plan.organisation).to_string();
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
