//! The planes of a frame: their list, and the operations on all of them.
//!
//! To add a plane, add a line to the list below, and write its pixels in the shading kernel and in the reference.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

use tercio_scene::{Background, srgb_to_linear};

use super::shared::SharedPlane;
use super::{FinishedPart, Frame, NO_PRIMITIVE, TileFragments};
use crate::screen::{PixelRect, TileGrid};

macro_rules! planes {
    ($(
        $(#[$doc:meta])* $name:ident: $type:ty, wanted: $wanted:literal, background: $row:ident => $background:expr;
    )*) => {
        /// Which planes a frame has.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub struct Outputs {
            $($(#[$doc])* pub $name: bool,)*
        }

        impl Default for Outputs {
            fn default() -> Self {
                Self { $($name: $wanted,)* }
            }
        }

        impl Outputs {
            /// All planes.
            pub const ALL: Self = Self { $($name: true,)* };
            /// No plane.
            pub const NONE: Self = Self { $($name: false,)* };

            /// The planes of both.
            #[must_use]
            pub fn with(self, other: Self) -> Self {
                Self { $($name: self.$name || other.$name,)* }
            }

            /// Bytes per pixel of each plane, in order.
            pub fn plane_bytes(&self) -> impl Iterator<Item = usize> + use<> {
                let planes = [$((self.$name, size_of::<$type>()),)*];
                planes.into_iter().filter_map(|(is_wanted, bytes)| is_wanted.then_some(bytes))
            }

            /// Bytes per pixel of all planes together.
            pub fn pixel_bytes(&self) -> usize {
                0 $(+ if self.$name { size_of::<$type>() } else { 0 })*
            }
        }

        /// Planes of pixels, row by row; those that were not requested are empty.
        #[derive(Clone, Debug, Default, PartialEq)]
        pub struct Planes {
            $($(#[$doc])* pub $name: Vec<$type>,)*
        }

        impl Planes {
            /// Resizes the requested planes to this many pixels and empties the others. The values are unspecified.
            pub(crate) fn resize(&mut self, outputs: &Outputs, pixels: usize) {
                $(resize(&mut self.$name, if outputs.$name { pixels } else { 0 });)*
            }

            /// Planes of two frames of one size: by turns `pixels` of the one and as many of the other. With the pixels of a row they are
            /// side by side, with those of a frame one below the other. A plane that one of them does not have is empty.
            #[must_use]
            pub fn in_turn(&self, other: &Self, pixels: usize) -> Self {
                Self { $($name: in_turn(&self.$name, &other.$name, pixels.max(1)),)* }
            }

            /// Sets a pixel in the planes that are present.
            pub(crate) fn put(&mut self, index: usize, pixel: &Pixel) {
                $(if let Some(value) = self.$name.get_mut(index) {
                    *value = pixel.$name;
                })*
            }

            /// Sets a range of pixels in the planes that are present.
            pub fn fill(&mut self, range: std::ops::Range<usize>, pixel: &Pixel) {
                $(if let Some(values) = self.$name.get_mut(range.clone()) {
                    values.fill(pixel.$name);
                })*
            }

            /// Appends a range of pixels of the requested planes as bytes, plane after plane, in native byte order.
            ///
            /// # Panics
            /// If a requested plane does not have these pixels.
            pub fn write_bytes(&self, outputs: &Outputs, range: std::ops::Range<usize>, out: &mut Vec<u8>) {
                $(if outputs.$name {
                    out.extend_from_slice(bytemuck::cast_slice(&self.$name[range.clone()]));
                })*
            }

            /// Reads bytes of [`Planes::write_bytes`] into a range of pixels.
            ///
            /// # Panics
            /// If a requested plane does not have these pixels, or the number of bytes is another one.
            pub fn read_bytes(&mut self, outputs: &Outputs, mut bytes: &[u8], range: std::ops::Range<usize>) {
                $(if outputs.$name {
                    let values = &mut self.$name[range.clone()];
                    let (own, rest) = bytes.split_at(size_of_val(values));
                    bytes = rest;
                    bytemuck::cast_slice_mut(values).copy_from_slice(own);
                })*
                assert!(bytes.is_empty(), "{} bytes more than the planes have", bytes.len());
            }

            /// Which of a range of pixels, in any of the requested planes, are not bit for bit those of `pixel`: `differs`
            /// has one entry for each of them.
            ///
            /// # Panics
            /// If a requested plane does not have these pixels.
            pub fn differ_from(
                &self,
                outputs: &Outputs,
                range: std::ops::Range<usize>,
                pixel: &Pixel,
                differs: &mut [bool],
            ) {
                differs.fill(false);
                $(if outputs.$name {
                    // Without early exits, so that this is vectorised.
                    for (differs, value) in differs.iter_mut().zip(&self.$name[range.clone()]) {
                        *differs |= bits(value) != bits(&pixel.$name);
                    }
                })*
            }

            /// Describes the first plane in which two frames differ, and returns the index of the first pixel that
            /// differs there; numbers are compared by their bits.
            pub(crate) fn first_difference(&self, other: &Self) -> Option<(String, usize)> {
                $(
                    let (own, others) = (&self.$name, &other.$name);
                    if own.len() != others.len() {
                        let found = format!("{} of {} pixels, not {}", stringify!($name), own.len(), others.len());
                        return Some((found, 0));
                    }
                    let differs = |&index: &usize| {
                        bytemuck::bytes_of(&own[index]) != bytemuck::bytes_of(&others[index])
                    };
                    if let Some(index) = (0..own.len()).find(differs) {
                        let count = (0..own.len()).filter(differs).count();
                        let found = format!(
                            "{count} pixels differ in {}, first {:?}, not {:?}",
                            stringify!($name), own[index], others[index],
                        );
                        return Some((found, index));
                    }
                )*
                None
            }
        }

        /// One pixel: its value in every plane.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct Pixel {
            $($(#[$doc])* pub $name: $type,)*
        }

        impl Pixel {
            /// The background pixel of row `y` in a picture of this height.
            pub fn of_background(background: &Background, y: u32, height: u32) -> Self {
                Self::of_row(&BackgroundRow::new(background, y, height, true))
            }

            /// The background pixel of each of some rows of a picture of this height; its linear colour is valid if
            /// `needs_linear`.
            pub fn of_background_rows(
                background: &Background,
                rows: std::ops::Range<u32>,
                height: u32,
                needs_linear: bool,
            ) -> Vec<Self> {
                let of = |y: u32| Self::of_row(&BackgroundRow::new(background, y, height, needs_linear));
                match background {
                    Background::Solid(_) => vec![of(0); rows.len()],
                    Background::Gradient { .. } => rows.map(of).collect(),
                }
            }

            fn of_row(row: &BackgroundRow) -> Self {
                Self { $($name: { let $row = row; let _ = $row; $background },)* }
            }
        }

        /// The planes of a frame while threads write their tiles.
        struct SharedPlanes<'a> {
            $($name: SharedPlane<'a, $type>,)*
        }

        impl<'a> SharedPlanes<'a> {
            fn new(planes: &'a mut Planes, width: usize, height: usize) -> Self {
                Self { $($name: SharedPlane::new(&mut planes.$name, width, height),)* }
            }

            /// Fills a tile with one pixel for each of its rows.
            ///
            /// # Safety
            /// No other thread accesses this rectangle.
            unsafe fn fill(&self, rows: &[Pixel], rect: PixelRect) {
                $(
                    // SAFETY: the caller upholds the same contract.
                    unsafe { fill(rows.iter().map(|row| row.$name), rect, &self.$name) };
                )*
            }

            /// Copies the pixels of a tile, whose rows are `stride` pixels apart, to a rectangle of the picture.
            ///
            /// # Safety
            /// No other thread accesses this rectangle.
            unsafe fn write(&self, tile: &Planes, stride: usize, rect: PixelRect) {
                $(
                    // SAFETY: the caller upholds the same contract.
                    unsafe { copy(&tile.$name, stride, rect, &self.$name) };
                )*
            }

            /// Copies the pixels of a rectangle of the picture to a tile, whose rows are `stride` pixels apart.
            ///
            /// # Safety
            /// No other thread accesses this rectangle.
            unsafe fn read(&self, tile: &mut Planes, stride: usize, rect: PixelRect) {
                $(
                    // SAFETY: the caller upholds the same contract.
                    unsafe { copy_back(&mut tile.$name, stride, rect, &self.$name) };
                )*
            }
        }

        /// Fills a tile: each of its rows, of `stride` pixels, with one pixel of `rows`.
        fn clear(tile: &mut Planes, outputs: &Outputs, rows: &[Pixel], stride: usize) {
            $(
                tile.$name.clear();
                if outputs.$name {
                    rows.iter().for_each(|row| tile.$name.extend(std::iter::repeat_n(row.$name, stride)));
                }
            )*
        }
    };
}

planes! {
    /// Visibility keys ([`super::visibility_key`]), used to compose pictures of parts; 0 where nothing was drawn.
    keys: u64, wanted: false, background: _row => 0;
    /// What decides between equal keys if primitive numbers need more than 32 bits ([`super::key_and_tie`]); 0 otherwise, and where
    /// nothing was drawn.
    ties: u32, wanted: false, background: _row => 0;
    /// sRGB colour, 8 bits, alpha not premultiplied.
    color: [u8; 4], wanted: true, background: row => row.level(255.0).map(|c| c as u8);
    /// sRGB colour, 16 bits, alpha not premultiplied.
    color16: [u16; 4], wanted: false, background: row => row.level(65535.0).map(|c| c as u16);
    /// Distance from the eye along the line of sight in world units; infinite where nothing was drawn.
    depth: f32, wanted: false, background: _row => f32::INFINITY;
    /// Linear RGB light, clamped to the range from 0 to 1, and alpha; the colour is multiplied by alpha.
    linear: [f32; 4], wanted: false, background: row => row.linear;
    /// Number of the visible input face (polygon), counted through the instances in order;
    /// [`NO_PRIMITIVE`] where nothing was drawn.
    ids: u32, wanted: false, background: _row => NO_PRIMITIVE;
    /// The unit normals in world space that the picture is lit with: see [`crate::conventions`]. Except for rounding
    /// errors, none points away from the viewer; zero where nothing was drawn.
    normals: [f32; 3], wanted: false, background: _row => [0.0; 3];
}

/// The bits of a value of a plane, of at most 16 bytes.
#[inline(always)]
fn bits<T: bytemuck::NoUninit>(value: &T) -> u128 {
    let mut bits = [0; 16];
    bits[..size_of::<T>()].copy_from_slice(bytemuck::bytes_of(value));
    u128::from_ne_bytes(bits)
}

/// As many values of one plane and of another by turns.
fn in_turn<T: Copy>(own: &[T], others: &[T], values: usize) -> Vec<T> {
    let mut all = Vec::with_capacity(2 * own.len().min(others.len()));
    for (own, others) in own.chunks(values).zip(others.chunks(values)) {
        all.extend_from_slice(own);
        all.extend_from_slice(others);
    }
    all
}

/// Resizes a plane. Memory that has to be allocated is not touched: the system clears a page when it is first written.
fn resize<T: bytemuck::Zeroable + Copy + Default>(plane: &mut Vec<T>, pixels: usize) {
    if plane.capacity() < pixels {
        *plane = bytemuck::zeroed_vec(pixels);
    } else {
        plane.resize(pixels, T::default());
    }
}

/// The background of a row. Gradients are interpolated in sRGB, as graphics programs do.
struct BackgroundRow {
    /// sRGB and alpha, not premultiplied.
    color: [f32; 4],
    /// Premultiplied linear light, or zero if it is not needed: it takes longer than a row of pixels.
    linear: [f32; 4],
}

impl BackgroundRow {
    fn new(background: &Background, y: u32, height: u32, needs_linear: bool) -> Self {
        let color = match *background {
            Background::Solid(color) => color,
            Background::Gradient { top, bottom } => {
                let t = (y as f32 + 0.5) / height as f32;
                std::array::from_fn(|k| top[k] + (bottom[k] - top[k]) * t)
            }
        };
        let mut linear = [0.0; 4];
        if needs_linear {
            let [r, g, b, alpha] = color.map(|c| c.clamp(0.0, 1.0));
            let [r, g, b] = [r, g, b].map(|c| srgb_to_linear(f64::from(c)) as f32 * alpha);
            linear = [r, g, b, alpha];
        }
        Self { color, linear }
    }

    fn level(&self, most: f32) -> [f32; 4] {
        self.color.map(|c| c.clamp(0.0, 1.0) * most + 0.5)
    }
}

/// Copies the rows of a tile to a rectangle of a plane.
///
/// # Safety
/// No other thread accesses this rectangle.
unsafe fn copy<T: Copy>(tile: &[T], stride: usize, rect: PixelRect, plane: &SharedPlane<T>) {
    if !plane.is_wanted() {
        return;
    }
    let width = (rect.x1 - rect.x0 + 1) as usize;
    for (row, y) in tile.chunks_exact(stride).zip(rect.y0..) {
        // SAFETY: the caller guarantees that no other thread accesses the rectangle, and the row is released at once.
        unsafe { plane.row(rect.x0 as usize, y as usize, width) }.copy_from_slice(&row[..width]);
    }
}

/// Copies the rows of a rectangle of a plane to a tile.
///
/// # Safety
/// No other thread accesses this rectangle.
unsafe fn copy_back<T: Copy>(tile: &mut [T], stride: usize, rect: PixelRect, plane: &SharedPlane<T>) {
    if !plane.is_wanted() {
        return;
    }
    let width = (rect.x1 - rect.x0 + 1) as usize;
    for (row, y) in tile.chunks_exact_mut(stride).zip(rect.y0..) {
        // SAFETY: the caller guarantees that no other thread accesses the rectangle, and the row is released at once.
        row[..width].copy_from_slice(unsafe { plane.row(rect.x0 as usize, y as usize, width) });
    }
}

/// Fills each row of a tile with one value.
///
/// # Safety
/// No other thread accesses this rectangle.
unsafe fn fill<T: Copy>(rows: impl Iterator<Item = T>, rect: PixelRect, plane: &SharedPlane<T>) {
    if !plane.is_wanted() {
        return;
    }
    let width = (rect.x1 - rect.x0 + 1) as usize;
    for (value, y) in rows.zip(rect.y0..) {
        // SAFETY: the caller guarantees that no other thread accesses the rectangle; the row is released at once.
        unsafe { plane.row(rect.x0 as usize, y as usize, width) }.fill(value);
    }
}

/// A frame that several threads draw, tile by tile.
pub struct Canvas<'a> {
    planes: SharedPlanes<'a>,
    outputs: Outputs,
    grid: TileGrid,
    /// Width and height of the picture in pixels.
    size: [u32; 2],
    /// Elements of a plane per pixel.
    count: u32,
    /// The first row of the picture that the frame holds.
    first_row: u32,
    /// The background pixel of each row of the frame.
    background: Vec<Pixel>,
    /// Which tiles have been claimed: each may be written once.
    claimed: Vec<AtomicBool>,
    /// The fragments that are kept, in any order of the tiles.
    fragments: Mutex<Vec<TileFragments>>,
}

/// A tile of a [`Canvas`] that its owner may write, exclusively.
pub struct CanvasTile<'a> {
    canvas: &'a Canvas<'a>,
    tile: u32,
    /// The elements of the planes.
    rect: PixelRect,
}

impl<'a> Canvas<'a> {
    /// A canvas of a frame whose planes have been resized. It has `count` elements per pixel, side by side, and holds the
    /// rows of a picture of height `height` that the grid divides. The linear colour of the background is valid if
    /// `needs_linear`.
    pub fn new(
        frame: &'a mut Frame,
        outputs: &Outputs,
        background: &Background,
        grid: &TileGrid,
        count: u32,
        height: u32,
        needs_linear: bool,
    ) -> Self {
        let first_row = grid.first_row << grid.shift;
        let rows = first_row..first_row + frame.height;
        Self {
            planes: SharedPlanes::new(&mut frame.planes, frame.width as usize, frame.height as usize),
            outputs: *outputs,
            grid: grid.clone(),
            size: [frame.width / count, height],
            count,
            first_row,
            background: Pixel::of_background_rows(background, rows, height, needs_linear),
            claimed: (0..grid.count()).map(|_| AtomicBool::new(false)).collect(),
            fragments: Mutex::default(),
        }
    }

    /// The fragments that were kept, in the order of the tiles.
    pub fn into_fragments(self) -> Vec<TileFragments> {
        let mut fragments = self.fragments.into_inner().unwrap_or_else(|e| e.into_inner());
        fragments.sort_unstable_by_key(|of_tile| of_tile.tile);
        fragments
    }

    /// The planes of the canvas.
    #[inline(always)]
    pub fn outputs(&self) -> &Outputs {
        &self.outputs
    }

    /// Claims a tile for writing.
    ///
    /// # Panics
    /// If the tile was claimed before.
    pub fn claim(&self, tile: u32) -> CanvasTile<'_> {
        let claimed = self.claimed[tile as usize].swap(true, Ordering::Relaxed);
        assert!(!claimed, "tile {tile} is drawn twice");
        let rect = self.grid.rect(tile, self.size);
        let (count, first_row) = (self.count as i32, self.first_row as i32);
        CanvasTile {
            canvas: self,
            tile,
            rect: PixelRect {
                x0: rect.x0 * count,
                x1: (rect.x1 + 1) * count - 1,
                y0: rect.y0 - first_row,
                y1: rect.y1 - first_row,
            },
        }
    }
}

impl CanvasTile<'_> {
    /// Fills the pixels of the tile, whose rows are `stride` pixels apart, with the background.
    pub fn clear(&self, pixels: &mut Planes, stride: usize) {
        clear(pixels, &self.canvas.outputs, self.background(), stride);
    }

    /// The background pixel of each row of the tile.
    pub fn background(&self) -> &[Pixel] {
        &self.canvas.background[self.rect.y0 as usize..=self.rect.y1 as usize]
    }

    /// Fills the tile of the picture with the background.
    pub fn write_background(&mut self) {
        // SAFETY: as in `write`.
        unsafe { self.canvas.planes.fill(self.background(), self.rect) };
    }

    /// Keeps the fragments of the tile, and what is finished of it.
    pub fn keep(self, finished: FinishedPart, bytes: Vec<u8>) {
        if finished.pixels > 0 || !bytes.is_empty() {
            let mut fragments = self.canvas.fragments.lock().unwrap_or_else(|e| e.into_inner());
            fragments.push(TileFragments { tile: self.tile, bytes, finished });
        }
    }

    /// The number of the tile.
    pub fn number(&self) -> u32 {
        self.tile
    }

    /// Copies the pixels of the tile from the picture, to where rows are `stride` pixels apart.
    pub fn read(&mut self, pixels: &mut Planes, stride: usize) {
        // SAFETY: as in `write`.
        unsafe { self.canvas.planes.read(pixels, stride, self.rect) };
    }

    /// Copies the pixels to the picture.
    pub fn write(&mut self, pixels: &Planes, stride: usize) {
        // SAFETY: the tiles of a grid do not overlap, and each can be claimed only once.
        unsafe { self.canvas.planes.write(pixels, stride, self.rect) };
    }
}
