//! Frames of ranks, predicted.
//!
//! There are two models. What the renderer's ranks do, sort-first and sort-last with direct send, is counted rank by
//! rank, charged and played through; `tercio lab validate --ranks` compares this model with the renderer. Everything
//! else, sort-middle, sort-twice, other networks, a million ranks, comes from the simulator of the sorting classes, which
//! knows polygons and links, but not what the renderer does. A prediction says which of them it is from.
//!
//! | module | what |
//! |---|---|
//! | [`drawing`] | what each of the renderer's ranks draws |
//! | [`traffic`] | what they send each other, by what each of them shows |
//! | [`exchange`] | what they do beside drawing, and what it costs |
//! | [`schedule`] | ranks on processors, messages on wires |
//! | [`renderer`] | a frame of it |
//! | [`simulated`] | a frame by the simulator |
//! | [`measure`] | the real ranks' times |
//! | [`calibrate`] | the costs of this machine |

pub mod calibrate;
pub mod drawing;
pub mod exchange;
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
use super::counts::Counters;
use crate::machines::{Machine, Topology};
use crate::simulators::sorting::{Assignment, Organisation};
use crate::workloads::BoxScene;
use exchange::ExchangeCosts;
use renderer::{RanksFrame, RanksWork};
use simulated::SimulatedFrame;

/// Most ranks that the renderer draws with.
pub const MOST_RANKS: usize = 256;
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
    /// Where work changes hands.
    pub organisation: Organisation,
    /// Ranks.
    pub ranks: usize,
    /// Pixels along the edge of a region; `None` takes the largest of which there is one a rank.
    pub region: Option<u32>,
    /// Who gets which region.
    pub assignment: Assignment,
    /// Another shape of the network than the machine's.
    pub topology: Option<Topology>,
}

/// Why a plan is left to the simulator.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Simulated {
    /// Somebody wants it so.
    #[error("as asked for")]
    Asked,
    /// The renderer has no such organisation.
    #[error("the renderer sorts first or last")]
    Organisation,
    /// Regions go to ranks in turn.
    #[error("the renderer deals regions out in turn")]
    Assignment,
    /// Regions are the renderer's tiles.
    #[error("the renderer's regions are tiles of 8, 16, 32, 64 or 128 pixels")]
    Region,
    /// More than [`MOST_RANKS`].
    #[error("the renderer has at most {MOST_RANKS} ranks")]
    Ranks,
    /// Another network than the machine's.
    #[error("only the machine's own network carries the renderer's messages")]
    Network,
    /// The description does not charge for what ranks do.
    #[error("the machine's description has no costs of the renderer's ranks")]
    Costs,
}

impl Plan {
    /// How the renderer does this on a machine, or why only the simulator knows it.
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
        if self.ranks > MOST_RANKS {
            return Err(Simulated::Ranks);
        }
        if self.topology.is_some() {
            return Err(Simulated::Network);
        }
        if !ExchangeCosts::are_known(machine) {
            return Err(Simulated::Costs);
        }
        Ok(organisation)
    }
}

/// What is drawn.
#[derive(Clone, Copy, Debug)]
pub struct Picture<'a> {
    /// Of what.
    pub scene: &'a Scene,
    /// From where.
    pub camera: &'a Camera,
    /// How, all of it.
    pub settings: &'a Settings,
}

/// Predicts a frame that the renderer's ranks would draw; `None` with the reason where that is left to the simulator.
/// Ranks that share a memory share the machine's processors, too.
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
    let costs = ExchangeCosts::of(machine)?;
    let work = RanksWork::count(picture.scene, picture.camera, &settings, (plan.ranks, organisation))?;
    let processors = machine.processors.count.whole() as usize;
    Ok(Ok(renderer::predict(machine, &costs, &work, processors)?))
}

/// Simulates a frame.
///
/// # Errors
/// A machine without a network or without the bytes of what travels.
pub fn simulate(
    machine: &Machine,
    counters: &Counters,
    boxes: &BoxScene,
    size: (u32, u32),
    plan: &Plan,
) -> Result<SimulatedFrame, PredictError> {
    Ok(simulated::predict(machine, counters, boxes, size, *plan)?)
}
