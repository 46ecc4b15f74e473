//! The stages of a machine, for its diagram.

use serde::{Deserialize, Serialize};

use super::check::{Wrong, positive, simulated};
use super::description::{Machine, is_default};
use super::kinds::{Arrangement, SortingClass, Topology};
use super::sourced::Sourced;
use crate::units::Count;

/// A stage of a machine: equal units, and what comes to them. Its source is that of the number of units.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Stage {
    /// What one of its units is called, such as `span processor`.
    pub name: String,
    /// Its units, all together.
    pub count: Sourced<Count>,
    /// How its units are arranged: `parallel` by default.
    #[serde(default, skip_serializing_if = "is_default")]
    pub arrangement: Arrangement,
    /// What travels to it from the stage before, such as `spans`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub receives: Option<String>,
    /// How that travels. By default units are connected directly: each to those that it serves, or all to all if it is sorted and they
    /// are parallel; a pipeline or a tree sorts what passes through it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub over: Option<Topology>,
    /// Whether the machine sorts what travels to this stage.
    #[serde(default, skip_serializing_if = "is_default")]
    pub sorted: bool,
}

/// The most stages: more do not fit beside each other.
const MOST_STAGES: usize = 8;

/// Stages have units, and the machine sorts between as many of them as its class says.
pub(super) fn check(m: &Machine) -> Result<(), Wrong> {
    let stages = &m.stages;
    let wrong = |nth, key, what| Err(Wrong::new("stages", key, what).in_section(nth));
    if stages.len() > MOST_STAGES {
        let what = format!("expected at most {MOST_STAGES} stages, found {}", stages.len());
        return wrong(MOST_STAGES, "name", what);
    }
    for (nth, stage) in stages.iter().enumerate() {
        if stage.name.trim().is_empty() {
            return wrong(nth, "name", "expected what one of its units is called, found nothing".into());
        }
        let count = Some(&stage.count);
        positive("stages", "count", count).map_err(|w| w.in_section(nth))?;
        simulated("stages", "count", count).map_err(|w| w.in_section(nth))?;
        if stage.sorted && stage.receives.is_none() {
            return wrong(nth, "sorted", "expected what is sorted, stages.receives, found none".into());
        }
    }
    let class = m.sorting.class;
    let sorted = stages.iter().filter(|s| s.sorted).count();
    let expected = match class {
        _ if stages.is_empty() => return Ok(()),
        SortingClass::None => 0..=0,
        SortingClass::SortFirst | SortingClass::SortMiddle | SortingClass::SortLast => 1..=1,
        SortingClass::SortTwice => 2..=2,
        SortingClass::Hybrid => 2..=MOST_STAGES,
    };
    if expected.contains(&sorted) {
        return Ok(());
    }
    let (least, name) = (expected.start(), class.name());
    let what = format!("expected true in {least} stages, because sorting.class is {name}; found {sorted}");
    wrong(stages.iter().position(|s| s.sorted).unwrap_or(0), "sorted", what)
}
