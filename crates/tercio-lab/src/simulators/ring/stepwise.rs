//! The passes of one stride, with every slot moved in every pass, as in document 000, appendix A.2.2.
//!
//! Slow and plain on purpose: [`super::stage`] has to produce the same copies in the same order.

use std::collections::VecDeque;

use super::destinations::Destinations;
use super::stage::{Descriptor, Passes, Stage};

/// A slot of the ring: a descriptor and the hops after which copies are still to be made.
struct Slot {
    descriptor: Descriptor,
    hops: Vec<u32>,
    travelled: u32,
}

/// As [`Stage::run`]; copies are reported in the order of the passes.
pub fn run(
    stage: &Stage,
    destinations: &Destinations,
    queues: &[Vec<Descriptor>],
    mut taken: impl FnMut(u64, u32, Descriptor),
) -> Passes {
    let (n, stride) = (stage.processors as usize, stage.stride);
    let mut sources: Vec<VecDeque<Slot>> = Vec::new();
    for (processor, queue) in queues.iter().enumerate() {
        let mut source = VecDeque::new();
        for &descriptor in queue {
            let mut hops: Vec<u32> = descriptor.hops(destinations, stride).collect();
            if hops.first() == Some(&0) {
                taken(0, processor as u32, descriptor.copy(0, stride));
                hops.remove(0);
            }
            if !hops.is_empty() {
                source.push_back(Slot { descriptor, hops, travelled: 0 });
            }
        }
        sources.push(source);
    }
    let mut ring: Vec<Option<Slot>> = (0..n).map(|_| None).collect();
    let mut result = Passes::default();
    loop {
        for (slot, source) in ring.iter_mut().zip(&mut sources) {
            if slot.is_none() {
                *slot = source.pop_front();
                result.descriptors += u64::from(slot.is_some());
            }
        }
        let occupied = ring.iter().flatten().count() as u64;
        if occupied == 0 && sources.iter().all(VecDeque::is_empty) {
            return result;
        }
        ring.rotate_right(stride as usize % n);
        result.passes += 1;
        result.occupied += occupied;
        for (processor, place) in ring.iter_mut().enumerate() {
            let Some(slot) = place else { continue };
            slot.travelled += 1;
            if slot.hops.first() == Some(&slot.travelled) {
                slot.hops.remove(0);
                taken(result.passes, processor as u32, slot.descriptor.copy(slot.travelled, stride));
            }
            if slot.hops.is_empty() && result.passes.is_multiple_of(u64::from(stage.test_period)) {
                *place = None;
            }
        }
    }
}
