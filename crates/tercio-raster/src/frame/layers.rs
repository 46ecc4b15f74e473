//! Layers that a frame of samples keeps apart ([`Settings::separate_layers`](crate::Settings::separate_layers)), as bytes:
//! ranks exchange them, and blend them once all are together.
//!
//! A layer is a fragment of a triangle that may not be opaque. Its bytes are a [`LayerHead`]; its normal and the number of
//! its face, each if that plane is requested; and its depths, as `f32`, at the samples of its mask in ascending order. The
//! bytes of a tile are those of its layers in any order, in native byte order.

use bytemuck::{Pod, Zeroable, bytes_of, pod_read_unaligned};

use super::Outputs;

/// The layers of a tile.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TileLayers {
    /// Number of the tile.
    pub tile: u32,
    /// The layers as bytes.
    pub bytes: Vec<u8>,
}

/// What every layer has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct LayerHead {
    /// Number of the primitive, which breaks ties of depth.
    pub primitive: u32,
    /// Its pixel in the tile: its row times the edge of tiles, plus its column.
    pub place: u16,
    /// The samples of the pixel at which it is a layer, one bit each.
    pub mask: u16,
    /// Premultiplied linear colour.
    pub color: [f32; 4],
}

/// A layer of a tile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layer<'a> {
    /// What every layer has.
    pub head: LayerHead,
    /// Its normal, or zero.
    pub normal: [f32; 3],
    /// Number of its face, or 0.
    pub face: u32,
    /// Its depths as bytes.
    depths: &'a [u8],
}

/// Why bytes are not layers of a tile.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum LayerError {
    /// The bytes end inside a layer.
    #[error("layers of tile {tile}, byte {at}: the bytes end inside a layer")]
    Short {
        /// The tile.
        tile: u32,
        /// Offset of the layer.
        at: usize,
    },
    /// A layer of a pixel or sample that the tile does not have.
    #[error("layers of tile {tile}, byte {at}: samples {mask:#06b} of pixel {place} are not in the tile")]
    Place {
        /// The tile.
        tile: u32,
        /// Offset of the layer.
        at: usize,
        /// Its pixel.
        place: u16,
        /// Its samples.
        mask: u16,
    },
    /// The frame has no such tile.
    #[error("layers of tile {tile}, but the frame has {tiles} tiles")]
    Tile {
        /// The tile.
        tile: u32,
        /// Number of tiles.
        tiles: usize,
    },
}

/// Number of bytes of a layer at this many samples.
pub fn layer_bytes(outputs: &Outputs, samples: usize) -> usize {
    let normal = if outputs.normals { size_of::<[f32; 3]>() } else { 0 };
    let face = if outputs.ids { size_of::<u32>() } else { 0 };
    size_of::<LayerHead>() + normal + face + samples * size_of::<f32>()
}

/// Appends the bytes of a layer: its normal and its face are written if these planes are requested.
pub fn write_layer(
    outputs: &Outputs,
    head: &LayerHead,
    normal: [f32; 3],
    face: impl FnOnce() -> u32,
    depths: impl Iterator<Item = f32>,
    out: &mut Vec<u8>,
) {
    out.extend_from_slice(bytes_of(head));
    if outputs.normals {
        out.extend_from_slice(bytes_of(&normal));
    }
    if outputs.ids {
        out.extend_from_slice(&face().to_ne_bytes());
    }
    depths.for_each(|depth| out.extend_from_slice(&depth.to_ne_bytes()));
}

impl<'a> Layer<'a> {
    /// Reads the first layer of some bytes, and returns the bytes behind it; `None` if they end inside it.
    pub fn read(outputs: &Outputs, bytes: &'a [u8]) -> Option<(Self, &'a [u8])> {
        let (head, mut rest) = bytes.split_at_checked(size_of::<LayerHead>())?;
        let head: LayerHead = pod_read_unaligned(head);
        let (mut normal, mut face) = ([0.0; 3], 0);
        if outputs.normals {
            let (own, behind) = rest.split_at_checked(size_of::<[f32; 3]>())?;
            (normal, rest) = (pod_read_unaligned(own), behind);
        }
        if outputs.ids {
            let (own, behind) = rest.split_at_checked(size_of::<u32>())?;
            (face, rest) = (pod_read_unaligned(own), behind);
        }
        let (depths, rest) = rest.split_at_checked(head.mask.count_ones() as usize * size_of::<f32>())?;
        Some((Self { head, normal, face, depths }, rest))
    }

    /// Its depth at a sample of its mask.
    pub fn depth(&self, sample: usize) -> f32 {
        let before = (u32::from(self.head.mask) & ((1 << sample) - 1)).count_ones() as usize;
        let first = before * size_of::<f32>();
        pod_read_unaligned(&self.depths[first..first + size_of::<f32>()])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layers_are_read_as_they_were_written() {
        let heads = [(7, 5, 0b1010), (8, 0, 0b1), (9, 4095, 0xffff)].map(|(primitive, place, mask)| {
            let color = [0.25, 0.5, 0.0, 0.75];
            LayerHead { primitive, place, mask, color }
        });
        for outputs in [Outputs::NONE, Outputs::ALL, Outputs { ids: true, ..Outputs::NONE }] {
            let mut bytes = Vec::new();
            for head in &heads {
                let depths = (0..head.mask.count_ones()).map(|k| k as f32 + 0.5);
                let before = bytes.len();
                write_layer(&outputs, head, [1.0, 2.0, 3.0], || head.primitive + 1, depths, &mut bytes);
                assert_eq!(bytes.len() - before, layer_bytes(&outputs, head.mask.count_ones() as usize));
            }
            let mut rest = &bytes[..];
            for head in &heads {
                let (layer, behind) = Layer::read(&outputs, rest).unwrap();
                assert_eq!(layer.head, *head);
                assert_eq!(layer.normal, if outputs.normals { [1.0, 2.0, 3.0] } else { [0.0; 3] });
                assert_eq!(layer.face, if outputs.ids { head.primitive + 1 } else { 0 });
                let samples = (0..16).filter(|sample| head.mask >> sample & 1 == 1);
                for (k, sample) in samples.enumerate() {
                    assert_eq!(layer.depth(sample), k as f32 + 0.5);
                }
                rest = behind;
            }
            assert!(rest.is_empty());
            for length in 0..layer_bytes(&outputs, 2) {
                assert_eq!(Layer::read(&outputs, &bytes[..length]), None);
            }
        }
    }
}
