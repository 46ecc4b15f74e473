//! Where on the screen triangles are: grids of cells, from one as large as the picture to cells of a triangle's size.
//!
//! A triangle is in the cells of one grid, whose cells are about as large as it is, so that the memory does not depend on the sizes
//! of triangles. Long thin ones are in more but smaller cells than their boxes would need.

use glam::{DVec2, DVec3};
use tercio_mesh::loops::prelude::*;

use super::hiders::Hiders;
use crate::data::sort_key;
use crate::strokes::Eye;

/// How far beyond its outline a triangle is in cells, in pixels: above all rounding on the screen.
const BESIDE: f64 = 1e-6;
/// Cells along a long thin triangle, about.
const LENGTH: f64 = 8.0;
/// The smallest cells, in pixels.
const SMALLEST: f64 = 0.5;

/// A triangle in a cell, ordered by cell and then by distance.
type Entry = (u64, u32);

/// The grids.
#[derive(Debug)]
pub struct Grids {
    /// The upper left corner of the first cells.
    corner: DVec2,
    /// From large to small cells.
    levels: Vec<Level>,
    /// The first entry of each cell, and the number of all entries.
    firsts: Vec<u32>,
    /// Triangles by cell, near ones first.
    triangles: Vec<u32>,
}

#[derive(Clone, Debug)]
struct Level {
    size: f64,
    columns: i64,
    rows: i64,
    /// The number of its first cell.
    first: u64,
}

/// A convex polygon on the screen.
struct Polygon {
    corners: Vec<DVec2>,
    low: DVec2,
    high: DVec2,
}

impl Grids {
    /// Puts the triangles into cells. What is more than `margin` pixels beside the picture is left out.
    pub fn new(hiders: &Hiders, margin: f64) -> Self {
        let eye = hiders.eye();
        let size = eye.size() + 2.0 * margin;
        let count = hiders.len().max(1) as f64;
        // About a cell a triangle.
        let smallest = (size.x * size.y / count).sqrt().max(SMALLEST);
        let (mut levels, mut cell) = (Vec::new(), size.max_element().max(SMALLEST));
        let mut first = 0;
        loop {
            let [columns, rows] = [size.x, size.y].map(|length| (length / cell).ceil().max(1.0) as i64);
            levels.push(Level { size: cell, columns, rows, first });
            first += (columns * rows) as u64;
            if cell * 0.5 < smallest {
                break;
            }
            cell *= 0.5;
        }
        let mut grids =
            Self { corner: DVec2::splat(-margin), levels, firsts: Vec::new(), triangles: Vec::new() };
        let mut entries: Vec<Entry> = (0..hiders.len() as u32)
            .into_par_iter()
            .with_min_len(1 << 10)
            .fold(Vec::new, |mut entries, number| {
                grids.add(hiders, number, margin, &mut entries);
                entries
            })
            .reduce(Vec::new, |mut a, mut b| {
                a.append(&mut b);
                a
            });
        entries.par_sort_unstable();
        let mut firsts = vec![0u32; first as usize + 1];
        for &(key, _) in &entries {
            firsts[(key >> 32) as usize + 1] += 1;
        }
        for cell in 1..firsts.len() {
            firsts[cell] += firsts[cell - 1];
        }
        grids.firsts = firsts;
        grids.triangles = entries.into_iter().map(|entry| entry.1).collect();
        grids
    }

    /// Adds the cells of a triangle.
    fn add(&self, hiders: &Hiders, number: u32, margin: f64, entries: &mut Vec<Entry>) {
        let corners = hiders.corners(number);
        let nearest = corners.iter().map(|p| p.z).fold(f64::INFINITY, f64::min);
        let Some(polygon) = polygon(hiders.eye(), corners, margin) else { return };
        let extent = (polygon.high - polygon.low).max_element();
        let level = &self.levels[self.level(extent, polygon.thickness())];
        let near = u64::from(sort_key((nearest as f32).next_down()));
        let place = |p: DVec2| ((p - self.corner) / level.size).floor();
        let (low, high) = (place(polygon.low - BESIDE), place(polygon.high + BESIDE));
        let limit = |c: f64, count: i64| (c.max(0.0) as i64).min(count - 1);
        for row in limit(low.y, level.rows)..=limit(high.y, level.rows) {
            let top = self.corner.y + row as f64 * level.size;
            let Some([left, right]) = polygon.reach(top - BESIDE, top + level.size + BESIDE) else {
                continue;
            };
            let column = |x: f64| limit(((x - self.corner.x) / level.size).floor(), level.columns);
            for column in column(left - BESIDE)..=column(right + BESIDE) {
                let cell = level.first + (row * level.columns + column) as u64;
                entries.push((cell << 32 | near, number));
            }
        }
    }

    /// The level for a triangle of this size.
    fn level(&self, extent: f64, thickness: f64) -> usize {
        let wanted = (extent / LENGTH).max(extent.min(thickness));
        self.levels.iter().rposition(|level| level.size >= wanted).unwrap_or(0)
    }

    /// Calls `visit` with each cell on a way over the screen, grid by grid, beginning with the largest cells: with its triangles,
    /// and where the way enters and leaves it, as shares of its length.
    pub fn along(&self, [from, to]: [DVec2; 2], mut visit: impl FnMut(&[u32], f64, f64)) {
        for level in &self.levels {
            let (a, b) = ((from - self.corner) / level.size, (to - self.corner) / level.size);
            let step = b - a;
            let (mut column, mut row) = (a.x.floor() as i64, a.y.floor() as i64);
            let mut at = 0.0;
            // The way leaves a cell at a line of the grid, whose share is computed anew each time.
            for _ in 0..=2 * (level.columns + level.rows) + 8 {
                let leaves = |step: f64, start: f64, cell: i64| match step {
                    s if s > 0.0 => ((cell + 1) as f64 - start) / s,
                    s if s < 0.0 => (cell as f64 - start) / s,
                    _ => f64::INFINITY,
                };
                let (x, y) = (leaves(step.x, a.x, column), leaves(step.y, a.y, row));
                let next = x.min(y).clamp(at, 1.0);
                let inside = [column.clamp(0, level.columns - 1), row.clamp(0, level.rows - 1)];
                let cell = (level.first + (inside[1] * level.columns + inside[0]) as u64) as usize;
                let range = self.firsts[cell] as usize..self.firsts[cell + 1] as usize;
                if !range.is_empty() {
                    visit(&self.triangles[range], at, next);
                }
                if !(x.min(y) < 1.0) {
                    break;
                }
                if x <= y {
                    column += if step.x > 0.0 { 1 } else { -1 };
                }
                if y <= x {
                    row += if step.y > 0.0 { 1 } else { -1 };
                }
                at = next;
            }
        }
    }
}

impl Polygon {
    fn thickness(&self) -> f64 {
        let (mut area, mut longest) = (0.0, 0.0f64);
        let first = self.corners[0];
        for (k, &corner) in self.corners.iter().enumerate() {
            let next = self.corners[(k + 1) % self.corners.len()];
            area += (corner - first).perp_dot(next - first);
            longest = longest.max(first.distance(corner)).max(corner.distance(next));
        }
        if longest > 0.0 { area.abs() / longest } else { 0.0 }
    }

    /// Its least and its greatest x between two y.
    fn reach(&self, top: f64, bottom: f64) -> Option<[f64; 2]> {
        let (mut left, mut right) = (f64::INFINITY, f64::NEG_INFINITY);
        let mut add = |x: f64| (left, right) = (left.min(x), right.max(x));
        for (k, &a) in self.corners.iter().enumerate() {
            let b = self.corners[(k + 1) % self.corners.len()];
            if (top..=bottom).contains(&a.y) {
                add(a.x);
            }
            for y in [top, bottom] {
                if (a.y < y) != (b.y < y) {
                    add(a.x + (b.x - a.x) * ((y - a.y) / (b.y - a.y)));
                }
            }
        }
        (left <= right).then_some([left, right])
    }
}

/// A triangle on the screen: what of it is in front of the near plane and not beside the picture.
fn polygon(eye: &Eye, corners: [DVec3; 3], margin: f64) -> Option<Polygon> {
    let mut now: Vec<(DVec3, [f64; 5])> = corners.iter().map(|&p| (p, eye.inside(p, margin))).collect();
    for border in 0..5 {
        if now.iter().all(|(_, inside)| inside[border] >= 0.0) {
            continue;
        }
        let mut next = Vec::with_capacity(now.len() + 1);
        for (k, &(p, a)) in now.iter().enumerate() {
            let (q, b) = now[(k + 1) % now.len()];
            if a[border] >= 0.0 {
                next.push((p, a));
            }
            if (a[border] >= 0.0) != (b[border] >= 0.0) {
                let cut = p.lerp(q, a[border] / (a[border] - b[border]));
                let mut inside = eye.inside(cut, margin);
                inside[border] = inside[border].max(0.0);
                next.push((cut, inside));
            }
        }
        now = next;
        if now.is_empty() {
            return None;
        }
    }
    let corners: Vec<DVec2> = now.into_iter().map(|(p, _)| eye.screen(p)).collect();
    let low = corners.iter().copied().reduce(DVec2::min)?;
    let high = corners.iter().copied().reduce(DVec2::max)?;
    (low.is_finite() && high.is_finite()).then_some(Polygon { corners, low, high })
}
