//! The renderer as ranks on a network, by the simulator of the sorting classes.
//!
//! The triangles that hold a sample stand as boxes of samples, in the order of the clusters. A rank is one processor of
//! the machine. What the simulator does not know is added: shading of what is shown, and the cost of the picture.

use serde::Serialize;

use super::counters::{Counters, Picture};
use crate::machines::{Machine, MachineError, Operation, Topology};
use crate::simulators::sorting::organisation::{Setting, simulate};
use crate::simulators::sorting::{Assignment, Costs, NetworkModel, Organisation, SortReport};
use crate::workloads::BoxScene;

/// How ranks share a frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Plan {
    /// Where work changes hands.
    pub organisation: Organisation,
    /// Ranks.
    pub ranks: usize,
    /// Pixels along the edge of a region; `None` takes the largest of which there is one a rank.
    pub region: Option<u32>,
    /// Who gets which region.
    pub assignment: Assignment,
    /// Another shape of the network than the machine's.
    pub topology: Option<Topology>,
}

/// A predicted frame of some ranks; seconds.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RanksTime {
    /// How they share it.
    pub plan: Plan,
    /// The simulator's phases, with loads, bytes and messages.
    pub sorting: SortReport,
    /// Shading of the busiest rank.
    pub shading: f64,
    /// What every frame costs, and clearing and writing the rank's part of the picture.
    pub picture: f64,
}

impl RanksTime {
    /// The whole frame.
    pub fn total(&self) -> f64 {
        self.sorting.seconds() + self.shading + self.picture
    }

    /// The phases by name, in their order.
    pub fn phases(&self) -> [(&'static str, f64); 6] {
        let s = &self.sorting;
        [
            ("geometry", s.geometry.seconds),
            ("redistribution", s.redistribution_seconds),
            ("rasterization", s.raster.seconds),
            ("shading", self.shading),
            ("picture", self.picture),
            ("composition", s.composition_seconds),
        ]
    }

    /// The phase that takes longest.
    pub fn longest_phase(&self) -> (&'static str, f64) {
        let phases = self.phases();
        phases.into_iter().fold(phases[0], |best, p| if p.1 > best.1 { p } else { best })
    }
}

/// Predicts a frame.
///
/// # Errors
/// A machine without a network or without the bytes of what travels.
pub fn predict(
    machine: &Machine,
    counters: &Counters,
    boxes: &BoxScene,
    picture: Picture,
    plan: Plan,
) -> Result<RanksTime, MachineError> {
    let network = machine.need(machine.network.as_ref(), "network")?;
    let seconds = |o| machine.seconds_or_0(o);
    let box_pixels: u64 = boxes.boxes.iter().filter(|b| b.visible).map(|b| b.pixels.area()).sum();
    // The renderer tests blocks of samples; the simulator counts the samples of boxes.
    let blocks_a_pixel = counters.box_blocks as f64 / box_pixels.max(1) as f64;
    let costs = Costs::of(machine)?;
    let costs = Costs { pixel: costs.pixel + blocks_a_pixel * seconds(Operation::Block), ..costs };
    let setting = Setting {
        width: picture.width,
        height: picture.height,
        processors: plan.ranks,
        region: plan.region,
        assignment: plan.assignment,
        network: NetworkModel::of(network, plan.topology),
        costs,
    };
    let sorting = simulate(boxes, plan.organisation, &setting);
    let ranks = plan.ranks as f64;
    let parts = match plan.organisation {
        Organisation::SortLast => 1.0,
        Organisation::SortTwice(group) => group.min(plan.ranks) as f64,
        Organisation::SortFirst | Organisation::SortMiddle => ranks,
    };
    // With whole pictures composed, each rank shades what it sees itself: between what is shown in the end and all
    // that is covered. A group sees about as much of what its polygons cover as the groups are few.
    let groups = ranks / parts;
    let (shown, covered) = (counters.pixels_shaded as f64, counters.samples_covered as f64);
    let shaded = (shown * groups).min(covered.max(shown));
    let shading = shaded / ranks * sorting.raster.imbalance() * seconds(Operation::ShadedPixel);
    let own_pixels = counters.pixels as f64 / parts;
    let picture = seconds(Operation::Frame) + own_pixels * seconds(Operation::PicturePixel);
    Ok(RanksTime { plan, sorting, shading, picture })
}
