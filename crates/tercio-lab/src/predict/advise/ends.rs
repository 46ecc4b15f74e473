//! A machine with the numbers that are assumed of it at their ends: all as fast as they may be, and all as slow.

use super::super::counts::count;
use super::super::frame::{FrameTime, need_costs};
use super::super::ranks::Picture;
use crate::machines::{Assumptions, Machine, Network, Sourced};
use crate::predict::PredictError;
use tercio_raster::Settings;

/// A machine whose assumed numbers are at one of their ends.
#[derive(Clone, Debug, PartialEq)]
pub struct End {
    /// The machine.
    pub machine: Machine,
    /// Its costs over those of its description.
    pub costs: f64,
}

/// Fast and slow; `None` if the description says nothing of how far its numbers may be off.
pub fn ends(machine: &Machine) -> Option<[End; 2]> {
    let of = machine.uncertainty.as_ref()?;
    Some([-1, 1].map(|slow| end(machine, of, slow)))
}

/// The slow end for `slow` of 1, the fast one for -1.
fn end(machine: &Machine, of: &Assumptions, slow: i32) -> End {
    // Times are multiplied by this, bandwidths divided.
    let factor = |off: &Option<Sourced<_>>| (1.0 + off.as_ref().map_or(0.0, |off| off.value)).powi(slow);
    let (costs, message, bandwidth) = (factor(&of.costs), factor(&of.message), factor(&of.network_bandwidth));
    let mut machine = machine.clone();
    machine.costs.values_mut().for_each(|cost| cost.value *= costs);
    let of_messages = |network: &mut Network| {
        network.message.value *= message;
        network.hop.value *= message;
        network.bandwidth.value /= bandwidth;
    };
    [&mut machine.network, &mut machine.node, &mut machine.mpi].into_iter().flatten().for_each(of_messages);
    let p = &mut machine.processors;
    p.memory_bandwidth.iter_mut().for_each(|b| b.value /= factor(&of.memory_bandwidth));
    p.wake_up.iter_mut().for_each(|time| time.value *= factor(&of.wake_up));
    if slow > 0 {
        p.serial = of.serial.clone().or(p.serial.take());
    }
    End { machine, costs }
}

/// A frame of threads of one process, and the same at both ends.
///
/// # Errors
/// [`PredictError`]: costs are missing, no memory is shared by so many processors, or the picture cannot be drawn.
pub fn on_threads(
    machine: &Machine,
    ends: Option<&[End; 2]>,
    picture: &Picture,
    region: Option<u32>,
    threads: usize,
) -> Result<(FrameTime, Option<[FrameTime; 2]>), PredictError> {
    need_costs(machine)?;
    machine.may_share_memory(threads)?;
    let settings = Settings { tile_size: region.or(picture.settings.tile_size), ..picture.settings.clone() };
    let counted = count(picture.scene, picture.camera, &settings, threads)?;
    let frame = |machine: &Machine| FrameTime::on_threads(machine, &counted, threads);
    let at_ends = ends.map(|[fast, slow]| [fast, slow].map(|end| frame(&end.machine)));
    Ok((frame(machine), at_ends))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machines::{Operation, builtin};

    fn off(value: f64) -> Option<Sourced<crate::units::Ratio>> {
        Some(Sourced::new(value, value.to_string(), "assumed".into()))
    }

    #[test]
    fn numbers_are_moved_by_what_is_assumed_of_each() {
        let mut machine = builtin("cluster-64").unwrap().unwrap();
        machine.uncertainty = None;
        assert_eq!(ends(&machine), None);
        machine.processors.memory_bandwidth = Some(Sourced::new(1e9, "1 GB/s".into(), String::new()));
        machine.mpi = machine.network.clone();
        let wake_up = machine.processors.wake_up.as_ref().unwrap().value;
        machine.uncertainty = Some(Assumptions {
            costs_of: None,
            residual: None,
            costs: off(1.0),
            memory_bandwidth: off(0.25),
            network_bandwidth: off(3.0),
            message: off(0.5),
            wake_up: off(2.0),
            serial: off(0.1),
        });
        let [fast, slow] = ends(&machine).unwrap();
        let cost =
            |m: &Machine| m.seconds(Operation::Vertex).unwrap() / machine.seconds(Operation::Vertex).unwrap();
        assert_eq!([cost(&fast.machine), cost(&slow.machine)], [0.5, 2.0]);
        assert_eq!([fast.costs, slow.costs], [0.5, 2.0]);
        let memory = |m: &Machine| m.processors.memory_bandwidth.as_ref().unwrap().value;
        assert_eq!([memory(&fast.machine), memory(&slow.machine)], [1.25e9, 0.8e9]);
        let wake_up = |m: &Machine| m.processors.wake_up.as_ref().unwrap().value / wake_up;
        assert!(
            (wake_up(&fast.machine) - 1.0 / 3.0).abs() < 1e-12
                && (wake_up(&slow.machine) - 3.0).abs() < 1e-12
        );
        let networks: [fn(&Machine) -> Option<Network>; 3] =
            [|m| m.network.clone(), |m| m.node.clone(), |m| m.mpi.clone()];
        for of in networks.map(|network| move |m: &Machine| network(m).unwrap()) {
            let (ours, fast, slow) = (of(&machine), of(&fast.machine), of(&slow.machine));
            assert_eq!(
                [fast.bandwidth.value, slow.bandwidth.value],
                [4.0, 0.25].map(|x| ours.bandwidth.value * x)
            );
            for (ours, fast, slow) in
                [(&ours.message, &fast.message, &slow.message), (&ours.hop, &fast.hop, &slow.hop)]
            {
                assert!(
                    (fast.value * 1.5 - ours.value).abs() < 1e-15
                        && (ours.value * 1.5 - slow.value).abs() < 1e-15
                );
            }
        }
        let serial = |m: &Machine| m.processors.serial.as_ref().unwrap().value;
        assert_eq!([serial(&fast.machine), serial(&slow.machine)], [0.0, 0.1]);
    }

    /// Without anything that may be off, both ends are the machine.
    #[test]
    fn nothing_is_moved_by_nothing() {
        let mut machine = builtin("server-128").unwrap().unwrap();
        machine.uncertainty = Some(Assumptions::default());
        let [fast, slow] = ends(&machine).unwrap();
        assert_eq!((&fast.machine, &slow.machine), (&machine, &machine));
    }
}
