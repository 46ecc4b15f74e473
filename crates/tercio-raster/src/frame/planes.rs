//! The planes of a frame: their list, and what is done with all of them.
//!
//! A further plane is a further line of the list below; what draws it fills its samples.

use std::sync::atomic::{AtomicBool, Ordering};

use tercio_scene::Background;

use super::shared::SharedPlane;
use super::{Frame, NO_PRIMITIVE};
use crate::screen::{PixelRect, TileGrid};

macro_rules! planes {
    ($($(#[$doc:meta])* $name:ident: $type:ty, wanted: $wanted:literal, background: $row:ident => $background:expr;)*) => {
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
            /// All there are.
            pub const ALL: Self = Self { $($name: true,)* };
            /// None at all.
            pub const NONE: Self = Self { $($name: false,)* };

            /// Bytes of a pixel in all planes.
            pub fn pixel_bytes(&self) -> usize {
                0 $(+ if self.$name { size_of::<$type>() } else { 0 })*
            }
        }

        /// Planes of pixels, row by row; those that nobody asked for are empty.
        #[derive(Clone, Debug, Default, PartialEq)]
        pub struct Planes {
            $($(#[$doc])* pub $name: Vec<$type>,)*
        }

        impl Planes {
            /// Gives the planes that are asked for so many pixels. What they hold is of no use.
            pub(crate) fn resize(&mut self, outputs: &Outputs, pixels: usize) {
                $(self.$name.resize(if outputs.$name { pixels } else { 0 }, <$type>::default());)*
            }

            /// Sets a pixel in the planes that there are.
            pub(crate) fn put(&mut self, place: usize, pixel: &Pixel) {
                $(if let Some(place) = self.$name.get_mut(place) {
                    *place = pixel.$name;
                })*
            }

            /// Sets neighbouring pixels in the planes that there are.
            pub fn fill(&mut self, places: std::ops::Range<usize>, pixel: &Pixel) {
                $(if let Some(places) = self.$name.get_mut(places.clone()) {
                    places.fill(pixel.$name);
                })*
            }

            /// Appends the samples of neighbouring pixels, plane after plane, those that are asked for: in the byte order
            /// of the machine.
            ///
            /// # Panics
            /// If a plane that is asked for does not have these pixels.
            pub fn write_bytes(&self, outputs: &Outputs, places: std::ops::Range<usize>, out: &mut Vec<u8>) {
                $(if outputs.$name {
                    out.extend_from_slice(bytemuck::cast_slice(&self.$name[places.clone()]));
                })*
            }

            /// Takes over from bytes of [`Planes::write_bytes`] the pixels, from place `first` on, for which `takes` is
            /// true.
            ///
            /// # Panics
            /// If a plane that is asked for does not have these pixels, or the bytes are fewer than they need.
            pub fn read_bytes(&mut self, outputs: &Outputs, mut bytes: &[u8], takes: &[bool], first: usize) {
                $(if outputs.$name {
                    let (own, rest) = bytes.split_at(takes.len() * size_of::<$type>());
                    bytes = rest;
                    let places = self.$name[first..first + takes.len()].iter_mut();
                    for ((place, sample), &takes) in places.zip(own.chunks_exact(size_of::<$type>())).zip(takes) {
                        if takes {
                            *place = bytemuck::pod_read_unaligned(sample);
                        }
                    }
                })*
                let _ = bytes;
            }

            /// In words, the first plane in which two frames differ and the first place there; numbers are compared by
            /// their bits.
            pub(crate) fn first_difference(&self, other: &Self) -> Option<(String, usize)> {
                $(
                    let (own, others) = (&self.$name, &other.$name);
                    if own.len() != others.len() {
                        let found = format!("{} of {} pixels, not {}", stringify!($name), own.len(), others.len());
                        return Some((found, 0));
                    }
                    let differs = |&place: &usize| {
                        bytemuck::bytes_of(&own[place]) != bytemuck::bytes_of(&others[place])
                    };
                    if let Some(place) = (0..own.len()).find(differs) {
                        let count = (0..own.len()).filter(differs).count();
                        let found = format!(
                            "{count} pixels differ in {}, first {:?}, not {:?}",
                            stringify!($name), own[place], others[place],
                        );
                        return Some((found, place));
                    }
                )*
                None
            }
        }

        /// A sample of every plane.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct Pixel {
            $($(#[$doc])* pub $name: $type,)*
        }

        impl Pixel {
            /// What stands where nothing was drawn, in a row of a picture.
            pub fn of_background(background: &Background, y: u32, height: u32) -> Self {
                let row = BackgroundRow::new(background, y, height);
                Self { $($name: { let $row = &row; let _ = $row; $background },)* }
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
            /// No other thread writes in this rectangle.
            unsafe fn fill(&self, rows: &[Pixel], rect: PixelRect) {
                $(
                    // SAFETY: as the caller promises.
                    unsafe { fill(rows.iter().map(|row| row.$name), rect, &self.$name) };
                )*
            }

            /// Copies the pixels of a tile, of which a row begins every `stride` places, to their places in the picture.
            ///
            /// # Safety
            /// No other thread writes in this rectangle.
            unsafe fn write(&self, tile: &Planes, stride: usize, rect: PixelRect) {
                $(
                    // SAFETY: as the caller promises.
                    unsafe { copy(&tile.$name, stride, rect, &self.$name) };
                )*
            }
        }

        /// Fills the pixels of a tile: one pixel for each of its rows, and `stride` places a row.
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
    /// Visibility keys ([`super::visibility_key`]), by which pictures of parts are composed; 0 where nothing was drawn.
    keys: u64, wanted: false, background: _row => 0;
    /// sRGB colour, 8 bits, alpha not multiplied in.
    color: [u8; 4], wanted: true, background: row => row.level(255.0).map(|c| c as u8);
    /// sRGB colour, 16 bits, alpha not multiplied in.
    color16: [u16; 4], wanted: false, background: row => row.level(65535.0).map(|c| c as u16);
    /// Distance from the eye along the line of sight in world units; infinite where nothing was drawn.
    depth: f32, wanted: false, background: _row => f32::INFINITY;
    /// Number of the input face (polygon) that is seen, counted through the instances in order;
    /// [`NO_PRIMITIVE`] where nothing was drawn.
    ids: u32, wanted: false, background: _row => NO_PRIMITIVE;
    /// Unit normals in world space, those that the picture is lit by: see [`crate::conventions`]. None points away from
    /// the viewer but for rounding; zero where nothing was drawn.
    normals: [f32; 3], wanted: false, background: _row => [0.0; 3];
}

/// The background of a row: mixed in sRGB, as a designer's gradient is.
struct BackgroundRow([f32; 4]);

impl BackgroundRow {
    fn new(background: &Background, y: u32, height: u32) -> Self {
        Self(match *background {
            Background::Solid(color) => color,
            Background::Gradient { top, bottom } => {
                let t = (y as f32 + 0.5) / height as f32;
                std::array::from_fn(|k| top[k] + (bottom[k] - top[k]) * t)
            }
        })
    }

    fn level(&self, most: f32) -> [f32; 4] {
        self.0.map(|c| c.clamp(0.0, 1.0) * most + 0.5)
    }
}

/// Copies the rows of a tile.
///
/// # Safety
/// No other thread writes in this rectangle.
unsafe fn copy<T: Copy>(tile: &[T], stride: usize, rect: PixelRect, plane: &SharedPlane<T>) {
    if !plane.is_wanted() {
        return;
    }
    let width = (rect.x1 - rect.x0 + 1) as usize;
    for (row, y) in tile.chunks_exact(stride).zip(rect.y0..) {
        // SAFETY: no other thread holds a part of the rectangle, as the caller promises, and the row is let go at once.
        unsafe { plane.row(rect.x0 as usize, y as usize, width) }.copy_from_slice(&row[..width]);
    }
}

/// Fills the rows of a tile with a value each.
///
/// # Safety
/// No other thread writes in this rectangle.
unsafe fn fill<T: Copy>(rows: impl Iterator<Item = T>, rect: PixelRect, plane: &SharedPlane<T>) {
    if !plane.is_wanted() {
        return;
    }
    let width = (rect.x1 - rect.x0 + 1) as usize;
    for (value, y) in rows.zip(rect.y0..) {
        // SAFETY: no other thread holds a part of the rectangle, as the caller promises, and the row is let go at once.
        unsafe { plane.row(rect.x0 as usize, y as usize, width) }.fill(value);
    }
}

/// A frame that is drawn tile by tile, by several threads.
pub struct Canvas<'a> {
    planes: SharedPlanes<'a>,
    outputs: Outputs,
    grid: TileGrid,
    /// Pixels across and down.
    size: [u32; 2],
    /// What stands in each row where nothing was drawn.
    background: Vec<Pixel>,
    /// Which tiles were handed out: each is written once.
    claimed: Vec<AtomicBool>,
}

/// A tile of a [`Canvas`] that one thread may write.
pub struct CanvasTile<'a> {
    canvas: &'a Canvas<'a>,
    rect: PixelRect,
}

impl<'a> Canvas<'a> {
    /// The planes of a frame, which have their size.
    pub fn new(frame: &'a mut Frame, outputs: &Outputs, background: &Background, grid: &TileGrid) -> Self {
        let size = [frame.width, frame.height];
        Self {
            planes: SharedPlanes::new(&mut frame.planes, size[0] as usize, size[1] as usize),
            outputs: *outputs,
            grid: grid.clone(),
            size,
            background: (0..size[1]).map(|y| Pixel::of_background(background, y, size[1])).collect(),
            claimed: (0..grid.count()).map(|_| AtomicBool::new(false)).collect(),
        }
    }

    /// Which planes it has.
    #[inline(always)]
    pub fn outputs(&self) -> &Outputs {
        &self.outputs
    }

    /// A tile to be written.
    ///
    /// # Panics
    /// If it was handed out before.
    pub fn claim(&self, tile: u32) -> CanvasTile<'_> {
        let claimed = self.claimed[tile as usize].swap(true, Ordering::Relaxed);
        assert!(!claimed, "tile {tile} is drawn twice");
        CanvasTile { canvas: self, rect: self.grid.rect(tile, self.size) }
    }
}

impl CanvasTile<'_> {
    /// Makes the pixels of the tile background, with `stride` places from a row to the next.
    pub fn clear(&self, pixels: &mut Planes, stride: usize) {
        clear(pixels, &self.canvas.outputs, self.background(), stride);
    }

    /// What stands in each row where nothing was drawn.
    fn background(&self) -> &[Pixel] {
        &self.canvas.background[self.rect.y0 as usize..=self.rect.y1 as usize]
    }

    /// Writes background only.
    pub fn write_background(self) {
        // SAFETY: as in `write`.
        unsafe { self.canvas.planes.fill(self.background(), self.rect) };
    }

    /// Copies the pixels to their place in the picture.
    pub fn write(self, pixels: &Planes, stride: usize) {
        // SAFETY: tiles of a grid do not overlap, and there is one of these for each of them.
        unsafe { self.canvas.planes.write(pixels, stride, self.rect) };
    }
}
