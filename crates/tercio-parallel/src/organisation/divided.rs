//! Who draws which clusters of a frame, and owns which of its tiles.

use std::ops::Range;

use tercio_raster::context::FrameContext;
use tercio_raster::{ClusterSet, Part, Renderer};

use super::envelope::FrameComm;
use super::{Rank, Sharing, Task};
use crate::comm::collective::all_reduce_arrays;
use crate::comm::{Communicator, Group, Kind};
use crate::division::{ClusterDivision, Division, cuts::Cuts};
use crate::{ParallelError, RankReport};

/// What a rank remembers of a frame for the next one. All ranks of a group remember the same, but each its own work.
#[derive(Debug, Default)]
pub struct LastFrame {
    /// Of what it is; `None` if there is nothing to remember.
    of: Option<Divided>,
    cuts: Cuts,
    /// What this rank did in each tile.
    work: Vec<u64>,
}

/// What has to be the same in two frames, so that the cuts of one are those of the other.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Divided {
    columns: u32,
    rows: u32,
    shift: u32,
    members: Range<usize>,
}

impl LastFrame {
    /// Adds work that this rank did in tiles of the frame.
    pub fn add(&mut self, work: impl Iterator<Item = (u32, u64)>) {
        if self.of.is_some() {
            work.for_each(|(tile, work)| self.work[tile as usize] += work);
        }
    }

    /// Forgets it.
    pub fn clear(&mut self) {
        self.of = None;
    }
}

/// The clusters that a rank sorts: where nothing is composited, as many consecutive ones as every other.
pub fn clusters(
    sharing: &Sharing,
    context: &FrameContext,
    (rank, size): (usize, usize),
    report: &mut RankReport,
) -> ClusterSet {
    if !sharing.organisation.composites(size) || sharing.clusters == ClusterDivision::Consecutive {
        return Part { number: rank as u32, of: size as u32 }.range(context.clusters()).into();
    }
    report.stages.redistribute.time(|| Renderer::divide_clusters(context, size).swap_remove(rank))
}

/// The owner of each tile, one of the `members`, which share them; by its number in the group. All members call this.
///
/// # Errors
/// [`ParallelError::Comm`].
pub fn owners(
    own: &mut Rank,
    comm: &mut FrameComm<'_, impl Communicator>,
    task: &Task,
    context: &FrameContext,
    members: &Range<usize>,
    report: &mut RankReport,
) -> Result<Vec<u32>, ParallelError> {
    let (grid, division, last) = (&context.grid, task.sharing.division, &mut own.last_frame);
    let stages = &mut report.stages;
    let is_adaptive = division == Division::Adaptive && members.len() > 1;
    let (columns, rows, shift) = (grid.columns, grid.rows, grid.shift);
    let of = is_adaptive.then(|| Divided { columns, rows, shift, members: members.clone() });
    // Nothing is known after an error.
    let before = last.of.take();
    let is_known = is_adaptive && before == of;
    if members.len() == 1 {
        return Ok(vec![0; grid.count()]);
    }
    let mut load = std::mem::take(&mut last.work);
    if !is_known {
        load.clear();
        if division.needs_load() {
            load = stages.redistribute.time(|| Renderer::estimate_load(context));
        }
    }
    // Of the last frame each rank knows only its own tiles, and of a model in parts only its own clusters.
    if is_known || division.needs_load() && task.scene.is_in_parts() {
        comm.begin(Kind::Load);
        let mut group = Group::new(comm, members.clone());
        stages.wait.time(|| all_reduce_arrays(&mut group, &mut load, u64::saturating_add))?;
    }
    Ok(stages.redistribute.time(|| {
        if !is_adaptive {
            return division.owners(grid, &load, members.len());
        }
        if !is_known {
            last.cuts = Cuts::default();
        }
        let owners = last.cuts.owners(grid, &load, members.len());
        load.fill(0);
        (last.work, last.of) = (load, of);
        owners
    }))
}
