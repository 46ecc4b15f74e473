//! Options of how ranks share a frame.

use clap::{Args, ValueEnum};
use tercio::parallel::{Organisation, Ranks};
use tercio::scene::{Instance, Scene};

use crate::output::UsageError;

/// The largest number of ranks.
pub const MAX_RANKS: usize = 256;

/// Where work is redistributed between ranks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum OrganisationName {
    /// Ranks share the picture: each draws only in its tiles, and only the clusters that reach them.
    SortFirst,
    /// Ranks share the clusters: their pictures are composited.
    SortLast,
}

impl From<OrganisationName> for Organisation {
    fn from(name: OrganisationName) -> Self {
        match name {
            OrganisationName::SortFirst => Self::SortFirst,
            OrganisationName::SortLast => Self::SortLast,
        }
    }
}

/// Ranks.
#[derive(Debug, Args)]
#[command(next_help_heading = "Ranks (the picture stays the same)")]
pub struct RanksArgs {
    /// Draws with this many ranks, 1 to 256: threads of this process that share nothing but the model and send each
    /// other messages, as the processes of a cluster do. They share the threads of --threads. Processes that
    /// mpirun started are ranks without this option.
    #[arg(long, value_name = "N", value_parser = parse_ranks)]
    ranks: Option<usize>,
    /// How ranks share a frame [default: sort-last; sort-first if the model is not opaque].
    #[arg(long, value_name = "HOW", value_enum)]
    organisation: Option<OrganisationName>,
}

/// Who draws a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Drawers {
    /// This process, without ranks.
    Alone,
    /// This many ranks of this process.
    InProcess(usize, Organisation),
    /// The processes that mpirun started.
    Mpi(Organisation),
}

impl RanksArgs {
    /// Who draws, in a job of `processes` if it is an MPI job.
    ///
    /// # Errors
    /// [`UsageError`] if the options request other ranks than those of the job.
    pub fn drawers(&self, processes: Option<usize>) -> Result<Drawers, UsageError> {
        let organisation = self.organisation.unwrap_or(OrganisationName::SortLast).into();
        let has_others = processes.is_some_and(|p| p > 1);
        match (self.ranks, processes) {
            (Some(ranks), Some(processes)) if has_others && ranks != processes => Err(UsageError(format!(
                "--ranks {ranks}: mpirun started {processes} processes, which are the ranks"
            ))),
            (Some(ranks), _) if !has_others => Ok(Drawers::InProcess(ranks, organisation)),
            (_, Some(_)) if has_others || self.organisation.is_some() => Ok(Drawers::Mpi(organisation)),
            (None, None) if self.organisation.is_some() => Err(UsageError(
                "--organisation says how ranks share a frame: it needs --ranks N, or mpirun -n N".into(),
            )),
            _ => Ok(Drawers::Alone),
        }
    }
}

impl RanksArgs {
    /// How ranks share a frame of this scene: without a request, sort-last only if all is opaque, because it sends every layer
    /// of what is not.
    pub fn organisation(&self, requested: Organisation, scene: &Scene) -> Organisation {
        let is_opaque = !scene.instances.iter().any(Instance::is_translucent);
        if is_opaque || self.organisation.is_some() { requested } else { Organisation::SortFirst }
    }
}

impl Drawers {
    /// The ranks of this process, if there are any, sharing `threads` threads.
    pub fn in_process(self, threads: usize) -> Option<Ranks> {
        let Self::InProcess(count, organisation) = self else { return None };
        Some(Ranks { count, threads: (threads / count).max(1), organisation })
    }

    /// Whether ranks composite their pictures.
    pub fn composites(self) -> bool {
        matches!(self, Self::InProcess(_, Organisation::SortLast) | Self::Mpi(Organisation::SortLast))
    }

    /// Number of frames that this process keeps at the same time, and whether with their keys.
    pub fn frames(self) -> (usize, bool) {
        match self {
            Self::Alone => (1, false),
            Self::InProcess(count, _) => (count, true),
            Self::Mpi(_) => (1, true),
        }
    }
}

pub fn parse_ranks(text: &str) -> Result<usize, String> {
    let n = text.parse().ok().filter(|n| (1..=MAX_RANKS).contains(n));
    n.ok_or_else(|| format!("expected 1 to {MAX_RANKS}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawers(
        ranks: Option<usize>,
        organisation: Option<OrganisationName>,
        processes: Option<usize>,
    ) -> Result<Drawers, String> {
        RanksArgs { ranks, organisation }.drawers(processes).map_err(|e| e.0)
    }

    #[test]
    fn processes_of_mpirun_are_the_ranks() {
        use Organisation::{SortFirst, SortLast};
        let first = Some(OrganisationName::SortFirst);
        assert_eq!(drawers(None, None, None), Ok(Drawers::Alone));
        assert_eq!(drawers(None, None, Some(1)), Ok(Drawers::Alone));
        assert_eq!(drawers(None, None, Some(4)), Ok(Drawers::Mpi(SortLast)));
        assert_eq!(drawers(Some(4), None, Some(4)), Ok(Drawers::Mpi(SortLast)));
        assert_eq!(drawers(None, first, Some(1)), Ok(Drawers::Mpi(SortFirst)));
        assert_eq!(drawers(Some(3), first, None), Ok(Drawers::InProcess(3, SortFirst)));
        assert_eq!(drawers(Some(3), None, Some(1)), Ok(Drawers::InProcess(3, SortLast)));
        assert!(drawers(Some(3), None, Some(4)).unwrap_err().contains("mpirun started 4"));
        assert!(drawers(None, first, None).unwrap_err().contains("--ranks"));
    }
}
