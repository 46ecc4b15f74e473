//! Blends the layers of all ranks over the samples of a frame.

use rayon::prelude::*;

use crate::context::FrameContext;
use crate::frame::layers::{Layer, LayerError};
use crate::frame::{Frame, Pixel, visibility_key};

/// Tiles that are blended before their samples are written: few enough that these take little memory, many enough for all
/// threads.
const TILES_AT_A_TIME: usize = 64;

/// The layers of a tile: the bytes of several ranks.
#[derive(Clone, Debug, Default)]
pub struct LayersOfTile<'a> {
    /// Number of the tile.
    pub tile: u32,
    /// Bytes of layers ([`crate::frame::layers`]).
    pub parts: Vec<&'a [u8]>,
}

/// Blends layers over the samples of a frame ([`Settings::separate_layers`](crate::Settings::separate_layers)) that shows what
/// is opaque: afterwards it shows the same as if one renderer had drawn everything. Each tile is given once, with the layers
/// of all ranks. The frame has keys, and the planes of the context's settings.
///
/// # Errors
/// [`LayerError`] if bytes are not layers of their tile; the samples of some tiles are then not blended.
///
/// # Panics
/// If the frame does not have the size of the settings, or one of these planes.
pub fn blend_layers(
    context: &FrameContext,
    tiles: &[LayersOfTile],
    frame: &mut Frame,
) -> Result<(), LayerError> {
    let settings = context.settings;
    let width = settings.width * settings.elements_per_pixel();
    assert_eq!([frame.width, frame.height], [width, settings.height], "the samples of a whole picture");
    assert_eq!(frame.planes.keys.len(), width as usize * settings.height as usize, "the frame has keys");
    for tiles in tiles.chunks(TILES_AT_A_TIME) {
        let planes = &*frame;
        let blended = tiles.par_iter().map(|tile| OfTile::read(context, tile)?.blend(planes));
        for samples in blended.collect::<Result<Vec<_>, _>>()? {
            for (index, sample) in samples {
                frame.planes.put(index, &sample);
            }
        }
    }
    Ok(())
}

/// The end of a list of layers.
const NO_LAYER: u32 = u32::MAX;

/// The layers of a tile, found by their pixels.
struct OfTile<'a> {
    context: &'a FrameContext<'a>,
    tile: u32,
    layers: Vec<Layer<'a>>,
    /// For each layer, the one in the same pixel before it.
    before: Vec<u32>,
    /// The last layer of each pixel.
    last: Vec<u32>,
}

impl<'a> OfTile<'a> {
    fn read(context: &'a FrameContext<'a>, of: &LayersOfTile<'a>) -> Result<Self, LayerError> {
        let (tile, tiles) = (of.tile, context.grid.count());
        if tile as usize >= tiles {
            return Err(LayerError::Tile { tile, tiles });
        }
        let (shift, rect) = (context.grid.shift, context.grid.rect(tile, context.size()));
        let (columns, rows) = (rect.x1 - rect.x0 + 1, rect.y1 - rect.y0 + 1);
        let mut all = Self {
            context,
            tile,
            layers: Vec::new(),
            before: Vec::new(),
            last: vec![NO_LAYER; (rows as usize) << shift],
        };
        for &bytes in &of.parts {
            let mut rest = bytes;
            while !rest.is_empty() {
                let at = bytes.len() - rest.len();
                let read = Layer::read(&context.settings.outputs, rest);
                let (layer, behind) = read.ok_or(LayerError::Short { tile, at })?;
                let (place, mask) = (layer.head.place, layer.head.mask);
                let column = i32::from(place) & ((1 << shift) - 1);
                let has_samples = mask != 0 && u32::from(mask) >> context.cells.count == 0;
                let Some(last) =
                    all.last.get_mut(usize::from(place)).filter(|_| column < columns && has_samples)
                else {
                    return Err(LayerError::Place { tile, at, place, mask });
                };
                all.before.push(std::mem::replace(last, all.layers.len() as u32));
                all.layers.push(layer);
                rest = behind;
            }
        }
        Ok(all)
    }

    /// The samples that layers change, as they are afterwards, with their indices in the frame.
    fn blend(&self, frame: &Frame) -> Result<Vec<(usize, Pixel)>, LayerError> {
        let (grid, count) = (&self.context.grid, self.context.cells.count);
        let (x, y) = grid.corner(self.tile);
        let (mut changed, mut of_pixel, mut of_sample) = (Vec::new(), Vec::new(), Vec::new());
        for (place, &last) in self.last.iter().enumerate().filter(|(_, last)| **last != NO_LAYER) {
            of_pixel.clear();
            let some = |number: u32| (number != NO_LAYER).then_some(number);
            of_pixel.extend(std::iter::successors(some(last), |&number| some(self.before[number as usize])));
            let (column, row) = (place & ((1 << grid.shift) - 1), place >> grid.shift);
            let first = (y as usize + row) * frame.width as usize + (x as usize + column) * count;
            for sample in 0..count {
                let index = first + sample;
                of_sample.clear();
                of_sample.extend(of_pixel.iter().filter_map(|&number| {
                    let layer = &self.layers[number as usize];
                    if layer.head.mask >> sample & 1 == 0 {
                        return None;
                    }
                    let depth = layer.depth(sample);
                    let key = visibility_key(depth, layer.head.primitive);
                    (key > frame.planes.keys[index]).then_some((key, number))
                }));
                of_sample.sort_unstable_by_key(|&(key, _)| std::cmp::Reverse(key));
                changed.extend(self.blend_sample(&of_sample, frame, index).map(|sample| (index, sample)));
            }
        }
        Ok(changed)
    }

    /// Blends layers, the nearest first, over a sample; `None` if they do not change it. The operations and their order are
    /// those of the back end.
    fn blend_sample(&self, layers: &[(u64, u32)], frame: &Frame, index: usize) -> Option<Pixel> {
        let (mut color, mut passing, mut nearest) = ([0.0f32; 4], 1.0f32, None);
        for &(key, number) in layers {
            let layer = &self.layers[number as usize];
            let passes = 1.0 - layer.head.color[3];
            if passes == 1.0 {
                continue;
            }
            nearest = nearest.or(Some((key, layer)));
            (0..4).for_each(|k| color[k] += passing * layer.head.color[k]);
            passing *= passes;
            if passing <= 0.0 {
                break;
            }
        }
        let (key, layer) = nearest?;
        if passing > 0.0
            && let Some(behind) = frame.planes.linear.get(index)
        {
            (0..4).for_each(|k| color[k] += passing * behind[k]);
        }
        Some(Pixel {
            keys: key,
            linear: color,
            depth: self.context.view.distance(f32::from_bits((key >> 32) as u32)),
            ids: layer.face,
            normals: layer.normal,
            color: [0; 4],
            color16: [0; 4],
        })
    }
}
