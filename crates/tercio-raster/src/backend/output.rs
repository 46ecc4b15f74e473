//! From a tile's pixels to the planes of the picture.

use tercio_scene::Background;

use crate::Frame;
use crate::binning::PixelRect;
use crate::context::FrameContext;
use crate::frame::NO_PRIMITIVE;
use crate::frame::planes::SharedPlane;

/// The planes of a frame while its tiles are drawn.
pub struct Planes<'a> {
    /// 8-bit colour.
    pub color: SharedPlane<'a, [u8; 4]>,
    /// 16-bit colour.
    pub color16: SharedPlane<'a, [u16; 4]>,
    /// Distances.
    pub depth: SharedPlane<'a, f32>,
    /// Input faces.
    pub ids: SharedPlane<'a, u32>,
    /// World-space normals.
    pub normals: SharedPlane<'a, [f32; 3]>,
    /// Visibility keys.
    pub keys: SharedPlane<'a, u64>,
    /// Background of each row: 8 bits, 16 bits.
    background: Vec<([u8; 4], [u16; 4])>,
}

impl<'a> Planes<'a> {
    /// Takes the planes of a frame apart.
    pub fn new(frame: &'a mut Frame, background: &Background) -> Self {
        let (w, h) = (frame.width as usize, frame.height as usize);
        Self {
            color: SharedPlane::new(&mut frame.color, w, h),
            color16: SharedPlane::new(&mut frame.color16, w, h),
            depth: SharedPlane::new(&mut frame.depth, w, h),
            ids: SharedPlane::new(&mut frame.ids, w, h),
            normals: SharedPlane::new(&mut frame.normals, w, h),
            keys: SharedPlane::new(&mut frame.keys, w, h),
            background: (0..frame.height).map(|y| background_row(background, y, frame.height)).collect(),
        }
    }
}

/// The background of a row in 8 and in 16 bits: mixed in sRGB, as a designer's gradient is.
pub fn background_row(background: &Background, y: u32, height: u32) -> ([u8; 4], [u16; 4]) {
    let mixed: [f32; 4] = match *background {
        Background::Solid(color) => color,
        Background::Gradient { top, bottom } => {
            let t = (y as f32 + 0.5) / height as f32;
            std::array::from_fn(|k| top[k] + (bottom[k] - top[k]) * t)
        }
    };
    let level = |most: f32| mixed.map(|c| c.clamp(0.0, 1.0) * most + 0.5);
    (level(255.0).map(|c| c as u8), level(65535.0).map(|c| c as u16))
}

/// The pixels of a tile that lie inside the picture.
pub fn tile_rect(context: &FrameContext, tile: u32) -> PixelRect {
    let (x, y) = context.grid.corner(tile);
    let edge = 1u32 << context.grid.shift;
    PixelRect {
        x0: x as i32,
        x1: (x + edge).min(context.view.width) as i32 - 1,
        y0: y as i32,
        y1: (y + edge).min(context.view.height) as i32 - 1,
    }
}

/// The pixels of one tile, at the places that their samples have in the [`TileMemory`](super::memory::TileMemory);
/// planes that nobody asked for stay empty.
#[derive(Debug, Default)]
pub struct TilePixels {
    /// Places from a row to the next.
    stride: usize,
    /// sRGB, 8 bits.
    pub color: Vec<[u8; 4]>,
    /// sRGB, 16 bits.
    pub color16: Vec<[u16; 4]>,
    /// Distances.
    pub depth: Vec<f32>,
    /// Input faces.
    pub ids: Vec<u32>,
    /// World-space normals.
    pub normals: Vec<[f32; 3]>,
    /// Visibility keys.
    pub keys: Vec<u64>,
}

impl TilePixels {
    /// Fills the tile with the background.
    pub fn clear(&mut self, rect: PixelRect, stride: usize, planes: &Planes) {
        self.stride = stride;
        let rows = &planes.background[rect.y0 as usize..=rect.y1 as usize];
        let pixels = stride * rows.len();
        if planes.color.is_wanted() {
            self.color.clear();
            rows.iter().for_each(|row| self.color.extend(std::iter::repeat_n(row.0, stride)));
        }
        if planes.color16.is_wanted() {
            self.color16.clear();
            rows.iter().for_each(|row| self.color16.extend(std::iter::repeat_n(row.1, stride)));
        }
        fn fill<T: Clone, P>(plane: &mut Vec<T>, wanted: &SharedPlane<P>, pixels: usize, value: T) {
            plane.clear();
            if wanted.is_wanted() {
                plane.resize(pixels, value);
            }
        }
        fill(&mut self.depth, &planes.depth, pixels, f32::INFINITY);
        fill(&mut self.ids, &planes.ids, pixels, NO_PRIMITIVE);
        fill(&mut self.normals, &planes.normals, pixels, [0.0; 3]);
        fill(&mut self.keys, &planes.keys, pixels, 0);
    }

    /// Copies the tile to its place in the picture.
    pub fn write(&self, rect: PixelRect, planes: &Planes) {
        copy(&self.color, self.stride, rect, &planes.color);
        copy(&self.color16, self.stride, rect, &planes.color16);
        copy(&self.depth, self.stride, rect, &planes.depth);
        copy(&self.ids, self.stride, rect, &planes.ids);
        copy(&self.normals, self.stride, rect, &planes.normals);
        copy(&self.keys, self.stride, rect, &planes.keys);
    }
}

fn copy<T: Copy>(tile: &[T], stride: usize, rect: PixelRect, plane: &SharedPlane<T>) {
    if !plane.is_wanted() {
        return;
    }
    let width = (rect.x1 - rect.x0 + 1) as usize;
    for (row, y) in tile.chunks_exact(stride).zip(rect.y0..) {
        // SAFETY: tiles do not overlap, each is drawn by one thread, and the row is let go at once.
        unsafe { plane.row(rect.x0 as usize, y as usize, width) }.copy_from_slice(&row[..width]);
    }
}
