//! The four sorting classes, phase by phase.
//!
//! Sort-middle is sort-twice with one group, sort-last is sort-twice with groups of one processor, so one function
//! does the three. In every class the finished picture is delivered. Machines whose processors all execute the same
//! instruction, in a ring, run by the rules of [`super::simd`]. Sources: document 000, chapters 4 and 6 and appendix A;
//! document 001, 2.3.

use serde::Serialize;
use tercio_mesh::loops::prelude::*;

use super::composition::{Groups, Step};
use super::network::{Links, NetworkModel, Traffic};
use super::regions::{Assignment, Regions};
use super::simd::{self, Simd};
use crate::machines::{
    Control, DataKind, Delivery, Machine, MachineError, Operation, Packing, SortingClass, Sourced,
};
use crate::simulators::ring::AlgorithmError;
use crate::units::Bytes;
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

impl Organisation {
    /// Its class, whatever the size of groups.
    pub fn class(self) -> SortingClass {
        match self {
            Self::SortFirst => SortingClass::SortFirst,
            Self::SortMiddle => SortingClass::SortMiddle,
            Self::SortLast => SortingClass::SortLast,
            Self::SortTwice(_) => SortingClass::SortTwice,
        }
    }

    /// Are pictures of several processors merged?
    pub fn composites(self) -> bool {
        matches!(self, Self::SortLast | Self::SortTwice(_))
    }

    /// What sort-twice is without groups worth the name: sort-last if each is one processor, sort-middle if one is all of
    /// them. None if it is an organisation of its own.
    pub fn without_groups(self, processors: usize) -> Option<Self> {
        match self {
            Self::SortTwice(group) if group >= processors => Some(Self::SortMiddle),
            Self::SortTwice(1) => Some(Self::SortLast),
            _ => None,
        }
    }
}

/// Processors of a group of sort-twice if nobody says how many: 16, or all of fewer. Groups of a SIMD machine divide its
/// processors: then the most up to 16 that do.
pub fn usual_group(machine: &Machine, processors: usize) -> usize {
    let most = processors.clamp(1, 16);
    match machine.processors.control {
        Control::Mimd => most,
        Control::Simd => (1..=most).rev().find(|&group| processors.is_multiple_of(group)).unwrap_or(1),
    }
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
    /// Bytes of a polygon before the geometry work; 0 if none travels and the description does not say.
    pub primitive: u64,
    /// Bytes of a set-up polygon.
    pub descriptor: u64,
    /// Bytes of a pixel with its depth.
    pub sample: u64,
    /// Bytes of a pixel of the finished picture.
    pub delivered: u64,
}

/// Vertices and triangles of a full cluster of the renderer.
const CLUSTER: [f64; 2] = [64.0, 128.0];

impl Costs {
    /// The costs of a description for some organisations. A machine that is charged for clusters transforms a polygon for
    /// its share of a full one.
    ///
    /// # Errors
    /// [`MachineError::Missing`] without the costs of geometry and pixels or the bytes of descriptors and samples, which every
    /// organisation keeps; without the cost of composition if one composites; without the bytes of primitives if
    /// one sends them.
    pub fn of(machine: &Machine, uses: &[Organisation]) -> Result<Self, MachineError> {
        use Operation::{Cluster, ClusterDrawn, ClusterEntry, Polygon, PolygonSetUp, Vertex};
        let whole = |bytes: &Sourced<Bytes>| bytes.value.ceil() as u64;
        let need = |kind: DataKind| {
            machine.need(machine.bytes.get(&kind), &format!("bytes.{}", kind.name())).map(whole)
        };
        let kinds: [&[_]; 3] = [&[Polygon, ClusterDrawn], &[Operation::Pixel], &[Operation::CompositePixel]];
        let composites = uses.iter().any(|o| o.composites());
        let sample = MachineError::both(
            need(DataKind::Sample),
            machine.need_costs(&kinds[..2 + usize::from(composites)]),
        );
        let descriptor = MachineError::both(need(DataKind::Descriptor), sample);
        let primitive = need(DataKind::Primitive)
            .or_else(|error| if uses.contains(&Organisation::SortFirst) { Err(error) } else { Ok(0) });
        let (primitive, (descriptor, (sample, ()))) = MachineError::both(primitive, descriptor)?;
        let [vertices, polygons] = CLUSTER;
        let of_cluster: f64 =
            [Cluster, ClusterEntry, ClusterDrawn].map(|o| machine.seconds_or_0(o)).iter().sum();
        let of_cluster = of_cluster + vertices * machine.seconds_or_0(Vertex);
        Ok(Self {
            polygon: machine.seconds(Polygon).unwrap_or(of_cluster / polygons),
            set_up: machine.seconds_or_0(PolygonSetUp),
            entry: machine.seconds_or_0(Operation::Entry) + machine.seconds_or_0(Operation::DrawnEntry),
            pixel: machine.seconds_or_0(Operation::Pixel),
            composite: machine.seconds_or_0(Operation::CompositePixel),
            primitive,
            descriptor,
            sample,
            delivered: machine.bytes.get(&DataKind::Pixel).map_or(4, whole),
        })
    }

    /// Operations of an organisation without a cost in the description: the times are too short if they occur.
    pub fn uncharged(&self, organisation: Organisation) -> Vec<Operation> {
        let all = [
            (self.polygon, Operation::Polygon),
            (self.set_up, Operation::PolygonSetUp),
            (self.entry, Operation::Entry),
            (self.pixel, Operation::Pixel),
            (self.composite, Operation::CompositePixel),
        ];
        let occurs = |o: &Operation| *o != Operation::CompositePixel || organisation.composites();
        all.into_iter().filter(|(s, o)| *s == 0.0 && occurs(o)).map(|(_, operation)| operation).collect()
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
    pub(super) fn of(times: impl Iterator<Item = f64>, processors: usize) -> Self {
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
    /// Traffic of the finished picture.
    pub delivery: Traffic,
    /// Seconds of that.
    pub delivery_seconds: f64,
    /// Rasterized polygons a visible polygon: the overlap.
    pub overlap: f64,
    /// Largest number of bytes that a processor stores: polygons that it rasterizes and its part of the picture.
    pub most_bytes_kept: u64,
}

impl SortReport {
    /// The whole frame, one phase after another.
    pub fn seconds(&self) -> f64 {
        self.geometry.seconds
            + self.redistribution_seconds
            + self.raster.seconds
            + self.composition_seconds
            + self.delivery_seconds
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
    /// The rules of a ring that executes one instruction at a time; `None` for processors with programs of their own.
    pub simd: Option<Simd>,
}

impl Setting {
    /// The settings of a machine for some organisations, with the largest regions, interleaved, on a screen of some pixels.
    ///
    /// # Errors
    /// [`MachineError`]: costs, bytes or a network are missing; the machine cannot have so many processors.
    pub fn of(
        machine: &Machine,
        processors: usize,
        (width, height): (u32, u32),
        topology: Option<crate::machines::Topology>,
        uses: &[Organisation],
    ) -> Result<Self, MachineError> {
        machine.may_have(processors)?;
        let (network, costs) =
            MachineError::both(NetworkModel::of(machine, topology), Costs::of(machine, uses))?;
        Ok(Self {
            width,
            height,
            processors,
            region: None,
            assignment: Assignment::Interleaved,
            network,
            costs,
            simd: Simd::of(machine, network.topology)?,
        })
    }

    pub(super) fn regions(&self, owners: usize) -> Regions {
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
/// # Errors
/// [`AlgorithmError`] if groups do not divide a SIMD ring.
///
/// # Panics
/// If there are no processors or the screen has no pixel.
pub fn simulate(
    scene: &BoxScene,
    organisation: Organisation,
    s: &Setting,
) -> Result<SortReport, AlgorithmError> {
    let n = s.processors;
    assert!(n > 0, "at least one processor");
    let group = match organisation {
        Organisation::SortFirst | Organisation::SortMiddle => n,
        Organisation::SortLast => 1,
        Organisation::SortTwice(g) => g.clamp(1, n),
    };
    if let Some(simd) = &s.simd {
        return simd::simulate(scene, organisation, group, s, simd);
    }
    let (work, traffic, visible) = sort(scene, organisation == Organisation::SortFirst, group, s);
    let entries: u64 = work.entries.iter().map(|&e| u64::from(e)).sum();
    let whole = s.regions(group);
    let picture = whole.owned().into_iter().max().unwrap_or(0) * s.costs.sample;
    let composed = compose(whole, group, s);
    let most_entries = u64::from(work.entries.iter().copied().max().unwrap_or(0));
    Ok(SortReport {
        organisation,
        processors: n,
        geometry: work.geometry(&s.costs),
        redistribution: traffic,
        redistribution_seconds: s.network.seconds(&traffic),
        raster: work.raster(&s.costs),
        composition: composed.composition,
        composition_seconds: composed.composition_seconds,
        delivery: composed.delivery,
        delivery_seconds: s.network.seconds(&composed.delivery),
        overlap: if visible == 0 { 0.0 } else { entries as f64 / visible as f64 },
        most_bytes_kept: most_entries * s.costs.descriptor + picture,
    })
}

/// Simulates a frame with each of many settings, on the cores of the current pool; the reports are in the order of the
/// settings. `finished` is called after each, in any order.
///
/// # Errors
/// As [`simulate`].
///
/// # Panics
/// As [`simulate`].
pub fn sweep(
    scene: &BoxScene,
    settings: &[(Organisation, Setting)],
    finished: impl Fn() + Sync,
) -> Result<Vec<SortReport>, AlgorithmError> {
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
    let mut links = Links::new(&s.network, n);
    let mut visible = 0;
    // A smaller last group divides the screen among its own processors.
    let (whole, rest) = (s.regions(group), s.regions((n % group).max(1)));
    let mut owners: Vec<usize> = Vec::new();
    let bytes = if before_geometry { s.costs.primitive } else { s.costs.descriptor };
    let mut sent = Vec::new();
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
            match s.network.packing {
                Packing::OneAPolygon => links.send(home, owner, bytes),
                Packing::OneADestination if home != owner => sent.push((home as u32, owner as u32)),
                Packing::OneADestination => {}
            }
        }
    }
    sent.sort_unstable();
    for of_pair in sent.chunk_by(|a, b| a == b) {
        links.send(of_pair[0].0 as usize, of_pair[0].1 as usize, of_pair.len() as u64 * bytes);
    }
    (work, links.traffic(), visible)
}

/// What composition and delivery send, and how long composition takes.
#[derive(Default)]
struct Composed {
    composition: Traffic,
    composition_seconds: f64,
    delivery: Traffic,
}

/// Composites the pictures of the groups and delivers the result, round by round.
fn compose(whole: Regions, group: usize, s: &Setting) -> Composed {
    let groups = Groups {
        processors: s.processors,
        size: group,
        whole,
        last: s.regions((s.processors % group).max(1)),
    };
    let mut composed = Composed::default();
    // Pixels that each processor merges in a round.
    let mut merged = vec![0u64; s.processors];
    groups.compose(|step, transfers| {
        if step == Step::Delivery && s.network.delivery == Delivery::Display {
            return;
        }
        let mut links = Links::new(&s.network, s.processors);
        let bytes = if step == Step::Delivery { s.costs.delivered } else { s.costs.sample };
        merged.fill(0);
        for t in transfers {
            links.send(t.from, t.to, t.pixels * bytes);
            merged[t.to] += t.pixels;
        }
        let traffic = links.traffic();
        if step == Step::Delivery {
            composed.delivery = traffic;
        } else {
            let most = merged.iter().copied().max().unwrap_or(0) as f64;
            composed.composition = composed.composition.then(traffic);
            composed.composition_seconds += s.network.seconds(&traffic) + most * s.costs.composite;
        }
    });
    composed
}

#[cfg(test)]
mod tests;
