//! Counting of the back end's work: the counts of the statistics only, or all counts that predictions need.
//!
//! The kernels count into a [`Tally`]. [`BackEndCounts`] is the tally that pictures are drawn with. [`FullTally`] adds
//! finer counts; in kernels with the other tally, their code is compiled out.

use tercio_mesh::cluster::ClusterView;

use super::corners::ColorSource;
use super::shade;
use crate::context::FrameContext;
use crate::simd::LANES;
use crate::stats::{BackEndCounts, counts};

/// The counters of the back end for one tile, or for a share of a tile.
pub trait Tally: Default + Send {
    /// The tallies of the tiles of a frame, accumulated.
    type Frame: Default + Send;

    /// The counts that every tally has.
    fn counts(&mut self) -> &mut BackEndCounts;

    /// The tally itself if it is a [`FullTally`], otherwise `None`.
    fn full(&mut self) -> Option<&mut FullTally>;

    /// The sum of the tallies of two shares of one tile.
    fn plus(self, o: Self) -> Self;

    /// The frame's tally that consists of this one tile only.
    fn into_frame(self, tile: u32, is_shared: bool) -> Self::Frame;

    /// The tally of the tiles of both.
    fn join(a: Self::Frame, b: Self::Frame) -> Self::Frame;

    /// The sum of [`Tally::counts`] over all tiles of a frame.
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

/// All counts of a tile.
#[derive(Clone, Debug, Default)]
pub struct FullTally {
    /// The counts that every tally has.
    pub counts: BackEndCounts,
    /// Finer counts.
    pub details: DetailCounts,
    /// Numbers of the clusters that were drawn; in a tile that workers share, a number may occur several times.
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
    /// Counts the pixels of a tile that are inside the picture, and, if the tile has entries, all of its samples.
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

    /// Counts the shading of the `pixels` winners of a cluster that has triangles which are wide on the screen, or not.
    pub fn winners(&mut self, context: &FrameContext, number: u32, pixels: usize, are_wide: bool) {
        if pixels == 0 {
            return;
        }
        let (instance, cluster) = context.cluster(number);
        let shadings = pixels.div_ceil(LANES) as u64;
        self.details.clusters_won += 1;
        self.details.shadings += shadings;
        if are_wide {
            self.details.shadings_wide += shadings;
        }
        if shade::needs_plane(context, instance, cluster.head().normals_agree()) {
            self.details.shadings_by_plane += shadings;
        }
        if is_colored(context, instance) {
            self.details.vertices_colored += cluster.vertices() as u64;
        }
    }

    /// Counts pixels of an instance that are shaded when a tile is finished: a block of one triangle, or a single
    /// pixel.
    pub fn late(&mut self, context: &FrameContext, instance: usize, pixels: u64, is_block: bool) {
        self.details.pixels_shaded_late += pixels;
        if is_block {
            self.details.whole_blocks += 1;
        } else if is_colored(context, instance) {
            self.details.pixels_colored += pixels;
        }
    }
}

/// Does an instance have colours per vertex or per triangle?
fn is_colored(context: &FrameContext, instance: usize) -> bool {
    let instance = &context.scene.instances[instance];
    ColorSource::of(instance) != ColorSource::Base
}

/// Bytes of the cache lines that are touched by drawing a cluster.
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
        /// Samples of the tiles that have entries, including those outside the picture.
        pub tile_samples: u64,
        /// Pixels shaded when a tile is finished.
        pub pixels_shaded_late: u64,
        /// Blocks of 4x4 of these pixels that show a single triangle, whose corners are fetched once.
        pub whole_blocks: u64,
        /// Stamps of triangles that are set up one by one (a subset of all stamps).
        pub stamps_alone: u64,
        /// Groups of 16 small triangles that are set up together.
        pub set_ups: u64,
        /// Coverage tests of small triangles, each of one sample in each of 16 triangles.
        pub steps: u64,
        /// Clusters with winners, counted in each tile.
        pub clusters_won: u64,
        /// Groups of 16 winners that are shaded together with their cluster.
        pub shadings: u64,
        /// Those of these groups that need the triangles' planes.
        pub shadings_by_plane: u64,
        /// Those of clusters with triangles that are wide on the screen, which no specialized kernel shades.
        pub shadings_wide: u64,
        /// Pixels with colours per vertex or per triangle that are shaded when a tile is finished, except whole blocks.
        pub pixels_colored: u64,
        /// Vertices of clusters with winners, counted in each tile, that have colours per vertex or per triangle.
        pub vertices_colored: u64,
        /// Entries of triangles drawn.
        pub entries_drawn: u64,
        /// Bytes of the cache lines of the clusters drawn, counted in each tile.
        pub bytes_read: u64,
    }
}
