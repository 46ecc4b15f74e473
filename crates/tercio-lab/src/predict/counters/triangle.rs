//! Which samples a triangle covers, and how near it is there: by definition, not by the renderer's kernels.

use tercio_raster::conventions;
use tercio_raster::view::ScreenVertex;

use crate::workloads::PixelBox;

/// A triangle as the points at which three linear functions are not negative; those on an edge count if it is a left
/// or upper one.
#[derive(Clone, Copy, Debug)]
pub struct Triangle {
    corners: [(i64, i64); 3],
    /// Growth to the right, growth downwards, and 1 where the edge itself is outside.
    edges: [(i64, i64, i64); 3],
    depth: Depth,
    /// Its corners run clockwise on the screen.
    pub clockwise: bool,
    /// Its corners do not stand in one line.
    pub has_area: bool,
    /// Its primitive number, which decides among equal depths.
    pub primitive: u64,
}

/// The depth of a triangle, reckoned from its farthest corner as the conventions say.
#[derive(Clone, Copy, Debug)]
struct Depth {
    anchor: (i64, i64),
    base: f32,
    slope: [f32; 2],
    nearest: f32,
}

/// Sub-pixels a pixel, and from a pixel's corner to its sample.
const PIXEL: i64 = conventions::SUBPIXELS as i64;
const SAMPLE: i64 = conventions::SAMPLE as i64;

impl Triangle {
    /// From corners in the order of the mesh; `None` without area.
    pub fn new(v: [ScreenVertex; 3], primitive: u64) -> Option<Self> {
        Some(Self::of_any_area(v, primitive)).filter(|t| t.has_area)
    }

    /// From corners in the order of the mesh. Without area it covers nothing, though its box may hold samples.
    pub fn of_any_area(v: [ScreenVertex; 3], primitive: u64) -> Self {
        let mut corners = v.map(|v| (i64::from(v.x), i64::from(v.y)));
        let [a, b, c] = corners;
        let area = (b.0 - a.0) * (c.1 - a.1) - (c.0 - a.0) * (b.1 - a.1);
        let depth = Depth::new(v, area);
        if area < 0 {
            corners.swap(1, 2);
        }
        // Clockwise on the screen: the inside lies right of each edge, seen along it.
        let edge = |k: usize| {
            let (from, to) = (corners[k], corners[(k + 1) % 3]);
            let (right, down) = (from.1 - to.1, to.0 - from.0);
            let left_or_top = right > 0 || right == 0 && down > 0;
            (right, down, i64::from(!left_or_top))
        };
        let edges = [edge(0), edge(1), edge(2)];
        Self { corners, edges, depth, clockwise: area > 0, has_area: area != 0, primitive }
    }

    /// Pixels whose samples lie in the bounding box.
    pub fn samples(&self) -> Option<PixelBox> {
        let range = |of: fn(&(i64, i64)) -> i64| {
            let values = self.corners.map(|c| of(&c));
            let (low, high) = (values.into_iter().min()?, values.into_iter().max()?);
            let first = (low - SAMPLE).div_euclid(PIXEL) + i64::from((low - SAMPLE).rem_euclid(PIXEL) > 0);
            Some((i32::try_from(first).ok()?, i32::try_from((high - SAMPLE).div_euclid(PIXEL)).ok()?))
        };
        let ((x0, x1), (y0, y1)) = (range(|c| c.0)?, range(|c| c.1)?);
        PixelBox::new([x0, y0], [x1, y1])
    }

    /// Does it reach so far that edge functions of 32 bits do not serve it?
    pub fn is_wide(&self) -> bool {
        let extent = |of: fn(&(i64, i64)) -> i64| {
            let v = self.corners.map(|c| of(&c));
            v[0].max(v[1]).max(v[2]) - v[0].min(v[1]).min(v[2])
        };
        extent(|c| c.0).max(extent(|c| c.1)) >= i64::from(conventions::SMALL_EXTENT)
    }

    fn inside(&self, edge: usize, x: i32, y: i32) -> bool {
        let ((right, down, outside), from) = (self.edges[edge], self.corners[edge]);
        let (dx, dy) = (i64::from(x) * PIXEL + SAMPLE - from.0, i64::from(y) * PIXEL + SAMPLE - from.1);
        right * dx + down * dy >= outside
    }

    /// Does the sample of a pixel belong to it?
    pub fn covers(&self, x: i32, y: i32) -> bool {
        (0..3).all(|k| self.inside(k, x, y))
    }

    /// False if one edge has every sample of a rectangle on its outer side.
    pub fn may_cover(&self, r: &PixelBox) -> bool {
        (0..3).all(|k| {
            let (right, down, _) = self.edges[k];
            self.inside(k, if right > 0 { r.x1 } else { r.x0 }, if down > 0 { r.y1 } else { r.y0 })
        })
    }

    /// Depth at the sample of a pixel; greater is nearer.
    pub fn depth(&self, x: i32, y: i32) -> f32 {
        let d = &self.depth;
        let dx = (i64::from(x) * PIXEL + SAMPLE - d.anchor.0) as f32;
        let dy = (i64::from(y) * PIXEL + SAMPLE - d.anchor.1) as f32;
        ((dx * d.slope[0] + dy * d.slope[1]) + d.base).max(d.base).min(d.nearest)
    }
}

impl Depth {
    fn new(v: [ScreenVertex; 3], area: i64) -> Self {
        // The first among equals.
        let farthest = [1, 2].into_iter().fold(0, |f, k| if v[k].d < v[f].d { k } else { f });
        let [a, b, c] = [0, 1, 2].map(|k| v[(farthest + k) % 3]);
        let [x1, y1, x2, y2] = [b.x - a.x, b.y - a.y, c.x - a.x, c.y - a.y].map(|d| d as f32);
        let (d1, d2) = (b.d - a.d, c.d - a.d);
        let inverse = 1.0 / area as f32;
        Self {
            anchor: (i64::from(a.x), i64::from(a.y)),
            base: a.d,
            slope: [(d1 * y2 - d2 * y1) * inverse, (d2 * x1 - d1 * x2) * inverse],
            nearest: if b.d > c.d { b.d } else { c.d },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn vertex(x: i32, y: i32, d: f32) -> ScreenVertex {
        ScreenVertex { x, y, d, inside: true }
    }

    #[test]
    fn a_triangle_covers_samples_and_its_left_and_upper_edges() {
        // The right angle and the legs run through samples; 4 pixels long.
        let at = |x: i32, y: i32| (x * 256 + 128, y * 256 + 128);
        let ((x0, y0), (x1, _), (_, y1)) = (at(2, 3), at(6, 3), at(2, 7));
        let v = [vertex(x0, y0, 0.5), vertex(x1, y0, 0.25), vertex(x0, y1, 1.0)];
        let t = Triangle::new(v, 7).unwrap();
        assert!(t.clockwise);
        assert_eq!(t.samples(), PixelBox::new([2, 3], [6, 7]));
        let covered = (0..10).flat_map(|y| (0..10).map(move |x| (x, y))).filter(|&(x, y)| t.covers(x, y));
        // The hypotenuse is a lower edge and does not count.
        assert_eq!(covered.count(), 4 + 3 + 2 + 1);
        assert!(!t.may_cover(&PixelBox::new([5, 6], [8, 8]).unwrap()));
        assert_eq!(t.depth(2, 3), 0.5);
        // Half way between two corners.
        assert_eq!(t.depth(4, 3), 0.375);
        let line = [vertex(0, 0, 1.0), vertex(256, 256, 1.0), vertex(512, 512, 1.0)];
        assert!(Triangle::new(line, 0).is_none());
        let line = Triangle::of_any_area(line, 0);
        assert!((0..2).all(|y| (0..2).all(|x| !line.covers(x, y))));
    }
}
