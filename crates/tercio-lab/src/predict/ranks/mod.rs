//! Predicts frames of ranks.
//!
//! There are two models. The work of the renderer's ranks, sort-first and sort-last with direct send, is counted rank
//! by rank, charged and scheduled; `tercio lab validate --ranks` compares this model with the renderer. Of more than
//! [`MOST_RANKS`] ranks, each term of the frame is continued from what it is with fewer. Everything else, sort-middle,
//! sort-twice and other networks, comes from the simulator of the sorting classes, which has polygons and links, but not
//! the work of the renderer. A prediction says which of them it is from.
//!
//! | module | what |
//! |---|---|
//! | [`drawing`] | what each of the renderer's ranks draws |
//! | [`traffic`] | what they send each other, from the pixels that each of them shows |
//! | [`exchange`] | their work besides drawing, and its costs |
//! | [`schedule`] | simulates ranks on processors and messages on the network |
//! | [`renderer`] | a frame of the renderer's ranks |
//! | [`extrapolated`] | the frame of more ranks than are counted |
//! | [`simulated`] | a frame by the simulator |
//! | [`measure`] | the real ranks' times |
//! | [`calibrate`] | the costs of this machine |

pub mod calibrate;
pub mod drawing;
pub mod exchange;
pub mod extrapolated;
pub mod measure;
pub mod renderer;
pub mod schedule;
pub mod simulated;
pub mod traffic;

use serde::Serialize;
use tercio_parallel::{Organisation as RendererOrganisation, ParallelError};
use tercio_raster::Settings;
use tercio_scene::{Camera, Scene};

use super::PredictError;
use super::counts::{Counters, count};
use super::frame::{FrameTime, need_costs};
use crate::machines::{Machine, MachineError, Topology};
use crate::simulators::sorting::{Assignment, Organisation};
use crate::workloads::BoxScene;
use exchange::ExchangeCosts;
pub use extrapolated::extrapolate;
use renderer::{RanksFrame, RanksWork};
use simulated::SimulatedFrame;

/// The largest number of ranks whose work is counted rank by rank, as the renderer divides it.
pub const MOST_RANKS: usize = 1024;
/// Edges of the renderer's tiles, which are the regions of its ranks.
pub const TILE_EDGES: [u32; 5] = [8, 16, 32, 64, 128];

/// Why ranks could not be compared.
#[derive(Debug, thiserror::Error)]
pub enum RanksError {
    /// There is no prediction.
    #[error(transparent)]
    Predict(#[from] PredictError),
    /// The ranks could not draw.
    #[error(transparent)]
    Parallel(#[from] ParallelError),
}

/// How ranks share a frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Plan {
    /// Where work is redistributed.
    pub organisation: Organisation,
    /// Ranks.
    pub ranks: usize,
    /// Threads of each; the simulator has one.
    pub threads: usize,
    /// Pixels along the edge of a region; `None` is the renderer's own choice, or the largest that gives every rank a region of a
    /// simulated machine.
    pub region: Option<u32>,
    /// Who gets which region.
    pub assignment: Assignment,
    /// A shape of the network other than the machine's.
    pub topology: Option<Topology>,
}

/// Why only the simulator can predict a plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Simulated {
    /// It was requested.
    #[error("as requested")]
    Asked,
    /// Its messages are not counted.
    #[error("of the renderer's organisations, only the messages of sort-first and sort-last are counted")]
    Organisation,
    /// Tiles are scattered.
    #[error("runs of as many tiles each are not predicted: the renderer divides tiles by their work")]
    Assignment,
    /// Regions are the renderer's tiles.
    #[error("the renderer's regions are tiles of 8, 16, 32, 64 or 128 pixels")]
    Region,
    /// More than [`MOST_RANKS`].
    #[error("the work of at most {MOST_RANKS} ranks is counted rank by rank")]
    Ranks,
    /// Another network than the machine's.
    #[error("only the machine's own network carries the renderer's messages")]
    Network,
    /// The description has no costs of ranks.
    #[error("the machine's description has no costs of the renderer's ranks")]
    Costs,
}

impl Plan {
    /// Checks that each thread of each rank has a processor of its own.
    ///
    /// # Errors
    /// [`MachineError::TooMany`]: the machine may not have so many processors.
    pub fn need_processors(&self, machine: &Machine) -> Result<(), MachineError> {
        machine.may_have(self.ranks * self.threads.max(1))
    }

    /// The renderer's organisation for this plan on a machine, or why only the simulator supports it.
    ///
    /// # Errors
    /// The first reason.
    pub fn by_renderer(&self, machine: &Machine) -> Result<RendererOrganisation, Simulated> {
        let organisation = match self.organisation {
            Organisation::SortFirst => RendererOrganisation::SortFirst,
            Organisation::SortLast => RendererOrganisation::SortLast,
            Organisation::SortMiddle | Organisation::SortTwice(_) => return Err(Simulated::Organisation),
        };
        if self.assignment != Assignment::Interleaved {
            return Err(Simulated::Assignment);
        }
        if self.region.is_some_and(|edge| !TILE_EDGES.contains(&edge)) {
            return Err(Simulated::Region);
        }
        if self.topology.is_some() {
            return Err(Simulated::Network);
        }
        if !ExchangeCosts::are_known(machine) {
            return Err(Simulated::Costs);
        }
        // Nothing but their number: it can be extrapolated.
        if self.ranks > MOST_RANKS {
            return Err(Simulated::Ranks);
        }
        Ok(organisation)
    }
}

/// The picture to predict.
#[derive(Clone, Copy, Debug)]
pub struct Picture<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The camera.
    pub camera: &'a Camera,
    /// The settings of the whole frame.
    pub settings: &'a Settings,
}

/// Predicts a frame of one process of some threads, with its counts.
///
/// # Errors
/// [`PredictError`]: costs are missing, no memory is shared by so many processors, or the picture cannot be drawn.
pub fn on_threads(
    machine: &Machine,
    picture: &Picture,
    region: Option<u32>,
    threads: usize,
) -> Result<FrameTime, PredictError> {
    need_costs(machine)?;
    machine.may_share_memory(threads)?;
    let settings = Settings { tile_size: region.or(picture.settings.tile_size), ..picture.settings.clone() };
    let counted = count(picture.scene, picture.camera, &settings, threads)?;
    Ok(FrameTime::on_threads(machine, &counted, threads))
}

/// Predicts a frame of the renderer's ranks; `None` with the reason if only the simulator supports it. Of a machine without nodes
/// there may be more ranks than processors, which they then share: [`Plan::need_processors`] refuses that.
///
/// # Errors
/// [`PredictError`].
pub fn predict(
    machine: &Machine,
    picture: &Picture,
    plan: &Plan,
) -> Result<Result<RanksFrame, Simulated>, PredictError> {
    let organisation = match plan.by_renderer(machine) {
        Ok(organisation) => organisation,
        Err(reason) => return Ok(Err(reason)),
    };
    let settings =
        Settings { tile_size: plan.region.or(picture.settings.tile_size), ..picture.settings.clone() };
    need_costs(machine)?;
    if machine.processors.per_node.is_some() {
        machine.may_have(plan.ranks * plan.threads.max(1))?;
    }
    machine.may_share_memory(plan.threads)?;
    let costs = ExchangeCosts::of(machine)?;
    // Scattered by the work in the tiles, as ranks do without options.
    let how = (plan.ranks, organisation.into());
    let work = RanksWork::with_threads(picture.scene, picture.camera, &settings, how, plan.threads.max(1))?;
    let processors = machine.processors_for(plan.ranks * plan.threads.max(1));
    Ok(Ok(renderer::predict(machine, &costs, &work, processors)?))
}

/// Simulates a frame.
///
/// # Errors
/// As [`simulated::predict`].
pub fn simulate(
    machine: &Machine,
    counters: &Counters,
    boxes: &BoxScene,
    size: (u32, u32),
    plan: &Plan,
) -> Result<SimulatedFrame, PredictError> {
    simulated::predict(machine, counters, boxes, size, *plan)
}
