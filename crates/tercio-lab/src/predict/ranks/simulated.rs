//! Ranks on a network, by the simulator of the sorting classes: what the renderer does not have (yet), at any scale.
//!
//! The triangles with at least one sample are boxes of samples, in the order of the clusters. A rank is one processor
//! of the machine. The simulator distributes polygons; if a machine is charged for clusters, a polygon costs its
//! average in this very frame on one processor. Shading of what is visible and the cost of the picture, which the
//! simulator does not have, are added.

use serde::Serialize;

use super::Plan;
use crate::machines::{Machine, Operation};
use crate::predict::PredictError;
use crate::predict::counts::Counters;
use crate::predict::frame::{FrameTime, knows_clusters};
use crate::simulators::sorting::organisation::{Setting, simulate};
use crate::simulators::sorting::{Costs, Organisation, SortReport};
use crate::workloads::BoxScene;

/// A simulated frame of ranks; seconds.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SimulatedFrame {
    /// How they share it.
    pub plan: Plan,
    /// The simulator's phases, with loads, bytes and messages.
    pub sorting: SortReport,
    /// Shading of the busiest rank.
    pub shading: f64,
    /// The fixed cost, and clearing and writing the rank's part of the picture.
    pub picture: f64,
}

impl SimulatedFrame {
    /// The whole frame.
    pub fn total(&self) -> f64 {
        self.sorting.seconds() + self.shading + self.picture
    }

    /// The phases by name, in their order.
    pub fn phases(&self) -> [(&'static str, f64); 7] {
        let s = &self.sorting;
        [
            ("geometry", s.geometry.seconds),
            ("redistribution", s.redistribution_seconds),
            ("rasterization", s.raster.seconds),
            ("shading", self.shading),
            ("picture", self.picture),
            ("composition", s.composition_seconds),
            ("delivery", s.delivery_seconds),
        ]
    }
}

/// The costs of polygons in this frame, and the seconds of shading and of the picture on one processor.
struct Work {
    costs: Costs,
    shading: f64,
    /// Without the fixed cost of a frame.
    picture: f64,
}

impl Work {
    fn of(machine: &Machine, costs: Costs, c: &Counters, boxes: &BoxScene) -> Self {
        let visible = boxes.boxes.iter().filter(|b| b.visible);
        let box_pixels = visible.map(|b| b.pixels.area()).sum::<u64>().max(1) as f64;
        let one = FrameTime::on_one_thread(machine, c);
        let costs = if knows_clusters(machine) {
            let geometry = one.front_end + one.geometry + one.memory;
            let polygon = geometry / c.triangles.max(1) as f64;
            Costs { polygon, set_up: 0.0, entry: 0.0, pixel: one.raster / box_pixels, ..costs }
        } else {
            // Such a machine may test stamps of samples; the simulator counts the samples of boxes.
            let stamps = c.stamps_alone as f64 * machine.seconds_or_0(Operation::Stamp);
            Costs { pixel: costs.pixel + stamps / box_pixels, ..costs }
        };
        let picture = one.picture - machine.seconds_or_0(Operation::Frame);
        Self { costs, shading: one.shading, picture }
    }
}

/// Predicts a frame.
///
/// # Errors
/// A machine without a network, the sizes of messages or costs, or that cannot have so many processors; groups that do
/// not divide a SIMD ring.
pub fn predict(
    machine: &Machine,
    counters: &Counters,
    boxes: &BoxScene,
    size: (u32, u32),
    plan: Plan,
) -> Result<SimulatedFrame, PredictError> {
    let setting = Setting::of(machine, plan.ranks, size, plan.topology, &[plan.organisation])?;
    let work = Work::of(machine, setting.costs, counters, boxes);
    let setting = Setting { region: plan.region, assignment: plan.assignment, costs: work.costs, ..setting };
    let sorting = simulate(boxes, plan.organisation, &setting)?;
    let ranks = plan.ranks as f64;
    let group = match plan.organisation {
        Organisation::SortLast => 1,
        Organisation::SortTwice(group) => group.clamp(1, plan.ranks),
        Organisation::SortFirst | Organisation::SortMiddle => plan.ranks,
    };
    // Each group has a whole picture among its ranks, a smaller last one among fewer.
    let last = plan.ranks % group;
    let parts = if last == 0 { group } else { last } as f64;
    // If whole pictures are composited, each rank shades what is visible in its own: between what is visible in the end
    // and everything covered. The fewer the groups, the less a group shades beyond what is visible in the end.
    let groups = plan.ranks.div_ceil(group) as f64;
    let (shown, covered) = (counters.pixels_visible as f64, counters.samples_covered as f64);
    let shaded = if shown > 0.0 { (shown * groups).min(covered.max(shown)) / shown } else { 0.0 };
    let shading = work.shading * shaded / ranks * sorting.raster.imbalance();
    let picture = machine.seconds_or_0(Operation::Frame) + work.picture / parts;
    Ok(SimulatedFrame { plan, sorting, shading, picture })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::machines::builtin;
    use crate::simulators::sorting::Assignment;
    use crate::workloads::{BoundingBox, PixelBox};

    fn counters() -> Counters {
        Counters {
            clusters: 100,
            clusters_drawn: 90,
            vertices: 5000,
            triangles: 9000,
            set_ups: 700,
            steps: 5000,
            shadings: 300,
            pixels_visible: 4000,
            // More than 40 groups can see: each shades as much as if it were alone.
            samples_covered: 1 << 20,
            pixels: 1 << 16,
            ..Counters::default()
        }
    }

    fn predicted(organisation: Organisation, ranks: usize) -> SimulatedFrame {
        let machine = builtin("cluster-64").unwrap().unwrap();
        let of = |k: i32| BoundingBox {
            visible: true,
            pixels: PixelBox { x0: k % 250, y0: 9, x1: k % 250 + 3, y1: 12 },
        };
        let boxes = BoxScene { boxes: (0..9000).map(of).collect() };
        let assignment = Assignment::Interleaved;
        let plan = Plan { organisation, ranks, threads: 1, region: None, assignment, topology: None };
        predict(&machine, &counters(), &boxes, (256, 256), plan).unwrap()
    }

    #[test]
    fn one_rank_costs_what_one_thread_costs() {
        let ranks = predicted(Organisation::SortMiddle, 1).total();
        let machine = builtin("cluster-64").unwrap().unwrap();
        let thread = FrameTime::on_one_thread(&machine, &counters()).total();
        assert!((ranks / thread - 1.0).abs() < 1e-6, "{ranks} {thread}");
    }

    proptest! {
        /// Counted rank by rank: the busiest one has the largest part of a picture, and every group shades what is visible in it.
        #[test]
        fn every_group_has_a_whole_picture(ranks in 1usize..40, group in 1usize..48) {
            let frame = predicted(Organisation::SortTwice(group), ranks);
            let of_group = |k: usize| (0..ranks).filter(|rank| rank / group == k).count();
            let groups: Vec<usize> = (0..ranks).map(of_group).filter(|&members| members > 0).collect();
            let alone = predicted(Organisation::SortLast, 1);
            let fixed = builtin("cluster-64").unwrap().unwrap().seconds_or_0(Operation::Frame);
            let most = groups.iter().map(|&members| (alone.picture - fixed) / members as f64).fold(0.0, f64::max);
            prop_assert!(((frame.picture - fixed) / most - 1.0).abs() < 1e-9, "{} {most}", frame.picture - fixed);
            let mean = groups.len() as f64 * alone.shading / ranks as f64;
            let shading = frame.shading / frame.sorting.raster.imbalance();
            prop_assert!((shading / mean - 1.0).abs() < 1e-9, "{shading} {mean}");
        }
    }
}
