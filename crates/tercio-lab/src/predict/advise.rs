//! The best organisation for a machine and a model: all of a list are predicted, the fastest is explained.

use rayon::prelude::*;
use serde::Serialize;

use super::counters::Counters;
use super::ranks::{Plan, RanksTime, predict};
use crate::machines::{Machine, MachineError, Topology};
use crate::simulators::sorting::{Assignment, Organisation};
use crate::workloads::BoxScene;

/// Predictions, the fastest first.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Advice {
    /// All plans that were looked at.
    pub plans: Vec<RanksTime>,
}

/// The plans that are looked at: the four classes, groups of every power of two, regions of 16 to 128 pixels and the
/// largest possible, both assignments.
pub fn plans(ranks: usize, topology: Option<Topology>) -> Vec<Plan> {
    let mut organisations = vec![Organisation::SortFirst, Organisation::SortMiddle, Organisation::SortLast];
    let groups = (1..usize::BITS).map(|bit| 1usize << bit).take_while(|g| *g < ranks);
    organisations.extend(groups.map(Organisation::SortTwice));
    let mut plans = Vec::new();
    for organisation in organisations {
        for region in [None, Some(16), Some(32), Some(64), Some(128)] {
            for assignment in [Assignment::Interleaved, Assignment::Blocks] {
                // Whoever owns the whole picture needs no regions.
                let divided = organisation != Organisation::SortLast;
                if divided || (region.is_none() && assignment == Assignment::Interleaved) {
                    plans.push(Plan { organisation, ranks, region, assignment, topology });
                }
            }
        }
    }
    plans
}

/// Predicts all plans.
///
/// # Errors
/// As [`predict`].
pub fn advise(
    machine: &Machine,
    counters: &Counters,
    boxes: &BoxScene,
    size: (u32, u32),
    plans: &[Plan],
) -> Result<Advice, MachineError> {
    let predicted: Result<Vec<RanksTime>, _> =
        plans.par_iter().map(|&plan| predict(machine, counters, boxes, size, plan)).collect();
    let mut plans = predicted?;
    // Equal times stay in the order of the list, simple plans first.
    plans.sort_by(|a, b| a.total().total_cmp(&b.total()));
    Ok(Advice { plans })
}

impl Advice {
    /// Why the first one: its longest phase, and what holds the best of each other class back.
    pub fn explanation(&self) -> Vec<String> {
        let Some(best) = self.plans.first() else { return Vec::new() };
        let milliseconds = |s: f64| format!("{:.3} ms", s * 1e3);
        let (phase, seconds) = best.longest_phase();
        let mut lines = vec![format!(
            "{} is fastest, {} a frame: its longest phase is {phase} with {}; busiest over mean rank {:.2} in geometry \
             and {:.2} in rasterization",
            describe(&best.plan),
            milliseconds(best.total()),
            milliseconds(seconds),
            best.sorting.geometry.imbalance(),
            best.sorting.raster.imbalance(),
        )];
        let mut seen = vec![class(best.plan.organisation)];
        for other in &self.plans {
            let class = class(other.plan.organisation);
            if seen.contains(&class) {
                continue;
            }
            seen.push(class);
            // The phase in which it loses most against the best.
            let phases = other.phases().into_iter().zip(best.phases());
            let (name, theirs, ours) = phases
                .map(|(o, b)| (o.0, o.1, b.1))
                .fold(("", 0.0, 0.0), |worst, p| if p.1 - p.2 > worst.1 - worst.2 { p } else { worst });
            lines.push(format!(
                "{} takes {:.2} times as long, {}: {name} takes {} instead of {}",
                describe(&other.plan),
                other.total() / best.total(),
                milliseconds(other.total()),
                milliseconds(theirs),
                milliseconds(ours),
            ));
        }
        lines
    }
}

fn class(organisation: Organisation) -> &'static str {
    match organisation {
        Organisation::SortFirst => "sort-first",
        Organisation::SortMiddle => "sort-middle",
        Organisation::SortLast => "sort-last",
        Organisation::SortTwice(_) => "sort-twice",
    }
}

/// A plan in words.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machines::builtin;
    use crate::workloads::{BoundingBox, PixelBox};

    fn counters(boxes: u64) -> Counters {
        let binned = Counters {
            triangles: boxes,
            triangles_apart: boxes,
            triangles_binned: boxes,
            ..Counters::default()
        };
        Counters {
            entries: boxes,
            entries_drawn: boxes,
            stamps: boxes,
            stamps_alone: boxes,
            pixels: 1 << 20,
            ..binned
        }
    }

    fn scene(boxes: u64) -> BoxScene {
        let at = |k: u64| (k * 7919 % 1_000_003 % 1000) as i32;
        let of = |k| {
            let (x, y) = (at(k), at(k * 31 + 5));
            BoundingBox { visible: true, pixels: PixelBox { x0: x, y0: y, x1: x + 2, y1: y + 2 } }
        };
        BoxScene { boxes: (0..boxes).map(of).collect() }
    }

    #[test]
    fn the_first_plan_is_the_fastest_and_the_others_are_told_why() {
        let machine = builtin("princeton-engine").unwrap().unwrap();
        let plans = plans(64, None);
        let advice = advise(&machine, &counters(3000), &scene(3000), (1024, 1024), &plans).unwrap();
        assert_eq!(advice.plans.len(), plans.len());
        assert!(advice.plans.windows(2).all(|w| w[0].total() <= w[1].total()));
        let lines = advice.explanation();
        assert_eq!(lines.len(), 4, "one line a class: {lines:?}");
        // 3,000 polygons travel faster than megabytes of pixels round a ring.
        assert!(matches!(
            advice.plans[0].plan.organisation,
            Organisation::SortMiddle | Organisation::SortFirst
        ));
        assert!(lines.iter().any(|l| l.starts_with("sort-last") && l.contains("composition")), "{lines:?}");
    }

    #[test]
    fn a_machine_without_a_network_is_told() {
        let machine = builtin("voodoo-sli").unwrap().unwrap();
        let error = advise(&machine, &counters(1), &scene(1), (64, 64), &plans(2, None)).unwrap_err();
        assert!(error.to_string().contains("network is needed"), "{error}");
    }
}
