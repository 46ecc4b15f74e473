//! Options of how ranks share a frame.

use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, ValueEnum};
use tercio::image::Destination;
use tercio::parallel::trace::now;
use tercio::parallel::{ClusterDivision, Composition, Division, Encoding, Organisation, Radices, Sharing};
use tercio_lab::predict::choose::candidates::Limits;

use crate::args::values;
use crate::named_files::NamedFiles;
use crate::output::UsageError;

/// The largest number of ranks.
pub const MAX_RANKS: usize = 1024;

/// Where work is redistributed between ranks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum OrganisationName {
    /// Ranks share the picture: each draws only in its tiles, and only the clusters that reach them.
    SortFirst,
    /// Ranks share the clusters, sort them into tiles, and send them to the ranks that own the tiles.
    SortMiddle,
    /// Ranks share the clusters: their pictures are composited.
    SortLast,
    /// Sort-middle in groups of --group ranks, whose pictures are composited.
    SortTwice,
    /// The one that should be the fastest, by a model of the laboratory; -v says why. --group, --division, --composition and
    /// (for radix-k) --radix limit what is compared.
    Auto,
}

/// How the tiles of the picture are divided among ranks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum DivisionName {
    /// Scattered, with about the same work for each rank.
    Balanced,
    /// Tile k, row by row, belongs to rank k modulo the number of ranks.
    Interleaved,
    /// Strips across the picture, with about the same work.
    Rows,
    /// Strips down the picture, with about the same work.
    Columns,
    /// Compact parts, with about the same work.
    Blocks,
    /// Compact regions between cuts that move from picture to picture, by the work that each tile was in the last one.
    Adaptive,
}

/// How the pictures of ranks are composited.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum CompositionName {
    /// Each rank sends its part of a tile straight to the tile's owner.
    DirectSend,
    /// Pairs of ranks exchange halves.
    BinarySwap,
    /// Groups of up to --radix ranks exchange parts.
    RadixK,
    /// Groups of ranks are joined by twos and threes, whose members exchange parts.
    #[value(name = "2-3-swap")]
    TwoThreeSwap,
    /// Half of the ranks send all that they have to the others, until one has everything.
    Tree,
    /// One rank after another adds its part.
    Ring,
}

/// Which pixels are sent to be composited.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum EncodingName {
    /// Those that are drawn. Ranks tell each other what they hide, which the others then do not draw.
    Visible,
    /// Those that are drawn, hidden by other ranks or not, to compare with.
    Sparse,
    /// All of them, whatever is drawn, to compare with; it needs --aa 1 and nothing translucent.
    Dense,
}

/// How clusters are divided among ranks that composite.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ClustersName {
    /// Into parts that are compact in the picture and have about the same visible work.
    Compact,
    /// As many consecutive ones for each rank, whatever the view, to compare with.
    Consecutive,
}

/// Ranks.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Ranks (the picture stays the same)")]
pub struct RanksArgs {
    /// Draws with this many ranks, 1 to 1024: threads of this process that share nothing but the model and send each
    /// other messages, as the processes of a cluster do. They share the threads of --threads, but each has at least one. Processes that
    /// mpirun started are ranks without this option.
    #[arg(long, value_name = "N", value_parser = parse_ranks)]
    ranks: Option<usize>,
    /// How ranks share a frame [default: sort-middle; with --parts, sort-last].
    #[arg(long, visible_alias = "organization", value_name = "HOW", value_enum)]
    organisation: Option<OrganisationName>,
    /// Ranks of a group of sort-twice; the last group may be smaller [default: about the square root of their number].
    #[arg(long, value_name = "N", value_parser = parse_ranks)]
    group: Option<usize>,
    /// How the tiles of the picture are divided: for sort-first, sort-middle, and inside the groups of sort-twice [default:
    /// balanced].
    #[arg(long, value_name = "HOW", value_enum)]
    division: Option<DivisionName>,
    /// How pictures are composited: for sort-last, and between the groups of sort-twice [default: direct-send].
    #[arg(long, value_name = "HOW", value_enum)]
    composition: Option<CompositionName>,
    /// Largest number of ranks that exchange parts in a round of --composition radix-k, at least 2 [default: 4]. Of several, as
    /// in 8,2,2, at most 10, the first is that of the first round, and the last one that of all further ones, too.
    #[arg(long, value_name = "K,...", value_delimiter = ',', value_parser = clap::value_parser!(u32).range(2..=MAX_RANKS as i64))]
    radix: Option<Vec<u32>>,
    /// Which pixels, or fragments of samples and layers, are sent to be composited: for sort-last, and between the groups of
    /// sort-twice [default: visible].
    #[arg(long, value_name = "WHICH", value_enum)]
    encoding: Option<EncodingName>,
    /// How the clusters of the model are divided: for sort-last and sort-twice, unless ranks have parts of the model [default: compact].
    #[arg(long, value_name = "HOW", value_enum)]
    clusters: Option<ClustersName>,
    /// Each process of an MPI job loads a part of the model only, and they draw all of it. They share one file (a prepared
    /// model, binary PLY or binary STL), or each has its own: part_{rank}.ply.
    #[arg(long)]
    parts: bool,
    /// Ends an MPI job in which a rank waits for another one for longer than this, in seconds. After 10 seconds a rank says which
    /// one it waits for; without this option it goes on waiting.
    #[arg(long, value_name = "SECONDS", value_parser = values::positive)]
    timeout: Option<f64>,
    /// Writes when each rank loaded, agreed, sorted, redistributed, drew, composited, collected, waited and reported, in Chrome's
    /// trace event format, for about:tracing or ui.perfetto.dev; `-` for standard output. All processes of a job need it; rank 0
    /// writes. Without ranks there is one.
    #[arg(long, value_name = "FILE")]
    trace: Option<PathBuf>,
}

/// Who draws a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Drawers {
    /// This process, without ranks.
    Alone,
    /// This many ranks of this process.
    InProcess(usize, How),
    /// The processes that mpirun started.
    Mpi(How),
}

/// How ranks share a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum How {
    /// So.
    As(Sharing),
    /// As is chosen when the scene is known.
    Auto(Limits),
}

impl How {
    /// Whether ranks may composite their pictures.
    fn may_composite(self, ranks: usize) -> bool {
        match self {
            Self::As(sharing) => sharing.organisation.composites(ranks),
            Self::Auto(_) => ranks > 1,
        }
    }
}

impl RanksArgs {
    /// Who draws, in a job of `processes` if it is an MPI job.
    ///
    /// # Errors
    /// [`UsageError`] if the options request other ranks than those of the job.
    pub fn drawers(&self, processes: Option<usize>) -> Result<Drawers, UsageError> {
        let has_others = processes.is_some_and(|p| p > 1);
        match (self.ranks, processes) {
            (Some(ranks), Some(processes)) if has_others && ranks != processes => Err(UsageError(format!(
                "--ranks {ranks}: mpirun started {processes} processes, which are the ranks"
            ))),
            (Some(_), _) if !has_others && self.timeout.is_some() => Err(UsageError(
                "--timeout is for processes that mpirun started: ranks of one process are not stopped one by one".into(),
            )),
            (Some(_), _) if !has_others && self.parts => Err(UsageError(
                "--parts is for processes that mpirun started: ranks of one process share its memory".into(),
            )),
            (Some(ranks), _) if !has_others => Ok(Drawers::InProcess(ranks, self.how(ranks)?)),
            (_, Some(processes)) if has_others || self.option().is_some() => {
                Ok(Drawers::Mpi(self.how(processes)?))
            }
            (None, None) => match self.option() {
                Some(option) => Err(UsageError(format!(
                    "{option} is for ranks: it needs --ranks N, or mpirun -n N"
                ))),
                None => Ok(Drawers::Alone),
            },
            _ => Ok(Drawers::Alone),
        }
    }

    /// The first option that says how ranks share a frame, if there is one.
    fn option(&self) -> Option<&'static str> {
        [
            (self.organisation.is_some(), "--organisation"),
            (self.group.is_some(), "--group"),
            (self.division.is_some(), "--division"),
            (self.composition.is_some(), "--composition"),
            (self.radix.is_some(), "--radix"),
            (self.encoding.is_some(), "--encoding"),
            (self.clusters.is_some(), "--clusters"),
            (self.parts, "--parts"),
            (self.timeout.is_some(), "--timeout"),
        ]
        .into_iter()
        .find_map(|(is_given, option)| is_given.then_some(option))
    }

    /// Whether each rank loads a part of the model.
    pub fn parts(&self) -> bool {
        self.parts
    }

    /// Where to write when each rank did what.
    pub fn trace(&self) -> Option<Destination> {
        self.trace.as_deref().map(Destination::from_path)
    }

    /// When something begins, if it is recorded: the clock of the machine is read only then, because valgrind cannot read it in the
    /// static program.
    pub fn now(&self) -> Option<u64> {
        self.trace.as_ref().map(|_| now())
    }

    /// Adds the files that these options name.
    pub fn named_files(&self, files: NamedFiles) -> NamedFiles {
        match self.trace() {
            Some(destination) => files.writes("--trace", &destination),
            None => files,
        }
    }

    /// Refuses `--encoding dense` with several samples per pixel.
    ///
    /// # Errors
    /// They are refused.
    pub fn check_samples(&self, samples: usize) -> Result<(), UsageError> {
        if self.encoding == Some(EncodingName::Dense) && samples > 1 {
            return Err(UsageError(
                "--encoding dense composites pixels, not samples: it needs --aa 1".into(),
            ));
        }
        Ok(())
    }

    /// How long a rank waits for another one.
    pub fn timeout(&self) -> Option<Duration> {
        // Longer times than there are: for ever.
        self.timeout.and_then(|seconds| Duration::try_from_secs_f64(seconds).ok())
    }

    /// How this many ranks share a frame.
    fn how(&self, ranks: usize) -> Result<How, UsageError> {
        if let Some(group) = self.group.filter(|&group| group > ranks) {
            return Err(UsageError(format!("--group {group}: there are {ranks} ranks")));
        }
        let division = self.division.map(DivisionName::division);
        // Of models in parts, pixels are fewer bytes than triangles, as a rule.
        let usual = if self.parts { OrganisationName::SortLast } else { OrganisationName::SortMiddle };
        let organisation = match self.organisation.unwrap_or(usual) {
            OrganisationName::SortFirst => Organisation::SortFirst,
            OrganisationName::SortMiddle => Organisation::SortMiddle,
            OrganisationName::SortLast => Organisation::SortLast,
            OrganisationName::SortTwice => {
                let square_root = (1..).find(|root| root * root >= ranks).unwrap_or(ranks);
                Organisation::SortTwice { group: self.group.unwrap_or(square_root) }
            }
            OrganisationName::Auto if self.parts => {
                return Err(UsageError(
                    "--organisation auto counts whole models: with --parts, name an organisation".into(),
                ));
            }
            OrganisationName::Auto
                if self.encoding.is_some_and(|encoding| encoding != EncodingName::Visible) =>
            {
                return Err(UsageError(
                    "--organisation auto predicts --encoding visible: with another one, name an organisation"
                        .into(),
                ));
            }
            OrganisationName::Auto if self.clusters == Some(ClustersName::Consecutive) => {
                return Err(UsageError(
                    "--organisation auto predicts --clusters compact: with others, name an organisation"
                        .into(),
                ));
            }
            OrganisationName::Auto => {
                let composition = self.composition()?;
                let limits = Limits { group: self.group, division, composition, all: false };
                let some = limits.candidates(ranks);
                some.map_err(|none| UsageError(format!("--organisation auto: {none}")))?;
                return Ok(How::Auto(limits));
            }
        };
        let name = organisation.name();
        let unused = |option, why: &str| Err(UsageError(format!("{option}: {name} {why}")));
        let is_twice = matches!(organisation, Organisation::SortTwice { .. });
        if self.group.is_some() && !is_twice {
            return unused("--group", "has no groups of ranks; --organisation sort-twice has");
        }
        if division.is_some() && organisation == Organisation::SortLast {
            return unused("--division", "does not divide the picture");
        }
        let composites = is_twice || organisation == Organisation::SortLast;
        let of_composition = [
            (self.composition.is_some(), "--composition"),
            (self.radix.is_some(), "--radix"),
            (self.encoding.is_some(), "--encoding"),
            (self.clusters.is_some(), "--clusters"),
        ];
        if let Some((_, option)) = of_composition.into_iter().find(|(is_given, _)| *is_given && !composites) {
            return unused(option, "does not composite pictures; sort-last and sort-twice do");
        }
        let (division, composition) = (division.unwrap_or_default(), self.composition()?.unwrap_or_default());
        let encoding = match self.encoding {
            None | Some(EncodingName::Visible) => Encoding::Visible,
            Some(EncodingName::Sparse) => Encoding::Sparse,
            Some(EncodingName::Dense) => Encoding::Dense,
        };
        if self.clusters.is_some() && self.parts {
            return unused("--clusters", "draws the clusters that each rank has, with --parts");
        }
        let clusters = match self.clusters {
            None | Some(ClustersName::Compact) => ClusterDivision::Compact,
            Some(ClustersName::Consecutive) => ClusterDivision::Consecutive,
        };
        Ok(How::As(Sharing { organisation, division, composition, encoding, clusters }))
    }

    /// The composition, if one is requested.
    fn composition(&self) -> Result<Option<Composition>, UsageError> {
        Ok(match self.composition {
            Some(CompositionName::RadixK) => match &self.radix {
                None => Some(Composition::radix_k(4)),
                Some(radices) => {
                    let most = || UsageError(format!("--radix: at most {} rounds", Radices::MOST));
                    Some(Composition::RadixK(Radices::new(radices).ok_or_else(most)?))
                }
            },
            _ if self.radix.is_some() => {
                return Err(UsageError("--radix is for --composition radix-k".into()));
            }
            None => None,
            Some(CompositionName::DirectSend) => Some(Composition::DirectSend),
            Some(CompositionName::BinarySwap) => Some(Composition::BinarySwap),
            Some(CompositionName::TwoThreeSwap) => Some(Composition::TwoThreeSwap),
            Some(CompositionName::Tree) => Some(Composition::Tree),
            Some(CompositionName::Ring) => Some(Composition::Ring),
        })
    }
}

impl DivisionName {
    fn division(self) -> Division {
        match self {
            Self::Balanced => Division::Balanced,
            Self::Interleaved => Division::Interleaved,
            Self::Rows => Division::Rows,
            Self::Columns => Division::Columns,
            Self::Blocks => Division::Blocks,
            Self::Adaptive => Division::Adaptive,
        }
    }
}

impl Drawers {
    /// Whether ranks may composite their pictures.
    pub fn composites(self) -> bool {
        match self {
            Self::Alone => false,
            Self::InProcess(count, how) => how.may_composite(count),
            // As many processes as there may be.
            Self::Mpi(how) => how.may_composite(usize::MAX),
        }
    }

    /// Does each rank send all pixels?
    pub fn sends_all(self) -> bool {
        let (Self::InProcess(_, how) | Self::Mpi(how)) = self else { return false };
        matches!(how, How::As(Sharing { encoding: Encoding::Dense, .. })) && self.composites()
    }

    /// Number of frames that this process keeps at the same time, and whether with their keys.
    pub fn frames(self) -> (usize, bool) {
        match self {
            Self::InProcess(count, _) => (count, self.composites()),
            Self::Alone | Self::Mpi(_) => (1, self.composites()),
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

    /// Options as they are written.
    #[derive(clap::Parser)]
    struct Line {
        #[command(flatten)]
        ranks: RanksArgs,
    }

    fn drawers(options: &str, processes: Option<usize>) -> Result<Drawers, String> {
        let line = std::iter::once("tercio").chain(options.split_whitespace());
        let parsed = <Line as clap::Parser>::try_parse_from(line).map_err(|e| e.to_string())?;
        parsed.ranks.drawers(processes).map_err(|e| e.0)
    }

    #[test]
    fn processes_of_mpirun_are_the_ranks() {
        use Organisation::{SortFirst, SortMiddle};
        assert_eq!(drawers("", None), Ok(Drawers::Alone));
        assert_eq!(drawers("", Some(1)), Ok(Drawers::Alone));
        let (first, middle) = (How::As(SortFirst.into()), How::As(SortMiddle.into()));
        assert_eq!(drawers("", Some(4)), Ok(Drawers::Mpi(middle)));
        assert_eq!(drawers("--ranks 4", Some(4)), Ok(Drawers::Mpi(middle)));
        assert_eq!(drawers("--organisation sort-first", Some(1)), Ok(Drawers::Mpi(first)));
        let three = "--ranks 3 --organisation sort-first";
        assert_eq!(drawers(three, None), Ok(Drawers::InProcess(3, first)));
        assert_eq!(drawers("--ranks 3", Some(1)), Ok(Drawers::InProcess(3, middle)));
        assert!(drawers("--ranks 3", Some(4)).unwrap_err().contains("mpirun started 4"));
        let last = How::As(Organisation::SortLast.into());
        assert_eq!(drawers("--parts", Some(2)), Ok(Drawers::Mpi(last)));
        let clusters = drawers("--parts --clusters compact", Some(2)).unwrap_err();
        assert!(clusters.contains("that each rank has"), "{clusters}");
        let auto = drawers("--parts --organisation auto", Some(2)).unwrap_err();
        assert!(auto.contains("name an organisation"), "{auto}");
        for option in [
            "--parts",
            "--organisation sort-first",
            "--organisation auto",
            "--group 2",
            "--division rows",
            "--composition tree",
            "--radix 4",
            "--encoding dense",
            "--clusters consecutive",
        ] {
            let error = drawers(option, None).unwrap_err();
            assert!(error.contains("--ranks") && error.starts_with(&option[..7]), "{error}");
        }
    }

    #[test]
    fn options_that_have_no_effect_are_refused() {
        let sharing = |options: &str| match drawers(&format!("--ranks 10 {options}"), None) {
            Ok(Drawers::InProcess(10, How::As(sharing))) => Ok(sharing),
            Ok(other) => panic!("{other:?}"),
            Err(error) => Err(error),
        };
        let twice = |group| Sharing::from(Organisation::SortTwice { group });
        assert_eq!(sharing("--organisation sort-twice"), Ok(twice(4)));
        assert_eq!(sharing("--organisation sort-twice --group 3"), Ok(twice(3)));
        let composition = Composition::radix_k(3);
        let last = Sharing { composition, ..Organisation::SortLast.into() };
        assert_eq!(sharing("--organisation sort-last --composition radix-k --radix 3"), Ok(last));
        let radices = Radices::new(&[8, 2, 2]).expect("radices");
        let last = Sharing { composition: Composition::RadixK(radices), ..Organisation::SortLast.into() };
        assert_eq!(sharing("--organisation sort-last --composition radix-k --radix 8,2,2"), Ok(last));
        let last = Sharing { composition: Composition::TwoThreeSwap, ..Organisation::SortLast.into() };
        assert_eq!(sharing("--organisation sort-last --composition 2-3-swap"), Ok(last));
        let last = Sharing { encoding: Encoding::Dense, ..Organisation::SortLast.into() };
        assert_eq!(sharing("--organisation sort-last --encoding dense"), Ok(last));
        let last = Sharing { encoding: Encoding::Sparse, ..Organisation::SortLast.into() };
        assert_eq!(sharing("--organisation sort-last --encoding sparse"), Ok(last));
        let last = Sharing { clusters: ClusterDivision::Consecutive, ..Organisation::SortLast.into() };
        assert_eq!(sharing("--organisation sort-last --clusters consecutive"), Ok(last));
        let division = Division::Rows;
        let middle = Sharing { division, ..Organisation::SortMiddle.into() };
        assert_eq!(sharing("--organisation sort-middle --division rows"), Ok(middle));
        for (options, reason) in [
            ("--group 3", "sort-middle has no groups"),
            ("--organisation sort-last --division rows", "sort-last does not divide"),
            ("--organisation sort-middle --composition tree", "sort-middle does not composite"),
            (
                "--organisation sort-first --composition radix-k --radix 3",
                "--composition: sort-first does not composite",
            ),
            ("--organisation sort-first --radix 3", "--radix: sort-first does not composite"),
            ("--organisation sort-first --encoding dense", "--encoding: sort-first does not composite"),
            ("--organisation sort-first --clusters compact", "--clusters: sort-first does not composite"),
            ("--organisation auto --clusters consecutive", "name an organisation"),
            ("--organisation auto --encoding dense", "name an organisation"),
            ("--organisation auto --encoding sparse", "name an organisation"),
            ("--organisation auto --group 11", "--group 11: there are 10 ranks"),
            ("--organisation auto --radix 3", "--radix is for"),
            ("--organisation sort-last --composition tree --radix 3", "--radix is for"),
            ("--radix 1", "1 is not in 2..=1024"),
            ("--radix 4,1", "1 is not in 2..=1024"),
            (
                "--organisation sort-last --composition radix-k --radix 2,2,2,2,2,2,2,2,2,2,2",
                "--radix: at most 10 rounds",
            ),
            ("--organisation sort-twice --group 11", "--group 11: there are 10 ranks"),
            ("--timeout 5", "--timeout is for processes"),
            ("--parts", "--parts is for processes"),
            ("--timeout 0", "--timeout"),
        ] {
            let error = sharing(options).unwrap_err();
            assert!(error.contains(reason), "{options}: {error}");
        }
    }

    #[test]
    fn options_besides_auto_limit_what_it_compares() {
        let auto = |options: &str| drawers(&format!("--ranks 4 --organisation auto {options}"), None);
        let limits = |limits| Ok(Drawers::InProcess(4, How::Auto(limits)));
        assert_eq!(auto(""), limits(Limits::default()));
        let (division, composition) = (Some(Division::Rows), Some(Composition::radix_k(3)));
        assert_eq!(auto("--division rows"), limits(Limits { division, ..Limits::default() }));
        let both = "--division rows --composition radix-k --radix 3 --group 2";
        assert_eq!(auto(both), limits(Limits { group: Some(2), division, composition, all: false }));
        assert_eq!(drawers("--organisation auto", Some(3)), Ok(Drawers::Mpi(How::Auto(Limits::default()))));
        let two = drawers("--ranks 2 --organisation auto --division rows --composition tree", None);
        let error = two.unwrap_err();
        assert!(error.contains("sort-twice, which needs 3 ranks or more: there are 2"), "{error}");
    }
}
