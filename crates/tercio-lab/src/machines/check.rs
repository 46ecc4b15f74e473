//! Checks of a description beyond units: numbers that must not be 0, or that depend on others.

use super::builtin::NAMES;
use super::description::Machine;
use super::error::MachineError;
use super::sourced::{Cost, Sourced};
use super::stages;
use crate::units::Count;

/// An invalid number, with its section and key.
pub(super) struct Wrong {
    section: &'static str,
    /// Which of the sections of this name, from 0.
    nth: usize,
    key: String,
    what: String,
}

impl Wrong {
    pub fn new(section: &'static str, key: &str, what: String) -> Self {
        Self { section, nth: 0, key: key.into(), what }
    }

    /// The same in another section of this name.
    pub fn in_section(self, nth: usize) -> Self {
        Self { nth, ..self }
    }

    /// The message with the line of the key, or of the section if the key is not on a line of its own.
    pub fn in_file(self, file: &str, text: &str) -> MachineError {
        let (line, column) = self.place(text);
        let what = format!("{}.{}: {}", self.section, self.key, self.what);
        MachineError::Text { file: file.into(), line, column, what }
    }

    fn place(&self, text: &str) -> (usize, usize) {
        let (mut inside, mut section, mut sections) = (false, 1, 0);
        for (number, line) in text.lines().enumerate() {
            let trimmed = line.trim_start();
            if let Some(header) = trimmed.strip_prefix('[') {
                let name = header.trim_start_matches('[').split(']').next().unwrap_or_default();
                sections += usize::from(name == self.section);
                // A number may have a table of its own, as `lab machines` writes them.
                let of_section = name.strip_prefix(self.section);
                let is_it = of_section.and_then(|rest| rest.strip_prefix('.')) == Some(&self.key);
                if is_it && sections.max(1) == self.nth + 1 {
                    return (number + 1, line.len() - trimmed.len() + 1);
                }
                inside = name == self.section && sections == self.nth + 1;
                section = if inside { number + 1 } else { section };
            } else if inside && trimmed.split('=').next().is_some_and(|k| k.trim() == self.key) {
                return (number + 1, line.len() - trimmed.len() + 1);
            }
        }
        (section, 1)
    }
}

pub(super) fn positive<Q>(
    section: &'static str,
    key: &str,
    number: Option<&Sourced<Q>>,
) -> Result<(), Wrong> {
    match number {
        Some(n) if n.value <= 0.0 => {
            Err(Wrong::new(section, key, format!("expected more than 0, found {}", n.text)))
        }
        _ => Ok(()),
    }
}

/// The largest number of anything that is counted, processors above all: what the simulators are made for.
pub const MOST: u64 = 1 << 20;

/// The most bytes of one thing that is sent or stored.
const MOST_BYTES: f64 = (1u64 << 30) as f64;
/// The most cycles of an operation: sums over a frame are counted in 64 bits.
const MOST_CYCLES: f64 = 1e6;
/// The most cycles of the engines' stages, which are simulated cycle by cycle.
const MOST_ENGINE_CYCLES: f64 = 1e4;
/// The most seconds of an operation, a message, a hop, or waking up.
const MOST_SECONDS: f64 = 1e3;
/// The least and the most cycles a second of a clock.
const CLOCKS: [f64; 2] = [1.0, 1e12];
/// The least and the most bytes a second of a link or a memory.
const BANDWIDTHS: [f64; 2] = [1.0, 1e15];
/// The most bytes of a memory or cache.
const MOST_MEMORY: f64 = (1u64 << 50) as f64;
/// The most heaps: each has a list for every tile.
const MOST_HEAPS: f64 = 64.0;
/// The most tile engines: if they composite, each looks at every tile.
const MOST_ENGINES: f64 = 1024.0;
/// The largest share by which a number may be off.
const MOST_OFF: f64 = 1e3;

fn at_most<Q>(
    section: &'static str,
    key: &str,
    number: Option<&Sourced<Q>>,
    most: f64,
    unit: &str,
) -> Result<(), Wrong> {
    match number {
        Some(n) if n.value > most => {
            Err(Wrong::new(section, key, format!("expected at most {most}{unit}, found {}", n.text)))
        }
        _ => Ok(()),
    }
}

/// A number that is neither so small nor so large that times which are divided by it say nothing.
fn within<Q>(
    section: &'static str,
    key: &str,
    number: Option<&Sourced<Q>>,
    [least, most]: [f64; 2],
    unit: &str,
) -> Result<(), Wrong> {
    match number {
        Some(n) if n.value < least => {
            Err(Wrong::new(section, key, format!("expected at least {least}{unit}, found {}", n.text)))
        }
        _ => at_most(section, key, number, most, unit),
    }
}

/// Numbers that times are made of: clock, bandwidths, times of messages, and caches.
fn speeds(m: &Machine) -> Result<(), Wrong> {
    let p = &m.processors;
    within("processors", "clock", p.clock.as_ref(), CLOCKS, " Hz")?;
    within("processors", "memory-bandwidth", p.memory_bandwidth.as_ref(), BANDWIDTHS, " B/s")?;
    at_most("processors", "wake-up", p.wake_up.as_ref(), MOST_SECONDS, " s")?;
    at_most("processors", "nap", p.nap.as_ref(), MOST_SECONDS, " s")?;
    for (key, bytes) in [
        ("memory", &p.memory),
        ("own-cache", &p.own_cache),
        ("shared-cache", &p.shared_cache),
        ("exchange-cache", &p.exchange_cache),
    ] {
        at_most("processors", key, bytes.as_ref(), MOST_MEMORY, " B")?;
    }
    for (section, network) in [("network", &m.network), ("node", &m.node), ("mpi", &m.mpi)] {
        let Some(network) = network else { continue };
        within(section, "bandwidth", Some(&network.bandwidth), BANDWIDTHS, " B/s")?;
        at_most(section, "hop", Some(&network.hop), MOST_SECONDS, " s")?;
        at_most(section, "message", Some(&network.message), MOST_SECONDS, " s")?;
    }
    let Some(transfer) = &m.transfer else { return Ok(()) };
    within("transfer", "bandwidth", Some(&transfer.bandwidth), BANDWIDTHS, " B/s")?;
    at_most("transfer", "overhead", Some(&transfer.overhead), MOST_SECONDS, " s")
}

/// Numbers whose sums the simulators count in 64 bits, or cycle by cycle.
fn sizes(m: &Machine) -> Result<(), Wrong> {
    for (kind, bytes) in &m.bytes {
        at_most("bytes", kind.name(), Some(bytes), MOST_BYTES, " B")?;
    }
    for (operation, cost) in &m.costs {
        match cost.cost() {
            Cost::Cycles(_) => at_most("costs", operation.name(), Some(cost), MOST_CYCLES, " cycles")?,
            Cost::Time(_) => at_most("costs", operation.name(), Some(cost), MOST_SECONDS, " s")?,
        }
    }
    if let Some(heap) = &m.heap {
        for (key, bytes) in [("node", &heap.node), ("buffer", &heap.buffer), ("header", &heap.header)] {
            at_most("heap", key, Some(bytes), MOST_BYTES, " B")?;
        }
    }
    if let Some(sdram) = &m.sdram {
        at_most("sdram", "page", Some(&sdram.page), MOST_BYTES, " B")?;
        at_most("sdram", "width", Some(&sdram.width), MOST_BYTES, " B")?;
        at_most("sdram", "page-miss", Some(&sdram.page_miss), MOST_CYCLES, " cycles")?;
    }
    at_most("transfer", "block", m.transfer.as_ref().map(|t| &t.block), MOST_BYTES, " B")?;
    let engine = m.tile_engine.as_ref().map(|e| &e.set_up_triangle);
    at_most("tile-engine", "set-up-triangle", engine, MOST_ENGINE_CYCLES, " cycles")
}

/// Finds the first invalid number.
pub(super) fn check(m: &Machine) -> Result<(), Wrong> {
    counts(m)?;
    sizes(m)?;
    speeds(m)?;
    let p = &m.processors;
    positive("processors", "count", Some(&p.count))?;
    positive("processors", "per-node", p.per_node.as_ref())?;
    if let Some(s) = p.serial.as_ref().filter(|s| s.value > 1.0) {
        return Err(Wrong::new("processors", "serial", format!("expected at most 100 %, found {s}")));
    }
    uncertainty(m)?;
    stages::check(m)?;
    if let Some(screen) = &m.screen {
        positive("screen", "width", Some(&screen.width))?;
        positive("screen", "height", Some(&screen.height))?;
    }
    positive("transfer", "block", m.transfer.as_ref().map(|t| &t.block))?;
    positive("sdram", "page", m.sdram.as_ref().map(|s| &s.page))?;
    positive("sdram", "banks", m.sdram.as_ref().map(|s| &s.banks))?;
    positive("sdram", "width", m.sdram.as_ref().map(|s| &s.width))?;
    heap(m)?;
    tile_engine(m)?;
    let cycles = m.costs.iter().find(|c| matches!(c.1.cost(), Cost::Cycles(_)));
    match cycles {
        Some((o, c)) if p.clock.is_none() => {
            Err(Wrong::new("costs", o.name(), format!("\"{c}\" needs processors.clock, which is missing")))
        }
        _ => Ok(()),
    }
}

pub(super) fn simulated(
    section: &'static str,
    key: &str,
    number: Option<&Sourced<Count>>,
) -> Result<(), Wrong> {
    at_most(section, key, number, MOST as f64, "")
}

/// Numbers that simulators reserve memory by, and nodes.
fn counts(m: &Machine) -> Result<(), Wrong> {
    let p = &m.processors;
    simulated("processors", "count", Some(&p.count))?;
    simulated("processors", "at-most", p.at_most.as_ref())?;
    if let Some(most) = p.at_most.as_ref().filter(|most| most.value < p.count.value) {
        let what = format!("expected at least processors.count = {}, found {most}", p.count);
        return Err(Wrong::new("processors", "at-most", what));
    }
    simulated("screen", "width", m.screen.as_ref().map(|s| &s.width))?;
    simulated("screen", "height", m.screen.as_ref().map(|s| &s.height))?;
    at_most("heap", "heaps", m.heap.as_ref().map(|h| &h.heaps), MOST_HEAPS, "")?;
    simulated("sdram", "banks", m.sdram.as_ref().map(|s| &s.banks))?;
    if let Some(e) = &m.tile_engine {
        at_most("tile-engine", "engines", Some(&e.engines), MOST_ENGINES, "")?;
        let counts =
            [("fifo", &e.fifo), ("fifo-after-broadcast", &e.fifo_after_broadcast), ("output", &e.output)];
        counts.iter().try_for_each(|(key, count)| simulated("tile-engine", key, Some(count)))?;
    }
    match (&p.per_node, &m.node) {
        (Some(_), None) => Err(Wrong::new(
            "processors",
            "per-node",
            "expected a section node, the network inside a node, found none".into(),
        )),
        (None, Some(_)) => Err(Wrong::new(
            "node",
            "bandwidth",
            "expected processors.per-node, the processors of a node, found none".into(),
        )),
        _ => Ok(()),
    }
}

/// Where costs are borrowed, and the serial share.
fn uncertainty(m: &Machine) -> Result<(), Wrong> {
    let Some(of) = &m.uncertainty else { return Ok(()) };
    if let Some(name) = of.costs_of.as_ref().filter(|name| !NAMES.contains(&name.as_str())) {
        let what = format!("expected the name of a built-in machine, found {name}");
        return Err(Wrong::new("uncertainty", "costs-of", what));
    }
    let off = [
        ("residual", &of.residual),
        ("costs", &of.costs),
        ("memory-bandwidth", &of.memory_bandwidth),
        ("network-bandwidth", &of.network_bandwidth),
        ("message", &of.message),
        ("wake-up", &of.wake_up),
    ];
    off.iter().try_for_each(|(key, ratio)| at_most("uncertainty", key, ratio.as_ref(), MOST_OFF, ""))?;
    let least = m.processors.serial.as_ref().map_or(0.0, |s| s.value);
    match &of.serial {
        Some(s) if s.value > 1.0 || s.value < least => {
            let what = format!(
                "expected at least processors.serial, {} %, and at most 100 %, found {s}",
                100.0 * least
            );
            Err(Wrong::new("uncertainty", "serial", what))
        }
        _ => Ok(()),
    }
}

fn heap(m: &Machine) -> Result<(), Wrong> {
    let Some(h) = &m.heap else { return Ok(()) };
    positive("heap", "node", Some(&h.node))?;
    positive("heap", "heaps", Some(&h.heaps))?;
    if h.node.value + h.header.value > h.buffer.value {
        return Err(Wrong::new(
            "heap",
            "buffer",
            format!("expected room for header and node, found {}", h.buffer),
        ));
    }
    Ok(())
}

fn tile_engine(m: &Machine) -> Result<(), Wrong> {
    let Some(e) = &m.tile_engine else { return Ok(()) };
    let numbers = [
        ("tile", &e.tile),
        ("engines", &e.engines),
        ("fifo", &e.fifo),
        ("fifo-after-broadcast", &e.fifo_after_broadcast),
        ("output", &e.output),
    ];
    for (key, number) in numbers {
        positive("tile-engine", key, Some(number))?;
    }
    positive("tile-engine", "set-up-triangle", Some(&e.set_up_triangle))?;
    if !e.tile.whole().is_power_of_two() || e.tile.whole() > 1024 {
        let what = format!("expected a power of two, at most 1024, found {}", e.tile);
        return Err(Wrong::new("tile-engine", "tile", what));
    }
    if ![1, 2].contains(&e.interleave.whole()) {
        return Err(Wrong::new(
            "tile-engine",
            "interleave",
            format!("expected 1 or 2, found {}", e.interleave),
        ));
    }
    Ok(())
}
