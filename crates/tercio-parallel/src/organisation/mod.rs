//! Who draws what, and where work is redistributed.
//!
//! A frame of ranks has the same steps in every organisation ([`frame`]):
//!
//! | step | sort-first | sort-middle | sort-last | sort-twice |
//! |---|---|---|---|---|
//! | front end | all clusters, own tiles | own clusters | own clusters ([divided](divided) by visible work) | the same |
//! | [redistribute](redistribute) bins | – | to the owners of tiles | – | to the owners of tiles in the rank's group |
//! | [tell](depth_bounds) how near one may draw (with several samples) | – | – | to the owners of tiles | to the owners of tiles |
//! | draw | own tiles | own tiles | all tiles, [those first](front_first) in which the rank is in front | the same in own tiles in the group |
//! | [composite](crate::composite) | – | – | between ranks | between groups |
//! | [collect](collect) pixels | on rank 0 | on rank 0 | on rank 0 | on rank 0 |
//!
//! Each message of a frame says what it is ([envelope]).
//!
//! So sort-middle and sort-last are sort-twice with groups of all ranks, and of one.
//!
//! If models are in [parts], "own clusters" are those that a rank holds. Where ranks of a group share the picture,
//! each sorts its own clusters into all tiles, and [sends](clusters) those of other owners' tiles that these do not [have](held);
//! then it goes on as in sort-first, with the clusters of its own tiles.

mod clusters;
mod collect;
mod depth_bounds;
mod divided;
pub mod envelope;
mod frame;
mod front_first;
mod held;
pub mod redistribute;
mod rounds;

use std::fmt;
use std::ops::Range;

use serde::{Serialize, Serializer};
use tercio_raster::binning::Sorted;
use tercio_raster::{Frame, RenderError, Renderer, Settings};
use tercio_scene::{Camera, Instance, Scene};

use crate::ParallelError;
use crate::agreement::frame_digest;
use crate::comm::{Communicator, Kind};
use crate::composite::{Composition, Encoding};
use crate::division::{ClusterDivision, Division};
use crate::parts;
use crate::report::{RankReport, RankStages};
use crate::trace::{Span, Step, Timeline, timed};
use divided::LastFrame;
use envelope::FrameComm;
use held::Held;

/// Where work is redistributed between ranks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Organisation {
    /// Before the front end: every rank draws the clusters that reach its tiles, and only there.
    SortFirst,
    /// Between front end and back end: every rank sorts a share of the clusters into tiles, and sends what is in them to the
    /// tiles' owners, which draw them.
    SortMiddle,
    /// After the back end: every rank draws a share of the clusters, and the pictures are composited.
    SortLast,
    /// Both: sort-middle in groups of this many ranks (the last group may be smaller), sort-last between the groups.
    SortTwice {
        /// Ranks of a group.
        group: usize,
    },
}

impl Organisation {
    /// The name on the command line and in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::SortFirst => "sort-first",
            Self::SortMiddle => "sort-middle",
            Self::SortLast => "sort-last",
            Self::SortTwice { .. } => "sort-twice",
        }
    }

    /// The number of ranks that share the tiles of the picture, at least 1: all ranks but in sort-last and sort-twice.
    pub fn group(self, ranks: usize) -> usize {
        match self {
            Self::SortFirst | Self::SortMiddle => ranks,
            Self::SortLast => 1,
            Self::SortTwice { group } => group.clamp(1, ranks.max(1)),
        }
    }

    /// Are pictures of several of this many ranks composited?
    pub fn composites(self, ranks: usize) -> bool {
        self.group(ranks) < ranks
    }
}

impl fmt::Display for Organisation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())?;
        match self {
            Self::SortTwice { group } => write!(f, " in groups of {group}"),
            _ => Ok(()),
        }
    }
}

impl Serialize for Organisation {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

/// How ranks share a frame. The picture does not depend on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sharing {
    /// Where work is redistributed.
    pub organisation: Organisation,
    /// How tiles are divided among the ranks that draw different ones; without meaning for sort-last.
    pub division: Division,
    /// How pixels of the same tiles are composited; without meaning for sort-first and sort-middle.
    pub composition: Composition,
    /// Which pixels are sent then, and whether ranks tell each other what they hide.
    pub encoding: Encoding,
    /// How clusters are divided among the ranks that composite; without meaning for sort-first and sort-middle, and for models in parts.
    pub clusters: ClusterDivision,
}

impl From<Organisation> for Sharing {
    /// The organisation with the usual divisions, composition and encoding.
    fn from(organisation: Organisation) -> Self {
        Self {
            organisation,
            division: Division::default(),
            composition: Composition::default(),
            encoding: Encoding::default(),
            clusters: ClusterDivision::default(),
        }
    }
}

/// The ranks, consecutive ones, that share the tiles of the picture with a rank.
pub fn group_of(organisation: Organisation, ranks: usize, rank: usize) -> Range<usize> {
    let size = organisation.group(ranks);
    let first = rank / size * size;
    first..(first + size).min(ranks)
}

/// A rank's renderer, kept from frame to frame. It draws in the rayon pool in which it is called; calls from one of its threads draw
/// without waking another.
#[derive(Debug, Default)]
pub struct Rank {
    renderer: Renderer,
    /// Memory for the keys of a picture whose settings do not request keys.
    keys: Vec<u64>,
    /// Likewise of ties.
    ties: Vec<u32>,
    /// What it draws from.
    sorted: Sorted,
    last_frame: LastFrame,
    /// Of models in parts.
    held: Held,
    /// The frames so far, modulo 2^32: all ranks draw the same ones.
    frames: u32,
    omits_partners: bool,
    /// What this rank did when, if that is recorded.
    timeline: Option<Timeline>,
}

/// The input of a frame, the same on all ranks.
#[derive(Clone, Copy, Debug)]
pub struct Task<'a> {
    /// How ranks share it.
    pub sharing: Sharing,
    /// The whole scene. Its meshes are in shared memory here; a rank reads only the parts of them that it draws. Or a scene whose
    /// meshes are this rank's [parts] of models.
    pub scene: &'a Scene,
    /// The camera.
    pub camera: &'a Camera,
    /// The settings. The organisation chooses the parts: those in the settings are ignored. Bands, and frames that keep
    /// samples, are refused.
    pub settings: &'a Settings,
}

impl Rank {
    /// A rank that has not drawn anything yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Whether [`draw_frame`](crate::between_processes::draw_frame) tells rank 0 the counts of messages by partner, as it does
    /// at first. If many frames are drawn with many ranks, these are much to send for each.
    pub fn tell_partners(&mut self, tells: bool) {
        self.omits_partners = !tells;
    }

    /// From now on it is recorded what this rank does when.
    pub fn record(&mut self) {
        self.timeline.get_or_insert_default();
    }

    /// Records something else that this rank did, of a frame or, with number 0, of none.
    pub fn record_step(&mut self, step: Step, frame: u32, span: Span) {
        if let Some(timeline) = &mut self.timeline {
            timeline.add(step, frame, span);
        }
    }

    /// What was recorded so far, and ends the recording.
    pub fn take_timeline(&mut self) -> Timeline {
        self.timeline.take().unwrap_or_default()
    }

    /// Runs work of a frame, and records it if that is done.
    pub(crate) fn timed<T>(&mut self, step: Step, frame: u32, work: impl FnOnce() -> T) -> T {
        timed(&mut self.timeline, step, frame, work)
    }

    /// The number of frames so far, modulo 2^32.
    pub(crate) fn frames(&self) -> u32 {
        self.frames
    }

    pub(crate) fn tells_partners(&self) -> bool {
        !self.omits_partners
    }

    /// Does this rank's part of a frame; all ranks of the communicator have to do theirs. On rank 0 `frame` is then
    /// the picture, with the bytes that one renderer gives; elsewhere it is memory for the next frame.
    ///
    /// # Errors
    /// [`ParallelError`] if this rank fails, or another one is gone.
    pub fn draw_into(
        &mut self,
        comm: &mut impl Communicator,
        task: &Task,
        frame: &mut Frame,
    ) -> Result<RankReport, ParallelError> {
        let before = comm.traffic();
        let mut report = RankReport { rank: comm.rank(), ..RankReport::default() };
        if self.timeline.is_some() {
            report.stages = RankStages::recording();
        }
        task.settings.check()?;
        refuse_parts(task.settings)?;
        let ranks = comm.size();
        self.frames = self.frames.wrapping_add(1);
        if ranks == 1 {
            self.last_frame.clear();
            if task.scene.is_in_parts() {
                parts::check::check(comm, task.scene)?;
            }
            self.draw_alone(task, frame, &mut report)?;
        } else {
            let mut framed = FrameComm::new(comm, self.frames, frame_digest(task, ranks));
            if task.scene.is_in_parts() {
                framed.begin(Kind::Parts);
                parts::check::check(&mut framed, task.scene)?;
            }
            frame::draw(self, &mut framed, task, frame, &mut report)?;
            report.partners = framed.finish();
        }
        report.traffic = comm.traffic().since(before);
        if let Some(timeline) = &mut self.timeline {
            report.stages.record(self.frames, timeline);
        }
        Ok(report)
    }

    /// Draws everything, as a renderer without ranks.
    fn draw_alone(
        &mut self,
        task: &Task,
        frame: &mut Frame,
        report: &mut RankReport,
    ) -> Result<(), ParallelError> {
        let settings = Settings {
            tile_size: Some(tile_edge(task.scene, task.settings, task.sharing.organisation, 1)),
            ..task.settings.clone()
        };
        let stage = &mut report.stages.draw;
        let draw = || self.renderer.render_into(task.scene, task.camera, &settings, frame);
        rayon::scope(|_| stage.time(draw))?;
        report.clusters = task.scene.cluster_count() as u64;
        report.frame = frame.stats.clone();
        report.pixels.visible = report.frame.backend.pixels_visible;
        Ok(())
    }
}

/// May anything in the scene not be opaque?
fn is_translucent(scene: &Scene) -> bool {
    scene.instances.iter().any(Instance::is_translucent)
}

/// Tiles for each rank, if ranks share the picture: enough to give all of them about the same work.
const TILES_PER_RANK: usize = 32;
/// Tiles do not get smaller than this for more ranks.
const SMALLEST_TILE: u32 = 32;

/// Pixels along the edge of the tiles of a frame, which are the same for every rank, however many threads it has. Unless the
/// settings choose it, it is smaller if many ranks share the picture, and for what is not opaque: memory has to hold all
/// fragments of a tile.
pub fn tile_edge(scene: &Scene, settings: &Settings, organisation: Organisation, ranks: usize) -> u32 {
    let mut edge = settings.tile_edge();
    if settings.tile_size.is_some() {
        return edge;
    }
    let sharing_tiles = organisation.group(ranks);
    while sharing_tiles > 1
        && edge > SMALLEST_TILE
        && settings.tiles_of(edge) < TILES_PER_RANK * sharing_tiles
    {
        edge /= 2;
    }
    if is_translucent(scene) { edge.min(32) } else { edge }
}

/// Ranks draw whole pictures.
fn refuse_parts(settings: &Settings) -> Result<(), RenderError> {
    let refused = |what, value: String| {
        Err(RenderError::Setting { what, range: "not set: ranks draw whole pictures".into(), value })
    };
    match &settings.band {
        Some(band) => refused("band", format!("{band:?}")),
        None if settings.unresolved => refused("unresolved", "true".into()),
        None if settings.keep_fragments => refused("keep_fragments", "true".into()),
        None => Ok(()),
    }
}
