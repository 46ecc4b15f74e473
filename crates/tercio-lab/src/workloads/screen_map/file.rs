//! Screen maps as text.

use std::fmt::Write;
use std::path::Path;

use super::{MapError, ScreenMap};
use crate::workloads::text::{lines, missing};
use crate::workloads::{PixelBox, ReadError, SyntaxError, error};

impl ScreenMap {
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
    /// [`SyntaxError`], with the line of the rectangle that is at fault.
    pub fn parse(text: &str) -> Result<Self, SyntaxError> {
        let (mut rectangles, mut places) = (Vec::new(), Vec::new());
        for mut line in lines(text) {
            let owner: u32 = line.number("the number of a processor")?;
            if owner >= 1 << 24 {
                return Err(line.wrong("a processor below 16777216", owner));
            }
            let (first, last) = (line.point()?, line.point()?);
            line.end()?;
            let pixels = PixelBox::new(first, last).ok_or_else(|| {
                line.wrong("a last pixel right of and below the first", format!("{last:?}"))
            })?;
            rectangles.push((owner, pixels));
            places.push(line);
        }
        Self::of_rectangles(&rectangles).map_err(|error| match error {
            MapError::Outside { rectangle } | MapError::Overlap { rectangle, .. } => {
                places[rectangle].wrong("every pixel with precisely one processor", error)
            }
            _ => missing(text, format!("every pixel with precisely one processor ({error})")),
        })
    }

    /// The text of a file: one line a cell.
    pub fn to_text(&self) -> String {
        let mut text = String::new();
        for (place, owner) in self.owners.iter().enumerate() {
            let columns = self.starts_x.len() - 1;
            let (i, j) = (place % columns, place / columns);
            let (x0, y0) = (self.starts_x[i], self.starts_y[j]);
            let (x1, y1) = (self.starts_x[i + 1] - 1, self.starts_y[j + 1] - 1);
            let _ = writeln!(text, "{owner} ({x0}, {y0}) ({x1}, {y1})");
        }
        text
    }
}
