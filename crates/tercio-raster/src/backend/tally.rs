//! How the kernels count their work: as little as statistics show, or all that predictions are made of.
//!
//! They count into a [`Tally`]. [`BackEndCounts`] is the one that pictures are drawn with. [`FullTally`] counts finer
//! things besides; where it is off, nothing of it is compiled in.

use tercio_mesh::cluster::ClusterView;

use super::corners::ColorSource;
use super::shade;
use crate::context::FrameContext;
use crate::simd::LANES;
use crate::stats::{BackEndCounts, counts};

/// What the back end counts with.
pub trait Tally: Default + Send {
    /// What the tallies of the tiles of a frame come to.
    type Frame: Default + Send;

    /// What is always counted.
    fn counts(&mut self) -> &mut BackEndCounts;

    /// The whole tally, for what is counted in full only; always `None` where that is off.
    fn full(&mut self) -> Option<&mut FullTally>;

    /// The sum of shares of one tile.
    fn plus(self, o: Self) -> Self;

    /// A frame's tally, of one tile that all workers shared or one drew alone.
    fn into_frame(self, tile: u32, is_shared: bool) -> Self::Frame;

    /// Both together.
    fn join(a: Self::Frame, b: Self::Frame) -> Self::Frame;

    /// What is always counted, in all tiles of a frame.
    fn sum(frame: &Self::Frame) -> BackEndCounts;
}

impl Tally for BackEndCounts {
    type Frame = Self;

    #[inline(always)]
    fn counts(&mut self) -> &mut Self {
        self
    }

    #[inline(always)]
    fn full(&mut self) -> Option<&mut FullTally> {
        None
    }

    fn plus(self, o: Self) -> Self {
        self.plus(o)
    }

    fn into_frame(self, _: u32, _: bool) -> Self {
        self
    }

    fn join(a: Self, b: Self) -> Self {
        a.plus(b)
    }

    fn sum(frame: &Self) -> BackEndCounts {
        *frame
    }
}

/// All that is counted while a tile is drawn.
#[derive(Clone, Debug, Default)]
pub struct FullTally {
    /// What is always counted.
    pub counts: BackEndCounts,
    /// Finer counts.
    pub details: DetailCounts,
    /// Numbers of the clusters that were drawn; of a tile that workers share, one may stand here several times.
    pub clusters: Vec<u32>,
}

impl Tally for FullTally {
    type Frame = Vec<(u32, bool, Self)>;

    #[inline(always)]
    fn counts(&mut self) -> &mut BackEndCounts {
        &mut self.counts
    }

    #[inline(always)]
    fn full(&mut self) -> Option<&mut Self> {
        Some(self)
    }

    fn plus(mut self, o: Self) -> Self {
        self.counts = self.counts.plus(o.counts);
        self.details = self.details.plus(o.details);
        self.clusters.extend(o.clusters);
        self
    }

    fn into_frame(self, tile: u32, is_shared: bool) -> Self::Frame {
        vec![(tile, is_shared, self)]
    }

    fn join(mut a: Self::Frame, b: Self::Frame) -> Self::Frame {
        a.extend(b);
        a
    }

    fn sum(frame: &Self::Frame) -> BackEndCounts {
        frame.iter().map(|tile| tile.2.counts).fold(BackEndCounts::default(), BackEndCounts::plus)
    }
}

impl FullTally {
    /// Counts the picture's part of a tile, and the tile's memory if it has entries.
    pub fn tile(&mut self, context: &FrameContext, tile: u32, is_used: bool) {
        let (x, y) = context.grid.corner(tile);
        let edge = 1u32 << context.grid.shift;
        let across = edge.min(context.view.width - x);
        let down = edge.min(context.view.height - y);
        self.details.pixels += u64::from(across) * u64::from(down);
        self.details.tile_samples += u64::from(is_used) * u64::from(edge) * u64::from(edge);
    }

    /// Counts a cluster that is drawn.
    pub fn cluster(&mut self, number: u32, cluster: &ClusterView) {
        self.details.bytes_read += bytes(cluster);
        self.clusters.push(number);
    }

    /// Counts the shading of the pixels that a cluster won.
    pub fn winners(&mut self, context: &FrameContext, number: u32, pixels: usize) {
        if pixels == 0 {
            return;
        }
        let (instance, cluster) = context.cluster(number);
        let shadings = pixels.div_ceil(LANES) as u64;
        self.details.clusters_won += 1;
        self.details.shadings += shadings;
        if shade::needs_plane(context, instance, cluster.head().normals_agree()) {
            self.details.shadings_by_plane += shadings;
        }
        if is_colored(context, instance) {
            self.details.vertices_colored += cluster.vertices() as u64;
        }
    }

    /// Counts pixels of an instance that are shaded when a tile is finished: a whole block, or one fetched by itself.
    pub fn late(&mut self, context: &FrameContext, instance: usize, pixels: u64, is_block: bool) {
        self.details.pixels_shaded_late += pixels;
        if is_block {
            self.details.whole_blocks += 1;
        } else if is_colored(context, instance) {
            self.details.pixels_colored += pixels;
        }
    }
}

/// Do the colours of an instance stand at its vertices or triangles?
fn is_colored(context: &FrameContext, instance: usize) -> bool {
    let instance = &context.scene.instances[instance];
    ColorSource::of(&instance.mesh, &instance.surface) != ColorSource::Base
}

/// Bytes of the cache lines that drawing a cluster touches.
pub fn bytes(cluster: &ClusterView) -> u64 {
    let colors = cluster.vertex_colors().map_or(0, size_of_val);
    (size_of_val(cluster.hot_lines()) + colors) as u64
}

counts! {
    /// Counts of the back end that are finer than [`BackEndCounts`].
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    #[non_exhaustive]
    pub struct DetailCounts {
        /// Pixels of the tiles that are drawn.
        pub pixels: u64,
        /// Samples of the tiles with an entry, whole ones at the picture's border, too.
        pub tile_samples: u64,
        /// Pixels shaded when a tile is finished.
        pub pixels_shaded_late: u64,
        /// Of these the blocks of 4x4 that show one triangle, which is fetched once.
        pub whole_blocks: u64,
        /// Of the stamps those of triangles drawn by themselves.
        pub stamps_alone: u64,
        /// Sixteens of small triangles set up.
        pub set_ups: u64,
        /// Samples looked at, of 16 small triangles side by side.
        pub steps: u64,
        /// Clusters that won a pixel, in each tile.
        pub clusters_won: u64,
        /// Sixteens of pixels shaded with the cluster that won them.
        pub shadings: u64,
        /// Of these the ones that need the triangles' planes.
        pub shadings_by_plane: u64,
        /// Pixels shaded when a tile is finished, each fetched by itself, whose colour stands at vertices or triangles.
        pub pixels_colored: u64,
        /// Vertices of clusters that won a pixel, in each tile, whose colour stands at vertices or triangles.
        pub vertices_colored: u64,
        /// Entries of triangles drawn.
        pub entries_drawn: u64,
        /// Bytes of cache lines of the clusters drawn, in each tile.
        pub bytes_read: u64,
    }
}
