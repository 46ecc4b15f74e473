//! The four sorting classes, phase by phase.
//!
//! Sort-middle is sort-twice with one group, sort-last is sort-twice with groups of one processor, so one function
//! does the three. Sources: document 000, chapters 4 and 6 and appendix A; document 001, 2.3.

use rayon::prelude::*;
use serde::Serialize;

use super::network::{Links, NetworkModel, Traffic};
use super::regions::{Assignment, Regions};
use crate::machines::{DataKind, Machine, MachineError, Operation};
use crate::workloads::{BoxScene, PixelBox};

/// Where polygons and pixels are redistributed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Organisation {
    /// Polygons are sent before the geometry work, which every owner of a touched region then does.
    SortFirst,
    /// Set-up polygons are sent to the owners of the regions that they touch.
    SortMiddle,
    /// Pictures are composited.
    SortLast,
    /// Sort-middle within groups of this many consecutive processors, then the groups' pictures are composited. The
    /// last group may be smaller.
    SortTwice(usize),
}

/// Costs of a processor's work in seconds, and sizes in bytes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Costs {
    /// Seconds to transform a polygon and keep or reject it.
    pub polygon: f64,
    /// Seconds to set up a visible polygon.
    pub set_up: f64,
    /// Seconds to start a polygon's rasterization.
    pub entry: f64,
    /// Seconds of a pixel of a polygon's box.
    pub pixel: f64,
    /// Seconds to merge a pixel of two pictures.
    pub composite: f64,
    /// Bytes of a polygon before the geometry work.
    pub primitive: u64,
    /// Bytes of a set-up polygon.
    pub descriptor: u64,
    /// Bytes of a pixel with its depth.
    pub sample: u64,
}

impl Costs {
    /// The costs of a description; operations without a cost in it cost nothing.
    ///
    /// # Errors
    /// [`MachineError::Missing`] without the sizes of messages.
    pub fn of(machine: &Machine) -> Result<Self, MachineError> {
        let bytes = |kind: DataKind| {
            let what = format!("bytes.{}", kind.name());
            machine.need(machine.bytes.get(&kind), &what).map(|b| b.value.ceil() as u64)
        };
        Ok(Self {
            polygon: machine.seconds_or_0(Operation::Polygon),
            set_up: machine.seconds_or_0(Operation::PolygonSetUp),
            entry: machine.seconds_or_0(Operation::Entry) + machine.seconds_or_0(Operation::DrawnEntry),
            pixel: machine.seconds_or_0(Operation::Pixel),
            composite: machine.seconds_or_0(Operation::CompositePixel),
            primitive: bytes(DataKind::Primitive)?,
            descriptor: bytes(DataKind::Descriptor)?,
            sample: bytes(DataKind::Sample)?,
        })
    }

    /// Operations without a cost in the description: the times are too short if they occur.
    pub fn uncharged(&self) -> Vec<Operation> {
        let all = [
            (self.polygon, Operation::Polygon),
            (self.set_up, Operation::PolygonSetUp),
            (self.entry, Operation::Entry),
            (self.pixel, Operation::Pixel),
            (self.composite, Operation::CompositePixel),
        ];
        all.into_iter().filter(|(seconds, _)| *seconds == 0.0).map(|(_, operation)| operation).collect()
    }
}

/// A phase in which every processor works for itself.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Computing {
    /// Seconds of the busiest processor.
    pub seconds: f64,
    /// Seconds of the mean processor.
    pub mean: f64,
}

impl Computing {
    fn of(times: impl Iterator<Item = f64>, processors: usize) -> Self {
        let (mut seconds, mut sum) = (0.0f64, 0.0);
        for t in times {
            seconds = seconds.max(t);
            sum += t;
        }
        Self { seconds, mean: sum / processors.max(1) as f64 }
    }

    /// Busiest over mean, 1 where nothing is done.
    pub fn imbalance(&self) -> f64 {
        if self.mean > 0.0 { self.seconds / self.mean } else { 1.0 }
    }
}

/// A frame.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SortReport {
    /// Where it sorts.
    pub organisation: Organisation,
    /// Processors.
    pub processors: usize,
    /// Geometry work.
    pub geometry: Computing,
    /// Traffic of polygons.
    pub redistribution: Traffic,
    /// Seconds of that.
    pub redistribution_seconds: f64,
    /// Rasterization.
    pub raster: Computing,
    /// Traffic of pixels.
    pub composition: Traffic,
    /// Seconds of that, merging included.
    pub composition_seconds: f64,
    /// Rasterized polygons a visible polygon: the overlap.
    pub overlap: f64,
    /// Largest number of bytes that a processor stores: polygons that it rasterizes and its part of the picture.
    pub most_bytes_kept: u64,
}

impl SortReport {
    /// The whole frame, one phase after another.
    pub fn seconds(&self) -> f64 {
        self.geometry.seconds + self.redistribution_seconds + self.raster.seconds + self.composition_seconds
    }
}

/// Parameters of a simulated frame.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Setting {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Processors.
    pub processors: usize,
    /// Pixels along the edge of a region; `None` is the largest that gives every owner a region.
    pub region: Option<u32>,
    /// Who gets which region.
    pub assignment: Assignment,
    /// The network.
    pub network: NetworkModel,
    /// The costs.
    pub costs: Costs,
}

impl Setting {
    fn regions(&self, owners: usize) -> Regions {
        let fitting = Regions::fitting(self.width, self.height, owners, self.assignment);
        self.region.map_or(fitting, |edge| Regions { edge: edge.max(1), ..fitting })
    }
}

/// Amounts of work of every processor.
struct Work {
    transformed: Vec<u32>,
    set_up: Vec<u32>,
    entries: Vec<u32>,
    pixels: Vec<u64>,
}

impl Work {
    fn none(n: usize) -> Self {
        Self { transformed: vec![0; n], set_up: vec![0; n], entries: vec![0; n], pixels: vec![0; n] }
    }

    fn geometry(&self, c: &Costs) -> Computing {
        let times = self.transformed.iter().zip(&self.set_up);
        let seconds = times.map(|(&t, &s)| f64::from(t) * c.polygon + f64::from(s) * c.set_up);
        Computing::of(seconds, self.set_up.len())
    }

    fn raster(&self, c: &Costs) -> Computing {
        let times = self.entries.iter().zip(&self.pixels);
        let seconds = times.map(|(&e, &p)| f64::from(e) * c.entry + p as f64 * c.pixel);
        Computing::of(seconds, self.entries.len())
    }
}

/// Simulates a frame. Polygon k starts on processor k modulo the number of processors; a polygon's pixels are those of
/// its box, as in document 000, appendix A. Parts outside the screen are ignored.
///
/// # Panics
/// If there are no processors or the screen has no pixel.
pub fn simulate(scene: &BoxScene, organisation: Organisation, s: &Setting) -> SortReport {
    let n = s.processors;
    assert!(n > 0, "at least one processor");
    let group = match organisation {
        Organisation::SortFirst | Organisation::SortMiddle => n,
        Organisation::SortLast => 1,
        Organisation::SortTwice(g) => g.clamp(1, n),
    };
    let (work, traffic, visible) = sort(scene, organisation == Organisation::SortFirst, group, s);
    let entries: u64 = work.entries.iter().map(|&e| u64::from(e)).sum();
    let (composition, merged) = compose(group, s);
    let picture = u64::from(s.width) * u64::from(s.height) / group as u64 * s.costs.sample;
    let most_entries = u64::from(work.entries.iter().copied().max().unwrap_or(0));
    SortReport {
        organisation,
        processors: n,
        geometry: work.geometry(&s.costs),
        redistribution: traffic,
        redistribution_seconds: s.network.seconds(&traffic),
        raster: work.raster(&s.costs),
        composition,
        composition_seconds: s.network.seconds(&composition) + merged as f64 * s.costs.composite,
        overlap: if visible == 0 { 0.0 } else { entries as f64 / visible as f64 },
        most_bytes_kept: most_entries * s.costs.descriptor + picture,
    }
}

/// Simulates a frame with each of many settings, on the cores of the current pool; the reports are in the order of the
/// settings. `finished` is called after each, in any order.
///
/// # Panics
/// As [`simulate`].
pub fn sweep(
    scene: &BoxScene,
    settings: &[(Organisation, Setting)],
    finished: impl Fn() + Sync,
) -> Vec<SortReport> {
    let run = |(organisation, setting): &(Organisation, Setting)| {
        let report = simulate(scene, *organisation, setting);
        finished();
        report
    };
    settings.par_iter().map(run).collect()
}

/// Distributes polygons and sends them to the owners of the regions that they touch.
fn sort(scene: &BoxScene, before_geometry: bool, group: usize, s: &Setting) -> (Work, Traffic, u64) {
    let n = s.processors;
    let screen = PixelBox::screen(s.width, s.height);
    let mut work = Work::none(n);
    let mut links = Links::new(s.network.topology, n);
    let mut visible = 0;
    // A smaller last group divides the screen among its own processors.
    let (whole, rest) = (s.regions(group), s.regions((n % group).max(1)));
    let mut owners: Vec<usize> = Vec::new();
    for (number, polygon) in scene.boxes.iter().enumerate() {
        let home = number % n;
        if !before_geometry {
            work.transformed[home] += 1;
        }
        let on_screen = polygon.pixels.intersection(&screen).filter(|_| polygon.visible);
        let Some(pixels) = on_screen else {
            // In sort-first, a polygon has to be transformed where it starts, to find its regions.
            work.transformed[home] += u32::from(before_geometry);
            continue;
        };
        visible += 1;
        work.set_up[home] += u32::from(!before_geometry);
        let first = home / group * group;
        let regions = if first + group <= n { &whole } else { &rest };
        owners.clear();
        for (region, area) in regions.touched(pixels) {
            let owner = first + regions.owner(region);
            work.pixels[owner] += area;
            owners.push(owner);
        }
        owners.sort_unstable();
        owners.dedup();
        for &owner in &owners {
            work.entries[owner] += 1;
            if before_geometry {
                work.transformed[owner] += 1;
                work.set_up[owner] += 1;
            }
            let bytes = if before_geometry { s.costs.primitive } else { s.costs.descriptor };
            links.send(home, owner, bytes);
        }
    }
    (work, links.traffic(), visible)
}

/// Composites the pictures of the groups by binary swap: processors with the same position in their groups halve their
/// part of the picture in every round and exchange the halves, with the nearest partner while the halves are large. If
/// the number of groups is no power of two, the excess groups first send their whole part to others. Returns the
/// traffic and the pixels that a processor merges, one round after another.
fn compose(group: usize, s: &Setting) -> (Traffic, u64) {
    let groups = s.processors / group;
    if groups <= 1 {
        return (Traffic::default(), 0);
    }
    let pixels = u64::from(s.width) * u64::from(s.height);
    let mut part = pixels.div_ceil(group as u64);
    let swapping = 1usize << groups.ilog2();
    let (mut traffic, mut merged) = (Traffic::default(), 0);
    let mut round = |pairs: &mut dyn Iterator<Item = (usize, usize)>, both: bool, part: u64| {
        let mut links = Links::new(s.network.topology, s.processors);
        for (a, b) in pairs {
            for member in 0..group {
                links.send(a * group + member, b * group + member, part * s.costs.sample);
                if both {
                    links.send(b * group + member, a * group + member, part * s.costs.sample);
                }
            }
        }
        traffic = traffic.then(links.traffic());
        merged += part;
    };
    if swapping < groups {
        round(&mut (swapping..groups).map(|g| (g, g - swapping)), false, part);
    }
    for bit in 0..swapping.ilog2() {
        part = part.div_ceil(2);
        let pairs = (0..swapping).filter(|g| g >> bit & 1 == 0).map(|g| (g, g | 1 << bit));
        round(&mut { pairs }, true, part);
    }
    (traffic, merged)
}

#[cfg(test)]
mod tests;
