//! A machine as its TOML file describes it.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::check::check;
use super::error::MachineError;
use super::kinds::{Control, Delivery, Packing, ScreenDivision, SortingClass, Topology};
use super::operations::Operation;
use super::sections::{Assumptions, Calibration, Heap, Sdram, TileEngine, Transfer};
use super::sourced::{Cost, Sourced};
use super::stages::Stage;
use super::{NAMES, builtin};
use crate::units::{Bytes, BytesPerSecond, Count, Hertz, PolygonRate, Ratio, Seconds};

/// A machine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Machine {
    /// Its name.
    pub name: String,
    /// What it is, in a sentence or two.
    pub summary: String,
    /// Where it sorts and how it divides the screen.
    pub sorting: Sorting,
    /// Its processors.
    pub processors: Processors,
    /// Its stages in order, for its diagram, if they differ in number or kind. The scene is before them, the picture after them. Without
    /// them, geometry and rasterization are drawn as the work of `processors.count` processors.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub stages: Vec<Stage>,
    /// Its screen, if a document gives it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub screen: Option<Screen>,
    /// Its network; between nodes, if there is a section `node`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub network: Option<Network>,
    /// The network between the processors of one node (`processors.per-node`): its memory.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub node: Option<Network>,
    /// The network as measured with MPI messages, if it was measured in addition to messages between threads, which are
    /// `network`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mpi: Option<Network>,
    /// Sizes of what is sent and stored.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub bytes: BTreeMap<DataKind, Sourced<Bytes>>,
    /// What work costs on one processor.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub costs: BTreeMap<Operation, Sourced<Cost>>,
    /// Triangle heap.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub heap: Option<Heap>,
    /// Memory below the heap.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sdram: Option<Sdram>,
    /// Tile engines.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tile_engine: Option<TileEngine>,
    /// Bus from the host.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub transfer: Option<Transfer>,
    /// How the numbers were measured, if `tercio lab calibrate` measured them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub calibration: Option<Calibration>,
    /// How far numbers that were not measured on it may be off.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub uncertainty: Option<Assumptions>,
    /// Polygon rates that its makers or a document claim or measured, by name.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub claims: BTreeMap<String, Sourced<PolygonRate>>,
}

/// Where a machine sorts and how it divides the screen.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Sorting {
    /// Where work is redistributed.
    pub class: SortingClass,
    /// How the screen is divided.
    pub screen: ScreenDivision,
    /// Description in words.
    pub how: String,
    /// The source of this section.
    pub source: String,
}

/// The processors of a machine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Processors {
    /// Their number.
    pub count: Sourced<Count>,
    /// Who decides what they do next: `mimd` by default.
    #[serde(default, skip_serializing_if = "is_default")]
    pub control: Control,
    /// The largest number that a document or the maker considers; `count` by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at_most: Option<Sourced<Count>>,
    /// Their clock.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clock: Option<Sourced<Hertz>>,
    /// Memory of each.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub memory: Option<Sourced<Bytes>>,
    /// Bandwidth of memory that all processors of a node share.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub memory_bandwidth: Option<Sourced<BytesPerSecond>>,
    /// Cache of each.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub own_cache: Option<Sourced<Bytes>>,
    /// Cache that the processors share.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shared_cache: Option<Sourced<Bytes>>,
    /// Part of the shared cache that pictures and messages of ranks stay in, beside the model and other programs; half of it by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub exchange_cache: Option<Sourced<Bytes>>,
    /// Processors that share one memory, which the section `node` describes; all of them by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub per_node: Option<Sourced<Count>>,
    /// Share of a frame's work that runs on one processor only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub serial: Option<Sourced<Ratio>>,
    /// Time from the beginning of a frame until the other processors take part; none by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wake_up: Option<Sourced<Seconds>>,
    /// Processor time of a short sleep and of waking up from it, which a process that polls for a message takes from one that works
    /// on the same processor; none by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nap: Option<Sourced<Seconds>>,
}

/// The screen.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Screen {
    /// Pixels across.
    pub width: Sourced<Count>,
    /// Pixels down.
    pub height: Sourced<Count>,
}

/// The network.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Network {
    /// Their shape.
    pub topology: Topology,
    /// Bandwidth of one link in one direction.
    pub bandwidth: Sourced<BytesPerSecond>,
    /// Time of one hop.
    pub hop: Sourced<Seconds>,
    /// Time that a processor spends on every message.
    pub message: Sourced<Seconds>,
    /// How polygons are packed into messages: `one-a-destination` by default.
    #[serde(default, skip_serializing_if = "is_default")]
    pub packing: Packing,
    /// Where the finished picture goes: to the `first-processor` by default.
    #[serde(default, skip_serializing_if = "is_default")]
    pub delivery: Delivery,
}

pub(super) fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

/// What is sent or stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum DataKind {
    /// A polygon before the geometry work.
    Primitive,
    /// A polygon after it, ready for rasterization.
    Descriptor,
    /// A pixel of a partial picture with its depth.
    Sample,
    /// A pixel of the finished picture; 4 B by default, a colour.
    Pixel,
}

impl DataKind {
    /// The name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Primitive => "primitive",
            Self::Descriptor => "descriptor",
            Self::Sample => "sample",
            Self::Pixel => "pixel",
        }
    }
}

impl Machine {
    /// Seconds that an operation costs, if the description says so.
    pub fn seconds(&self, operation: Operation) -> Option<f64> {
        match self.costs.get(&operation)?.cost() {
            Cost::Time(time) => Some(time.get()),
            Cost::Cycles(cycles) => Some((cycles / self.processors.clock.as_ref()?.get()).get()),
        }
    }

    /// Seconds that an operation costs; 0 if the machine is not charged for it.
    pub fn seconds_or_0(&self, operation: Operation) -> f64 {
        self.seconds(operation).unwrap_or(0.0)
    }

    /// The clock in Hz.
    ///
    /// # Errors
    /// [`MachineError::Missing`].
    pub fn clock(&self) -> Result<f64, MachineError> {
        self.need(self.processors.clock.as_ref(), "processors.clock").map(|c| c.value)
    }

    /// A part of the description that the caller requires.
    ///
    /// # Errors
    /// [`MachineError::Missing`] with the name of the part.
    pub fn need<'a, T>(&self, part: Option<&'a T>, what: &str) -> Result<&'a T, MachineError> {
        part.ok_or_else(|| MachineError::Missing { machine: self.name.clone(), what: what.into() })
    }

    /// The largest number of processors that it may have.
    pub fn most_processors(&self) -> u64 {
        let p = &self.processors;
        p.at_most.as_ref().map_or(p.count.whole(), |most| most.whole().max(p.count.whole()))
    }

    /// The processors of the machine if `wanted` are: more than are described, as far as it may have them.
    pub fn processors_for(&self, wanted: usize) -> usize {
        let [described, most] = [self.processors.count.whole(), self.most_processors()];
        (wanted as u64).clamp(described, most) as usize
    }

    /// The largest number of processors that share a memory: those of a node. Processors of a SIMD machine have one each.
    pub fn most_threads(&self) -> u64 {
        if self.processors.control == Control::Simd {
            return 1;
        }
        self.processors.per_node.as_ref().map_or(self.most_processors(), Sourced::whole)
    }

    /// Checks that the machine may have so many processors.
    ///
    /// # Errors
    /// [`MachineError::TooMany`].
    pub fn may_have(&self, processors: usize) -> Result<(), MachineError> {
        self.at_most("processors", self.most_processors(), processors)
    }

    fn at_most(&self, what: &'static str, most: u64, found: usize) -> Result<(), MachineError> {
        let (machine, found) = (self.name.clone(), found as u64);
        if found <= most { Ok(()) } else { Err(MachineError::TooMany { machine, what, most, found }) }
    }

    /// Checks that so many processors may share a memory.
    ///
    /// # Errors
    /// [`MachineError::TooMany`].
    pub fn may_share_memory(&self, processors: usize) -> Result<(), MachineError> {
        self.at_most("processors that share a memory", self.most_threads(), processors)
    }

    /// Checks that one operation of each kind of work has a cost of more than 0.
    ///
    /// # Errors
    /// [`MachineError::Missing`] with the names of the costs of all kinds of work that have none.
    pub fn need_costs(&self, kinds: &[&[Operation]]) -> Result<(), MachineError> {
        let is_free = |o: &Operation| self.costs.get(o).is_none_or(|cost| cost.value == 0.0);
        let without = kinds.iter().filter(|kind| kind.iter().all(is_free));
        let name = |o: &Operation| match self.costs.get(o) {
            Some(cost) => format!("costs.{} of more than 0 (found {cost})", o.name()),
            None => format!("costs.{}", o.name()),
        };
        let names: Vec<_> =
            without.map(|kind| kind.iter().map(name).collect::<Vec<_>>().join(" or ")).collect();
        self.need(names.is_empty().then_some(&()), &names.join(", ")).copied()
    }

    /// The machine with MPI messages between its ranks: `mpi` becomes its network.
    ///
    /// # Errors
    /// [`MachineError::Missing`] if the description does not have it.
    pub fn over_mpi(self) -> Result<Self, MachineError> {
        self.need(self.mpi.as_ref(), "mpi")?;
        Ok(Self { network: self.mpi.clone(), ..self })
    }

    /// Whether messages between ranks go over MPI: true for the result of [`Machine::over_mpi`].
    pub fn is_over_mpi(&self) -> bool {
        self.mpi.is_some() && self.network == self.mpi
    }

    /// The description as TOML.
    ///
    /// # Errors
    /// An error of the serializer.
    pub fn to_toml(&self) -> Result<String, toml::ser::Error> {
        toml::to_string(self)
    }
}

/// Reads a description; `file` names it in messages.
///
/// # Errors
/// [`MachineError::Text`] with line and column.
pub fn parse(file: &str, text: &str) -> Result<Machine, MachineError> {
    let machine: Machine = toml::from_str(text).map_err(|e| MachineError::of_toml(file, text, &e))?;
    check(&machine).map_err(|wrong| wrong.in_file(file, text))?;
    Ok(machine)
}

/// A machine by its built-in name, or from a file.
///
/// # Errors
/// [`MachineError`].
pub fn load(name_or_file: &str) -> Result<Machine, MachineError> {
    if let Some(machine) = builtin(name_or_file) {
        return machine;
    }
    let path = Path::new(name_or_file);
    if !path.exists() {
        return Err(MachineError::Unknown { name: name_or_file.into(), known: NAMES.join(", ") });
    }
    let bytes = fs::read(path).map_err(|source| MachineError::Io { path: path.into(), source })?;
    match std::str::from_utf8(&bytes) {
        Ok(text) => parse(name_or_file, text),
        Err(error) => Err(MachineError::of_bytes(name_or_file, &bytes[..error.valid_up_to()])),
    }
}
