//! The formulas of [`choose`](crate::predict::choose) with the costs and the network of any machine.
//!
//! Some of their costs are constants, fitted on the laboratory's machine: they are scaled by how much slower the machine draws the
//! picture. The costs of drawing are then scaled again, so that one rank of one thread takes as long as counting its work says; and
//! several threads of a rank are as fast as those of one process, again counted, and have to wake up like those. So ranks and threads
//! are comparable.

use std::collections::{BTreeMap, BTreeSet};

use tercio_mesh::loops::prelude::*;
use tercio_parallel::{Organisation, Sharing};
use tercio_scene::Instance;

use super::splits::Split;
use super::{Candidate, Frame, How, ends};
use crate::machines::{Machine, Topology};
use crate::predict::PredictError;
use crate::predict::choose;
use crate::predict::choose::candidates::Limits;
use crate::predict::choose::rates::Rates;
use crate::predict::choose::sights::Sights;
use crate::predict::choose::terms::Stage;
use crate::predict::choose::wires::{Wire, Wires};
use crate::predict::counts::count;
use crate::predict::frame::{FrameTime, waking};
use crate::predict::ranks::Picture;

/// One thread, that has messages with nobody.
pub(super) fn alone(rates: &Rates) -> Stage<'_> {
    let between = Wire { latency: 0.0, busy: 0.0, bandwidth: f64::INFINITY };
    Stage { rates, wires: Wires { between, inside: None }, share: 1.0, processors: 1.0, waking: 0.0 }
}

/// The costs of a picture on a machine.
///
/// # Errors
/// [`PredictError`]: a picture that cannot be drawn.
pub fn rates(machine: &Machine, picture: &Picture) -> Result<Rates, PredictError> {
    let counters = count(picture.scene, picture.camera, picture.settings, 1)?.frame;
    let seconds = |machine: &Machine| FrameTime::on_one_thread(machine, &counters).total();
    let own = seconds(machine);
    let slower = own / seconds(&choose::machine()?);
    let translucent = picture.scene.instances.iter().any(Instance::is_translucent);
    let rates = Rates::of(machine, picture.settings, translucent).slower(slower);
    let sharing = [Sharing::from(Organisation::SortMiddle)];
    let predicted = Sights::new(picture, 1).predict(&sharing, &alone(&rates))?;
    let terms = predicted.first().map_or_else(Default::default, |first| first.terms);
    let times = (own - terms.front_end) / terms.draw;
    // An empty picture has nothing to compare.
    Ok(if times.is_finite() && times > 0.0 { rates.drawing(times) } else { rates })
}

/// Predicts all ways in which the ranks of each split share the frame, each thread with a processor of its own, or with so many
/// processors of all ranks together.
///
/// # Errors
/// [`PredictError`].
pub fn ranks(
    machine: &Machine,
    picture: &Picture,
    topology: Option<Topology>,
    splits: &[Split],
    processors: Option<usize>,
) -> Result<Vec<Candidate>, PredictError> {
    let rates = rates(machine, picture)?;
    let of_ends = ends::ends(machine);
    // Of the machine, and at both ends of what is assumed of it; waking up is charged apart, because it does not grow with the work.
    let seconds = |threads: usize| -> Result<[f64; 3], PredictError> {
        let (time, at_ends) = ends::on_threads(machine, of_ends.as_ref(), picture, None, threads)?;
        let [fast, slow] = at_ends.unwrap_or([time; 2]);
        Ok([time, fast, slow].map(|time| time.awake()))
    };
    let one = seconds(1)?;
    let mut shares = BTreeMap::new();
    for threads in splits.iter().map(|split| split.threads).collect::<BTreeSet<_>>() {
        let together = if threads > 1 { seconds(threads)? } else { one };
        let share = |k: usize| if one[k] > 0.0 { together[k] / one[k] } else { 1.0 };
        shares.insert(threads, std::array::from_fn::<f64, 3, _>(share));
    }
    let numbers: BTreeSet<usize> = splits.iter().map(|split| split.ranks).collect();
    let of_ranks = |&ranks: &usize| -> Result<Vec<Candidate>, PredictError> {
        let sharings = Limits::ALL.candidates(ranks)?;
        let mut sights = Sights::new(picture, ranks);
        let mut found = Vec::new();
        for &split in splits.iter().filter(|split| split.ranks == ranks) {
            let wires = Wires::of(machine, topology, ranks, split.threads)?;
            let processors = processors.unwrap_or(split.processors()) as f64;
            let shares = &shares[&split.threads];
            let stage = |wires, share, waking| Stage { rates: &rates, wires, share, processors, waking };
            let mut at_ends = Vec::new();
            for (end, &share) in of_ends.iter().flatten().zip(&shares[1..]) {
                // All costs are so many times as high: then that is the unit of time, in which only messages differ.
                let wires = Wires::of(&end.machine, topology, ranks, split.threads)?.in_units_of(end.costs);
                let waking = waking(&end.machine, split.threads) / end.costs;
                let predicted = sights.predict(&sharings, &stage(wires, share, waking))?;
                at_ends.push(predicted.iter().map(|p| p.terms.total() * end.costs).collect::<Vec<_>>());
            }
            let waking = waking(machine, split.threads);
            let predicted = sights.predict(&sharings, &stage(wires, shares[0], waking))?;
            found.extend(predicted.into_iter().enumerate().map(|(k, p)| {
                let frame = Frame::Formulas { terms: p.terms, sent: p.sent };
                let assumed = if let [fast, slow] = &at_ends[..] { Some([fast[k], slow[k]]) } else { None };
                Candidate { split, how: How::Ranks { sharing: p.sharing, region: None }, frame, assumed }
            }));
        }
        Ok(found)
    };
    let numbers: Vec<usize> = numbers.iter().copied().collect();
    let all: Result<Vec<_>, _> = numbers.par_iter().map(of_ranks).collect();
    Ok(all?.into_iter().flatten().collect())
}
