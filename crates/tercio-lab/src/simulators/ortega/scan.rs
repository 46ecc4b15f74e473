//! Segments of a polygon by the even-odd rule (document 004, section 4, scan conversion).

use crate::workloads::polygons::SUBPIXELS;
use crate::workloads::{ScreenPoint, ScreenPolygon};

/// A run of pixels of one polygon on one line. A pixel belongs to it if its centre does; centres on its left end belong
/// to it, those on its right end do not, so that neighbours share no pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// Number of the polygon.
    pub polygon: u32,
    /// The line of pixels.
    pub y: i32,
    /// First pixel.
    pub first: i32,
    /// Number of pixels; 0 if it contains no centre.
    pub length: u32,
    /// Depth at the centre of the first pixel.
    pub depth: f64,
    /// Change of depth per pixel.
    pub depth_step: f64,
}

/// An end of a segment: sub-pixels from the left as an exact fraction, and the depth at this point.
#[derive(Clone, Copy, Debug)]
struct End {
    numerator: i64,
    denominator: i64,
    depth: f64,
}

impl End {
    fn x(&self) -> f64 {
        self.numerator as f64 / self.denominator as f64
    }

    /// First pixel whose centre is at or right of it.
    fn first_pixel(&self) -> i32 {
        let half = i64::from(SUBPIXELS / 2) * self.denominator;
        let side = i64::from(SUBPIXELS) * self.denominator;
        -(-(self.numerator - half)).div_euclid(side) as i32
    }
}

/// The first line whose centre is at or below a coordinate.
fn first_line(y: i32) -> i32 {
    (y - SUBPIXELS / 2 + SUBPIXELS - 1).div_euclid(SUBPIXELS)
}

/// The polygon's lines of pixels: the first one and their number.
pub fn lines(polygon: &ScreenPolygon) -> (i32, u32) {
    let ys = || polygon.corners.iter().map(|c| c.y);
    let first = first_line(ys().min().unwrap_or(0));
    (first, (first_line(ys().max().unwrap_or(0)) - first) as u32)
}

/// Adds the segments of a polygon on one line: crossings with its sides from left to right, in pairs.
pub fn segments(polygon: &ScreenPolygon, number: u32, line: i32, into: &mut Vec<Segment>) {
    let middle = line * SUBPIXELS + SUBPIXELS / 2;
    let corners = &polygon.corners;
    let mut ends: Vec<End> = (0..corners.len())
        .map(|i| (corners[i], corners[(i + 1) % corners.len()]))
        .filter(|(a, b)| (a.y <= middle) != (b.y <= middle))
        .map(|(a, b)| crossing(a, b, middle))
        .collect();
    // Fractions are compared exactly; equal ones bound an empty segment in either order.
    ends.sort_by(|a, b| {
        let left = i128::from(a.numerator) * i128::from(b.denominator);
        left.cmp(&(i128::from(b.numerator) * i128::from(a.denominator)))
    });
    for pair in ends.chunks_exact(2) {
        let (first, end) = (pair[0].first_pixel(), pair[1].first_pixel());
        let width = pair[1].x() - pair[0].x();
        let slope = if width > 0.0 { (pair[1].depth - pair[0].depth) / width } else { 0.0 };
        let to_middle = f64::from(first) * f64::from(SUBPIXELS) + f64::from(SUBPIXELS / 2) - pair[0].x();
        into.push(Segment {
            polygon: number,
            y: line,
            first,
            length: (end - first) as u32,
            depth: pair[0].depth + slope * to_middle,
            depth_step: slope * f64::from(SUBPIXELS),
        });
    }
}

/// Where a side crosses the centre of a line. The lower end comes first, so that both polygons at a side agree.
fn crossing(a: ScreenPoint, b: ScreenPoint, middle: i32) -> End {
    let (a, b) = if a.y < b.y { (a, b) } else { (b, a) };
    let denominator = i64::from(b.y) - i64::from(a.y);
    let along = i64::from(middle) - i64::from(a.y);
    let numerator = i64::from(a.x) * denominator + along * (i64::from(b.x) - i64::from(a.x));
    let (near, far) = (f64::from(a.depth), f64::from(b.depth));
    End { numerator, denominator, depth: near + (far - near) * (along as f64 / denominator as f64) }
}
