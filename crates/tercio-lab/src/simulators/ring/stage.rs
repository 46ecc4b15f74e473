//! The passes of one stride.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use tercio_parallel::numbers::gcd;

use super::destinations::Destinations;

/// A polygon at a processor that has to pass it on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Descriptor {
    /// Number of the polygon in [`Destinations`].
    pub polygon: u32,
    /// Its position: offset from the polygon's sender.
    pub base: u32,
    /// The last offset it may serve. Those further on have their own copy (A.2.2: after passes of stride d a copy
    /// serves d processors).
    pub end: u32,
}

impl Descriptor {
    /// The processor that holds it, on a ring of `n`.
    pub fn holder(&self, destinations: &Destinations, n: u32) -> u32 {
        (destinations.source(self.polygon) + self.base) % n
    }

    /// After how many passes of `stride` a processor receives a copy, ascending; 0 is the holder itself. A destination
    /// is served from the last processor before it that the stride touches (figure A-6).
    pub fn hops<'a>(&'a self, destinations: &'a Destinations, stride: u32) -> impl Iterator<Item = u32> + 'a {
        let mut next = 0;
        destinations.runs(self.polygon).iter().flat_map(move |run| {
            let (first, last) = (run.first.max(self.base), run.last.min(self.end));
            let hops = if first <= last {
                let begin = ((first - self.base) / stride).max(next);
                begin..(last - self.base) / stride + 1
            } else {
                0..0
            };
            next = next.max(hops.end);
            hops
        })
    }

    /// The copy that is received after `hops` passes of `stride`.
    pub fn copy(&self, hops: u32, stride: u32) -> Self {
        let base = self.base + hops * stride;
        Self { polygon: self.polygon, base, end: self.end.min(base + (stride - 1)) }
    }
}

/// Parameters of the passes of one stride.
#[derive(Clone, Copy, Debug)]
pub struct Stage {
    /// n: processors.
    pub processors: u32,
    /// d: processors that a pass moves over.
    pub stride: u32,
    /// t: passes between two checks for free slots.
    pub test_period: u32,
}

/// Counts of the passes of one stride.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Passes {
    /// Passes until every slot is free.
    pub passes: u64,
    /// Descriptors that took a slot.
    pub descriptors: u64,
    /// Slots times passes in which they held a descriptor.
    pub occupied: u64,
}

impl Stage {
    /// Passes the descriptors round. `queues` has one list per processor; `taken` is called for every copy with the
    /// number of the pass after which its processor receives it (0 for the holder itself) and that processor.
    ///
    /// Slots are processed when they become free or when a free one reaches a queue that is not empty. Slots do not
    /// interact within a pass, since each is at another processor; so the result is that of moving them all at once.
    pub fn run(
        &self,
        destinations: &Destinations,
        queues: &[Vec<Descriptor>],
        mut taken: impl FnMut(u64, u32, Descriptor),
    ) -> Passes {
        let (n, stride, period) = (self.processors, self.stride, u64::from(self.test_period));
        let mut waiting = Waiting::new(n, stride);
        let mut queue: Vec<std::iter::Peekable<_>> = Vec::with_capacity(queues.len());
        for (processor, list) in (0..n).zip(queues) {
            // The holder keeps its own copy; polygons without other destinations do not enter the ring.
            let mut travel = Vec::new();
            for descriptor in list {
                let mut hops = descriptor.hops(destinations, stride).peekable();
                if hops.peek() == Some(&0) {
                    taken(0, processor, descriptor.copy(0, stride));
                }
                if hops.any(|h| h > 0) {
                    travel.push(*descriptor);
                }
            }
            waiting.set(processor, !travel.is_empty());
            queue.push(travel.into_iter().peekable());
        }

        let mut result = Passes::default();
        // Slots by the pass of their next event. Slot s starts at processor s.
        let mut slots: BinaryHeap<Reverse<(u64, u32)>> = (0..n).map(|slot| Reverse((0, slot))).collect();
        while let Some(Reverse((time, slot))) = slots.pop() {
            let at = ((u64::from(slot) + time % u64::from(n) * u64::from(stride)) % u64::from(n)) as u32;
            let Some(distance) = waiting.next(at) else { continue };
            if distance > 0 {
                slots.push(Reverse((time + u64::from(distance), slot)));
                continue;
            }
            let Some(descriptor) = queue[at as usize].next() else { continue };
            waiting.set(at, queue[at as usize].peek().is_some());
            let mut last = 0;
            for hops in descriptor.hops(destinations, stride).filter(|&h| h > 0) {
                last = hops;
                let copy = descriptor.copy(hops, stride);
                taken(time + u64::from(hops), copy.holder(destinations, n), copy);
            }
            let free = (time + u64::from(last)).next_multiple_of(period);
            result.descriptors += 1;
            result.occupied += free - time;
            result.passes = result.passes.max(free);
            slots.push(Reverse((free, slot)));
        }
        result
    }
}

/// The processors whose queues are not empty, in the order in which a slot visits them.
struct Waiting {
    /// Positions of the processors in that order: one cycle of slots after another.
    place: Vec<u32>,
    /// Length of a cycle.
    cycle: u32,
    /// One bit a place.
    bits: Vec<u64>,
}

impl Waiting {
    fn new(n: u32, stride: u32) -> Self {
        let cycles = gcd(n as usize, stride as usize) as u32;
        let cycle = n / cycles;
        let mut place = vec![0; n as usize];
        for c in 0..cycles {
            for k in 0..cycle {
                let processor = (u64::from(c) + u64::from(k) * u64::from(stride)) % u64::from(n);
                place[processor as usize] = c * cycle + k;
            }
        }
        Self { place, cycle, bits: vec![0; (n as usize).div_ceil(64)] }
    }

    fn set(&mut self, processor: u32, waiting: bool) {
        let place = self.place[processor as usize];
        let bit = 1 << (place % 64);
        let word = &mut self.bits[(place / 64) as usize];
        *word = if waiting { *word | bit } else { *word & !bit };
    }

    /// After how many passes a slot at this processor reaches a queue that is not empty now.
    fn next(&self, processor: u32) -> Option<u32> {
        let place = self.place[processor as usize];
        let begin = place - place % self.cycle;
        let ahead = self.first(place, begin + self.cycle).map(|found| found - place);
        ahead.or_else(|| self.first(begin, place).map(|found| found + self.cycle - place))
    }

    /// The first set bit in a range of positions.
    fn first(&self, begin: u32, end: u32) -> Option<u32> {
        let mut place = begin;
        while place < end {
            let word = self.bits[(place / 64) as usize] >> (place % 64);
            if word != 0 {
                let found = place + word.trailing_zeros();
                return (found < end).then_some(found);
            }
            place = (place / 64 + 1) * 64;
        }
        None
    }
}
