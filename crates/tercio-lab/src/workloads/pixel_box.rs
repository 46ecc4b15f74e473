//! A rectangle of pixels.

/// A rectangle of pixels, inclusive on all sides, so that it is never empty: `x0 <= x1` and `y0 <= y1`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct PixelBox {
    /// First column.
    pub x0: i32,
    /// First row.
    pub y0: i32,
    /// Last column.
    pub x1: i32,
    /// Last row.
    pub y1: i32,
}

impl PixelBox {
    /// The box between two pixels, `None` if the second is left of or above the first.
    pub fn new([x0, y0]: [i32; 2], [x1, y1]: [i32; 2]) -> Option<Self> {
        (x0 <= x1 && y0 <= y1).then_some(Self { x0, y0, x1, y1 })
    }

    /// All pixels of a screen.
    ///
    /// # Panics
    /// If the screen has no pixel.
    pub fn screen(width: u32, height: u32) -> Self {
        assert!(width > 0 && height > 0, "a screen has pixels");
        Self { x0: 0, y0: 0, x1: (width - 1) as i32, y1: (height - 1) as i32 }
    }

    /// Columns.
    pub fn width(&self) -> u64 {
        self.x1.abs_diff(self.x0) as u64 + 1
    }

    /// Rows.
    pub fn height(&self) -> u64 {
        self.y1.abs_diff(self.y0) as u64 + 1
    }

    /// Pixels.
    pub fn area(&self) -> u64 {
        self.width() * self.height()
    }

    /// The pixels of both boxes.
    pub fn intersection(&self, other: &Self) -> Option<Self> {
        let min = [self.x0.max(other.x0), self.y0.max(other.y0)];
        Self::new(min, [self.x1.min(other.x1), self.y1.min(other.y1)])
    }
}
