//! Which triangles of a cluster reach a sample of a tile, and how many.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, i32x16, u8x16};
use tercio_mesh::cluster::MAX_TRIANGLES;

use crate::binning::PixelRect;
use crate::frontend::transform::{CornerTable, LocalVertices, ScreenTriangles};
use crate::settings::Cull;
use crate::simd::{LANES, append_bytes, live_lanes, part, splat_i};

/// Number of each lane.
const NUMBERS: [u8; LANES] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15];

/// Which triangles are kept.
#[derive(Clone, Copy, Debug)]
pub struct Keep {
    /// Those that reach a sample of these pixels,
    pub rect: PixelRect,
    /// and are not left out by their facing,
    pub cull: Cull,
    /// in an instance that is a mirror image.
    pub mirrored: bool,
}

/// How many samples the bounding box of a triangle holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Size {
    /// At most 2 across and down.
    Tiny,
    /// At most 4 across and down.
    Small,
    /// At most 8 across.
    Medium,
    /// At most 16 across.
    Large,
    /// More, or more than edge functions of 32 bits serve, whatever samples of it the tile holds.
    Huge,
}

impl Size {
    /// All, smallest first.
    pub const ALL: [Self; 5] = [Self::Tiny, Self::Small, Self::Medium, Self::Large, Self::Huge];

    /// The most samples across; none for the last.
    pub const fn most_across(self) -> Option<i32> {
        match self {
            Self::Tiny => Some(2),
            Self::Small => Some(4),
            Self::Medium => Some(8),
            Self::Large => Some(16),
            Self::Huge => None,
        }
    }

    /// The most samples down, where it matters.
    pub const fn most_down(self) -> Option<i32> {
        match self {
            Self::Tiny | Self::Small => self.most_across(),
            Self::Medium | Self::Large | Self::Huge => None,
        }
    }
}

/// The triangles of a cluster that are drawn, by their number in it, in lists by size.
#[derive(Debug)]
pub struct Sieve {
    numbers: [[u8; MAX_TRIANGLES + LANES]; Size::ALL.len()],
    counts: [usize; Size::ALL.len()],
}

impl Default for Sieve {
    fn default() -> Self {
        Self { numbers: [[0; MAX_TRIANGLES + LANES]; Size::ALL.len()], counts: [0; Size::ALL.len()] }
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
        let rect = vertices.see(keep.rect);
        let mut first = 0;
        while first < count.min(MAX_TRIANGLES) {
            let live = live_lanes(count - first);
            let t = ScreenTriangles::new(simd, vertices.coordinates(simd, &corners.of_16(first)), rect);
            part(
                simd,
                #[inline(always)]
                || {
                    let (area, zero) = (t.area(), splat_i(simd, 0));
                    let hits = t.hits() & live;
                    let mut clockwise = area.simd_gt(zero).to_bitmask() as u32 & hits;
                    let mut counter = area.simd_lt(zero).to_bitmask() as u32 & hits;
                    let mut huge = 0;
                    if vertices.is_wide {
                        huge = t.large(simd) & hits;
                        let sides = sides_of(&t, huge);
                        clockwise = clockwise & !huge | sides[0];
                        counter = counter & !huge | sides[1];
                    }
                    let (kept, _) = keep.cull.split(keep.mirrored, clockwise, counter);
                    let numbers = u8x16::load_array(simd, NUMBERS) + first as u8;
                    let (across, down) = (t.columns[1] - t.columns[0], t.rows[1] - t.rows[0]);
                    let mut left = kept & !huge;
                    for size in Size::ALL {
                        let mut of_size = left;
                        if let Some(most) = size.most_across() {
                            of_size &= across.simd_lt(splat_i(simd, most)).to_bitmask() as u32;
                        }
                        if let Some(most) = size.most_down() {
                            of_size &= down.simd_lt(splat_i(simd, most)).to_bitmask() as u32;
                        }
                        if size == Size::Huge {
                            of_size |= kept & huge;
                        }
                        self.add(simd, size, of_size, numbers);
                        left &= !of_size;
                    }
                },
            );
            first += LANES;
        }
    }

    /// Adds the triangles of some lanes to a list.
    #[inline(always)]
    fn add<S: Simd>(&mut self, simd: S, size: Size, lanes: u32, numbers: u8x16<S>) {
        let count = &mut self.counts[size as usize];
        append_bytes(simd, &mut self.numbers[size as usize], *count, lanes, numbers);
        *count += lanes.count_ones() as usize;
    }

    /// Triangles that are drawn.
    pub fn len(&self) -> u64 {
        self.counts.iter().sum::<usize>() as u64
    }

    /// Triangles of one size, 16 at a time, with the lanes that hold one; the others hold some other triangle.
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

/// Of some lanes, those whose triangle appears clockwise and those where it appears counter-clockwise, from areas of
/// 64 bits.
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
