//! What messages between ranks are for.

use std::fmt;

use serde::{Deserialize, Serialize};

/// What a message between ranks is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Kind {
    /// Comparing the ranks' tasks before a frame.
    Agreement,
    /// Waiting for each other.
    Barrier,
    /// Which parts of models the ranks hold.
    Parts,
    /// In which tiles a rank may have drawn something.
    Touched,
    /// The work in each tile: estimates, of models in parts, or what was counted in the last frame, for adaptive divisions.
    Load,
    /// Clusters of models in parts, for the owners of tiles.
    Clusters,
    /// Contents of bins, for the owners of tiles.
    Bins,
    /// How near a rank may draw in the blocks of tiles.
    DepthBounds,
    /// Behind which depths a rank hides everything in the blocks of tiles.
    Occlusion,
    /// How many tiles are drawn next of what is not opaque.
    Round,
    /// Pixels with keys, which are composited.
    Pixels,
    /// Fragments, which are composited.
    Fragments,
    /// Finished pixels, for rank 0.
    Finished,
    /// Counts and times of a rank, for rank 0.
    Report,
}

impl Kind {
    /// All of them, in the order in which they occur in a frame. Messages have their places in this list.
    pub const ALL: [Self; 14] = [
        Self::Agreement,
        Self::Barrier,
        Self::Parts,
        Self::Touched,
        Self::Load,
        Self::Clusters,
        Self::Bins,
        Self::DepthBounds,
        Self::Occlusion,
        Self::Round,
        Self::Pixels,
        Self::Fragments,
        Self::Finished,
        Self::Report,
    ];

    /// Its place in [`Kind::ALL`].
    pub fn number(self) -> u32 {
        self as u32
    }

    /// The kind at a place in [`Kind::ALL`]; `None` behind its end.
    pub fn from_number(number: u32) -> Option<Self> {
        Self::ALL.get(usize::try_from(number).ok()?).copied()
    }

    /// The name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Agreement => "agreement",
            Self::Barrier => "barrier",
            Self::Parts => "parts of models",
            Self::Touched => "touched tiles",
            Self::Load => "work in tiles",
            Self::Clusters => "clusters",
            Self::Bins => "bins",
            Self::DepthBounds => "bounds of depth",
            Self::Occlusion => "occlusion",
            Self::Round => "round",
            Self::Pixels => "pixels",
            Self::Fragments => "fragments",
            Self::Finished => "finished pixels",
            Self::Report => "report",
        }
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_places_in_the_list() {
        for (number, kind) in (0..).zip(Kind::ALL) {
            assert_eq!((kind.number(), Kind::from_number(number)), (number, Some(kind)));
        }
        assert_eq!(Kind::from_number(Kind::ALL.len() as u32), None);
    }
}
