//! Bounding boxes of polygons, as document 000 (Eldridge 1995, appendix A.1.1, figure A-1) writes them.
//!
//! ```text
//! NumPolygons=2
//! 0 (406,163) (407,164)
//! 1 (413,166) (418,171)
//! ```
//!
//! One line per polygon of the model: 1 if it is visible and 0 if it was culled, then the first and the last pixel of
//! its box, both inclusive. Culled polygons stay in the file because rejecting them costs geometry work. Empty lines
//! and comments after a `#` are skipped, an extension of the document's format.

use std::fmt::Write;
use std::path::Path;

use super::text::{lines, missing};
use super::{PixelBox, ReadError, SyntaxError, error};

/// One polygon.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BoundingBox {
    /// False if it faces away or is outside the view.
    pub visible: bool,
    /// Its pixels; they may extend beyond the screen.
    pub pixels: PixelBox,
}

/// The boxes of all polygons of a model, in the model's order.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct BoxScene {
    /// One a polygon.
    pub boxes: Vec<BoundingBox>,
}

/// A larger number of polygons is considered a mistake in the file's first line.
const MAX_POLYGONS: u64 = u32::MAX as u64 - 1;

impl BoxScene {
    /// Number of visible polygons.
    pub fn visible(&self) -> u64 {
        self.boxes.iter().filter(|b| b.visible).count() as u64
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
    /// [`SyntaxError`]: a line that is no box, or more or fewer lines than the first one states.
    pub fn parse(text: &str) -> Result<Self, SyntaxError> {
        let mut lines = lines(text);
        let mut head = lines.next().ok_or_else(|| missing(text, "\"NumPolygons=\""))?;
        head.literal("NumPolygons")?;
        head.literal("=")?;
        let count: u64 = head.number("the number of polygons")?;
        head.end()?;
        if count > MAX_POLYGONS {
            return Err(head.wrong(format!("at most {MAX_POLYGONS} polygons"), count));
        }
        let mut boxes = Vec::new();
        for mut line in lines {
            if boxes.len() as u64 == count {
                return Err(line.wrong(format!("the end after {count} polygons"), "one more"));
            }
            let visible = match line.number("1 (visible) or 0 (culled)")? {
                0u8 => false,
                1 => true,
                other => return Err(line.wrong("1 (visible) or 0 (culled)", other)),
            };
            let (first, last) = (line.point()?, line.point()?);
            line.end()?;
            let pixels = PixelBox::new(first, last).ok_or_else(|| {
                line.wrong("a last pixel right of and below the first", format!("{last:?}"))
            })?;
            boxes.push(BoundingBox { visible, pixels });
        }
        if (boxes.len() as u64) < count {
            return Err(missing(text, format!("polygon {} of {count}", boxes.len() + 1)));
        }
        Ok(Self { boxes })
    }

    /// The text of a file.
    pub fn to_text(&self) -> String {
        let mut text = format!("NumPolygons={}\n", self.boxes.len());
        for BoundingBox { visible, pixels: PixelBox { x0, y0, x1, y1 } } in &self.boxes {
            let _ = writeln!(text, "{} ({x0},{y0}) ({x1},{y1})", u8::from(*visible));
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Figure A-1.
    const FIGURE_A1: &str = "NumPolygons=7\n0 (406,163) (407,164)\n0 (407,167) (408,167)\n1 (406,182) (415,185)\n\
        1 (413,166) (418,171)\n0 (411,183) (413,186)\n1 (364,219) (370,223)\n1 (381,204) (388,212)\n";

    #[test]
    fn the_file_of_figure_a1() {
        let scene = BoxScene::parse(FIGURE_A1).unwrap();
        assert_eq!((scene.boxes.len(), scene.visible()), (7, 4));
        assert_eq!(scene.boxes[2].pixels, PixelBox { x0: 406, y0: 182, x1: 415, y1: 185 });
        assert_eq!(scene.boxes[2].pixels.area(), 40);
        assert_eq!(scene.to_text(), FIGURE_A1);
    }

    #[test]
    fn mistakes_are_reported_with_their_line() {
        let cases = [
            ("", "line 1: expected \"NumPolygons=\", found the end"),
            ("NumPolygons=x", "line 1: expected the number of polygons, found \"x\""),
            ("NumPolygons=2\n1 (1,2) (3,4)\n", "line 3: expected polygon 2 of 2, found the end"),
            ("NumPolygons=0\n\n1 (1,2) (3,4)\n", "line 3: expected the end after 0 polygons, found one more"),
            ("NumPolygons=1\n2 (1,2) (3,4)\n", "line 2: expected 1 (visible) or 0 (culled), found 2"),
            ("NumPolygons=1\n1 (1,2 (3,4)\n", "line 2: expected \")\", found \"(3,4)\""),
            ("NumPolygons=1\n1 (1,2) (3,x)\n", "line 2: expected y, a whole number of pixels, found \"x)\""),
            ("NumPolygons=1\n1 (1,2) (3,4) 5\n", "line 2: expected the end of the line, found \"5\""),
            (
                "NumPolygons=1\n1 (4,2) (3,4)\n",
                "line 2: expected a last pixel right of and below the first, found [3, 4]",
            ),
            ("NumPolygons=99999999999\n", "line 1: expected at most 4294967294 polygons, found 99999999999"),
        ];
        for (text, message) in cases {
            assert_eq!(BoxScene::parse(text).unwrap_err().to_string(), message, "{text:?}");
        }
    }

    proptest! {
        #[test]
        fn what_is_written_is_read(boxes in prop::collection::vec(
            (any::<bool>(), -9..9000, -9..9000, 0..99, 0..99), 0..40)) {
            let boxes = boxes.into_iter().map(|(visible, x, y, w, h)| BoundingBox {
                visible,
                pixels: PixelBox::new([x, y], [x + w, y + h]).unwrap(),
            });
            let scene = BoxScene { boxes: boxes.collect() };
            prop_assert_eq!(BoxScene::parse(&scene.to_text()), Ok(scene));
        }

        #[test]
        fn no_text_panics(text in "[NumPolygons=0-9(),\n #-]{0,80}") {
            let _ = BoxScene::parse(&text);
        }
    }
}
