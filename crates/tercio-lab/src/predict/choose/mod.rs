//! Chooses how ranks share a frame: `--organisation auto`.
//!
//! All [candidates] are predicted from what is known before anything is drawn: which tiles some of the clusters may reach
//! ([`tercio_raster::survey`]), the costs of work of the laboratory's machine ([`rates`]), and the [cost of messages](network),
//! measured between processes. A frame is five terms, each a formula over ranks and tiles, not a simulation of messages: choosing
//! among a thousand ranks takes some dozens of milliseconds.
//!
//! | module | what |
//! |---|---|
//! | [`candidates`] | what is compared |
//! | [`rates`] | seconds of work |
//! | [`network`] | seconds of messages |
//! | [`tiles`] | what groups of ranks have in which tiles |
//! | [`frame`] | the frame of a candidate |
//! | [`compose`] | of which: compositing |
//! | [`terms`] | stages on processors and ports |
//! | [`together`] | all ranks of a job choose the same |

pub mod candidates;
pub mod compose;
pub mod frame;
pub mod network;
pub mod rates;
pub mod terms;
pub mod tiles;
pub mod together;

use std::time::Instant;

use serde::Serialize;
use tercio_parallel::organisation::tile_edge;
use tercio_parallel::{Composition, Division, Organisation, Sharing};
use tercio_raster::context::FrameContext;
use tercio_raster::survey::Effort;
use tercio_raster::{Part, Settings, TileSet};
use tercio_scene::Instance;

use super::PredictError;
use super::ranks::Picture;
use crate::machines::{self, Machine, MachineError};
use candidates::{Limits, MANY};
use frame::{Divided, Grouped};
use network::Network;
use rates::Rates;
use terms::{Stage, Sums, Terms};
use tiles::Tiles;

/// The machine of the laboratory whose costs are used.
pub const MACHINE: &str = "two-core-2026";

/// How much of a scene is looked at for each size of tiles, for up to [`MANY`] ranks, and for more.
const EFFORT: Effort = Effort { clusters: 1024, visits: 1 << 13 };
const EFFORT_OF_MANY: Effort = Effort { clusters: 4096, visits: 1 << 15 };
/// Tiles are at least so large that there are no more than this, or as many as many ranks need.
const MOST_TILES: usize = 4096;

/// Ranks, and on what they run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Job {
    /// Ranks, at least 1.
    pub ranks: usize,
    /// Threads of each.
    pub threads: usize,
    /// Processors of all ranks together.
    pub processors: usize,
    /// Messages between them.
    pub network: Network,
}

/// A candidate, predicted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Predicted {
    /// How ranks share the frame.
    pub sharing: Sharing,
    /// Seconds.
    pub terms: Terms,
    /// Messages and bytes of all ranks.
    pub sent: Sums,
}

/// All candidates, and why the first was chosen.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// Ranks, and on what they run.
    pub job: Job,
    /// The fastest first; of equally fast ones that which comes first among the candidates.
    pub candidates: Vec<Predicted>,
    /// Seconds that choosing took, without measuring the network.
    pub seconds: f64,
    /// Seconds that measuring the network took.
    pub measuring: f64,
    /// How many tiles and parts of tiles were looked at.
    pub steps: u64,
}

impl Choice {
    /// How ranks are to share the frame.
    pub fn sharing(&self) -> Sharing {
        self.candidates.first().map_or(Organisation::SortMiddle.into(), |first| first.sharing)
    }
}

/// The machine whose costs are used.
///
/// # Errors
/// None for the built-in one.
pub fn machine() -> Result<Machine, MachineError> {
    machines::load(MACHINE)
}

/// Predicts all candidates. The result is a function of the arguments, except for the times that it took.
///
/// # Errors
/// [`PredictError`]: no candidate fits the limits; a picture that cannot be drawn.
pub fn choose(picture: &Picture, job: Job, limits: &Limits) -> Result<Choice, PredictError> {
    let begin = Instant::now();
    let candidates = limits.candidates(job.ranks)?;
    let translucent = picture.scene.instances.iter().any(Instance::is_translucent);
    let rates = Rates::of(&machine()?, picture.settings, translucent);
    let stage = Stage {
        rates: &rates,
        network: job.network,
        threads: job.threads.max(1) as f64,
        processors: job.processors.max(1) as f64,
    };
    let mut steps = 0;
    let mut seen = Vec::<Seen>::new();
    let mut predicted = Vec::new();
    for sharing in candidates {
        let (organisation, division) = (sharing.organisation, sharing.division);
        let edge = edge_for(picture, organisation, job.ranks);
        let number = match seen.iter().position(|seen| seen.edge == edge) {
            Some(number) => number,
            None => {
                seen.push(Seen::of(picture, edge, job.ranks, &rates, &mut steps)?);
                seen.len() - 1
            }
        };
        let divided = seen[number].divided(organisation, division, job.ranks, &stage, &mut steps);
        let (terms, sent) = divided.with(&sharing, &stage, &mut steps);
        predicted.push(Predicted { sharing, terms, sent });
    }
    predicted.sort_by(|a, b| a.terms.total().total_cmp(&b.terms.total()));
    let seconds = begin.elapsed().as_secs_f64();
    Ok(Choice { job, candidates: predicted, seconds, measuring: 0.0, steps })
}

/// Pixels along the edge of the tiles of an organisation; if there were very many, larger ones stand for them.
fn edge_for(picture: &Picture, organisation: Organisation, ranks: usize) -> u32 {
    let mut edge = tile_edge(picture.scene, picture.settings, organisation, ranks);
    let most = MOST_TILES.max(8 * ranks);
    while edge < 128 && picture.settings.tiles_of(edge) > most {
        edge *= 2;
    }
    edge
}

/// The picture in tiles of one size, and what was found out about it.
struct Seen {
    edge: u32,
    grid: tercio_raster::screen::TileGrid,
    tiles: Tiles,
    /// By the size of groups.
    parts: Vec<(usize, Vec<tiles::Part>)>,
    /// By division and the number of ranks that share the tiles.
    owners: Vec<((Division, usize), Vec<u32>)>,
    divided: Vec<((bool, usize, Division), Divided)>,
}

impl Seen {
    fn of(
        picture: &Picture,
        edge: u32,
        ranks: usize,
        rates: &Rates,
        steps: &mut u64,
    ) -> Result<Self, PredictError> {
        let settings = Settings {
            tile_size: Some(edge),
            clusters: Part::WHOLE,
            tiles: TileSet::ALL,
            ..picture.settings.clone()
        };
        let context = FrameContext::new(picture.scene, picture.camera, &settings, 1)?;
        let effort = if ranks > MANY { EFFORT_OF_MANY } else { EFFORT };
        let tiles = Tiles::of(&context, effort, ranks, rates);
        *steps += (2 * tiles.entries() + tiles.load.len()) as u64;
        Ok(Self {
            edge,
            grid: context.grid.clone(),
            tiles,
            parts: Vec::new(),
            owners: Vec::new(),
            divided: Vec::new(),
        })
    }

    /// Where the owners of the tiles are in the list of them, if so many ranks share the tiles.
    fn owners(&mut self, division: Division, ranks: usize, steps: &mut u64) -> usize {
        self.owners.iter().position(|(of, _)| *of == (division, ranks)).unwrap_or_else(|| {
            *steps += self.tiles.load.len() as u64;
            let owners = self.tiles.owners(&self.grid, division, ranks);
            self.owners.push(((division, ranks), owners));
            self.owners.len() - 1
        })
    }

    /// The picture, divided; once for all compositions.
    fn divided(
        &mut self,
        organisation: Organisation,
        division: Division,
        ranks: usize,
        stage: &Stage,
        steps: &mut u64,
    ) -> &Divided {
        let group = organisation.group(ranks);
        let key = (organisation == Organisation::SortFirst, group, division);
        if let Some(number) = self.divided.iter().position(|(of, _)| *of == key) {
            return &self.divided[number].1;
        }
        let number = self.parts.iter().position(|(of, _)| *of == group).unwrap_or_else(|| {
            *steps += (2 * self.tiles.entries() + ranks.div_ceil(group)) as u64;
            self.parts.push((group, self.tiles.parts(group, stage.rates)));
            self.parts.len() - 1
        });
        let shorter = ranks - (ranks.div_ceil(group) - 1) * group;
        let [full, last] = [group, shorter].map(|sharing| self.owners(division, sharing, steps));
        let grouped = Grouped {
            tiles: &self.tiles,
            ranks,
            group,
            parts: &self.parts[number].1,
            owners: &self.owners[full].1,
            owners_of_last: &self.owners[last].1,
        };
        let divided = grouped.divide(organisation, division, stage, steps);
        self.divided.push((key, divided));
        &self.divided[self.divided.len() - 1].1
    }
}

/// The parts of a candidate that have a meaning for this many ranks.
pub fn parts_of(sharing: &Sharing, ranks: usize) -> (Option<usize>, Option<Division>, Option<Composition>) {
    let organisation = sharing.organisation;
    let group = matches!(organisation, Organisation::SortTwice { .. }).then(|| organisation.group(ranks));
    let division = (organisation != Organisation::SortLast).then_some(sharing.division);
    let composites = matches!(organisation, Organisation::SortLast | Organisation::SortTwice { .. });
    (group, division, composites.then_some(sharing.composition))
}

#[cfg(test)]
mod tests;
