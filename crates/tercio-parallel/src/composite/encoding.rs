//! Which pixels ranks send to be composited.

use std::fmt;

use serde::Serialize;

/// Which pixels ranks send to be composited. The picture does not depend on it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Encoding {
    /// Those in which something is drawn, as runs (active-pixel encoding), of the tiles that clusters reach. If there are several
    /// samples per pixel, nothing is translucent and the filter is no wider than a pixel, ranks tell each other what they hide while they draw, and what a rank knows to
    /// be hidden is not sent; nor is it drawn.
    #[default]
    Visible,
    /// Those in which something is drawn, whether other ranks hide it or not. For comparison.
    Sparse,
    /// All pixels of all tiles, whether something is drawn there or not, as first sort-last machines did: the cost does not
    /// depend on the model. For comparison. If there are several samples per pixel or anything is translucent, lists of fragments
    /// are composited, and this encoding is refused ([`RenderError::Setting`](tercio_raster::RenderError::Setting)).
    Dense,
}

impl Encoding {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Visible, Self::Sparse, Self::Dense];

    /// The name on the command line and in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Visible => "visible",
            Self::Sparse => "sparse",
            Self::Dense => "dense",
        }
    }
}

impl fmt::Display for Encoding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
