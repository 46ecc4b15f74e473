//! Options of how ranks share a frame.

use clap::{Args, ValueEnum};
use tercio::parallel::{Organisation, Ranks};

/// The largest number of ranks that can be asked for.
pub const MAX_RANKS: usize = 256;

/// Where work changes hands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum OrganisationName {
    /// Ranks share the picture: each draws the clusters that reach its tiles, and only there.
    SortFirst,
    /// Ranks share the clusters: pictures are composed.
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
    /// Draws with so many ranks, 1 to 256: threads of this process that share nothing but the model and send each
    /// other messages, as the processes of a cluster do. They share the threads of --threads.
    #[arg(long, value_name = "N", value_parser = parse_ranks)]
    pub ranks: Option<usize>,
    /// How ranks share a frame [default: sort-last].
    #[arg(long, value_name = "HOW", value_enum, requires = "ranks")]
    organisation: Option<OrganisationName>,
}

impl RanksArgs {
    /// The ranks, if any were asked for, that share so many threads.
    pub fn ranks(&self, threads: usize) -> Option<Ranks> {
        let organisation = self.organisation.unwrap_or(OrganisationName::SortLast).into();
        self.ranks.map(|count| Ranks { count, threads: (threads / count).max(1), organisation })
    }
}

pub fn parse_ranks(text: &str) -> Result<usize, String> {
    let n = text.parse().ok().filter(|n| (1..=MAX_RANKS).contains(n));
    n.ok_or_else(|| format!("expected 1 to {MAX_RANKS}"))
}
