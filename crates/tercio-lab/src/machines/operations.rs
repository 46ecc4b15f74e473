//! What processors are charged for.

use serde::{Deserialize, Serialize};

/// One kind of work that has a cost.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Operation {
    /// What every frame costs, whatever is drawn.
    Frame,
    /// One cluster (object partition) looked at.
    Cluster,
    /// One vertex transformed.
    Vertex,
    /// One polygon transformed and kept or rejected.
    Polygon,
    /// One visible polygon lit and set up.
    PolygonSetUp,
    /// One polygon put into one tile.
    Entry,
    /// One tile begun, finished and written.
    Tile,
    /// One block of 4x4 samples tested against a triangle.
    Block,
    /// One scan line of one polygon.
    Segment,
    /// One pixel of one polygon, seen or not.
    Pixel,
    /// One pixel that shows a polygon shaded.
    ShadedPixel,
    /// One pixel of the picture cleared and written, whatever it shows.
    PicturePixel,
    /// One pixel of two partial pictures merged.
    CompositePixel,
}

impl Operation {
    /// The name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Frame => "frame",
            Self::Cluster => "cluster",
            Self::Vertex => "vertex",
            Self::Polygon => "polygon",
            Self::PolygonSetUp => "polygon-set-up",
            Self::Entry => "entry",
            Self::Tile => "tile",
            Self::Block => "block",
            Self::Segment => "segment",
            Self::Pixel => "pixel",
            Self::ShadedPixel => "shaded-pixel",
            Self::PicturePixel => "picture-pixel",
            Self::CompositePixel => "composite-pixel",
        }
    }
}
