//! A polygon and its scan lines (document 002, sections 2.1 and 2.2).

use crate::workloads::{PolygonScene, ScreenPolygon};

/// A convex polygon with its corners at whole pixels, y upwards. No corner occurs twice; one or two corners are
/// allowed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Polygon {
    corners: Vec<[i32; 2]>,
}

/// The pixels of a polygon on one scan line, inclusive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Span {
    /// The line.
    pub y: i32,
    /// First pixel.
    pub first: i32,
    /// Last pixel.
    pub last: i32,
}

/// A position along a line or a column, as a fraction with a positive denominator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fraction {
    numerator: i64,
    denominator: i64,
}

impl Fraction {
    /// The whole number at or below.
    pub fn floor(&self) -> i32 {
        self.numerator.div_euclid(self.denominator) as i32
    }

    /// Whether it is at most `value`.
    pub fn at_most(&self, value: i32) -> bool {
        self.numerator <= i64::from(value) * self.denominator
    }

    /// Whether it is at least `value`.
    pub fn at_least(&self, value: i32) -> bool {
        self.numerator >= i64::from(value) * self.denominator
    }
}

/// Where the line through two points has coordinate `at` along one axis: its coordinate along the other. The points
/// differ along the first axis.
pub fn crossing(a: [i32; 2], b: [i32; 2], axis: usize, at: i32) -> Fraction {
    let other = 1 - axis;
    let (low, high) = if a[axis] < b[axis] { (a, b) } else { (b, a) };
    let denominator = i64::from(high[axis]) - i64::from(low[axis]);
    let run = i64::from(high[other]) - i64::from(low[other]);
    let numerator = i64::from(low[other]) * denominator + (i64::from(at) - i64::from(low[axis])) * run;
    Fraction { numerator, denominator }
}

impl Polygon {
    /// The polygon with these corners; duplicates are removed. `None` without corners.
    pub fn new(corners: impl IntoIterator<Item = [i32; 2]>) -> Option<Self> {
        let mut distinct = Vec::new();
        for corner in corners {
            if !distinct.contains(&corner) {
                distinct.push(corner);
            }
        }
        (!distinct.is_empty()).then_some(Self { corners: distinct })
    }

    /// A screen polygon with its corners at the pixels in which they lie, on a screen of this height.
    pub fn on_screen(polygon: &ScreenPolygon, height: u32) -> Option<Self> {
        let up = |[x, y]: [i32; 2]| [x, height as i32 - 1 - y];
        Self::new(polygon.corners.iter().map(|c| up(c.pixel())))
    }

    /// The input of the machines: the polygons of a scene that show their front (section 2.1).
    pub fn of_scene(scene: &PolygonScene) -> Vec<Self> {
        let fronts = scene.polygons.iter().filter(|p| p.front);
        fronts.filter_map(|p| Self::on_screen(p, scene.height)).collect()
    }

    /// The corners, in order round it.
    pub fn corners(&self) -> &[[i32; 2]] {
        &self.corners
    }

    /// The polygon's sides; a point has one from itself to itself, a line two.
    pub fn sides(&self) -> impl Iterator<Item = ([i32; 2], [i32; 2])> + '_ {
        let next = self.corners.iter().cycle().skip(1);
        self.corners.iter().copied().zip(next.copied())
    }

    /// The lowest and the highest line.
    pub fn lines(&self) -> [i32; 2] {
        let y = || self.corners.iter().map(|c| c[1]);
        [y().min().unwrap_or(0), y().max().unwrap_or(0)]
    }

    /// The pixels on a line: from the pixel in which the left side crosses it to that of the right side, so at least
    /// one. The document adds slopes truncated to whole numbers line by line; here each crossing is exact.
    pub fn span(&self, y: i32) -> Option<Span> {
        let mut span: Option<Span> = None;
        for (a, b) in self.sides() {
            if y < a[1].min(b[1]) || y > a[1].max(b[1]) {
                continue;
            }
            let (first, last) = if a[1] == b[1] {
                (a[0].min(b[0]), a[0].max(b[0]))
            } else {
                let x = crossing(a, b, 1, y).floor();
                (x, x)
            };
            span = Some(match span {
                Some(s) => Span { y, first: s.first.min(first), last: s.last.max(last) },
                None => Span { y, first, last },
            });
        }
        span
    }
}
