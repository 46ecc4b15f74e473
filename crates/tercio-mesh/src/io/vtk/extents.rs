//! Which pieces of a grid are beside each other.

use std::collections::HashMap;
use std::ops::Range;

/// The first and the last point of a piece of a grid along its axes, in the numbers of the whole grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Extent(pub [[i64; 2]; 3]);

/// Ranges along three axes.
pub type Range3 = [Range<i64>; 3];

impl Extent {
    /// Of six numbers: the first and the last one along each axis.
    pub fn parse(text: &str) -> Option<Self> {
        let numbers: Vec<i64> = text.split_whitespace().filter_map(|n| n.parse().ok()).collect();
        let [x0, x1, y0, y1, z0, z1] = numbers[..] else { return None };
        let extent = Self([[x0, x1], [y0, y1], [z0, z1]]);
        extent.points().map(|_| extent)
    }

    /// Numbers of points along the axes.
    pub fn points(&self) -> Option<[u64; 3]> {
        let along = |[low, high]: [i64; 2]| u64::try_from(high.checked_sub(low)?.checked_add(1)?).ok();
        let [x, y, z] = self.0.map(along);
        Some([x?, y?, z?])
    }

    /// The cells, in numbers that count from the first point of another piece; `None` where they are too far away.
    fn cells_from(&self, other: &Self) -> Option<Range3> {
        let mut cells = [const { 0..0 }; 3];
        for axis in 0..3 {
            let ([low, high], [first, _]) = (self.0[axis], other.0[axis]);
            cells[axis] = low.checked_sub(first)?..high.checked_sub(first)?;
        }
        Some(cells)
    }

    /// Whether both have cells in common along an axis.
    fn overlaps(&self, other: &Self, axis: usize) -> bool {
        let ([a, b], [c, d]) = (self.0[axis], other.0[axis]);
        a < d && c < b
    }
}

/// The pieces of a grid whose cells have volumes, by where they end: to find those that touch another one.
#[derive(Debug, Default)]
pub struct Extents {
    all: Vec<Extent>,
    /// By axis, whether it is the upper end, and the number of the last point there.
    ends: HashMap<(usize, bool, i64), Vec<usize>>,
}

impl FromIterator<Extent> for Extents {
    fn from_iter<I: IntoIterator<Item = Extent>>(extents: I) -> Self {
        let is_solid = |extent: &Extent| extent.0.iter().all(|[low, high]| low < high);
        let all: Vec<Extent> = extents.into_iter().filter(is_solid).collect();
        let mut ends: HashMap<_, Vec<usize>> = HashMap::new();
        for (number, extent) in all.iter().enumerate() {
            for (axis, &[low, high]) in extent.0.iter().enumerate() {
                ends.entry((axis, false, low)).or_default().push(number);
                ends.entry((axis, true, high)).or_default().push(number);
            }
        }
        Self { all, ends }
    }
}

impl Extents {
    /// The cells of pieces that touch this one, in numbers that count from its first cell.
    pub fn beside(&self, piece: &Extent) -> Vec<Range3> {
        let mut beside = Vec::new();
        for (axis, &[low, high]) in piece.0.iter().enumerate() {
            // The upper end of one is the lower end of the other.
            for key in [(axis, true, low), (axis, false, high)] {
                let others = self.ends.get(&key).into_iter().flatten().map(|&number| &self.all[number]);
                let touches = |other: &&Extent| (0..3).all(|k| k == axis || piece.overlaps(other, k));
                beside.extend(others.filter(touches).filter_map(|other| other.cells_from(piece)));
            }
        }
        beside
    }
}
