//! The destinations and the sender of each polygon (document 000, appendix A.2.1 and A.2.2).
//!
//! A destination is an *offset*: its distance to the right of the sender in processors, 0 for the sender itself. The
//! n-bit vectors of the document are stored as runs of neighbouring offsets.

use super::{Algorithm, Machine};
use crate::workloads::{PixelBox, ScreenMap};

/// Neighbouring offsets, inclusive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Run {
    /// The least offset.
    pub first: u32,
    /// The greatest offset.
    pub last: u32,
}

/// The destinations of all visible polygons.
#[derive(Clone, Debug, Default)]
pub struct Destinations {
    /// The polygons' senders.
    sources: Vec<u32>,
    /// Index of each polygon's first run; one more entry at the end.
    starts: Vec<usize>,
    /// Runs of offsets, ascending and disjoint.
    runs: Vec<Run>,
}

/// Sender and destinations of one polygon.
#[derive(Clone, Debug, Default)]
pub struct Route {
    /// The processor that sends it.
    pub source: u32,
    /// Its destinations with the number of pixels that each has to rasterize, offsets ascending.
    pub stops: Vec<(u32, u64)>,
    overlap: Vec<(u32, u64)>,
    candidate: Vec<(u32, u64)>,
}

/// The processors that hold a polygon: b mod n/m and every n/m-th after it (A.2.1, where "+ km" has to read "+ k n/m",
/// as in section 5.4).
pub fn copies(
    polygon: u64,
    processors: u32,
    duplication: u32,
) -> impl DoubleEndedIterator<Item = u32> + Clone {
    let distance = processors / duplication;
    let first = (polygon % u64::from(distance)) as u32;
    (0..duplication).map(move |k| first + k * distance)
}

impl Route {
    /// Finds sender and destinations of polygon number `polygon` of the model. There are no stops if its box contains
    /// no pixel of the screen.
    ///
    /// With one group the sender is the rightmost holder at or left of the polygon's first processor, or the last
    /// holder if there is none (A.2.1). With several groups each region has a processor near every holder; the sender
    /// is then the holder whose farthest stop is nearest, the first of equal ones.
    pub fn find(
        &mut self,
        machine: &Machine,
        algorithm: &Algorithm,
        map: &ScreenMap,
        polygon: u64,
        pixels: &PixelBox,
    ) {
        let Self { source, stops, overlap, candidate } = self;
        let (n, g) = (machine.processors, algorithm.group);
        stops.clear();
        map.overlap(pixels, overlap);
        let holders = copies(polygon, n, algorithm.duplication);
        *source = holders.clone().next().unwrap_or(0);
        let Some(&(first, _)) = overlap.first() else { return };
        if g == n {
            let left = holders.clone().rev().find(|&holder| holder <= first);
            *source = left.or_else(|| holders.clone().next_back()).unwrap_or(0);
            offsets(*source, n, overlap, stops);
            return;
        }
        for holder in holders {
            offsets(holder, g, overlap, candidate);
            let farthest = |stops: &[(u32, u64)]| stops.last().map_or(u32::MAX, |s| s.0);
            if farthest(candidate) < farthest(stops) {
                *source = holder;
                std::mem::swap(candidate, stops);
            }
        }
    }
}

/// The regions of a polygon as offsets from `source`, where the regions repeat every `period` processors.
fn offsets(source: u32, period: u32, regions: &[(u32, u64)], stops: &mut Vec<(u32, u64)>) {
    let phase = source % period;
    // Regions from the sender's own on come first, those before it after one turn round the ring.
    let split = regions.partition_point(|&(region, _)| region < phase);
    let (before, from) = regions.split_at(split);
    stops.clear();
    stops.extend(from.iter().map(|&(region, pixels)| (region - phase, pixels)));
    stops.extend(before.iter().map(|&(region, pixels)| (region + period - phase, pixels)));
}

impl Destinations {
    /// Adds a polygon. Its number here is the number of polygons added before it.
    pub fn push(&mut self, route: &Route) {
        self.sources.push(route.source);
        self.starts.push(self.runs.len());
        let begin = self.runs.len();
        for &(offset, _) in &route.stops {
            match self.runs[begin..].last_mut() {
                Some(run) if run.last + 1 == offset => run.last = offset,
                _ => self.runs.push(Run { first: offset, last: offset }),
            }
        }
    }

    /// Number of polygons.
    pub fn len(&self) -> usize {
        self.sources.len()
    }

    /// True without polygons.
    pub fn is_empty(&self) -> bool {
        self.sources.is_empty()
    }

    /// The sender of a polygon.
    pub fn source(&self, polygon: u32) -> u32 {
        self.sources[polygon as usize]
    }

    /// The destinations of a polygon as offsets from its sender.
    pub fn runs(&self, polygon: u32) -> &[Run] {
        let end = self.starts.get(polygon as usize + 1).copied().unwrap_or(self.runs.len());
        &self.runs[self.starts[polygon as usize]..end]
    }
}
