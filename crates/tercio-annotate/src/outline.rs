//! Outlines, and how much of a pixel they cover.
//!
//! The coverage of a pixel is the exact area of the outline in it. It is computed row by row from the edges themselves, never
//! from the row above, so that a band of a picture has the pixels of the whole picture: rasterizers in libraries walk down
//! an outline, and begin elsewhere in a band.

/// The largest distance between a curve and the lines that replace it, in pixels.
const FLATNESS: f64 = 0.02;

/// Closed polygons, in pixels from the upper left corner of the picture. What any of them encloses is inside; those in the
/// opposite direction are holes.
#[derive(Clone, Debug, Default)]
pub struct Outline {
    edges: Vec<[[f64; 2]; 2]>,
    first: [f64; 2],
    last: [f64; 2],
}

impl Outline {
    /// A polygon.
    pub fn polygon(corners: &[[f64; 2]]) -> Self {
        let mut outline = Self::default();
        if let Some((&first, rest)) = corners.split_first() {
            outline.begin(first);
            rest.iter().for_each(|&corner| outline.line(corner));
        }
        outline
    }

    /// A line from one point to another, so many pixels wide.
    pub fn stroke(from: [f64; 2], to: [f64; 2], width: f64) -> Self {
        let [dx, dy] = [to[0] - from[0], to[1] - from[1]];
        let length = (dx * dx + dy * dy).sqrt();
        if !(length > 0.0) {
            return Self::default();
        }
        let [x, y] = [-dy / length * width * 0.5, dx / length * width * 0.5];
        let [[ax, ay], [bx, by]] = [from, to];
        Self::polygon(&[[ax + x, ay + y], [bx + x, by + y], [bx - x, by - y], [ax - x, ay - y]])
    }

    /// Begins another polygon.
    pub fn begin(&mut self, at: [f64; 2]) {
        self.close();
        (self.first, self.last) = (at, at);
    }

    /// A straight edge.
    pub fn line(&mut self, to: [f64; 2]) {
        // Level edges cover nothing.
        if to[1] != self.last[1] {
            self.edges.push([self.last, to]);
        }
        self.last = to;
    }

    /// A quadratic curve.
    pub fn curve(&mut self, control: [f64; 2], to: [f64; 2]) {
        let from = self.last;
        let bend = [0, 1].map(|k| from[k] - 2.0 * control[k] + to[k]);
        let bend = (bend[0] * bend[0] + bend[1] * bend[1]).sqrt();
        let steps = (bend / (4.0 * FLATNESS)).sqrt().ceil().clamp(1.0, 256.0);
        for step in 1..steps as usize {
            let t = step as f64 / steps;
            let s = 1.0 - t;
            self.line([0, 1].map(|k| s * s * from[k] + 2.0 * s * t * control[k] + t * t * to[k]));
        }
        self.line(to);
    }

    fn close(&mut self) {
        if self.first != self.last {
            self.line(self.first);
        }
    }

    /// Both outlines.
    pub fn add(&mut self, mut other: Self) {
        other.close();
        self.close();
        self.edges.append(&mut other.edges);
    }

    /// Left, upper, right and lower border; `None` if it covers nothing.
    pub fn bounds(&self) -> Option<[f64; 4]> {
        let points = self.edges.iter().flatten();
        points.fold(None, |bounds: Option<[f64; 4]>, &[x, y]| {
            let [left, top, right, bottom] = bounds.unwrap_or([x, y, x, y]);
            Some([left.min(x), top.min(y), right.max(x), bottom.max(y)])
        })
    }

    /// The polygons of a closed outline. Level edges are not kept: those that are missing are put back, perhaps together with
    /// others there and back again, which enclose nothing.
    pub fn polygons(&self) -> Vec<Vec<[f64; 2]>> {
        let mut polygons: Vec<Vec<[f64; 2]>> = Vec::new();
        for &[from, to] in &self.edges {
            match polygons.last_mut() {
                Some(polygon) if polygon.last() == Some(&from) => polygon.push(to),
                // A level edge.
                Some(polygon) if polygon.last().is_some_and(|last| last[1] == from[1]) => {
                    polygon.extend([from, to]);
                }
                _ => polygons.push(vec![from, to]),
            }
        }
        for polygon in &mut polygons {
            if polygon.len() > 1 && polygon.first() == polygon.last() {
                polygon.pop();
            }
        }
        polygons
    }

    /// A closed outline that can be drawn.
    pub fn closed(mut self) -> Self {
        self.close();
        self
    }

    /// Appends to `cover` the covered shares of the pixels of a row, and returns the column of the first of them; `None` if the
    /// row has none. `width` is that of the picture.
    pub fn cover(&self, row: u32, width: u32, cover: &mut Vec<f32>) -> Option<usize> {
        let (top, bottom) = (f64::from(row), f64::from(row) + 1.0);
        let limit = f64::from(width);
        // The pieces of the edges in this row: downwards or upwards, from x to x.
        let pieces = || {
            self.edges.iter().filter_map(move |&[from, to]| {
                let (sign, upper, lower) = if from[1] < to[1] { (1.0, from, to) } else { (-1.0, to, from) };
                if upper[1] >= bottom || lower[1] <= top {
                    return None;
                }
                let slope = (lower[0] - upper[0]) / (lower[1] - upper[1]);
                let at = |y: f64| if y == lower[1] { lower[0] } else { upper[0] + (y - upper[1]) * slope };
                let (y0, y1) = (upper[1].max(top), lower[1].min(bottom));
                Some((sign * (y1 - y0), at(y0), at(y1)))
            })
        };
        let ends = pieces().flat_map(|(_, a, b)| [a, b]);
        let (left, right) = ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, r), x| (l.min(x), r.max(x)));
        if !(left < limit && right > 0.0) {
            return None;
        }
        let (left, right) = (left.max(0.0), right.min(limit));
        let first = left.floor() as usize;
        let count = (right.ceil() as usize).min(width as usize) - first;
        // Area to the right of the edges: of each pixel, the difference to the pixel before.
        let mut sums = vec![0.0f64; count + 2];
        for (height, a, b) in pieces() {
            let (a, b) = (a.min(b), a.max(b));
            // What is beside the picture is at its border.
            let inside = [a.clamp(0.0, limit), b.clamp(0.0, limit)];
            let per_column = if b > a { height / (b - a) } else { 0.0 };
            let before = per_column * (b.min(0.0) - a).max(0.0);
            let beyond = per_column * (b - a.max(limit)).max(0.0);
            let start = inside[0] - first as f64;
            if before != 0.0 {
                add_piece(&mut sums, before, start, start);
            }
            let height = height - before - beyond;
            if height != 0.0 {
                add_piece(&mut sums, height, start, inside[1] - first as f64);
            }
        }
        let mut sum = 0.0;
        cover.extend(sums[..count].iter().map(|difference| {
            sum += difference;
            // Where nothing is covered, sums of inexact numbers leave rests.
            let covered = sum.abs();
            if covered < 1e-9 { 0.0 } else { covered.min(1.0) as f32 }
        }));
        Some(first)
    }
}

/// Adds the area to the right of a piece of an edge from column `a` to column `b`, as differences from pixel to pixel.
fn add_piece(sums: &mut [f64], height: f64, a: f64, b: f64) {
    let (first, last) = (a.floor() as usize, b.floor() as usize);
    if first == last {
        let right = height * (1.0 - ((a + b) * 0.5 - first as f64));
        sums[first] += right;
        sums[first + 1] += height - right;
        return;
    }
    // How much of each pixel is to the right of the piece: a triangle, trapezoids, and a pentagon.
    let per_column = height / (b - a);
    let mut before = 0.0;
    for column in first..=last {
        let (from, to) = (a.max(column as f64), b.min(column as f64 + 1.0));
        let middle = (from + to) * 0.5 - column as f64;
        let done = per_column * (from - a);
        let right = done + per_column * (to - from) * (1.0 - middle);
        sums[column] += right - before;
        before = right;
    }
    sums[last + 1] += height - before;
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The coverage of all pixels against points of a fine grid.
    #[test]
    fn coverage_is_the_area() {
        let mut random = 1u64;
        let mut next = || {
            random = random.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (random >> 33) as f64 / (1u64 << 31) as f64
        };
        let (width, height) = (23u32, 17u32);
        for _ in 0..60 {
            let corners: Vec<[f64; 2]> = (0..3).map(|_| [next() * 30.0 - 4.0, next() * 24.0 - 4.0]).collect();
            let outline = Outline::polygon(&corners).closed();
            let edge = |a: [f64; 2], b: [f64; 2], p: [f64; 2]| {
                (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])
            };
            for row in 0..height {
                let mut cover = Vec::new();
                let first = outline.cover(row, width, &mut cover);
                for x in 0..width as usize {
                    const FINE: usize = 24;
                    let inside = (0..FINE * FINE).filter(|i| {
                        let part = |k: usize| (k as f64 + 0.5) / FINE as f64;
                        let p = [x as f64 + part(i % FINE), f64::from(row) + part(i / FINE)];
                        let sides = [0, 1, 2].map(|k| edge(corners[k], corners[(k + 1) % 3], p) > 0.0);
                        sides.iter().all(|s| *s) || sides.iter().all(|s| !*s)
                    });
                    let expected = inside.count() as f64 / (FINE * FINE) as f64;
                    let found = first.and_then(|f| cover.get(x.checked_sub(f)?)).copied().unwrap_or(0.0);
                    assert!(
                        (f64::from(found) - expected).abs() < 0.05,
                        "{corners:?} {x} {row} {found} {expected}"
                    );
                }
            }
        }
    }

    /// Polygons that are taken out and put in again cover the same.
    #[test]
    fn polygons_are_those_that_were_put_in() {
        let mut outline = Outline::polygon(&[[2.0, 1.0], [5.0, 1.0], [5.0, 3.0], [2.0, 3.0]]);
        // Two more that begin and end at the same height, the second one a hole.
        outline.add(Outline::polygon(&[[8.0, 1.0], [12.0, 1.0], [12.0, 4.5], [8.0, 4.5]]));
        outline.add(Outline::polygon(&[[9.0, 4.0], [11.0, 4.0], [11.0, 1.0], [9.0, 1.5]]));
        let outline = outline.closed();
        let mut again = Outline::default();
        outline.polygons().iter().for_each(|corners| again.add(Outline::polygon(corners)));
        let again = again.closed();
        for row in 0..6 {
            let (mut cover, mut cover_again) = (Vec::new(), Vec::new());
            assert_eq!(outline.cover(row, 16, &mut cover), again.cover(row, 16, &mut cover_again));
            assert_eq!(cover, cover_again);
        }
    }

    #[test]
    fn whole_pixels_are_covered_wholly() {
        let outline = Outline::polygon(&[[2.0, 1.0], [5.0, 1.0], [5.0, 3.0], [2.0, 3.0]]).closed();
        let mut cover = Vec::new();
        assert_eq!(outline.cover(1, 8, &mut cover), Some(2));
        assert_eq!(cover, [1.0; 3]);
        assert_eq!(outline.cover(0, 8, &mut Vec::new()), None);
        assert_eq!(outline.cover(3, 8, &mut Vec::new()), None);
    }
}
