//! Equations 2.5 and 2.6 of document 001: the overlap as an integral over the positions of a box or a shape, of which
//! the closed forms are special cases.

use crate::models;
use crate::models::registry::Model;
use crate::units::{Count, Length, Ratio};

/// Maximum number of positions per side in [`placed_shapes`].
const MOST_STEPS: f64 = 4096.0;
/// Maximum number of tiles per side that its shape may meet.
const MOST_TILES: f64 = 4096.0;

/// Equation 2.5: tiles of `width` by `height` that a box of `w` by `h` meets if the position of its centre is not
/// uniformly distributed: `density` divides a tile into rows of equal cells and has the weight of each, with any sum.
/// Exact, since the number of tiles is integrated in closed form over each cell.
///
/// # Errors
/// No cells, rows of different lengths, weights below zero or all of them zero, tiles without area.
pub fn placed_boxes(
    width: Length,
    height: Length,
    w: Length,
    h: Length,
    density: Vec<Vec<f64>>,
) -> Result<Ratio, String> {
    let columns = density.first().map_or(0, Vec::len);
    if let Some(row) = density.iter().find(|row| row.len() != columns || columns == 0) {
        return Err(format!("p: expected rows of {} cells, found one of {}", columns.max(1), row.len()));
    }
    if density.iter().flatten().any(|p| *p < 0.0) {
        return Err("p: expected weights not below zero".into());
    }
    let sum: f64 = density.iter().flatten().sum();
    if !(sum > 0.0) {
        return Err("p: expected a place that is possible, found none".into());
    }
    if width.get() <= 0.0 || height.get() <= 0.0 {
        return Err("W, H: expected tiles with an area".into());
    }
    let across: Vec<_> = (0..columns).map(|cell| tiles_along(width, w, cell, columns)).collect();
    let met = density.iter().enumerate().map(|(y, row)| {
        let down = tiles_along(height, h, y, density.len());
        row.iter().zip(&across).map(|(p, x)| p * x).sum::<f64>() * down
    });
    Ok(Ratio::new(met.sum::<f64>() / sum))
}

/// The mean number of tiles of side `tile` that meet a segment of length `w` on a line, over the positions of its
/// centre in one of `cells` equal parts of a tile.
fn tiles_along(tile: Length, w: Length, cell: usize, cells: usize) -> f64 {
    let tile = tile.get();
    let edge = |k: usize| tile * k as f64 / cells as f64;
    let (from, to, half) = (edge(cell), edge(cell + 1), w.get() / 2.0);
    // The integral of floor(t / tile) from 0 to u.
    let steps = |u: f64| {
        let whole = (u / tile).floor();
        tile * whole * (whole - 1.0) / 2.0 + whole * (u - whole * tile)
    };
    let last = steps(to + half) - steps(from + half);
    let first = steps(to - half) - steps(from - half);
    1.0 + (last - first) / (to - from)
}

/// Equation 2.6 for the shape itself instead of its box: square tiles of side `tile` that a convex polygon meets,
/// counted at `steps` by `steps` positions in a tile. The closed form is [`super::exact_by_box`].
///
/// # Errors
/// No polygon, one that is not convex, no steps or more than 4096, a polygon across more than 4096 tiles.
pub fn placed_shapes(tile: Length, shape: Vec<[f64; 2]>, steps: Count) -> Result<Ratio, String> {
    let side = tile.get();
    if !(1.0..=MOST_STEPS).contains(&steps.get()) {
        return Err(format!("steps: expected a number from 1 to {MOST_STEPS}, found {steps}"));
    }
    if !is_convex(&shape) {
        return Err("shape: expected the corners of a convex polygon in their order".into());
    }
    let (low, high) = extent(shape.iter().map(|v| v[1]));
    if !(side > 0.0 && (high - low) / side <= MOST_TILES) {
        return Err(format!(
            "S: expected tiles of which the shape meets at most {MOST_TILES} in height, found {tile}"
        ));
    }
    let offset = |step: u64| (step as f64 + 0.5) * side / steps.get();
    let steps = steps.get() as u64;
    let mut met = 0.0;
    for dy in (0..steps).map(offset) {
        let (first, last) = (((low + dy) / side).floor(), ((high + dy) / side).floor());
        for row in 0..=(last - first) as u64 {
            let top = (first + row as f64) * side - dy;
            // A convex shape meets all tiles of a row between the ends of its part in that row.
            let Some((left, right)) = slice(&shape, top, top + side) else { continue };
            let tiles = |dx: f64| ((right + dx) / side).floor() - ((left + dx) / side).floor() + 1.0;
            met += (0..steps).map(offset).map(tiles).sum::<f64>();
        }
    }
    Ok(Ratio::new(met / (steps * steps) as f64))
}

/// Whether the corners turn in one direction only, and go round once.
fn is_convex(shape: &[[f64; 2]]) -> bool {
    let n = shape.len();
    let edge = |i: usize| [0, 1].map(|k| shape[(i + 1) % n][k] - shape[i % n][k]);
    let cross = |a: [f64; 2], b: [f64; 2]| a[0] * b[1] - a[1] * b[0];
    let turns: Vec<_> = (0..n).map(|i| cross(edge(i), edge(i + 1))).collect();
    let one_way = turns.iter().all(|t| *t >= 0.0) || turns.iter().all(|t| *t <= 0.0);
    // Stars turn in one direction, too, but change between left and right more than twice.
    let rightwards: Vec<_> = (0..n).map(|i| edge(i)[0]).filter(|dx| *dx != 0.0).map(|dx| dx > 0.0).collect();
    let changes = (0..rightwards.len()).filter(|&i| rightwards[i] != rightwards[(i + 1) % rightwards.len()]);
    n >= 3 && one_way && changes.count() <= 2
}

/// The left and right ends of the part of a convex shape between two heights.
fn slice(shape: &[[f64; 2]], top: f64, bottom: f64) -> Option<(f64, f64)> {
    let edges = shape.iter().zip(shape.iter().cycle().skip(1));
    let ends = edges.filter_map(|(a, b)| {
        let at = |y: f64| if a[1] == b[1] { 0.0 } else { ((y - a[1]) / (b[1] - a[1])).clamp(0.0, 1.0) };
        let inside = a[1].max(b[1]) >= top && a[1].min(b[1]) <= bottom;
        let both = if a[1] == b[1] { [0.0, 1.0] } else { [at(top), at(bottom)] };
        inside.then(|| both.map(|t| a[0] + t * (b[0] - a[0])))
    });
    let (left, right) = extent(ends.flatten());
    (left <= right).then_some((left, right))
}

fn extent(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
}

pub(crate) const MODELS: &[Model] = models! {
    "overlap.2.5", "001 eq 2.5", "tiles W by H that a box w by h meets, with the probability p of its position":
        placed_boxes["W": Length, "H": Length, "w": Length, "h": Length, "p": Vec<Vec<f64>>]
            -> Result<Ratio, String>;
    "overlap.2.6", "001 eq 2.6", "square tiles that a convex polygon meets, counted at steps by steps positions":
        placed_shapes["S": Length, "shape": Vec<[f64; 2]>, "steps": Count = 64.0] -> Result<Ratio, String>;
};

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::{boxes, exact_by_box};
    use super::*;
    use crate::units::Pixels;

    fn lengths<const N: usize>(of: [f64; N]) -> [Length; N] {
        of.map(Length::new)
    }

    proptest! {
        /// With uniform positions the integral is equation 2.1, however finely the tile is divided.
        #[test]
        fn even_places_are_molnar_and_eyles(
            of in prop::array::uniform4(0.5f64..200.0), columns in 1usize..9, rows in 1usize..9,
        ) {
            let [width, height, w, h] = lengths(of);
            let even = placed_boxes(width, height, w, h, vec![vec![0.3; columns]; rows]).unwrap().get();
            prop_assert!((even / boxes(width, height, w, h).get() - 1.0).abs() < 1e-9);
        }

        /// In a single narrow cell the number of tiles is that at the cell's position.
        #[test]
        fn one_place(cell in 0usize..1000, w in 0.1f64..90.0) {
            let mut row = vec![0.0; 1000];
            row[cell] = 2.0;
            let [tile, length, point] = lengths([10.0, w, 0.0]);
            let found = placed_boxes(tile, tile, length, point, vec![row]).unwrap().get();
            let middle = (cell as f64 + 0.5) / 100.0;
            let plainly = ((middle + w / 2.0) / 10.0).floor() - ((middle - w / 2.0) / 10.0).floor() + 1.0;
            // The border of a tile may cross the cell.
            prop_assert!((found - plainly).abs() <= 1.0);
            prop_assert!(found >= 1.0);
        }

        /// For triangles of any size, counting agrees with the closed form.
        #[test]
        fn shapes_are_the_closed_form(c in prop::array::uniform6(-40i32..40)) {
            let shape = [0, 2, 4].map(|i| [f64::from(c[i]), f64::from(c[i + 1])]);
            let [a, b, d] = shape;
            let doubled = (b[0] - a[0]) * (d[1] - a[1]) - (b[1] - a[1]) * (d[0] - a[0]);
            let box_of = |k: usize| extent(shape.iter().map(|v| v[k]));
            let [w, h] = [0, 1].map(|k| Length::new(box_of(k).1 - box_of(k).0));
            let tile = Length::new(8.0);
            let counted = placed_shapes(tile, shape.to_vec(), Count::new(64.0)).unwrap().get();
            let closed = exact_by_box(tile, w, h, Pixels::new(doubled.abs() / 2.0)).unwrap().get();
            prop_assert!((counted / closed - 1.0).abs() < 0.02, "{} {}", counted, closed);
        }
    }

    #[test]
    fn what_is_no_density_and_no_shape_is_refused() {
        let [tile, side] = lengths([8.0, 3.0]);
        let of = |p: Vec<Vec<f64>>| placed_boxes(tile, tile, side, side, p);
        for p in [vec![], vec![vec![]], vec![vec![1.0], vec![]], vec![vec![-1.0, 3.0]], vec![vec![0.0]]] {
            assert!(of(p.clone()).is_err(), "{p:?}");
        }
        let star = [0, 2, 4, 1, 3].map(|k| {
            let angle = std::f64::consts::TAU * f64::from(k) / 5.0;
            [angle.cos(), angle.sin()]
        });
        let dent = vec![[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [3.0, 1.0]];
        for shape in [vec![], vec![[0.0, 0.0], [1.0, 1.0]], dent, star.to_vec()] {
            assert!(placed_shapes(tile, shape.clone(), Count::new(4.0)).is_err(), "{shape:?}");
        }
        let square = vec![[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0]];
        assert!(placed_shapes(tile, square.clone(), Count::new(0.0)).is_err());
        assert!(placed_shapes(Length::new(0.0), square, Count::new(4.0)).is_err());
    }
}
