//! The tile memory: depth and slot buffers of a tile while it is drawn.
//!
//! Samples are stored row by row. Triangles are tested in stamps of 16 samples, with one vector operation each: one row
//! of 16 or two rows of 8, beginning at any column.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8, f32x16, i32x16, mask32x16, u32x4, u32x8, u32x16};

use tercio_mesh::cluster::MAX_TRIANGLES;

use super::cluster::prefetch_primitives;
use crate::context::{FrameContext, NO_SLOT};
use crate::frame::{Planes, key_and_tie, visibility_key, wide_key};
use crate::screen::PixelRect;
use crate::simd::{LANE_NUMBERS, LANES, part, splat, splat_i};

/// Depth and slot of every sample of a tile.
///
/// A sample's index (its place) is its row times [`TileMemory::stride`] plus its column. There are a few rows more than
/// in the tile, because stamps of two rows may begin in the last row.
#[derive(Debug, Default)]
pub struct TileMemory {
    /// Depth, 0 where nothing was drawn.
    pub depth: Vec<f32>,
    /// Slot, [`NO_SLOT`] where nothing was drawn.
    pub slot: Vec<u32>,
    /// One bit per sample, 16 per element: its pixel is shaded already.
    pub shaded: Vec<u16>,
    /// First column and row of pixels of the tile.
    pub corner: [i32; 2],
    /// Last column and row of pixels inside the picture.
    pub last: [i32; 2],
    /// [`stride_bits`].
    stride_bits: u32,
}

/// log2 of the stride of the rows of a tile: the tile's edge, but at least the width of a stamp.
pub fn stride_bits(context: &FrameContext) -> u32 {
    context.grid.shift.max(LANES.trailing_zeros())
}

/// Column of each lane in a stamp with rows of this width.
#[inline(always)]
pub fn lane_columns<S: Simd, const WIDTH: usize>(simd: S) -> i32x16<S> {
    i32x16::load_array(simd, LANE_NUMBERS) & (WIDTH as i32 - 1)
}

/// Row of each lane in a stamp with rows of this width.
#[inline(always)]
pub fn lane_rows<S: Simd, const WIDTH: usize>(simd: S) -> i32x16<S> {
    i32x16::load_array(simd, LANE_NUMBERS) >> WIDTH.trailing_zeros()
}

impl TileMemory {
    /// Resizes and clears the memory for a tile.
    pub fn clear(&mut self, context: &FrameContext, tile: u32) {
        let (x, y) = context.grid.corner(tile);
        let edge = 1usize << context.grid.shift;
        self.corner = [x as i32, y as i32];
        self.last = [
            (x as i32 + edge as i32).min(context.view.width as i32) - 1,
            (y as i32 + edge as i32).min(context.view.height as i32) - 1,
        ];
        self.stride_bits = stride_bits(context);
        let places = (edge + 4) << self.stride_bits;
        self.depth.clear();
        self.depth.resize(places, 0.0);
        self.slot.clear();
        self.slot.resize(places, NO_SLOT);
        self.shaded.clear();
        self.shaded.resize(places / LANES, 0);
    }

    /// log2 of [`TileMemory::stride`].
    #[inline(always)]
    pub fn stride_bits(&self) -> u32 {
        self.stride_bits
    }

    /// Distance of two rows, in samples.
    #[inline(always)]
    pub fn stride(&self) -> usize {
        1 << self.stride_bits
    }

    /// The pixels of the tile that are inside the picture.
    #[inline(always)]
    pub fn rect(&self) -> PixelRect {
        PixelRect { x0: self.corner[0], x1: self.last[0], y0: self.corner[1], y1: self.last[1] }
    }

    /// The index of a sample, from its column and row.
    #[inline(always)]
    pub fn place(&self, column: i32, row: i32) -> usize {
        ((row as usize) << self.stride_bits) + column as usize
    }

    /// The indices of 16 samples.
    #[inline(always)]
    pub fn places<S: Simd>(&self, column: i32x16<S>, row: i32x16<S>) -> i32x16<S> {
        (row << self.stride_bits) + column
    }

    /// The sample indices of each block of 4x4 that begins inside the picture, row by row.
    #[inline(always)]
    pub fn blocks<S: Simd>(&self, simd: S) -> impl Iterator<Item = [i32; LANES]> {
        let lanes = self.places(lane_columns::<S, 4>(simd), lane_rows::<S, 4>(simd));
        let last = [0, 1].map(|k| (self.last[k] - self.corner[k]) / 4);
        let corners = (0..last[1] + 1).flat_map(move |y| (0..last[0] + 1).map(move |x| (4 * x, 4 * y)));
        corners.map(
            #[inline(always)]
            move |(column, row)| (lanes + self.place(column, row) as i32).to_array(),
        )
    }

    /// Slots of the block of 4x4 that begins at sample index `corner`.
    #[inline(always)]
    pub fn slots_of_block<S: Simd>(&self, simd: S, corner: i32) -> u32x16<S> {
        let row = |k: usize| {
            let place = corner as usize + k * self.stride();
            u32x4::from_slice(simd, &self.slot[place..place + 4])
        };
        row(0).combine(row(1)).combine(row(2).combine(row(3)))
    }

    /// Mask of the samples that are shaded already, in the block of 4x4 that begins at sample index `corner`.
    #[inline(always)]
    pub fn shaded_of_block(&self, corner: i32) -> u32 {
        let mut lanes = 0;
        for row in 0..4 {
            let place = corner as usize + row * self.stride();
            lanes |= (u32::from(self.shaded[place / LANES] >> (place % LANES)) & 15) << (4 * row);
        }
        lanes
    }

    /// The last column in which a stamp may begin.
    #[inline(always)]
    pub fn last_column_of_stamps<const WIDTH: usize>(&self) -> i32 {
        (self.stride() - WIDTH) as i32
    }

    /// Writes the visibility keys of the drawn pixels to the planes of keys and ties, each of which is either empty or has a pixel
    /// for each sample of the tile that is inside the picture, with the tile's stride.
    pub fn write_keys(&self, context: &FrameContext, pixels: &mut Planes) {
        if context.is_wide() {
            let Planes { keys, ties, .. } = pixels;
            self.each_primitive(context, keys.len().max(ties.len()), |place, depth, primitive| {
                let (key, tie) = key_and_tie(wide_key(depth, primitive), true);
                keys.get_mut(place).into_iter().for_each(|own| *own = key);
                ties.get_mut(place).into_iter().for_each(|own| *own = tie);
            });
        } else {
            let keys = &mut pixels.keys[..];
            self.each_primitive(context, keys.len(), |place, depth, primitive| {
                keys[place] = visibility_key(depth, primitive as u32);
            });
        }
    }

    /// Calls `put` with the place, the depth and the primitive number of each pixel that was drawn, of the first `places`.
    #[inline(always)]
    fn each_primitive(&self, context: &FrameContext, places: usize, mut put: impl FnMut(usize, f32, u64)) {
        let width = (self.last[0] - self.corner[0] + 1) as usize;
        // Neighbours are often of the same cluster.
        let (mut located, mut cluster) = (NO_SLOT, None);
        for row in 0..places / self.stride() {
            let first = row * self.stride();
            prefetch_primitives(context, self.slot[first..first + width].iter().copied());
            let samples = self.slot[first..first + width].iter().zip(&self.depth[first..first + width]);
            for (place, (&slot, &depth)) in (first..).zip(samples) {
                if slot == NO_SLOT {
                    continue;
                }
                let number = slot / MAX_TRIANGLES as u32;
                let (first_primitive, cluster) = match cluster {
                    Some(found) if number == located => found,
                    _ => {
                        let found = context.primitives_of(number);
                        (located, cluster) = (number, Some(found));
                        found
                    }
                };
                let primitive = first_primitive + u64::from(cluster.primitive(slot as usize % MAX_TRIANGLES));
                put(place, depth, primitive);
            }
        }
    }

    /// The samples, for writing.
    #[inline(always)]
    pub fn samples_mut(&mut self) -> Samples<'_> {
        Samples { stride: self.stride(), depth: &mut self.depth, slot: &mut self.slot }
    }

    /// Is every sample of a part of the tile nearer than this depth?
    #[inline(always)]
    pub fn all_nearer<S: Simd>(&self, simd: S, rect: PixelRect, depth: f32) -> bool {
        let (x0, x1) = (rect.x0 - self.corner[0], rect.x1 - self.corner[0]);
        let (y0, y1) = (rect.y0 - self.corner[1], rect.y1 - self.corner[1]);
        let depth = splat(simd, depth);
        let mut column = x0;
        while column <= x1 {
            let first = column.min(self.last_column_of_stamps::<LANES>());
            let columns = i32x16::load_array(simd, LANE_NUMBERS) + first;
            let inside = columns.simd_ge(splat_i(simd, column)) & columns.simd_le(splat_i(simd, x1));
            for row in y0..y1 + 1 {
                let place = self.place(first, row);
                let stamp = f32x16::from_slice(simd, &self.depth[place..place + LANES]);
                if (stamp.simd_le(depth) & inside).any_true() {
                    return false;
                }
            }
            column += LANES as i32;
        }
        true
    }

    /// Merges another memory of the same tile: the nearer samples win.
    pub fn merge(&mut self, context: &FrameContext, other: &Self) {
        for (place, (&depth, &slot)) in other.depth.iter().zip(&other.slot).enumerate() {
            let before = self.depth[place];
            let wins = depth > before
                || (slot != NO_SLOT && depth == before && lower_primitive(context, slot, self.slot[place]));
            if wins {
                self.depth[place] = depth;
                self.slot[place] = slot;
            }
        }
    }

    /// Marks the pixels of some samples as shaded.
    #[inline(always)]
    pub fn mark_shaded(&mut self, places: impl Iterator<Item = i32>) {
        for place in places {
            self.shaded[place as usize / LANES] |= 1 << (place as usize % LANES);
        }
    }

    /// Number of pixels that show a triangle.
    pub fn visible(&self) -> u64 {
        u64::from(self.slot.iter().map(|&slot| u32::from(slot != NO_SLOT)).sum::<u32>())
    }
}

/// The samples of a [`TileMemory`].
pub struct Samples<'a> {
    stride: usize,
    depth: &'a mut [f32],
    slot: &'a mut [u32],
}

impl Samples<'_> {
    /// Depth test and write of a stamp: keeps the nearer of old and new at the covered samples. Returns the mask of the
    /// samples that the new triangle won.
    #[inline(always)]
    pub fn write<S: Simd, const WIDTH: usize>(
        &mut self,
        simd: S,
        context: &FrameContext,
        place: usize,
        covered: mask32x16<S>,
        depth: f32x16<S>,
        slot: u32,
    ) -> u32 {
        part(
            simd,
            #[inline(always)]
            || {
                let stride = self.stride;
                // From its first sample to one past its last.
                let stamp = place..place + (LANES / WIDTH - 1) * stride + WIDTH;
                let old_depth = &mut self.depth[stamp.clone()];
                let old_slot = &mut self.slot[stamp];
                let before = load_depths::<S, WIDTH>(simd, old_depth, stride);
                let mut wins = covered & depth.simd_gt(before);
                let tie = covered & depth.simd_eq(before);
                if tie.any_true() {
                    let old = load_slots::<S, WIDTH>(simd, old_slot, stride);
                    let more = lower_primitives(context, tie.to_bitmask() as u32, slot, old.to_array());
                    wins |= mask32x16::from_bitmask(simd, u64::from(more));
                }
                store_depths::<S, WIDTH>(wins.select(depth, before), old_depth, stride);
                let before = load_slots::<S, WIDTH>(simd, old_slot, stride);
                let slots = wins.select(splat_i(simd, slot as i32), before);
                store_slots::<S, WIDTH>(slots, old_slot, stride);
                wins.to_bitmask() as u32 & 0xffff
            },
        )
    }
}

#[inline(always)]
fn load_depths<S: Simd, const WIDTH: usize>(simd: S, from: &[f32], stride: usize) -> f32x16<S> {
    if WIDTH == LANES {
        return f32x16::from_slice(simd, &from[..LANES]);
    }
    f32x8::from_slice(simd, &from[..8]).combine(f32x8::from_slice(simd, &from[stride..stride + 8]))
}

#[inline(always)]
fn store_depths<S: Simd, const WIDTH: usize>(depths: f32x16<S>, to: &mut [f32], stride: usize) {
    if WIDTH == LANES {
        return depths.store_slice(&mut to[..LANES]);
    }
    let (upper, lower) = depths.split();
    upper.store_slice(&mut to[..8]);
    lower.store_slice(&mut to[stride..stride + 8]);
}

#[inline(always)]
fn load_slots<S: Simd, const WIDTH: usize>(simd: S, from: &[u32], stride: usize) -> i32x16<S> {
    if WIDTH == LANES {
        return u32x16::from_slice(simd, &from[..LANES]).bitcast();
    }
    let both =
        u32x8::from_slice(simd, &from[..8]).combine(u32x8::from_slice(simd, &from[stride..stride + 8]));
    both.bitcast()
}

#[inline(always)]
fn store_slots<S: Simd, const WIDTH: usize>(slots: i32x16<S>, to: &mut [u32], stride: usize) {
    let slots: u32x16<S> = slots.bitcast();
    if WIDTH == LANES {
        return slots.store_slice(&mut to[..LANES]);
    }
    let (upper, lower) = slots.split();
    upper.store_slice(&mut to[..8]);
    lower.store_slice(&mut to[stride..stride + 8]);
}

/// Which of the lanes of equal depth `slot` wins because its primitive number is lower.
#[cold]
#[inline(never)]
fn lower_primitives(context: &FrameContext, ties: u32, slot: u32, old: [i32; LANES]) -> u32 {
    let mut wins = 0;
    for (lane, old) in old.into_iter().enumerate() {
        if ties >> lane & 1 == 1 && lower_primitive(context, slot, old as u32) {
            wins |= 1 << lane;
        }
    }
    wins
}

/// Does `slot` win over `old` at equal depth? It does if its primitive number is lower, or if `old` is [`NO_SLOT`].
#[cold]
#[inline(never)]
pub fn lower_primitive(context: &FrameContext, slot: u32, old: u32) -> bool {
    old == NO_SLOT || context.primitive(slot) < context.primitive(old)
}
