//! The sieve: drops the triangles of a cluster whose bounding boxes contain no sample of a tile, and sorts the others
//! by the number of pixels whose samples they may contain.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, i32x16, u8x64, u16x32, u32x16};
use tercio_mesh::cluster::MAX_TRIANGLES;

use crate::conventions::{SUBPIXEL_BITS, SUBPIXELS};
use crate::projection::{CornerTable, LocalVertices, ScreenTriangles};
use crate::screen::PixelRect;
use crate::settings::Cull;
use crate::simd::{BYTE_LANES, LANES, append_numbers, each3, live_lanes, part, splat_i};

/// The criteria for triangles to be kept.
#[derive(Clone, Copy, Debug)]
pub struct Keep {
    /// The pixels of which a triangle must reach a sample.
    pub rect: PixelRect,
    /// Smallest distance of a pixel's samples from its borders, in sub-pixels.
    pub origin: i32,
    /// Face culling.
    pub cull: Cull,
    /// Whether the instance is a mirror image.
    pub mirrored: bool,
}

/// Size class of a triangle, by the pixels inside the tile whose samples its bounding box may contain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Size {
    /// At most 2 across and down.
    Tiny,
    /// At most 4 across and down; also those of at most 2 that fill its last vector.
    Small,
    /// At most 8 across.
    Medium,
    /// At most 16 across.
    Large,
    /// More, or a triangle too large for edge functions of 32 bits, however few of its pixels are in the tile.
    Huge,
}

impl Size {
    /// All, smallest first.
    pub const ALL: [Self; 5] = [Self::Tiny, Self::Small, Self::Medium, Self::Large, Self::Huge];

    /// The largest number of pixels across, if it is limited.
    pub const fn max_across(self) -> Option<i32> {
        match self {
            Self::Tiny => Some(2),
            Self::Small => Some(4),
            Self::Medium => Some(8),
            Self::Large => Some(16),
            Self::Huge => None,
        }
    }

    /// The largest number of pixels down, if it is limited.
    pub const fn max_down(self) -> Option<i32> {
        match self {
            Self::Tiny | Self::Small => self.max_across(),
            Self::Medium | Self::Large | Self::Huge => None,
        }
    }
}

/// Per vertex of a cluster, the bounds of the pixels next to it, as bytes: a bound for 64 vertices or triangles fits
/// into one register.
///
/// Columns and rows of pixels are counted from the first sample of the tile, and bounds outside the tile are clamped
/// to its border. Clamping preserves the order of bounds, so the bounds of a triangle inside the tile are the smallest
/// and the largest of its corners' bounds.
struct Reach<S: Simd> {
    /// First column of pixels with samples at or right of each vertex, and first row with samples at or below it.
    first: [u8x64<S>; 2],
    /// First column of pixels whose samples are all right of each vertex, and first row of those all below it.
    end: [u8x64<S>; 2],
}

impl<S: Simd> Reach<S> {
    /// The bounds within the pixels to keep, at most 130 across and down.
    #[inline(always)]
    fn new(simd: S, vertices: &LocalVertices, keep: &Keep) -> Self {
        part(
            simd,
            #[inline(always)]
            || {
                let local = vertices.to_local(keep.rect);
                let offset = [-(local.x0 << SUBPIXEL_BITS), -(local.y0 << SUBPIXEL_BITS)];
                let (to_first, to_end) = (keep.origin - 1, SUBPIXELS - keep.origin);
                let first = whole_pixels(simd, vertices, [offset[0] + to_first, offset[1] + to_first]);
                let end = whole_pixels(simd, vertices, [offset[0] + to_end, offset[1] + to_end]);
                let across = u8x64::splat(simd, (local.x1 - local.x0 + 1) as u8);
                let down = u8x64::splat(simd, (local.y1 - local.y0 + 1) as u8);
                Self {
                    first: [first[0].min(across), first[1].min(down)],
                    end: [end[0].min(across), end[1].min(down)],
                }
            },
        )
    }

    /// Number of columns and rows of pixels with samples in the bounding boxes of 64 triangles.
    #[inline(always)]
    fn samples(&self, corners: &[u8x64<S>; 3]) -> [u8x64<S>; 2] {
        [self.samples_along(0, corners), self.samples_along(1, corners)]
    }

    #[inline(always)]
    fn samples_along(&self, axis: usize, corners: &[u8x64<S>; 3]) -> u8x64<S> {
        let (first, end) = (self.first[axis], self.end[axis]);
        let first = each3!(K => first.swizzle_dyn(corners[K]));
        let end = each3!(K => end.swizzle_dyn(corners[K]));
        end[0].max(end[1]).max(end[2]).saturating_sub(first[0].min(first[1]).min(first[2]))
    }
}

/// Coordinates of a cluster's vertices plus `offset` sub-pixels, in whole pixels clamped to 0 to 255: x, y.
#[inline(always)]
fn whole_pixels<S: Simd>(simd: S, vertices: &LocalVertices, offset: [i32; 2]) -> [u8x64<S>; 2] {
    let both = |x: i32, y: i32| (x.clamp(0, 0xffff) | y.clamp(0, 0xffff) << 16) as u32;
    let more: u16x32<S> = u32x16::splat(simd, both(offset[0], offset[1])).bitcast();
    let less: u16x32<S> = u32x16::splat(simd, both(-offset[0], -offset[1])).bitcast();
    let [a, b, c, d] = vertices.packed(simd);
    let a = a.saturating_add(more).saturating_sub(less).bitcast::<u8x64<S>>();
    let b = b.saturating_add(more).saturating_sub(less).bitcast::<u8x64<S>>();
    let c = c.saturating_add(more).saturating_sub(less).bitcast::<u8x64<S>>();
    let d = d.saturating_add(more).saturating_sub(less).bitcast::<u8x64<S>>();
    // The upper byte of 16 bits is the whole pixel. Bytes of x and y are interleaved.
    let (ab, cd) = (a.unzip_high(b), c.unzip_high(d));
    [ab.unzip_low(cd), ab.unzip_high(cd)]
}

/// The triangles of a cluster to draw, as numbers in the cluster, in one list per size.
#[derive(Debug)]
pub struct Sieve {
    numbers: [List; Size::ALL.len()],
    counts: [usize; Size::ALL.len()],
}

/// Numbers of triangles, with the padding that [`append_numbers`] requires.
type List = [u8; MAX_TRIANGLES + BYTE_LANES];

impl Default for Sieve {
    fn default() -> Self {
        Self { numbers: [[0; MAX_TRIANGLES + BYTE_LANES]; Size::ALL.len()], counts: [0; Size::ALL.len()] }
    }
}

impl Sieve {
    /// Sorts the first `count` triangles of a cluster.
    #[inline(always)]
    pub fn sort<S: Simd>(
        &mut self,
        simd: S,
        vertices: &LocalVertices,
        corners: &CornerTable,
        count: usize,
        keep: &Keep,
    ) {
        self.counts = [0; Size::ALL.len()];
        let reach = Reach::new(simd, vertices, keep);
        let by_area = vertices.is_wide || !matches!(keep.cull, Cull::Auto | Cull::None);
        let (mut reached, mut count_reached) = ([0; MAX_TRIANGLES + BYTE_LANES], 0);
        let mut first = 0;
        while first < count.min(MAX_TRIANGLES) {
            part(
                simd,
                #[inline(always)]
                || {
                    let [across, down] = reach.samples(&corners.of_64(simd, first));
                    let left = count - first;
                    let live = if left >= BYTE_LANES { u64::MAX } else { (1 << left) - 1 };
                    let mut hits = !across.min(down).simd_eq(0).to_bitmask() & live;
                    if by_area {
                        append_numbers(simd, &mut reached, count_reached, hits, first as u8);
                        count_reached += hits.count_ones() as usize;
                        return;
                    }
                    let most = across.max(down);
                    for size in Size::ALL {
                        if hits == 0 {
                            break;
                        }
                        let mut of_size = hits;
                        if let Some(limit) = size.max_across() {
                            let extent = if size.max_down().is_some() { most } else { across };
                            of_size &= extent.simd_le(limit as u8).to_bitmask();
                        }
                        self.add(simd, size, of_size, first);
                        hits &= !of_size;
                    }
                },
            );
            first += BYTE_LANES;
        }
        if by_area {
            self.sort_by_area(simd, vertices, corners, &reached, count_reached, keep);
        }
        self.join_rests();
    }

    /// Moves the last tiny triangles, which do not fill all lanes, to the small ones if these then fill as many vectors as
    /// before.
    #[inline(always)]
    fn join_rests(&mut self) {
        let [tiny, small] = [Size::Tiny, Size::Small].map(|size| self.counts[size as usize]);
        let rest = tiny % LANES;
        if small % LANES == 0 || rest + small % LANES > LANES {
            return;
        }
        let [of_tiny, of_small, ..] = &mut self.numbers;
        if let (Some(to), Some(from)) =
            (of_small[small..].first_chunk_mut::<LANES>(), of_tiny[tiny - rest..].first_chunk::<LANES>())
        {
            *to = *from;
        }
        self.counts[Size::Tiny as usize] -= rest;
        self.counts[Size::Small as usize] += rest;
    }

    /// Sorts the triangles that reach a sample, if they have to be tested by area: drops those that show the culled
    /// side, and finds those too large for edge functions of 32 bits. Not inlined, because few clusters need it.
    #[cold]
    #[inline(never)]
    fn sort_by_area<S: Simd>(
        &mut self,
        simd: S,
        vertices: &LocalVertices,
        corners: &CornerTable,
        reached: &List,
        count: usize,
        keep: &Keep,
    ) {
        simd.vectorize(
            #[inline(always)]
            || {
                let rect = vertices.to_local(keep.rect);
                let (chunks, _) = reached.as_chunks::<LANES>();
                for (numbers, first) in chunks.iter().zip((0..count).step_by(LANES)) {
                    let corners = corners.look_up(simd, numbers);
                    let coordinates = vertices.coordinates(simd, &corners);
                    let t = ScreenTriangles::new(simd, coordinates, keep.origin, rect);
                    part(
                        simd,
                        #[inline(always)]
                        || {
                            let live = live_lanes(count - first);
                            let huge = t.large(simd) & live;
                            let mut kept = live;
                            if !matches!(keep.cull, Cull::Auto | Cull::None) {
                                let (area, zero) = (t.area(), splat_i(simd, 0));
                                let sides = sides_of(&t, huge);
                                let clockwise = area.simd_gt(zero).to_bitmask() as u32 & live & !huge;
                                let counter = area.simd_lt(zero).to_bitmask() as u32 & live & !huge;
                                (kept, _) =
                                    keep.cull.split(keep.mirrored, clockwise | sides[0], counter | sides[1]);
                            }
                            let (across, down) = (t.columns[1] - t.columns[0], t.rows[1] - t.rows[0]);
                            let mut left = kept & !huge;
                            for size in Size::ALL {
                                let mut of_size = left;
                                if let Some(max) = size.max_across() {
                                    of_size &= across.simd_lt(splat_i(simd, max)).to_bitmask() as u32;
                                }
                                if let Some(max) = size.max_down() {
                                    of_size &= down.simd_lt(splat_i(simd, max)).to_bitmask() as u32;
                                }
                                if size == Size::Huge {
                                    of_size |= kept & huge;
                                }
                                self.add_some(size, of_size, numbers);
                                left &= !of_size;
                            }
                        },
                    );
                }
            },
        );
    }

    /// Adds triangles to a list: bit 0 is triangle `first` of the cluster.
    #[inline(always)]
    fn add<S: Simd>(&mut self, simd: S, size: Size, bits: u64, first: usize) {
        let count = &mut self.counts[size as usize];
        append_numbers(simd, &mut self.numbers[size as usize], *count, bits, first as u8);
        *count += bits.count_ones() as usize;
    }

    /// Adds the triangles in some lanes to a list.
    #[inline(always)]
    fn add_some(&mut self, size: Size, mut lanes: u32, numbers: &[u8; LANES]) {
        let count = &mut self.counts[size as usize];
        while lanes != 0 {
            self.numbers[size as usize][*count] = numbers[lanes.trailing_zeros() as usize % LANES];
            *count += 1;
            lanes &= lanes - 1;
        }
    }

    /// Number of triangles to draw.
    pub fn len(&self) -> u64 {
        self.counts.iter().sum::<usize>() as u64
    }

    /// Triangles of one size, 16 at a time, each with the mask of the lanes in use; other lanes have arbitrary values.
    #[inline(always)]
    pub fn of_size(&self, size: Size) -> impl Iterator<Item = (&[u8; LANES], u32)> {
        let count = self.counts[size as usize];
        let (chunks, _) = self.numbers[size as usize].as_chunks::<LANES>();
        chunks.iter().zip((0..count).step_by(LANES)).map(move |(chunk, first)| {
            let lanes = live_lanes(count - first);
            (chunk, lanes)
        })
    }
}

/// Of some lanes, the masks of clockwise and of counter-clockwise triangles, computed with areas of 64 bits.
#[cold]
#[inline(never)]
fn sides_of<S: Simd>(t: &ScreenTriangles<S>, lanes: u32) -> [u32; 2] {
    let mut sides = [0; 2];
    for lane in (0..LANES).filter(|lane| lanes >> lane & 1 == 1) {
        let along = |v: &[i32x16<S>; 3], k: usize| i64::from(v[k][lane] - v[0][lane]);
        let area = along(&t.x, 1) * along(&t.y, 2) - along(&t.x, 2) * along(&t.y, 1);
        sides[0] |= u32::from(area > 0) << lane;
        sides[1] |= u32::from(area < 0) << lane;
    }
    sides
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The last tiny triangles become small ones where these need no more vectors for them.
    #[test]
    fn rests_are_joined_where_that_saves_a_vector() {
        for (tiny, small, joined) in [
            (3, 13, true),
            (3, 14, false),
            (16, 1, true),
            (3, 16, false),
            (3, 0, false),
            (20, 12, true),
            (20, 29, false),
        ] {
            let mut sieve = Sieve::default();
            let mut expected: Vec<u8> = (0..tiny + small).collect();
            for number in 0..tiny + small {
                let size = if number < tiny { Size::Tiny } else { Size::Small };
                sieve.add_some(size, 1, &[number; LANES]);
            }
            sieve.join_rests();
            let rest = if joined { tiny % LANES as u8 } else { 0 };
            let of = |size: Size| -> Vec<u8> {
                let vectors = sieve.of_size(size);
                vectors.flat_map(|(numbers, lanes)| numbers[..lanes.count_ones() as usize].to_vec()).collect()
            };
            let (of_tiny, of_small) = (of(Size::Tiny), of(Size::Small));
            assert_eq!(
                [of_tiny.len(), of_small.len()],
                [tiny - rest, small + rest].map(usize::from),
                "{tiny}, {small}"
            );
            let mut all = [of_tiny, of_small].concat();
            all.sort_unstable();
            expected.sort_unstable();
            assert_eq!(all, expected);
        }
    }
}
