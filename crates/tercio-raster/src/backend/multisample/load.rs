//! Fragments as bytes: those of a tile memory, and a tile memory from those of several ranks.

use tercio_mesh::cluster::{ClusterView, MAX_TRIANGLES};

use super::finished::{FinishedBlocks, blocks_of};
use super::fragments::{Fragment, NO_FRAGMENT};
use super::memory::SampleMemory;
use super::shade::is_needed;
use crate::backend::cluster::prefetch_primitives;
use crate::context::FrameContext;
use crate::depth_bounds::BLOCK_BITS;
use crate::frame::fragments::{FragmentError, FragmentHead, FragmentsOfTile, TileFragment, write_fragment};
use crate::frame::{FragmentLayout, Outputs, wide_key};
use crate::sampling::MAX_SAMPLES;

/// The triangle of a fragment that another rank has drawn.
#[derive(Clone, Copy, Debug)]
pub struct Origin {
    /// Number of its primitive.
    pub primitive: u64,
    /// Number of its face, if that is requested.
    pub face: u32,
}

/// Pixels that are written one after the other: across a block.
const BLOCK: usize = 1 << BLOCK_BITS;

/// Writes the visible fragments of pixels.
struct Visible<'a> {
    context: &'a FrameContext<'a>,
    layout: FragmentLayout,
    /// What is not shaded has no colour: what is in the list is of an earlier tile.
    is_shaded: bool,
    /// The cluster of the last fragment, and the number of its instance's first primitive: neighbours are mostly of the same.
    known: Option<(u32, u64, ClusterView<'a>)>,
}

impl Visible<'_> {
    /// The number of the primitive in a slot.
    #[inline(always)]
    fn primitive(&mut self, slot: u32) -> u64 {
        let (number, triangle) = (slot / MAX_TRIANGLES as u32, slot as usize % MAX_TRIANGLES);
        let (first, cluster) = match &self.known {
            Some((known, first, cluster)) if *known == number => (*first, *cluster),
            _ => {
                let (first, cluster) = self.context.primitives_of(number);
                self.known = Some((number, first, cluster));
                (first, cluster)
            }
        };
        first + u64::from(cluster.primitive(triangle))
    }

    /// Writes the fragments of a pixel of N samples, and returns the number of bytes.
    #[inline(always)]
    fn write<const N: usize>(&mut self, memory: &SampleMemory, pixel: usize, out: &mut [u8]) -> usize {
        let first = pixel * N;
        let (Some(fragments), Some(depths)) =
            (memory.fragment[first..].first_chunk::<N>(), memory.depth[first..].first_chunk::<N>())
        else {
            unreachable!("the pixel is in memory")
        };
        let (mut done, mut at) = (0_u32, 0);
        for (sample, &number) in fragments.iter().enumerate() {
            if number == NO_FRAGMENT || done >> sample & 1 == 1 {
                continue;
            }
            let mask = (0..N).fold(0, |mask, s| mask | u32::from(fragments[s] == number) << s);
            done |= mask;
            let slot = memory.list.fragments[number as usize].slot;
            let color =
                if self.is_shaded { memory.list.colors[number as usize] } else { [0.0, 0.0, 0.0, 1.0] };
            let primitive = self.primitive(slot);
            let head =
                FragmentHead { primitive: primitive as u32, place: pixel as u16, mask: mask as u16, color };
            let normal = || memory.list.normals[number as usize];
            let face = || self.context.face(slot);
            at += write_fragment(
                self.layout,
                &head,
                primitive,
                normal,
                face,
                |sample| depths[sample % N],
                &mut out[at..],
            );
        }
        at
    }
}

impl SampleMemory {
    /// Number of the primitive in a slot.
    pub fn primitive(&self, context: &FrameContext, slot: u32) -> u64 {
        let origin = self.origins.get(slot as usize);
        origin.map_or_else(|| context.primitive(slot), |origin| origin.primitive)
    }

    /// Appends the opaque fragments that are visible, which are shaded, as bytes ([`crate::frame::fragments`]), but for those of
    /// finished blocks.
    pub fn write_bytes(
        &self,
        context: &FrameContext,
        outputs: &Outputs,
        finished: &FinishedBlocks,
        out: &mut Vec<u8>,
    ) {
        let layout = context.fragment_layout(outputs);
        let mut visible = Visible { context, layout, is_shaded: is_needed(outputs), known: None };
        // Each sample may be a fragment of its own.
        let most = BLOCK * (layout.bytes(1) << self.count_bits);
        for row in 0..(self.rect.y1 - self.rect.y0 + 1) as usize {
            let first = row << self.stride_bits;
            let pixels = first..first + (self.rect.x1 - self.rect.x0 + 1) as usize;
            for some in pixels.clone().step_by(BLOCK) {
                let some = some..(some + BLOCK).min(pixels.end);
                if finished.contains([some.start - first, row]) {
                    continue;
                }
                let samples = &self.fragment[some.start << self.count_bits..some.end << self.count_bits];
                // Most of a picture that a rank has drawn alone is empty.
                if samples.iter().fold(NO_FRAGMENT, |all, f| all & f) == NO_FRAGMENT {
                    continue;
                }
                let drawn = samples.iter().filter(|&&number| number != NO_FRAGMENT);
                prefetch_primitives(context, drawn.map(|&number| self.list.fragments[number as usize].slot));
                let mut at = out.len();
                out.resize(at + most, 0);
                for pixel in some {
                    at += match self.count_bits {
                        0 => visible.write::<1>(self, pixel, &mut out[at..]),
                        1 => visible.write::<2>(self, pixel, &mut out[at..]),
                        2 => visible.write::<4>(self, pixel, &mut out[at..]),
                        3 => visible.write::<8>(self, pixel, &mut out[at..]),
                        _ => visible.write::<16>(self, pixel, &mut out[at..]),
                    };
                }
                out.truncate(at);
            }
        }
    }

    /// Sets the memory to what all fragments of a tile amount to, except that layers are not blended yet.
    ///
    /// # Errors
    /// [`FragmentError`].
    pub fn load(&mut self, context: &FrameContext, of: &FragmentsOfTile) -> Result<(), FragmentError> {
        let (tile, tiles) = (of.tile, context.grid.count());
        if tile as usize >= tiles {
            return Err(FragmentError::Tile { tile, tiles });
        }
        self.clear(context, tile);
        let outputs = &context.settings.outputs;
        let layout = context.fragment_layout(outputs);
        let read = |part: usize, at: usize| {
            let read = TileFragment::read(layout, &of.parts[part][at..]);
            read.ok_or(FragmentError::Short { tile, at })
        };
        // Layers follow, once it is known what is opaque: there may be many, so only their places are noted.
        let mut layers = Vec::new();
        let mut finished = Vec::new();
        for (part, bytes) in of.parts.iter().enumerate() {
            let mut at = 0;
            while at < bytes.len() {
                let (fragment, behind) = read(part, at)?;
                let FragmentHead { place, mask, .. } = fragment.head;
                if mask == 0 {
                    let known = blocks_of(context, &fragment.head).filter(|_| !context.is_translucent());
                    finished.push(known.ok_or(FragmentError::Blocks { tile, at, first: place })?);
                } else if !self.has_samples(place, mask) {
                    return Err(FragmentError::Place { tile, at, place, mask });
                } else if fragment.is_opaque() {
                    self.add(outputs, &fragment);
                } else if context.is_translucent() {
                    layers.push((part, at));
                } else {
                    return Err(FragmentError::Translucent { tile, at });
                }
                at = bytes.len() - behind.len();
            }
        }
        finished.into_iter().flatten().for_each(|number| self.clear_block(context, number));
        for (part, at) in layers {
            self.add_layer(context, &read(part, at)?.0);
        }
        let list = &mut self.layers.list;
        list.late = list.count;
        Ok(())
    }

    /// Does a pixel in memory have these samples?
    fn has_samples(&self, place: u16, mask: u16) -> bool {
        let (row, column) =
            (i32::from(place) >> self.stride_bits, i32::from(place) & ((1 << self.stride_bits) - 1));
        let is_inside = row <= self.rect.y1 - self.rect.y0 && column <= self.rect.x1 - self.rect.x0;
        is_inside && u32::from(mask) >> (1 << self.count_bits) == 0
    }

    /// Adds an opaque fragment.
    #[inline(always)]
    fn add(&mut self, outputs: &Outputs, fragment: &TileFragment) {
        let (primitive, FragmentHead { place, mask, color, .. }) = (fragment.primitive, fragment.head);
        let number = self.list.count as u32;
        let mut is_visible = false;
        for (sample, new) in fragment.samples() {
            let index = (usize::from(place) << self.count_bits) + sample;
            let (before, old) = (self.depth[index], self.fragment[index]);
            let is_first = || old == NO_FRAGMENT || primitive < self.origin_of(old).primitive;
            if new > before || new == before && is_first() {
                (self.depth[index], self.fragment[index]) = (new, number);
                is_visible = true;
            }
        }
        if !is_visible {
            return;
        }
        let slot = self.origins.len() as u32;
        self.origins.push(Origin { primitive, face: fragment.face });
        let list = &mut self.list;
        if !list.has_room() {
            list.grow();
        }
        list.push(Fragment::new(slot, usize::from(place), u32::from(mask)));
        list.colors.resize(list.fragments.len().max(list.colors.len()), [0.0; 4]);
        list.colors[number as usize] = color;
        if outputs.normals {
            list.normals.resize(list.fragments.len().max(list.normals.len()), [0.0; 3]);
            list.normals[number as usize] = fragment.normal;
        }
    }

    /// Where an opaque fragment comes from.
    fn origin_of(&self, number: u32) -> Origin {
        self.origins[self.list.fragments[number as usize].slot as usize]
    }

    /// Adds a fragment that is not opaque, at the samples where nothing opaque is in front of it.
    fn add_layer(&mut self, context: &FrameContext, fragment: &TileFragment) {
        let (primitive, FragmentHead { place, mask, color, .. }) = (fragment.primitive, fragment.head);
        let mut depths = [0.0; MAX_SAMPLES];
        let mut visible = 0;
        for (sample, depth) in fragment.samples() {
            let index = (usize::from(place) << self.count_bits) + sample;
            let opaque = self.fragment[index];
            // A fragment of one sample has one depth, whichever sample it is.
            depths[if self.is_by_sample { 0 } else { sample }] = depth;
            let behind = match opaque {
                NO_FRAGMENT => 0,
                opaque => wide_key(self.depth[index], self.origin_of(opaque).primitive),
            };
            visible |= u32::from(wide_key(depth, primitive) > behind) << sample;
        }
        if visible == 0 {
            return;
        }
        let slot = self.origins.len() as u32;
        self.origins.push(Origin { primitive, face: fragment.face });
        let number = self.layers.list.count;
        let new = Fragment::new(slot, usize::from(place), u32::from(mask));
        self.layers.push(context, new, visible, &depths);
        let list = &mut self.layers.list;
        list.colors.resize(list.fragments.len().max(list.colors.len()), [0.0; 4]);
        list.colors[number] = color;
        if context.settings.outputs.normals {
            list.normals.resize(list.fragments.len().max(list.normals.len()), [0.0; 3]);
            list.normals[number] = fragment.normal;
        }
    }
}
