//! Whole screen polygons: a model's polygons after the front end, before rasterization.
//!
//! ```text
//! Screen=512x512 NumPolygons=2
//! 1 (10,20,0.5) (30.5,20,0.5) (10,40.25,0.75)
//! 0 (1,2,0) (4,2,0) (4,8.00390625,0)
//! ```
//!
//! The first line gives the screen in pixels and the number of polygons; then comes one line a polygon: 1 if its
//! front is seen and 0 if its back, and its corners in order as `(x,y,depth)`. Coordinates are in pixels from the
//! screen's upper left corner, y downwards, and are whole multiples of 1/256 (the reader rounds to the nearest);
//! they may lie outside the screen. Depth is linear in screen space and larger is nearer. Polygons of documents
//! 002 and 003 are convex; document 004 draws any by the even-odd rule.

use std::fmt::Write;
use std::path::Path;

use super::text::{lines, missing};
use super::{BoundingBox, BoxScene, MAX_SCREEN_PIXELS, PixelBox, ReadError, SyntaxError, error};

/// Sub-pixels along a pixel's side.
pub const SUBPIXELS: i32 = 256;
/// Coordinates reach at most this many pixels from the upper left corner.
const MAX_PIXELS: f64 = 65_536.0;

/// A corner of a polygon.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScreenPoint {
    /// Sub-pixels ([`SUBPIXELS`] a pixel) from the left of the screen.
    pub x: i32,
    /// Sub-pixels from the top of the screen.
    pub y: i32,
    /// Larger is nearer.
    pub depth: f32,
}

impl ScreenPoint {
    /// The point at whole pixels, at depth 0.
    pub fn at_pixel(x: i32, y: i32) -> Self {
        Self { x: x * SUBPIXELS, y: y * SUBPIXELS, depth: 0.0 }
    }

    /// Column and row of the pixel in which the point lies.
    pub fn pixel(&self) -> [i32; 2] {
        [self.x.div_euclid(SUBPIXELS), self.y.div_euclid(SUBPIXELS)]
    }
}

/// A polygon of at least one corner.
#[derive(Clone, Debug, PartialEq)]
pub struct ScreenPolygon {
    /// Whether its front is visible.
    pub front: bool,
    /// Its corners, in order round it.
    pub corners: Vec<ScreenPoint>,
}

/// All polygons of a model that the screen may show, in the model's order.
#[derive(Clone, Debug, PartialEq)]
pub struct PolygonScene {
    /// Pixels across the screen.
    pub width: u32,
    /// Pixels down the screen.
    pub height: u32,
    /// The polygons.
    pub polygons: Vec<ScreenPolygon>,
}

impl ScreenPolygon {
    /// A polygon with its front to the viewer and its corners at whole pixels, at depth 0.
    pub fn at_pixels(corners: &[[i32; 2]]) -> Self {
        let corners = corners.iter().map(|&[x, y]| ScreenPoint::at_pixel(x, y)).collect();
        Self { front: true, corners }
    }

    /// The pixels between the minimum and the maximum of the corners.
    ///
    /// # Panics
    /// If the polygon has no corner.
    pub fn bounds(&self) -> PixelBox {
        let pixel = self.corners[0].pixel();
        let mut bounds = PixelBox { x0: pixel[0], y0: pixel[1], x1: pixel[0], y1: pixel[1] };
        for [x, y] in self.corners.iter().map(ScreenPoint::pixel) {
            bounds = PixelBox {
                x0: bounds.x0.min(x),
                y0: bounds.y0.min(y),
                x1: bounds.x1.max(x),
                y1: bounds.y1.max(y),
            };
        }
        bounds
    }
}

impl PolygonScene {
    /// The polygons' bounding boxes. Those that show their back or are outside the screen are culled.
    pub fn boxes(&self) -> BoxScene {
        let screen = PixelBox::screen(self.width, self.height);
        let boxes = self.polygons.iter().map(|p| {
            let pixels = p.bounds();
            BoundingBox { visible: p.front && pixels.intersection(&screen).is_some(), pixels }
        });
        BoxScene { boxes: boxes.collect() }
    }

    /// Reads a file.
    ///
    /// # Errors
    /// [`ReadError`].
    pub fn read(file: impl AsRef<Path>) -> Result<Self, ReadError> {
        error::read(file.as_ref(), Self::parse)
    }

    /// Reads the text of a file.
    ///
    /// # Errors
    /// [`SyntaxError`]: a line that is no polygon, or more or fewer lines than the first one states.
    pub fn parse(text: &str) -> Result<Self, SyntaxError> {
        let mut lines = lines(text);
        let mut head = lines.next().ok_or_else(|| missing(text, "\"Screen=\""))?;
        head.literal("Screen")?;
        head.literal("=")?;
        let screen: String = head.number("the screen's size, WIDTHxHEIGHT")?;
        let side = |s: &str| s.parse::<u32>().ok().filter(|s| (1..=MAX_PIXELS as u32).contains(s));
        let sides = screen.split_once('x').and_then(|(w, h)| Some((side(w)?, side(h)?)));
        let (width, height) = sides.ok_or_else(|| head.wrong("a size WIDTHxHEIGHT in pixels", &screen))?;
        if u64::from(width) * u64::from(height) > MAX_SCREEN_PIXELS {
            return Err(head.wrong(format!("a screen of at most {MAX_SCREEN_PIXELS} pixels"), &screen));
        }
        head.literal("NumPolygons")?;
        head.literal("=")?;
        let count: u64 = head.number("the number of polygons")?;
        head.end()?;
        let mut polygons = Vec::new();
        for mut line in lines {
            if polygons.len() as u64 == count {
                return Err(line.wrong(format!("the end after {count} polygons"), "one more"));
            }
            let front = match line.number("1 (front) or 0 (back)")? {
                0u8 => false,
                1 => true,
                other => return Err(line.wrong("1 (front) or 0 (back)", other)),
            };
            let mut corners = Vec::new();
            while line.end().is_err() {
                line.literal("(")?;
                let mut coordinate = |name: &str| {
                    let value: f64 = line.number(name)?;
                    let snapped = (value * f64::from(SUBPIXELS)).round_ties_even();
                    if value.abs() <= MAX_PIXELS {
                        line.literal(",")?;
                        Ok(snapped as i32)
                    } else {
                        Err(line.wrong(format!("{name} of at most {MAX_PIXELS} pixels"), value))
                    }
                };
                let (x, y) = (coordinate("x")?, coordinate("y")?);
                let depth: f32 = line.number("a depth")?;
                if !depth.is_finite() {
                    return Err(line.wrong("a finite depth", depth));
                }
                line.literal(")")?;
                corners.push(ScreenPoint { x, y, depth });
            }
            if corners.is_empty() {
                return Err(line.error("a corner (x,y,depth)"));
            }
            polygons.push(ScreenPolygon { front, corners });
        }
        if (polygons.len() as u64) < count {
            return Err(missing(text, format!("polygon {} of {count}", polygons.len() + 1)));
        }
        Ok(Self { width, height, polygons })
    }

    /// The text of a file.
    pub fn to_text(&self) -> String {
        let mut text = format!("Screen={}x{} NumPolygons={}\n", self.width, self.height, self.polygons.len());
        for polygon in &self.polygons {
            text.push(if polygon.front { '1' } else { '0' });
            for &ScreenPoint { x, y, depth } in &polygon.corners {
                let [x, y] = [x, y].map(|v| f64::from(v) / f64::from(SUBPIXELS));
                let _ = write!(text, " ({x},{y},{depth})");
            }
            text.push('\n');
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn boxes_of_polygons() {
        let polygon =
            |front, corners: &[[i32; 2]]| ScreenPolygon { front, ..ScreenPolygon::at_pixels(corners) };
        let scene = PolygonScene {
            width: 20,
            height: 10,
            polygons: vec![
                polygon(true, &[[4, 5], [10, 5], [7, 14]]),
                polygon(false, &[[1, 1], [2, 2], [1, 2]]),
                polygon(true, &[[20, 1], [25, 2], [21, 2]]),
            ],
        };
        let boxes = scene.boxes().boxes;
        assert_eq!(boxes[0].pixels, PixelBox { x0: 4, y0: 5, x1: 10, y1: 14 });
        assert_eq!(boxes.iter().map(|b| b.visible).collect::<Vec<_>>(), [true, false, false]);
    }

    #[test]
    fn coordinates_are_rounded_to_sub_pixels() {
        let scene = PolygonScene::parse("Screen=8x8 NumPolygons=1\n1 (0.001,-0.5,0.25)\n").unwrap();
        assert_eq!(scene.polygons[0].corners, [ScreenPoint { x: 0, y: -128, depth: 0.25 }]);
        assert_eq!(scene.polygons[0].corners[0].pixel(), [0, -1]);
    }

    #[test]
    fn mistakes_are_reported_with_their_line() {
        let cases = [
            (
                "Screen=65536x65536 NumPolygons=1",
                "line 1: expected a screen of at most 67108864 pixels, found 65536x65536",
            ),
            ("Screen=8x0 NumPolygons=1", "line 1: expected a size WIDTHxHEIGHT in pixels, found 8x0"),
            (
                "Screen=8x8 NumPolygons=1\n1 \n",
                "line 2: expected a corner (x,y,depth), found the end of the line",
            ),
            ("Screen=8x8 NumPolygons=1\n1 (1,2)\n", "line 2: expected \",\", found \")\""),
            ("Screen=8x8 NumPolygons=1\n1 (1,2,nan)\n", "line 2: expected a finite depth, found NaN"),
            (
                "Screen=8x8 NumPolygons=1\n1 (inf,2,1)\n",
                "line 2: expected x of at most 65536 pixels, found inf",
            ),
            ("Screen=8x8 NumPolygons=2\n1 (1,2,0)\n", "line 3: expected polygon 2 of 2, found the end"),
        ];
        for (text, message) in cases {
            assert_eq!(PolygonScene::parse(text).unwrap_err().to_string(), message, "{text:?}");
        }
    }

    proptest! {
        #[test]
        fn what_is_written_is_read(polygons in prop::collection::vec(
            (any::<bool>(), prop::collection::vec((-99999i32..99999, -99999i32..99999, 0f32..1.0), 1..6)), 0..20))
        {
            let polygons = polygons.into_iter().map(|(front, corners)| ScreenPolygon {
                front,
                corners: corners.into_iter().map(|(x, y, depth)| ScreenPoint { x, y, depth }).collect(),
            });
            let scene = PolygonScene { width: 7, height: 512, polygons: polygons.collect() };
            prop_assert_eq!(PolygonScene::parse(&scene.to_text()), Ok(scene));
        }
    }
}
