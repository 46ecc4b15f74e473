//! The operations that have a cost.

use serde::{Deserialize, Serialize};

/// One kind of work that has a cost.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Operation {
    /// The fixed cost of every frame, whatever is drawn.
    Frame,
    /// One cluster (object partition) tested.
    Cluster,
    /// One vertex transformed.
    Vertex,
    /// One polygon transformed and kept or rejected.
    Polygon,
    /// One visible polygon lit and set up.
    PolygonSetUp,
    /// One polygon added to one tile.
    Entry,
    /// One tile started, finished and written.
    Tile,
    /// One stamp of 16 samples (rows of 8 or 16) tested against a polygon that is binned by itself.
    Stamp,
    /// One scan line of one polygon.
    Segment,
    /// One pixel of one polygon, visible or not.
    Pixel,
    /// One visible pixel of a polygon shaded.
    ShadedPixel,
    /// One pixel of the picture cleared and written, whatever it shows.
    PicturePixel,
    /// One cluster added to one tile.
    ClusterEntry,
    /// One cluster taken apart: its triangles are sorted one by one.
    ClusterApart,
    /// One cluster in one tile found to be hidden by what is drawn there.
    ClusterHidden,
    /// One stamp of 16 samples that is compared with the depth of such a cluster.
    HiddenStamp,
    /// One cluster drawn into one tile.
    ClusterDrawn,
    /// One triangle of a cluster tested in one tile.
    ClusterTriangle,
    /// Up to 16 small triangles of a cluster set up in parallel.
    SetUp,
    /// One sample of each of up to 16 small triangles tested.
    SampleStep,
    /// One stamp of 16 samples (rows of 8 or 16) tested against a larger triangle of a cluster.
    ClusterStamp,
    /// One polygon drawn into one tile by itself.
    DrawnEntry,
    /// One sample of a tile that is not empty, cleared and scanned.
    TileSample,
    /// One cluster that is visible in one tile prepared for shading.
    ClusterShaded,
    /// Up to 16 pixels of a cluster shaded in parallel.
    Shading,
    /// The additional cost where pixels use the planes of their triangles.
    PlaneShading,
    /// The additional cost where the colours of pixels are those of vertices or triangles.
    ColoredShading,
    /// One colour of a pixel fetched from vertices or triangles.
    ColoredPixel,
    /// One colour of a vertex prepared for the pixels of its cluster.
    ColoredVertex,
    /// A block of 4x4 pixels of one polygon shaded.
    WholeBlock,
    /// One line of memory that a processor's own cache does not hold.
    CacheLine,
    /// The additional cost if no cache holds it.
    MemoryLine,
    /// One pixel of two partial pictures merged.
    CompositePixel,
    /// One visibility key of a picture cleared and written, whatever it shows.
    PictureKey,
    /// One visibility key made for a shaded pixel.
    ShadedKey,
    /// One line of memory of keys written that `processors.exchange-cache` does not hold.
    KeyLine,
    /// One pixel of a rank's picture scanned before it is sent.
    ScannedPixel,
    /// One span of pixels packed into a message.
    PackedSpan,
    /// One key or colour of these pixels packed into a message.
    PackedSample,
    /// One span of pixels unpacked from a message.
    UnpackedSpan,
    /// One key or colour of these pixels unpacked from a message.
    UnpackedSample,
    /// One pixel of two packets that are merged, with its key and colour.
    MergedPixel,
    /// One pixel of another rank's region set to the background.
    ClearedPixel,
    /// One line of memory of pictures and messages that `processors.exchange-cache` does not hold.
    ExchangeLine,
    /// One cluster looked at, to divide the picture among ranks by the work in its tiles.
    SurveyedCluster,
    /// One tile of the picture so divided.
    DividedTile,
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
            Self::Stamp => "stamp",
            Self::Segment => "segment",
            Self::Pixel => "pixel",
            Self::ShadedPixel => "shaded-pixel",
            Self::PicturePixel => "picture-pixel",
            Self::ClusterEntry => "cluster-entry",
            Self::ClusterApart => "cluster-apart",
            Self::ClusterHidden => "cluster-hidden",
            Self::HiddenStamp => "hidden-stamp",
            Self::ClusterDrawn => "cluster-drawn",
            Self::ClusterTriangle => "cluster-triangle",
            Self::SetUp => "set-up",
            Self::SampleStep => "sample-step",
            Self::ClusterStamp => "cluster-stamp",
            Self::DrawnEntry => "drawn-entry",
            Self::TileSample => "tile-sample",
            Self::ClusterShaded => "cluster-shaded",
            Self::Shading => "shading",
            Self::PlaneShading => "plane-shading",
            Self::ColoredShading => "colored-shading",
            Self::ColoredPixel => "colored-pixel",
            Self::ColoredVertex => "colored-vertex",
            Self::WholeBlock => "whole-block",
            Self::CacheLine => "cache-line",
            Self::MemoryLine => "memory-line",
            Self::CompositePixel => "composite-pixel",
            Self::PictureKey => "picture-key",
            Self::ShadedKey => "shaded-key",
            Self::KeyLine => "key-line",
            Self::ScannedPixel => "scanned-pixel",
            Self::PackedSpan => "packed-span",
            Self::PackedSample => "packed-sample",
            Self::UnpackedSpan => "unpacked-span",
            Self::UnpackedSample => "unpacked-sample",
            Self::MergedPixel => "merged-pixel",
            Self::ClearedPixel => "cleared-pixel",
            Self::ExchangeLine => "exchange-line",
            Self::SurveyedCluster => "surveyed-cluster",
            Self::DividedTile => "divided-tile",
        }
    }
}
