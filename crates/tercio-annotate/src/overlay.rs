//! What is drawn onto a picture, or behind it: shapes in the order of drawing, and the pixels they make.

use std::ops::Range;
use std::sync::Arc;

use tercio_mesh::color::srgb_to_linear;
use tercio_mesh::loops::prelude::*;
use tercio_raster::color::DECODE;
use tercio_raster::frame::Planes;
use tercio_raster::{color8, color16};

use crate::font::{Direction, Line};
use crate::outline::Outline;

/// A colour as a function of a place from 0 to 1: linear light, not multiplied by its alpha.
pub type ColorAt = Arc<dyn Fn(f64) -> [f32; 4] + Send + Sync>;

/// How a shape is coloured.
#[derive(Clone)]
pub enum Paint {
    /// Alike everywhere: linear light, not multiplied by its alpha.
    Solid([f32; 4]),
    /// Along a row, or a column if `is_upright`, from one pixel coordinate (0) to another one (1).
    Along {
        /// Whether it changes from row to row.
        is_upright: bool,
        /// Where 0 and 1 are.
        ends: [f64; 2],
        /// The colour there.
        color: ColorAt,
    },
}

struct Shape {
    outline: Outline,
    bounds: [f64; 4],
    paint: Paint,
}

/// Shapes in the order of drawing, for a whole picture of one size.
#[derive(Default)]
pub struct Overlay {
    shapes: Vec<Shape>,
}

impl Overlay {
    /// Whether nothing is drawn.
    pub fn is_empty(&self) -> bool {
        self.shapes.is_empty()
    }

    /// Adds an outline.
    pub fn fill(&mut self, outline: Outline, paint: Paint) {
        let outline = outline.closed();
        if let Some(bounds) = outline.bounds().filter(|bounds| bounds.iter().all(|b| b.is_finite())) {
            self.shapes.push(Shape { outline, bounds, paint });
        }
    }

    /// Adds a rectangle from its left, upper, right and lower border.
    pub fn rectangle(&mut self, [left, top, right, bottom]: [f64; 4], paint: Paint) {
        let corners = [[left, top], [right, top], [right, bottom], [left, bottom]];
        self.fill(Outline::polygon(&corners), paint);
    }

    /// Adds a line.
    pub fn stroke(&mut self, from: [f64; 2], to: [f64; 2], width: f64, color: [f32; 4]) {
        self.fill(Outline::stroke(from, to, width), Paint::Solid(color));
    }

    /// Adds a text, whose baseline begins at `at`, with so many pixels an em.
    pub fn text(&mut self, line: &Line, at: [f64; 2], em: f64, direction: Direction, color: [f32; 4]) {
        self.fill(line.outline(at, em, direction), Paint::Solid(color));
    }

    /// Left, upper, right and lower border of all shapes.
    pub fn bounds(&self) -> Option<[f64; 4]> {
        self.shapes
            .iter()
            .map(|shape| shape.bounds)
            .reduce(|a, b| [a[0].min(b[0]), a[1].min(b[1]), a[2].max(b[2]), a[3].max(b[3])])
    }

    /// The polygons of each shape, in the order of drawing: what any of them encloses is filled, and those in the opposite direction
    /// are holes.
    pub fn areas(&self) -> impl Iterator<Item = (Vec<Vec<[f64; 2]>>, &Paint)> {
        self.shapes.iter().map(|shape| (shape.outline.polygons(), &shape.paint))
    }

    /// Draws onto the colours of a band of rows of a picture of this width: in linear light, on the colours that the picture has,
    /// of 8 or 16 bits. What is not drawn on keeps its bytes.
    ///
    /// # Panics
    /// If a plane of colours does not have these pixels.
    pub fn draw(&self, planes: &mut Planes, width: u32, rows: Range<u32>) {
        self.each_row(&mut planes.color, width, &rows, |pixel, front| {
            *pixel = color8(over(front, from8(*pixel)));
        });
        self.each_row(&mut planes.color16, width, &rows, |pixel, front| {
            *pixel = color16(over(front, from16(*pixel)));
        });
    }

    /// Draws behind the colours of a whole picture of this width, which has a plane of linear light and was drawn on a transparent
    /// background: where it is opaque, nothing is seen of the shapes.
    ///
    /// # Panics
    /// If a plane of colours does not have these pixels, or there is no linear one.
    pub fn draw_behind(&self, planes: &mut Planes, width: u32, height: u32) {
        let rows = 0..height;
        let pixels = width as usize * height as usize;
        assert_eq!(planes.linear.len(), pixels, "a linear colour for each pixel");
        // The first shape is the farthest.
        let farthest_last = Self { shapes: self.shapes.iter().rev().map(Shape::again).collect() };
        farthest_last.each_row(&mut planes.linear, width, &rows, |pixel, behind| {
            if pixel[3] < 1.0 {
                *pixel = over(*pixel, behind);
            }
        });
        let changed = self.rows(height);
        let range = changed.start as usize * width as usize..changed.end as usize * width as usize;
        let linear = &planes.linear[range.clone()];
        if let Some(narrow) = planes.color.get_mut(range.clone()) {
            narrow.par_iter_mut().zip(linear).for_each(|(narrow, linear)| *narrow = color8(*linear));
        }
        if let Some(wide) = planes.color16.get_mut(range) {
            wide.par_iter_mut().zip(linear).for_each(|(wide, linear)| *wide = color16(*linear));
        }
    }

    /// The rows on which something is drawn.
    fn rows(&self, height: u32) -> Range<u32> {
        let Some([_, top, _, bottom]) = self.bounds() else { return 0..0 };
        let limit = |y: f64| y.clamp(0.0, f64::from(height)) as u32;
        limit(top.floor())..limit(bottom.ceil())
    }

    /// Calls `put` with each pixel of a plane that a shape covers, and the shape's premultiplied light there.
    fn each_row<T: Send>(
        &self,
        plane: &mut [T],
        width: u32,
        rows: &Range<u32>,
        put: impl Fn(&mut T, [f32; 4]) + Sync,
    ) {
        if plane.is_empty() || self.shapes.is_empty() {
            return;
        }
        assert_eq!(plane.len(), width as usize * rows.len(), "a colour for each pixel");
        plane.par_chunks_mut(width as usize).enumerate().for_each(|(number, pixels)| {
            let row = rows.start + number as u32;
            let (top, bottom) = (f64::from(row), f64::from(row) + 1.0);
            let mut cover = Vec::new();
            for shape in self.shapes.iter().filter(|s| s.bounds[1] < bottom && s.bounds[3] > top) {
                cover.clear();
                let Some(first) = shape.outline.cover(row, width, &mut cover) else { continue };
                for (column, &cover) in (first..).zip(&cover).filter(|(_, cover)| **cover > 0.0) {
                    put(&mut pixels[column], shape.light(column, row, cover));
                }
            }
        });
    }
}

impl Shape {
    /// The premultiplied light of the shape in a pixel of which it covers a share.
    fn light(&self, column: usize, row: u32, cover: f32) -> [f32; 4] {
        let [r, g, b, alpha] = match &self.paint {
            Paint::Solid(color) => *color,
            Paint::Along { is_upright, ends: [from, to], color } => {
                let at = if *is_upright { f64::from(row) } else { column as f64 } + 0.5;
                color(((at - from) / (to - from)).clamp(0.0, 1.0))
            }
        };
        let alpha = alpha * cover;
        [r * alpha, g * alpha, b * alpha, alpha]
    }

    fn again(&self) -> Self {
        Self { outline: self.outline.clone(), bounds: self.bounds, paint: self.paint.clone() }
    }
}

/// A premultiplied colour before another one.
fn over(front: [f32; 4], behind: [f32; 4]) -> [f32; 4] {
    let left = 1.0 - front[3];
    std::array::from_fn(|k| front[k] + behind[k] * left)
}

/// Premultiplied linear light of an 8-bit colour.
fn from8([r, g, b, alpha]: [u8; 4]) -> [f32; 4] {
    let alpha = f32::from(alpha) / 255.0;
    let [r, g, b] = [r, g, b].map(|level| DECODE[usize::from(level)] * alpha);
    [r, g, b, alpha]
}

/// Premultiplied linear light of a 16-bit colour.
fn from16([r, g, b, alpha]: [u16; 4]) -> [f32; 4] {
    let alpha = f32::from(alpha) / 65535.0;
    let [r, g, b] = [r, g, b].map(|level| srgb_to_linear(f64::from(level) / 65535.0) as f32 * alpha);
    [r, g, b, alpha]
}
