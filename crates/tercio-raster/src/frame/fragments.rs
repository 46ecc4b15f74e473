//! Fragments of tiles as bytes: ranks that share the triangles of a frame draw them apart
//! ([`Settings::keep_fragments`](crate::Settings::keep_fragments)), and the owner of a tile merges those of all ranks
//! ([`Renderer::merge`](crate::Renderer::merge)).
//!
//! A fragment is a triangle in a pixel. Its bytes are a [`FragmentHead`]; the upper 32 bits of the number of its primitive, if
//! numbers need more than 32; its normal and the number of its face, each if that plane is requested; and its depths, as `f32`, at the samples of its mask in ascending order. The bytes of a tile are those
//! of its fragments in any order, in native byte order. Opaque ones are there at samples where they are the nearest, others
//! where nothing opaque is in front of them.
//!
//! Ranks that know how near others draw ([`FrameContext::nearest_of_others`](crate::context::FrameContext::nearest_of_others))
//! keep nothing of what these hide ([`FrameContext::hidden_by_others`](crate::context::FrameContext::hidden_by_others)), and
//! finish blocks of pixels instead, in which no fragment of the others can be visible. If others may have hidden fragments in such blocks, the
//! owner of the tile has to discard these: a run of consecutive blocks is recorded among the fragments as a head with an empty mask,
//! whose place is the number of the first block, and whose primitive is the length of the run.
//!
//! Ranks that hand on what others have sent merge it first ([`FragmentMerger`]).

mod merge;

use bytemuck::{Pod, Zeroable, bytes_of, pod_read_unaligned};

pub use merge::FragmentMerger;
pub(crate) use merge::write_finished;

use super::Outputs;

/// The fragments of a tile.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TileFragments {
    /// Number of the tile.
    pub tile: u32,
    /// The fragments as bytes.
    pub bytes: Vec<u8>,
    /// What is finished of the tile.
    pub finished: FinishedPart,
}

/// The part of a tile that is finished without other ranks: its pixels are in the planes of the frame, which has the background in
/// all others of the tile.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FinishedPart {
    /// Pixels that show something.
    pub pixels: u64,
    /// Of each block of the tile in which other ranks may draw something, a depth behind which nothing of theirs is seen
    /// ([`FrameContext::hidden_by_others`](crate::context::FrameContext::hidden_by_others)): infinity where the block is finished. 0 of the other blocks. Empty if nothing is
    /// known of other ranks.
    pub hides: Vec<f32>,
}

/// The fragments of a tile that several ranks have drawn.
#[derive(Clone, Debug, Default)]
pub struct FragmentsOfTile<'a> {
    /// Number of the tile.
    pub tile: u32,
    /// Bytes of fragments.
    pub parts: Vec<&'a [u8]>,
    /// The frame has finished pixels of the tile: those in which there is no fragment keep their values. Otherwise they get the
    /// background.
    pub has_finished: bool,
}

/// What every fragment has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct FragmentHead {
    /// The lower 32 bits of the number of the primitive, which breaks ties of depth.
    pub primitive: u32,
    /// Its pixel, counted from the first one that the tile needs: its row in the tile memory times the distance of rows, plus its column.
    pub place: u16,
    /// The samples of the pixel that it has, one bit each.
    pub mask: u16,
    /// Premultiplied linear colour.
    pub color: [f32; 4],
}

/// A fragment of a tile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TileFragment<'a> {
    /// What every fragment has.
    pub head: FragmentHead,
    /// Number of its primitive.
    pub primitive: u64,
    /// Its normal, or zero.
    pub normal: [f32; 3],
    /// Number of its face, or 0.
    pub face: u32,
    /// Its depths as bytes.
    depths: &'a [u8],
}

/// Why bytes are not fragments of a tile.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum FragmentError {
    /// The bytes end inside a fragment.
    #[error("fragments of tile {tile}, byte {at}: the bytes end inside a fragment")]
    Short {
        /// The tile.
        tile: u32,
        /// Offset of the fragment.
        at: usize,
    },
    /// A fragment of a pixel or sample that the tile does not have.
    #[error("fragments of tile {tile}, byte {at}: samples {mask:#06b} of pixel {place} are not in the tile")]
    Place {
        /// The tile.
        tile: u32,
        /// Offset of the fragment.
        at: usize,
        /// Its pixel.
        place: u16,
        /// Its samples.
        mask: u16,
    },
    /// Finished blocks that the tile does not have.
    #[error("fragments of tile {tile}, byte {at}: the finished blocks from {first} on are not in the tile")]
    Blocks {
        /// The tile.
        tile: u32,
        /// Offset of their record.
        at: usize,
        /// The first of them.
        first: u16,
    },
    /// A fragment that is not opaque, in a scene in which everything is.
    #[error("fragments of tile {tile}, byte {at}: not opaque, in a scene in which everything is")]
    Translucent {
        /// The tile.
        tile: u32,
        /// Offset of the fragment.
        at: usize,
    },
    /// The frame has no such tile.
    #[error("fragments of tile {tile}, but the frame has {tiles} tiles")]
    Tile {
        /// The tile.
        tile: u32,
        /// Number of tiles.
        tiles: usize,
    },
}

/// What fragments have as bytes, besides their heads and depths.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FragmentLayout {
    /// The upper 32 bits of the number of the primitive.
    pub wide: bool,
    /// The normal.
    pub normals: bool,
    /// The number of the face.
    pub ids: bool,
}

impl FragmentLayout {
    /// Of a frame with these planes; `is_wide` if numbers of primitives need more than 32 bits.
    pub fn new(outputs: &Outputs, is_wide: bool) -> Self {
        Self { wide: is_wide, normals: outputs.normals, ids: outputs.ids }
    }

    /// Number of bytes of a fragment at this many samples.
    pub fn bytes(self, samples: usize) -> usize {
        let number = if self.wide { size_of::<u32>() } else { 0 };
        let normal = if self.normals { size_of::<[f32; 3]>() } else { 0 };
        let face = if self.ids { size_of::<u32>() } else { 0 };
        size_of::<FragmentHead>() + number + normal + face + samples * size_of::<f32>()
    }
}

/// Writes the bytes of a fragment, whose head has the lower half of the number of its primitive, to the beginning of `out`, and
/// returns their number. `depths` are those of all samples of its pixel.
///
/// # Panics
/// If `out` is too short.
#[inline(always)]
pub fn write_fragment(
    layout: FragmentLayout,
    head: &FragmentHead,
    primitive: u64,
    normal: impl FnOnce() -> [f32; 3],
    face: impl FnOnce() -> u32,
    depths: impl Fn(usize) -> f32,
    out: &mut [u8],
) -> usize {
    let mut at = 0;
    let mut put = |bytes: &[u8]| {
        out[at..at + bytes.len()].copy_from_slice(bytes);
        at += bytes.len();
    };
    put(bytes_of(head));
    if layout.wide {
        put(&((primitive >> 32) as u32).to_ne_bytes());
    }
    if layout.normals {
        put(bytes_of(&normal()));
    }
    if layout.ids {
        put(&face().to_ne_bytes());
    }
    samples_of(head.mask).for_each(|sample| put(&depths(sample).to_ne_bytes()));
    at
}

/// The samples of a mask, in ascending order.
#[inline(always)]
fn samples_of(mask: u16) -> impl Iterator<Item = usize> {
    let next = |left: u16| (left != 0).then_some(left);
    std::iter::successors(next(mask), move |&left| next(left & (left - 1)))
        .map(|left| left.trailing_zeros() as usize)
}

impl<'a> TileFragment<'a> {
    /// Reads the first fragment of some bytes, and returns the bytes behind it; `None` if they end inside it.
    #[inline(always)]
    pub fn read(layout: FragmentLayout, bytes: &'a [u8]) -> Option<(Self, &'a [u8])> {
        let (head, mut rest) = bytes.split_at_checked(size_of::<FragmentHead>())?;
        let head: FragmentHead = pod_read_unaligned(head);
        let (mut primitive, mut normal, mut face) = (u64::from(head.primitive), [0.0; 3], 0);
        if layout.wide {
            let (own, behind) = rest.split_at_checked(size_of::<u32>())?;
            (primitive, rest) = (primitive | u64::from(pod_read_unaligned::<u32>(own)) << 32, behind);
        }
        if layout.normals {
            let (own, behind) = rest.split_at_checked(size_of::<[f32; 3]>())?;
            (normal, rest) = (pod_read_unaligned(own), behind);
        }
        if layout.ids {
            let (own, behind) = rest.split_at_checked(size_of::<u32>())?;
            (face, rest) = (pod_read_unaligned(own), behind);
        }
        let (depths, rest) = rest.split_at_checked(head.mask.count_ones() as usize * size_of::<f32>())?;
        Some((Self { head, primitive, normal, face, depths }, rest))
    }

    /// Does it hide what is behind it? Surfaces that may not be opaque may have fragments that are.
    #[inline(always)]
    pub fn is_opaque(&self) -> bool {
        self.head.color[3] == 1.0
    }

    /// The samples of its mask, and its depth at each.
    #[inline(always)]
    pub fn samples(&self) -> impl Iterator<Item = (usize, f32)> {
        let depths = self.depths.as_chunks().0.iter().map(|&depth| f32::from_ne_bytes(depth));
        samples_of(self.head.mask).zip(depths)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fragments_are_read_as_they_were_written() {
        let heads = [(7, 5, 0b1010), (8, 0, 0b1), (9, 4095, 0xffff)].map(|(primitive, place, mask)| {
            let color = [0.25, 0.5, 0.0, 0.75];
            FragmentHead { primitive, place, mask, color }
        });
        let planes = [Outputs::NONE, Outputs::ALL, Outputs { ids: true, ..Outputs::NONE }];
        for layout in planes.iter().flat_map(|of| [false, true].map(|wide| FragmentLayout::new(of, wide))) {
            let high = |head: &FragmentHead| if layout.wide { u64::from(head.place) << 32 } else { 0 };
            let number = |head: &FragmentHead| u64::from(head.primitive) | high(head);
            let mut bytes = Vec::new();
            for head in &heads {
                let depths = |sample: usize| sample as f32 + 0.5;
                let mut out = [0; 128];
                let (normal, face) = (|| [1.0, 2.0, 3.0], || head.primitive + 1);
                let count = write_fragment(layout, head, number(head), normal, face, depths, &mut out);
                assert_eq!(count, layout.bytes(head.mask.count_ones() as usize));
                bytes.extend_from_slice(&out[..count]);
            }
            let mut rest = &bytes[..];
            for head in &heads {
                let (fragment, behind) = TileFragment::read(layout, rest).unwrap();
                assert_eq!((fragment.head, fragment.primitive), (*head, number(head)));
                assert_eq!(fragment.normal, if layout.normals { [1.0, 2.0, 3.0] } else { [0.0; 3] });
                assert_eq!(fragment.face, if layout.ids { head.primitive + 1 } else { 0 });
                let samples = (0..16).filter(|sample| head.mask >> sample & 1 == 1);
                let expected: Vec<(usize, f32)> = samples.map(|k| (k, k as f32 + 0.5)).collect();
                assert_eq!(fragment.samples().collect::<Vec<_>>(), expected);
                rest = behind;
            }
            assert!(rest.is_empty());
            for length in 0..layout.bytes(2) {
                assert_eq!(TileFragment::read(layout, &bytes[..length]), None);
            }
        }
    }
}
