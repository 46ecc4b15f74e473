//! The result of the front end: all that the back end needs to draw a set of tiles, from this process or another one.

use bytemuck::{Pod, Zeroable, cast_slice, pod_read_unaligned};

use tercio_mesh::cluster::MAX_TRIANGLES;

use super::{BinnedCluster, Bins};
use crate::context::FrameContext;
use crate::depth_bounds::{BLOCK_BITS, blocks_across};
use crate::screen::{PixelRect, ScreenTriangle, TileGrid, TileSet};
use crate::stats::{BinningCounts, FrontEndCounts, ratio};

/// Clusters and triangles of a frame, sorted into its tiles.
///
/// Made by [`Renderer::sort`](crate::Renderer::sort), or received from another rank as bytes
/// ([`Sorted::write_bytes`], [`Sorted::read_bytes`]).
#[derive(Debug, Default)]
pub struct Sorted {
    /// One for each batch of clusters and each message that was read.
    pub(crate) bins: Vec<Bins>,
    /// The counts of the front end; messages do not contribute.
    pub(crate) counts: FrontEndCounts,
}

/// Why bytes are not valid as bins of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SortedError {
    /// The lengths stored in the bytes do not match their number.
    #[error("the lengths stored in the bins do not match their {bytes} bytes")]
    Length {
        /// Number of bytes.
        bytes: usize,
    },
    /// They were made for a different division of the picture into tiles.
    #[error("bins of {found:?} tiles of 2^{shift} pixels, expected {expected:?}")]
    Grid {
        /// Tiles across and down.
        found: [u32; 2],
        /// Tiles across and down of the frame.
        expected: [u32; 2],
        /// log2 of the edge of a tile.
        shift: u32,
    },
    /// A tile, cluster or triangle that the frame does not have, or that is not valid.
    #[error("{what} {number} is not valid in this frame")]
    Number {
        /// Kind of the element.
        what: &'static str,
        /// Its number.
        number: u32,
    },
}

/// The header of the bytes.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct Head {
    shift: u32,
    columns: u32,
    rows: u32,
    first_row: u32,
    halo: u32,
    /// Number of tiles with entries.
    tiles: u32,
    /// Number of triangles, each counted once.
    triangles: u32,
    /// Number of their entries in all tiles.
    triangle_entries: u32,
    /// Number of entries of clusters in all tiles.
    cluster_entries: u32,
}

/// The header of a tile: its number, and the numbers of its entries.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct TileHead {
    tile: u32,
    triangles: u32,
    clusters: u32,
}

impl Sorted {
    /// Removes all bins and counts.
    pub fn clear(&mut self) {
        self.bins.clear();
        self.counts = FrontEndCounts::default();
    }

    /// Number of entries of a tile, triangles and clusters.
    pub fn fill(&self, tile: u32) -> u64 {
        self.bins.iter().map(|bins| bins.fill(tile)).sum()
    }

    /// The tiles that have entries; nothing can be drawn in the others.
    pub fn tiles_with_entries(&self, grid: &TileGrid) -> TileSet {
        TileSet::from_fn(grid.count(), |tile| self.fill(tile) > 0)
    }

    /// Numbers of the clusters that have entries in any of these tiles, as a whole or triangle by triangle; in ascending order,
    /// each once.
    pub fn clusters_in(&self, tiles: &[u32]) -> Vec<u32> {
        let mut found = Vec::new();
        // Triangles of a cluster often follow each other.
        let mut add = |number: u32| {
            if found.last() != Some(&number) {
                found.push(number);
            }
        };
        for (bins, &tile) in self.bins.iter().flat_map(|bins| tiles.iter().map(move |tile| (bins, tile))) {
            bins.clusters_in(tile).iter().for_each(|cluster| add(cluster.number));
            bins.triangles_in(tile).for_each(|triangle| add(triangle.slot / MAX_TRIANGLES as u32));
        }
        found.sort_unstable();
        found.dedup();
        found
    }

    /// The clusters that are sorted into a tile as a whole, in the order of the bins.
    pub fn clusters_of(&self, tile: u32) -> impl Iterator<Item = &BinnedCluster> {
        self.bins.iter().flat_map(move |bins| bins.clusters_in(tile))
    }

    /// Bytes of the bins that are in use.
    pub(crate) fn bytes_used(&self) -> u64 {
        self.bins.iter().map(Bins::bytes_used).sum()
    }

    /// The counts of the front end.
    pub fn front_end_counts(&self) -> FrontEndCounts {
        self.counts
    }

    /// An estimate of how many pixels layers cover in each tile, each layer counted: the areas of the clusters and triangles
    /// that may not be opaque. Triangles of a cluster that lie behind each other count once.
    pub fn layer_pixels(&self, context: &FrameContext) -> Vec<u64> {
        let of_tile = |tile: u32| {
            let own = context.grid.rect(tile, context.size());
            let area = |rect: PixelRect| {
                let rect = rect.intersect(own);
                if rect.is_empty() {
                    0
                } else {
                    (rect.x1 - rect.x0 + 1) as u64 * (rect.y1 - rect.y0 + 1) as u64
                }
            };
            let of_bins = |bins: &Bins| {
                let clusters = bins.clusters_in(tile).iter().filter(|c| context.has_translucency(c.number));
                let clusters = clusters.map(|c| area(c.pixels()));
                let triangles = bins.triangles_in(tile);
                let triangles = triangles.filter(|t| context.has_translucency(t.slot / MAX_TRIANGLES as u32));
                let [width, height] = context.size();
                let triangles = triangles.filter_map(|t| t.pixels(context.cells.origin, width, height));
                clusters.sum::<u64>() + triangles.map(area).sum::<u64>()
            };
            self.bins.iter().map(of_bins).sum()
        };
        (0..context.grid.count() as u32).map(of_tile).collect()
    }

    /// Raises the bounds of depth of a tile's blocks ([`DepthBounds`](crate::depth_bounds::DepthBounds)) to what may be drawn there.
    ///
    /// # Panics
    /// If the frame does not have the tile, or there are fewer bounds than the tile has blocks.
    pub fn raise_bounds(&self, context: &FrameContext, tile: u32, nearest: &mut [f32]) {
        let [width, height] = context.size();
        let own = context.grid.rect(tile, [width, height]);
        let across = blocks_across(&context.grid);
        let mut raise = |rect: PixelRect, depth: f32| {
            let rect = rect.intersect(own);
            if rect.is_empty() {
                return;
            }
            let blocks = |first: i32, last: i32, origin: i32| {
                ((first - origin) >> BLOCK_BITS) as usize..((last - origin) >> BLOCK_BITS) as usize + 1
            };
            for row in blocks(rect.y0, rect.y1, own.y0) {
                for old in &mut nearest[row * across..][blocks(rect.x0, rect.x1, own.x0)] {
                    // 0 is where nothing is drawn.
                    *old = old.max(depth).max(f32::MIN_POSITIVE);
                }
            }
        };
        for bins in &self.bins {
            bins.clusters_in(tile).iter().for_each(|cluster| raise(cluster.pixels(), cluster.nearest));
            for triangle in bins.triangles_in(tile) {
                if let Some(rect) = triangle.pixels(context.cells.origin, width, height) {
                    raise(rect, triangle.d.into_iter().fold(0.0, f32::max));
                }
            }
        }
    }

    /// The counts of binning.
    pub fn counts(&self, grid: &TileGrid) -> BinningCounts {
        let sum = |count: fn(&Bins) -> u64| self.bins.iter().map(count).sum::<u64>();
        let (triangles, triangle_entries) = (sum(Bins::triangles), sum(Bins::triangle_entries));
        let (clusters, cluster_entries) = (sum(Bins::clusters), sum(Bins::cluster_entries));
        let (mut tiles_used, mut largest_tile) = (0, 0);
        for tile in 0..grid.count() as u32 {
            let fill = self.bins.iter().map(|bins| bins.fill(tile)).sum::<u64>();
            tiles_used += u64::from(fill > 0);
            largest_tile = largest_tile.max(fill);
        }
        BinningCounts {
            triangles,
            entries: triangle_entries,
            overlap: ratio(triangle_entries, triangles),
            clusters,
            cluster_entries,
            cluster_overlap: ratio(cluster_entries, clusters),
            tiles: grid.count() as u64,
            tiles_used,
            largest_tile,
            bytes: sum(Bins::bytes),
        }
    }

    /// Appends the bins of some tiles as bytes, for the rank that draws these tiles of the same frame. Its machine must
    /// have the same byte order. `numbering` is memory that is reused from message to message of the same bins.
    ///
    /// The bytes are a header, the headers of the tiles that have entries, all triangles, then by tile the indices of
    /// its triangles, then by tile its clusters. There are no bytes at all if none of the tiles has entries.
    ///
    /// # Panics
    /// If there are 2^32 entries or more.
    pub fn write_bytes(&self, grid: &TileGrid, tiles: &[u32], numbering: &mut Numbering, out: &mut Vec<u8>) {
        numbering.begin(&self.bins);
        let (mut heads, mut triangles) = (Vec::<TileHead>::new(), Vec::<ScreenTriangle>::new());
        let (mut entries, mut clusters) = (Vec::<u32>::new(), Vec::<BinnedCluster>::new());
        for &tile in tiles {
            let before = (entries.len(), clusters.len());
            for (bins, numbers) in self.bins.iter().zip(&mut numbering.of_bins) {
                for &number in bins.triangle_lists.tile(tile) {
                    let (message, own) = &mut numbers[number as usize];
                    if *message != numbering.message {
                        (*message, *own) = (numbering.message, triangles.len() as u32);
                        triangles.push(bins.triangles[number as usize]);
                    }
                    entries.push(*own);
                }
                clusters.extend(bins.clusters_in(tile));
            }
            let (triangles, clusters) = (entries.len() - before.0, clusters.len() - before.1);
            if triangles + clusters > 0 {
                heads.push(TileHead { tile, triangles: triangles as u32, clusters: clusters as u32 });
            }
        }
        if heads.is_empty() {
            return;
        }
        let count = |length: usize| u32::try_from(length).expect("fewer than 2^32 entries");
        let head = Head {
            shift: grid.shift,
            columns: grid.columns,
            rows: grid.rows,
            first_row: grid.first_row,
            halo: grid.halo,
            tiles: count(heads.len()),
            triangles: count(triangles.len()),
            triangle_entries: count(entries.len()),
            cluster_entries: count(clusters.len()),
        };
        out.extend_from_slice(bytemuck::bytes_of(&head));
        out.extend_from_slice(cast_slice(&heads));
        out.extend_from_slice(cast_slice(&triangles));
        out.extend_from_slice(cast_slice(&entries));
        out.extend_from_slice(cast_slice(&clusters));
    }

    /// Adds bins from messages of [`Sorted::write_bytes`]. Tiles that are not drawn with the frame's settings are
    /// skipped.
    ///
    /// # Errors
    /// The number of the first message that is not valid, and why; nothing is added then.
    pub fn read_bytes<'m>(
        &mut self,
        context: &FrameContext,
        messages: impl IntoIterator<Item = &'m [u8]>,
    ) -> Result<(), (usize, SortedError)> {
        // One for all messages: each has tables of all tiles.
        let mut bins = Bins::default();
        for (number, bytes) in messages.into_iter().enumerate().filter(|(_, bytes)| !bytes.is_empty()) {
            read_into(&mut bins, context, bytes).map_err(|error| (number, error))?;
        }
        bins.sort(&context.grid);
        self.bins.push(bins);
        Ok(())
    }
}

/// Which triangles a message has already: memory for [`Sorted::write_bytes`].
#[derive(Debug, Default)]
pub struct Numbering {
    /// The number of the message.
    message: u32,
    /// For each triangle of each of the bins, the last message that it is in, and its number there.
    of_bins: Vec<Vec<(u32, u32)>>,
}

impl Numbering {
    /// Begins a message from these bins.
    fn begin(&mut self, bins: &[Bins]) {
        let fits = self.of_bins.len() == bins.len()
            && self.of_bins.iter().zip(bins).all(|(numbers, bins)| numbers.len() == bins.triangles.len());
        if !fits || self.message == u32::MAX {
            self.message = 0;
            self.of_bins = bins.iter().map(|bins| vec![(0, 0); bins.triangles.len()]).collect();
        }
        self.message += 1;
    }
}

/// Adds the entries of a message, which are not sorted yet.
fn read_into(bins: &mut Bins, context: &FrameContext, bytes: &[u8]) -> Result<(), SortedError> {
    let length = SortedError::Length { bytes: bytes.len() };
    let mut rest = bytes;
    let head: Head = pod_read_unaligned(take(&mut rest, size_of::<Head>(), 1).ok_or(length)?);
    let grid = &context.grid;
    if (head.shift, head.columns, head.rows) != (grid.shift, grid.columns, grid.rows) {
        let (found, expected) = ([head.columns, head.rows], [grid.columns, grid.rows]);
        return Err(SortedError::Grid { found, expected, shift: head.shift });
    }
    let tiles = elements::<TileHead>(&mut rest, head.tiles).ok_or(length)?;
    let triangles = elements::<ScreenTriangle>(&mut rest, head.triangles).ok_or(length)?;
    let entries = elements::<u32>(&mut rest, head.triangle_entries).ok_or(length)?;
    let clusters = elements::<BinnedCluster>(&mut rest, head.cluster_entries).ok_or(length)?;
    let sum = |of: fn(&TileHead) -> u32| tiles.iter().map(|tile| u64::from(of(tile))).sum::<u64>();
    if !rest.is_empty()
        || sum(|tile| tile.triangles) != u64::from(head.triangle_entries)
        || sum(|tile| tile.clusters) != u64::from(head.cluster_entries)
    {
        return Err(length);
    }
    let number = |what, number| SortedError::Number { what, number };
    if let Some(t) = triangles.iter().find(|t| !context.has_slot(t.slot) || !t.is_in_range()) {
        return Err(number("triangle", t.slot));
    }
    if let Some(c) = clusters.iter().find(|c| c.number >= context.clusters()) {
        return Err(number("cluster", c.number));
    }
    if let Some(&entry) = entries.iter().find(|&&entry| entry >= head.triangles) {
        return Err(number("triangle", entry));
    }
    if let Some(tile) = tiles.iter().find(|tile| tile.tile as usize >= grid.count()) {
        return Err(number("tile", tile.tile));
    }
    // Those of earlier messages come first.
    let first = u32::try_from(bins.triangles.len()).map_err(|_| length)?;
    first.checked_add(head.triangles).ok_or(length)?;
    bins.triangles.extend(triangles);
    bins.clusters += u64::from(head.cluster_entries);
    let (mut entries, mut clusters) = (entries.into_iter(), clusters.into_iter());
    for tile in tiles {
        for entry in entries.by_ref().take(tile.triangles as usize) {
            bins.triangle_lists.push(grid, tile.tile, first + entry);
        }
        for cluster in clusters.by_ref().take(tile.clusters as usize) {
            bins.cluster_lists.push(grid, tile.tile, cluster);
        }
    }
    Ok(())
}

/// Takes the first `count` elements of `bytes` bytes each; `None` if there are fewer.
fn take<'a>(rest: &mut &'a [u8], bytes: usize, count: u32) -> Option<&'a [u8]> {
    let (first, behind) = rest.split_at_checked(bytes.checked_mul(count as usize)?)?;
    *rest = behind;
    Some(first)
}

/// Reads `count` elements, of any alignment.
fn elements<T: Pod>(rest: &mut &[u8], count: u32) -> Option<Vec<T>> {
    let bytes = take(rest, size_of::<T>(), count)?;
    Some(bytes.chunks_exact(size_of::<T>()).map(pod_read_unaligned).collect())
}

impl ScreenTriangle {
    /// Are the coordinates in the range that clipping guarantees, so that differences do not overflow, and does the
    /// triangle have area?
    fn is_in_range(&self) -> bool {
        const MOST: i32 = 1 << 24;
        self.x.iter().chain(&self.y).all(|c| (-MOST..=MOST).contains(c)) && self.area() != 0
    }
}
